// What a footprint leaves to the BRDF: total minus resolved (eq. 4), from tables
// of pel_sea_slopes_left (ocean/filter.h).

layout(std430, binding = PEL_STORE_VARIANCE) restrict readonly buffer variance_block { vec2 variance_table[]; };
layout(binding = PEL_UNIT_VARIANCE) uniform sampler3D variance_by_azimuth;

// Slope variance along and across the wind.
vec2 variance_left(vec2 sight, float along, float across)
{
    float octaves = log2(along) - PEL_VARIANCE_FIRST;
#if PEL_ANISOTROPY > 1
    vec2 turned = vec2(dot(sight, wind.xy), sight.y * wind.x - sight.x * wind.y);
    float azimuth = (turned.y < 0.0 ? -1.0 : 1.0) * fast_acos(turned.x) / PI;
    vec3 place = vec3(octaves * PEL_LENGTH_STEPS, log2(along / across) * PEL_ASPECT_STEPS,
                      azimuth * float(PEL_AZIMUTH_COUNT));
    return textureLod(variance_by_azimuth, (place + 0.5) / vec3(textureSize(variance_by_azimuth, 0)), 0.0).xy;
#else
    float place = clamp(octaves * PEL_VARIANCE_STEPS, 0.0, float(PEL_VARIANCE_COUNT) - 1.001);
    int entry = int(place);
    return mix(variance_table[entry], variance_table[entry + 1], place - float(entry));
#endif
}
