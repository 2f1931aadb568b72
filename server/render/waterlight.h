/* The light that leaves the water, as maps over the line of sight for every
 * pixel of a frame (shaders/lib/water.glsl). A new water costs its response to
 * beams from every elevation (optics/waterkernel.h, on the processor; the
 * second order by the maps of Iwasaki et al. 2003, on the device): some 25 ms
 * on a software device. A new light or sky costs a sum over that: 2 ms there,
 * 0.1 ms on hardware. Both happen in the frame that first shows them, so a
 * picture is a function of its scene and no frame waits for more. Render thread
 * only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "optics/waterkernel.h"
#include "render/renderer.h"

enum pel_water_program {
    PEL_WATER_PHASE_MAP,    /* volume-scattering map */
    PEL_WATER_RADIANCE_MAP, /* with the attenuation map */
    PEL_WATER_SCATTER_MAP,
    PEL_WATER_SKY,
    PEL_WATER_MAP,
    PEL_WATER_PROGRAMS,
};

enum pel_water_buffer {
    PEL_WATER_BUFFER_DIRECTIONS, /* of the sampling: cosine, weight */
    PEL_WATER_BUFFER_KNOTS,      /* nodes of beams and sights: sine, cosine */
    PEL_WATER_BUFFER_PLANE,      /* depths and weights of the planes */
    PEL_WATER_BUFFER_KERNEL,
    PEL_WATER_BUFFER_SKY_ROW, /* places of the sky's and of the maps' rows */
    PEL_WATER_BUFFER_MAP_ROW,
    PEL_WATER_BUFFER_COEFFICIENTS, /* the sky as beams at the nodes */
    PEL_WATER_BUFFER_MEDIUM,
    PEL_WATER_BUFFER_BEAM,
    PEL_WATER_BUFFER_TURNS, /* the phase function */
    PEL_WATER_BUFFERS,
};

struct pel_water_light {
    GLuint programs[PEL_WATER_PROGRAMS];
    GLuint buffers[PEL_WATER_BUFFERS];
    GLuint phase_map, radiance_map, attenuation_map;
    GLuint map; /* texture array, as in shaders/lib/water.glsl */
    struct pel_water_body body; /* of the kernel */
    struct pel_water_depths depths;
    enum pel_water_orders orders;
    double beams[PEL_LIGHTS]; /* just below the surface: irradiance normal to
                                 each light's beam, of 1 above it */
    uint64_t version; /* counts changes of the kernel; 0: there is none yet */
    bool failed;      /* the last try for a new one found no memory */
    /* pel_water_kernel_take, or what a test puts in its place. */
    enum pel_err (*build)(const struct pel_water_body *body,
                          const struct pel_water_depths *depths,
                          enum pel_water_orders orders,
                          struct pel_water_kernel *out);
};

PEL_CHECK enum pel_err pel_water_light_init(struct pel_water_light *w,
                                            const char *shader_dir,
                                            struct pel_fault *fault);
void pel_water_light_finish(struct pel_water_light *w);

/* The depths that are made for an environment. */
struct pel_water_depths
pel_water_light_depths(const struct pel_environment *env);

/* Brings the kernel up to date with the water, its depths and the orders of
 * *env. Where there is no memory for it, *env gets the water, the depths and
 * the orders that the maps still hold, so that the picture is whole, and the
 * next call tries again; NO_MEMORY when the maps hold none that would do: none
 * at all, or one depth where a height field asks for several. */
PEL_CHECK enum pel_err pel_water_light_update(struct pel_water_light *w,
                                              struct pel_environment *env);

/* Waves that lights come in through: mean-square slopes along and across the
 * axis that lies wind_to_rad from east. */
struct pel_water_waves {
    double along, cross, wind_to_rad;
};

/* The beam of light i and its sky as beams at the nodes: fills and binds block
 * `beam` and the buffer PEL_STORE_WATER_COEFFICIENTS. As pel_water_light_map.
 */
void pel_water_light_enter(struct pel_water_light *w,
                           const struct pel_light *lights, int i,
                           const struct pel_water_waves *waves,
                           GLuint sky_table);

/* Fills the maps for the first `lit` lights and their skies, layers of
 * `sky_table`. More of a low light enters through `waves` than through a level
 * surface (NULL); the sky's light enters as through that. The blocks `frame`
 * and `light` are bound, the buffer of the latter is `light` and gets
 * sea_light. */
void pel_water_light_map(struct pel_water_light *w,
                         const struct pel_light *lights, int lit,
                         const struct pel_water_waves *waves, GLuint sky_table,
                         GLuint light);
