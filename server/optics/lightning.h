/* Lightning: cloud-to-ground flashes as a function of state, seed and time.
 *
 * Flashes come at random (Poisson), evenly over a storm's disc. Each has return
 * strokes along one channel: one in a fifth of them, else up to 20 with a mean
 * of 3.5; their intervals are log-normal with a geometric mean of 60 ms (Rakov
 * and Uman 2003, chapter 4). A first stroke radiates 3.7e5 J in the optical
 * band, the later ones a fourth of it (Guo and Krider 1982: peaks of 2.3e9 and
 * 4.8e8 W, widths of some 160 us), each by a log-normal factor; a third of the
 * flashes go on after the last stroke with a continuing current, as much light
 * again over 0.1 s. At 100 lm/W.
 *
 * Within clouds the channel goes on, as bright a metre, up to half of their
 * thickness; and there are three times as many flashes that stay within (Rakov
 * and Uman 2003, chapter 1), of the same strokes and light. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "optics/lamp.h"
#include "shaders/lib/blocks.h"

/* A channel is a line of so many lamps, the sea mirrors some of them. */
#define PEL_LIGHTNING_LAMPS 96
#define PEL_LIGHTNING_MIRRORED 12
#define PEL_LIGHTNING_STROKES 20            /* of a flash at most */
#define PEL_LIGHTNING_LASTS_S 2.0           /* a flash at most */
#define PEL_LIGHTNING_GLOWS PEL_CLOUD_GLOWS /* within clouds, at a moment */

struct pel_lightning {
    double per_minute; /* flashes; 0: none */
    double east_m, north_m, radius_m;
    double base_m;      /* height of the channels' upper ends, above the sea */
    double thickness_m; /* of the clouds above; 0: none */
    double turned_m;    /* on which light forgets its way within */
    uint32_t seed;
};

struct pel_lightning_flash {
    double time_s; /* of the first stroke */
    double east_m, north_m;
    uint32_t stream; /* of its random numbers */
    int strokes;
    double begin_s[PEL_LIGHTNING_STROKES];    /* after time_s */
    double energy_lms[PEL_LIGHTNING_STROKES]; /* lm s */
    double continuing_lms; /* after the last, evenly over 0.1 s */
};

/* Flashes whose first stroke lies in [from_s, to_s), in order of time within
 * each tenth of a second; `most` at most. Gives back their number. */
size_t pel_lightning_flashes(const struct pel_lightning *l, double from_s,
                             double to_s, struct pel_lightning_flash *out,
                             size_t most);

/* Luminous intensity of a flash in its mean over (time_s - exposure_s, time_s],
 * the same towards all sides [cd]. */
double pel_lightning_intensity(const struct pel_lightning_flash *flash,
                               double time_s, double exposure_s);

/* The lamps of those that burn in the exposure that ends at time_s, or one that
 * gives no light, so that what draws lamps is ready; `most` at most. */
size_t pel_lightning_lamps(const struct pel_lightning *l, double time_s,
                           double exposure_s, struct pel_lamp *out,
                           size_t most);

/* A place within clouds that gives light, the same to all sides. */
struct pel_lightning_glow {
    double east_m, north_m, altitude_m;
    double intensity_cd[3]; /* linear Rec. 709, luminance in candela */
};

/* Those of the exposure that ends at time_s; `most` at most. */
size_t pel_lightning_glows(const struct pel_lightning *l, double time_s,
                           double exposure_s, struct pel_lightning_glow *out,
                           size_t most);
