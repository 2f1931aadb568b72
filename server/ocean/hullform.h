/* What a thin hull's sections make of its source strength (wake.h): its
 * transforms along and down. Pure functions of the hull, any thread. */
#pragma once

#include <stddef.h>

#include "base/err.h"
#include "ocean/wake.h"

#define PEL_HULL_STEPS 32.0 /* of the table along, a unit of s */

struct pel_hull_form {
    double scale; /* of the beam */
    size_t along_count;
    /* G(s) = ∫_0^1 P'(ξ) sin sξ dξ without its sign, s = i / STEPS */
    float *along;
    float *deep; /* ∫_0^1 P(ζ) cosh k(d − Tζ) / cosh kd dζ over k, 0..k_most */
    double k_most;
};

/* Up to k_most [rad/m]; depth_m: 0 is deep water. NO_MEMORY. */
PEL_CHECK enum pel_err pel_hull_form_init(struct pel_hull_form *form,
                                          const struct pel_hull *hull,
                                          double k_most, double depth_m);
void pel_hull_form_finish(struct pel_hull_form *form);

double pel_hull_form_deep(const struct pel_hull_form *form, double k);
