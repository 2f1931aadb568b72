// The shading of a pixel: `shaded`, made with its functions from
// proto/layers.def.
#include "lib/layers.glsl"

#ifdef PEL_LAYERS
// The layers of this pass, as bits by their places.
layout(location = PEL_UNIFORM_LAYERS) uniform uint pass_layers;

bool wants_layer(int layer)
{
    return (pass_layers >> layer & 1u) != 0u;
}
#endif
#ifdef PEL_WATER_PARTS
void set_parts(inout shaded s, water_light parts)
{
    s.water_single = parts.single;
    s.water_second = parts.second;
    s.water_higher = parts.higher;
    s.bottom = parts.bottom;
}
#endif

layout(binding = PEL_UNIT_EYE_TABLE) uniform sampler2DArray eye_table; // a layer a light
