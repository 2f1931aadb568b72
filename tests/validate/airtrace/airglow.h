/* Directions drawn towards the glow of dusk over the Sun. */
#ifndef AIRGLOW_H
#define AIRGLOW_H

#include "airmodel.h"

/* As seen from a place. */
struct air_glow {
    struct air_vec up, toward, beside;
    double middle, low, range; /* of the elevation, and of what is drawn */
};

struct air_glow air_glow_at(struct air_vec p, struct air_vec sun,
                            double ground);

/* For two numbers in [0, 1). */
struct air_vec air_glow_turn(const struct air_glow *g, double u, double v);

/* 1/sr */
double air_glow_density(const struct air_glow *g, struct air_vec d);

#endif
