// Whitecaps, twin of ocean/foam.h: foam that a pixel sees where it resolves a
// part of the waves that break, its structure, and its light.

#ifdef PEL_FOAM
layout(binding = PEL_UNIT_FOAM) uniform sampler3D foam_table;
#endif
layout(binding = PEL_UNIT_FOAM_GRAIN) uniform sampler2D foam_grain;

// S, pel_foam_share.
float foam_share(float x)
{
    return 1.0 / (1.0 + exp(-x * (1.5976 + 0.070565 * x * x)));
}

// The structure of a tile: mean, and variance of what is left.
vec2 grain_at(vec2 uv, float texels)
{
    vec2 g = textureLod(foam_grain, uv, log2(max(texels, 1.0))).xy;
    return vec2(g.x, max(g.y - g.x * g.x, 0.0));
}

#ifdef PEL_FOAM
#ifdef PEL_SHORE
// The least bound where waves break on the bottom: on their crests, and what they
// leave behind.
float surf_bound(vec2 surf)
{
    float crest = smoothstep(-0.2, 0.6, surf.y);
    return mix(-5.0, mix(-0.9, 1.8, crest), smoothstep(0.0, 0.35, surf.x));
}

// The structure of surf is that of whitecaps and one of larger patches, or a tile
// would be seen over and over.
vec2 surf_grain(vec2 x, vec2 n, float texels, vec2 surf)
{
    vec2 at = (x * shore_grid.z + shore_grid.xy) / (shore_grid.z * PEL_FOAM_SURF_M);
    vec2 wide = grain_at(vec2(0.8 * at.x + 0.6 * at.y, 0.8 * at.y - 0.6 * at.x), texels / PEL_FOAM_SURF_M);
    float w = 0.75 * smoothstep(0.0, 0.35, surf.x);
    return vec2(sqrt(1.0 - w * w), 1.0 - w * w) * n + vec2(w, w * w) * wide;
}
#endif

// x: foam is where the structure, a normal number that belongs to the water at
// rest, is below a bound; of what a pixel averages over its variance is known.
// y: how bright it is, thick in the middle and thin at its edges, by the share
// of the foam there that is thicker: so its mean is 1. `up`: what an area has
// the short waves times; `surf`: how much breaks on the bottom, and the height of
// the waves there, m.
vec2 foam_of(vec2 x, vec2 breaking, float footprint, float up, vec2 surf)
{
    const float side = float(PEL_FOAM_SIDE);
    const float levels = float(PEL_FOAM_LEVELS);
    const float least = sqrt(PEL_FOAM_ALWAYS_LEFT);
    float left = (foam_left(footprint) - least) / (1.0 - least);
    vec3 place = vec3(breaking * (whitecaps.x * 0.5 / PEL_FOAM_REACH) + 0.5, left);
    vec3 nodes = vec3(side, side, levels);
    float bound = textureLod(foam_table, (clamp(place, 0.0, 1.0) * (nodes - 1.0) + 0.5) / nodes, 0.0).x;
#ifdef PEL_AREAS
    // Slopes grow with the wind, and foam with its power: by so much, to first
    // order in the logarithm of the odds.
    bound += PEL_AREA_FOAM * log(max(up, 0.05)) / (1.5976 + 0.211695 * bound * bound);
#endif
#ifdef PEL_SHORE
    bound = max(bound, surf_bound(surf));
#endif
    // Too little, or too far, to see its structure.
#ifdef PEL_STREAKS
    float low = 1.0 - smoothstep(-2.0, 0.5, bound); // no crest's
    float w = whitecaps.y * (0.3 + 0.7 * low);
    float far = PEL_FOAM_GRAIN_SEEN_M * (1.0 + 4.0 * whitecaps.y);
#else
    const float far = PEL_FOAM_GRAIN_SEEN_M;
#endif
    if (bound < -3.2 || footprint > far) {
        return vec2(foam_share(bound), 1.0);
    }
    float texels = float(PEL_FOAM_GRAIN) * footprint;
    vec2 run = vec2(dot(x, wind.xy), dot(x, vec2(-wind.y, wind.x)));
    vec2 place_in = run * vec2(whitecaps.z, 1.0 / PEL_FOAM_GRAIN_M) + grain.xy;
    vec2 n = grain_at(place_in, texels / PEL_FOAM_GRAIN_M);
#ifdef PEL_STREAKS
    float bend = run.x / PEL_FOAM_BEND_ALONG_M + run.y / PEL_FOAM_BEND_ACROSS_M + bends.x;
    run.y += PEL_FOAM_STREAK_BEND_M * sin(2.0 * PI * fract(bend));
    vec2 streak = grain_at(run / vec2(PEL_FOAM_STREAK_ALONG_M, PEL_FOAM_STREAK_ACROSS_M) + grain.zw,
                           texels / PEL_FOAM_STREAK_ACROSS_M);
    n = vec2(sqrt(1.0 - w * w), 1.0 - w * w) * n + vec2(w, w * w) * streak;
#endif
#ifdef PEL_SHORE
    n = surf_grain(x, n, texels, surf);
#endif
    float seen = clamp(2.0 - 2.0 * footprint / far, 0.0, 1.0);
    n = vec2(seen * n.x, 1.0 - seen * seen * (1.0 - n.y));
    // Edges of foam are thin, or torn about.
    float thin = crests.z;
#ifdef PEL_STREAKS
    thin += PEL_FOAM_STREAK_THIN * low;
#endif
    // From near, that is the same structure, finer and turned.
    float torn = thin - PEL_FOAM_THIN;
    vec2 fine = vec2(0.0, 1.0);
    if (torn > 0.0 && footprint < PEL_FOAM_FINE_SEEN_M) {
        const vec2 turn = vec2(PEL_FOAM_FINE_A, PEL_FOAM_FINE_B);
        fine = grain_at(vec2(turn.x * place_in.x - turn.y * place_in.y, turn.y * place_in.x + turn.x * place_in.y),
                        length(turn) * texels / PEL_FOAM_GRAIN_M);
        float part = clamp(2.0 - 2.0 * footprint / PEL_FOAM_FINE_SEEN_M, 0.0, 1.0);
        fine = vec2(part * fine.x, 1.0 - part * part * (1.0 - fine.y));
    }
    n += vec2(sqrt(torn) * fine.x, torn * fine.y);
    float whole = 1.0 + torn;
    float foam = foam_share((bound * sqrt(1.0 + thin) - n.x) * inversesqrt(n.y + PEL_FOAM_THIN));
    float thicker = min(foam_share(n.x * inversesqrt(whole)) / foam_share(bound), 1.0);
    return vec2(foam, 1.0 + PEL_FOAM_RELIEF * (1.0 - n.y / whole) * (1.0 - 2.0 * thicker));
}
#endif

#ifdef PEL_WASH
#include "lib/washfoam.glsl"
#endif
