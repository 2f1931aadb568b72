/* Fills the uniform blocks of shaders/lib/blocks.h. Pure computation. */
#pragma once

#include "ocean/cascade.h"
#include "render/filtering.h"
#include "render/mesh.h"
#include "render/renderer.h"
#include "shaders/lib/blocks.h"

/* The levels of depth as lib/water.glsl finds them, and a last component. */
struct pel_vec4 pel_water_levels(const struct pel_environment *env,
                                 double last);

void pel_fill_frame(const struct pel_environment *env,
                    struct pel_block_frame *out);

void pel_fill_eye(double height_m, double table_height_m,
                  const struct pel_mesh *mesh, struct pel_block_eye *out);

/* Phases at the nadir of (east_m, north_m) at env->time_s. */
void pel_fill_waves(const struct pel_environment *env, double east_m,
                    double north_m, struct pel_block_waves *out);

/* Places of the cascades' tiles at the nadir of (east_m, north_m). */
void pel_fill_cascades(const struct pel_cascades *cascades, double east_m,
                       double north_m, struct pel_block_cascades *out);

/* Never changes. */
void pel_fill_facets(struct pel_block_facets *out);

struct pel_variance {
    float along, cross;
};

/* Table of the slope variance that a footprint leaves unresolved
 * (pel_sea_slopes_left). */
void pel_fill_variance(const struct pel_sea *sea,
                       const struct pel_filter *filter,
                       struct pel_variance out[PEL_VARIANCE_COUNT]);

/* As the shaders read it: each entry and the next, which the last lacks. */
void pel_pair_variance(const struct pel_variance table[PEL_VARIANCE_COUNT],
                       struct pel_variance out[PEL_VARIANCE_COUNT - 1][2]);

/* By the same footprints, in `along`, the standard deviation that one leaves of
 * what breaks (pel_foam_left), of a sea with foam. */
void pel_fill_foam_left(const struct pel_sea *sea,
                        const struct pel_filter *filter,
                        struct pel_variance out[PEL_VARIANCE_COUNT]);

struct pel_foam;
/* The spray between an eye at height_m and the sea; foam NULL: none. */
void pel_fill_spray(const struct pel_foam *foam, double height_m,
                    struct pel_block_eye *out);

/* The wash of ships, for lib/wash.glsl. */
void pel_fill_wash(const struct pel_environment *env, double east_m,
                   double north_m, struct pel_block_wash *out);

/* The areas of a sea, for lib/areas.glsl. */
void pel_fill_areas(const struct pel_environment *env, double east_m,
                    double north_m, struct pel_block_areas *out);

/* Fog as it is seen from a place, and from own ship's for what the sea mirrors,
 * in steps of PEL_FOG_STEP_M. */
void pel_fill_fog(const struct pel_environment *env, double east_m,
                  double north_m, struct pel_block_eye *out);
void pel_fill_fog_own(const struct pel_environment *env,
                      struct pel_block_eye *out);

/* Where the eye stands on the structure of foam (lib/foam.glsl). */
/* Where clouds are seen from, in metres of the air that they drift with. */
void pel_fill_cloud_eye(const struct pel_environment *env, double x_m,
                        double y_m, struct pel_block_eye *out);

void pel_fill_grain(const struct pel_foam *foam, double wind_to_rad,
                    double east_m, double north_m, struct pel_block_eye *out);
/* Also rounds the camera's pixel lattice: see pel_pixel_pitch. */
void pel_fill_view(const struct pel_camera *camera,
                   const struct pel_filter *filter, struct pel_block_view *out);

/* What the camera's meter looks through. */
void pel_fill_sights(const struct pel_environment *env,
                     const struct pel_camera *camera,
                     struct pel_block_sighted *out);

/* Tangent of a pixel from the frustum, rounded to 20 bits so that pictures
 * which tile one frustum agree to the last bit. */
double pel_pixel_pitch(double tan_low, double tan_high, uint32_t pixels);
