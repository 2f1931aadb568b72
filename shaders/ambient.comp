#version 450 core
// The light of the surroundings on a surface by its normal: their spherical
// harmonics, the cosine folded in (Ramamoorthi and Hanrahan 2001).
#include "lib/blocks.h"

layout(local_size_x = PEL_GROUP_LINE) in;
layout(binding = PEL_UNIT_SURROUNDINGS) uniform sampler2D map;
layout(std430, binding = PEL_STORE_SURROUNDINGS) writeonly buffer out_block {
    vec4 out_ambient[2 * PEL_SURROUNDINGS_TERMS];
};

shared vec4 partial[PEL_GROUP_LINE];

// Of a sum over directions times the base at them, weights of the light by the
// polynomials in lib/objects.glsl: products of the bases' constants, the
// cosine's 1, 2/3 and 1/4.
const float CONSTANT = 0.28209479, LINEAR = 0.48860251, MIXED = 1.09254843, ZONAL = 0.31539157,
            SQUARES = 0.54627422;
const float FACTORS[PEL_SURROUNDINGS_TERMS] =
    float[](CONSTANT * CONSTANT, LINEAR * LINEAR * 2.0 / 3.0, LINEAR * LINEAR * 2.0 / 3.0,
            LINEAR * LINEAR * 2.0 / 3.0, MIXED * MIXED * 0.25, MIXED * MIXED * 0.25,
            ZONAL * ZONAL * 0.25, MIXED * MIXED * 0.25, SQUARES * SQUARES * 0.25);

float base(int k, vec3 n)
{
    switch (k) {
    case 0: return 1.0;
    case 1: return n.y;
    case 2: return n.z;
    case 3: return n.x;
    case 4: return n.x * n.y;
    case 5: return n.y * n.z;
    case 6: return 3.0 * n.z * n.z - 1.0;
    case 7: return n.x * n.z;
    }
    return n.x * n.x - n.y * n.y;
}

void main()
{
    int lane = int(gl_LocalInvocationID.x);
    const int N = PEL_SURROUNDINGS_SIZE;
    for (int j = 0; j < 2 * PEL_SURROUNDINGS_TERMS; j++) {
        int k = j % PEL_SURROUNDINGS_TERMS;
        float highest = j < PEL_SURROUNDINGS_TERMS ? 2.0 : 0.0;
        vec4 sum = vec4(0.0);
        for (int i = lane; i < N * N; i += PEL_GROUP_LINE) {
            vec2 e = (vec2(i % N, i / N) + 0.5) * (2.0 / float(N)) - 1.0;
            vec3 dir = vec3(e, 1.0 - abs(e.x) - abs(e.y));
            float fold = max(-dir.z, 0.0);
            dir.xy -= vec2(dir.x >= 0.0 ? fold : -fold, dir.y >= 0.0 ? fold : -fold);
            float inverse = inversesqrt(dot(dir, dir));
            // A texel's solid angle is in proportion to this.
            float weight = inverse * inverse * inverse;
            vec3 light = dir.z < highest ? texelFetch(map, ivec2(i % N, i / N), 0).rgb * dusk.y : vec3(0.0);
            sum += vec4(light * base(k, dir * inverse), 1.0) * weight;
        }
        partial[lane] = sum;
        barrier();
        for (int stride = PEL_GROUP_LINE / 2; stride > 0; stride >>= 1) {
            if (lane < stride) {
                partial[lane] += partial[lane + stride];
            }
            barrier();
        }
        if (lane == 0) {
            const float SPHERE = 12.5663706;
            out_ambient[j] = vec4(partial[0].rgb * (FACTORS[k] * SPHERE / partial[0].w), 0.0);
        }
        barrier();
    }
}
