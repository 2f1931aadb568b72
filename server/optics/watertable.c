#include "optics/watertable.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "optics/brdf.h"
#include "optics/ordinates.h"

#define SIZE PEL_WATER_TABLE_SIZE
#define NODES 12
#define MODES (2 * NODES)

void pel_water_sky_clear(const struct pel_atmosphere *air, double sun_zenith,
                         struct pel_water_sky *out)
{
    struct pel_vec3 sun = { sin(sun_zenith), 0.0, cos(sun_zenith) };
    for (int i = 0; i < PEL_WATER_SKY_ZENITHS; i++) {
        double zenith = 0.5 * PEL_PI * i / (PEL_WATER_SKY_ZENITHS - 1);
        for (int j = 0; j < PEL_WATER_SKY_AZIMUTHS; j++) {
            double azimuth = PEL_PI * j / (PEL_WATER_SKY_AZIMUTHS - 1);
            struct pel_vec3 to = { sin(zenith) * cos(azimuth),
                                   sin(zenith) * sin(azimuth), cos(zenith) };
            out->radiance[i][j] = pel_atmosphere_sky(air, 0.0, to, sun);
        }
    }
}

double pel_water_depth(const struct pel_water_depths *d, int i)
{
    return d->levels > 1 ? d->first_m * pow(d->last_m / d->first_m,
                                            (double)i / (d->levels - 1))
                         : d->first_m;
}

static double channel(struct pel_rgb c, int i)
{
    return i == 0 ? c.r : i == 1 ? c.g : c.b;
}

/* Azimuth modes of the sky at the solver's nodes, for a unit of horizontal
 * irradiance. */
static void sky_modes(const struct pel_ordinates *o,
                      const struct pel_water_sky *sky, int wavelength,
                      double *modes)
{
    enum { LAST = PEL_WATER_SKY_AZIMUTHS - 1 };
    for (int i = 0; i < NODES; i++) {
        double at = pel_ordinates_sky_node(o, i) / (0.5 * PEL_PI) *
                    (PEL_WATER_SKY_ZENITHS - 1);
        int row = (int)fmin(at, PEL_WATER_SKY_ZENITHS - 2);
        double part = at - row;
        for (int m = 0; m < MODES; m++) {
            double sum = 0.0;
            for (int j = 0; j <= LAST && m < LAST; j++) {
                double end = j == 0 || j == LAST ? 0.5 : 1.0;
                double value =
                    (1.0 - part) * channel(sky->radiance[row][j], wavelength) +
                    part * channel(sky->radiance[row + 1][j], wavelength);
                sum += end * value * cos(m * PEL_PI * j / LAST);
            }
            modes[m * NODES + i] = sum / LAST * (m ? 2.0 : 1.0);
        }
    }
    double irradiance = pel_ordinates_sky_irradiance(o, modes);
    for (int i = 0; i < MODES * NODES; i++) {
        modes[i] = irradiance > 0.0 ? modes[i] / irradiance : 0.0;
    }
}

struct views {
    double mu[SIZE];     /* in the water */
    double sine[SIZE];   /* in the water */
    double cosine[SIZE]; /* of the azimuth */
};

static void make_views(struct views *v)
{
    for (int i = 0; i < SIZE; i++) {
        v->sine[i] = (double)i / (SIZE - 1) / PEL_WATER_INDEX;
        v->mu[i] = sqrt(1.0 - v->sine[i] * v->sine[i]);
        v->cosine[i] = 2.0 * i / (SIZE - 1) - 1.0;
    }
}

/* Adds up the series of one wavelength; cos mφ by Chebyshev's recurrence. */
static void fill(const struct views *v, const double *series, int modes,
                 int wavelength, float texels[SIZE][SIZE][4])
{
    const double n2 = PEL_WATER_INDEX * PEL_WATER_INDEX;
    for (int i = 0; i < SIZE; i++) {
        for (int j = 0; j < SIZE; j++) {
            double x = v->cosine[j], before = x, cosine = 1.0, sum = 0.0;
            for (int m = 0; m < modes; m++) {
                sum += series[m * SIZE + i] * cosine;
                double next = 2.0 * x * cosine - before;
                before = cosine;
                cosine = next;
            }
            texels[i][j][wavelength] = (float)fmax(sum / n2, 0.0);
        }
    }
}

/* What the solver leaves to the caller: single scattering of the Sun. */
static void add_single(struct pel_ordinates *o, const struct views *v,
                       const struct pel_medium *medium, double sun_zenith,
                       int wavelength, float texels[SIZE][SIZE][4])
{
    const double n2 = PEL_WATER_INDEX * PEL_WATER_INDEX;
    struct pel_geometry geometry = { .sun_zenith_rad = sun_zenith };
    struct pel_interface face = pel_interface_at(&geometry);
    double sun_sine = sin(sun_zenith) / PEL_WATER_INDEX;
    for (int i = 0; i < SIZE; i++) {
        for (int j = 0; j < SIZE; j++) {
            double nu =
                sun_sine * v->sine[i] * v->cosine[j] - face.sun_mu * v->mu[i];
            texels[i][j][wavelength] +=
                (float)(pel_ordinates_single(o, medium, face.beam, face.sun_mu,
                                             v->mu[i], nu) /
                        n2);
        }
    }
}

static void build(struct pel_ordinates *o, const struct pel_water_body *body,
                  double sun_zenith, const struct pel_water_sky *sky,
                  int wavelength, struct pel_water_table *out)
{
    struct views views;
    double series[MODES * SIZE], modes_of_sky[MODES * NODES];
    int modes = 0;
    make_views(&views);
    struct pel_medium medium = pel_water_medium(body, wavelength);
    struct pel_ordinates_light sun = { .sun_zenith_rad = sun_zenith,
                                       .sun = 1.0 };
    pel_ordinates_solve(o, &medium, &sun, views.mu, SIZE, series, &modes, NULL);
    fill(&views, series, modes, wavelength, out->sun);
    add_single(o, &views, &medium, sun_zenith, wavelength, out->sun);
    struct pel_ordinates_light above = { .sky = modes_of_sky,
                                         .sky_modes = MODES };
    if (sky) {
        sky_modes(o, sky, wavelength, modes_of_sky);
    } else {
        above.sky_modes = 1;
        for (int i = 0; i < NODES; i++) {
            modes_of_sky[i] = 1.0 / PEL_PI;
        }
    }
    pel_ordinates_solve(o, &medium, &above, views.mu, SIZE, series, &modes,
                        NULL);
    fill(&views, series, modes, wavelength, out->sky);
}

enum pel_err pel_water_table_build(const struct pel_water_body *body,
                                   double sun_zenith,
                                   const struct pel_water_sky *sky,
                                   struct pel_water_table *out)
{
    struct pel_ordinates *o = pel_ordinates_create(NODES, 2e-4);
    if (!o) {
        return PEL_ERR_NO_MEMORY;
    }
    memset(out, 0, sizeof *out);
    double zenith = sun_zenith >= 0.0 && sun_zenith < 0.5 * PEL_PI
                        ? sun_zenith
                        : 0.5 * PEL_PI;
    for (int i = 0; i < 3; i++) {
        build(o, body, zenith, sky, i, out);
    }
    pel_ordinates_destroy(o);
    return PEL_OK;
}

struct pel_rgb pel_water_table_fetch(const float texels[SIZE][SIZE][4],
                                     double sin_zenith, double cos_azimuth)
{
    double y = pel_clamp(sin_zenith, 0.0, 1.0) * (SIZE - 1);
    double x = 0.5 * (1.0 + pel_clamp(cos_azimuth, -1.0, 1.0)) * (SIZE - 1);
    int i = (int)fmin(y, SIZE - 2), j = (int)fmin(x, SIZE - 2);
    double rgb[3];
    for (int k = 0; k < 3; k++) {
        double low =
            texels[i][j][k] + (x - j) * (texels[i][j + 1][k] - texels[i][j][k]);
        double high = texels[i + 1][j][k] +
                      (x - j) * (texels[i + 1][j + 1][k] - texels[i + 1][j][k]);
        rgb[k] = low + (y - i) * (high - low);
    }
    return (struct pel_rgb){ rgb[0], rgb[1], rgb[2] };
}

struct pel_rgb pel_water_table_leaving(const struct pel_water_table *table,
                                       struct pel_vec3 view,
                                       struct pel_vec3 normal,
                                       struct pel_vec3 sun,
                                       struct pel_rgb sun_irradiance,
                                       struct pel_rgb sky_irradiance)
{
    const double eta = 1.0 / PEL_WATER_INDEX;
    double facing = fmax(pel_vec3_dot(normal, view), 0.0);
    /* The line of sight refracted, its horizontal part. */
    double along =
        eta * facing - sqrt(1.0 - eta * eta * (1.0 - facing * facing));
    double x = normal.x * along - eta * view.x;
    double y = normal.y * along - eta * view.y;
    double sine = hypot(x, y), across = hypot(sun.x, sun.y) * sine;
    double cosine = across > 1e-6 ? (x * sun.x + y * sun.y) / across : 0.0;
    struct pel_rgb a =
        pel_water_table_fetch(table->sun, PEL_WATER_INDEX * sine, cosine);
    struct pel_rgb b =
        pel_water_table_fetch(table->sky, PEL_WATER_INDEX * sine, cosine);
    return (struct pel_rgb){
        sun_irradiance.r * a.r + sky_irradiance.r * b.r,
        sun_irradiance.g * a.g + sky_irradiance.g * b.g,
        sun_irradiance.b * a.b + sky_irradiance.b * b.b,
    };
}
