/* Weather that leads the sea: while the state names a weather field, wind,
 * fetch and swell of the sea are the field's at own ship (without own ship at
 * the scene's origin).
 *
 * At each whole second of simulated time, and after each edit of others, the
 * field is asked; where the surface would move by more than
 * PEL_WEATHER_MOVES_M, root mean square, or the wind by more than
 * PEL_WEATHER_WIND_MPS, a patch brings the sea to it. It is an edit of that
 * moment like any other: a log of commands, the journal and the state have it,
 * and a replay needs nothing of this. What it decides by is the state, the
 * field and the moment, so a restart goes on as if there had been none. Modes
 * keep their phases and frequencies from one sea to the next (steady,
 * ocean/sea.h), so that a step is that small everywhere. Control thread. */
#pragma once

#include "base/err.h"
#include "scene/scene.h"

#define PEL_WEATHER_MOVES_M 5e-4
#define PEL_WEATHER_WIND_MPS 0.02

struct pel_weather_lead;
struct pel_weather_lead *pel_weather_lead_create(struct pel_scene *scene);
/* Before the scene; NULL allowed. */
void pel_weather_lead_destroy(struct pel_weather_lead *lead);

/* Refuses an edit of what a field leads, before and after it: CONFLICT. One
 * that says sea.field.time is the field's own. `from` and `to`: the state
 * before and after. */
PEL_CHECK enum pel_err pel_weather_lead_check(const Pelagos__State *from,
                                              const Pelagos__State *to,
                                              const Pelagos__Patch *patch,
                                              struct pel_fault *fault);
