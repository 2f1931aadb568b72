/* Where the Sun's shadows of objects fall. Any thread. */
#pragma once

#include "render/renderer.h"
#include "scene/snapshot.h"

/* Longer shadows are cut, m. */
#define PEL_FARTHEST_SHADOW_M 2000.0

/* Whether the shadow of one may reach another, by spheres about their origins
 * along the beam; false while the Sun is down. */
bool pel_shadow_reaches(const struct pel_environment *env,
                        const struct pel_object *from,
                        const struct pel_object *to);

/* Rows that take a point from the object's origin into its shadow's texture, of
 * which `side` texels are used, and depth: along the beam of the Sun. */
void pel_shadow_look(const struct pel_environment *env,
                     const struct pel_object *object, int side,
                     struct pel_vec4 out[3]);
