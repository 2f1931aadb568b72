#include "render/cloudsystems.h"

#include <math.h>
#include <stdint.h>

static void hash(const uint32_t at[3], uint32_t v[3])
{
    for (int i = 0; i < 3; i++) {
        v[i] = at[i] * 1664525u + 1013904223u;
    }
    for (int round = 0; round < 2; round++) {
        v[0] += v[1] * v[2];
        v[1] += v[2] * v[0];
        v[2] += v[0] * v[1];
        for (int i = 0; i < 3 && round == 0; i++) {
            v[i] ^= v[i] >> 16;
        }
    }
}

static void noise_at(const double p[3], double sum[3])
{
    double f[3];
    uint32_t cell[3];
    for (int i = 0; i < 3; i++) {
        double low = floor(p[i]), x = p[i] - low;
        f[i] = x * x * (3 - 2 * x);
        cell[i] = (uint32_t)((int32_t)low + 4096);
        sum[i] = 0;
    }
    for (uint32_t k = 0; k < 8; k++) {
        uint32_t at[3], v[3];
        double w = 1;
        for (int i = 0; i < 3; i++) {
            uint32_t off = k >> i & 1;
            at[i] = cell[i] + off;
            w *= off ? f[i] : 1 - f[i];
        }
        hash(at, v);
        for (int i = 0; i < 3; i++) {
            sum[i] += (v[i] >> 8) / 16777216.0 * w;
        }
    }
}

void pel_cloud_systems(struct pel_vec3 earth, double from,
                       double octaves[PEL_CLOUD_OCTAVES])
{
    double p[3] = { 2.4 * earth.x + from, 2.4 * earth.y + from,
                    3.4 * earth.z + from };
    double noise[3];
    noise_at(p, noise);
    octaves[0] = noise[0] - 0.5;
    for (int i = 0; i < 3; i++) {
        p[i] += 0.9 * (noise[(i + 1) % 3] - 0.5);
    }
    for (int i = 1; i < PEL_CLOUD_OCTAVES; i++) {
        const double q[3] = { 0.8 * p[0] - 0.6 * p[1], 0.6 * p[0] + 0.8 * p[1],
                              p[2] };
        for (int k = 0; k < 3; k++) {
            p[k] = 2.2 * q[k] + 17.3;
        }
        noise_at(p, noise);
        octaves[i] = noise[0] - 0.5;
    }
}
