#include "airpath.h"

#include "airglow.h"

#include <stdbool.h>

#define PI 3.14159265358979323846

enum { PIECES = 24, SIGHT_PIECES = 240, LATTICE = 8, TURNS = 1000 };

/* Below this weight a path goes on by chance. */
#define FAINT 0.1

/* Share of paths that go on from the water, where it is told apart. */
#define OF_WATER 0.2

/* Share of turns that are sought by the light there, and about what light of
 * higher orders is to the Sun's at dusk. */
#define GUIDED 0.65
#define GLOOM 0.005

/* Share of directions that are sought towards the glow over the only Sun. */
#define TO_GLOW 0.5
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
    bool at_first; /* the sight itself has not ended */
    enum air_part part;
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

/* Of a beam, by the ground; by what the sight itself meets. */
static double reflected(const struct walk *walk, struct air_vec back,
                        struct air_vec sun, struct air_vec up)
{
    const struct air_ground *ground = walk->scene->ground;
    const struct air_first *first = walk->sight->first;
    int channel = walk->sight->channel;
    double cosine = fmax(air_dot(up, sun), 0);
    double all = air_ground_reflect(ground, channel, back, sun, up) * cosine;
    return walk->at_first && first
               ? all + first->again[channel] +
                     ground->albedo[channel] / PI *
                         (first->leaves[channel] - 1) * cosine
               : all;
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
            weight * sun * reflected(walk, back, walk->suns[i], up);
    }
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
    struct air_glow sought = { .range = 1 };
    if (glow > 0) {
        sought = air_glow_at(p, walk->suns[0], air->ground);
    }
    if (which < glow) {
        *d = air_glow_turn(&sought, u, v);
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
    density += glow > 0 ? glow * air_glow_density(&sought, *d) : 0;
    return (molecules + point.aerosols * air_phase_aerosols(air, cosine)) /
           density;
}

/* At what the sight itself meets: on from the water, or from the mirror. */
static double bounce_first(struct walk *walk, struct air_vec up,
                           const double u[3], struct air_vec *d)
{
    const struct air_first *first = walk->sight->first;
    int channel = walk->sight->channel, i = 0, end = first->count - 1;
    if (u[2] < OF_WATER) {
        walk->part = AIR_LEFT_WATER;
        *d = air_turned(up, sqrt(u[0]), 2 * PI * u[1]);
        return walk->scene->ground->albedo[channel] * first->leaves[channel] /
               OF_WATER;
    }
    if (end < 0) {
        return 0;
    }
    double wanted = u[0] * first->escapes[end].upto;
    while (i < end) {
        int middle = (i + end) / 2;
        if (first->escapes[middle].upto > wanted) {
            end = middle;
        } else {
            i = middle + 1;
        }
    }
    const struct air_escape *e = &first->escapes[i];
    *d = e->toward;
    return first->drawn * e->weight[channel] / e->weight[1] / (1 - OF_WATER);
}

/* Turns at the ray's end on the ground; the weight that it costs. */
static double bounce(struct walk *walk, struct air_vec p, struct air_vec *d)
{
    double r = sqrt(air_dot(p, p)), weight;
    struct air_vec up = { p.x / r, p.y / r, p.z / r };
    struct air_vec back = { -d->x, -d->y, -d->z };
    double a = number(walk), b = number(walk), c = number(walk);
    if (walk->at_first) {
        walk->part = AIR_MIRRORED;
        if (walk->sight->first) {
            return bounce_first(walk, up, (const double[3]){ a, b, c }, d);
        }
    }
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
    walk->at_first = true;
    walk->part = AIR_TURNED;
    double weight = step(walk, sight, walk->sight->first_order, 1, &p, &d);
    walk->at_first = false;
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
        walk.at_first = true;
        gather_ground(&walk,
                      air_along(ray.from, ray.start[ray.pieces], ray.toward),
                      ray.toward, exp(-ray.depth[ray.pieces]));
    }
}

static void paths_of(struct walk *walk, const struct ray *ray, int paths,
                     uint64_t seed, double part[AIR_PARTS])
{
    sea_random_init(&walk->random, seed);
    /* The plastic number's sequence in eight dimensions (Roberts 2018). */
    double root = 2, shift[LATTICE], pace[LATTICE];
    for (int i = 0; i < 60; i++) {
        root = pow(1 + root, 1.0 / (LATTICE + 1));
    }
    for (int i = 0; i < LATTICE; i++) {
        shift[i] = sea_random_unit(&walk->random);
        pace[i] = pow(root, -(i + 1));
    }
    for (int n = 0; n < paths; n++) {
        for (int i = 0; i < LATTICE; i++) {
            double x = shift[i] + n * pace[i];
            walk->lattice[i] = x - floor(x);
        }
        walk->used = 0;
        double before = walk->light[0];
        follow(walk, ray);
        part[walk->part] += (walk->light[0] - before) / paths;
    }
}

void air_more(const struct air_scene *scene, const struct air_sight *sight,
              int paths, uint64_t seed, double light[AIR_SUNS])
{
    struct walk walk;
    struct ray ray;
    double part[AIR_PARTS] = { 0 };
    begin(&walk, scene, sight, light);
    if (!look(&ray, scene, sight)) {
        return;
    }
    weigh(&ray, &walk);
    paths_of(&walk, &ray, paths, seed, part);
    for (int i = 0; i < sight->suns; i++) {
        light[i] /= paths;
    }
}

void air_parts(const struct air_scene *scene, const struct air_sight *sight,
               int paths, uint64_t seed, double part[AIR_PARTS])
{
    struct walk walk;
    struct ray ray;
    double light[AIR_SUNS];
    begin(&walk, scene, sight, light);
    for (int i = 0; i < AIR_PARTS; i++) {
        part[i] = 0;
    }
    if (look(&ray, scene, sight)) {
        weigh(&ray, &walk);
        paths_of(&walk, &ray, paths, seed, part);
    }
}
