#version 450 core
// What clouds and fog leave of the sky's light on the sea, from the map that the sea
// reflects: the skies of all lights are scaled alike.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
layout(std430, binding = PEL_STORE_LIGHT) buffer out_block {
    vec4 out_incident;
    vec4 out_sea;
    vec4 out_beams[PEL_LIGHTS];
    vec4 out_skies[PEL_LIGHTS];
};

shared vec3 partial[PEL_GROUP_LINE];

float illuminance(vec3 e)
{
    return dot(vec3(0.2126, 0.7152, 0.0722), vec3(dot(red.rgb, e), dot(green.rgb, e), dot(blue.rgb, e)));
}

void main()
{
    uint lane = gl_LocalInvocationID.x;
    vec3 sum = vec3(0.0);
    // E = ∫ L cos θ dω, by even steps of sin² θ.
    for (uint k = lane; k < 1024u; k += uint(PEL_GROUP_LINE)) {
        float azimuth = 2.0 * PI * (float(k & 31u) + 0.5) / 32.0;
        float sine = sqrt((float(k >> 5u) + 0.5) / 32.0);
        float cosine = sqrt(1.0 - sine * sine);
        vec2 u = vec2(cos(azimuth), sin(azimuth)) * (sine / (1.0 + cosine));
        sum += textureLod(reflection_map, u * (0.5 / PEL_REFLECTION_HALF_WIDTH) + 0.5, 1.0).rgb;
    }
    partial[lane] = sum * (PI / 1024.0);
    barrier();
    for (uint stride = uint(PEL_GROUP_LINE) / 2u; stride > 0u; stride >>= 1u) {
        if (lane < stride) {
            partial[lane] += partial[lane + stride];
        }
        barrier();
    }
    if (lane == 0u) {
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
        veil_lights_evenly();
#endif
        vec3 clear = vec3(0.0), direct = vec3(0.0), left = vec3(0.0);
        for (int i = 0; i < PEL_LIT; i++) {
            clear += out_skies[i].rgb;
            vec3 one = out_beams[i].rgb * max(lights[i].direction.z, 0.0);
            direct += one;
            left += one * beam_share(i);
        }
        vec3 share = partial[0] / max(clear, vec3(1e-20));
        for (int i = 0; i < PEL_LIT; i++) {
            out_skies[i].rgb *= share;
        }
        vec3 now = left + partial[0];
        out_sea.rgb *= now / max(direct + clear, vec3(1e-20));
        // How much brighter the sky is than without them.
        out_incident = vec4(illuminance(now), share);
    }
}
