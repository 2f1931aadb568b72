// The wash of ships, twin of ocean/wash.h: nodes, lists of pieces, cells.
layout(std430, binding = PEL_STORE_WASH) readonly buffer wash_words_block { uint wash_words[]; };

vec4 wash_texel(uint at)
{
    return uintBitsToFloat(uvec4(wash_words[at], wash_words[at + 1u], wash_words[at + 2u], wash_words[at + 3u]));
}

// A band `off` from its middle as a footprint sees it: its mean is kept.
float wash_band(float off, float half_width, float from, float to, float soft)
{
    float wide = max(half_width, min(soft, half_width + PEL_WASH_SOFTEST_M));
    return (1.0 - smoothstep(from, to, abs(off) / wide)) * half_width / wide;
}

// What the piece from node `i` on does: calm, foam, bubbles, the greater of it
// and of what is there.
vec3 wash_piece(uint i, vec2 x, float bend, float soft, vec3 sum)
{
    uint at = i * uint(PEL_WASH_NODE_WORDS);
    vec4 a = wash_texel(at);
    vec4 b = wash_texel(at + uint(PEL_WASH_NODE_WORDS));
    float f0 = dot(x - a.xy, a.zw);
    float f1 = dot(x - b.xy, b.zw);
    if (f0 < 0.0 || f1 >= 0.0) {
        return sum;
    }
    float f = f0 / (f0 - f1);
    vec4 middle = mix(a, b, f);
    vec2 n = vec2(-middle.w, middle.z);
    float v = dot(x - middle.xy, n) / max(length(n), 0.1);
    // half-width, calm, core's, core
    vec4 amid = mix(wash_texel(at + 4u), wash_texel(at + uint(PEL_WASH_NODE_WORDS) + 4u), f);
    // of the sides: place, half-width, foam; bubbles
    vec4 side = mix(wash_texel(at + 8u), wash_texel(at + uint(PEL_WASH_NODE_WORDS) + 8u), f);
    float wake = wash_band(v + bend * amid.x, amid.x, 0.65, 1.0, soft);
    float core = wash_band(v + bend * amid.z, amid.z, 0.4, 1.1, soft);
    float beside = wash_band(abs(v) - side.x + bend * side.y, side.y, 0.4, 1.0, soft);
    return max(sum, vec3(amid.y * wake, max(amid.w * core, side.z * beside), side.w * core));
}

// At the water that rests at x from the eye's nadir: what short waves are
// times; the mean share of foam; bubbles.
vec3 wash_at(vec2 x, float footprint)
{
    vec3 sum = vec3(0.0);
    vec2 place = (x - wash_box.xy) * wash_box.z;
    if (min(place.x, place.y) >= 0.0 && place.x < wash_size.x && place.y < wash_size.y) {
        uint cell = wash_words[int(wash_box.w) + int(place.y) * int(wash_size.x) + int(place.x)];
        uint first = uint(wash_size.z) + (cell >> 10u);
        uint end = first + (cell & 1023u);
        if (first < end) {
            vec2 turns = vec2(dot(x, vec2(PEL_WASH_BEND_1_X, PEL_WASH_BEND_1_Y)),
                              dot(x, vec2(PEL_WASH_BEND_2_X, PEL_WASH_BEND_2_Y))) + wash_bends.xy;
            turns = 6.28318530718 * fract(turns);
            float bend = PEL_WASH_BEND * (sin(turns.x) + sin(turns.y));
            for (uint i = first; i < end; i++) {
                sum = wash_piece(wash_words[i], x, bend, 0.5 * footprint, sum);
            }
        }
    }
    return vec3(1.0 - sum.x + PEL_WASH_CHURNED * sum.y, sum.yz);
}
