/* Ship waves: the transient thin ship (Havelock; the source potential of Cauchy
 * and Poisson). A hull of half-beam f(x, z), z down, that runs along X(τ)
 * pushes water aside on its centre plane; the volume that a source at depth z
 * emits rises to the surface and then oscillates: Q(k, τ) = −2 U ∬ f_x cosh k(d
 * − z) / cosh kd e^{−i k∥ x} dx dz ζ̂(k, t) = ∫ Q(k, τ) e^{−i k·X(τ)} cos ω(t −
 * τ) dτ,  ω² = g k tanh kd Linear: ships add up, with each other and with the
 * sea's waves. Starts, stops, turns and shallow water are in it. A function of
 * (track, time), no history.
 *
 * A track is pieces, straight and at constant speed; of one the integral is
 * closed. Waves stand on periodic tiles that follow the ship, each of one band
 * of |k|: what left the tile (its packet, at the group velocity) is left out,
 * and the tile fades towards its border. A ship too slow for waves of the
 * longest tile has a second one of the middle tile's waves behind that, for
 * what has left it.
 *
 * Frame as ocean/sea.h. Immutable once built; any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "base/vec.h"
#include "ocean/bowwave.h"
#include "shaders/lib/blocks.h" /* PEL_WAKE_N texels of a tile's side */

#define PEL_WAKE_TILES 3   /* of a ship, longest waves first */
#define PEL_WAKE_RATIO 3.0 /* of their sides */
#define PEL_WAKE_MODES 88  /* highest mode number: 2.9 texels */
#define PEL_WAKE_NEAR_M 256.0
#define PEL_WAKE_POINTS 257 /* at most 256 pieces */

/* Sections that are parabolas at the ends of a parallel body: half-beam
 * b/2 P(2x/L, m) P(z/T, n), P(s, m) = 1 up to m, then 1 − ((s − m) / (1 − m))².
 * m = n = 0 is Wigley's hull, of block coefficient 4/9; fuller ones are full
 * amidships first (n = 0.85 from 0.6 on). Symmetric fore and aft. */
struct pel_hull {
    double length_m, beam_m, draught_m; /* > 0 */
    double block; /* block coefficient, 0.2..0.95; below 4/9 narrower ones */
};

/* The ship's middle was here then. */
struct pel_wake_point {
    double time_s;
    double x_m, y_m;
};

/* The waterline that raises the bow wave (wakebow.c): its stem forward of
 * amidships, its length; long_m 0: none. */
struct pel_wake_bow {
    double stem_m, long_m;
    double half_m[PEL_BOW_STATIONS];
};

struct pel_wake_track {
    struct pel_hull hull;
    struct pel_wake_bow bow;
    int count; /* of points, rising in time; at least 2, or no waves */
    struct pel_wake_point point[PEL_WAKE_POINTS];
};

/* A tile of one ship at one moment: its side, and the middle of the square in
 * which it holds. Texel (i, j) is at the place (i, j) · length / N, repeated:
 * (Dx, Dy, h, ∂h/∂t). */
struct pel_wake_tile {
    double length_m;
    double x_m, y_m;
    float (*texels)[4]; /* NULL: it holds no waves */
};

#define PEL_WAKE_TILE_BYTES ((size_t)PEL_WAKE_N * PEL_WAKE_N * sizeof(float[4]))

/* The waves of one ship at one moment. */
struct pel_wake {
    /* Longest waves first, or the tile behind. */
    struct pel_wake_tile tile[PEL_WAKE_TILES];
};

/* Side of the tile of the shortest waves; each other one is RATIO times as long
 * as the next. */
double pel_wake_near_m(const struct pel_hull *hull);

/* What a track has left in the water up to a moment: dear (every mode and
 * piece), and what the moments that follow are made from. */
struct pel_wake_past;

/* The waves of a track up to time_s, its last piece going on as it is; depth_m:
 * 0 is deep water. What comes later than time_s has no part in it. NO_MEMORY.
 */
PEL_CHECK enum pel_err pel_wake_past_create(const struct pel_wake_track *track,
                                            double time_s, double depth_m,
                                            struct pel_wake_past **out);
void pel_wake_past_destroy(struct pel_wake_past *past); /* NULL: none */

/* What it holds, with what it may share with others. */
size_t pel_wake_past_bytes(const struct pel_wake_past *past);

/* The waves at time_s, not before it, of a track that is the same up to its
 * moment: cheap (a turn of every mode, the pieces since, transforms). What the
 * tiles let go is that of the past's moment: within 0.3 % of the highest wave
 * for as long as the ship goes a tenth of the shortest tile's side. NO_MEMORY.
 */
PEL_CHECK enum pel_err pel_wake_later(const struct pel_wake_past *past,
                                      const struct pel_wake_track *track,
                                      double time_s, struct pel_wake **out);

/* The tiles at time_s without their texels: sides and middles. */
void pel_wake_lay(const struct pel_wake_past *past,
                  const struct pel_wake_track *track, double time_s,
                  struct pel_wake *out);

/* Whether a laid tile may hold waves at a place of [low, high]. */
bool pel_wake_tile_holds(const struct pel_wake_tile *tile, struct pel_vec2 low,
                         struct pel_vec2 high);

/* Fills in the texels of laid tile `which`, as pel_wake_later does. NO_MEMORY.
 */
PEL_CHECK enum pel_err pel_wake_fill(const struct pel_wake_past *past,
                                     const struct pel_wake_track *track,
                                     double time_s, int which,
                                     struct pel_wake *wake);

/* Whether its waves at time_s may be seen within radius_m of a place. */
bool pel_wake_reaches(const struct pel_wake_track *track, double time_s,
                      double depth_m, double x_m, double y_m, double radius_m);

/* Both in one. */
PEL_CHECK enum pel_err pel_wake_create(const struct pel_wake_track *track,
                                       double time_s, double depth_m,
                                       struct pel_wake **out);
void pel_wake_destroy(struct pel_wake *wake); /* NULL: none */

/* What a wake adds at one place of rest: displacement, the slopes of its
 * height, the derivatives of its horizontal part, ∂h/∂t. */
struct pel_wake_shift {
    struct pel_vec3 d;
    double hx, hy;
    double dxx, dxy, dyx, dyy; /* dxy: ∂Dx/∂y */
    double rise_mps;
};

/* Adds `wake` at the place to *to. */
void pel_wake_add(const struct pel_wake *wake, double x_m, double y_m,
                  struct pel_wake_shift *to);

/* Mean squares of the slopes of height over ROUGH_N² blocks of texels, from
 * every fourth: ∂h/∂x squared, ∂h/∂y squared, their product. The tile has
 * texels. */
void pel_wake_tile_slopes(const struct pel_wake_tile *tile, float (*out)[4]);
