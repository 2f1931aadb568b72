// Textures of objects (render/modelpaint.h): reflectances by square roots in
// bytes and the share that is no hole, four texels a texel of the triangles' buffer, each level of detail half
// as wide; a header says where it begins.

vec4 paint_texel(int first, int start, ivec2 bits, ivec2 at)
{
    ivec2 place = at & ((ivec2(1) << bits) - 1);
    int i = (place.y << bits.x) + place.x;
    vec4 root = unpackUnorm4x8(texelFetch(object_triangles, first + start + (i >> 2))[i & 3]);
    return vec4(root.rgb * root.rgb, root.a);
}

vec4 paint_level(int first, ivec2 size, int level, vec2 uv)
{
    int start = int(texelFetch(object_triangles, first + (level >> 2))[level & 3]);
    ivec2 bits = max(size - level, ivec2(0));
    vec2 at = uv * vec2(ivec2(1) << bits) - 0.5;
    ivec2 low = ivec2(floor(at));
    vec2 part = at - vec2(low);
    return mix(mix(paint_texel(first, start, bits, low), paint_texel(first, start, bits, low + ivec2(1, 0)), part.x),
               mix(paint_texel(first, start, bits, low + ivec2(0, 1)), paint_texel(first, start, bits, low + ivec2(1)), part.x),
               part.y);
}

// `wide`: of what the pixel sees, in uv. A float holds whole numbers to 2^24.
vec4 paint_at(vec2 texture_, vec2 uv, float wide)
{
    int first = int(texture_.x);
    int packed_ = int(texture_.y) - 1;
    ivec2 size = ivec2(packed_ % PEL_PAINT_SIZES, packed_ / PEL_PAINT_SIZES);
    float levels = float(max(size.x, size.y));
    float level = clamp(log2(max(wide, 1e-9)) + levels, 0.0, levels);
    int coarse = int(min(level, levels - 0.5));
    vec2 turns = fract(uv);
    return mix(paint_level(first, size, coarse, turns), paint_level(first, size, min(coarse + 1, int(levels)), turns),
               level - float(coarse));
}
