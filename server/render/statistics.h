/* Heights of a sea below each wavelength and slopes below each footprint. Of an
 * FFT sea they take milliseconds, so they are kept until the sea changes.
 * Render thread only. */
#pragma once

#include <stdbool.h>

#include "render/mesh.h"
#include "render/renderer.h"
#include "render/uniforms.h"

/* What they depend on; zeroed before it is filled. */
struct pel_statistics_key {
    struct pel_sea_desc desc;
    double wind_to_rad;
};

/* Zeroed before its first use. */
struct pel_statistics {
    struct pel_statistics_key key;
    struct pel_mesh_losses losses;
    struct pel_variance variance[PEL_VARIANCE_COUNT];
    struct pel_variance breaking[PEL_VARIANCE_COUNT]; /* pel_fill_foam_left */
};

/* Brings them to the sea of `env`; true: they changed. */
bool pel_statistics_need(struct pel_statistics *s,
                         const struct pel_environment *env,
                         const struct pel_filter *filter);
