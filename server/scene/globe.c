#include "scene/globe.h"

#include <math.h>

/* How far the sphere is below the eye's horizontal plane. */
static double drop(double flat_m)
{
    double half = sin(0.5 * flat_m / PEL_EARTH_RADIUS);
    return 2 * PEL_EARTH_RADIUS * half * half;
}

struct pel_vec3 pel_globe_at(struct pel_vec3 eye, struct pel_vec3 offset)
{
    double flat = hypot(offset.x, offset.y);
    double stretch = 1 / cos(0.5 * flat / PEL_EARTH_RADIUS);
    return (struct pel_vec3){ eye.x + stretch * offset.x,
                              eye.y + stretch * offset.y,
                              eye.z + offset.z + drop(flat) };
}

struct pel_vec3 pel_globe_offset(struct pel_vec3 eye, struct pel_vec3 at)
{
    double x = at.x - eye.x, y = at.y - eye.y;
    double arc = hypot(x, y), flat = arc;
    /* flat = arc cos(flat / 2R): each round is (arc / 2R)^2 nearer. */
    for (int i = 0; i < 12; i++) {
        flat = arc * cos(0.5 * flat / PEL_EARTH_RADIUS);
    }
    double share = arc > 0 ? flat / arc : 1;
    return (struct pel_vec3){ share * x, share * y, at.z - eye.z - drop(flat) };
}
