#include "scene/objectray.h"

#include <math.h>

#include "models/model.h"
#include "scene/globe.h"

/* World to model: the inverse of a rotation. */
static struct pel_vec3 into(const struct pel_mat3 *m, struct pel_vec3 v)
{
    return (struct pel_vec3){ pel_vec3_dot(m->x, v), pel_vec3_dot(m->y, v),
                              pel_vec3_dot(m->z, v) };
}

static bool cast_one(const struct pel_object *o, struct pel_vec3 from,
                     struct pel_vec3 along, double least_m, double most_m,
                     struct pel_object_hit *out)
{
    const struct pel_vec3 at = { o->east_m, o->north_m, o->altitude_m };
    struct pel_vec3 to = pel_globe_offset(from, at);
    double nearest_m = pel_vec3_dot(to, along);
    double passes_m2 = pel_vec3_dot(to, to) - nearest_m * nearest_m;
    double radius_m = o->model->radius_m;
    if (passes_m2 > radius_m * radius_m || nearest_m + radius_m < least_m ||
        nearest_m - radius_m > most_m) {
        return false;
    }
    /* From just before the sphere: no digits are lost to distance. */
    double begin_m = fmax(least_m, nearest_m - radius_m);
    struct pel_vec3 begin =
        pel_vec3_add(pel_vec3_scale(along, begin_m), pel_vec3_scale(to, -1));
    struct pel_model_hit hit;
    if (!pel_model_cast(o->model, into(&o->world_from_model, begin),
                        into(&o->world_from_model, along), most_m - begin_m,
                        &hit)) {
        return false;
    }
    *out = (struct pel_object_hit){
        .id = o->id,
        .range_m = begin_m + hit.distance_m,
        .normal = pel_mat3_apply(&o->world_from_model, hit.normal),
    };
    return true;
}

bool pel_objects_cast(const struct pel_object *objects, size_t count, long but,
                      struct pel_vec3 from, struct pel_vec3 along,
                      double least_m, double most_m, struct pel_object_hit *out)
{
    bool met = false;
    for (size_t i = 0; i < count; i++) {
        if ((long)objects[i].id != but &&
            cast_one(&objects[i], from, along, least_m, most_m, out)) {
            met = true;
            most_m = out->range_m;
        }
    }
    return met;
}
