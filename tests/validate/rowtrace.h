/* The reference picture, row by row, each with as many rays as it takes. */
#pragma once

#include "scene/snapshot.h"
#include "tests/validate/reference.h"

#define ROW_MOST 4096

enum part { SUN, SKY, WATER, PARTS };

struct row_plan {
    const struct reference *reference;
    const struct reference_light *light;
    struct pel_camera camera;
    int first;               /* rows above it are not traced */
    long least, most;        /* rays of a row; the number doubles between */
    double move;             /* of each part's mean until it is done */
    double slope_x, slope_y; /* variance along east and north: where to look
                                for the Sun */
};

struct row_result {
    double energy[PARTS]; /* mean radiance over what is sea, 550 nm */
    double move[PARTS];   /* by how much the last doubling moved it, relative */
    long rays;
};

/* Traces all rows from plan->first on by a thread a processor. The result is
 * that of any number of threads. `picture` of each part: RGB, camera.width ×
 * camera.height. `name` goes before the progress on standard error. */
void rowtrace(const struct row_plan *plan, const char *name,
              struct row_result *rows, float *picture[PARTS]);
