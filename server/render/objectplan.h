/* What a picture may show of objects, and where (pel_objects_plan). Pure
 * computation. */
#pragma once

#include "render/objects.h"

/* A level of detail's surface may be so many pixels from the model's; so a
 * change of level changes a picture by less than a move by as much
 * (level_test).
 */
#define PEL_OBJECT_LEVEL_PX 0.5

/* Of the object from the eye's nadir and above the sea's zero. */
struct pel_vec3 pel_object_origin(const struct pel_environment *env,
                                  const struct pel_object *object,
                                  const struct pel_camera *camera);

/* So far below the mean sea a mirrored view shows the hull: in troughs its
 * facets see it. */
double pel_object_mirrored_below(const struct pel_environment *env);
