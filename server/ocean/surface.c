#include <math.h>
#include <stdbool.h>

#include "ocean/sea.h"

#define MET_M 1e-6
#define MOST_STEPS 40
#define MOST_HALVINGS 10

/* Everything the sum gives at one rest position. With p = k·x − ω t + phase:
 * D = (−k̂ c h sin p, h cos p), its derivatives, and the velocity. */
struct field {
    double dx, dy, dz;
    double xx, xy, yy; /* ∂dx/∂x, ∂dx/∂y = ∂dy/∂x, ∂dy/∂y */
    double zx, zy;     /* ∂dz/∂x, ∂dz/∂y */
    double vx, vy, vz;
};

static void field_at(const struct pel_sea *sea, double x, double y, double t,
                     struct field *f)
{
    *f = (struct field){ 0 };
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        double p = w->kx * x + w->ky * y - w->omega * t + w->phase;
        double sn = sin(p), cs = cos(p);
        double k = sqrt(w->kx * w->kx + w->ky * w->ky);
        double ux = w->kx / k, uy = w->ky / k;
        double h = w->amplitude, ch = w->chop * h;
        f->dx -= ux * ch * sn;
        f->dy -= uy * ch * sn;
        f->dz += h * cs;
        f->xx -= w->kx * ux * ch * cs;
        f->xy -= w->kx * uy * ch * cs;
        f->yy -= w->ky * uy * ch * cs;
        f->zx -= w->kx * h * sn;
        f->zy -= w->ky * h * sn;
        f->vx += ux * ch * w->omega * cs;
        f->vy += uy * ch * w->omega * cs;
        f->vz += h * w->omega * sn;
    }
}

struct pel_vec3 pel_sea_displace(const struct pel_sea *sea, double x, double y,
                                 double time_s)
{
    struct field f;
    field_at(sea, x, y, time_s, &f);
    return (struct pel_vec3){ f.dx, f.dy, f.dz };
}

/* The map x0 → x0 + D(x0) is the gradient of a convex function wherever it
 * does not fold, and its derivative is symmetric: Newton's step, with the
 * eigenvalues kept from zero, always leads downhill. */
static struct pel_vec2 newton_step(const struct field *f, double rx, double ry)
{
    double a = 1.0 + f->xx, b = f->xy, d = 1.0 + f->yy;
    double half = 0.5 * (a + d);
    double least = half - sqrt(0.25 * (a - d) * (a - d) + b * b);
    if (least < 0.02) {
        a += 0.02 - least;
        d += 0.02 - least;
    }
    double det = a * d - b * b;
    return (struct pel_vec2){ (d * rx - b * ry) / det,
                              (a * ry - b * rx) / det };
}

/* Field at the rest position that is carried to (x, y). */
static void field_above(const struct pel_sea *sea, double x, double y, double t,
                        struct field *f)
{
    double x0 = x, y0 = y;
    field_at(sea, x0, y0, t, f);
    double rx = -f->dx, ry = -f->dy;
    double error = rx * rx + ry * ry;
    for (int step = 0; step < MOST_STEPS && error > MET_M * MET_M; step++) {
        struct pel_vec2 s = newton_step(f, rx, ry);
        bool nearer = false;
        for (int i = 0; i < MOST_HALVINGS && !nearer; i++) {
            struct field next;
            double nx = x0 + s.x, ny = y0 + s.y;
            field_at(sea, nx, ny, t, &next);
            double ex = x - nx - next.dx, ey = y - ny - next.dy;
            double e = ex * ex + ey * ey;
            if (e < error) {
                nearer = true;
                x0 = nx;
                y0 = ny;
                rx = ex;
                ry = ey;
                error = e;
                *f = next;
            }
            s.x *= 0.5;
            s.y *= 0.5;
        }
        if (!nearer) {
            return; /* the rounding of far places: as near as doubles go */
        }
    }
}

void pel_sea_sample(const struct pel_sea *sea, double x_m, double y_m,
                    double time_s, struct pel_surface_sample *out)
{
    struct field f;
    field_above(sea, x_m, y_m, time_s, &f);
    struct pel_vec3 along_x = { 1.0 + f.xx, f.xy, f.zx };
    struct pel_vec3 along_y = { f.xy, 1.0 + f.yy, f.zy };
    out->height_m = f.dz;
    out->normal = pel_vec3_normalize(pel_vec3_cross(along_x, along_y));
    out->velocity_mps = (struct pel_vec3){ f.vx, f.vy, f.vz };
}

void pel_sea_query(const struct pel_sea *sea, const struct pel_vec2 *points,
                   size_t n, double time_s, struct pel_surface_sample *out)
{
    for (size_t i = 0; i < n; i++) {
        pel_sea_sample(sea, points[i].x, points[i].y, time_s, &out[i]);
    }
}
