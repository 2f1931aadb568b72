#include "airglow.h"

#define PI 3.14159265358979323846

/* Cauchy's density in elevation about the middle between level and the ground's
 * edge, rad, and wrapped round the horizon. */
#define GLOW_WIDE 0.1
#define GLOW_ROUND 0.5

struct air_glow air_glow_at(struct air_vec p, struct air_vec sun, double ground)
{
    struct air_glow g;
    double r = sqrt(air_dot(p, p));
    g.up = (struct air_vec){ p.x / r, p.y / r, p.z / r };
    struct air_vec t = air_along(sun, -air_dot(sun, g.up), g.up);
    double level = sqrt(air_dot(t, t));
    g.toward = (struct air_vec){ t.x / level, t.y / level, t.z / level };
    g.beside = (struct air_vec){ g.up.y * g.toward.z - g.up.z * g.toward.y,
                                 g.up.z * g.toward.x - g.up.x * g.toward.z,
                                 g.up.x * g.toward.y - g.up.y * g.toward.x };
    g.middle = -0.5 * acos(fmin(ground / r, 1));
    g.low = atan((-PI / 2 - g.middle) / GLOW_WIDE);
    g.range = atan((PI / 2 - g.middle) / GLOW_WIDE) - g.low;
    return g;
}

struct air_vec air_glow_turn(const struct air_glow *g, double u, double v)
{
    double e = g->middle + GLOW_WIDE * tan(g->low + u * g->range);
    double a =
        2 * atan((1 - GLOW_ROUND) / (1 + GLOW_ROUND) * tan(PI * (v - 0.5)));
    double level = cos(e), x = level * cos(a), y = level * sin(a), z = sin(e);
    return (struct air_vec){
        x * g->toward.x + y * g->beside.x + z * g->up.x,
        x * g->toward.y + y * g->beside.y + z * g->up.y,
        x * g->toward.z + y * g->beside.z + z * g->up.z,
    };
}

/* 1/sr */
double air_glow_density(const struct air_glow *g, struct air_vec d)
{
    double z = air_dot(d, g->up);
    double level = sqrt(fmax(1 - z * z, 1e-12));
    double away = (asin(z > 1 ? 1 : z < -1 ? -1 : z) - g->middle) / GLOW_WIDE;
    double round = air_dot(d, g->toward) / level;
    return (1 - GLOW_ROUND * GLOW_ROUND) /
           (2 * PI * (1 + GLOW_ROUND * GLOW_ROUND - 2 * GLOW_ROUND * round)) /
           (g->range * GLOW_WIDE * (1 + away * away) * level);
}
