/* One layer of clouds: a field over the plane, and the light in it.
 *
 * The field is the rank U of a place among all places of a periodic tile, made
 * of noise: clouds stand where U is above 1 - cover, so that the share of the
 * sea below them is `cover` exactly; they are the thicker the farther above.
 * It drifts with the layer's wind and does not change otherwise.
 *
 * Light: what one scattering sends on, by the phase function; and of all others
 * the mean intensity of a slab of the same optical depth by Eddington's closed
 * form for conservative scattering, with lengths that of its scattering count
 * 1 - g (van de Hulst's similarity). Twin of shaders/lib/clouds.glsl. Any
 * thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"
#include "base/vec.h"
#include "shaders/lib/blocks.h"

enum pel_cloud_genus {
#define PEL_CLOUD(ID, ...) PEL_CLOUD_##ID,
#include "optics/clouds.def"
    PEL_CLOUD_GENERA
};

struct pel_clouds {
    double cover; /* share of the sea below them, 0: none .. 1 */
    enum pel_cloud_genus genus;
    double base_m, thickness_m; /* the latter at most */
    double east_mps, north_mps; /* they drift */
    uint32_t seed;
};

struct pel_cloud_kind {
    double base_m, thickness_m;
    double extinction; /* 1/m */
    double tile_m, along, rise, grain, soft_m;
};
const struct pel_cloud_kind *pel_cloud_kind(enum pel_cloud_genus genus);

/* Texels a side of the tile; what each has: U, its square (whose mean over many
 * texels tells how much U differs there), and fine structure of mean 0.5. */
#define PEL_CLOUD_SIDE PEL_CLOUD_TEXELS

/* The tile; 0.2 s. */
void pel_cloud_field(enum pel_cloud_genus genus, uint32_t seed,
                     float (*texels)[4]);

/* The rank above which there is cloud: 1 - cover; below 0 where the cover is
 * whole, since eight octas have no gap and so no place without thickness. */
double pel_cloud_bound(const struct pel_clouds *clouds);

/* Share of the thickness that a cloud has where the rank is U, 0: none. */
double pel_cloud_thick(const struct pel_clouds *clouds, double u);

/* By how much more light that enters a thick slab at this zenith cosine reaches
 * its depths, or that comes from there leaves it this way, than Eddington's
 * 2/3 + mu has: 3/7 (1 + 2 mu) (Zege, Ivanov and Katsev 1991). */
double pel_cloud_escape(double mu);

/* Mean intensity over an irradiance of 1 on a plane across the beam, of all
 * light scattered at least once, at optical depth t of a slab of b, both times
 * 1 - g, below the beam of zenith cosine mu. Eddington. */
double pel_cloud_glow(double t, double b, double mu);

/* Share of the light on a level plane that such a slab of optical depth b lets
 * through, the beam itself included. */
double pel_cloud_through(double b, double mu);

/* Mean intensity at height z over the base of a layer `high` thick, `across`
 * metres aside of a point at height `from` that gives off 1 a steradian: by
 * diffusion, 3 / (4 pi l r), l the length on which light forgets its way, less
 * the images that make it end 2/3 l beyond either side; far away the modes that
 * these are [1/m2]. */
double pel_cloud_within(double l, double high, double across, double z,
                        double from);
