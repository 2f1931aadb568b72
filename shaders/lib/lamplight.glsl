// Lamps that the sea mirrors (render/lampglow.h), by the term of the lights of
// the sky. Includers have lib/ross.glsl.
#include "lib/lampbeam.glsl"
#ifdef PEL_LAMPS
vec3 lamps_from = vec3(0.0); // the place that is shaded, from the eye
float lamps_footprint = 0.0;
uint lamps_here = 0u; // a bit a lamp

// Which may be mirrored in the tile of a pixel.
void lamps_about(ivec2 at)
{
    uvec4 head = texelFetch(lamp_glows, 0);
    ivec2 last = ivec2(head.x, head.w) - 1;
    ivec2 tile = clamp((at + ivec2(0, int(head.y)) - int(head.z & 0xFFFFu)) / 64, ivec2(0), last);
    int word = tile.y * int(head.x) + tile.x;
    lamps_here = texelFetch(lamp_glows, 1 + PEL_GLOW_TEXELS * 32 + word / 4)[word & 3];
}

// Of one lamp, its radiance mirrored to the eye; v, tilt: of the patch.
vec3 lamp_mirrored(int lamp, vec3 v, vec2 tilt, vec3 tx, vec3 ty, vec3 n, vec3 view, vec2 variance,
                   vec2 drawn, vec2 held, float fold, patch_frame frame_, sight_along eye_)
{
    vec4 place = glow_texel(lamp, 0), light = glow_texel(lamp, 1);
    vec3 way = place.xyz - lamps_from;
    float away = sqrt(dot(way, way));
    vec3 dir = way / away;
    vec3 to = vec3(dir.xy - tilt * dir.z, dir.z + dot(tilt, dir.xy));
    vec3 sum = v + to;
    // Steeper slopes than these there are none of, so that tiles may leave it out.
    vec4 form = glow_texel(lamp, 4);
    float wide = form.y / away;
    float most = PEL_LAMP_SLOPES * (sqrt(max(wind.z, wind.w) + 1e-6) + wide);
    float window = clamp(PEL_LAMP_SLOPES * (1.0 - length(sum.xy) / (max(sum.z, 1e-6) * most)), 0.0, 1.0);
    float strength = lamp_towards(-dir, light, glow_texel(lamp, 2), glow_texel(lamp, 3), form.x) *
                     (to.z > 0.0 ? window : 0.0) * exp(-place.w * away) / (away * away);
    float part = 0.25 * lamps_footprint / away;
    return light.rgb * strength *
           reflected_light(view, vec3(dot(to, tx), dot(to, ty), dot(to, n)), variance, 1e-7 + part * part + wide * wide,
                           drawn, held, fold, frame_, eye_);
}
#endif
