#version 450 core
// The environment the sea reflects, in stereographic projection: the zenith
// at the centre, the horizon on the circle of radius 1 (section 5.2 of the
// 2010 paper). Beyond it is the horizon's, so that a footprint that reaches
// over it has what escapes; what waves show of waves is in second.frag.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"

layout(location = 0) out vec4 radiance;
layout(binding = PEL_UNIT_SKY_TABLE) uniform sampler2DArray sky_table;
#ifdef PEL_PANORAMA
#include "lib/panorama.glsl"
#endif
#ifdef PEL_NIGHT
#include "lib/night.glsl"
#endif
#ifdef PEL_CLOUDS
layout(binding = PEL_UNIT_TRANSMITTANCE) uniform sampler2D transmittance;
#endif
layout(location = 0) uniform vec2 map; // size in px, half width in units

void main()
{
    vec2 u = (gl_FragCoord.xy / map.x * 2.0 - 1.0) * map.y;
    float rho2 = dot(u, u);
    vec3 dir = vec3(2.0 * u, 1.0 - rho2) / (1.0 + rho2);
    float elevation = asin(clamp(dir.z, 0.0, 1.0));
#ifdef PEL_PANORAMA
    vec3 light = panorama_at(dir.xy, 0.5 * PI - elevation, elevation, 0.02);
#else
    vec3 light = sky_light(sky_table, dir.xy, elevation);
#endif
#ifdef PEL_NIGHT
    light = max(light + night_off(dir), vec3(0.0));
#endif
#ifdef PEL_CLOUDS
    // Not lower than half a texel above the horizon.
    dir.z = max(dir.z, 0.01);
    light = clouded_sky(clouds_toward(transmittance, normalize(dir), light, through_sky(transmittance, normalize(dir)), 0.02, 1e9), light);
#endif
#ifdef PEL_FOG
    light = foggy_sky(fog_toward(vec3(0.0), normalize(vec3(dir.xy, max(dir.z, 0.01))), 1e7), light);
#endif
    radiance = vec4(light, 1.0);
}
