// The bottom and the land as a height field (seabed/seabed.h): where a line of
// sight meets the land, and how deep the water is that it looks into. Heights
// are above the sea's zero here, places x from the eye's nadir.

layout(binding = PEL_UNIT_SEABED_HEIGHTS) uniform sampler2D seabed_heights; // and their means, m above the file's zero
// A buffer, since samplers of software devices take one level for four pixels.
layout(std430, binding = PEL_STORE_SEABED_TOPS) restrict readonly buffer seabed_tops_block { float seabed_tops[]; };

vec2 bed_node(vec2 x)
{
    return x * bed_place.z + bed_place.xy;
}

// Bilinear by hand: samplers interpolate by 1/256. Twin of pel_seabed_drawn.
float seabed_height(vec2 node)
{
    if (any(lessThan(node, vec2(-0.5))) || any(greaterThan(node, bed_size.xy - 0.5))) {
        return bed_beyond.x;
    }
    vec2 p = clamp(node, vec2(0.0), bed_size.xy - 1.0);
    ivec2 i = ivec2(min(p, bed_size.xy - 2.0));
    vec2 f = p - vec2(i);
    float a = texelFetch(seabed_heights, i, 0).r;
    float b = texelFetch(seabed_heights, i + ivec2(1, 0), 0).r;
    float c = texelFetch(seabed_heights, i + ivec2(0, 1), 0).r;
    float d = texelFetch(seabed_heights, i + ivec2(1, 1), 0).r;
    return mix(mix(a, b, f.x), mix(c, d, f.x), f.y) + bed_size.w;
}

// Normal of the ground, over `footprint` m and no less than a node each way.
vec3 seabed_normal(vec2 node, float footprint)
{
    float reach = max(0.5 * footprint * bed_place.z, 1.0);
    float lod = log2(reach);
    vec2 scale = 1.0 / bed_size.xy;
    vec2 uv = (node + 0.5) * scale;
    vec2 across = vec2(reach, 0.0);
    vec2 slope = vec2(textureLod(seabed_heights, uv + across.xy * scale, lod).r -
                          textureLod(seabed_heights, uv - across.xy * scale, lod).r,
                      textureLod(seabed_heights, uv + across.yx * scale, lod).r -
                          textureLod(seabed_heights, uv - across.yx * scale, lod).r) *
                 (0.5 / (reach * bed_place.w));
    return normalize(vec3(-slope, 1.0));
}

// Height of the line of sight above the sphere.
float sight_height(vec3 dir, float t)
{
    float arc = t * length(dir.xy);
    return eye.x + t * dir.z + arc * arc * (0.5 / planet.x);
}

float above_ground(vec3 dir, float t)
{
    return sight_height(dir, t) - seabed_height(bed_node(dir.xy * t));
}

// Where the line of sight is over the field and not above all of it.
bool clip_to_field(vec3 dir, inout float from, inout float to)
{
    vec2 step_ = dir.xy * bed_place.z;
    vec2 safe = mix(step_, vec2(1e-9), lessThan(abs(step_), vec2(1e-9)));
    vec2 a = (vec2(-0.5) - bed_place.xy) / safe;
    vec2 b = (bed_size.xy - 0.5 - bed_place.xy) / safe;
    vec2 first = min(a, b);
    vec2 last = max(a, b);
    from = max(from, max(first.x, first.y));
    to = min(to, min(last.x, last.y));
    float bend = max(dot(dir.xy, dir.xy), 1e-9) * (0.5 / planet.x);
    float over = eye.x - bed_size.z;
    float root = dir.z * dir.z - 4.0 * bend * over;
    if (root < 0.0) {
        return false; // passes above it
    }
    root = sqrt(root);
    // Both roots without cancellation.
    float q = -0.5 * (dir.z + (dir.z < 0.0 ? -root : root));
    vec2 roots = vec2(q / bend, abs(q) > 1e-12 ? over / q : 0.0);
    from = max(from, min(roots.x, roots.y));
    to = min(to, max(roots.x, roots.y));
    return from < to;
}

// Distance to the ground along the unit direction, if nearer than `limit`; else
// negative. Squares whose highest node lies below the line of sight are passed
// whole, large ones first.
float seabed_distance(vec3 dir, float limit)
{
    float t = 0.0;
    float to = limit;
    if (!clip_to_field(dir, t, to)) {
        return -1.0;
    }
    vec2 step_ = dir.xy * bed_place.z;
    vec2 ahead = step(vec2(0.0), step_);
    vec2 inverse = 1.0 / mix(step_, vec2(1e-9), lessThan(abs(step_), vec2(1e-9)));
    float top = bed_beyond.z - 1.0;
    float level = min(3.0, top);
    // Half a node at a time where squares are not passed whole. One look at the
    // ground in the loop: a software device runs through all of it each time.
    float fine = 0.5 * bed_place.w / max(length(dir.xy), 1e-3);
    float hit = -1.0;
    for (int i = 0; i < 768 && t < to; i++) {
        vec2 node = dir.xy * (t * bed_place.z) + bed_place.xy;
        float side = exp2(level + 1.0);
        // A little ahead, so that a border belongs to what comes.
        vec2 square = floor((node + (ahead - 0.5) * 0.002) / side);
        vec2 leave = ((square + ahead) * side - bed_place.xy) * inverse;
        float end = min(max(min(leave.x, leave.y), t + 0.002 * bed_place.w), to);
        vec3 table = bed_level[int(level)].xyz;
        vec2 at = clamp(square, vec2(0.0), table.yz - 1.0);
        float highest = seabed_tops[int(table.x + at.y * table.y + at.x)] + bed_size.w;
        float arc = (end - t) * length(dir.xy);
        float lowest = min(sight_height(dir, t), sight_height(dir, end)) -
                       arc * arc * (0.125 / planet.x);
        if (lowest > highest) {
            t = end;
            level = min(level + 1.0, top);
        } else if (level > 0.5) {
            level -= 1.0;
        } else {
            float next = min(t + fine, end);
            if (above_ground(dir, next) <= 0.0) {
                hit = next;
                break;
            }
            t = next;
        }
    }
    // Software devices run through what follows for every line of sight, and
    // through a loop once where nothing is to be done.
    bool found = hit >= 0.0;
    hit = found ? hit : t;
    float before = above_ground(dir, t);
    float after = above_ground(dir, hit);
    float near_enough = 1e-6 * hit;
    for (int i = 0; i < 6 && before > 0.0 && hit - t > near_enough; i++) {
        float middle = mix(t, hit, before / (before - after));
        float here = above_ground(dir, middle);
        if (here > 0.0) {
            t = middle;
            before = here;
        } else {
            hit = middle;
            after = here;
        }
    }
    if (!found) {
        return -1.0;
    }
    return before <= 0.0 ? t : mix(t, hit, before / max(before - after, 1e-9));
}

#ifdef PEL_FFT
// Of the cascades from the second on: the first has no waves short enough to
// focus light. Ends where a footprint leaves nothing of the next one; how many
// there are is a uniform, for a loop that is written out is run to its end, and
// the condition stands last, for software devices run a loop's body once more
// than it holds.
#define PEL_EACH_CASCADE(BODY)                                                 \
    reading at = reading_at(x);                                                \
    shear(0, x, at);                                                           \
    int c = 1;                                                                 \
    do {                                                                       \
        shear(c, x, at);                                                       \
        float lod = log2(footprint / cascades[c].place.w) + back.w;              \
        BODY                                                                   \
        c++;                                                                   \
    } while (c < int(bed_fall.w) &&                                            \
             footprint * cascades[min(c, PEL_CASCADES - 1)].place.z < PEL_LONGEST_OF_CASCADE);
#endif

// Slope of the waves that a footprint resolves.
vec2 wave_slope(vec2 x, float footprint)
{
    vec2 slope = vec2(0.0);
#ifdef PEL_FFT
    PEL_EACH_CASCADE(slope += textureLod(slope_fields, vec3(cascade_uv(c, at.place), c), lod).xy;)
#else
    float scale = up.w / footprint;
    float offset = -right.w * up.w;
#define PEL_TILT(phase, wander)                                                \
    float w = filter_weight(phase.w * scale + offset);                         \
    vec3 at = wandered(wander, x);                                             \
    slope -= wave_vector(phase, wander, at) *                                  \
             (w * wander.w * sine_cosine_turns(wave_turns(phase, x, at)).x);
    PEL_EACH_WAVE(PEL_TILT)
#endif
    return slope;
}

// Their second derivatives: xx, xy, yy.
vec3 wave_bend(vec2 x, float footprint)
{
    vec3 bend = vec3(0.0);
#ifdef PEL_FFT
    vec2 half_ = vec2(0.5 * footprint, 0.0);
    PEL_EACH_CASCADE(
        vec2 e = textureLod(slope_fields, vec3(cascade_uv(c, at.place + half_.xy), c), lod).xy;
        vec2 w = textureLod(slope_fields, vec3(cascade_uv(c, at.place - half_.xy), c), lod).xy;
        vec2 n = textureLod(slope_fields, vec3(cascade_uv(c, at.place + half_.yx), c), lod).xy;
        vec2 s = textureLod(slope_fields, vec3(cascade_uv(c, at.place - half_.yx), c), lod).xy;
        bend += vec3(e.x - w.x, 0.5 * (e.y - w.y + n.x - s.x), n.y - s.y);
    )
    bend /= footprint;
#else
    float scale = up.w / footprint;
    float offset = -right.w * up.w;
#define PEL_BEND(phase, wander)                                                \
    float w = filter_weight(phase.w * scale + offset);                         \
    vec3 at = wandered(wander, x);                                             \
    float c = sine_cosine_turns(wave_turns(phase, x, at)).y;                   \
    vec2 k = wave_vector(phase, wander, at);                                   \
    bend -= k.xxy * k.xyy * (2.0 * PI * w * wander.w * c);
    PEL_EACH_WAVE(PEL_BEND)
#endif
    return bend;
}

// How much brighter than under a flat surface a light's beam falls on the
// bottom at `place`, `depth` m down: rays through the waves there are moved
// aside by `reach` times the slope where they enter, so the light of an area is
// spread by the determinant of that map; which ray ends here is found by going
// back along it. Waves so short that their rays would cross are left out, so
// its mean over the bottom is 1.
float caustic(int light, vec2 place, float depth, float footprint, vec3 light_dir, float cosine)
{
    const float eta = 1.0 / PEL_WATER_INDEX;
    float row = clamp((log2(max(depth, 1e-3)) - PEL_FOCUS_FIRST) * PEL_FOCUS_STEPS, 0.0,
                      float(PEL_FOCUS_COUNT) - 1.001);
    int entry = int(row);
    int focus = light * PEL_FOCUS_COUNT + entry;
    float least = exp2(mix(bed_focus[focus].x, bed_focus[focus + 1].x, row - float(entry)));
    // The light's disc, refracted, blurs what lies deep.
    least = max(least, max(footprint, 2.0 * lights[light].direction.w * eta * depth));
    float reach = depth * (cosine - eta * light_dir.z) / cosine;
    vec2 enter = place + light_dir.xy * (depth * eta / cosine);
    vec3 bend = wave_bend(enter - reach * wave_slope(enter, least), least);
    float spread = (1.0 + reach * bend.x) * (1.0 + reach * bend.z) - reach * reach * bend.y * bend.y;
    return 1.0 / max(spread, 0.2);
}

// Of a light's beam, what no rise of the bottom between the surface and a place
// at this height, `depth` m down, hides: only slopes steeper than the refracted beam can.
float seabed_lit(int light, vec2 place, float height, float depth, vec3 light_dir, float cosine)
{
    if (bed_beams[light].y < 0.5) {
        return 1.0;
    }
    float hidden = 0.0;
    vec2 run = light_dir.xy * (depth / (PEL_WATER_INDEX * cosine));
    for (int i = 1; i <= 8; i++) {
        float t = float(i) / 8.5;
        hidden = max(hidden, seabed_height(bed_node(place + run * t)) - height - depth * t);
    }
    return 1.0 - smoothstep(0.0, 0.05 * depth, hidden);
}

// A point of the bottom in view.
struct bed_view {
    vec2 place;
    float height; // of the bottom there, above the sea's zero
    float depth; // of the water, below where the line of sight enters it
    float under; // the same below that place itself
    float rise;  // cosine of the line of sight in the water to the vertical
};

// Where the line of sight towards v, refracted by a facet n at place x and
// height z of the surface, meets the bottom.
bed_view seabed_seen(vec2 x, float z, vec3 v, vec3 n)
{
    float facing = max(dot(n, v), 0.0);
    const float eta = 1.0 / PEL_WATER_INDEX;
    vec3 down = n * (eta * facing - sqrt(1.0 - eta * eta * (1.0 - facing * facing))) - eta * v;
    bed_view seen;
    seen.rise = max(-down.z, 0.2);
    vec2 run = down.xy / seen.rise;
    seen.under = max(z - seabed_height(bed_node(x)), 0.0);
    seen.depth = seen.under;
    seen.place = x + run * seen.depth;
    // Slopes of the bottom times that of the sight are small: it converges.
    for (int i = 0; i < 4; i++) {
        seen.depth = max(z - seabed_height(bed_node(seen.place)), 0.0);
        seen.place = x + run * seen.depth;
    }
    seen.height = z - seen.depth;
    return seen;
}

// The water's light over a bottom that is not level.
struct bed_light {
    vec3 volume; // never touched it
    vec3 bottom;
};

// log2(1 − x) for x from −1 to 0.6, within 0.024.
vec3 log2_less(vec3 x)
{
    return x * (x - 6.0) / (4.158883 - 2.772589 * x);
}

// From the maps of level water of a light, `at` on them: its light straight to the bottom
// and back by its own equation (eq. 9 of the 2003 paper with cos γ, shade and
// the waves' focusing), what was scattered as well from level water of another
// depth, by how deep it is under the line of sight and how steep the bottom.
// Twin of pel_slope_light.
bed_light seabed_light(int light, vec2 at, bed_view seen, float footprint, vec3 light_dir)
{
    const float eta = 1.0 / PEL_WATER_INDEX;
    float depth = max(seen.depth, 0.01);
    float cosine = sqrt(1.0 - eta * eta * (1.0 - light_dir.z * light_dir.z));
    vec3 n = seabed_normal(bed_node(seen.place), footprint);
    float gain = max(dot(n.xy, light_dir.xy) * eta + n.z * cosine, 0.0) / cosine;
    gain *= seabed_lit(light, seen.place, seen.height, depth, light_dir, cosine);

    float under = 1.0 - seen.under / depth;
    float steep = 1.0 - n.z * n.z;
    vec3 turned = bed_turned.rgb * depth;
    vec3 reach = PEL_SLOPE_ABSORBED * depth * bed_absorption.rgb + turned;
    // Levels of the depths that are looked up, none beyond the last: the sea
    // beyond the field's tiles has its bottom.
    float last = water.x - 1.0;
    float here = (log2(depth) - water.y) * water.z;
    vec3 shift = clamp(reach * (PEL_SLOPE_BOTTOM_UNDER * under + PEL_SLOPE_BOTTOM_STEEP * steep),
                       PEL_SLOPE_SHIFT_LEAST, PEL_SLOPE_SHIFT_MOST);
    vec3 deepest = vec3(exp2(water.y + last / water.z));
    vec3 for_bottom = min(depth * (1.0 - shift), deepest);
    vec3 bottom_level = min(here + log2_less(shift) * water.z, last);
    shift = clamp(reach * (PEL_SLOPE_VOLUME_UNDER * under + PEL_SLOPE_VOLUME_STEEP * steep),
                  PEL_SLOPE_SHIFT_LEAST, PEL_SLOPE_SHIFT_MOST);
    vec3 volume_level = min(here + log2_less(shift) * water.z, last);
    vec3 kept = 1.0 / (1.0 + turned);

    float below = clamp(floor(bottom_level.g), 0.0, last - 1.0);
    float first = water_layer(light, WATER_TOTAL) + below;
    vec3 total0 = textureLod(water_map, vec3(at, first), 0.0).rgb;
    vec3 total1 = textureLod(water_map, vec3(at, first + 1.0), 0.0).rgb;
    first = water_layer(light, WATER_BOTTOM) + below;
    vec3 bottom0 = textureLod(water_map, vec3(at, first), 0.0).rgb;
    vec3 bottom1 = textureLod(water_map, vec3(at, first + 1.0), 0.0).rgb;
    float z0 = exp2(water.y + below / water.z);
    float z1 = exp2(water.y + (below + 1.0) / water.z);

    vec3 way = bed_extinction.rgb * (1.0 / cosine + 1.0 / seen.rise);
    vec3 beam = bed_under.rgb * beams[light].rgb * bed_beams[light].x;
    vec3 around0 = max(bottom0 - beam * exp(-way * z0), vec3(1e-12));
    vec3 around1 = max(bottom1 - beam * exp(-way * z1), vec3(1e-12));
    // Between levels a power of the depth times e^(−fall depth).
    vec3 fall = bed_fall.rgb * (1.0 / cosine + 1.0 / seen.rise);
    vec3 part = clamp(bottom_level - below, -1.0, 2.0);
    vec3 around = exp2(mix(log2(around0) + fall * z0, log2(around1) + fall * z1, part) -
                       fall * for_bottom);
    vec3 most = beam + bed_under.rgb * skies[light].rgb * (eta * eta / PI);
    around = min(around, most / (1.0 - 0.5 * bed_under.rgb));

    vec3 direct = beams[light].rgb * max(light_dir.z, 0.0);
    vec3 by_beam = direct / (direct + skies[light].rgb + 1e-20);
    bed_light result;
    result.bottom = around * (1.0 + kept * (mix(vec3(n.z), vec3(gain), by_beam) - 1.0));
    if (bed_beyond.w > 0.5 && light_dir.z > 0.02) {
        gain *= caustic(light, seen.place, depth, footprint, light_dir, cosine);
    }
    result.bottom += beam * exp(-way * min(depth, deepest.r)) * gain;
    part = clamp(volume_level - below, -1.0, 2.0);
    result.volume = max(mix(total0 - bottom0, total1 - bottom1, part), vec3(0.0));
    return result;
}
