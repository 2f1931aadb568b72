// The samples of a pixel (render/samples.h).
layout(binding = PEL_UNIT_OBJECT_SAMPLES) uniform usampler2DMS object_samples;

// Where in its pixel a sample lies, as the drivers have it.
vec2 sample_place(int i)
{
    return (vec2(i == 0 ? 3.0 : i == 1 ? 7.0 : i == 2 ? 1.0 : 5.0, i == 0 ? 1.0 : i == 1 ? 3.0 : i == 2 ? 5.0 : 7.0)) *
           0.125;
}

// An object's triangle; its bit: the ray meets the inner side.
const uint SAMPLE_INNER = 0x80000000u;
