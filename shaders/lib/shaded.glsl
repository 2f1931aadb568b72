// What the shading of a pixel gives, and how it is written: the layers of
// render/renderer.h, in the order of their attachments.
struct shaded {
    vec3 radiance;
#ifdef PEL_LAYERS
    float depth;
    vec4 normal; // w: F̄
    vec3 sun, sky, water, air;
    vec2 variance;
#endif
#ifdef PEL_WATER_PARTS
    water_light parts; // of the light out of the water, as it reaches the eye
#endif
};

layout(binding = PEL_UNIT_EYE_TABLE) uniform sampler2DArray eye_table; // a layer a light

// What an eye under the surface sees: the water's own light, more from above.
vec3 from_under_water(vec3 radiance, float up)
{
    return lut.y > 0.5 ? sea_light.rgb * (PEL_WATER_INDEX * PEL_WATER_INDEX * (0.7 + 0.3 * up)) : radiance;
}
