// The sea's mesh as shading reads it.
#include "lib/together.glsl"

// The vertices, two texels each: software devices read a texel of four at once,
// the members of a storage buffer one by one and lane by lane. Of hardware it
// depends on what else is read: with trochoids a buffer takes a fifth off all of
// shading, with cascades it adds a tenth.
#if defined(PEL_STORED) && !defined(PEL_FFT)
layout(std430, binding = PEL_STORE_NET) restrict readonly buffer net_block { vec4 net_words[]; };
#define NET_WORD(i) net_words[i]
#else
layout(binding = PEL_UNIT_VERTICES) uniform samplerBuffer vertex_texels;
#define NET_WORD(i) texelFetch(vertex_texels, i)
#endif

vec4 vertex_position(int i)
{
    return NET_WORD(2 * (FIRST_VERTEX + i));
}

// Its place at rest, its flags and its ring.
vec4 vertex_rest(int i)
{
    return NET_WORD(2 * (FIRST_VERTEX + i) + 1);
}

const int NO_STRIP = 1 << 20; // that of the sky

// The inner ring of a triangle's strip.
int strip_of(uint triangle)
{
    return triangle == 0u ? NO_STRIP : int(NET_WORD(2 * FIRST_VERTEX + int(triangle - 1u | 1u)).w);
}

// A triangle of the mesh, cut by a ray.
struct cut {
    vec2 x;     // place at rest
    float t;    // distance, in lengths of the ray
    vec3 facet; // the triangle's normal
    float cell; // the length of the mesh's cell
};

// In homogeneous barycentrics.
cut cut_triangle(vec3 ray, uint triangle)
{
    uint id = max(triangle, 1u) - 1u;
    int i = int(id >> 1u);
    bool outer = (id & 1u) == 1u; // its first corner lies on the outer ring
    vec4 one = vertex_position(i);
    int other = i + int(one.w) - (outer ? 0 : 1);
    int i0 = outer ? other : i;
    int i2 = outer ? i : other;
    vec3 two = vertex_position(other).xyz;
    vec3 a = outer ? two : one.xyz;
    vec3 b = vertex_position(i0 - 1).xyz;
    vec3 c = outer ? one.xyz : two;
    vec3 weight = vec3(dot(ray, cross(b, c - b)), dot(ray, cross(c, a - c)),
                       dot(ray, cross(a, b - a)));
    weight = clamp(weight / (weight.x + weight.y + weight.z), 0.0, 1.0);
    weight /= weight.x + weight.y + weight.z;
    cut result;
    vec2 first = vertex_rest(i0).xy, last = vertex_rest(i2).xy;
    result.x = weight.x * first + weight.y * vertex_rest(i0 - 1).xy + weight.z * last;
    result.cell = abs(length(first) - length(last));
    result.t = -dot(weight.x * a + weight.y * b + weight.z * c, back.xyz);
    result.facet = normalize(cross(b - a, c - a));
    return result;
}
