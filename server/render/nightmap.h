/* The night sky of pictures: the map of its diffuse light, and the stars and
 * planets of a view by tiles of its pixels. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "optics/nightsky.h"
#include "render/renderer.h"

/* What the map depends on: visibility, the minute's axes, the Sun. */
#define PEL_NIGHT_KEYS 5

struct pel_night_textures {
    GLuint zonal, off; /* optics/nightsky.h */
    GLuint stars;      /* buffer, of the last view */
    struct pel_rgb air;
    double key[PEL_NIGHT_KEYS];
};

void pel_night_textures_finish(struct pel_night_textures *n);

/* Makes the map where it is not that of env->night, which is on. */
void pel_night_textures_fit(struct pel_night_textures *n,
                            const struct pel_environment *env);
void pel_night_key(const struct pel_environment *env,
                   double key[PEL_NIGHT_KEYS]);

/* Binds the map and the stars of the pixels of *view. */
void pel_night_textures_bind(struct pel_night_textures *n,
                             const struct pel_environment *env,
                             const struct pel_block_view *view);
