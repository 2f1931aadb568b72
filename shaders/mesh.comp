#version 450 core
// Displaces the mesh: rings around the eye's nadir, columns of equal azimuth
// counted from east. A vertex depends on the eye, its ring and its column
// only, so all views from one eye see one surface.
#include "lib/blocks.h"
#include "lib/together.glsl"
#include "lib/turns.glsl"
#include "lib/vertex.glsl"
#ifdef PEL_AREAS
#include "lib/areas.glsl"
#endif
#include "lib/spline.glsl"
#ifdef PEL_SHORE
#include "lib/shore.glsl"
#endif
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif

#ifdef PEL_WAKES
#include "lib/wake.glsl"
#endif

layout(local_size_x = PEL_GROUP_LINE) in;

layout(std430, binding = PEL_STORE_VERTICES) buffer vertices_block { vertex vertices[]; };
// Radius of each ring and the length of its cells.
layout(std430, binding = PEL_STORE_RINGS) readonly buffer rings_block { vec2 rings[]; };

#ifndef PEL_TOGETHER
layout(location = 0) uniform int block_count;
layout(location = 1) uniform ivec4 blocks[PEL_MESH_MAX_BLOCKS]; // first ring, rings, first column, columns
layout(location = 1 + PEL_MESH_MAX_BLOCKS) uniform int bases[PEL_MESH_MAX_BLOCKS];   // first vertex
#endif

void main()
{
    take_view();
    int v = int(gl_GlobalInvocationID.x);
    int b = 0;
    while (b + 1 < MESH_BLOCKS && v >= MESH_BASE(b + 1)) {
        b++;
    }
    ivec4 block = MESH_BLOCK(b);
    int index = v - MESH_BASE(b);
    if (index >= block.y * block.w) {
        return;
    }
    int row = index / block.w;
    int place_in_row = index % block.w;
    int ring = block.x + row;
    int column = (block.z + place_in_row) % COLUMNS_AROUND;
    vec2 r = rings[FIRST_RING + ring];
    float angle = float(column) * COLUMN_ANGLE;
    vec2 x = r.x * vec2(cos(angle), sin(angle));
#ifdef PEL_FFT
    vec3 shift = cascade_shift(x, r.y);
#else
    float scale = up.w / r.y;
    float offset = -right.w * up.w;
    vec3 shift = vec3(0.0);
#ifdef PEL_AREAS
    vec3 washed;
    float higher = short_waves(x, r.y, washed);
#define PEL_UP(phase)                                                          \
    float up = phase.w < PEL_AREA_SHORTER_M ? higher : 1.0;                    \
    sc *= vec2(min(up, 1.0), up);
#else
#define PEL_UP(phase)
#endif
#ifdef PEL_SHORE
    shored here[PEL_SHORE_BANDS + 1];
    shore_of_waves(x, here);
#define PEL_READ                                                               \
    shored ashore = here[wave_band(wave_)];                                    \
    vec2 read = ashore.read;
#define PEL_GROWN sc *= vec2(ashore.b, ashore.a);
#else
#define PEL_READ vec2 read = x;
#define PEL_GROWN
#endif
#define PEL_DISPLACE(phase, wander)                                            \
    PEL_READ                                                            \
    float h = wander.w * filter_weight(phase.w * scale + offset);              \
    vec2 sc = h * sine_cosine_turns(wave_turns(phase, read, wandered(wander, read))); \
    PEL_UP(phase)                                                              \
    PEL_GROWN                                                                  \
    shift += vec3((-wave_chop(phase) * sc.x) * phase.xy, sc.y);
    PEL_EACH_WAVE(PEL_DISPLACE)
    shift *= 0.159154943; // 1 / 2π
#endif
#ifdef PEL_WAKES
    shift += wake_at(x + shift.xy, 0.25 * r.y).d;
#endif
    uint beside = (place_in_row > 0 ? VERTEX_LEFT : 0u) | (row > 0 ? VERTEX_INNER : 0u) |
                  (row + 1 < block.y ? VERTEX_OUTER : 0u);
    // The sphere under the eye: arc r.x becomes a chord and a drop.
    float half_arc = 0.5 * r.x / planet.x;
    float drop = 2.0 * planet.x * sin(half_arc) * sin(half_arc);
    vec3 place = vec3(x * cos(half_arc), -drop - eye.x);
    vertices[FIRST_VERTEX + v].position = vec4(place + shift, float(block.w));
    vertices[FIRST_VERTEX + v].rest = vec4(x, float(beside | uint(b) << VERTEX_BLOCK), float(ring));
}
