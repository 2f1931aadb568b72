/* What a picture shows of each entity, from its id layer and the models: boxes,
 * corners, what is hidden. Pure functions, any thread. */
#pragma once

#include "render/renderer.h"

/* Pixels from the upper left corner of the picture, x to the right, y down. */
struct pel_truth_box {
    double left, top, right, bottom;
};

/* A point of an entity. World: east and north of the origin on the map, up
 * above altitude 0. Camera: from the eye, to the right, down, ahead, with the
 * Earth's curve, as it is drawn. */
struct pel_truth_point {
    struct pel_vec3 world, camera;
    bool before; /* the eye: then it has a pixel */
    double x, y;
};

struct pel_truth {
    const struct pel_object *object;
    /* Of the id layer: right and bottom are behind the last pixel. */
    uint32_t pixels;
    struct pel_truth_box visible;
    /* Of its shape above its own waterline as though nothing stood before it,
     * no sea, land or entity: not cut at the picture's edges; and how many of
     * the picture's pixels have their middle in it, of these how many show it.
     * Holes by alpha test count as closed. */
    struct pel_truth_box whole;
    uint32_t whole_pixels, shown_pixels;
    /* Of the model's box: bit 0 of the index is the bow's side, bit 1 port,
     * bit 2 up. */
    struct pel_truth_point corners[8];
    /* The ends of the waterline, the bow's first. */
    struct pel_truth_point waterline[2];
    double distance_m, bearing_rad; /* from the eye to its origin */
};

/* Entities that have a pixel, or would have one if nothing hid them, in the
 * order of the environment; `picture` must have its id layer. NO_MEMORY. */
PEL_CHECK enum pel_err pel_truth_find(const struct pel_picture *picture,
                                      const struct pel_camera *camera,
                                      const struct pel_environment *env,
                                      struct pel_truth out[PEL_MAX_ENTITIES],
                                      size_t *count);
