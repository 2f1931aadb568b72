// Waves over a bottom that they feel, twin of ocean/shore.h.
// Includers have lib/spline.glsl.

#ifdef PEL_FFT
layout(binding = PEL_UNIT_SHORE_OF_CASCADES) uniform sampler2DArray shore_nodes;
#else
layout(binding = PEL_UNIT_SHORE_OF_WAVES) uniform sampler2DArray shore_nodes;
#endif

// What a band's waves are at a place of rest x, from the eye's nadir.
struct shored {
    vec2 read;   // the place that they are read at
    vec2 to;     // their direction far out
    vec2 slope;  // of s
    vec2 higher; // gradient of a
    float a;     // what heights are times
    float b;     // and horizontal displacements
    float breaks;
};

shored far_out(vec2 x)
{
    return shored(x, vec2(0.0), vec2(0.0), vec2(0.0), 1.0, 1.0, 0.0);
}

shored shore_at(int band, vec2 x)
{
    shored here = far_out(x);
    vec2 at = x * shore_grid.z + shore_grid.xy;
    if (any(lessThan(at, vec2(1.0))) || any(greaterThanEqual(at, shore_size.xy - 2.0))) {
        return here;
    }
    ivec2 i = ivec2(at);
    vec2 w[4];
    vec2 d[4];
    cubic_spline(at - vec2(i), w, d);
    vec4 value = vec4(0.0);
    vec2 by_x = vec2(0.0);
    vec2 by_y = vec2(0.0);
    for (int q = 0; q < 4; q++) {
        for (int p = 0; p < 4; p++) {
            vec4 t = texelFetch(shore_nodes, ivec3(i + ivec2(p - 1, q - 1), band), 0);
            value += w[p].x * w[q].y * t;
            by_x += d[p].x * w[q].y * t.xy;
            by_y += w[p].x * d[q].y * t.xy;
        }
    }
    here.to = shore_bands[band].xy;
    here.read = x + value.x * here.to;
    here.slope = vec2(by_x.x, by_y.x) * shore_grid.z;
    here.higher = vec2(by_x.y, by_y.y) * shore_grid.z;
    here.a = 1.0 + value.y;
    here.b = 1.0 + value.z;
    here.breaks = value.w;
    return here;
}

// A gradient by the place of reading as one by the place of rest.
vec2 shore_gradient(shored here, vec2 g)
{
    return g + dot(here.to, g) * here.slope;
}
