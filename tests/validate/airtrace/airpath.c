#include "airpath.h"

#include <stdbool.h>

#define PI 3.14159265358979323846

enum { PIECES = 24, SIGHT_PIECES = 240, LATTICE = 8, TURNS = 1000 };

/* Below this weight a path goes on by chance. */
#define FAINT 0.1

/* Share of turns that are sought by the light there, and about what light of
 * higher orders is to the Sun's at dusk. */
#define GUIDED 0.65
#define GLOOM 0.005

/* Share of directions that are sought towards the glow over the only Sun, and
 * how that is drawn: by Cauchy's density in elevation about the middle between
 * level and the ground's edge, rad, and wrapped round the horizon. */
#define TO_GLOW 0.5
#define GLOW_WIDE 0.1
#define GLOW_ROUND 0.5
#define GLOW_WAY 40.0

/* A ray in pieces: how far each begins and how deep it lies, and the chance to
 * turn before its end. */
struct ray {
    struct air_vec from, toward;
    int pieces;
    bool ends_on_ground;
    double start[SIGHT_PIECES + 1], depth[SIGHT_PIECES + 1];
    double chance[SIGHT_PIECES + 1];
};

struct walk {
    const struct air_scene *scene;
    const struct air_sight *sight;
    struct air_vec suns[AIR_SUNS];
    double to_glow;
    struct sea_random random;
    double lattice[LATTICE];
    int used;
    double *light;
};

static double height_at(const struct ray *ray, const struct air *air, double t)
{
    struct air_vec p = air_along(ray->from, t, ray->toward);
    return sqrt(air_dot(p, p)) - air->ground;
}

/* Optical depth from a to b by two Gauss nodes. */
static double depth_between(const struct air *air, int channel,
                            const struct ray *ray, double a, double b)
{
    double middle = (a + b) / 2, away = (b - a) * 0.28867513459481287;
    return (b - a) / 2 *
           (air_at(air, channel, height_at(ray, air, middle - away))
                .extinction +
            air_at(air, channel, height_at(ray, air, middle + away))
                .extinction);
}

/* Pieces from `low` to `high`, short where the ray is low. */
static int divide(double *start, int at, double from, double low, double high,
                  int pieces)
{
    for (int i = 0; i <= pieces; i++) {
        double u = low < high ? (double)i / pieces : 1 - (double)i / pieces;
        double end = low < high ? high : from;
        start[at + i] = low + (end - low) * u * u;
    }
    return at + pieces;
}

/* Cuts the ray at its end on the ground or at the top, and sums up the optical
 * depth; false where it does not touch the air. */
static bool cut(struct ray *ray, const struct air *air, int channel, int pieces)
{
    double s = air_dot(ray->from, ray->toward);
    double nearest2 = air_dot(ray->from, ray->from) - s * s;
    double top2 = air->top * air->top - nearest2;
    double ground2 = air->ground * air->ground - nearest2;
    if (top2 <= 0) {
        return false;
    }
    double far = sqrt(top2) - s;
    ray->ends_on_ground = s < 0 && ground2 > 0;
    if (ray->ends_on_ground) {
        double end = fmax(-sqrt(ground2) - s, 0);
        for (int i = 0; i <= pieces; i++) {
            double u = 1 - (double)i / pieces;
            ray->start[i] = end * (1 - u * u);
        }
        ray->pieces = pieces;
    } else if (s >= 0) {
        ray->pieces = divide(ray->start, 0, 0, 0, far, pieces);
    } else {
        for (int i = 0; i <= pieces; i++) {
            double u = 1 - (double)i / pieces;
            ray->start[i] = -s * (1 - u * u);
        }
        ray->pieces = divide(ray->start, pieces, 0, -s, far, pieces);
    }
    ray->depth[0] = 0;
    for (int i = 0; i < ray->pieces; i++) {
        ray->depth[i + 1] =
            ray->depth[i] +
            depth_between(air, channel, ray, ray->start[i], ray->start[i + 1]);
    }
    return true;
}

/* How much the only Sun shines in the middle of a piece. */
static double lit(const struct walk *walk, const struct ray *ray, int i)
{
    double t = (ray->start[i] + ray->start[i + 1]) / 2;
    struct air_vec p = air_along(ray->from, t, ray->toward);
    double r = sqrt(air_dot(p, p));
    struct air_sun_place place =
        air_sun_place(walk->scene->sun, walk->sight->channel, r);
    return air_sun_seen(&place, air_dot(p, walk->suns[0]) / r);
}

/* Chances to turn in each piece, 1 together: as dense as extinction has it,
 * and half of them where the Sun shines. */
static void weigh(struct ray *ray, const struct walk *walk)
{
    double share[SIGHT_PIECES], guide[SIGHT_PIECES], all = 0, shine = 0;
    for (int i = 0; i < ray->pieces; i++) {
        share[i] =
            exp(-ray->depth[i]) * -expm1(ray->depth[i] - ray->depth[i + 1]);
        all += share[i];
        guide[i] =
            walk->sight->guided ? share[i] * (lit(walk, ray, i) + GLOOM) : 0;
        shine += guide[i];
    }
    ray->chance[0] = 0;
    for (int i = 0; i < ray->pieces; i++) {
        double p = share[i] / all;
        p = shine > 0 ? p + GUIDED * (guide[i] / shine - p) : p;
        ray->chance[i + 1] = ray->chance[i] + p;
    }
}

/* Where the ray turns, for a number in [0, 1): the distance; `*weight` is what
 * the transmittance is over the density of such a turn. */
static double turn(const struct ray *ray, const struct air *air, int channel,
                   double u, double *weight)
{
    u *= ray->chance[ray->pieces];
    int i = 0, end = ray->pieces - 1;
    while (i < end) {
        int middle = (i + end) / 2;
        if (ray->chance[middle + 1] > u) {
            end = middle;
        } else {
            i = middle + 1;
        }
    }
    double wide = ray->start[i + 1] - ray->start[i];
    double depth = ray->depth[i + 1] - ray->depth[i];
    double chance = ray->chance[i + 1] - ray->chance[i];
    double v = chance > 0 ? (u - ray->chance[i]) / chance : 0.5;
    v = v > 1 ? 1 : v;
    double t, density;
    if (depth > 1e-6) {
        double x = -log1p(v * expm1(-depth));
        t = ray->start[i] + wide * x / depth;
        density = chance * depth / wide * exp(-x) / -expm1(-depth);
    } else {
        t = ray->start[i] + wide * v;
        density = chance / wide;
    }
    depth = ray->depth[i] + depth_between(air, channel, ray, ray->start[i], t);
    *weight = exp(-depth) / density;
    return t;
}

static double number(struct walk *walk)
{
    return walk->used < LATTICE ? walk->lattice[walk->used++]
                                : sea_random_unit(&walk->random);
}

/* Light of the Suns that air at p turns into -d. */
static void gather_air(struct walk *walk, struct air_vec p, struct air_vec d,
                       struct air_point point, double weight)
{
    const struct air_scene *scene = walk->scene;
    double r = sqrt(air_dot(p, p));
    struct air_sun_place place =
        air_sun_place(scene->sun, walk->sight->channel, r);
    for (int i = 0; i < walk->sight->suns; i++) {
        double sun = air_sun_seen(&place, air_dot(p, walk->suns[i]) / r);
        if (sun > 0) {
            double cosine = air_dot(d, walk->suns[i]);
            walk->light[i] +=
                weight * sun *
                (point.molecules * air_phase_molecules(scene->air, cosine) +
                 point.aerosols * air_phase_aerosols(scene->air, cosine));
        }
    }
}

static void gather_ground(struct walk *walk, struct air_vec p, struct air_vec d,
                          double weight)
{
    const struct air_scene *scene = walk->scene;
    double r = sqrt(air_dot(p, p));
    struct air_vec up = { p.x / r, p.y / r, p.z / r };
    struct air_vec back = { -d.x, -d.y, -d.z };
    struct air_sun_place place =
        air_sun_place(scene->sun, walk->sight->channel, scene->air->ground);
    for (int i = 0; i < walk->sight->suns; i++) {
        double cosine = air_dot(up, walk->suns[i]);
        double sun = air_sun_seen(&place, cosine);
        walk->light[i] +=
            weight * sun * fmax(cosine, 0) *
            air_ground_reflect(scene->ground, walk->sight->channel, back,
                               walk->suns[i], up);
    }
}

/* The glow of dusk as seen from a place. */
struct glow {
    struct air_vec up, toward, beside;
    double middle, low, range; /* of the elevation, and of what is drawn */
};

static struct glow glow_at(struct air_vec p, struct air_vec sun, double ground)
{
    struct glow g;
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

static struct air_vec glow_turn(const struct glow *g, double u, double v)
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
static double glow_density(const struct glow *g, struct air_vec d)
{
    double z = air_dot(d, g->up);
    double level = sqrt(fmax(1 - z * z, 1e-12));
    double away = (asin(z > 1 ? 1 : z < -1 ? -1 : z) - g->middle) / GLOW_WIDE;
    double round = air_dot(d, g->toward) / level;
    return (1 - GLOW_ROUND * GLOW_ROUND) /
           (2 * PI * (1 + GLOW_ROUND * GLOW_ROUND - 2 * GLOW_ROUND * round)) /
           (g->range * GLOW_WIDE * (1 + away * away) * level);
}

/* The next direction by molecules, aerosols or towards the glow, and the
 * weight it costs. */
static double scatter(struct walk *walk, struct air_vec p,
                      struct air_point point, struct air_vec *d)
{
    const struct air *air = walk->scene->air;
    double both = point.molecules + point.aerosols;
    double glow = walk->to_glow * exp(-GLOW_WAY * point.aerosols);
    double which = number(walk), u = number(walk), v = number(walk);
    struct air_vec from = *d;
    struct glow sought = { .range = 1 };
    if (glow > 0) {
        sought = glow_at(p, walk->suns[0], air->ground);
    }
    if (which < glow) {
        *d = glow_turn(&sought, u, v);
    } else if ((which - glow) * both < (1 - glow) * point.molecules) {
        *d = air_turned(from, air_turn_molecules(air, u), 2 * PI * v);
    } else {
        double density;
        *d = air_turned(from, air_turn_aerosols(air, u, &density), 2 * PI * v);
    }
    double cosine = air_dot(from, *d);
    double molecules = point.molecules * air_phase_molecules(air, cosine);
    double density =
        (1 - glow) *
        (molecules + point.aerosols * air_aerosols_density(air, cosine)) / both;
    density += glow > 0 ? glow * glow_density(&sought, *d) : 0;
    return (molecules + point.aerosols * air_phase_aerosols(air, cosine)) /
           density;
}

/* Turns at the ray's end on the ground; the weight that it costs. */
static double bounce(struct walk *walk, struct air_vec p, struct air_vec *d)
{
    double r = sqrt(air_dot(p, p)), weight;
    struct air_vec up = { p.x / r, p.y / r, p.z / r };
    struct air_vec back = { -d->x, -d->y, -d->z };
    double a = number(walk), b = number(walk), c = number(walk);
    *d = air_ground_sample(walk->scene->ground, walk->sight->channel, back, up,
                           (const double[3]){ a, b, c }, &weight);
    return weight;
}

/* One turn of a path: moves it on, and takes what the Suns bring there. The
 * weight that is left, 0 at the end. */
static double step(struct walk *walk, const struct ray *ray, bool gathers,
                   double weight, struct air_vec *p, struct air_vec *d)
{
    const struct air *air = walk->scene->air;
    int channel = walk->sight->channel;
    double clear = exp(-ray->depth[ray->pieces]), u = number(walk);
    if (ray->ends_on_ground) {
        if (u < clear) {
            *p = air_along(ray->from, ray->start[ray->pieces], ray->toward);
            if (gathers) {
                gather_ground(walk, *p, *d, weight);
            }
            return weight * bounce(walk, *p, d);
        }
        u = (u - clear) / (1 - clear);
        weight /= 1 - clear;
    }
    double factor, t = turn(ray, air, channel, u, &factor);
    weight *= factor;
    *p = air_along(ray->from, t, ray->toward);
    struct air_point point =
        air_at(air, channel, sqrt(air_dot(*p, *p)) - air->ground);
    if (gathers) {
        gather_air(walk, *p, *d, point, weight);
    }
    return weight * scatter(walk, *p, point, d);
}

static void follow(struct walk *walk, const struct ray *sight)
{
    struct ray ray;
    struct air_vec p = sight->from, d = sight->toward;
    double weight = step(walk, sight, walk->sight->first_order, 1, &p, &d);
    for (int turns = 1; turns < TURNS && weight > 0; turns++) {
        if (weight < FAINT) {
            if (sea_random_unit(&walk->random) * FAINT >= weight) {
                return;
            }
            weight = FAINT;
        }
        ray.from = p;
        ray.toward = d;
        if (!cut(&ray, walk->scene->air, walk->sight->channel, PIECES)) {
            return;
        }
        weigh(&ray, walk);
        weight = step(walk, &ray, true, weight, &p, &d);
    }
}

static void begin(struct walk *walk, const struct air_scene *scene,
                  const struct air_sight *sight, double *light)
{
    *walk = (struct walk){ .scene = scene, .sight = sight, .light = light };
    walk->to_glow = sight->guided ? TO_GLOW : 0;
    for (int i = 0; i < sight->suns; i++) {
        light[i] = 0;
        walk->suns[i] =
            (struct air_vec){ sin(sight->zenith[i]), 0, cos(sight->zenith[i]) };
    }
}

static bool look(struct ray *ray, const struct air_scene *scene,
                 const struct air_sight *sight)
{
    ray->from = (struct air_vec){ 0, 0, scene->air->ground + sight->height };
    ray->toward = sight->toward;
    /* Two legs of a ray that dips share the pieces. */
    return cut(ray, scene->air, sight->channel, SIGHT_PIECES / 2);
}

void air_once(const struct air_scene *scene, const struct air_sight *sight,
              double light[AIR_SUNS])
{
    static const double node[3] = { 0.1127016653792583, 0.5,
                                    0.8872983346207417 };
    static const double share[3] = { 5.0 / 18, 8.0 / 18, 5.0 / 18 };
    struct walk walk;
    struct ray ray;
    begin(&walk, scene, sight, light);
    if (!look(&ray, scene, sight)) {
        return;
    }
    for (int i = 0; i < ray.pieces; i++) {
        double wide = ray.start[i + 1] - ray.start[i];
        for (int k = 0; k < 3; k++) {
            double t = ray.start[i] + wide * node[k];
            double depth =
                ray.depth[i] + depth_between(scene->air, sight->channel, &ray,
                                             ray.start[i], t);
            struct air_vec p = air_along(ray.from, t, ray.toward);
            struct air_point point =
                air_exact(scene->air, sight->channel,
                          sqrt(air_dot(p, p)) - scene->air->ground);
            gather_air(&walk, p, ray.toward, point,
                       exp(-depth) * wide * share[k]);
        }
    }
    if (ray.ends_on_ground) {
        gather_ground(&walk,
                      air_along(ray.from, ray.start[ray.pieces], ray.toward),
                      ray.toward, exp(-ray.depth[ray.pieces]));
    }
}

void air_more(const struct air_scene *scene, const struct air_sight *sight,
              int paths, uint64_t seed, double light[AIR_SUNS])
{
    struct walk walk;
    struct ray ray;
    begin(&walk, scene, sight, light);
    if (!look(&ray, scene, sight)) {
        return;
    }
    weigh(&ray, &walk);
    sea_random_init(&walk.random, seed);
    /* The plastic number's sequence in eight dimensions (Roberts 2018). */
    double root = 2, shift[LATTICE], pace[LATTICE];
    for (int i = 0; i < 60; i++) {
        root = pow(1 + root, 1.0 / (LATTICE + 1));
    }
    for (int i = 0; i < LATTICE; i++) {
        shift[i] = sea_random_unit(&walk.random);
        pace[i] = pow(root, -(i + 1));
    }
    for (int n = 0; n < paths; n++) {
        for (int i = 0; i < LATTICE; i++) {
            double x = shift[i] + n * pace[i];
            walk.lattice[i] = x - floor(x);
        }
        walk.used = 0;
        follow(&walk, &ray);
    }
    for (int i = 0; i < sight->suns; i++) {
        light[i] /= paths;
    }
}
