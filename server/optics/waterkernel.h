/* What plane-parallel water answers to a beam of light from any height, for
 * any line of sight: radiance leaving as a Fourier series in azimuth, at nodes
 * between which polynomials in the sines are exact to 1e-5. The Sun is one
 * such beam and the sky is made of them, so that neither's moving needs more
 * than sums over this (shaders/water_map.comp). Any thread. */
#pragma once

#include "base/err.h"
#include "optics/brdf.h"
#include "optics/watertable.h"
#include "shaders/lib/blocks.h"

#define PEL_KERNEL_NODES PEL_WATER_NODES /* of beams, and of sights */
#define PEL_KERNEL_MODES PEL_WATER_MODES

enum pel_kernel_part {
    PEL_KERNEL_SINGLE = PEL_PART_SINGLE, /* scattered once */
    PEL_KERNEL_SECOND =
        PEL_PART_SECOND, /* twice: pel_kernel_second, or its maps on the GPU */
    PEL_KERNEL_BEYOND =
        PEL_PART_HIGHER, /* every order but the first, over a black bottom */
    PEL_KERNEL_BOTTOM = PEL_PART_BOTTOM, /* reflected by the bottom, and
                          scattered or mirrored by the surface as well */
    PEL_KERNEL_STRAIGHT =
        PEL_PART_STRAIGHT, /* reflected by the bottom only: I eq. 9 */
    PEL_KERNEL_PARTS,
};

/* One depth. Radiance just above the surface, before the surface's own
 * Fresnel factor on the way out (the radiance below over n²) [1/sr], for a
 * unit of irradiance normal to the refracted beam: Σ_m r[m] cos mφ, φ the
 * azimuth of the line of sight from the beam's. [part][mode][beam][view], by
 * wavelength and 0. */
struct pel_water_kernel {
    float response[PEL_KERNEL_PARTS][PEL_KERNEL_MODES][PEL_KERNEL_NODES]
                  [PEL_KERNEL_NODES][4];
};

/* 1/n²: what the kernel's radiances have over those below the surface. */
#define PEL_KERNEL_LEAVING (1.0 / (PEL_WATER_INDEX * PEL_WATER_INDEX))

/* Sine, in the water, of the zenith angle of node i: Chebyshev's extremes on
 * 0 .. 1/n. */
double pel_kernel_sine(int i);

/* Weights by which the values at the nodes make that at a sine (0 .. 1/n). */
void pel_kernel_weights(double sine, double weights[PEL_KERNEL_NODES]);

/* Fills `single`, `beyond`, `bottom` and `straight` at every depth; `beyond`
 * and `bottom` are 0 but with PEL_ORDERS_ALL; `second` stays 0. About 10 ms,
 * and 1.5 ms for each depth after the first. NO_MEMORY. */
PEL_CHECK enum pel_err pel_water_kernel_build(
    const struct pel_water_body *body, const struct pel_water_depths *depths,
    enum pel_water_orders orders, struct pel_water_kernel *out);

/* How the second order is sampled (I section 5.2): horizontal planes, at
 * Gauss nodes of what the way in and out lets through; zenith angles of the
 * directions in each hemisphere, at Gauss nodes of their cosine; azimuths in
 * half a circle. n_z is `planes`, n_d 4 · zeniths · azimuths. */
struct pel_water_sampling {
    int planes;   /* 1..PEL_SAMPLING_PLANES_MAX; 0: closed form */
    int zeniths;  /* 2..PEL_SAMPLING_ZENITHS_MAX */
    int azimuths; /* 2..PEL_SAMPLING_AZIMUTHS_MAX */
};
#define PEL_SAMPLING_PLANES_MAX 32
#define PEL_SAMPLING_ZENITHS_MAX 64
#define PEL_SAMPLING_AZIMUTHS_MAX 128

/* What the maps are made with, from `make validate-water`'s study. */
#define PEL_SAMPLING_PLANES PEL_WATER_PLANES
#define PEL_SAMPLING_ZENITHS PEL_WATER_ZENITHS
#define PEL_SAMPLING_AZIMUTHS PEL_WATER_AZIMUTHS
extern const struct pel_water_sampling pel_water_sampling_default;

/* Depth of plane k of a water [m], and the weight of its scattering map. */
double pel_sampling_plane(const struct pel_medium *medium, int planes, int k,
                          double *weight);

/* Second order, I eq. 6–8 with full extinction, as `out`[mode][beam][view] in
 * the kernel's units: twin of shaders/water_phase.comp, water_radiance.comp,
 * water_scatter.comp. */
void pel_kernel_second(
    const struct pel_medium *medium, const struct pel_water_sampling *sampling,
    double out[PEL_KERNEL_MODES][PEL_KERNEL_NODES][PEL_KERNEL_NODES]);
