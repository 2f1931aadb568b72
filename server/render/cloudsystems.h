/* Noise of the systems of clouds on the Earth, twin of lib/spacecloud.glsl
 * (noise_at, cloud_systems). Pure, any thread. */
#pragma once

#include "base/vec.h"

#define PEL_CLOUD_OCTAVES 9

/* Where a point's normal is this unit vector of the Earth's axes, each octave's
 * noise less its mean; `from`: where they begin. */
void pel_cloud_systems(struct pel_vec3 earth, double from,
                       double octaves[PEL_CLOUD_OCTAVES]);
