// What a footprint leaves to the BRDF: total minus resolved (eq. 4), from the
// table of pel_sea_slopes_left (ocean/filter.h).

layout(std430, binding = PEL_STORE_VARIANCE) restrict readonly buffer variance_block { vec2 variance_table[]; };

// Slope variance along and across the wind.
vec2 variance_left(float footprint)
{
    float octaves = log2(footprint) - PEL_VARIANCE_FIRST;
    float place = clamp(octaves * PEL_VARIANCE_STEPS, 0.0, float(PEL_VARIANCE_COUNT) - 1.001);
    int entry = int(place);
    return mix(variance_table[entry], variance_table[entry + 1], place - float(entry));
}
