#version 450 core
// A square about each drop on a pane before the camera (render/panemap.h): those
// that sit, in cells of the pane, and those that run down, in columns, each with
// the beads that it leaves. All by hashes of cells and of lives.
#include "lib/blocks.h"

layout(location = 0) uniform vec4 pane;   // x amount; yzw lives of PEL_PANE_LIFE_S: whole, the rest, seed
layout(location = 1) uniform vec4 cells;  // xy first column and row; z columns; w side, tangent; 0 beads
layout(location = 2) uniform vec4 sizes;  // xy least and most radius, tangent; z chance; w kind

flat out vec4 drop; // middle on the lattice; radius, px; its share of 1
flat out vec4 bent; // middle, tangents; z lengthened
flat out vec4 form; // xyz how it is no circle

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

uint hash_of(int x, int y, uint born, uint kind)
{
    uint h = stirred(uint(x) * 0x9E3779B1u + kind * 0x27D4EB2Fu + uint(pane.w));
    return stirred(h + uint(y) * 0x85EBCA77u + born * 0xC2B2AE3Du);
}

struct runner {
    float x;    // of its way, tangent
    float from; // where it begins, tangent
    float at;   // how far it has come, 0 to 1
    float fat;  // radius
    float bend;
    bool there;
};

// Of a column of runners, at this moment.
runner runner_of(int column)
{
    uint own = hash_of(column, 0, 0u, 9u);
    float life = pane.z + part(own, 0u);
    uint now = hash_of(column, 1, uint(pane.y + floor(life)), 9u);
    runner r;
    r.x = (float(column) + 0.5 + 0.5 * (part(now, 0u) - 0.5)) * PEL_PANE_RUN_WIDE;
    r.from = PEL_PANE_TOP * (2.0 * part(now, 10u) - 0.6);
    float u = fract(life);
    // It sticks and slips.
    r.at = u - 0.024 * sin(2.0 * 3.14159265 * (5.0 * u + part(own, 10u)));
    r.fat = mix(0.008, 0.013, part(now, 20u));
    r.bend = part(own, 20u);
    r.there = part(stirred(now), 0u) < PEL_PANE_RUNS * pane.x;
    return r;
}

float run_y(runner r, float at)
{
    return r.from - 1.4 * at;
}

float run_x(runner r, float y)
{
    return r.x + 0.006 * sin(24.0 * y + 6.0 * r.bend) + 0.004 * sin(61.0 * y + 9.0 * r.bend);
}

void main()
{
    int cell = gl_VertexID / 6;
    int corner = gl_VertexID - 6 * cell;
    int columns = int(cells.z);
    int column = int(cells.x) + cell % columns;
    int row = int(cells.y) + cell / columns;
    uint kind = uint(sizes.w);
    vec2 middle;
    float radius;
    float share = 1.0;
    float longer = 1.0;
    bool there;
    uint own;
    if (cells.w > 0.0) {
        own = hash_of(column, row, 0u, kind);
        float life = pane.z * 0.5 + part(own, 0u) + 0.5 * mod(pane.y, 2.0);
        uint now = hash_of(column, row, uint(floor(pane.y * 0.5) + floor(life)), kind + 16u);
        float u = fract(life);
        middle = (vec2(column, row) + 0.5 + 0.5 * (vec2(part(now, 0u), part(now, 10u)) - 0.5)) * cells.w;
        radius = mix(sizes.x, sizes.y, part(now, 20u) * part(own, 10u));
        // It lands, sits, dries.
        share = smoothstep(0.0, 0.01, u) * (1.0 - smoothstep(0.85, 1.0, u));
        there = part(stirred(now), 10u) < sizes.z * pane.x;
        // A runner takes it along.
        for (int i = -1; i <= 1; i++) {
            runner r = runner_of(int(floor(middle.x / PEL_PANE_RUN_WIDE)) + i);
            bool met = abs(run_x(r, middle.y) - middle.x) < r.fat + radius;
            bool passed = middle.y > run_y(r, r.at) && middle.y < r.from;
            share *= r.there && met && passed ? 0.0 : 1.0;
        }
    } else {
        // Row 0 is the runner, others its beads.
        runner r = runner_of(column);
        own = hash_of(column, row, 0u, 40u);
        float step_ = float(row) / float(PEL_PANE_BEADS);
        float y = row == 0 ? run_y(r, r.at) : run_y(r, step_);
        uint bead = hash_of(column, row, uint(pane.y), kind + 32u);
        bead = row == 0 ? bead : hash_of(column, row, uint(1024.0 * r.bend), kind + 32u);
        float since = r.at - step_;
        middle = vec2(run_x(r, y), y);
        radius = row == 0 ? r.fat : r.fat * mix(0.15, 0.45, part(bead, 0u)) * (1.0 - 0.6 * clamp(since * 1.5, 0.0, 1.0));
        longer = row == 0 ? 1.35 : 1.0;
        middle.y += row == 0 ? 0.0 : 0.01 * (part(bead, 10u) - 0.5);
        share = row == 0 ? 1.0 : smoothstep(0.0, 0.02, since);
        share *= 1.0 - smoothstep(0.94, 1.0, r.at);
        there = r.there;
    }
    radius *= min(1.0, 0.4 + 0.6 * share);
    vec2 place = vec2(middle.x, -middle.y) / pixel.xy;
    float px = radius / pixel.x;
    drop = vec4(place, px, share);
    bent = vec4(middle, longer, 0.0);
    own = stirred(own);
    form = vec4(vec3(part(own, 0u), part(own, 10u), part(own, 20u)) - 0.5, 0.0);
    form.xyz *= radius > 0.004 && longer == 1.0 ? vec3(0.6, 0.6, 0.5) : vec3(0.2);
    vec2 box = vec2(corner == 1 || corner == 3 || corner == 4 ? 1.0 : -1.0, corner == 2 || corner >= 4 ? 1.0 : -1.0);
    vec2 at = place - pixel.zw + box * (1.3 * longer * px + PEL_PANE_SOFT / pixel.x + 2.0);
    bool whole = there && share > 0.0;
    gl_Position = whole ? vec4(at / size.xy * 2.0 - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}
