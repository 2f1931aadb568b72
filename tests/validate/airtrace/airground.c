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

/* The axis of slopes as it lies on the ground, and the one across. */
static void axes(const struct air_ground *ground, struct air_vec up,
                 struct air_vec *a, struct air_vec *b)
{
    *a = air_along(ground->axis, -air_dot(ground->axis, up), up);
    double length = sqrt(air_dot(*a, *a));
    if (length < 1e-9) {
        *a = air_turned(up, 0, 0);
        length = 1;
    }
    *a = (struct air_vec){ a->x / length, a->y / length, a->z / length };
    *b = (struct air_vec){ up.y * a->z - up.z * a->y, up.z * a->x - up.x * a->z,
                           up.x * a->y - up.y * a->x };
}

/* Variance of slopes in the azimuth of a direction. */
static double variance_toward(const struct air_ground *ground,
                              struct air_vec direction, struct air_vec up)
{
    struct air_vec a, b;
    if (ground->across <= 0) {
        return ground->variance;
    }
    axes(ground, up, &a, &b);
    double x = air_dot(direction, a), y = air_dot(direction, b);
    double level2 = x * x + y * y;
    return level2 > 0
               ? (ground->variance * x * x + ground->across * y * y) / level2
               : ground->variance;
}

/* The facet that mirrors one direction to the other, half of both, and its
 * cosines to them and to the normal. */
struct facet {
    struct air_vec half;
    double incidence, upright;
};

static struct facet facet(struct air_vec eye, struct air_vec light,
                          struct air_vec up)
{
    struct facet f = { .half = air_along(eye, 1, light) };
    double length = sqrt(air_dot(f.half, f.half));
    f.incidence = fmin(length / 2, 1);
    f.upright = fmin(air_dot(f.half, up) / length, 1);
    return f;
}

static double slope_density(const struct air_ground *ground,
                            const struct facet *f, struct air_vec up)
{
    double v = ground->variance, w = ground->across;
    if (w <= 0) {
        double slope2 = 1 / (f->upright * f->upright) - 1;
        return exp(-slope2 / (2 * v)) / (2 * PI * v);
    }
    struct air_vec a, b;
    axes(ground, up, &a, &b);
    double level = air_dot(f->half, up);
    double x = air_dot(f->half, a) / level, y = air_dot(f->half, b) / level;
    return exp(-x * x / (2 * v) - y * y / (2 * w)) / (2 * PI * sqrt(v * w));
}

double air_ground_mirror(const struct air_ground *ground, int channel,
                         struct air_vec eye, struct air_vec light,
                         struct air_vec up)
{
    double cos_eye = air_dot(eye, up), cos_light = air_dot(light, up);
    if (ground->kind != AIR_FRESNEL || cos_eye <= 0 || cos_light <= 0) {
        return 0;
    }
    struct facet f = facet(eye, light, up);
    double upright2 = f.upright * f.upright;
    return fresnel(f.incidence, ground->index[channel]) *
           slope_density(ground, &f, up) /
           (4 * cos_eye * cos_light * upright2 * upright2 *
            (1 + hidden(variance_toward(ground, eye, up), cos_eye) +
             hidden(variance_toward(ground, light, up), cos_light)));
}

double air_ground_reflect(const struct air_ground *ground, int channel,
                          struct air_vec eye, struct air_vec light,
                          struct air_vec up)
{
    if (ground->kind == AIR_BLACK || air_dot(eye, up) <= 0 ||
        air_dot(light, up) <= 0) {
        return 0;
    }
    return ground->albedo[channel] / PI +
           air_ground_mirror(ground, channel, eye, light, up);
}

/* A facet's normal by its slopes. */
static struct air_vec draw_facet(const struct air_ground *ground,
                                 struct air_vec up, const double u[2])
{
    double slope = sqrt(-2 * ground->variance * log(1 - u[0]));
    if (ground->across <= 0) {
        return air_turned(up, 1 / sqrt(1 + slope * slope), 2 * PI * u[1]);
    }
    struct air_vec a, b;
    axes(ground, up, &a, &b);
    double x = slope * cos(2 * PI * u[1]);
    double y =
        slope * sin(2 * PI * u[1]) * sqrt(ground->across / ground->variance);
    struct air_vec h = air_along(air_along(up, x, a), y, b);
    double length = sqrt(air_dot(h, h));
    return (struct air_vec){ h.x / length, h.y / length, h.z / length };
}

struct air_vec air_ground_sample(const struct air_ground *ground, int channel,
                                 struct air_vec eye, struct air_vec up,
                                 const double u[3], double *weight)
{
    double matt_share = ground->kind == AIR_FRESNEL ? MATT_SHARE : 1;
    struct air_vec light;
    if (u[2] < matt_share) {
        light = air_turned(up, sqrt(u[0]), 2 * PI * u[1]);
    } else {
        struct air_vec h = draw_facet(ground, up, u);
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
        struct facet f = facet(eye, light, up);
        density += (1 - matt_share) * slope_density(ground, &f, up) /
                   (4 * f.incidence * f.upright * f.upright * f.upright);
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
