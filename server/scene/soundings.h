/* Depths of the bottom in a raster, as charts and plans want them: of the one
 * field that is drawn, at a scale of their own. */
#pragma once

#include <stddef.h>

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "seabed/seabed.h"

struct pel_scene;

/* A raster about a place of the local frame. */
struct pel_soundings_raster {
    int columns, rows;
    double east_m, north_m; /* its middle */
    double spacing_m;       /* of cells, both ways */
    double up_rad;          /* where it looks up, clockwise from the y axis */
};

/* Depth below mean sea level [m] of each cell, row by row from the upper left,
 * negative on land, NaN without data: at its middle and, where cells are larger
 * than the field's, the least of the nodes in it too, so that nothing narrow is
 * lost. At most some 4e6 nodes are looked at. Any thread. */
void pel_soundings_fill(const struct pel_seabed *bed,
                        const struct pel_soundings_raster *raster,
                        float *depth_m);

/* depth_m: `count` floats, little-endian; NULL on failure; the callee's. */
typedef void (*pel_soundings_done)(void *user, enum pel_err err,
                                   const struct pel_fault *fault,
                                   float *depth_m, size_t count);

/* Asks a thread; `done` is called on the control thread. The query was tested.
 * CONFLICT: the state names no seabed.file; BUSY. Control thread. */
PEL_CHECK enum pel_err pel_scene_ask_soundings(
    struct pel_scene *scene, const Pelagos__SoundingsQuery *query,
    pel_soundings_done done, void *user, struct pel_fault *fault);
