/* The sea as cascades of inverse FFTs (Tessendorf 2001): one periodic grid of
 * modes for each of PEL_CASCADES disjoint bands of |k|, drawn from the same
 * directional spectrum as the trochoids. Immutable once built, so every thread
 * may read it; a function of (description, simulated time).
 *
 * This header is the contract between the CPU (cascade.c, the reference) and
 * the shaders: both must read the same function of (place, time).
 *
 * Modes. Mode (i, j) of a cascade, stored at j · PEL_CASCADE_N + i, has
 * m = i < N/2 ? i : i − N, n likewise of j, and the wave vector
 *     k = 2π / length · (m · u + n · v)     [rad/m, east and north]
 * with u = (turn_cos, turn_sin), v = (−turn_sin, turn_cos): the grids lie at
 * different angles, so that their repetitions share no axis. At time t
 *     φ = 2π · fract(frequency · t)          [in double precision]
 *     h̃ = h0 e^{−iφ} + h0m e^{+iφ}
 * where h0 = (h0[0], h0[1]) is the amplitude at k and h0m = (h0[2], h0[3])
 * the conjugate of that at −k. `frequency` is single precision by definition,
 * so both sides agree at any time.
 *
 * Fields, each Σ over modes of f̃ e^{+2πi (m i' + n j') / N} (no 1/N²), real:
 *     height h: h̃                displacement D = (Dx, Dy): i c k/|k| h̃
 *     slopes ∂h/∂x, ∂h/∂y: i k h̃
 *     ∂Dx/∂x, ∂Dy/∂y, ∂Dx/∂y = ∂Dy/∂x: −c (kx², ky², kx ky)/|k| h̃
 * in world axes (east, north), with c = `chop` of the mode: a point that rests
 * at X is carried to (X + D, h), as in Bruneton et al. 2010, eq. 2.
 *
 * Sampling. Texel (i', j') stands at texture coordinates
 * ((i' + ½)/N, (j' + ½)/N); the place (x, y) is at
 *     (X u.x + Y u.y, X v.x + Y v.y) / length      [repeated]
 * where (X, Y) is (x, y) sheared (shear.h), back and forth over some two
 * tiles, for its own tile and for every larger one: one tile on, the water is
 * not the same. Waves bend by some degrees by that, as in a current (the
 * longest by two or less), and keep their variance within 1 %, and their times.
 * Slopes are by (x, y): those by (X, Y) times ∂(X, Y)/∂(x, y). The derivatives
 * of D in normals are left as they are read, which turns normals by 0.2° or
 * less. Displacement (Dx, Dy, h) is sampled by a uniform cubic B-spline (four
 * bilinear taps), slopes and the derivatives of D by bilinear interpolation.
 * Interpolation weakens waves of few texels; so the modes of a field are
 * multiplied by gain[i] · gain[j], which is 1 over the interpolation's root
 * mean square gain: displacement_gain for (Dx, Dy, h), slope_gain for the five
 * others. The variance of each interpolated field is then the spectrum's.
 *
 * Height over a place, normal and velocity are those of the rest position X
 * with X + ΣD(X) = place; the normal is that of the tangents
 * (1 + ∂Dx/∂x, ∂Dx/∂y, ∂h/∂x) and (∂Dx/∂y, 1 + ∂Dy/∂y, ∂h/∂y). */
#pragma once

#include "base/err.h"
#include "ocean/filter.h"
#include "ocean/shear.h"

#define PEL_CASCADE_MODES (PEL_CASCADE_N * PEL_CASCADE_N)

/* Highest mode number of a cascade: its shortest wave has N/88 = 2.9 texels. */
#define PEL_CASCADE_HIGHEST 88

/* Steps of the table of kept slope variance: levels of detail 0 to 8 (one
 * texel for the whole tile), PEL_CASCADE_LOD_STEPS of them a level. */
#define PEL_CASCADE_LOD_STEPS 4
#define PEL_CASCADE_SECTORS 16
#define PEL_CASCADE_LODS ((PEL_CASCADE_LEVELS - 1) * PEL_CASCADE_LOD_STEPS + 1)

struct pel_evolve_modes; /* evolve.h */

struct pel_cascade {
    double length_m;
    double turn_cos, turn_sin;
    double k_lo, k_hi; /* band of |k|, rad/m: waves in [k_lo, k_hi) */
    double m0;         /* variance of height in the band, m² */
    double texel_m;    /* length_m / N */

    /* N · N each, ready for upload: RGBA32F h0(k), conj h0(−k) [m];
     * RG32F frequency [turns/s, ≥ 0] and chop [0..1]. Modes outside the band
     * are zero. */
    float (*h0)[4];
    float (*mode)[2];
    struct pel_evolve_modes *modes; /* the same for evolve.h */

    /* Variance of the slope texture (level 0 is N · N, each next one the mean
     * of 2 × 2) as sampled bilinearly, or trilinearly between levels, at
     * level i / PEL_CASCADE_LOD_STEPS, by the direction of the waves: sector s
     * is that of (s + ½) π / PEL_CASCADE_SECTORS from the wind, either way.
     * kept[…][0] is the band's whole. */
    struct pel_slopes kept[PEL_CASCADE_SECTORS][PEL_CASCADE_LODS];
};

/* What the modes of |k| ≥ a bound carry. */
struct pel_cascade_beyond {
    double m0;
    struct pel_slopes slopes; /* and what lies below the last band */
};
#define PEL_CASCADE_BOUNDS 513

struct pel_fields_cache; /* fields.h */

struct pel_cascades {
    struct pel_cascade cascade[PEL_CASCADES]; /* longest waves first */
    struct pel_shears shears;
    float displacement_gain[PEL_CASCADE_N]; /* by index, along one axis */
    float slope_gain[PEL_CASCADE_N];
    double m0;               /* of all bands, m² */
    struct pel_slopes total; /* of the spectrum, also below the last band */
    /* Bound i is log_k0 + step · i in ln k, the last one the shortest wave. */
    struct pel_cascade_beyond beyond[PEL_CASCADE_BOUNDS];
    double log_k0, step;
    struct pel_fields_cache *cache; /* of queries */
};

/* Draws the cascades from the spectrum of `desc`, whose synthesiser need not
 * be PEL_SYNTHESISER_FFT. OUT_OF_RANGE as pel_sea_build; NO_MEMORY. About
 * 6.5 MB. The energy of a mode is the integral of the spectrum over its cell
 * of the wave-vector plane and its cascade's band. */
PEL_CHECK enum pel_err pel_cascades_create(const struct pel_sea_desc *desc,
                                           struct pel_cascades **out);
void pel_cascades_destroy(struct pel_cascades *c); /* NULL allowed */

/* The same between the bounds: what the waves shorter than wavelength_m carry,
 * within 2 % of the spectrum's integral. */
struct pel_cascade_beyond pel_cascades_below(const struct pel_cascades *c,
                                             double wavelength_m);

/* Slope variance that the textures still show at level of detail `lod`
 * (clamped to 0..8; interpolated between the steps). */
struct pel_slopes pel_cascade_kept(const struct pel_cascade *c, double lod);

/* Slope variance left to the BRDF where every cascade is sampled at the level
 * log2(footprint / its texel) + bias: the total less what is kept. */
struct pel_slopes pel_cascades_left(const struct pel_cascades *c,
                                    double footprint_m, double bias);

/* The fields of one moment. Texture layout: `displacement` (Dx, Dy, h, 0),
 * `slopes` (∂h/∂x, ∂h/∂y, ∂Dx/∂x, ∂Dy/∂y), `fold` (∂Dx/∂y), `velocity`
 * (∂/∂t of Dx, Dy, h; ∂²h/∂t²), `surge` (∂²/∂t² of Dx, Dy), N · N texels for
 * each cascade, first row first. */
struct pel_cascade_fields {
    double time_s;
    float (*displacement[PEL_CASCADES])[4];
    float (*slopes[PEL_CASCADES])[4];
    float *fold[PEL_CASCADES];
    float (*velocity[PEL_CASCADES])[4];
    float (*surge[PEL_CASCADES])[2];
    float (*breaking[PEL_CASCADES])[2];
};

/* Computes the fields at time_s: the reference for the shaders' FFT. */
PEL_CHECK enum pel_err
pel_cascade_fields_create(const struct pel_cascades *c, double time_s,
                          struct pel_cascade_fields **out);
void pel_cascade_fields_destroy(struct pel_cascade_fields *f); /* NULL: none */
