/* What optics/airlight.c and optics/airrays.c share: the solution by successive
 * orders of scattering, each the light along rays from every height of the
 * table in fixed directions. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>

#include "optics/airgeometry.h"
#include "optics/airlight.h"

/* Of the solution: heights and Suns are the table's; directions in each
 * hemisphere, azimuths in half a circle, terms of the phase functions, steps
 * along a ray, the most orders, how much those after the last may be of the
 * light, and the transmittance beyond which a ray ends. */
#define AIR_HALF 10
#define AIR_TURNS 16
#define AIR_STEPS 20
#define AIR_ORDERS 12
#define AIR_REST 0.03
#define AIR_DARK 1e-5
#define DIRECTIONS (2 * AIR_HALF)
#define TERMS AIR_TURNS
#define HEIGHTS PEL_AIR_HEIGHTS
#define SUNS PEL_AIR_SUNS
#define ZENITHS PEL_AIR_ZENITHS
#define AZIMUTHS PEL_AIR_AZIMUTHS
#define LUT 4096 /* places of a Sun's cosine */
#define ROW (SUNS * 4)

/* Light by direction and height of the Sun; the fourth of each is padding. */
typedef float suns[ROW];
typedef suns field[HEIGHTS][DIRECTIONS][AIR_TURNS];
typedef float kernel[TERMS][DIRECTIONS];

/* A step of a ray, the same for all azimuths and Suns. */
struct step {
    int level; /* and `above` of the next */
    float above;
    float along,
        across;      /* the Sun's cosine there is along · cos + across · ν */
    float weight[4]; /* what reaches the start of light scattered here, of the
                        source */
    float rayleigh[4], mie; /* shares of a source scattered once */
    double height;
};

struct ray {
    struct step steps[AIR_STEPS];
    int count; /* of those from which any light comes */
    bool ground;
    float ground_along, ground_across, ground_weight[4], mirror;
};

struct pel_air_solver {
    const struct pel_atmosphere *a;
    struct pel_airlight *out;
    int order;
    atomic_bool failed; /* for want of memory */
    double heights[HEIGHTS], sun_mu[SUNS];
    double mu[DIRECTIONS], weight[DIRECTIONS], phi[AIR_TURNS];
    double scatter[HEIGHTS][3][2]; /* molecules, aerosols: share of both */
    float place[LUT + 1]; /* of a Sun's cosine, in steps of the table */
    float cosine[AIR_TURNS][TERMS]; /* cos mφ */
    kernel rayleigh[DIRECTIONS], mie[DIRECTIONS];
    kernel rayleigh_seen[ZENITHS], mie_seen[ZENITHS];
    double chi[TERMS];
    float level[HEIGHTS][SUNS]; /* log2 of a source's size */
    float scale[HEIGHTS][SUNS]; /* and its reciprocal */
    struct ray rays[HEIGHTS][DIRECTIONS];
    /* Light of the order at work, the source it makes over its size, and the
     * sum of all light so far. */
    field light, source, sum;
    double mean[2][HEIGHTS][ROW],
        total[HEIGHTS][ROW]; /* light of the last two orders */
    float leaving[SUNS][4];  /* light out of the water */
    /* Light of the Sun that the sea mirrors, per unit irradiance normal to it
     * at the sea, as the mean over a direction's share of the sphere. */
    float glitter[AIR_HALF][AIR_TURNS][SUNS];
};

/* Splits x in 0..1 into a cell of n points and the place inside it. */
static inline int pel_air_cell(double x, int n, double *fraction)
{
    double at = pel_clamp(x, 0, 1) * (n - 1);
    int i = (int)at;
    i = i > n - 2 ? n - 2 : i;
    *fraction = at - i;
    return i;
}

/* Means over a step between two heights: scattering of molecules and aerosols,
 * extinction [1/m]. */
void pel_air_between(const struct pel_atmosphere *a, double from, double to,
                     double rayleigh[3], double *mie, double extinction[3]);

/* A ray's steps. */
void pel_air_ray(const struct pel_air_solver *s, double h, double mu,
                 struct ray *ray);

/* The sea's part: glitter; and after the light at sea level, which mirrors
 * nothing, what of the sky's light leaves the water. */
void pel_air_glitter(struct pel_air_solver *s);
void pel_air_leaving(struct pel_air_solver *s);

/* Works for pel_airlight_share over heights and directions: light of the order
 * from the air, then with what the sea sends up, and into the sum. */
void pel_air_light(void *user, int member, int at);
void pel_air_ground(void *user, int member, int at);
