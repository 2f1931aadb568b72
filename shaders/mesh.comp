#version 450 core
// Displaces the mesh: rings around the eye's nadir, columns of equal azimuth
// counted from east. A vertex depends on the eye, its ring and its column
// only, so all views from one eye see one surface.
// One dispatch adds PEL_WAVE_CHUNK waves, the first one also the sphere: a
// block goes without the dispatches whose waves its cells cannot carry.
#define PEL_WAVE_LIMIT 20
#include "lib/blocks.h"
#define PEL_WAVES PEL_WAVE_CHUNK
#ifdef PEL_FFT
#include "lib/cascades.glsl"
#else
#include "lib/waves.glsl"
#endif

layout(local_size_x = 64) in;

struct vertex {
    vec4 position; // from the eye; w: column count of its block
    vec4 rest;     // place at rest, from the eye's nadir
};
layout(std430, binding = 0) buffer vertices_block { vertex vertices[]; };
// Radius of each ring and the length of its cells.
layout(std430, binding = 1) readonly buffer rings_block { vec2 rings[]; };

layout(location = 0) uniform ivec4 block; // first ring, rings, first column, columns
layout(location = 1) uniform int base;    // first vertex
layout(location = 2) uniform int first;   // 1: vertices are not there yet

void main()
{
    int index = int(gl_GlobalInvocationID.x);
    if (index >= block.y * block.w) {
        return;
    }
    int ring = block.x + index / block.w;
    int column = (block.z + index % block.w) % int(eye.w);
    vec2 r = rings[ring];
    float angle = float(column) * eye.z;
    vec2 x = r.x * vec2(cos(angle), sin(angle));
#ifdef PEL_FFT
    vec3 shift = cascade_shift(x, r.y);
#else
    float scale = up.w / r.y;
    float offset = -right.w * up.w;
    vec3 shift = vec3(0.0);
#define PEL_DISPLACE(i)                                                        \
    {                                                                          \
        float w = filter_weight(waves[i].phase.w * scale + offset);             \
        float turns = dot(waves[i].phase.xy, x) + waves[i].phase.z;              \
        shift.xy -= waves[i].shift.xy * (w * sine_turns(turns));                \
        shift.z += waves[i].shift.z * (w * sine_turns(turns + 0.25));           \
    }
    PEL_EACH_WAVE(PEL_DISPLACE)
#endif
    int v = base + index;
    if (first == 1) {
        // The sphere under the eye: arc r.x becomes a chord and a drop.
        float half_arc = 0.5 * r.x / planet.x;
        float drop = 2.0 * planet.x * sin(half_arc) * sin(half_arc);
        vec3 place = vec3(x * cos(half_arc), -drop - eye.x);
        vertices[v].position = vec4(place + shift, float(block.w));
        vertices[v].rest = vec4(x, 0.0, 0.0);
    } else {
        vertices[v].position.xyz += shift;
    }
}
