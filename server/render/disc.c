#include "render/disc.h"

#include <math.h>

#define WIDER 1.29 /* than the disc, for the tangent's bend */
/* Its softened edge. */
#define EDGE_PX 3.0
#define LEAST_AHEAD 0.02 /* about a right angle off the axis */

/* Pixels from `at − margin` to `at + margin` of a picture `size` wide. */
static bool span(double at, double margin, uint32_t size, int *from, int *count)
{
    double lo = fmin(fmax(floor(at - margin), 0), size);
    double hi = fmin(ceil(at + margin), size);
    *from = (int)lo;
    *count = (int)(hi - lo);
    return hi > lo;
}

bool pel_disc_place(const struct pel_camera *c, struct pel_vec3 to,
                    double radius_rad, struct pel_disc_box *out)
{
    const struct pel_mat3 *m = &c->world_from_camera;
    double reach = WIDER * radius_rad;
    double ahead = -pel_vec3_dot(to, m->z);
    *out = (struct pel_disc_box){ 0, 0, (int)c->width, (int)c->height };
    if (ahead < LEAST_AHEAD) {
        double widest = fmax(fmax(fabs(c->tan_left), fabs(c->tan_right)),
                             fmax(fabs(c->tan_top), fabs(c->tan_bottom)));
        return ahead > -reach && widest > 0.5 / LEAST_AHEAD;
    }
    double x = pel_vec3_dot(to, m->x) / ahead;
    double y = pel_vec3_dot(to, m->y) / ahead;
    /* d tan θ = (1 + tan² θ) dθ, and more to the outer side */
    double radius = 2.0 * reach * (1.0 + x * x + y * y);
    double across = (c->tan_right - c->tan_left) / c->width;
    double down = (c->tan_top - c->tan_bottom) / c->height;
    double edge = EDGE_PX * fmax(across, down) + radius;
    return span((x - c->tan_left) / across, edge / across, c->width, &out->x,
                &out->width) &&
           span((c->tan_top - y) / down, edge / down, c->height, &out->y,
                &out->height);
}
