// What the shading of a pixel gives.
struct shaded {
    vec3 radiance;
#ifdef PEL_LAYERS
    float depth;
    vec3 normal;
#endif
};

layout(binding = 3) uniform sampler2D eye_table;

// What an eye under the surface sees: the water's own light, more from above.
vec3 from_under_water(vec3 radiance, float up)
{
    return lut.y > 0.5 ? sea_light.rgb * (1.34 * 1.34 * (0.7 + 0.3 * up)) : radiance;
}
