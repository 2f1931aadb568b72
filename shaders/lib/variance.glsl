// What a footprint leaves to the BRDF: total minus resolved (eq. 4), from the
// table of pel_sea_slopes_left (ocean/filter.h).

layout(binding = PEL_UNIT_VARIANCE) uniform samplerBuffer variance_texels; // an entry and the next

// Slope variance along and across the wind.
vec2 variance_left(float footprint)
{
    float octaves = log2(footprint) - PEL_VARIANCE_FIRST;
    float place = clamp(octaves * PEL_VARIANCE_STEPS, 0.0, float(PEL_VARIANCE_COUNT) - 1.001);
    int entry = int(place);
    vec4 around = texelFetch(variance_texels, entry);
    return mix(around.xy, around.zw, place - float(entry));
}

#ifdef PEL_FOAM
// Standard deviation that a footprint leaves of what breaks (pel_foam_left).
float foam_left(float footprint)
{
    float octaves = log2(footprint) - PEL_VARIANCE_FIRST;
    float place = clamp(octaves * PEL_VARIANCE_STEPS, 0.0, float(PEL_VARIANCE_COUNT) - 1.001);
    vec4 around = texelFetch(variance_texels, int(place) + PEL_VARIANCE_COUNT - 1);
    return mix(around.x, around.z, fract(place));
}
#endif
