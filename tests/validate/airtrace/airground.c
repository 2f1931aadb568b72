#include "airground.h"

#define PI 3.14159265358979323846

/* Directions drawn alike from the whole sky, of all. */
#define MATT_SHARE 0.2

static double water_index(double salinity, double celsius, double nm)
{
    double t = celsius, t2 = t * t;
    return 1.31405 + salinity * (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t2) -
           2.02e-6 * t2 + (15.868 + 0.01155 * salinity - 0.00423 * t) / nm -
           4382 / (nm * nm) + 1.1455e6 / (nm * nm * nm);
}

void air_ground_sea(struct air_ground *ground, double wind)
{
    *ground = (struct air_ground){
        .kind = AIR_FRESNEL,
        .albedo = { 0.001, 0.008, 0.017 },
        .variance = (0.003 + 0.00512 * wind) / 2,
        .index = { water_index(35, 15, 680), water_index(35, 15, 550),
                   water_index(35, 15, 440) },
    };
}

static double fresnel(double cosine, double index)
{
    double inside = sqrt(1 - (1 - cosine * cosine) / (index * index));
    double s = (cosine - index * inside) / (cosine + index * inside);
    double p = (index * cosine - inside) / (index * cosine + inside);
    return (s * s + p * p) / 2;
}

/* Smith 1967: facets hidden for each that is seen. */
static double hidden(double variance, double cosine)
{
    double sine2 = 1 - cosine * cosine;
    if (sine2 <= 0) {
        return 0;
    }
    double a = cosine / sqrt(2 * variance * sine2);
    return a > 6 ? 0 : (exp(-a * a) / (a * sqrt(PI)) - erfc(a)) / 2;
}

static double slope_density(double variance, double slope2)
{
    return exp(-slope2 / (2 * variance)) / (2 * PI * variance);
}

/* The facet that mirrors one direction to the other, and its cosines to them
 * and to the normal. */
static void facet(struct air_vec eye, struct air_vec light, struct air_vec up,
                  double *incidence, double *upright)
{
    struct air_vec h = air_along(eye, 1, light);
    double length = sqrt(air_dot(h, h));
    *incidence = fmin(length / 2, 1);
    *upright = fmin(air_dot(h, up) / length, 1);
}

double air_ground_reflect(const struct air_ground *ground, int channel,
                          struct air_vec eye, struct air_vec light,
                          struct air_vec up)
{
    double cos_eye = air_dot(eye, up), cos_light = air_dot(light, up);
    if (ground->kind == AIR_BLACK || cos_eye <= 0 || cos_light <= 0) {
        return 0;
    }
    double matt = ground->albedo[channel] / PI;
    if (ground->kind == AIR_LAMBERT) {
        return matt;
    }
    double incidence, upright, v = ground->variance;
    facet(eye, light, up, &incidence, &upright);
    double upright2 = upright * upright;
    return matt + fresnel(incidence, ground->index[channel]) *
                      slope_density(v, 1 / upright2 - 1) /
                      (4 * cos_eye * cos_light * upright2 * upright2 *
                       (1 + hidden(v, cos_eye) + hidden(v, cos_light)));
}

struct air_vec air_ground_sample(const struct air_ground *ground, int channel,
                                 struct air_vec eye, struct air_vec up,
                                 const double u[3], double *weight)
{
    double matt_share = ground->kind == AIR_FRESNEL ? MATT_SHARE : 1;
    struct air_vec light;
    double v = ground->variance;
    if (u[2] < matt_share) {
        light = air_turned(up, sqrt(u[0]), 2 * PI * u[1]);
    } else {
        double slope = sqrt(-2 * v * log(1 - u[0]));
        struct air_vec h =
            air_turned(up, 1 / sqrt(1 + slope * slope), 2 * PI * u[1]);
        double twice = 2 * air_dot(eye, h);
        light = (struct air_vec){ twice * h.x - eye.x, twice * h.y - eye.y,
                                  twice * h.z - eye.z };
    }
    double cosine = air_dot(light, up);
    *weight = 0;
    if (cosine <= 0) {
        return light;
    }
    double density = matt_share * cosine / PI;
    if (ground->kind == AIR_FRESNEL) {
        double incidence, upright;
        facet(eye, light, up, &incidence, &upright);
        density += (1 - matt_share) *
                   slope_density(v, 1 / (upright * upright) - 1) /
                   (4 * incidence * upright * upright * upright);
    }
    *weight =
        air_ground_reflect(ground, channel, eye, light, up) * cosine / density;
    return light;
}

double air_ground_albedo(const struct air_ground *ground, int channel,
                         double cosine)
{
    enum { HEIGHTS = 400, ANGLES = 720 };
    struct air_vec up = { 0, 0, 1 };
    struct air_vec from = { sqrt(1 - cosine * cosine), 0, cosine };
    double sum = 0;
    for (int i = 0; i < HEIGHTS; i++) {
        double z = (i + 0.5) / HEIGHTS, level = sqrt(1 - z * z);
        for (int j = 0; j < ANGLES; j++) {
            double a = 2 * PI * (j + 0.5) / ANGLES;
            struct air_vec to = { level * cos(a), level * sin(a), z };
            sum += z * air_ground_reflect(ground, channel, from, to, up);
        }
    }
    return sum * 2 * PI / (HEIGHTS * ANGLES);
}
