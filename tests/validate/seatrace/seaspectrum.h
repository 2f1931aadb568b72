/* Directional wave spectra for the ray-traced reference, written from the
 * literature alone: nothing here includes or repeats the program's code.
 *
 * Angles are radians from the direction the wind blows to; k in rad/m. The
 * surface is a linear Gaussian one at a fixed moment, so that a wave and its
 * opposite are the same.
 */
#ifndef SEASPECTRUM_H
#define SEASPECTRUM_H

enum sea_kind { SEA_PIERSON_MOSKOWITZ, SEA_ELFOUHAILY };

enum { SEA_TABLE = 4096 };

/* Tabulated over the logarithm of k from k_low to k_high. */
struct sea_spectrum {
    enum sea_kind kind;
    double wind_mps; /* at 10 m */
    double fetch_m;  /* Elfouhaily's */
    double k_peak, k_low, k_high;
    double log_low, log_step;
    double elevation[SEA_TABLE]; /* S(k), m3, over all directions */
    double spread[SEA_TABLE];    /* s of cos^2s(angle/2), or Elfouhaily's
                                    Delta */
    double norm[SEA_TABLE];      /* of the first */
};

struct sea_moments {
    double m0;           /* m2 */
    double along, cross; /* mean-square slopes */
};

/* wind_mps: 1 to 30. Waves shorter than shortest_m are left out. */
void sea_spectrum_init(struct sea_spectrum *spectrum, enum sea_kind kind,
                       double wind_mps, double fetch_m, double shortest_m);

/* Of k dk dangle, m4; 0 outside k_low to k_high. */
double sea_spectrum_density(const struct sea_spectrum *spectrum, double k,
                            double cos_angle);

/* Integrals between two wave numbers, by quadrature. */
struct sea_moments sea_spectrum_moments(const struct sea_spectrum *spectrum,
                                        double k_from, double k_to);

#endif
