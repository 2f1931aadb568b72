#include "watercolumn.h"

#include <math.h>
#include <stdlib.h>

#include "photons.h"
#include "waterrays.h"

#define PI PHOTON_PI
#define INDEX PHOTON_INDEX
#define CAP (PI / 180.0)
#define LAYERS 4000
#define FAINT 0.02 /* a photon of less is lost or made stronger */
#define BATCHES 32

struct layer {
    double albedo, molecular; /* of scattering; share of it */
    double below;             /* optical depth of its lower edge */
};

/* Depths are optical, without the narrow peak. */
struct state {
    struct layer layer[LAYERS];
    struct photon_phase molecules, particles;
    double deep, bottom, slope;
    double depth[COLUMN_DEPTHS];
    int depths;
    uint64_t random;
};

/* Petzold's three measurements in San Diego's harbour, averaged. */
static const double petzold_deg[] = {
    1,   1.259, 1.585, 1.995, 2.512, 3.162, 3.981, 5.012, 6.31, 7.943, 10,  15,
    20,  25,    30,    35,    40,    45,    50,    55,    60,   65,    70,  75,
    80,  85,    90,    95,    100,   105,   110,   115,   120,  125,   130, 135,
    140, 145,   150,   155,   160,   165,   170,   175,   180,
};
static const double petzold_value[] = {
    71.61,    49.58,    33.95,    22.81,    15.16,    10.02,    6.58,
    4.295,    2.807,    1.819,    1.153,    0.4893,   0.2444,   0.1472,
    0.08609,  0.05931,  0.0421,   0.03067,  0.02275,  0.01699,  0.01313,
    0.01046,  0.008488, 0.006976, 0.005842, 0.004953, 0.004292, 0.003782,
    0.003404, 0.003116, 0.002912, 0.002797, 0.002686, 0.002571, 0.002476,
    0.002377, 0.002329, 0.002313, 0.002365, 0.002506, 0.002662, 0.002835,
    0.003031, 0.003092, 0.003154,
};

static double petzold(double angle, const void *of)
{
    enum { COUNT = sizeof petzold_deg / sizeof *petzold_deg };
    double at = fmax(angle * 180.0 / PI, petzold_deg[0]);
    int i = 0;
    (void)of;
    while (i < COUNT - 2 && petzold_deg[i + 1] < at) {
        i++;
    }
    double part =
        log(at / petzold_deg[i]) / log(petzold_deg[i + 1] / petzold_deg[i]);
    return petzold_value[i] *
           pow(petzold_value[i + 1] / petzold_value[i], part);
}

static double fournier_forand(double angle, const void *of)
{
    const struct column *c = of;
    return water_ray_particles(c->index, c->size_slope, angle);
}

static double molecules(double angle, const void *of)
{
    const struct column *c = of;
    double q = c->molecular_anisotropy, cosine = cos(angle);
    return (1.0 + q * cosine * cosine) / (4.0 * PI * (1.0 + q / 3.0));
}

static double optical(const double *edges, double depth_m, double step)
{
    double at = depth_m / step;
    int i = (int)fmin(at, LAYERS - 1);
    return edges[i] + (at - i) * (edges[i + 1] - edges[i]);
}

static struct state *make(const struct column *c, const double *depths_m,
                          int depths, uint64_t seed)
{
    static double edges[LAYERS + 1];
    struct state *s = calloc(1, sizeof *s);
    if (!s) {
        abort();
    }
    photon_tabulate(&s->molecules, molecules, c);
    double kept = photon_tabulate(
        &s->particles, c->by == COLUMN_PETZOLD ? petzold : fournier_forand, c);
    double step = c->depth_m / LAYERS;
    for (int i = 0; i < LAYERS; i++) {
        struct column_water w = c->at((i + 0.5) * step);
        double b = w.molecular + kept * w.particles, all = w.absorption + b;
        edges[i + 1] = edges[i] + all * step;
        s->layer[i] = (struct layer){ .albedo = b / all,
                                      .molecular = w.molecular / b,
                                      .below = edges[i + 1] };
    }
    s->deep = edges[LAYERS];
    s->bottom = c->bottom;
    s->slope = sqrt(0.5 * c->slopes);
    s->depths = depths;
    s->random = seed * 0x9e3779b97f4a7c15u + 1u;
    for (int i = 0; i < depths; i++) {
        s->depth[i] = fmin(optical(edges, depths_m[i], step), s->deep);
    }
    return s;
}

static double draw(struct state *s)
{
    return photon_draw(&s->random);
}

static const struct layer *layer_at(const struct state *s, double depth)
{
    int low = 0, high = LAYERS - 1;
    while (low < high) {
        int middle = (low + high) / 2;
        if (s->layer[middle].below < depth) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return &s->layer[low];
}

/* The normal, upwards, of a facet that a ray meets, as often as it shows
 * itself to the ray. */
static struct photon_vector facet(struct state *s, struct photon_vector ray)
{
    if (s->slope <= 0.0) {
        return (struct photon_vector){ 0, 0, 1 };
    }
    double side = ray.z < 0.0 ? -1.0 : 1.0;
    double most = fabs(ray.z) + 5.0 * s->slope * sqrt(1.0 - ray.z * ray.z);
    for (;;) {
        double r = s->slope * sqrt(-2.0 * log(draw(s)));
        double around = 2.0 * PI * draw(s);
        double x = r * cos(around), y = r * sin(around);
        double shown = side * (ray.z - ray.x * x - ray.y * y);
        if (shown > most * draw(s)) {
            double n = sqrt(1.0 + x * x + y * y);
            return (struct photon_vector){ -x / n, -y / n, 1.0 / n };
        }
    }
}

/* Through the surface, or back, from either side, until it leaves it: false
 * where the ray is lost to the air. */
static bool cross(struct state *s, struct photon_vector *ray, bool air)
{
    for (;;) {
        struct photon_vector n = facet(s, *ray);
        double c = photon_dot(*ray, n); /* < 0 from above */
        double ratio = air ? 1.0 / INDEX : INDEX;
        double sine2 = ratio * ratio * (1.0 - c * c); /* beyond */
        double beyond = sqrt(fmax(1.0 - sine2, 0.0));
        double mirrored =
            air ? photon_mirrored(sqrt(sine2), beyond)
                : photon_mirrored(sqrt(fmax(1.0 - c * c, 0.0)), fabs(c));
        if (draw(s) < mirrored) {
            ray->x -= 2.0 * c * n.x;
            ray->y -= 2.0 * c * n.y;
            ray->z -= 2.0 * c * n.z;
        } else {
            double along = (c < 0.0 ? -beyond : beyond) - ratio * c;
            ray->x = ratio * ray->x + along * n.x;
            ray->y = ratio * ray->y + along * n.y;
            ray->z = ratio * ray->z + along * n.z;
            air = !air;
        }
        if (air ? ray->z > 0.0 : ray->z < 0.0) {
            return !air;
        }
    }
}

/* What a flight from a depth is expected to bring to the others. */
static void fly_by(const struct state *s, double depth, double up,
                   double weight, struct column_field *found)
{
    for (int i = 0; i < s->depths; i++) {
        double way = (depth - s->depth[i]) / up;
        if (way >= 0.0 && up < 0.0) {
            found[i].down += weight * exp(-way);
        } else if (way >= 0.0 && up > 0.0) {
            found[i].scalar_up += weight * exp(-way) / up;
        }
    }
}

/* What a scattering, or the bottom, sends straight up. */
static void shine_up(const struct state *s, double depth, double radiance,
                     struct column_field *found)
{
    for (int i = 0; i < s->depths; i++) {
        if (depth >= s->depth[i]) {
            found[i].nadir += radiance * exp(s->depth[i] - depth);
        }
    }
}

static struct photon_vector from_bottom(struct state *s)
{
    double up2 = draw(s), around = 2.0 * PI * draw(s), flat = sqrt(1.0 - up2);
    return (struct photon_vector){ flat * cos(around), flat * sin(around),
                                   sqrt(up2) };
}

static void follow(struct state *s, double cosine, struct column_field *found)
{
    struct photon_vector ray = { sqrt(1.0 - cosine * cosine), 0.0, -cosine };
    double depth = 0.0, weight = 1.0;
    if (!cross(s, &ray, true)) {
        return;
    }
    for (;;) {
        fly_by(s, depth, ray.z, weight, found);
        depth += log(draw(s)) * ray.z;
        if (depth < 0.0) {
            depth = 0.0;
            if (!cross(s, &ray, false)) {
                return;
            }
            continue;
        }
        if (depth >= s->deep) {
            depth = s->deep;
            weight *= s->bottom;
            shine_up(s, depth, weight / PI, found);
            ray = from_bottom(s);
        } else {
            const struct layer *l = layer_at(s, depth);
            weight *= l->albedo;
            double m = l->molecular;
            shine_up(s, depth,
                     weight * (m * photon_turn(&s->molecules, ray.z) +
                               (1.0 - m) * photon_turn(&s->particles, ray.z)),
                     found);
            ray = photon_turned(
                &s->random, ray,
                photon_draw_cosine(draw(s) < m ? &s->molecules : &s->particles,
                                   &s->random));
        }
        if (weight < FAINT) {
            if (draw(s) > 0.3) {
                return;
            }
            weight /= 0.3;
        }
    }
}

static void add(double value, double *mean, double *square)
{
    *mean += value / BATCHES;
    *square += value * value / BATCHES;
}

static double error_of(double mean, double square)
{
    return sqrt(fmax(square - mean * mean, 0.0) / (BATCHES - 1));
}

void water_column(const struct column *column, const double *depths_m,
                  int depths, uint64_t photons, uint64_t seed,
                  struct column_field *mean, struct column_field *error)
{
    struct state *s = make(column, depths_m, depths, seed);
    for (int i = 0; i < depths; i++) {
        mean[i] = error[i] = (struct column_field){ 0 };
    }
    uint64_t each = photons / BATCHES;
    for (int b = 0; b < BATCHES; b++) {
        struct column_field found[COLUMN_DEPTHS] = { 0 };
        for (uint64_t k = 0; k < each; k++) {
            /* The first number by strata. */
            follow(s, column->light(((double)k + draw(s)) / (double)each),
                   found);
        }
        for (int i = 0; i < depths; i++) {
            double n = (double)each;
            add(found[i].down / n, &mean[i].down, &error[i].down);
            add(found[i].scalar_up / n, &mean[i].scalar_up,
                &error[i].scalar_up);
            add(found[i].nadir / n, &mean[i].nadir, &error[i].nadir);
        }
    }
    for (int i = 0; i < depths; i++) {
        error[i].down = error_of(mean[i].down, error[i].down);
        error[i].scalar_up = error_of(mean[i].scalar_up, error[i].scalar_up);
        error[i].nadir = error_of(mean[i].nadir, error[i].nadir);
    }
    free(s);
}
