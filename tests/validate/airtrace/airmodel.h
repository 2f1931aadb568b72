/* The air as docs/physics/atmosphere.md states it, written a second time:
 * molecules, aerosols and ozone on a sphere, without polarisation and
 * refraction. Lengths in km, directions from the Earth's centre; channels 0, 1,
 * 2 are 680, 550, 440 nm. */
#ifndef AIRMODEL_H
#define AIRMODEL_H

#include "../seatrace/searandom.h"

enum { AIR_CHANNELS = 3, AIR_LEVELS = 6001, AIR_QUANTILES = 4097 };

struct air_vec {
    double x, y, z;
};

/* Scattering and extinction at one height, 1/km. */
struct air_point {
    double molecules, aerosols, extinction;
};

struct air {
    double ground, top;             /* distances from the centre */
    double molecules[AIR_CHANNELS]; /* scattering at sea level */
    double molecule_height;
    double aerosol_extinction, aerosol_albedo, aerosol_height;
    double asymmetry;           /* of Cornette and Shanks */
    double ozone[AIR_CHANNELS]; /* absorption at the peak */
    double ozone_peak, ozone_width;
    int isotropic; /* molecules scatter alike everywhere (tests) */
    /* Made by air_tabulate: at heights `step` apart, and cosines that part
     * the aerosols' scattering into equal shares. */
    double step;
    struct air_point levels[AIR_CHANNELS][AIR_LEVELS];
    double quantiles[AIR_QUANTILES];
};

/* Constants for a meteorological visibility in km: Koschmieder's 3.912 over
 * the extinction at 550 nm at sea level. Where aerosols' optical depth would
 * exceed 1.5 (below 3 km) their layer is shallower. */
void air_init(struct air *air, double visibility);

/* Fills the tables after a change of the constants. */
void air_tabulate(struct air *air);

/* From the closed form; from the table. */
struct air_point air_exact(const struct air *air, int channel, double height);
static inline struct air_point air_at(const struct air *air, int channel,
                                      double height)
{
    double x = height / air->step;
    x = x < 0 ? 0 : x > AIR_LEVELS - 1.001 ? AIR_LEVELS - 1.001 : x;
    int i = (int)x;
    double f = x - i;
    const struct air_point *p = &air->levels[channel][i];
    return (struct air_point){
        p[0].molecules + f * (p[1].molecules - p[0].molecules),
        p[0].aerosols + f * (p[1].aerosols - p[0].aerosols),
        p[0].extinction + f * (p[1].extinction - p[0].extinction),
    };
}

/* Densities over the sphere, 1/sr, of the cosine of the angle turned. */
double air_phase_molecules(const struct air *air, double cosine);
double air_phase_aerosols(const struct air *air, double cosine);

/* A cosine by one or the other; its density over the sphere is that of the
 * phase function for molecules, `*density` for aerosols. */
double air_turn_molecules(const struct air *air, double u);
double air_turn_aerosols(const struct air *air, double u, double *density);

/* The density of what air_turn_aerosols draws. */
double air_aerosols_density(const struct air *air, double cosine);

/* The unit vector at `cosine` from d, turned round it by `angle`. */
struct air_vec air_turned(struct air_vec d, double cosine, double angle);

static inline double air_dot(struct air_vec a, struct air_vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct air_vec air_along(struct air_vec p, double t,
                                       struct air_vec d)
{
    return (struct air_vec){ p.x + t * d.x, p.y + t * d.y, p.z + t * d.z };
}

#endif
