/* Tests of a whole state, after an edit and before it becomes the scene. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* Every value in its range of the schema and finite, enums known, names well
 * formed, keys unique, lists within their limits, views on entities that
 * exist, frusta whole. On refusal *fault (NULL allowed) names path, value, unit
 * and range. Absent fields are passed over: fill the state first. */
PEL_CHECK enum pel_err pel_state_check(const Pelagos__State *state,
                                       struct pel_fault *fault);

/* Corners of Area.corners into PEL_AREA_CORNERS places; their number, 0 for
 * an empty text, −1 where it is none that the schema allows. */
struct pel_vec2;
int pel_corners_parse(const char *text, struct pel_vec2 *out);

/* Replaces sky.metar, sea.beaufort or sea.douglas of a tested state by what
 * they mean; CONFLICT where both of the latter are given, INVALID:
 * pel_metar_parse. */
PEL_CHECK enum pel_err pel_sea_settle(Pelagos__State *state,
                                      struct pel_fault *fault);
