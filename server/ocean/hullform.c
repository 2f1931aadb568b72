#include "ocean/hullform.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"

#define DEEP_STEPS 1024

/* ∫_0^1 P'(ξ) sin(sξ) dξ, without its sign. */
static double along_transform(double m, double s)
{
    double e = 1.0 - m;
    double scale = 2.0 / (e * e);
    if (s < 0.05) { /* to s³: differences of near numbers beyond */
        double first = (1.0 - m * m * m) / 3.0 - m * (1.0 - m * m) / 2.0;
        double third =
            (1.0 - pow(m, 5.0)) / 5.0 - m * (1.0 - pow(m, 4.0)) / 4.0;
        return scale * s * (first - s * s * third / 6.0);
    }
    return scale * (-e * cos(s) / s + (sin(s) - sin(s * m)) / (s * s));
}

/* cosh k(d − z) / cosh kd */
static double rises(double k, double z, double depth_m)
{
    if (depth_m <= 0 || k * depth_m > 15.0) {
        return exp(-k * z);
    }
    z = fmin(z, depth_m);
    return (exp(-k * z) + exp(-k * (2.0 * depth_m - z))) /
           (1.0 + exp(-2.0 * k * depth_m));
}

/* ∫_0^1 P(ζ) rises(k, Tζ) dζ, Simpson's rule. */
static double deep_transform(const struct pel_hull *hull, double m, double k,
                             double depth_m)
{
    enum { STEPS = 64 };
    double sum = 0;
    for (int i = 0; i <= STEPS; i++) {
        double z = (double)i / STEPS;
        double past = fmax(z - m, 0.0) / (1.0 - m);
        double weight = i == 0 || i == STEPS ? 1.0 : i % 2 ? 4.0 : 2.0;
        sum += weight * (1.0 - past * past) *
               rises(k, hull->draught_m * z, depth_m);
    }
    return sum / (3.0 * STEPS);
}

enum pel_err pel_hull_form_init(struct pel_hull_form *form,
                                const struct pel_hull *hull, double k_most,
                                double depth_m)
{
    /* (2 + m) / 3 (2 + n) / 3 of the box is filled. */
    const double wigley = 4.0 / 9.0, full = 0.6;
    double n = 0.85 * pel_clamp((hull->block - wigley) / (full - wigley), 0, 1);
    double m = pel_clamp(9.0 * hull->block / (2.0 + n) - 2.0, 0.0, 0.93);
    form->scale = hull->block / ((2.0 + m) * (2.0 + n) / 9.0);
    form->k_most = k_most;
    form->along_count =
        (size_t)(0.5 * hull->length_m * k_most * PEL_HULL_STEPS) + 3;
    form->along = malloc(form->along_count * sizeof *form->along);
    form->deep = malloc((DEEP_STEPS + 2) * sizeof *form->deep);
    if (!form->along || !form->deep) {
        pel_hull_form_finish(form);
        return PEL_ERR_NO_MEMORY;
    }
    for (size_t i = 0; i < form->along_count; i++) {
        form->along[i] = (float)along_transform(m, (double)i / PEL_HULL_STEPS);
    }
    for (int i = 0; i < DEEP_STEPS + 2; i++) {
        form->deep[i] =
            (float)deep_transform(hull, n, k_most * i / DEEP_STEPS, depth_m);
    }
    return PEL_OK;
}

void pel_hull_form_finish(struct pel_hull_form *form)
{
    free(form->along);
    free(form->deep);
    *form = (struct pel_hull_form){ 0 };
}

double pel_hull_form_deep(const struct pel_hull_form *form, double k)
{
    double x = fmin(k / form->k_most, 1.0) * DEEP_STEPS;
    size_t i = (size_t)x;
    double f = x - (double)i;
    return (1.0 - f) * (double)form->deep[i] + f * (double)form->deep[i + 1];
}
