// The lamps that shine most where the eye is (render/lampglow.h), and their
// light on things.
#include "lib/lamptowards.glsl"
#ifdef PEL_LAMPS
layout(binding = PEL_UNIT_LAMP_GLOWS) uniform usamplerBuffer lamp_glows;

vec4 glow_texel(int lamp, int i)
{
    return uintBitsToFloat(texelFetch(lamp_glows, 1 + PEL_GLOW_TEXELS * lamp + i));
}

// At a place, from the eye: the irradiance across the way to the lamp, and the
// unit direction to it.
vec3 lamp_falling(int lamp, vec3 place, out vec3 to)
{
    vec4 at = glow_texel(lamp, 0), light = glow_texel(lamp, 1);
    vec3 way = at.xyz - place;
    // No lamp is smaller than a hand.
    float away2 = max(dot(way, way), 0.01);
    to = way * inversesqrt(away2);
    vec4 form = glow_texel(lamp, 4);
    return light.rgb * (lamp_towards(-to, light, glow_texel(lamp, 2), glow_texel(lamp, 3), form.x) *
                        exp(-form.w * sqrt(away2)) / away2);
}

int lamps_known()
{
    return int(texelFetch(lamp_glows, 0).z >> 16u);
}

// On a face at a place, from the eye: by floods and beams, beside which
// navigation's lights are nothing.
vec3 lamps_on_face(vec3 place, vec3 n)
{
    vec3 sum = vec3(0.0);
    for (uint left = texelFetch(lamp_glows, PEL_GLOW_TEXELS).z; left != 0u; left &= left - 1u) {
        vec3 to;
        vec3 beam = lamp_falling(findLSB(left), place, to);
        sum += beam * max(dot(n, to), 0.0);
    }
    return sum;
}
#endif
