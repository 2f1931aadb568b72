#include "optics/watermontecarlo.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/vec.h"
#include "optics/brdf.h"

/* Shares of directions that are not drawn from the phase function about the
 * path's own: first, and later; the narrower the function the more. */
#define FIRST_ANY (w->medium->back > 0.0 ? 0.4 : 0.25)
#define LATER_ANY (w->medium->back > 0.0 ? 0.3 : 0.1)

enum order {
    SINGLE,
    SECOND,
    HIGHER,
    BOTTOM_DIRECT,
    BOTTOM_SCATTERED,
    TOTAL,
    ORDERS,
};

struct beam {
    struct pel_vec3 direction; /* of the light, downward */
    double mu, irradiance;     /* normal to the refracted beam */
    double along;              /* component of its direction */
};

struct tally {
    double sum[ORDERS], square[ORDERS];
};

struct walk {
    const struct pel_medium *medium;
    const struct pel_phase_table *phase;
    const struct pel_section *bed;
    struct pel_vec3 axis; /* the bed's direction */
    const struct beam *beams;
    int beam_count;
    double extinction;
    uint64_t key, step;        /* random numbers of this path */
    struct pel_vec3 direction; /* of the path, against the light */
    double along, z;           /* place along the bed; depth */
    double weight;             /* importance */
    int scatters, bottoms, reflections;
    double sky;
    double found[PEL_MONTECARLO_SUNS][ORDERS];
};

static uint64_t mix(uint64_t x)
{
    /* The finaliser of Steele, Lea and Flood's SplitMix (2014). */
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9u;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* In (0, 1). */
static double uniform(struct walk *w)
{
    uint64_t bits = mix(w->key + ++w->step * 0x9e3779b97f4a7c15u);
    return ((double)(bits >> 11) + 0.5) * 0x1p-53;
}

static enum order order_of(const struct walk *w)
{
    if (w->bottoms) {
        return w->bottoms == 1 && w->scatters == 0 ? BOTTOM_DIRECT
                                                   : BOTTOM_SCATTERED;
    }
    if (w->scatters == 1) {
        return SINGLE;
    }
    return w->scatters == 2 && w->reflections == 0 ? SECOND : HIGHER;
}

static bool shaded(const struct walk *w, const struct beam *b)
{
    struct pel_section_hit hit;
    return w->bed->knots > 1 &&
           pel_section_meet(w->bed, w->along, w->z, -b->along, b->mu, &hit);
}

/* Sunlight met here: `phase` times the beam, attenuated on its way down; on a
 * bottom of this normal, or (NULL) in the water. */
static void look_at_suns(struct walk *w, const struct pel_section_hit *bottom)
{
    enum order order = order_of(w);
    for (int i = 0; i < w->beam_count; i++) {
        const struct beam *b = &w->beams[i];
        double onto =
            bottom ? b->mu * bottom->up - b->along * bottom->along : 1.0;
        if (onto <= 0.0 || shaded(w, b)) {
            continue;
        }
        double into =
            bottom ? onto / PEL_PI
                   : pel_phase_look_up(
                         w->phase, -pel_vec3_dot(b->direction, w->direction));
        double light = w->weight * into * b->irradiance *
                       exp(-w->extinction * w->z / b->mu);
        w->found[i][order] += light;
        w->found[i][TOTAL] += light;
    }
}

/* A direction of cosine nu about `axis`, at random around it. */
static struct pel_vec3 deflect(struct walk *w, struct pel_vec3 axis, double nu)
{
    double azimuth = 2.0 * PEL_PI * uniform(w);
    double sine = sqrt(fmax(1.0 - nu * nu, 0.0));
    struct pel_vec3 other = fabs(axis.z) < 0.9
                                ? (struct pel_vec3){ 0.0, 0.0, 1.0 }
                                : (struct pel_vec3){ 1.0, 0.0, 0.0 };
    struct pel_vec3 x = pel_vec3_normalize(pel_vec3_cross(other, axis));
    struct pel_vec3 y = pel_vec3_cross(axis, x);
    return pel_vec3_normalize(
        pel_vec3_add(pel_vec3_scale(axis, nu),
                     pel_vec3_add(pel_vec3_scale(x, sine * cos(azimuth)),
                                  pel_vec3_scale(y, sine * sin(azimuth)))));
}

/* Directions by the phase function alone seldom turn back and
 * seldom point at a Sun, and those few carry all the light. So some are taken
 * from anywhere and some about a Sun, and weighed by the density of all. */
static void change_direction(struct walk *w)
{
    double any = w->scatters <= 2 ? FIRST_ANY : LATER_ANY, choice = uniform(w);
    struct pel_vec3 axis = w->direction;
    double u = uniform(w), nu = pel_phase_draw(w->phase, u);
    if (choice < 0.5 * any) {
        nu = 1.0 - 2.0 * u;
    } else if (choice < any) {
        int k = (int)(uniform(w) * w->beam_count);
        axis = pel_vec3_scale(w->beams[k].direction, -1.0);
    }
    struct pel_vec3 to = deflect(w, axis, nu);
    double suns = 0.0;
    for (int i = 0; i < w->beam_count; i++) {
        suns += pel_phase_density(w->phase,
                                  -pel_vec3_dot(w->beams[i].direction, to));
    }
    nu = pel_vec3_dot(w->direction, to);
    w->weight *= pel_phase_look_up(w->phase, nu) /
                 ((1.0 - any) * pel_phase_density(w->phase, nu) +
                  0.5 * any * (1.0 / (4.0 * PEL_PI) + suns / w->beam_count));
    w->direction = to;
}

static void collide(struct walk *w)
{
    w->scatters++;
    w->weight *= w->medium->scattering / w->extinction;
    look_at_suns(w, NULL);
    change_direction(w);
}

static double along_bed(const struct walk *w)
{
    return pel_vec3_dot(w->direction, w->axis);
}

static void advance(struct walk *w, double length)
{
    w->along += length * along_bed(w);
    w->z -= length * w->direction.z;
}

static void meet_bottom(struct walk *w, const struct pel_section_hit *hit)
{
    advance(w, hit->length);
    w->bottoms++;
    w->weight *= w->medium->albedo;
    look_at_suns(w, hit);
    struct pel_vec3 normal = pel_vec3_scale(w->axis, hit->along);
    normal.z = hit->up;
    /* Light that then is turned by the peak of the phase function is found by
     * directions about a Sun, else a few paths would carry most of it. */
    const double about = 0.25;
    bool any = uniform(w) < about;
    if (any) {
        int k = (int)(uniform(w) * w->beam_count);
        w->direction = deflect(w, pel_vec3_scale(w->beams[k].direction, -1.0),
                               pel_phase_draw(w->phase, uniform(w)));
    } else {
        w->direction = deflect(w, normal, sqrt(uniform(w)));
    }
    double suns = 0.0;
    for (int i = 0; i < w->beam_count; i++) {
        suns += pel_phase_density(
            w->phase, -pel_vec3_dot(w->beams[i].direction, w->direction));
    }
    double into = fmax(pel_vec3_dot(normal, w->direction), 0.0) / PEL_PI;
    w->weight *= into / ((1.0 - about) * into + about * suns / w->beam_count);
}

static void meet_surface(struct walk *w)
{
    double sine = PEL_WATER_INDEX *
                  sqrt(fmax(1.0 - w->direction.z * w->direction.z, 0.0));
    double reflected = sine >= 1.0 ? 1.0
                                   : pel_fresnel_exact(sqrt(1.0 - sine * sine),
                                                       PEL_WATER_INDEX);
    /* Skylight comes in where the path goes out; L = 1/π for E = 1. */
    w->sky += w->weight * (1.0 - reflected) * PEL_WATER_INDEX *
              PEL_WATER_INDEX / PEL_PI;
    w->weight *= reflected;
    w->reflections++;
    w->z = 0.0;
    w->direction.z = -w->direction.z;
}

/* The first flight meets water or bottom by choice, so that shallow water is
 * not all bottom. */
static void first_flight(struct walk *w)
{
    struct pel_section_hit hit = { 0 };
    /* It goes down, and the bottom is everywhere. */
    (void)pel_section_meet(w->bed, w->along, w->z, along_bed(w), w->direction.z,
                           &hit);
    double through = exp(-w->extinction * hit.length);
    double chance =
        w->medium->albedo > 0.0 ? pel_clamp(through, 0.1, 0.6) : 0.0;
    if (uniform(w) < chance) {
        w->weight *= through / chance;
        meet_bottom(w, &hit);
        return;
    }
    w->weight *= (1.0 - through) / (1.0 - chance);
    advance(w, -log1p(-uniform(w) * (1.0 - through)) / w->extinction);
    collide(w);
}

static void fly(struct walk *w)
{
    struct pel_section_hit hit;
    double length = -log(uniform(w)) / w->extinction;
    bool met = pel_section_meet(w->bed, w->along, w->z, along_bed(w),
                                w->direction.z, &hit);
    if (met && hit.length <= length) {
        meet_bottom(w, &hit);
    } else if (w->z - length * w->direction.z <= 0.0) {
        advance(w, w->z / w->direction.z);
        meet_surface(w);
    } else {
        advance(w, length);
        collide(w);
    }
}

static void follow(struct walk *w)
{
    first_flight(w);
    while (w->weight > 0.0) {
        if (w->weight < 0.05) {
            if (uniform(w) > 0.25) {
                return;
            }
            w->weight *= 4.0;
        }
        fly(w);
    }
}

static struct pel_estimate estimate(double sum, double square, uint64_t paths,
                                    double scale)
{
    double n = (double)paths, mean = sum / n;
    double variance = fmax(square / n - mean * mean, 0.0);
    return (struct pel_estimate){
        scale * mean,
        scale * sqrt(variance / fmax(n - 1.0, 1.0)),
    };
}

void pel_montecarlo_leaving(const struct pel_medium *medium,
                            const struct pel_section *bed,
                            double view_zenith_rad,
                            const struct pel_montecarlo_sun *suns, int count,
                            uint64_t paths, uint64_t seed,
                            struct pel_montecarlo_result *out,
                            struct pel_estimate *sky)
{
    struct beam beams[PEL_MONTECARLO_SUNS];
    struct tally tallies[PEL_MONTECARLO_SUNS] = { 0 };
    struct pel_interface face = { 0 };
    double sky_sum = 0.0, sky_square = 0.0;
    const struct pel_section level = pel_section_level(medium->depth_m);
    bed = bed ? bed : &level;
    struct pel_phase phase = pel_medium_phase(medium);
    struct pel_phase_table table;
    pel_phase_tabulate(&phase, &table);
    const struct pel_vec3 axis = { -cos(bed->azimuth_rad),
                                   -sin(bed->azimuth_rad), 0.0 };
    for (int i = 0; i < count; i++) {
        struct pel_geometry at = { suns[i].zenith_rad, view_zenith_rad, 0.0 };
        face = pel_interface_at(&at);
        double sine = sqrt(1.0 - face.sun_mu * face.sun_mu);
        /* The view is in the plane of x; a Sun apart by an azimuth. */
        beams[i] = (struct beam){
            { sine * cos(suns[i].azimuth_rad), -sine * sin(suns[i].azimuth_rad),
              -face.sun_mu },
            face.sun_mu,
            face.beam,
            0.0,
        };
        beams[i].along = pel_vec3_dot(beams[i].direction, axis);
    }
    double sine = sqrt(1.0 - face.view_mu * face.view_mu);
    for (uint64_t path = 0; path < paths; path++) {
        struct walk w = {
            .medium = medium,
            .phase = &table,
            .bed = bed,
            .axis = axis,
            .beams = beams,
            .beam_count = count,
            .extinction = medium->absorption + medium->scattering,
            .key = mix(mix(seed) + path),
            .direction = { -sine, 0.0, -face.view_mu },
            .weight = 1.0,
        };
        follow(&w);
        for (int i = 0; i < count; i++) {
            for (int k = 0; k < ORDERS; k++) {
                tallies[i].sum[k] += w.found[i][k];
                tallies[i].square[k] += w.found[i][k] * w.found[i][k];
            }
        }
        sky_sum += w.sky;
        sky_square += w.sky * w.sky;
    }
    for (int i = 0; i < count; i++) {
        struct pel_estimate all[ORDERS];
        for (int k = 0; k < ORDERS; k++) {
            all[k] = estimate(tallies[i].sum[k], tallies[i].square[k], paths,
                              face.leaving);
        }
        out[i] = (struct pel_montecarlo_result){
            all[SINGLE],        all[SECOND],           all[HIGHER],
            all[BOTTOM_DIRECT], all[BOTTOM_SCATTERED], all[TOTAL],
        };
    }
    if (sky) {
        *sky = estimate(sky_sum, sky_square, paths, face.leaving);
    }
}
