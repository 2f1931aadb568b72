#include "optics/daylight.h"

#include <math.h>

#include "base/vec.h"
#include "optics/airgeometry.h"
#include "optics/atmosphere.h"

#define DIRECTIONS_UP 6
#define DIRECTIONS_AROUND 4
#define STEPS 24
#define LEAST_SINE (-0.156) /* -9 deg */
#define VISIBILITY_M 40000.0

/* Means of ASTM G-173's extraterrestrial column over 360..370 nm, 370..380 nm
 * and so on (Bruneton 2017). */
const double pel_sun_spectrum[PEL_DAYLIGHT_COUNT] = {
    1.11776, 1.14259, 1.01249, 1.14716, 1.72765, 1.73054, 1.68870, 1.61253,
    1.91198, 2.03474, 2.02042, 2.02212, 1.93377, 1.95809, 1.91686, 1.82980,
    1.86850, 1.89310, 1.85149, 1.85040, 1.83410, 1.83450, 1.81470, 1.78158,
    1.75330, 1.69650, 1.68194, 1.64654, 1.60480, 1.52143, 1.55622, 1.51130,
    1.47400, 1.44820, 1.41018, 1.36775, 1.34188, 1.31429, 1.28303, 1.26758,
    1.23670, 1.20820, 1.18737, 1.14683, 1.12362, 1.10580, 1.07124, 1.04992,
};

/* Absorption cross section of ozone, 1e-25 m^2, at 360, 370 .. 840 nm: means of
 * Serdyuchenko et al. 2014 at 233 K. */
static const double cross_section[PEL_DAYLIGHT_COUNT + 1] = {
    0.0118, 0.00218, 0.00282, 0.00664, 0.0153, 0.0276, 0.0552, 0.0845, 0.1582,
    0.2316, 0.3669,  0.4924,  0.7752,  0.9016, 1.480,  1.602,  2.139,  2.755,
    3.091,  3.500,   4.266,   4.672,   4.398,  4.701,  5.019,  4.305,  3.740,
    3.215,  2.662,   2.238,   1.852,   1.473,  1.209,  0.9423, 0.7455, 0.6566,
    0.5105, 0.4150,  0.4228,  0.3237,  0.2451, 0.2801, 0.2534, 0.1624, 0.1465,
    0.2078, 0.1383,  0.07105, 0.0,
};
#define CROSS_SECTION_550 3.5

static const double sampled_nm[3] = { 680.0, 550.0, 440.0 };

/* Coefficients of a wavelength: Rayleigh's scattering [1/m at sea level] and
 * ozone's absorption [1/m at its peak]. */
struct shade {
    double rayleigh, ozone;
};

static struct shade shade_at(const struct pel_atmosphere *air, double nm)
{
    double x = fmin(fmax((nm - 360.0) / 10.0, 0.0), PEL_DAYLIGHT_COUNT - 1e-9);
    int i = (int)x;
    double ozone =
        cross_section[i] + (x - i) * (cross_section[i + 1] - cross_section[i]);
    double ratio = 550.0 / nm, ratio2 = ratio * ratio;
    return (struct shade){ air->rayleigh.g * ratio2 * ratio2,
                           air->ozone.g * ozone / CROSS_SECTION_550 };
}

/* Every step of a path: what is scattered there towards the eye, and the air
 * that light crosses on the whole way from the Sun. */
struct step {
    double rayleigh, mie; /* scattering, shares of a metre of sea-level air */
    struct pel_columns way;
};

#define SHADES (PEL_DAYLIGHT_COUNT + 3)

static void add(const struct pel_atmosphere *air, const struct shade *shades,
                struct step s, double sum[SHADES])
{
    for (int i = 0; i < SHADES; i++) {
        sum[i] += (shades[i].rayleigh * s.rayleigh + s.mie) *
                  exp(-shades[i].rayleigh * s.way.rayleigh -
                      shades[i].ozone * s.way.ozone -
                      air->mie_extinction * s.way.mie);
    }
}

static void add_direction(const struct pel_atmosphere *air,
                          const struct shade *shades, struct pel_vec3 dir,
                          struct pel_vec3 sun, double weight,
                          double sum[SHADES])
{
    const double R = PEL_EARTH_RADIUS;
    double length = pel_distance_to_top(0.0, dir.z);
    double nu = pel_vec3_dot(dir, sun);
    double rayleigh = pel_phase_rayleigh(nu) * weight;
    double mie = pel_phase_mie(nu, air->mie_g) * weight * air->mie_scattering;
    struct pel_columns near = { 0, 0, 0 };
    for (int i = 0; i < STEPS; i++) {
        double from = length * pow((double)i / STEPS, 2.5);
        double long_m = length * pow((i + 1.0) / STEPS, 2.5) - from;
        double t = length * pow((i + 0.5) / STEPS, 2.5);
        double h = pel_height_along(0.0, dir.z, t);
        double mu = (t * nu + R * sun.z) / (R + h);
        double dr = exp(-h / air->rayleigh_height_m);
        double dm = exp(-h / air->mie_height_m);
        double off = fabs(h - air->ozone_center_m) / air->ozone_width_m;
        struct pel_columns half = { dr * long_m / 2, dm * long_m / 2,
                                    fmax(1 - off, 0) * long_m / 2 };
        if (mu > pel_horizon_cosine(h)) {
            struct pel_columns c = pel_atmosphere_columns(air, h, mu);
            c.rayleigh += near.rayleigh + half.rayleigh;
            c.mie += near.mie + half.mie;
            c.ozone += near.ozone + half.ozone;
            add(air, shades,
                (struct step){ dr * rayleigh * long_m, dm * mie * long_m, c },
                sum);
        }
        near.rayleigh += 2 * half.rayleigh;
        near.mie += 2 * half.mie;
        near.ozone += 2 * half.ozone;
    }
}

void pel_daylight(double sun_sine, struct pel_daylight *out)
{
    struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { VISIBILITY_M };
    pel_atmosphere_init(&desc, &air);
    struct shade shades[SHADES];
    for (int i = 0; i < PEL_DAYLIGHT_COUNT; i++) {
        shades[i] =
            shade_at(&air, PEL_DAYLIGHT_FIRST_NM + PEL_DAYLIGHT_STEP_NM * i);
    }
    for (int s = 0; s < 3; s++) {
        shades[PEL_DAYLIGHT_COUNT + s] = shade_at(&air, sampled_nm[s]);
    }
    double sine = fmin(fmax(sun_sine, LEAST_SINE), 1.0);
    const struct pel_vec3 sun = { 0, sqrt(1 - sine * sine), sine };
    double sum[SHADES] = { 0 };
    for (int i = 0; i < DIRECTIONS_UP; i++) {
        /* Solid angles that grow with the height above the horizon, where
         * twilight is brightest. */
        double low = (double)i * i / (DIRECTIONS_UP * DIRECTIONS_UP);
        double high = (i + 1.0) * (i + 1.0) / (DIRECTIONS_UP * DIRECTIONS_UP);
        double z = 0.5 * (low + high), level = sqrt(1 - z * z);
        for (int j = 0; j < DIRECTIONS_AROUND; j++) {
            double azimuth = PEL_PI * (j + 0.5) / DIRECTIONS_AROUND;
            struct pel_vec3 dir = { level * sin(azimuth), level * cos(azimuth),
                                    z };
            add_direction(&air, shades, dir, sun,
                          2 * PEL_PI * (high - low) / DIRECTIONS_AROUND, sum);
        }
    }
    if (sine > 0) {
        struct pel_columns c = pel_atmosphere_columns(&air, 0, sine);
        for (int i = 0; i < SHADES; i++) {
            sum[i] +=
                exp(-shades[i].rayleigh * c.rayleigh -
                    shades[i].ozone * c.ozone - air.mie_extinction * c.mie);
        }
    }
    for (int i = 0; i < PEL_DAYLIGHT_COUNT; i++) {
        out->at[i] = pel_sun_spectrum[i] * sum[i];
    }
    const struct pel_rgb e = PEL_SUN_IRRADIANCE;
    const double there[3] = { e.r, e.g, e.b };
    for (int s = 0; s < 3; s++) {
        out->sample[s] = there[s] * sum[PEL_DAYLIGHT_COUNT + s];
    }
}
