#include "underpath.h"

#include <stdbool.h>

#define PI UNDER_PI

#define SUN_RADIUS 0.0046513

/* Below this weight a path goes on by chance. */
#define FAINT 0.25

/* How narrow the lobe about the Sun is, at how many turns a second path sets
 * out, and from what cosine to the Sun on it need not. */
#define LOBE 0.85
#define PARTED 30
#define ASIDE 0.8

enum { TURNS = 100000, LATTICE = 6, RAYS = 1024 };

struct walk {
    const struct under_scene *scene;
    struct sea_random random;
    struct under_vec beam; /* towards the Sun, below a level surface */
    double beam_flux;      /* normal to it, just below */
    double extinction;
    struct under_vec ray[RAYS]; /* the same below a rough one */
    double flux[RAYS];
    double lattice[LATTICE];
    int used;
    struct under_light light;
};

/* A leg of a path. */
struct leg {
    double depth; /* where it begins */
    struct under_vec toward;
    double length; /* to the surface or the bottom */
    double weight;
};

double under_rate(const struct under_scene *scene)
{
    double a = scene->absorption;
    double b = scene->scattering * (1 - scene->phase->mean_cosine);
    return 0.8 * fmin(sqrt(3 * a * (a + b)), a + b);
}

static double number(struct walk *walk)
{
    return walk->used < LATTICE ? walk->lattice[walk->used++]
                                : sea_random_unit(&walk->random);
}

static bool is_level(const struct under_surface *surface)
{
    return surface->along <= 0;
}

/* Rays of the Sun below a rough surface, for all paths of one mean. */
static void draw_rays(struct walk *walk)
{
    const struct under_scene *scene = walk->scene;
    double zenith = scene->sun_zenith;
    for (int i = 0; i < RAYS; i++) {
        struct under_vec d = { -sin(zenith), 0, -cos(zenith) };
        walk->flux[i] = 0;
        if (under_cross(&scene->surface, &walk->random, UNDER_AIR, &d) ==
            UNDER_WATER) {
            walk->ray[i] = (struct under_vec){ -d.x, -d.y, -d.z };
            walk->flux[i] = scene->irradiance * cos(zenith) / -d.z;
        }
    }
}

static void begin(struct walk *walk, const struct under_scene *scene,
                  uint64_t seed)
{
    *walk = (struct walk){ .scene = scene };
    sea_random_init(&walk->random, seed);
    walk->extinction = scene->absorption + scene->scattering;
    double r, zenith = scene->sun_zenith;
    struct under_vec light = { -sin(zenith), 0, -cos(zenith) };
    struct under_vec below =
        under_refracted(&scene->surface, UNDER_AIR, light, &r);
    walk->beam = (struct under_vec){ -below.x, -below.y, -below.z };
    walk->beam_flux = scene->irradiance * (1 - r) * cos(zenith) / -below.z;
    if (!is_level(&scene->surface) && scene->irradiance > 0) {
        draw_rays(walk);
    }
}

/* A direction from which sunlight comes below the surface, and the irradiance
 * normal to it; false where the surface throws it back. */
static bool draw_sun(struct walk *walk, struct under_vec *sun, double *flux)
{
    if (is_level(&walk->scene->surface)) {
        *sun = walk->beam;
        *flux = walk->beam_flux;
    } else {
        int i = (int)(RAYS * sea_random_unit(&walk->random));
        *sun = walk->ray[i];
        *flux = walk->flux[i];
    }
    return *flux > 0;
}

static double length_of(const struct under_scene *scene, double depth,
                        struct under_vec toward)
{
    if (toward.z > 0) {
        return depth / toward.z;
    }
    return toward.z < 0 ? (scene->bottom - depth) / -toward.z : INFINITY;
}

/* Sunlight turned on a leg, over the phase function's value: scattering times
 * the integral of the transmittances to the surface and along the leg. */
static double turned_sun(const struct walk *walk, const struct leg *leg,
                         struct under_vec sun, double flux)
{
    double c = walk->extinction, rate = c * (1 - leg->toward.z / sun.z);
    double from = exp(-c * leg->depth / sun.z), part;
    if (fabs(rate * leg->length) < 1) {
        part =
            from * (rate * leg->length != 0 ? -expm1(-rate * leg->length) / rate
                                            : leg->length);
    } else if (isinf(leg->length)) {
        part = from / rate;
    } else {
        double end = leg->depth - leg->toward.z * leg->length;
        part = (from - exp(-c * (leg->length + fmax(end, 0) / sun.z))) / rate;
    }
    return walk->scene->scattering * flux * part;
}

/* Sunlight of the bottom at the end of a leg. */
static double bottom_sun(const struct walk *walk, const struct leg *leg,
                         struct under_vec sun, double flux)
{
    const struct under_scene *scene = walk->scene;
    if (leg->toward.z >= 0 || isinf(scene->bottom)) {
        return 0;
    }
    return scene->albedo / PI * flux * sun.z *
           exp(-walk->extinction * (leg->length + scene->bottom / sun.z));
}

/* Radiance of the sky at the upper end of a leg below a level surface. */
static double leg_sky(const struct walk *walk, const struct leg *leg)
{
    const struct under_surface *surface = &walk->scene->surface;
    double r, n = surface->index;
    if (leg->toward.z <= 0 || !is_level(surface)) {
        return 0;
    }
    struct under_vec d = under_refracted(surface, UNDER_WATER, leg->toward, &r);
    return r < 1 ? (1 - r) * n * n * under_sky_at(walk->scene->sky, d) *
                       exp(-walk->extinction * leg->length)
                 : 0;
}

/* What a leg after a turn gathers. It was drawn with the density `density`, of
 * sunlight that is also sought otherwise 0. */
static void gather(struct walk *walk, const struct leg *leg, double density)
{
    struct under_vec sun;
    double flux;
    if (draw_sun(walk, &sun, &flux)) {
        double phase =
            under_phase_at(walk->scene->phase, under_dot(leg->toward, sun));
        double share = density > 0 ? density / (density + phase) : 1;
        walk->light.scattered +=
            leg->weight * (share * phase * turned_sun(walk, leg, sun, flux) +
                           bottom_sun(walk, leg, sun, flux));
    }
}

/* A turn of a path: where, and whether at the matt bottom. */
struct turn {
    struct leg leg;
    bool matt;
    bool parted; /* a second path sets out from here */
};

/* Density of the direction `next` of light that comes to the leg. */
static double density_at(const struct walk *walk, const struct turn *at,
                         struct under_vec next)
{
    if (at->matt) {
        return fmax(next.z, 0) / PI;
    }
    return under_phase_at(walk->scene->phase, under_dot(at->leg.toward, next));
}

/* Henyey and Greenstein's density of directions about the Sun's beam. */
static double lobe_at(const struct walk *walk, const struct turn *at,
                      struct under_vec next)
{
    if (!at->parted) {
        return 0;
    }
    double x = 1 + LOBE * LOBE - 2 * LOBE * under_dot(next, walk->beam);
    return (1 - LOBE * LOBE) / (4 * PI * x * sqrt(x));
}

static struct under_vec lobe_turn(struct walk *walk)
{
    double u = 2 * sea_random_unit(&walk->random) - 1;
    double x = (1 - LOBE * LOBE) / (1 + LOBE * u);
    double cosine = (1 + LOBE * LOBE - x * x) / (2 * LOBE);
    return under_turned(walk->beam, 1 - fmin(cosine, 1),
                        2 * PI * sea_random_unit(&walk->random));
}

/* Another way to draw the leg after a turn: about the Sun, so that light which
 * is turned by little before or after it is found by both (balance heuristic,
 * Veach and Guibas 1995). */
static void seek_sun(struct walk *walk, const struct turn *at)
{
    struct under_vec sun;
    double flux;
    if (!draw_sun(walk, &sun, &flux)) {
        return;
    }
    double less =
        under_phase_turn(walk->scene->phase, sea_random_unit(&walk->random));
    struct leg next = at->leg;
    next.toward =
        under_turned(sun, less, 2 * PI * sea_random_unit(&walk->random));
    double density = density_at(walk, at, next.toward);
    if (density <= 0) {
        return;
    }
    next.length = length_of(walk->scene, next.depth, next.toward);
    double phase = under_phase_at(walk->scene->phase, 1 - less);
    walk->light.scattered +=
        next.weight * density * phase /
        (density + lobe_at(walk, at, next.toward) + phase) *
        turned_sun(walk, &next, sun, flux);
}

/* Moves to the leg's end or to a turn on it, whichever chance takes. True: a
 * turn. */
static bool advance(struct walk *walk, struct leg *leg)
{
    const struct under_scene *scene = walk->scene;
    double c = walk->extinction;
    double drawn = c - scene->sought * leg->toward.z;
    double s = -log(1 - number(walk)) / drawn;
    if (s < leg->length) {
        leg->weight *= scene->scattering / drawn * exp((drawn - c) * s);
        leg->depth -= leg->toward.z * s;
        if (leg->depth < 0) {
            leg->depth = 0;
        }
        return true;
    }
    leg->weight *= exp((drawn - c) * leg->length);
    leg->depth = leg->toward.z > 0 ? 0 : scene->bottom;
    return false;
}

/* Back from the surface into the water; false: the leg goes into the air, where
 * one that comes through a rough surface finds *sky. */
static bool reflect(struct walk *walk, struct leg *leg, double *sky)
{
    const struct under_surface *surface = &walk->scene->surface;
    double n = surface->index;
    *sky = 0;
    if (is_level(surface)) {
        double r = under_fresnel(leg->toward.z, 1 / n);
        leg->toward.z = -leg->toward.z;
        return r >= 1 || sea_random_unit(&walk->random) < r;
    }
    if (under_cross(surface, &walk->random, UNDER_WATER, &leg->toward) ==
        UNDER_WATER) {
        return true;
    }
    *sky = n * n * under_sky_at(walk->scene->sky, leg->toward);
    return false;
}

static struct under_vec turned(struct walk *walk, const struct turn *at)
{
    double u = number(walk), azimuth = 2 * PI * number(walk);
    if (at->matt) {
        double level = sqrt(u);
        return (struct under_vec){ level * cos(azimuth), level * sin(azimuth),
                                   sqrt(1 - u) };
    }
    return under_turned(at->leg.toward, under_phase_turn(walk->scene->phase, u),
                        azimuth);
}

/* The leg after a turn, its weight by the balance of the path and the second
 * one; the density of both. */
static double leave(const struct walk *walk, const struct turn *at,
                    struct under_vec next, struct leg *leg)
{
    double p = density_at(walk, at, next), q = lobe_at(walk, at, next);
    *leg = at->leg;
    leg->toward = next;
    leg->weight *= p > 0 ? p / (p + q) : 0;
    return p + q;
}

/* To the next turn of a path; what its legs gather on the way. False where it
 * ends. */
static bool next_turn(struct walk *walk, struct leg *leg, double density,
                      bool scattered, struct turn *at)
{
    const struct under_scene *scene = walk->scene;
    double *light = scattered ? &walk->light.scattered : &walk->light.window;
    for (int i = 0; i < TURNS; i++) {
        leg->length = length_of(scene, leg->depth, leg->toward);
        gather(walk, leg, density);
        *light += leg->weight * leg_sky(walk, leg);
        density = 0;
        bool turns = advance(walk, leg);
        if (turns || leg->toward.z < 0) {
            *at = (struct turn){ .leg = *leg, .matt = !turns };
            at->leg.weight *= turns ? 1 : scene->albedo;
            return at->leg.weight > 0;
        }
        double sky;
        if (!reflect(walk, leg, &sky)) {
            *light += leg->weight * sky;
            return false;
        }
    }
    return false;
}

/* A path from a leg on. The main one, while it does not look to the Sun anyway,
 * sends a second one that way from each turn: what turns by much and then by
 * little many times is seldom met else. */
static void follow(struct walk *walk, struct leg leg, double density, bool main)
{
    const struct under_scene *scene = walk->scene;
    double start = leg.depth, first = leg.weight;
    struct turn at;
    for (int i = 0; i < TURNS; i++) {
        if (!next_turn(walk, &leg, density, !main || i > 0, &at)) {
            return;
        }
        at.parted = main && i < PARTED &&
                    (at.matt || under_dot(at.leg.toward, walk->beam) < ASIDE);
        seek_sun(walk, &at);
        if (at.parted) {
            struct leg second;
            double d = leave(walk, &at, lobe_turn(walk), &second);
            if (second.weight > 0) {
                follow(walk, second, d, false);
            }
        }
        density = leave(walk, &at, turned(walk, &at), &leg);
        /* What the depth alone makes of the weight is no reason to end. */
        double wanted =
            FAINT * first * exp(scene->sought * (leg.depth - start));
        if (leg.weight < wanted) {
            if (sea_random_unit(&walk->random) * wanted >= leg.weight) {
                return;
            }
            leg.weight = wanted;
        }
    }
}

/* Shift and pace of the plastic number's sequence (Roberts 2018). */
static void lattice(struct walk *walk, double *shift, double *pace)
{
    double root = 2;
    for (int i = 0; i < 60; i++) {
        root = pow(1 + root, 1.0 / (LATTICE + 1));
    }
    for (int i = 0; i < LATTICE; i++) {
        shift[i] = sea_random_unit(&walk->random);
        pace[i] = pow(root, -(i + 1));
    }
}

static void next_path(struct walk *walk, int n, const double *shift,
                      const double *pace)
{
    for (int i = 0; i < LATTICE; i++) {
        double x = shift[i] + n * pace[i];
        walk->lattice[i] = x - floor(x);
    }
    walk->used = 0;
}

struct under_light under_look(const struct under_scene *scene, double depth,
                              struct under_vec toward, int paths, uint64_t seed)
{
    struct walk walk;
    double shift[LATTICE], pace[LATTICE];
    begin(&walk, scene, seed);
    lattice(&walk, shift, pace);
    const struct leg sight = { .depth = depth, .toward = toward, .weight = 1 };
    for (int n = 0; n < paths; n++) {
        next_path(&walk, n, shift, pace);
        follow(&walk, sight, 0, true);
    }
    return (struct under_light){ walk.light.scattered / paths,
                                 walk.light.window / paths };
}

double under_beam(const struct under_scene *scene, double depth, double *cosine)
{
    struct walk walk;
    begin(&walk, scene, 0);
    *cosine = walk.beam.z;
    return walk.beam_flux * exp(-walk.extinction * depth / walk.beam.z);
}

double under_sun(const struct under_scene *scene, double depth,
                 struct under_vec toward)
{
    const struct under_surface *surface = &scene->surface;
    double zenith = scene->sun_zenith, r, n = surface->index;
    struct under_vec sun = { sin(zenith), 0, cos(zenith) };
    if (toward.z <= 0) {
        return 0;
    }
    double through =
        scene->irradiance *
        exp(-(scene->absorption + scene->scattering) * depth / toward.z);
    if (!is_level(surface)) {
        return through * under_glitter(surface, sun, toward);
    }
    struct under_vec d = under_refracted(surface, UNDER_WATER, toward, &r);
    if (r >= 1 || under_dot(d, sun) < cos(SUN_RADIUS)) {
        return 0;
    }
    return through * (1 - r) * n * n / (2 * PI * (1 - cos(SUN_RADIUS)));
}

/* Directions are drawn alike from the sphere and, one of two, about the Sun. */
struct under_field under_field(const struct under_scene *scene, double depth,
                               int paths, uint64_t seed)
{
    struct walk walk;
    double shift[LATTICE], pace[LATTICE], cosine;
    struct under_field field = { .down = under_beam(scene, depth, &cosine) };
    field.down *= cosine;
    begin(&walk, scene, seed);
    lattice(&walk, shift, pace);
    for (int n = 0; n < paths; n++) {
        next_path(&walk, n, shift, pace);
        double u = number(&walk), azimuth = 2 * PI * number(&walk);
        struct under_vec up = { 0, 0, 1 };
        struct under_vec d =
            n % 2 ? under_turned(up, 2 * u, azimuth)
                  : under_turned(walk.beam, under_phase_turn(scene->phase, u),
                                 azimuth);
        double density =
            (1 / (4 * PI) +
             under_phase_at(scene->phase, under_dot(d, walk.beam))) /
            2;
        struct under_light before = walk.light;
        struct leg sight = { .depth = depth, .toward = d, .weight = 1 };
        follow(&walk, sight, 0, true);
        double found = (walk.light.scattered - before.scattered +
                        walk.light.window - before.window) /
                       density / paths;
        if (d.z > 0) {
            field.down += d.z * found;
        } else {
            field.up -= d.z * found;
            field.scalar_up += found;
        }
    }
    return field;
}
