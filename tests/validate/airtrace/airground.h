/* What lies below the air: nothing, a matt ground, or a rough sea. */
#ifndef AIRGROUND_H
#define AIRGROUND_H

#include "airmodel.h"

enum air_ground_kind { AIR_BLACK, AIR_LAMBERT, AIR_FRESNEL };

/* The sea: facets of Gaussian slopes that mirror by Fresnel's equations, with
 * Smith's masking of both directions; and light out of the water, alike in all
 * directions. What facets reflect on to other facets is left out. */
struct air_ground {
    enum air_ground_kind kind;
    double albedo[AIR_CHANNELS]; /* of the matt ground; out of the water */
    double variance;             /* of slopes along one axis */
    /* Where it is above 0, the variance across `axis`, a vector in space that
     * is laid on the ground; else slopes are alike in all directions. */
    double across;
    struct air_vec axis;
    double index[AIR_CHANNELS]; /* of refraction */
};

/* A sea under a wind in m/s: slopes of Cox and Munk 1954, 0.003 + 0.00512 U
 * for both axes together; water of 35 g/kg and 15 degrees Celsius (Quan and
 * Fry 1995); 0.1, 0.8 and 1.7 % out of clear water. */
void air_ground_sea(struct air_ground *ground, double wind);

/* 1/sr; both directions point away from the ground, `up` is its normal. */
double air_ground_reflect(const struct air_ground *ground, int channel,
                          struct air_vec eye, struct air_vec light,
                          struct air_vec up);

/* Of it the facets' part alone. */
double air_ground_mirror(const struct air_ground *ground, int channel,
                         struct air_vec eye, struct air_vec light,
                         struct air_vec up);

/* A direction that light may come from, from three numbers in [0, 1);
 * `*weight` is reflectance times cosine over the direction's density. */
struct air_vec air_ground_sample(const struct air_ground *ground, int channel,
                                 struct air_vec eye, struct air_vec up,
                                 const double u[3], double *weight);

/* Share of light from a zenith cosine that comes back at all, by quadrature. */
double air_ground_albedo(const struct air_ground *ground, int channel,
                         double cosine);

#endif
