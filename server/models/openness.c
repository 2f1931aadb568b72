#include "models/openness.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define USUAL_RAYS 250000 /* a few tenths of a second */
#define MOST_IN_ALL 1000000
#define LEAST_RAYS 8 /* of a triangle's corner */
#define MOST_RAYS 16
/* Where a corner of a triangle looks from: so far towards its middle. Farther
 * in where the corner is inside another body, as walls' feet are. */
static const double insets[] = { 0.15, 0.5, 0.85 };

/* Of a vertex: rays that go up and down, how many of them are free, and the
 * reflectance that the others met. */
struct count {
    unsigned rays[2], open[2];
    float own[2];
};

static struct pel_vec3 corner(const struct pel_model *m, uint32_t index)
{
    const float *p = m->vertices[index].position;
    return (struct pel_vec3){ (double)p[0], (double)p[1], (double)p[2] };
}

static double reflectance(const struct pel_model *m, uint16_t material)
{
    const float *a = m->materials[material].albedo;
    double paint = (double)a[0] / 3 + (double)a[1] / 3 + (double)a[2] / 3;
    /* A texture's mean is not known here. */
    return m->materials[material].texture < 0 ? paint : 0.5 * paint;
}

/* The i-th of `count` directions by the cosine to z, turned by `turn`: a
 * spiral of golden angles. */
static struct pel_vec3 direction(int i, int count, double turn,
                                 const struct pel_vec3 frame[3])
{
    double r = sqrt((i + 0.5) / count), a = 2.39996322972865332 * i + turn;
    return pel_vec3_add(pel_vec3_add(pel_vec3_scale(frame[0], r * cos(a)),
                                     pel_vec3_scale(frame[1], r * sin(a))),
                        pel_vec3_scale(frame[2], sqrt(1 - r * r)));
}

/* Rays from a place; false: it lies inside the model, which most of them leave
 * through backs. */
static bool look(const struct pel_model *m, struct pel_vec3 from,
                 struct pel_vec3 normal, int rays, double turn,
                 struct count *out)
{
    const struct pel_vec3 other = { fabs(normal.x) < 0.6, fabs(normal.x) >= 0.6,
                                    0 };
    struct pel_vec3 frame[3] = {
        pel_vec3_normalize(pel_vec3_cross(other, normal)), { 0, 0, 0 }, normal
    };
    frame[1] = pel_vec3_cross(normal, frame[0]);
    int backs = 0;
    *out = (struct count){ 0 };
    for (int i = 0; i < rays; i++) {
        struct pel_vec3 d = direction(i, rays, turn, frame);
        struct pel_model_hit hit;
        bool down = d.z < 0;
        double most = down && from.z > 0 ? from.z / -d.z : 2 * m->radius_m;
        out->rays[down]++;
        if (!pel_model_cast(m, from, d, most, &hit)) {
            out->open[down]++;
            continue;
        }
        backs += !hit.front && !m->materials[hit.material].two_sided;
        out->own[down] += (float)reflectance(m, hit.material);
    }
    return 2 * backs <= rays;
}

static void add(struct count *to, const struct count *more)
{
    for (int k = 0; k < 2; k++) {
        to->rays[k] += more->rays[k];
        to->open[k] += more->open[k];
        to->own[k] += more->own[k];
    }
}

static void look_from(const struct pel_model *m, size_t triangle, int rays,
                      struct count *counts)
{
    const uint32_t *index = m->indices + 3 * triangle;
    struct pel_vec3 p[3], middle = { 0, 0, 0 };
    for (int i = 0; i < 3; i++) {
        p[i] = corner(m, index[i]);
        middle = pel_vec3_add(middle, pel_vec3_scale(p[i], 1.0 / 3));
    }
    double off = 1e-4 * m->radius_m + 1e-3;
    for (int i = 0; i < 3; i++) {
        const float *v = m->vertices[index[i]].normal;
        struct pel_vec3 n = { (double)v[0], (double)v[1], (double)v[2] };
        n = pel_vec3_normalize(n);
        double turn =
            2 * PI *
            fmod(0.6180339887498949 * (double)(3 * triangle + (size_t)i), 1);
        for (size_t k = 0; k < sizeof insets / sizeof *insets; k++) {
            struct pel_vec3 at =
                pel_vec3_add(pel_vec3_scale(p[i], 1 - insets[k]),
                             pel_vec3_scale(middle, insets[k]));
            struct count one;
            if (look(m, pel_vec3_add(at, pel_vec3_scale(n, off)), n, rays, turn,
                     &one)) {
                add(&counts[index[i]], &one);
                break;
            }
        }
    }
}

static uint8_t byte(double share)
{
    return (uint8_t)(255 * pel_clamp(share, 0, 1) + 0.5);
}

void pel_model_openness(const struct pel_model *m, struct pel_model_open *out)
{
    memset(out, 255, m->vertex_count * sizeof *out);
    for (size_t i = 0; i < m->vertex_count; i++) {
        out[i].own_above = out[i].own_below = 0;
    }
    struct count *counts = calloc(m->vertex_count, sizeof *counts);
    size_t triangles = m->levels[0].triangles;
    size_t rays = USUAL_RAYS / (3 * triangles);
    rays = rays < LEAST_RAYS ? LEAST_RAYS : rays > MOST_RAYS ? MOST_RAYS : rays;
    bool few = 3 * triangles * rays <= MOST_IN_ALL;
    for (size_t t = 0; t < triangles && counts && few; t++) {
        look_from(m, t, (int)rays, counts);
    }
    for (size_t i = 0; i < m->vertex_count && counts; i++) {
        const struct count *c = &counts[i];
        double all = c->rays[0] + c->rays[1];
        if (all == 0) {
            continue;
        }
        out[i].above = c->rays[0] ? byte((double)c->open[0] / c->rays[0]) : 255;
        out[i].below = c->rays[1] ? byte((double)c->open[1] / c->rays[1]) : 255;
        out[i].own_above = byte((double)c->own[0] / all);
        out[i].own_below = byte((double)c->own[1] / all);
    }
    free(counts);
}
