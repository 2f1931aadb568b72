/* All orders of scattering in plane-parallel water by discrete ordinates
 * (Chandrasekhar 1950; Stamnes, Tsay, Wiscombe and Jayaweera 1988): azimuth
 * as a Fourier series, one symmetric eigenproblem a mode, the forward peak
 * scaled off (delta-M, Wiscombe 1977), the directions that leave the water and
 * those the surface keeps each with their own Gauss nodes (Jin and Stamnes
 * 1994), single scattering exact (Nakajima and Tanaka 1988).
 *
 * One object, one thread at a time. */
#pragma once

#include "optics/transport.h"

#define PEL_ORDINATES_MAX 32 /* nodes in each of the two ranges */
#define PEL_ORDINATES_REFERENCE 24
#define PEL_ORDINATES_VIEWS 64

struct pel_ordinates;

/* The light that falls on the water. */
struct pel_ordinates_light {
    double sun_zenith_rad;
    double sun; /* irradiance normal to the beam above the surface; 0: none */
    /* Mode m of the sky's radiance above the surface, Σ L_m cos m φ, at the
     * nodes that pel_ordinates_sky_node names; NULL: no sky. */
    const double *sky; /* [modes][nodes] */
    int sky_modes;
};

/* `nodes` in each range, 2..PEL_ORDINATES_MAX; 2 nodes terms of the phase
 * function and as many modes at most. The series in azimuth ends after two
 * modes below `tolerance` of the first. NULL: no memory. */
struct pel_ordinates *pel_ordinates_create(int nodes, double tolerance);
void pel_ordinates_destroy(struct pel_ordinates *o); /* NULL allowed */

/* Nodes for which sky radiance is wanted, and the zenith in air of each. */
int pel_ordinates_sky_nodes(const struct pel_ordinates *o);
double pel_ordinates_sky_node(const struct pel_ordinates *o, int i);

/* Horizontal irradiance of a sky given by its mode 0 at the nodes. */
double pel_ordinates_sky_irradiance(const struct pel_ordinates *o,
                                    const double *mode0);

/* Azimuth modes of the radiance going up just below the surface in `views`
 * directions of zenith cosine view_mu (in the water, above the critical
 * angle's), without single scattering of the Sun: out[mode * views + view],
 * mode < *modes ≤ 2 nodes; modes beyond do not matter. out has room for
 * 2 nodes × views; dark_bottom (NULL allowed) gets mode 0 over a black
 * bottom. views 1..PEL_ORDINATES_VIEWS. */
void pel_ordinates_solve(struct pel_ordinates *o,
                         const struct pel_medium *medium,
                         const struct pel_ordinates_light *light,
                         const double *view_mu, int views, double *out,
                         int *modes, double *dark_bottom);

/* The light at a depth, of a Sun of irradiance 1 normal to its beam above the
 * surface and no sky. */
struct pel_field {
    double down, up; /* irradiance of horizontal planes */
    double scalar_up;
    double nadir; /* radiance straight up, all orders [1/sr] */
};

/* The field at several depths (0: just below the surface), each at most the
 * medium's. */
void pel_ordinates_field(struct pel_ordinates *o,
                         const struct pel_medium *medium, double sun_zenith_rad,
                         const double *depths_m, int count,
                         struct pel_field *out);

/* The response of the water to sunbeams of zenith cosines mu (in the water, of
 * what has come through the surface; irradiance 1 normal to the beam), seen in
 * the same directions, at several depths (medium->depth_m is not read): modes
 * of the radiance going up just below the surface without single scattering,
 * over a black bottom dark[levels][modes][beams][views], and what the bottom
 * adds, which is the same all around, bottom[levels][beams][views]. A depth
 * costs a tenth of the first. beams 1..PEL_ORDINATES_BEAMS. NO_MEMORY. */
#define PEL_ORDINATES_BEAMS 16
PEL_CHECK enum pel_err
pel_ordinates_respond(struct pel_ordinates *o, const struct pel_medium *medium,
                      const double *depths, int levels, const double *mu,
                      int beams, int modes, double *dark, double *bottom);

/* Moments of the light at several depths (0: just below the surface, each at
 * most the medium's) of such beams: 2π ∫ L_m Λ_l^m dμ over all directions, the
 * beam itself included, Λ_l^m = √((l−m)!/(l+m)!) P_l^m, downward positive, by
 * (m, l) = (0, 0), which is the scalar irradiance, (0, 2), (1, 2), (2, 2):
 * out[moment][depth][beam]. What a phase function of two terms, as Raman
 * scattering's, needs of it. beams 1..PEL_ORDINATES_BEAMS. NO_MEMORY. */
#define PEL_MOMENTS 4
#define PEL_MOMENTS_TERMS 3
PEL_CHECK enum pel_err pel_ordinates_moments(struct pel_ordinates *o,
                                             const struct pel_medium *medium,
                                             const double *mu, int beams,
                                             const double *depths, int count,
                                             double *out);

/* Light in the water of sunbeams of zenith cosines mu (as of
 * pel_ordinates_respond), met with at several depths (each at most the
 * medium's) in directions of zenith cosine view_mu > 0 upwards and as many
 * downwards, 1..PEL_ORDINATES_VIEWS. What the water sends alone: the solution
 * of the transfer equation along each line that is 0 where the line enters the
 * water, at the surface or the bottom. Of any line of sight the water between a
 * place and a place s metres farther adds L(here) - e^(-c s) L(there), with
 * the scaled extinction c. Modes Σ_m r_m cos mφ of what was scattered twice and
 * more, many[levels][modes][beams][2][views], and of what was scattered
 * once as the solver has it, once[…] alike; [0]: seen looking up, [1]: looking
 * down. Azimuth 0 looks towards the Sun. Irradiance of level planes, the
 * unscattered beam left out, flux[levels][beams][2] from above and from below.
 * NO_MEMORY. */
PEL_CHECK enum pel_err
pel_ordinates_inside(struct pel_ordinates *o, const struct pel_medium *medium,
                     const double *mu, int beams, const double *depths,
                     int levels, const double *view_mu, int views, int modes,
                     double *many, double *once, double *flux);

/* The scaled extinction of a medium [1/m]: the forward peak that the solver
 * takes as not scattered left out. */
double pel_ordinates_extinction(struct pel_ordinates *o,
                                const struct pel_medium *medium);

/* Single scattering of the Sun with the true phase function and the scaled
 * extinction, below the surface: what pel_ordinates_solve leaves out. */
double pel_ordinates_single(struct pel_ordinates *o,
                            const struct pel_medium *medium, double beam,
                            double sun_mu, double view_mu, double scatter_nu);
