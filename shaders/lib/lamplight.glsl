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
    ivec2 tile = clamp((at + ivec2(0, int(head.y)) - int(head.z & 0xFFFFu)) / PEL_GLOW_TILE, ivec2(0), last);
    int word = tile.y * int(head.x) + tile.x;
    lamps_here = texelFetch(lamp_glows, 1 + PEL_GLOW_TEXELS * 32 + word / 4)[word & 3];
}

// Slopes², by the variance of the steepest, beyond which what a lamp shows is too
// faint for any eye; by its luminance at 1 m, the square of its distance, and the
// sum of the unit directions to it and to the eye.
float lamp_reaches(float intensity, float away2, vec3 sum)
{
    float dull = 1.0 - min(0.5 * sqrt(dot(sum, sum)), 1.0), dull2 = dull * dull;
    float mean = PEL_LAMP_MEAN * inversesqrt(wind.z * wind.w + 1e-12);
    float times = intensity * mean * (PEL_LAMP_DULLEST + dull2 * dull2 * dull) / away2;
    return 2.0 * log(times);
}

// Those of them that can be seen mirrored, estimated from above: most pixels have
// no facet that does it.
uint lamps_likely(vec3 v, vec2 tilt, vec3 tx, vec3 ty, vec3 n, vec3 view, vec2 variance, vec2 drawn, vec2 held,
                  float fold, patch_frame frame_, sight_along eye_)
{
    vec3 across = tx * view.x + ty * view.y;
    vec3 toward = across * (eye_.steeper / eye_.level);
    vec2 level = n.xy / max(n.z, 0.05);
    vec2 spread = variance - held + 1e-7, narrow_all = 1.0 / (variance + 1e-7);
    float along_z = 1.0 / (eye_.level * eye_.deviation), first_z = eye_.steeper / eye_.deviation;
    float narrower = PEL_SEEN_NARROWER / (1.0 + 0.25 * eye_.mu * eye_.mu);
    float steepest = 1.0 / (max(wind.z, wind.w) + 1e-6);
    // 4: of what reflected_light has besides.
    float denser = 2.0 * log(4.0 * 0.05 / (eye_.cosine + eye_.term) *
                             sqrt(wind.z * wind.w / (spread.x * spread.y)) + 1e-6);
    float wider = 0.0625 * lamps_footprint * lamps_footprint;
    vec2 side = vec2(-wind.y, wind.x);
#ifdef PEL_HARDWARE
    return lamps_here; // hardware is faster without
#endif
    uint likely = 0u; // all of them at once costs less than each in its turn
    for (uint left = lamps_here; left != 0u; left &= left - 1u) {
        vec4 place = glow_texel(findLSB(left), 0);
        vec3 way = place.xyz - lamps_from;
        float away2 = dot(way, way);
        vec3 dir = way * inversesqrt(away2);
        vec3 to = vec3(dir.xy - tilt * dir.z, dir.z + dot(tilt, dir.xy));
        vec3 sum = v + to;
        float reaches = lamp_reaches(place.w, away2, sum);
        float most = min(reaches, PEL_LAMP_SLOPES * PEL_LAMP_SLOPES);
        bool open = to.z > 0.0 && dot(sum.xy, sum.xy) * steepest < sum.z * sum.z * most;
        // As reflected_light, less what is near 1.
        float rise = 1.0 / max(dot(sum, n), 1e-3);
        vec3 facet = sum * rise - toward;
        vec2 slope = facet.xy / max(facet.z, 0.05);
        vec2 d = slope - level;
        vec2 rest = vec2(dot(frame_.pressed.xy, d), dot(frame_.pressed.zw, d));
        vec2 own = vec2(dot(rest, wind.xy), dot(rest, side)), own2 = own * own, off = own + drawn;
        float both = dot(rest, slope);
        float along = fold * (0.33333333 * dot(slope, slope) +
                              0.66666667 * both * both / max(own2.x + own2.y, 1e-12));
        float z = dot(across, sum) * rise * along_z - first_z;
        float odds = min(dot(own2, narrow_all) * along / (1.0 + along), 32.0) - dot(off * off, 1.0 / (spread + wider / away2)) -
                     narrower * z * z;
        // Of wide ones it says nothing.
        likely |= place.w < 0.0 || (open && odds + denser + reaches > 0.0) ? left & (0u - left) : 0u;
    }
    return likely;
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
    vec4 form = glow_texel(lamp, 4);
    float wide = form.y / away;
    float reaches = place.w < 0.0 ? PEL_LAMP_SLOPES * PEL_LAMP_SLOPES
                                  : clamp(lamp_reaches(place.w, away * away, sum), 1e-3, PEL_LAMP_SLOPES * PEL_LAMP_SLOPES);
    float most = (sqrt(max(wind.z, wind.w) + 1e-6) + wide) * sqrt(reaches);
    float window = clamp(4.0 * (1.0 - length(sum.xy) / (max(sum.z, 1e-6) * most)), 0.0, 1.0);
    float strength = lamp_towards(-dir, light, glow_texel(lamp, 2), glow_texel(lamp, 3), form.x) *
                     (to.z > 0.0 ? window : 0.0) * exp(-form.w * away) / (away * away);
    float part = 0.25 * lamps_footprint / away;
    return light.rgb * strength *
           reflected_light(view, vec3(dot(to, tx), dot(to, ty), dot(to, n)), variance, 1e-7 + part * part + wide * wide,
                           drawn, held, fold, frame_, eye_);
}
#endif
