#version 450 core
// Rasterises what of an entity stands above the sea as an eye in the water sees
// it through a level surface: each corner where its light comes from.
#define PEL_UNDER
#include "lib/blocks.h"
#include "lib/model.glsl"

layout(location = 0) uniform ivec2 drawn;  // entity, first triangle
layout(location = 1) uniform vec3 window_; // place on the lattice of its corner, 1 / half its side

flat out uvec2 number;
out float height; // above the surface

const float NEAR = 0.05;

// How far away light of a point `high` above the surface and `away` m aside
// comes through it, to an eye `deep` below: by Snell's law, found by halves.
float comes_through(float deep, float high, float away)
{
    float low = 0.0, most = away;
    for (int i = 0; i < 22; i++) {
        float x = 0.5 * (low + most);
        float air = (away - x) * inversesqrt((away - x) * (away - x) + high * high);
        float inside = x * inversesqrt(x * x + deep * deep);
        bool nearer = air > PEL_WATER_INDEX * inside;
        low = nearer ? x : low;
        most = nearer ? most : x;
    }
    return 0.5 * (low + most);
}

void main()
{
    int triangle = drawn.y + gl_VertexID / 3;
    uvec4 corners = texelFetch(object_triangles, triangle);
    vec3 p = object_point(placed_object(drawn.x),
                          texelFetch(object_vertices, int(corners[gl_VertexID % 3]) * PEL_OBJECT_VERTEX_TEXELS).xyz);
    float deep = max(under_drift.x, 0.02);
    height = p.z - deep;
    if (height > 0.0) {
        float away = length(p.xy);
        float x = comes_through(deep, height, away);
        vec2 aside = away > 1e-4 ? p.xy / away : vec2(0.0);
        vec3 sight = normalize(vec3(aside * x, deep));
        p = sight * (length(vec2(x, deep)) + length(vec2(away - x, height)));
    }
    vec3 c = vec3(dot(p, right.xyz), -dot(p, up.xyz), -dot(p, back.xyz));
    vec2 place = c.xy / pixel.xy;
    gl_Position = vec4((place - window_.xy * c.z) * window_.z - c.z, NEAR, c.z);
    number = uvec2(drawn.x + 1, triangle);
}
