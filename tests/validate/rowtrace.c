#include "tests/validate/rowtrace.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "optics/brdf.h"

struct work {
    const struct row_plan *plan;
    const char *name;
    atomic_int next, done;
    struct row_result *rows;
    float **picture;
};

struct sums {
    double all[PARTS], met; /* weighted */
};

static struct pel_vec3 ray_at(const struct pel_camera *c, double x, double y)
{
    struct pel_vec3 ray = { c->tan_left + x * (c->tan_right - c->tan_left),
                            c->tan_top - y * (c->tan_top - c->tan_bottom),
                            -1.0 };
    return pel_vec3_normalize(pel_mat3_apply(&c->world_from_camera, ray));
}

/* Half of the rays evenly, half where the glitter is by eq. 15 with all slopes.
 * cdf[i] is the chance of a column below i. */
static void aim(const struct row_plan *p, int row, double *cdf)
{
    const struct pel_camera *c = &p->camera;
    double blur2 = p->light->blur * p->light->blur, total = 0.0;
    for (uint32_t i = 0; i < c->width; i++) {
        struct pel_vec3 v = pel_vec3_scale(
            ray_at(c, (i + 0.5) / c->width, (row + 0.5) / c->height), -1.0);
        cdf[i + 1] = pel_ross_sun(v, p->light->sun, p->slope_x + blur2,
                                  p->slope_y + blur2, 0.0);
        total += cdf[i + 1];
    }
    cdf[0] = 0.0;
    for (uint32_t i = 0; i < c->width; i++) {
        double share = total > 0.0 ? cdf[i + 1] / total : 1.0 / c->width;
        cdf[i + 1] = cdf[i] + 0.5 / c->width + 0.5 * share;
    }
}

static uint32_t column_of(const double *cdf, uint32_t width, double u)
{
    uint32_t low = 0, high = width - 1;
    while (low < high) {
        uint32_t middle = (low + high + 1) / 2;
        if (cdf[middle] <= u) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    return low;
}

static double fraction(double x)
{
    return x - floor(x);
}

static void trace_some(struct work *w, int row, const double *cdf, long from,
                       long to, struct sums *s, int *counts)
{
    const struct row_plan *p = w->plan;
    const struct pel_camera *c = &p->camera;
    const struct pel_vec3 eye = { 0.0, 0.0, c->altitude_m };
    for (long i = from; i < to; i++) {
        /* Roberts' R2 sequence: even in two dimensions at every length; each
         * row begins elsewhere. */
        double u = fraction(0.381966 * row + 0.7548776662466927 * (double)i);
        double y = fraction(0.716281 * row + 0.5698402909980532 * (double)i);
        uint32_t column = column_of(cdf, c->width, u);
        double chance = cdf[column + 1] - cdf[column];
        double x = pel_clamp((u - cdf[column]) / chance, 0.0, 1.0);
        struct reference_sample hit;
        if (!reference_trace(
                p->reference, eye,
                ray_at(c, (column + x) / c->width, (row + y) / c->height),
                &hit)) {
            continue;
        }
        double weight = 1.0 / (chance * c->width);
        const struct pel_rgb parts[PARTS] = { hit.sun, hit.sky, hit.water };
        s->met += weight;
        counts[column]++;
        for (int k = 0; k < PARTS; k++) {
            s->all[k] += weight * parts[k].g;
            float *to_pixel =
                &w->picture[k][3 * ((size_t)row * c->width + column)];
            to_pixel[0] += (float)parts[k].r;
            to_pixel[1] += (float)parts[k].g;
            to_pixel[2] += (float)parts[k].b;
        }
    }
}

static void trace_row(struct work *w, int row)
{
    const struct row_plan *p = w->plan;
    uint32_t width = p->camera.width;
    double cdf[ROW_MOST + 1];
    int counts[ROW_MOST] = { 0 };
    struct sums s = { 0 };
    struct row_result *r = &w->rows[row];
    bool moved = true;
    for (long n = 0; (n < p->most) && moved;) {
        long to = n == 0 ? p->least : 2 * n;
        if (n == 0) {
            aim(p, row, cdf);
        }
        trace_some(w, row, cdf, n, to, &s, counts);
        moved = n == 0;
        for (int k = 0; k < PARTS; k++) {
            double mean = s.met > 0.0 ? s.all[k] / s.met : 0.0;
            r->move[k] = mean > 0.0 ? fabs(r->energy[k] / mean - 1.0) : 0.0;
            r->energy[k] = mean;
            moved = moved || r->move[k] >= p->move;
        }
        n = to;
        r->rays = n;
    }
    for (uint32_t i = 0; i < width; i++) {
        for (int k = 0; k < PARTS && counts[i] > 0; k++) {
            float *pixel = &w->picture[k][3 * ((size_t)row * width + i)];
            for (int c = 0; c < 3; c++) {
                pixel[c] /= (float)counts[i];
            }
        }
    }
}

static void *work_rows(void *data)
{
    struct work *w = data;
    int height = (int)w->plan->camera.height, row;
    while ((row = atomic_fetch_add(&w->next, 1)) < height) {
        trace_row(w, row);
        int done = atomic_fetch_add(&w->done, 1) + 1;
        fprintf(stderr, "\r  %s: brute force, row %d of %d ", w->name, done,
                height - w->plan->first);
    }
    return NULL;
}

void rowtrace(const struct row_plan *plan, const char *name,
              struct row_result *rows, float *picture[PARTS])
{
    struct work work = {
        .plan = plan, .name = name, .rows = rows, .picture = picture
    };
    atomic_init(&work.next, plan->first);
    pthread_t threads[64];
    long count = sysconf(_SC_NPROCESSORS_ONLN), started = 0;
    count = count < 1 ? 1 : count > 64 ? 64 : count;
    while (started < count - 1 &&
           pthread_create(&threads[started], NULL, work_rows, &work) == 0) {
        started++;
    }
    work_rows(&work);
    for (long i = 0; i < started; i++) {
        pthread_join(threads[i], NULL);
    }
    fprintf(stderr, "\n");
}
