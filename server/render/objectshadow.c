#include "render/objectshadow.h"

#include <math.h>

#include "models/model.h"
#include "render/uniforms.h"

bool pel_shadow_reaches(const struct pel_environment *env,
                        const struct pel_object *from,
                        const struct pel_object *to)
{
    const struct pel_vec3 sun = env->lights[PEL_LIGHT_FIRST].direction;
    const struct pel_vec3 d = { to->east_m - from->east_m,
                                to->north_m - from->north_m,
                                to->altitude_m - from->altitude_m };
    double both = from->model->radius_m + to->model->radius_m;
    double behind = -pel_vec3_dot(d, sun);
    double aside2 = pel_vec3_dot(d, d) - behind * behind;
    return sun.z > 0 && behind > -both && behind < PEL_FARTHEST_SHADOW_M &&
           aside2 < both * both;
}

static struct pel_vec4 row(struct pel_vec3 v, double scale, double w)
{
    return (struct pel_vec4){ (float)(v.x * scale), (float)(v.y * scale),
                              (float)(v.z * scale), (float)w };
}

void pel_shadow_look(const struct pel_environment *env,
                     const struct pel_object *object, int side,
                     struct pel_vec4 out[3])
{
    const struct pel_vec3 to = env->lights[PEL_LIGHT_FIRST].direction;
    const struct pel_vec3 pole = { fabs(to.x) < 0.9, fabs(to.x) >= 0.9, 0 };
    struct pel_vec3 u = pel_vec3_normalize(pel_vec3_cross(pole, to));
    struct pel_vec3 v = pel_vec3_cross(to, u);
    double half = 0.5 / object->model->radius_m;
    double part = (double)side / PEL_SHADOW_SIZE;
    out[0] = row(u, half * part, 0.5 * part);
    out[1] = row(v, half * part, 0.5 * part);
    out[2] = row(to, -half, 0.5);
}
