#version 450 core
// The light on the sea, from the sky table of sea level.
#include "lib/blocks.h"
#include "lib/sky.glsl"

layout(local_size_x = 64) in;
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
layout(binding = PEL_UNIT_SKY_TABLE) uniform sampler2DArray sky_table;
layout(std430, binding = PEL_STORE_LIGHT) writeonly buffer out_block {
    vec4 out_incident;
    vec4 out_sea; // by water_map.comp
    vec4 out_beams[PEL_LIGHTS];
    vec4 out_skies[PEL_LIGHTS];
    vec4 out_open_sky;
};

shared vec3 partial[64];

float illuminance(vec3 e)
{
    return dot(vec3(0.2126, 0.7152, 0.0722), vec3(dot(red.rgb, e), dot(green.rgb, e), dot(blue.rgb, e)));
}

// Light of the sky of one light on the level plane, to invocation 0.
vec3 gather(int i, uint lane)
{
    vec2 table = vec2(textureSize(sky_table, 0).xy);
    vec3 sum = vec3(0.0);
    // E = 2 ∫∫ L sin e cos e de dφ over half the azimuths; e = π/2 x².
    for (uint k = lane; k < 1024u; k += 64u) {
        float azimuth = PI * (float(k & 31u) + 0.5) / 32.0;
        float x = (float(k >> 5u) + 0.5) / 32.0;
        float e = 0.5 * PI * x * x;
        vec3 radiance = textureLod(sky_table, vec3(sky_uv(azimuth, e, table), i), 0.0).rgb;
        sum += radiance * (sin(e) * cos(e) * PI * x);
    }
    barrier(); // the last light's sums have been read
    partial[lane] = sum * (2.0 * PI / 1024.0);
    barrier();
    for (uint stride = 32u; stride > 0u; stride >>= 1u) {
        if (lane < stride) {
            partial[lane] += partial[lane + stride];
        }
        barrier();
    }
    return partial[0];
}

void main()
{
    uint lane = gl_LocalInvocationID.x;
    float level = 0.0;
#ifdef PEL_FOG
    vec3 above = vec3(0.0), straight = vec3(0.0);
#endif
    for (int i = 0; i < PEL_LIT; i++) {
        vec3 sky = gather(i, lane);
        vec4 to = lights[i].direction;
        vec3 direct = lights[i].irradiance.rgb *
                      light_transmittance(transmittance, 0.0, to.z, to.w);
        level += illuminance(sky + direct * max(to.z, 0.0));
#ifdef PEL_FOG
        above += sky;
        straight += direct * max(to.z, 0.0);
#endif
        if (lane == 0u) {
            out_beams[i] = vec4(direct, 0.0);
            out_skies[i] = vec4(sky, 0.0);
        }
    }
    if (lane == 0u) {
        out_incident = vec4(level, 0.0, 0.0, 0.0);
#ifdef PEL_FOG
#ifdef PEL_CLOUDS
        // What they let through, less what of it is the beams'.
        above = max((above + straight) * cloud_light.x - straight * cloud_light.y, vec3(0.0));
#endif
        out_open_sky = vec4(above, 0.0);
#endif
    }
}
