/* Particles in the water that an eye sees one by one: aggregates, marine snow.
 * Plain functions, any thread.
 *
 * Diameters d follow a power law, dN/dd in proportion to d^-exponent, from
 * PEL_MOTE_LEAST_M on (Junge 1963; Jackson et al. 1997, aggregates: 3 to 4).
 * They are divided by octaves of d. The water of an octave is divided into
 * cells, each of which has one at any place in it by a hash of its number, and
 * sinks and drifts as a whole: a function of place, time and seed alone. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"
#include "shaders/lib/blocks.h"

struct pel_mote_water {
    double per_m3;    /* of all, > 0 */
    double exponent;  /* 2.5 .. 6 */
    double largest_m; /* 1e-3 .. 0.03 */
};

/* One, at rest: `from` the eye, m. */
struct pel_mote {
    float from[3];
    float diameter_m;
};

/* Number of those larger than diameter_m. [1/m³] */
double pel_motes_larger(const struct pel_mote_water *water, double diameter_m);

/* How fast one sinks: 50 d^0.26 m a day, d in mm (Alldredge and Gotschalk
 * 1988). [m/s] */
double pel_mote_sinks(double diameter_m);

/* What of them an eye sees. */
struct pel_mote_view {
    struct pel_vec3 eye;               /* m; z up from the sea's zero */
    struct pel_mat3 world_from_camera; /* looks along -z */
    double tan_left, tan_right, tan_bottom, tan_top;
    double pixel_rad;
    double extinction; /* least of the water, 1/m, > 0 */
    double sways_m;    /* waves carry them no farther */
    double wind_to_rad;
    double time_s;
    uint32_t seed;
};

/* A particle is drawn up to d times this, m, and fades before. [m] */
double pel_mote_reach(const struct pel_mote_water *water,
                      const struct pel_mote_view *view);

/* Those that are drawn wherever waves carry them, in an order that does not
 * depend on the eye; their number, at most `room`. */
size_t pel_motes_seen(const struct pel_mote_water *water,
                      const struct pel_mote_view *view, struct pel_mote *out,
                      size_t room);
