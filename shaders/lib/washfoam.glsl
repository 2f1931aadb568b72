// Foam and bubbles of the wash of ships, as a pixel sees them.

// As foam_of: x the share that dense foam hides, y how bright it is. Whitecaps'
// structure and a second tile of it, coarser, together.
vec2 wash_foam(vec2 x, float foam, float footprint)
{
    if (foam < 1e-3) {
        return vec2(0.0, 1.0);
    }
    float odds = foam / (1.0 - foam);
    // S⁻¹, by Newton's steps.
    float l = log(odds);
    float bound = 0.6 * l;
    bound -= (bound * (1.5976 + 0.070565 * bound * bound) - l) / (1.5976 + 0.211695 * bound * bound);
    bound -= (bound * (1.5976 + 0.070565 * bound * bound) - l) / (1.5976 + 0.211695 * bound * bound);
    float far = 4.0 * PEL_FOAM_GRAIN_SEEN_M;
    if (footprint > far) {
        return vec2(foam, 1.0);
    }
    float texels = float(PEL_FOAM_GRAIN) * footprint;
    const float w = PEL_WASH_GRAIN_WEIGHT;
    vec2 n = grain_at(x / PEL_FOAM_GRAIN_M + wash_grain.xy, texels / PEL_FOAM_GRAIN_M);
    vec2 torn = grain_at(x / PEL_WASH_GRAIN_M + wash_grain.zw, texels / PEL_WASH_GRAIN_M);
    n = vec2(sqrt(1.0 - w * w), 1.0 - w * w) * n + vec2(w, w * w) * torn;
    float seen = clamp(2.0 - 2.0 * footprint / far, 0.0, 1.0);
    n = vec2(seen * n.x, 1.0 - seen * seen * (1.0 - n.y));
    float share = foam_share((bound * sqrt(1.0 + PEL_FOAM_THIN) - n.x) * inversesqrt(n.y + PEL_FOAM_THIN));
    float thicker = min(foam_share(n.x) / foam, 1.0);
    return vec2(share, 1.0 + PEL_FOAM_RELIEF * (1.0 - n.y) * (1.0 - 2.0 * thicker));
}

// Both foams on one water: whitecaps' a, b of the wash.
vec2 foams_together(vec2 a, vec2 b)
{
    float all = a.x + b.x - a.x * b.x;
    float of_a = a.x / max(a.x + b.x, 1e-6);
    return b.x > 0.0 ? vec2(all, mix(b.y, a.y, of_a)) : a; // the same bits beside the wash
}

// What bubbles under the surface send up, of Sun and sky.
vec3 light_of_bubbles(float bubbles, vec2 tilt)
{
    vec3 falling = vec3(0.0);
    for (int i = 0; i < PEL_LIT; i++) {
        falling += beam_there(i) * max(light_above(i, tilt).z, 0.0) + skies[i].rgb;
    }
    return bubbles * wash_water.rgb * falling;
}
