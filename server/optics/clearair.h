/* The air of the scene's default visibility with its table, which takes half a
 * second of a core and which most programs want first: made when the program
 * is built (server/tables.c), by the code that makes the others
 * (optics/airlight.h), and part of the program. */
#ifndef PELAGOS_OPTICS_CLEARAIR_H
#define PELAGOS_OPTICS_CLEARAIR_H

#include "optics/airlight.h"

struct pel_clear_air {
    double visibility_m;
    struct pel_airlight light;
};

extern const struct pel_clear_air pel_clear_air;

#endif
