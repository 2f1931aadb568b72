/* Fog and haze in layers and banks: what they add to the extinction of the air,
 * in closed form along any way, and the light that they scatter. Twin of
 * shaders/lib/fog.glsl. Any thread.
 *
 * A layer is everywhere: its extinction is EXTINCTION between base and top and
 * falls to nothing, linearly, over `soft_m` about each; a base of 0 has no such
 * edge. A bank is a dome on the sea (or a lens, where its base is higher): with
 * q = r² / R² + ((z - middle) / half height)² its extinction is EXTINCTION up
 * to q = 1 - PEL_FOG_RIM and falls to nothing, linearly in q, at 1.
 *
 * Light: as in clouds (optics/clouds.h), for drops of the same asymmetry, with
 * the open sky above and the sea below. What light scattered n + 1 times by a
 * Henyey-Greenstein function of asymmetry g goes like is such a function of
 * g^(n + 1); with n the optical depth on the way to the lamp that is what the
 * part of a beam goes like that has been turned, but not far. */
#pragma once

#include "base/vec.h"
#include "shaders/lib/blocks.h"

#define PEL_FOG_MAX PEL_FOGS

struct pel_fog {
    double extinction;    /* 1/m */
    double base_m, top_m; /* above the sea */
    double soft_m;        /* of a layer: width of its edges */
    double radius_m;      /* of a bank; 0: a layer, everywhere */
    /* Of a bank: its middle at simulated time 0, in the scene's frame; it
     * drifts. */
    double east_m, north_m, east_mps, north_mps;
};

/* Extinction by Koschmieder's visibility: a black thing against the horizon has
 * 2 % of contrast there. */
double pel_fog_extinction(double visibility_m);

/* As the shaders have it, seen from a place (in the scene's frame). */
struct pel_shader_fog pel_fog_seen(const struct pel_fog *f, double time_s,
                                   double east_m, double north_m);

/* A place: metres from that place, z above the curved sea. Optical depth from
 * there along the unit direction `dir` for `range_m`; in *mean_m, unless NULL,
 * how far the light comes from that it scatters towards there, on average. */
double pel_fog_way(const struct pel_shader_fog *f, struct pel_vec3 from,
                   struct pel_vec3 dir, double range_m, double *mean_m);

/* How much longer than upward the way out of a layer is from the sea towards a
 * light of zenith cosine mu (from 0 on), the sea's curve and all. */
double pel_fog_slant(const struct pel_shader_fog *f, double mu);

/* Optical depth of what is above and below a place. */
void pel_fog_column(const struct pel_shader_fog *f, struct pel_vec3 at,
                    double *above, double *below);

/* Extinction there, over the greatest. */
double pel_fog_density(const struct pel_shader_fog *f, struct pel_vec3 at);

/* What scatters at a place, as radiance that a long way through fog like this
 * tends to: of a sky of irradiance `sky` on a level plane above the fog, a beam
 * of irradiance `beam` across it (`way`: optical depth towards it, `mu` its
 * zenith cosine, `cosine` that of the angle between the line of sight and the
 * direction to the light), `above` and `below` of this place. In *single what
 * was scattered once, which is in it. */
struct pel_fog_light {
    double above, below, way, mu, cosine;
    double sky, beam;
};
double pel_fog_source(const struct pel_fog_light *l, double *single);
