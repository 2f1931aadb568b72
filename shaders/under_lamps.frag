#version 450 core
// What lamps in the water add between the eye and what under_find.frag has found,
// and what falls from them on that: the bottom, or foam from below. By itself, as
// under_surface.frag is.
#define PEL_UNDER
#ifndef PEL_LAMPS_BELOW
#define PEL_LAMPS_BELOW
#endif
#include "lib/blocks.h"
#include "lib/turns.glsl"
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#include "lib/spline.glsl"
#ifdef PEL_SHORE
#include "lib/shore.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/ross.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/haze.glsl"
#include "lib/seabed.glsl"
#include "lib/cut.glsl"
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
#include "lib/underlight.glsl"
#include "lib/under.glsl"

layout(binding = PEL_UNIT_UNDER_FOUND) uniform sampler2D under_found; // of under_find.frag
layout(location = 0) out vec4 between_out;
layout(location = 1) out vec4 on_out;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 found = texelFetch(under_found, at, 0);
    float s = found.x;
    vec3 sight = normalize(pixel_ray(lattice(at))), place = s * sight;
    bool surface = found.y == PEL_UNDER_SURFACE;
    float footprint = s * pixel.x * inversesqrt(max(-sight.z, 0.02));
    vec3 n = surface ? vec3(0.0, 0.0, -1.0) : under_bottom_normal(place.xy, footprint);
    between_out = vec4(under_lamps_between(surface ? under_levelled(sight, s) : sight, s), 0.0);
    on_out = vec4(under_lamps_on_face(place, n), 0.0);
}
