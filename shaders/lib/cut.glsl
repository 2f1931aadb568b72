// The sea's mesh as shading reads it.

// The vertices, two texels each: software devices read a texel of four at once,
// the members of a storage buffer one by one and lane by lane.
layout(binding = PEL_UNIT_VERTICES) uniform samplerBuffer vertex_texels;

vec4 vertex_position(int i)
{
    return texelFetch(vertex_texels, 2 * i);
}

vec2 vertex_rest(int i)
{
    return texelFetch(vertex_texels, 2 * i + 1).xy;
}

// A triangle of the mesh, cut by a ray.
struct cut {
    vec2 x;     // place at rest
    float t;    // distance, in lengths of the ray
    vec3 facet; // the triangle's normal
};

// In homogeneous barycentrics.
cut cut_triangle(vec3 ray, uint triangle)
{
    uint id = max(triangle, 1u) - 1u;
    int i0 = int(id >> 1u);
    vec4 a4 = vertex_position(i0);
    int columns = int(a4.w);
    int i2 = (id & 1u) == 1u ? i0 - columns : i0 + columns - 1;
    vec3 a = a4.xyz;
    vec3 b = vertex_position(i0 - 1).xyz;
    vec3 c = vertex_position(i2).xyz;
    vec3 weight = vec3(dot(ray, cross(b, c - b)), dot(ray, cross(c, a - c)),
                       dot(ray, cross(a, b - a)));
    weight = clamp(weight / (weight.x + weight.y + weight.z), 0.0, 1.0);
    weight /= weight.x + weight.y + weight.z;
    cut result;
    result.x = weight.x * vertex_rest(i0) + weight.y * vertex_rest(i0 - 1) +
               weight.z * vertex_rest(i2);
    result.t = -dot(weight.x * a + weight.y * b + weight.z * c, back.xyz);
    result.facet = normalize(cross(b - a, c - a));
    return result;
}
