// What objects leave of the Sun.
layout(binding = PEL_UNIT_OBJECT_SHADOWS) uniform sampler2DArrayShadow object_shadows;

// The place in the shadow's layer of a point d from the entity's origin, and its
// depth; false: the layer does not hold it.
bool shadow_place(int i, vec3 d, out vec3 at)
{
    vec4 x = place_texel(i, 5);
    vec4 y = place_texel(i, 6);
    vec4 z = place_texel(i, 7);
    vec4 p = vec4(d, 1.0);
    at = vec3(dot(x, p), dot(y, p), min(dot(z, p), 1.0));
    // Its part of the layer ends at twice its middle.
    return max(abs(at.x - x.w), abs(at.y - y.w)) < x.w;
}

// Share of the Sun that the entity's own shadow leaves at d, from its origin,
// with the normal n.
float lit_share(int i, vec3 d, vec3 n)
{
    float layer = object_facts(i).w;
    vec4 x = place_texel(i, 5);
    // A step off the surface, of two texels and a half: what a texel leans by there.
    float texel = inversesqrt(max(dot(x.xyz, x.xyz), 1e-12)) / float(PEL_SHADOW_SIZE);
    vec3 at;
    if (layer < 0.0 || !shadow_place(i, d + n * (2.5 * texel), at)) {
        return 1.0;
    }
    const float APART = 0.5 / float(PEL_SHADOW_SIZE);
    float sum = 0.0;
    for (int k = 0; k < 4; k++) {
        vec2 off = vec2(k & 1, k >> 1) * 2.0 - 1.0;
        sum += texture(object_shadows, vec4(at.xy + off * APART, layer, at.z));
    }
    return 0.25 * sum;
}

// Share of the Sun that other entities leave there; `place`: from the eye.
float lit_by_others(int i, vec3 place)
{
    float share = 1.0;
    for (int left = int(place_texel(i, 10).w); left != 0; left &= left - 1) {
        int other = findLSB(left);
        vec3 at;
        bool held = shadow_place(other, from_object(placed_object(other), place), at);
        share *= held ? texture(object_shadows, vec4(at.xy, float(other), at.z)) : 1.0;
    }
    return share;
}
