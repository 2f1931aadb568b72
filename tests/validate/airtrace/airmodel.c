#include "airmodel.h"

#define PI 3.14159265358979323846

static const double micrometres[AIR_CHANNELS] = { 0.680, 0.550, 0.440 };

/* 300 DU (2.6868e20 molecules m-2 each) in a triangle of 25 +- 15 km, times
 * the cross-sections of ozone. */
static const double cross_section[AIR_CHANNELS] = { 1.209e-25, 3.500e-25,
                                                    1.582e-26 };

void air_init(struct air *air, double visibility)
{
    *air = (struct air){ .ground = 6360,
                         .top = 6420,
                         .molecule_height = 8,
                         .aerosol_albedo = 0.9,
                         .aerosol_height = 1.2,
                         .asymmetry = 0.8,
                         .ozone_peak = 25,
                         .ozone_width = 15 };
    for (int c = 0; c < AIR_CHANNELS; c++) {
        double molecules = 300 * 2.6868e20; /* over a square metre */
        air->molecules[c] = 1.24062e-3 / pow(micrometres[c], 4);
        air->ozone[c] = 1e3 * molecules * cross_section[c] / 15e3;
    }
    double aerosols = 3.912 / visibility - air->molecules[1];
    air->aerosol_extinction = aerosols > 0 ? aerosols : 0;
    /* Beyond the published aerosol it is sea salt, which absorbs 0.02. */
    double published = 4.44e-3;
    if (aerosols > published) {
        air->aerosol_albedo =
            (0.9 * published + 0.98 * (aerosols - published)) / aerosols;
    }
    if (air->aerosol_extinction * air->aerosol_height > 1.5) {
        air->aerosol_height = 1.5 / air->aerosol_extinction;
    }
    air_tabulate(air);
}

struct air_point air_exact(const struct air *air, int channel, double height)
{
    double molecules =
        air->molecules[channel] * exp(-height / air->molecule_height);
    double aerosols =
        air->aerosol_extinction * exp(-height / air->aerosol_height);
    double away = fabs(height - air->ozone_peak) / air->ozone_width;
    double ozone = away < 1 ? air->ozone[channel] * (1 - away) : 0;
    return (struct air_point){ molecules, air->aerosol_albedo * aerosols,
                               molecules + aerosols + ozone };
}

void air_tabulate(struct air *air)
{
    air->step = (air->top - air->ground) / (AIR_LEVELS - 1);
    for (int c = 0; c < AIR_CHANNELS; c++) {
        for (int i = 0; i < AIR_LEVELS; i++) {
            air->levels[c][i] = air_exact(air, c, i * air->step);
        }
    }
    /* The share turned by less than each of many cosines, by the midpoint
     * rule in the angle's square root, which is dense where the peak is. */
    enum { STEPS = 200000 };
    double share = 0;
    int next = 1;
    air->quantiles[0] = 1;
    for (int i = 0; i < STEPS && next < AIR_QUANTILES - 1; i++) {
        double u = (i + 0.5) / STEPS, angle = PI * u * u;
        double before = share;
        share += 2 * PI * air_phase_aerosols(air, cos(angle)) * sin(angle) * 2 *
                 PI * u / STEPS;
        while (next < AIR_QUANTILES - 1 && share * (AIR_QUANTILES - 1) > next) {
            double f =
                (next / (AIR_QUANTILES - 1.0) - before) / (share - before);
            double v = (i + f) / STEPS;
            air->quantiles[next++] = cos(PI * v * v);
        }
    }
    air->quantiles[AIR_QUANTILES - 1] = -1;
}

double air_phase_molecules(const struct air *air, double cosine)
{
    return air->isotropic ? 1 / (4 * PI)
                          : 3 / (16 * PI) * (1 + cosine * cosine);
}

/* Cornette and Shanks 1992, eq. 8. */
double air_phase_aerosols(const struct air *air, double cosine)
{
    double g = air->asymmetry, g2 = g * g;
    double x = 1 + g2 - 2 * g * cosine;
    return 3 / (8 * PI) * (1 - g2) / (2 + g2) * (1 + cosine * cosine) /
           (x * sqrt(x));
}

/* The cubic c^3 + 3 c = 8 u - 4 has one root (Frisvad 2011). */
double air_turn_molecules(const struct air *air, double u)
{
    if (air->isotropic) {
        return 2 * u - 1;
    }
    double q = 4 * u - 2;
    double a = cbrt(q + sqrt(q * q + 1));
    double cosine = a - 1 / a;
    return cosine < -1 ? -1 : cosine > 1 ? 1 : cosine;
}

double air_turn_aerosols(const struct air *air, double u, double *density)
{
    double x = u * (AIR_QUANTILES - 1);
    int i = (int)x;
    i = i > AIR_QUANTILES - 2 ? AIR_QUANTILES - 2 : i;
    double wide = air->quantiles[i] - air->quantiles[i + 1];
    *density = 1 / (2 * PI * wide * (AIR_QUANTILES - 1));
    return air->quantiles[i] - (x - i) * wide;
}

double air_aerosols_density(const struct air *air, double cosine)
{
    int low = 0, high = AIR_QUANTILES - 1;
    while (low + 1 < high) {
        int middle = (low + high) / 2;
        if (air->quantiles[middle] > cosine) {
            low = middle;
        } else {
            high = middle;
        }
    }
    double wide = air->quantiles[low] - air->quantiles[high];
    return 1 / (2 * PI * wide * (AIR_QUANTILES - 1));
}

struct air_vec air_turned(struct air_vec d, double cosine, double angle)
{
    /* An orthonormal base (Duff et al. 2017). */
    double sign = copysign(1, d.z), a = -1 / (sign + d.z), b = d.x * d.y * a;
    struct air_vec e = { 1 + sign * d.x * d.x * a, sign * b, -sign * d.x };
    struct air_vec f = { b, sign + d.y * d.y * a, -d.y };
    double sine = sqrt(fmax(0, 1 - cosine * cosine));
    double p = sine * cos(angle), q = sine * sin(angle);
    return (struct air_vec){ cosine * d.x + p * e.x + q * f.x,
                             cosine * d.y + p * e.y + q * f.y,
                             cosine * d.z + p * e.z + q * f.z };
}
