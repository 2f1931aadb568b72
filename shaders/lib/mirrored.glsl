// What objects do to the sea beside them: they stand in the mirrored rays, their
// shadow lies on it, and their hulls are seen through it.
#include "lib/model.glsl"
#include "lib/shadow.glsl"

// Of those in a mask, `rest`. A program for one alone has no loop: software
// devices test after a turn whether there is another.
#ifdef PEL_ONE_OBJECT
#define EACH_OBJECT(mask) int rest = mask; if (rest != 0)
#else
#define EACH_OBJECT(mask) for (int rest = mask; rest != 0; rest &= rest - 1)
#endif

layout(binding = PEL_UNIT_MIRRORS) uniform sampler2DArray mirrors;
layout(binding = PEL_UNIT_MIRROR_DEPTHS) uniform sampler2DArray mirror_depths;
layout(location = PEL_UNIFORM_NEAR) uniform ivec3 objects_near; // masks: mirrored, shading, seen through the sea

vec3 sea_place = vec3(0.0); // of the pixel, from the eye
vec2 sea_pixel = vec2(0.0); // its place on the lattice
float sea_lit = 1.0;  // share of the Sun there

// Distances along the ray from p, in the model's axes, at which it comes to the
// model's outline, or nearest to its middle (negative: that is behind p); and
// between which it may meet the model, it or one close beside it.
vec3 outline_distance(int i, vec3 p, vec3 r)
{
    vec4 plan = place_texel(i, 4);
    vec2 inverse = 1.0 / mix(vec2(1e-6), r.xy, greaterThan(abs(r.xy), vec2(1e-6)));
    vec2 size_ = 1.0 / plan.zw;
    vec2 a = (plan.xy - p.xy) * inverse;
    vec2 b = (plan.xy + size_ - p.xy) * inverse;
    vec2 first = min(a, b);
    vec2 last = max(a, b);
    float enters = max(first.x, first.y);
    float leaves = min(last.x, last.y);
    float nearest = -dot(p.xy, r.xy) / max(dot(r.xy, r.xy), 1e-6);
    float half_ = 0.5 * length(size_);
    bool meets = enters < leaves && leaves > 0.0;
    vec2 between = meets ? vec2(enters, leaves) + vec2(-0.2, 0.2) * half_ : nearest + vec2(-half_, half_);
    return vec3(meets ? max(enters, 0.0) : nearest, max(between, vec2(0.0)));
}

// How much of what an object does to the sea a pixel gets: all but close to the
// edge of the rectangle, on the lattice, outside of which it does nothing.
float felt(vec4 box, float faded, float inset)
{
    vec2 off = min(sea_pixel - box.xy, box.zw - sea_pixel) - vec2(inset, 0.0);
    off /= max(faded * (box.zw - box.xy), vec2(1.0));
    return clamp(min(off.x, off.y), 0.0, 1.0);
}

// An object's view from the eye's image in the sea, for the rays of one pixel.
struct mirror_view {
    vec3 forward, across, upward;
    vec3 from; // the pixel's place, along across, upward, forward
    vec4 window_;
    vec4 level; // of what is seen, as far as by the view's tangents; less the place's
    float layer, tall, middle, here; // here 0: it is not met
    float pixel_; // 1 / its length on the sea, m, at least one
};

mirror_view mirror_view_of(int i, vec2 away)
{
    vec4 forward = place_texel(i, 8);
    vec4 across = place_texel(i, 9);
    mirror_view m;
    m.forward = forward.xyz;
    m.layer = forward.w;
    m.across = across.xyz;
    m.upward = place_texel(i, 10).xyz;
    m.window_ = place_texel(i, 11);
    vec4 more = place_texel(i, 14);
    m.middle = more.x;
    m.here = felt(place_texel(i, 12), 0.08, clamp((more.y - sea_pixel.y) * more.z, 0.0, more.w));
    vec3 from = sea_place - vec3(0.0, 0.0, across.w);
    m.from = vec3(dot(from, m.across), dot(from, m.upward), dot(from, m.forward));
    m.level = vec4(dot(m.across.xy, away), dot(m.upward.xy, away), dot(m.forward.xy, away), dot(from.xy, away));
    m.pixel_ = 1.0 / max(pixel.x * dot(sea_place, sea_place) / max(-sea_place.z, 0.1), 1.0);
    m.tall = m.window_.w * float(PEL_MIRROR_HEIGHT);
    return m;
}

vec3 in_view(mirror_view m, vec3 way)
{
    return vec3(dot(way, m.across), dot(way, m.upward), dot(way, m.forward));
}

// `far`: along `way`, of level length 1 and in the view's axes.
vec2 view_place(mirror_view m, vec3 way, float far, out float inverse)
{
    vec3 sight = m.from + far * way;
    inverse = 1.0 / sight.z;
    return sight.xy * inverse;
}

// How far away, level, what stands that a ray meets, if it is about `far` away,
// where nothing stands `other`.
float stands_mirrored(mirror_view m, vec3 way, float far, float lod, float other)
{
    float inverse;
    vec2 tangents = view_place(m, way, far, inverse);
    vec2 there = textureLod(mirror_depths, vec3((tangents - m.window_.xy) * m.window_.zw, m.layer), lod).rg;
    float depth = m.middle + there.r / max(there.g, 1e-3);
    float stands = depth * dot(m.level.xyz, vec3(tangents, 1.0)) - m.level.w;
    return there.g > 0.02 ? stands : other;
}

vec4 seen_mirrored(mirror_view m, vec3 way, float spread, float far)
{
    float inverse, level = max(far, 0.0);
    vec2 tangents = view_place(m, way, level, inverse);
    vec2 uv = (tangents - m.window_.xy) * m.window_.zw;
    float texels = spread * m.tall * level * inverse;
    // The middle of a pixel at the waterline may lie in the hull.
    float here = m.here * clamp(far * m.pixel_ + 2.0, 0.0, 1.0);
    vec4 seen = textureLod(mirrors, vec3(uv, m.layer), log2(max(texels, 1.0)));
    return here * vec4(seen.rgb * dusk.y, seen.a);
}

// Whether a ray may meet the object between two distances; false: the texels
// that seen_mirrored reads there are empty.
bool may_meet(mirror_view m, vec3 way, float spread, vec2 between)
{
    vec2 inverse;
    vec2 a = view_place(m, way, between.x, inverse.x);
    vec2 b = view_place(m, way, between.y, inverse.y);
    // A texel of the coarser level.
    vec2 texels = 2.0 * max(spread * m.tall * between * inverse, vec2(1.0));
    vec2 margin = max(texels.x, texels.y) / vec2(PEL_MIRROR_WIDTH, PEL_MIRROR_HEIGHT);
    vec2 low = (min(a, b) - m.window_.xy) * m.window_.zw - margin;
    vec2 high = (max(a, b) - m.window_.xy) * m.window_.zw + margin;
    return max(low.x, low.y) < 1.0 && min(high.x, high.y) > 0.0;
}

// The reflected light with objects in it. Of `sky`, reflected_sky's integral, they
// take the share that they hide of it by more facets, since an object has edges
// (of this integral itself: the two differ, and more than all of the sky would
// be hidden under a hull), and put there what those facets mirror. `s`, `mu`:
// standard deviation of the slopes towards the eye, the sight's tangent by it;
// `axis`: slopes of one s there; `tint`: of the reflectance, which facets have
// alike, by that of green. And the same for
// `second`, the second_reflection of `lost` at eta: facets that a ray
// meets there have in the mean the slope z, Q(eta) / (phi(eta) - eta Q(eta)) by
// its first terms, and mirror 2 z - eta.
vec3 with_objects(sampler2D map, vec3 sky, vec3 v, vec3 n, vec3 tx, vec3 ty, vec2 axis, float s, float cross2, float mu,
                  vec3 resolved, vec3 tint, vec3 lost, float eta, vec3 second)
{
    const int FACETS = 6;
    const float STEP = 0.8, WIDE = 0.6; // in s: apart, and blurred by the view's levels
    if (objects_near.x == 0) {
        return sky + lost * second;
    }
    vec3 ways[FACETS], skies_[FACETS];
    float shares[FACETS];
    vec3 stands = vec3(0.0), hidden = vec3(0.0), whole = vec3(0.0);
    float spreads[FACETS], left_[FACETS];
    float odds = escape_odds(mu);
    for (int k = 0; k < FACETS; k++) {
        float y = STEP * (float(k) - 0.5 * float(FACETS - 1));
        float weight = max(mu + y, 0.0) * exp(-0.5 * y * y);
        vec3 facet = tx * (axis.x * y) + ty * (axis.y * y) + n;
        vec3 f = facet * inversesqrt(dot(facet, facet) + cross2);
        float fv = dot(f, v);
        vec3 r = 2.0 * fv * f - v;
        float level = inversesqrt(max(dot(r.xy, r.xy), 1e-4));
        float tangent = r.z * level;
        float open_ = escape(tangent / s, odds) * escape(tangent * resolved.x, resolved.y);
        ways[k] = r * level;
        shares[k] = reflectance_of(fv, refraction.g) * (weight * open_);
        spreads[k] = max(sqrt(cross2) * abs(fv), WIDE * s) * level;
        left_[k] = 1.0;
        float inverse = 0.5 / PEL_REFLECTION_HALF_WIDTH / (1.0 + max(r.z, 0.0));
        skies_[k] = textureLod(map, r.xy * inverse + 0.5, 2.0).rgb * shares[k];
        whole += skies_[k];
    }
    vec2 away = -v.xy * inversesqrt(max(dot(v.xy, v.xy), 1e-8));
    float z = 1.2533 + eta * (0.56 + 0.08 * eta);
    vec3 twice = vec3(away, max(2.0 * z - eta, 0.1) / resolved.z);
    vec3 again = facet_reflectance(min(max(z - eta, 0.1) / resolved.z, 1.0));
    float left_twice = 1.0;
    vec3 sum_twice = vec3(0.0);
    EACH_OBJECT(objects_near.x) {
        int i = findLSB(rest);
        mirror_view m = mirror_view_of(i, away);
        // First the outline's distance, then of what each ray sees there.
        placed o = placed_object(i);
        vec3 outline = outline_distance(i, into_model(o, sea_place), vec3(dot(away, o.x.xy), dot(away, o.y.xy), 0.0));
        float guess = max(outline.x, 0.0), wall = outline.x;
        float lod = log2(max(m.tall * 0.3 * s * guess / max(m.from.z, 1.0), 1.0));
        int meets = 0;
        for (int k = 0; k < FACETS; k++) {
            bool may = m.here > 0.0 && shares[k] > 0.0 && may_meet(m, in_view(m, ways[k]), spreads[k], outline.yz);
            meets |= may ? 1 << k : 0;
        }
        // Software devices turn once in any loop, and compute both sides of a
        // branch.
        if (meets != 0) do {
            int turn = findLSB(meets);
            meets &= meets - 1;
            vec3 way = vec3(0.0);
            float share = 0.0, spread = 0.0, left = 0.0;
            for (int k = 0; k < FACETS; k++) {
                bool is = k == turn;
                way = is ? ways[k] : way;
                share = is ? shares[k] : share;
                spread = is ? spreads[k] : spread;
                left = is ? left_[k] : left;
            }
            way = in_view(m, way);
            wall = stands_mirrored(m, way, guess, lod, wall);
            vec4 seen = seen_mirrored(m, way, spread, wall) * left;
            stands += seen.rgb * share;
            for (int k = 0; k < FACETS; k++) {
                left_[k] -= k == turn ? seen.a : 0.0;
            }
        } while (meets != 0);
        vec4 seen = seen_mirrored(m, in_view(m, twice), 1.2 / resolved.z, wall) * left_twice;
        sum_twice += seen.rgb * again + seen.a * sea_light.rgb * (1.0 - again);
        left_twice -= seen.a;
    }
    for (int k = 0; k < FACETS; k++) {
        hidden += (1.0 - left_[k]) * skies_[k];
    }
    return sky * (1.0 - hidden / max(whole, vec3(1e-12))) + stands * tint * (sky.g / max(whole.g, 1e-12)) +
           lost * (second * left_twice + sum_twice);
}

#ifdef PEL_SHADED
float sun_on_sea(vec3 place)
{
    float share = 1.0;
    EACH_OBJECT(objects_near.y) {
        int i = findLSB(rest);
        float here = felt(place_texel(i, 13), 0.02, 0.0);
        vec3 at;
        bool held = shadow_place(i, from_object(placed_object(i), place), at);
        float lit = texture(object_shadows, vec4(at.xy, float(i), at.z));
        share *= held ? 1.0 - here * (1.0 - lit) : 1.0; // outside, where tiles do without it, exactly 1
    }
    return share;
}

#include "lib/keel.glsl"
#endif
