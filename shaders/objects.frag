#version 450 core
// The objects of a picture: the light of their samples, or layers of what
// pixels' middles show (object.frag); in tiles with land that stands nearer,
// not.
#include "lib/blocks.h"
#include "lib/turns.glsl"
#ifdef PEL_LAND
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif
#include "lib/filtered.glsl"
#endif
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/variance.glsl"
#include "lib/ray.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
#include "lib/haze.glsl"
#ifdef PEL_LAND
#include "lib/seabed.glsl"
#endif
#include "lib/objects.glsl"
#include "lib/tone.glsl"
#include "lib/outputs.glsl"

#ifdef PEL_SAMPLED
// Over what is behind it, by the share of the pixel that it covers.
void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    float cover;
    shaded s = shade_samples(at, cover);
    if (cover == 0.0) {
        discard;
    }
    radiance_out = vec4(s.radiance, cover);
#ifdef PEL_LAYERS
    for (int i = 0; i < PEL_FRAGMENT_SLOTS; i++) {
        slot_out[i] = vec4(layer_of(s, slots[i]).rgb, cover);
    }
#endif
}
#else
void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    uvec2 seen = texelFetch(objects, at, 0).rg;
    vec3 ray = pixel_ray(lattice(at));
    if (!object_in_sight(ray, seen)) {
        discard;
    }
    write_outputs(shade_object(ray, seen), at, 0.0);
}
#endif
