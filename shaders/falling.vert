#version 450 core
// A box about each streak of a shell of drops or flakes (optics/falling.h), cell
// by cell: all that a pixel needs is the streak's, in places of the lattice, so
// that tiles have the same.
#include "lib/blocks.h"
#include "lib/sky.glsl"
#include "lib/clouds.glsl"
#include "lib/fog.glsl"
#include "lib/beam.glsl"
#include "lib/falling.glsl"

layout(location = 0) uniform vec4 axis;   // w diameter, m, negative of flakes
layout(location = 1) uniform vec4 side;   // w streak, m
layout(location = 2) uniform vec4 motion; // x lives, whole, y the rest; z m in a life
layout(location = 3) uniform vec4 shell;  // x nearest, m; y columns; z cell, m; w seed
layout(location = 4) uniform vec4 chance; // x of a cell; y drops; z spread, m²; w 1: black
layout(location = 5) uniform vec4 within; // x first column, y rows, z first slope, w farthest, m

flat out vec4 streak, shape, light_of;

uint stirred(uint x)
{
    x ^= x >> 16u;
    x *= 0x7FEB352Du;
    x ^= x >> 15u;
    x *= 0x846CA68Bu;
    return x ^ (x >> 16u);
}

float part(uint bits, uint first)
{
    return (float((bits >> first) & 1023u) + 0.5) / 1024.0;
}

vec2 on_lattice(vec3 p, float ahead)
{
    return vec2(dot(p, right.xyz) / pixel.x, -dot(p, up.xyz) / pixel.y) / ahead;
}

void main()
{
    int cell = gl_VertexID / 6;
    int corner = gl_VertexID - 6 * cell;
    int rows = int(within.y);
    int column = int(within.x) + cell / rows;
    uint own = stirred(uint(column) + uint(shell.w) * 0x9E3779B1u);
    float away = shell.x * sqrt(1.0 + 3.0 * part(own, 0u));
    float life = motion.y + part(own, 10u);
    float fallen = motion.z * fract(life);
    float row = floor((away * within.z - fallen) / shell.z) + float(cell % rows);
    uint drop = stirred(own + uint(int(row)) * 0x85EBCA77u + uint(motion.x + floor(life)) * 0xC2B2AE3Du);
    bool there = part(stirred(drop), 22u) < chance.x;

    bool flake = axis.w < 0.0;
    float far = (row + 0.5) * shell.z + 0.5 * (part(drop, 10u) - 0.5) * (shell.z - side.w) + fallen;
    float place = float(column) + 0.5 + 0.5 * (part(drop, 0u) - 0.5);
    if (flake) {
        // They sway, neighbours alike.
        float sway = far * 0.7 + 3.0 * motion.y + float(column) * 0.01;
        place += 0.35 * sin(2.0 * PI * sway) + 0.2 * sin(2.0 * PI * (7.0 * motion.y - 1.9 * far) + shell.x);
    }
    float turn = 2.0 * PI * place / shell.y - PI;
    vec3 middle = away * (cos(turn) * side.xyz + sin(turn) * cross(axis.xyz, side.xyz)) + far * axis.xyz;
    float distance_ = length(middle);
    vec3 dir = middle / distance_;
    vec3 half_ = 0.5 * side.w * axis.xyz;
    float ahead = -dot(middle, back.xyz);
    float turned = dot(half_, back.xyz);
    there = there && ahead - abs(turned) > 0.1 * away;
    vec2 from = on_lattice(middle - half_, ahead + turned);
    vec2 to = on_lattice(middle + half_, ahead - turned);
    float long_ = max(length(to - from), 0.05);
    vec2 way = (to - from) / long_;
    way = dot(way, way) > 0.5 ? way : vec2(1.0, 0.0);

    // Until the sea.
    float reach = dir.z < 0.0 ? eye.x / -dir.z : 1e9;
    float sine = away / distance_;
    float weight = chance.y * aside(sine) * clamp(4.0 * (reach / distance_ - 1.0), 0.0, 1.0);
    weight *= smoothstep(0.9 * PEL_FALL_NEAREST_M, 1.1 * PEL_FALL_NEAREST_M, distance_);
    weight *= 1.0 - smoothstep(PEL_FALL_FADES * within.w, within.w, distance_);
    float size_ = abs(axis.w) * (0.8 + 0.4 * part(drop, 22u));
    float px = 1.0 / (pixel.x * ahead); // pixels a metre
    float wide = 0.4375 * (size_ * size_ + PEL_FALL_LENS_M * PEL_FALL_LENS_M) + chance.z;
    wide = sqrt(wide * px * px + PEL_FALL_PIXEL);
    // Its solid angle in pixels'; 1.0133: of the mean of squared sizes.
    float area = 0.25 * PI / 1.0133 * size_ * size_ * distance_ / (pixel.x * pixel.y * ahead * ahead * ahead);
#if defined(PEL_CLOUDS) || defined(PEL_FOG)
    veil_lights_evenly();
#endif
    streak = vec4(0.5 * (from + to), way);
    shape = vec4(wide, long_, weight * area, 0.0);
    light_of = vec4(chance.w > 0.5 ? vec3(0.0) : fallen_light(dir, flake), 0.0);
    vec2 box = vec2(corner == 1 || corner == 3 || corner == 4 ? 1.0 : -1.0, corner == 2 || corner >= 4 ? 1.0 : -1.0);
    box *= vec2(0.5 * long_ + wide, wide); // of nothing beyond
    vec2 at = streak.xy - pixel.zw + box.x * way + box.y * vec2(-way.y, way.x);
    gl_Position = vec4(at / size.xy * 2.0 - 1.0, 0.0, 1.0);
    if (!there || !(weight > 0.0)) {
        gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
    }
}
