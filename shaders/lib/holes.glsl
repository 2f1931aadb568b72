// Holes of alpha-tested textures: what the rasterisers of objects leave out.
// Includers have lib/model.glsl.
#include "lib/paint.glsl"

layout(binding = PEL_UNIT_OBJECT_MATERIALS) uniform samplerBuffer object_materials;

// Whether a texture has a hole at uv; `wide`: of what is seen there, in uv;
// `part`: 0 to 1, which share of what is wider than a texel must be there. Of
// what is narrower half must be, as a ray has it.
bool hole_at(uint material, vec2 uv, float wide, float part)
{
    vec4 finish = texelFetch(object_materials, int(material) * PEL_OBJECT_MATERIAL_TEXELS + 1);
    if (finish.w == 0.0) {
        return false;
    }
    int packed_ = int(finish.w) - 1;
    float texels = wide * exp2(float(max(packed_ % PEL_PAINT_SIZES, packed_ / PEL_PAINT_SIZES)));
    return paint_at(finish.zw, uv, wide).a < mix(0.5, part, clamp(texels - 0.5, 0.0, 1.0));
}

// The same where the pixel's ray meets an entity's triangle, whatever the
// rasteriser's own corners are.
bool hole_on_ray(uvec2 number, vec3 ray, float part)
{
    placed o = placed_object(int(number.x) - 1);
    uvec4 corners = texelFetch(object_triangles, int(number.y));
    vec3 p[3];
    vec2 uvs[3];
    for (int i = 0; i < 3; i++) {
        int first = int(corners[i]) * PEL_OBJECT_VERTEX_TEXELS;
        p[i] = object_point(o, texelFetch(object_vertices, first).xyz);
        uvs[i] = texelFetch(object_vertices, first + 1).zw;
    }
    vec3 weight = vec3(dot(ray, cross(p[1], p[2] - p[1])), dot(ray, cross(p[2], p[0] - p[2])),
                       dot(ray, cross(p[0], p[1] - p[0])));
    float sum = weight.x + weight.y + weight.z;
    weight = clamp(sum == 0.0 ? vec3(1.0 / 3.0) : weight / sum, 0.0, 1.0);
    weight /= weight.x + weight.y + weight.z;
    vec3 place = weight.x * p[0] + weight.y * p[1] + weight.z * p[2];
    vec3 face = cross(p[1] - p[0], p[2] - p[0]);
    vec2 along = uvs[1] - uvs[0];
    vec2 across = uvs[2] - uvs[0];
    float per_m = sqrt(abs(along.x * across.y - along.y * across.x) * inversesqrt(max(dot(face, face), 1e-20)));
    float facing = abs(dot(normalize(face), normalize(place)));
    float wide = per_m * length(place) * pixel.y * inversesqrt(max(facing, 1e-3));
    return hole_at(corners.w, uvs[0] + weight.y * along + weight.z * across, wide, part);
}
