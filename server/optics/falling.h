/* Drops and flakes near the eye as pictures show them: streaks, while the
 * shutter is open. Plain functions, any thread.
 *
 * What falls is divided by size into kinds of equal cross-section, each of
 * which falls at its own speed and drifts with the wind. Seen from the eye a
 * kind moves along one axis; about it the air is divided into shells that are
 * twice as far as the one before, a shell into columns along the axis, these
 * into cells that move with the drops. A cell has one drop at most, by a hash
 * of its number: a function of the direction, the time and the seed alone.
 * shaders/falling.vert places it. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/vec.h"
#include "shaders/lib/blocks.h"

struct pel_fall_desc {
    double rain_mm_h, snow_mm_h;
    double wind_mps, wind_to_rad;
    struct pel_vec3 eye_mps; /* its velocity */
    double shutter_s;
    double time_s;
    uint32_t seed;
    double pixel_rad; /* angle of a pixel on the picture's axis */
    int only;         /* for tests: this kind alone, from 1; 0: all */
};

/* Lengths in metres. */
struct pel_fall_shell {
    double near_m;    /* it reaches to twice as far */
    int columns;      /* around the axis */
    double cell_m;    /* along it */
    double chance;    /* that a cell has a streak */
    double weight;    /* of the streak, drops */
    double spread_m2; /* of the place of these */
    uint32_t seed;
};

struct pel_fall_kind {
    bool flake;
    double diameter_m, speed_mps; /* in still air */
    struct pel_vec3 axis, side;   /* unit; side is normal to it */
    double past_mps;              /* along the axis, past the eye */
    double streak_m;              /* that it falls while the shutter is open */
    double extinction;            /* of its shadows, 1/m */
    double turn;                  /* PEL_FALL_LIFE_S until time_s, mod 65536 */
    double far_m;  /* from the eye: none is drawn from there on */
    double covers; /* by what is drawn one by one */
    int shell_count;
    struct pel_fall_shell shells[PEL_FALL_SHELLS];
};

struct pel_fall_plan {
    int count; /* rain's, then snow's */
    struct pel_fall_kind kinds[PEL_FALL_KINDS];
};

/* What is too dense to be told apart, or fainter than anybody sees, is left
 * out: its mean is in the air's extinction. */
void pel_fall_plan(const struct pel_fall_desc *desc, struct pel_fall_plan *out);

/* Terminal speed [m/s] of a drop of a diameter [mm], Atlas, Srivastava and
 * Sekhon 1973 (their fit to Gunn and Kinzer 1949): 9.65 - 10.3 exp(-0.6 D);
 * at least 0.3. */
double pel_drop_speed(double diameter_mm);

/* The same of a flake by its melted diameter [mm], an aggregate (Langleben
 * 1954): 0.98 D^0.31. */
double pel_flake_speed(double melted_mm);

/* The columns and slopes (cotangents of the angle from the axis) about the axis
 * of a kind that a picture may show; axes x right, y up, z backwards. */
struct pel_fall_range {
    double turn_first, turns; /* of the columns, of a whole turn; first in
                                 0..1 */
    double slope_first, slope_last;
};
struct pel_fall_range pel_fall_range(const struct pel_fall_kind *kind,
                                     const struct pel_mat3 *world_from_camera,
                                     double tan_left, double tan_right,
                                     double tan_bottom, double tan_top);
