#include "render/spacegeometry.h"

#include "optics/atmosphere.h"

#define SEMI_MAJOR 6378137.0 /* WGS 84 */
#define FLATTENING (1.0 / 298.257223563)

static double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}

/* Of x to the east, y to the north, z up at a latitude of longitude 0. */
static struct pel_mat3 earth_of(double latitude, double longitude,
                                double convergence)
{
    double sf = sin(latitude), cf = cos(latitude);
    double sl = sin(longitude), cl = cos(longitude);
    double sc = sin(convergence), cc = cos(convergence);
    const struct pel_vec3 east = { -sl, cl, 0 },
                          north = { -sf * cl, -sf * sl, cf };
    return (struct pel_mat3){
        .x = pel_vec3_add(pel_vec3_scale(east, cc), pel_vec3_scale(north, sc)),
        .y = pel_vec3_add(pel_vec3_scale(east, -sc), pel_vec3_scale(north, cc)),
        .z = { cf * cl, cf * sl, sf },
    };
}

static struct pel_vec3 scaled(const struct pel_space_geometry *g,
                              struct pel_vec3 v)
{
    double across = PEL_EARTH_RADIUS / g->semi_major_m,
           along = PEL_EARTH_RADIUS / g->semi_minor_m;
    return (struct pel_vec3){ v.x * across, v.y * across, v.z * along };
}

static struct pel_vec3 in_axes(struct pel_vec3 x, struct pel_vec3 y,
                               struct pel_vec3 z, struct pel_vec3 v)
{
    return (struct pel_vec3){ pel_vec3_dot(x, v), pel_vec3_dot(y, v),
                              pel_vec3_dot(z, v) };
}

/* The eye in Earth's axes. */
static struct pel_vec3 eye_of(const struct pel_space_geometry *g,
                              double height_m)
{
    double a2 = g->semi_major_m * g->semi_major_m,
           b2 = g->semi_minor_m * g->semi_minor_m;
    const struct pel_vec3 n = g->earth.z;
    double over = 1.0 / sqrt(a2 * (n.x * n.x + n.y * n.y) + b2 * n.z * n.z);
    return (struct pel_vec3){ n.x * (a2 * over + height_m),
                              n.y * (a2 * over + height_m),
                              n.z * (b2 * over + height_m) };
}

struct pel_space_geometry pel_space_geometry_of(double height_m,
                                                double latitude_rad,
                                                double longitude_rad,
                                                double convergence_rad)
{
    double whole = pel_clamp((height_m - PEL_SPACE_LEAST_M) /
                                 (PEL_SPACE_WHOLE_M - PEL_SPACE_LEAST_M),
                             0.0, 1.0);
    struct pel_space_geometry g = {
        .whole = whole,
        .earth = earth_of(latitude_rad, longitude_rad, convergence_rad),
        .semi_major_m = mix(PEL_EARTH_RADIUS, SEMI_MAJOR, whole),
        .semi_minor_m =
            mix(PEL_EARTH_RADIUS, SEMI_MAJOR * (1.0 - FLATTENING), whole),
    };
    struct pel_vec3 eye = scaled(&g, eye_of(&g, height_m));
    double r = sqrt(pel_vec3_dot(eye, eye));
    g.height_m = r - PEL_EARTH_RADIUS;
    const struct pel_vec3 z = pel_vec3_scale(eye, 1.0 / r);
    struct pel_vec3 x = scaled(&g, g.earth.x);
    x = pel_vec3_normalize(
        pel_vec3_add(x, pel_vec3_scale(z, -pel_vec3_dot(x, z))));
    const struct pel_vec3 y = pel_vec3_cross(z, x);
    g.from = (struct pel_mat3){
        .x = in_axes(x, y, z, scaled(&g, g.earth.x)),
        .y = in_axes(x, y, z, scaled(&g, g.earth.y)),
        .z = in_axes(x, y, z, scaled(&g, g.earth.z)),
    };
    return g;
}

bool pel_space_meets(const struct pel_space_geometry *g, struct pel_vec3 dir,
                     double *distance_m, struct pel_vec3 *normal)
{
    const struct pel_vec3 d = pel_mat3_apply(&g->from, dir);
    double length = sqrt(pel_vec3_dot(d, d));
    double h = g->height_m, r = PEL_EARTH_RADIUS + h, mu = d.z / length;
    double c = h * (PEL_EARTH_RADIUS + r), disc = r * r * mu * mu - c;
    if (mu >= 0.0 || disc < 0.0) {
        return false;
    }
    double t = c / (-r * mu + sqrt(disc));
    const struct pel_vec3 p = { t * d.x / length, t * d.y / length,
                                r + t * mu };
    *distance_m = t / length;
    *normal = pel_vec3_normalize(in_axes(g->from.x, g->from.y, g->from.z, p));
    return true;
}

double pel_space_reach(const struct pel_space_geometry *g)
{
    return acos(PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + g->height_m));
}
