/* Random numbers that are a function of a seed: xoshiro256++ (Blackman and
 * Vigna 2019), seeded by splitmix64. */
#ifndef SEARANDOM_H
#define SEARANDOM_H

#include <math.h>
#include <stdint.h>

struct sea_random {
    uint64_t s[4];
};

static inline void sea_random_init(struct sea_random *random, uint64_t seed)
{
    for (int i = 0; i < 4; i++) {
        seed += 0x9e3779b97f4a7c15u;
        uint64_t z = seed;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        random->s[i] = z ^ (z >> 31);
    }
}

/* In [0, 1). */
static inline double sea_random_unit(struct sea_random *random)
{
    uint64_t *s = random->s;
    uint64_t sum = s[0] + s[3];
    uint64_t out = ((sum << 23) | (sum >> 41)) + s[0];
    uint64_t t = s[1] << 17;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= t;
    s[3] = (s[3] << 45) | (s[3] >> 19);
    return (double)(out >> 11) * 0x1p-53;
}

/* Two independent numbers of the normal distribution (Box and Muller). */
static inline void sea_random_normal(struct sea_random *random, double *a,
                                     double *b)
{
    double r = sqrt(-2 * log(1 - sea_random_unit(random)));
    double angle = 2 * 3.14159265358979323846 * sea_random_unit(random);
    *a = r * cos(angle);
    *b = r * sin(angle);
}

#endif
