#include "photons.h"

#include <math.h>

#define CELLS PHOTON_CELLS
#define PI PHOTON_PI
#define INDEX PHOTON_INDEX

double photon_draw(uint64_t *random)
{
    uint64_t old = *random;
    *random = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27);
    unsigned turn = (unsigned)(old >> 59);
    x = (x >> turn) | (x << ((32 - turn) & 31));
    return ((double)x + 0.5) / 4294967296.0;
}

double photon_dot(struct photon_vector a, struct photon_vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

struct photon_vector photon_turned(uint64_t *random, struct photon_vector from,
                                   double cosine)
{
    double sine = sqrt(fmax(1.0 - cosine * cosine, 0.0));
    double around = 2.0 * PI * photon_draw(random);
    double c = cos(around), t = sin(around);
    double flat = sqrt(from.x * from.x + from.y * from.y);
    if (flat < 1e-9) {
        return (struct photon_vector){ sine * c, sine * t,
                                       from.z > 0 ? cosine : -cosine };
    }
    return (struct photon_vector){
        cosine * from.x + sine * (from.x * from.z * c - from.y * t) / flat,
        cosine * from.y + sine * (from.y * from.z * c + from.x * t) / flat,
        cosine * from.z - sine * flat * c,
    };
}

double photon_mirrored(double sine_water, double cos_water)
{
    double sine_air = INDEX * sine_water;
    if (sine_air >= 1.0) {
        return 1.0;
    }
    double cos_air = sqrt(1.0 - sine_air * sine_air);
    double s = (cos_air - INDEX * cos_water) / (cos_air + INDEX * cos_water);
    double p = (INDEX * cos_air - cos_water) / (INDEX * cos_air + cos_water);
    return 0.5 * (s * s + p * p);
}

double photon_tabulate(struct photon_phase *phase,
                       double (*at)(double angle, const void *of),
                       const void *of)
{
    double sum = 0.0;
    for (int i = 0; i <= CELLS; i++) {
        double half = (double)i / CELLS;
        phase->value[i] = at(2.0 * asin(half), of);
        if (i > 0) {
            /* dΩ = 4π d(half²) */
            double before = (double)(i - 1) / CELLS;
            sum += 0.5 * (phase->value[i] + phase->value[i - 1]) * 4.0 * PI *
                   (half * half - before * before);
        }
        phase->below[i] = sum;
    }
    for (int i = 0; i <= CELLS; i++) {
        phase->value[i] /= sum;
        phase->below[i] /= sum;
    }
    return sum;
}

double photon_turn(const struct photon_phase *phase, double cosine)
{
    double at = sqrt(fmax(0.5 * (1.0 - cosine), 0.0)) * CELLS;
    int i = (int)fmin(at, CELLS - 1);
    return phase->value[i] + (at - i) * (phase->value[i + 1] - phase->value[i]);
}

double photon_density(const struct photon_phase *phase, double cosine)
{
    int i = (int)fmin(sqrt(fmax(0.5 * (1.0 - cosine), 0.0)) * CELLS, CELLS - 1);
    double ring = 4.0 * PI * (2.0 * i + 1.0) / ((double)CELLS * CELLS);
    return (phase->below[i + 1] - phase->below[i]) / ring;
}

double photon_draw_cosine(const struct photon_phase *phase, uint64_t *random)
{
    double u = photon_draw(random);
    int low = 0, high = CELLS;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (phase->below[middle] <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    double part =
        (u - phase->below[low]) / (phase->below[low + 1] - phase->below[low]);
    double square = (low * (double)low + part * (2.0 * low + 1.0)) /
                    ((double)CELLS * CELLS);
    return 1.0 - 2.0 * square;
}
