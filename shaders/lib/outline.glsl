// Pixels that an outline cuts: where waves hide what is behind them, and where
// they stand before the sky. The surface, an upright net around the eye, is
// followed outwards from the lower of two neighbours to the upper one: a crest
// that hides some of it on the way is an outline. It is a straight line in the
// pixel, and what is below it shows the lower neighbour, what is above it the
// upper one. All from the mesh and from three pixels' middles, so that a pixel
// is the same in every picture of its lattice. Includers have lib/ray.glsl,
// lib/cut.glsl and triangle_at.

#ifndef PEL_TOGETHER
layout(location = PEL_UNIFORM_BLOCK_COUNT) uniform int block_count;
layout(location = PEL_UNIFORM_BLOCKS) uniform ivec4 blocks[PEL_MESH_MAX_BLOCKS];
layout(location = PEL_UNIFORM_BASES) uniform int bases[PEL_MESH_MAX_BLOCKS];
#endif

const int MOST_STEPS = 400;
const int MOST_HIDDEN = 12; // rings that are looked through for a crest behind

// A pixel as it is seen along its azimuth: heights are tangents.
struct upright {
    vec3 ray;
    vec2 ahead;  // unit
    float level; // its tangent
    float high;  // a pixel
    float wide;
    ivec2 up;    // to the neighbour above, more or less
};

upright upright_at(ivec2 at)
{
    upright p;
    p.ray = pixel_ray(lattice(at));
    float far = inversesqrt(dot(p.ray.xy, p.ray.xy));
    p.ahead = p.ray.xy * far;
    p.level = p.ray.z * far;
    vec2 rise = vec2(right.z - p.level * dot(right.xy, p.ahead),
                     p.level * dot(up.xy, p.ahead) - up.z) * pixel.xy;
    float steep = sqrt(dot(rise, rise));
    vec2 across = vec2(-rise.y, rise.x) / steep * pixel.xy;
    vec2 side = right.xy * across.x - up.xy * across.y;
    p.high = steep * far;
    p.wide = abs(side.y * p.ahead.x - side.x * p.ahead.y) * far;
    p.up = abs(rise.y) >= abs(rise.x) ? ivec2(0, rise.y > 0.0 ? 1 : -1)
                                      : ivec2(rise.x > 0.0 ? 1 : -1, 0);
    return p;
}

// The part of a pixel below a line, that is `middle` pixels above its middle and
// rises by `slope`.
float part_below(float middle, float slope)
{
    vec4 at = clamp(0.5 + middle + slope * vec4(-0.375, -0.125, 0.125, 0.375), 0.0, 1.0);
    return 0.25 * (at.x + at.y + at.z + at.w);
}

// The part of the pixel that is below the outline which hides what lies between
// the triangle `near` and the strip `last`; `none` where nothing does.
float hidden_below(upright p, uint near, int last, float none)
{
    int n = COLUMNS_AROUND;
    int v = int(near - 1u >> 1u);
    vec2 flags_ring = vertex_rest(v).zw;
    int b = int(uint(flags_ring.x) >> 3); // VERTEX_BLOCK
    ivec4 block = MESH_BLOCK(b);
    int row = int(flags_ring.y) - block.x;
    int column = v - MESH_BASE(b) - row * block.w;
    row++;
    float crest = -1e9, slope = 0.0; // highest so far
    float outline = -1e9, outline_slope = 0.0;
    int crest_ring = 0, widest = 0, turned = 0;
    bool fallen = false;
    for (int i = 0; i < MOST_STEPS; i++) {
        if (row >= block.y) {
            if (++b >= MESH_BLOCKS) {
                break;
            }
            column += block.z - MESH_BLOCK(b).z;
            column += column < 0 ? n : column >= n ? -n : 0;
            block = MESH_BLOCK(b);
            row = 1;
        }
        if (block.w > n) { // all around
            column += column < 1 ? n : column > n ? -n : 0;
        }
        int ring = block.x + row;
        if (ring > last || column < 1 || column >= block.w) {
            break;
        }
        v = MESH_BASE(b) + row * block.w + column;
        vec3 from = vertex_position(v - 1).xyz;
        vec3 to = vertex_position(v).xyz;
        vec2 side = vec2(from.y * p.ahead.x - from.x * p.ahead.y, to.y * p.ahead.x - to.x * p.ahead.y);
        int turn = side.x > 0.0 ? -1 : side.y < 0.0 ? 1 : 0;
        if (turn != 0 && turn != -turned) {
            column += turn;
            turned = turn;
            continue;
        }
        vec2 far = 1.0 / max(vec2(dot(from.xy, p.ahead), dot(to.xy, p.ahead)), 1e-3);
        side *= far;
        float fall = (to.z * far.y - from.z * far.x) / max(side.y - side.x, 1e-9);
        float height = from.z * far.x - side.x * fall;
        if (height >= crest) {
            if (fallen && ring - crest_ring > widest) {
                widest = ring - crest_ring;
                outline = crest;
                outline_slope = slope;
            }
            fallen = false;
            crest = height;
            slope = fall;
            crest_ring = ring;
        } else {
            fallen = fallen || height < crest - 0.02 * p.high;
        }
        bool behind = last != NO_STRIP && fallen && ring - crest_ring > MOST_HIDDEN;
        if (behind || crest > p.level + 1.5 * p.high) {
            break;
        }
        row++;
        turned = 0;
    }
    if (last == NO_STRIP || (fallen && last - crest_ring > widest)) {
        outline = crest;
        outline_slope = slope;
    }
    return outline < -1e8 ? none
                          : part_below((outline - p.level) / p.high, outline_slope * p.wide / p.high);
}

// The parts of a pixel that its neighbours below and above are seen in.
vec2 parts_of_neighbours(ivec2 at, upright p)
{
    uint lower = triangle_at(at - p.up);
    uint own = triangle_at(at);
    int strip = strip_of(own);
    vec2 parts = vec2(0.0);
    if (lower != 0u && strip > strip_of(lower) + PEL_OUTLINE_HIDDEN) {
        parts.x = hidden_below(p, lower, strip, 0.0);
    }
    if (own != 0u) {
        int behind = strip_of(triangle_at(at + p.up));
        if (behind > strip + PEL_OUTLINE_HIDDEN) {
            parts.y = 1.0 - hidden_below(p, own, behind, 1.0);
        }
    }
    parts /= max(parts.x + parts.y, 1.0);
    return parts.x + parts.y < 0.002 ? vec2(0.0) : parts;
}
