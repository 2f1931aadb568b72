/* A bottom whose depth varies along one horizontal direction and is constant
 * along the other. Any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"

#define PEL_SECTION_KNOTS 8

/* Straight between knots, level before the first and beyond the last. Lengths
 * are from where a line of sight enters the water. */
struct pel_section {
    double azimuth_rad; /* of the direction from the line of sight's, in the
                           sense of pel_geometry's azimuth */
    int knots;          /* 1..PEL_SECTION_KNOTS; 1: level */
    double along_m[PEL_SECTION_KNOTS]; /* ascending; the same twice: a cliff */
    double depth_m[PEL_SECTION_KNOTS]; /* 0 (a beach)..PEL_DEPTH_MAX */
};

/* Where a line meets the bottom. */
struct pel_section_hit {
    double length;    /* in lengths of the line's direction */
    double along, up; /* unit normal of the bottom there, into the water */
};

/* A level bottom. */
struct pel_section pel_section_level(double depth_m);

/* A plane that falls (slope > 0, its tangent) in the direction of azimuth_rad
 * and is depth_m deep where the line of sight, of cosine view_mu in the water,
 * meets it; between a beach and deepest_m. INVALID when that line of sight
 * starts on land. */
PEL_CHECK enum pel_err pel_section_plane(double slope, double azimuth_rad,
                                         double view_mu, double depth_m,
                                         double deepest_m,
                                         struct pel_section *out);

/* Depth at a place along the section [m]. */
double pel_section_depth(const struct pel_section *p, double along_m);

/* Whether the line from a point in the water (along_m, depth_m down) towards
 * (along, up) meets the bottom, and where first. */
bool pel_section_meet(const struct pel_section *p, double along_m,
                      double depth_m, double along, double up,
                      struct pel_section_hit *hit);
