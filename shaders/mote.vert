#version 450 core
// A point for each particle near an eye in the water (optics/motes.h): where
// waves have carried it, how wide it is in the picture, and its light. Places are
// those of the lattice, so that tiles have the same.
#define PEL_UNDER
#include "lib/blocks.h"
#include "lib/turns.glsl"
#include "lib/spline.glsl"
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#undef PEL_STORED // in graphics a device may have none for vertices
#include "lib/waves.glsl"
#endif
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/water.glsl"
#include "lib/shaded.glsl"
layout(binding = PEL_UNIT_REFLECTION) uniform sampler2D reflection_map;
#include "lib/ross.glsl"
#include "lib/underlight.glsl"
#include "lib/underlamps.glsl"

layout(std430, binding = PEL_STORE_MOTES) restrict readonly buffer motes_block { vec4 motes[]; };
layout(location = 0) uniform vec4 falls; // of each cascade: how its waves fall with depth, 1/m
layout(location = 1) uniform float seen_; // drawn as far as diameters times this

flat out vec4 disc;     // xy its middle on the lattice; z radius, px; w share of a pixel's light in its middle
flat out vec4 light_of; // rgb; w how far away

// Of the water that rests at x from the eye's nadir, z m deep: waves of length λ
// fall as e^(-2 π z / λ).
vec3 carried(vec2 x, float z)
{
    vec3 sum = vec3(0.0);
#ifdef PEL_FFT
    reading at = reading_at(x);
    for (int c = 0; c < PEL_CASCADES - 1; c++) {
        shear(c, x, at);
        sum += exp(-falls[c] * z) * spline(c, cascade_uv(c, at.place), 0.0);
    }
#else
    float scale = 1.0 / max(z, 0.05);
    const float offset = -1.0;
#define PEL_CARRY(phase, wander)                                               \
    vec2 sc = sine_cosine_turns(wave_turns(phase, x, wandered(wander, x)));    \
    sum += exp(-2.0 * PI * z / phase.w) * wander.w *                           \
           vec3((-wave_chop(phase) * sc.x) * phase.xy, sc.y);
    PEL_EACH_WAVE(PEL_CARRY)
    sum *= 0.159154943; // 1 / 2π
#endif
    return sum;
}

// What a white sphere sends to where it is seen from, times 4 π, over what falls
// on it, half of it as if light went through it (Schönberg 1929; porous
// aggregates); to: where the light comes from.
float mote_phase(vec3 to, vec3 sight)
{
    float c = clamp(-dot(to, sight), -1.0, 1.0);
    float matt = 8.0 / (3.0 * PI) * (sqrt(1.0 - c * c) + (PI - fast_acos(c)) * c);
    return 0.5 + 0.5 * matt;
}

vec3 mote_light(vec3 place, vec3 sight, float z)
{
    vec3 light = under_flux(z, 0.0) / PEL_MOTE_COSINE_DOWN + under_flux(z, 1.0) / PEL_MOTE_COSINE_UP;
    for (int i = 0; i < PEL_LIT; i++) {
        light += under_beam(i, z) * mote_phase(under_beams[i].xyz, sight);
    }
#ifdef PEL_LAMPS_BELOW
    for (int i = 0; i < under_lamp_count(); i++) {
        vec3 to;
        vec3 beam = under_lamp_falling(i, place, to);
        light += beam * mote_phase(to, sight);
    }
#endif
    return light * (PEL_MOTE_WHITE / (4.0 * PI));
}

void main()
{
    vec4 mote = motes[gl_VertexID];
    float deep = max(under_eye.x - mote.z, 0.0);
    vec3 p = mote.xyz + carried(mote.xy, deep);
    float away = length(p);
    vec3 sight = p / away;
    float ahead = -dot(p, back.xyz);
    vec2 place = vec2(dot(p, right.xyz) / pixel.x, -dot(p, up.xyz) / pixel.y) / ahead;
    float px = 1.0 / (pixel.x * ahead); // pixels a metre
    float area = 0.25 * PI * mote.w * mote.w * px * px * (away / ahead); // its solid angle in pixels'
    // The lens, focused on what is far, makes a disc of its opening of a point.
    float wide = max(0.5 * px * sqrt(mote.w * mote.w + PEL_FALL_LENS_M * PEL_FALL_LENS_M), 0.7);
    float farthest = seen_ * mote.w;
    float fades = smoothstep(PEL_MOTE_NEAREST_M, 1.5 * PEL_MOTE_NEAREST_M, away) *
                  (1.0 - smoothstep(0.7 * farthest, farthest, away));
    disc = vec4(place, wide, fades * area / (PI * (wide * wide + 0.49 / 3.0)));
    veil_water();
    float z = max(under_depth() - p.z, 0.0);
    // With the water before it, in whose place it is seen.
    light_of = vec4(under_left(away) * mote_light(p, sight, z) + water_between(sight, under_depth(), away) +
                        suns_between(sight, under_depth(), away),
                    away);
    vec2 at = (place - pixel.zw + float(PEL_MOTE_MARGIN)) / (size.xy + 2.0 * float(PEL_MOTE_MARGIN));
    bool shown = ahead > 0.5 * away * 0.2 && disc.w > 1e-4 && wide < 0.5 * float(PEL_MOTE_MARGIN) && z > 0.0;
    gl_Position = shown ? vec4(at * 2.0 - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
    gl_PointSize = 2.0 * wide + 4.0;
}
