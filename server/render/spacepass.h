/* Draws a view from high up (render/spacemap.h): one pass over all pixels, as
 * fragments on every device, since there is no mesh to search. Render thread
 * only. */
#pragma once

#include <epoxy/gl.h>

#include "render/band.h"
#include "render/rendererstate.h"

/* Makes what such a view needs; `layers` as they are shaded, 0: its meter
 * alone. */
PEL_CHECK enum pel_err pel_space_need_view(struct pel_renderer *r,
                                           const struct pel_environment *env,
                                           double height_m, unsigned layers,
                                           struct pel_fault *fault);

/* Exposes a view by the eye at this height; the blocks `eye` and `sighted` are
 * bound. Where it has a share of the low form the block `exposure` holds that's
 * meter's, which is mixed in. */
void pel_space_expose(struct pel_renderer *r, const struct pel_environment *env,
                      const struct pel_camera *c, double height_m);

/* Between these the frame's block is that of the lights that such an eye has;
 * shade draws the band of a picture's layers, and says whether their colour is
 * among what it wrote. */
void pel_space_begin(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_camera *c, double height_m);
bool pel_space_shade(struct pel_renderer *r, const struct pel_environment *env,
                     const struct pel_camera *whole, struct pel_band band,
                     unsigned layers);
/* Mixes its share into the light of a picture of the low form; of other layers
 * takes the larger share's. */
void pel_space_mix(struct pel_renderer *r, const struct pel_environment *env,
                   const struct pel_camera *whole, unsigned layers,
                   double share);
void pel_space_end(struct pel_renderer *r, const struct pel_environment *env);
