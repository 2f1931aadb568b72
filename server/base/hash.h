/* Counter-based random numbers: a function of (seed, stream, index). */
#pragma once

#include <stdint.h>

/* The finaliser of MurmurHash3. */
static inline uint64_t pel_hash_mix(uint64_t x)
{
    x ^= x >> 33;
    x *= UINT64_C(0xff51afd7ed558ccd);
    x ^= x >> 33;
    x *= UINT64_C(0xc4ceb9fe1a85ec53);
    x ^= x >> 33;
    return x;
}

/* In [0, 1). */
static inline double pel_hash01(uint32_t seed, uint32_t stream, uint32_t index)
{
    uint64_t key = pel_hash_mix((uint64_t)seed << 32 | stream);
    uint64_t bits =
        pel_hash_mix(key + UINT64_C(0x9e3779b97f4a7c15) * (index + 1u));
    return (double)(bits >> 11) * 0x1p-53;
}
