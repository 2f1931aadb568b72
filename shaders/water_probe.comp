#version 450 core
// Lines of sight into a level sea, as the pixels look the water's light up
// (render/waterprobe.h).
#include "lib/blocks.h"
#include "lib/water.glsl"

layout(local_size_x = PEL_GROUP_WATER) in;
layout(std430, binding = PEL_STORE_PROBE) restrict readonly buffer views_block { vec4 views[]; }; // to the eye
layout(std430, binding = PEL_STORE_PROBE_ANSWERS) restrict writeonly buffer answers_block { vec4 answers[]; };

void main()
{
    int i = int(gl_GlobalInvocationID.x);
    if (i >= views.length()) {
        return;
    }
    const vec3 up = vec3(0.0, 0.0, 1.0);
    water_light l = water_parts(0, water_place(views[i].xyz, up, lights[0].direction.xyz), views[i].w, vec3(1.0));
    answers[4 * i] = vec4(l.single, 0.0);
    answers[4 * i + 1] = vec4(l.second, 0.0);
    answers[4 * i + 2] = vec4(l.higher, 0.0);
    answers[4 * i + 3] = vec4(l.bottom, 0.0);
}
