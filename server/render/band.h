/* Bands: rows of a picture that are drawn separately, with the same result as
 * in the whole. Pure computation, any thread. */
#pragma once

#include "render/disc.h"
#include "render/renderer.h"

struct pel_band {
    uint32_t first, rows;
};

struct pel_band pel_band_of(const struct pel_draw *draw);

/* The camera that sees only these rows. */
struct pel_camera pel_band_camera(const struct pel_camera *whole,
                                  struct pel_band band);

/* The part of a light's box (render/disc.h) that lies in the band; height 0:
 * none. */
struct pel_disc_box pel_band_disc(const struct pel_camera *whole,
                                  struct pel_vec3 to, double radius_rad,
                                  struct pel_band band);

/* Reduces the tiles of the whole picture to those of the band. */
void pel_band_tiles(const struct pel_camera *whole, struct pel_band band,
                    uint32_t *tiles);
