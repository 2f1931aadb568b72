#include "models/waterline.h"

#include <math.h>

#define BELOW 0.04 /* of the draught: where the waves do not bare it */

/* The first place of the hull that a ray meets on its way; NAN: none. */
static double met(const struct pel_model *m, struct pel_vec3 from,
                  struct pel_vec3 along, double most_m)
{
    struct pel_model_hit hit;
    return pel_model_cast(m, from, along, most_m, &hit) ? hit.distance_m : NAN;
}

bool pel_model_waterline(const struct pel_model *m,
                         struct pel_model_waterline *out)
{
    double z = -BELOW * m->draught_m;
    double ahead = m->high.x + 1, astern = m->low.x - 1;
    double beside = m->high.y + 1, way = ahead - astern;
    const struct pel_vec3 aft = { -1, 0, 0 }, forward = { 1, 0, 0 };
    const struct pel_vec3 inward = { 0, -1, 0 };
    out->stem_m = ahead - met(m, (struct pel_vec3){ ahead, 0, z }, aft, way);
    out->stern_m =
        astern + met(m, (struct pel_vec3){ astern, 0, z }, forward, way);
    double part = (out->stem_m - out->stern_m) / PEL_WATERLINE_PARTS;
    if (!(part > 0)) {
        return false;
    }
    for (int i = 0; i < PEL_WATERLINE_PARTS; i++) {
        double x = out->stem_m - (i + 0.5) * part;
        double d = met(m, (struct pel_vec3){ x, beside, z }, inward, beside);
        out->half_m[i] = isnan(d) ? 0.0 : beside - d;
    }
    return true;
}
