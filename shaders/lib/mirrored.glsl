// What objects do to the sea beside them: they stand in the mirrored rays, and
// their shadow lies on it.
#include "lib/model.glsl"
#include "lib/shadow.glsl"

layout(binding = PEL_UNIT_MIRRORS) uniform sampler2DArray mirrors;
layout(location = PEL_UNIFORM_NEAR) uniform ivec2 objects_near; // masks: mirrored, shading

vec3 sea_place = vec3(0.0); // of the pixel, from the eye
vec2 sea_pixel = vec2(0.0); // its place on the lattice
float sea_lit = 1.0;  // share of the Sun there

// Distance along the ray from p, in the model's axes, at which it comes to the
// model's outline, or nearest to its middle.
float outline_distance(int i, vec3 p, vec3 r)
{
    vec4 plan = texelFetch(object_places, i * PEL_OBJECT_PLACE_TEXELS + 4);
    vec2 inverse = 1.0 / mix(vec2(1e-6), r.xy, greaterThan(abs(r.xy), vec2(1e-6)));
    vec2 a = (plan.xy - p.xy) * inverse;
    vec2 b = (plan.xy + 1.0 / plan.zw - p.xy) * inverse;
    vec2 first = min(a, b);
    vec2 last = max(a, b);
    float enters = max(first.x, first.y);
    float leaves = min(last.x, last.y);
    float nearest = -dot(p.xy, r.xy) / max(dot(r.xy, r.xy), 1e-6);
    return max(enters < leaves && leaves > 0.0 ? enters : nearest, 0.0);
}

// How much of what an object does to the sea a pixel gets: all but close to the
// edge of the rectangle, on the lattice, outside of which it does nothing.
float felt(vec4 box)
{
    vec2 off = min(sea_pixel - box.xy, box.zw - sea_pixel) / max(0.08 * (box.zw - box.xy), vec2(1.0));
    return clamp(min(off.x, off.y), 0.0, 1.0);
}

// Radiance of the objects that rays from the pixel's place meet, and how many of
// them do: by a view of each from the eye's image in the sea. `ways`: towards
// where, and by how much the rays differ, rad.
void objects_mirrored(vec4 ways[3], out vec4 seen[3])
{
    seen[0] = seen[1] = seen[2] = vec4(0.0);
    for (int left = objects_near.x; left != 0; left &= left - 1) {
        int i = findLSB(left);
        int first = i * PEL_OBJECT_PLACE_TEXELS + 8;
        vec4 forward = texelFetch(object_places, first);
        vec4 across = texelFetch(object_places, first + 1);
        vec4 upward = texelFetch(object_places, first + 2);
        vec4 window_ = texelFetch(object_places, first + 3);
        float here = felt(texelFetch(object_places, first + 4));
        placed o = placed_object(i);
        vec3 p = into_model(o, sea_place);
        // From the image of the eye.
        vec3 from = sea_place - vec3(0.0, 0.0, across.w);
        for (int k = 0; k < 3; k++) {
            vec3 r = ways[k].xyz;
            float away = outline_distance(i, p, vec3(dot(r, o.x), dot(r, o.y), dot(r, o.z)));
            vec3 sight = from + away * r;
            float depth = dot(sight, forward.xyz);
            vec2 uv = (vec2(dot(sight, across.xyz), dot(sight, upward.xyz)) / depth - window_.xy) * window_.zw;
            float texels = ways[k].w * away / depth * window_.z * float(PEL_MIRROR_WIDTH);
            vec4 met = textureLod(mirrors, vec3(uv, forward.w), log2(max(texels, 1.0)));
            seen[k] += depth > 0.0 ? met * ((1.0 - seen[k].a) * here) : vec4(0.0);
        }
    }
}

float sun_on_sea(vec3 place)
{
    float share = 1.0;
    for (int left = objects_near.y; left != 0; left &= left - 1) {
        int i = findLSB(left);
        float here = felt(texelFetch(object_places, i * PEL_OBJECT_PLACE_TEXELS + 13));
        vec3 at;
        bool held = shadow_place(i, from_object(placed_object(i), place), at);
        float lit = texture(object_shadows, vec4(at.xy, float(i), at.z));
        share *= held ? 1.0 - here + here * lit : 1.0;
    }
    return share;
}
