#version 450 core
// The modes of the sea at this time, and the transform along their rows. The
// contract is in ocean/cascade.h; one workgroup a row, z the cascade.
#include "lib/blocks.h"
#include "lib/fft.glsl"

layout(local_size_x = 64) in;
layout(binding = PEL_UNIT_AMPLITUDES) uniform sampler2DArray amplitudes; // h0(k), conj h0(−k)
layout(binding = PEL_UNIT_MODES) uniform sampler2DArray modes;      // turns/s, chop
layout(std430, binding = PEL_STORE_LINES) writeonly buffer lines_block { vec4 lines[]; };
layout(std430, binding = PEL_STORE_MODES) readonly buffer modes_block {
    vec4 cascade[PEL_CASCADES];  // length, turn cos, turn sin
    vec2 gain[PEL_CASCADE_N]; // displacement, slopes, along one axis
};
layout(location = 0) uniform double time;

void main()
{
    int lane = int(gl_LocalInvocationID.x);
    int row = int(gl_WorkGroupID.y);
    int c = int(gl_WorkGroupID.z);
    float unit = 6.283185307 / cascade[c].x;
    vec2 turn = cascade[c].yz;
    vec4 ab[4];
    vec4 cd[4];
    for (int r = 0; r < 4; r++) {
        int column = lane + r * FFT_LANES;
        vec4 h0 = texelFetch(amplitudes, ivec3(column, row, c), 0);
        vec2 mode = texelFetch(modes, ivec3(column, row, c), 0).xy;
        double turns = double(mode.x) * time;
        float angle = 6.283185307 * float(turns - floor(turns));
        float co = cos(angle);
        float si = sin(angle);
        vec2 h = vec2(h0.x * co + h0.y * si + h0.z * co - h0.w * si,
                      h0.y * co - h0.x * si + h0.w * co + h0.z * si);
        vec2 at = vec2(column < PEL_CASCADE_N / 2 ? column : column - PEL_CASCADE_N,
                       row < PEL_CASCADE_N / 2 ? row : row - PEL_CASCADE_N);
        vec2 k = unit * (at.x * turn + at.y * vec2(-turn.y, turn.x));
#ifdef PEL_FOAM
        // Σ k h e^{iφ}: the waves of k alone, twice (ocean/foam.h).
        float slope_gain = gain[column].y * gain[row].y;
        vec2 alone = vec2(h0.x * co + h0.y * si, h0.y * co - h0.x * si);
        ab[r] = vec4(2.0 * slope_gain * sqrt(dot(k, k)) * alone, 0.0, 0.0);
        cd[r] = vec4(0.0);
#else
        vec2 chop = mode.y * k * inversesqrt(max(dot(k, k), 1e-20));
        float shift_gain = gain[column].x * gain[row].x;
        float slope_gain = gain[column].y * gain[row].y;
        // Pairs of real fields f, g as f + i g: (Dx, Dy), (h, ∂Dx/∂y),
        // (∂h/∂x, ∂h/∂y), (∂Dx/∂x, ∂Dy/∂y).
        ab[r] = vec4(turned(h, shift_gain * vec2(-chop.y, chop.x)),
                     turned(h, vec2(shift_gain, -slope_gain * chop.x * k.y)));
        cd[r] = slope_gain * vec4(turned(h, vec2(-k.y, k.x)),
                                  turned(h, -chop * k));
#endif
    }
    transform_line(lane, ab, cd);
    int base = ((c * PEL_CASCADE_N + row) * PEL_CASCADE_N) * 2;
    for (int r = 0; r < 4; r++) {
        int column = lane + r * FFT_LANES;
        lines[base + 2 * column] = ab[r];
        lines[base + 2 * column + 1] = cd[r];
    }
}
