// What the shading of a pixel gives.
struct shaded {
    vec3 radiance;
#ifdef PEL_LAYERS
    float depth;
    vec3 normal;
#endif
};

layout(binding = 3) uniform sampler2D eye_table;
