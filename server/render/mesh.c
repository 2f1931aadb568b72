#include "render/mesh.h"

#include <float.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>

#include "optics/atmosphere.h"

#define EDGE_SAMPLES 24 /* rays along each edge of the picture */
#define MAX_COLUMNS                                                            \
    (1 << 18)            /* around; finer ones are below a float's angle       \
                          */
#define RING_ATTEMPTS 12 /* with larger cells, before columns become fewer */
#define ATTEMPTS 40
/* Root mean square height that cells may lose, pixels of the picture at their
 * distance: rings are spaced by it. `drawn_test` has what is seen of it. */
#define LOSS_PX 0.35
#define LONGEST_CELL 0.15 /* in distances from the eye */

/* What a camera can see of the sea. */
struct reach {
    double nearest_m, farthest_m; /* distances from the nadir at rest */
    double azimuth_rad;           /* mathematical, of the middle */
    double left_rad, right_rad;   /* offsets, left ≥ 0 counter-clockwise */
    bool around;                  /* the nadir or the zenith is in sight */
};

/* Bounds of the displacement that count: five standard deviations. */
static double likely_shift(const struct pel_sea *sea)
{
    return fmin(sea->max_height_m, 5.0 * sqrt(sea->m0));
}

static struct pel_vec3 ray(const struct pel_camera *c, double x, double y)
{
    struct pel_vec3 v = { x, y, -1.0 };
    return pel_vec3_normalize(pel_mat3_apply(&c->world_from_camera, v));
}

static bool sees(const struct pel_camera *c, struct pel_vec3 world)
{
    double z = -pel_vec3_dot(world, c->world_from_camera.z);
    double x = pel_vec3_dot(world, c->world_from_camera.x);
    double y = pel_vec3_dot(world, c->world_from_camera.y);
    return z > 0 && x > c->tan_left * z && x < c->tan_right * z &&
           y > c->tan_bottom * z && y < c->tan_top * z;
}

static void reach_ray(struct reach *r, struct pel_vec3 d, double h, double dip,
                      double rise)
{
    double turn = remainder(atan2(d.y, d.x) - r->azimuth_rad, 2.0 * PEL_PI);
    r->left_rad = fmax(r->left_rad, turn);
    r->right_rad = fmax(r->right_rad, -turn);
    double depression = -asin(pel_clamp(d.z, -1.0, 1.0));
    if (depression > 1e-6) {
        double low = fmax(h - rise, 0.0) / tan(depression) - rise;
        r->nearest_m = fmin(r->nearest_m, fmax(low, 0.0));
    }
    /* Above this the horizon comes in sight. */
    if (depression < 1.5 * dip + 1e-3) {
        r->farthest_m = DBL_MAX;
    } else {
        r->farthest_m =
            fmax(r->farthest_m, 1.2 * (h + rise) / tan(depression) + rise);
    }
}

static struct reach find_reach(const struct pel_camera *c, double h, double dip,
                               double rise)
{
    struct pel_vec3 middle = ray(c, 0.5 * (c->tan_left + c->tan_right),
                                 0.5 * (c->tan_top + c->tan_bottom));
    struct reach r = {
        .nearest_m = h > rise ? DBL_MAX : 0.0,
        .azimuth_rad = atan2(middle.y, middle.x),
        .around = sees(c, (struct pel_vec3){ 0, 0, 1 }) ||
                  sees(c, (struct pel_vec3){ 0, 0, -1 }),
    };
    for (int i = 0; i <= EDGE_SAMPLES; i++) {
        double f = (double)i / EDGE_SAMPLES;
        double x = c->tan_left + f * (c->tan_right - c->tan_left);
        double y = c->tan_bottom + f * (c->tan_top - c->tan_bottom);
        reach_ray(&r, ray(c, x, c->tan_top), h, dip, rise);
        reach_ray(&r, ray(c, x, c->tan_bottom), h, dip, rise);
        reach_ray(&r, ray(c, c->tan_left, y), h, dip, rise);
        reach_ray(&r, ray(c, c->tan_right, y), h, dip, rise);
    }
    if (sees(c, (struct pel_vec3){ 0, 0, -1 })) {
        r.nearest_m = 0.0;
    }
    return r;
}

/* Mean square, of a wave's own, of what is lost when it is drawn with `weight`
 * by straight lines between places n to a wavelength, over all phases. */
static double lost(double n, double weight)
{
    double sinc = sin(PEL_PI / n) * n / PEL_PI;
    return 1.0 - 2.0 * weight * sinc * sinc +
           weight * weight * (2.0 + cos(2.0 * PEL_PI / n)) / 3.0;
}

void pel_mesh_losses(const struct pel_sea *sea, const struct pel_filter *filter,
                     struct pel_mesh_losses *out)
{
    static atomic_uint serials;
    out->serial = atomic_fetch_add(&serials, 1) + 1;
    const double shortest = log(0.01), longest = log(10000.0);
    double m0[PEL_MESH_LOSSES], at[PEL_MESH_LOSSES]; /* of a band, its middle */
    double below = 0.0;
    for (int i = 0; i < PEL_MESH_LOSSES; i++) {
        double f = i / (PEL_MESH_LOSSES - 1.0);
        out->cell_m[i] = exp(shortest + f * (longest - shortest));
        double rms = pel_sea_rms_below(sea, out->cell_m[i]);
        m0[i] = fmax(rms * rms - below, 0.0);
        at[i] = i ? sqrt(out->cell_m[i] * out->cell_m[i - 1]) : out->cell_m[0];
        below = rms * rms;
    }
    for (int i = 0; i < PEL_MESH_LOSSES; i++) {
        double sum = 0.0;
        for (int j = 0; j < PEL_MESH_LOSSES; j++) {
            double n = at[j] / out->cell_m[i];
            double weight = pel_filter_weight(filter, n);
            sum += m0[j] * (weight > 0.0 ? fmin(lost(n, weight), 1.0) : 1.0);
        }
        out->rms_m[i] = fmax(sqrt(sum), i ? out->rms_m[i - 1] : 0.0);
    }
}

/* Longest cell that loses no more than rms_m. */
static double longest_cell(const struct pel_mesh_losses *l, double rms_m)
{
    if (rms_m >= l->rms_m[PEL_MESH_LOSSES - 1]) {
        return DBL_MAX;
    }
    int low = 0, high = PEL_MESH_LOSSES - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (l->rms_m[middle] <= rms_m) {
            low = middle;
        } else {
            high = middle;
        }
    }
    double f = (rms_m - l->rms_m[low]) / (l->rms_m[high] - l->rms_m[low]);
    return l->cell_m[low] +
           pel_clamp(f, 0.0, 1.0) * (l->cell_m[high] - l->cell_m[low]);
}

/* The next ring; false: they are too many. */
static bool add_ring(struct pel_mesh_ring *rings, int *count, double radius_m,
                     double cell_m)
{
    if (*count >= PEL_MESH_MAX_RINGS - 4) {
        return false;
    }
    rings[(*count)++] =
        (struct pel_mesh_ring){ (float)radius_m, (float)cell_m };
    return true;
}

/* Rings from start_m to beyond the horizon, where crests of `rise` still stand
 * above it; their number, or -1 when they are too many. A cell is as long as
 * its waves lose LOSS_PX, whatever it is in the picture of level water: from
 * low down a pixel is many waves deep, but their crests hide each other, and
 * stand before the sky. `coarser` scales the cells. */
static int lay_rings(const struct pel_mesh_eye *eye, double start_m,
                     double horizon_m, double rise, double column_rad,
                     double coarser, struct pel_mesh_ring *rings)
{
    double h = fmax(eye->height_m, 0.5);
    double end =
        fmax(1.3 * horizon_m, horizon_m + sqrt(2.0 * PEL_EARTH_RADIUS * rise));
    double r = start_m;
    int count = 0;
    while (r < end) {
        double slant = hypot(r, h);
        double lateral = slant * column_rad;
        double seen = longest_cell(eye->losses, LOSS_PX * eye->pixel * slant);
        double cell = fmax(fmin(seen, LONGEST_CELL * slant), lateral) * coarser;
        if (!add_ring(rings, &count, r, cell)) {
            return -1;
        }
        /* One ring on the horizon itself, so that its line is exact. */
        r = r < horizon_m ? fmin(r + cell, horizon_m) : r + cell;
    }
    return add_ring(rings, &count, r, LONGEST_CELL * r) ? count : -1;
}

/* False: the vertices are too many. */
static bool add_block(struct pel_mesh *mesh, const struct reach *r,
                      int first_ring, int last_ring, double margin_rad)
{
    struct pel_mesh_block *b = &mesh->blocks[mesh->block_count];
    int n = mesh->columns_around;
    double left = r->azimuth_rad + r->left_rad + margin_rad;
    double right = r->azimuth_rad - r->right_rad - margin_rad;
    int first = (int)floor(right / mesh->column_rad) - 1;
    int columns = (int)ceil(left / mesh->column_rad) + 2 - first;
    if (r->around || columns > n) {
        first = 0;
        columns = n + 1;
    }
    int rings = last_ring - first_ring + 1;
    if (rings > (PEL_MESH_MAX_VERTICES - mesh->vertex_count) / columns) {
        return false;
    }
    *b = (struct pel_mesh_block){
        .first_ring = first_ring,
        .rings = rings,
        .first_column = ((first % n) + n) % n,
        .columns = columns,
        .base = mesh->vertex_count,
    };
    mesh->vertex_count += rings * columns;
    mesh->block_count++;
    return true;
}

/* Near rings need a wider sector: what rests outside the picture's edge may be
 * carried into it. Each block doubles its distance. False: too many vertices.
 */
static bool choose_blocks(struct pel_mesh *mesh, const struct reach *r,
                          double shift)
{
    mesh->block_count = 0;
    mesh->vertex_count = 0;
    int ring = 0;
    while (ring + 2 < mesh->ring_count &&
           mesh->rings[ring + 1].radius_m < r->nearest_m) {
        ring++;
    }
    int end = ring;
    while (end + 1 < mesh->ring_count &&
           mesh->rings[end].radius_m < r->farthest_m) {
        end++;
    }
    double limit = fmax(1.02 * shift, 1e-3);
    while (ring < end) {
        double start = mesh->rings[ring].radius_m;
        bool wide = start < limit;
        double margin = wide ? 2.0 * PEL_PI : asin(fmin(shift / start, 1.0));
        int last = ring + 1;
        bool final = mesh->block_count == PEL_MESH_MAX_BLOCKS - 1;
        double until = wide                  ? limit
                       : start < 2.5 * shift ? 1.3 * start
                                             : 2.0 * start;
        while (last < end && (final || mesh->rings[last].radius_m < until)) {
            last++;
        }
        if (!add_block(mesh, r, ring, last, margin)) {
            return false;
        }
        ring = last;
    }
    return true;
}

static double dip_of(const struct pel_mesh_eye *eye)
{
    double big = PEL_EARTH_RADIUS + eye->height_m;
    return acos(pel_clamp(PEL_EARTH_RADIUS / big, -1.0, 1.0));
}

void pel_mesh_narrow(const struct pel_mesh_eye *eye,
                     const struct pel_camera *part, struct pel_mesh *mesh)
{
    double shift = likely_shift(eye->sea);
    struct reach r = find_reach(part, eye->height_m, dip_of(eye), shift);
    struct pel_mesh_block blocks[PEL_MESH_MAX_BLOCKS];
    int block_count = mesh->block_count, vertex_count = mesh->vertex_count;
    memcpy(blocks, mesh->blocks, sizeof blocks);
    if (mesh->ring_count > 0 && !choose_blocks(mesh, &r, shift)) {
        memcpy(mesh->blocks, blocks, sizeof blocks);
        mesh->block_count = block_count;
        mesh->vertex_count = vertex_count;
    }
}

/* False: they are too many. */
static bool take_rings(const struct pel_mesh_eye *eye,
                       const struct pel_mesh_laid *by, double horizon_m,
                       const struct pel_mesh *like, struct pel_mesh *out)
{
    if (like && memcmp(&like->laid, by, sizeof *by) == 0) {
        if (like != out) {
            out->ring_count = like->ring_count;
            memcpy(out->rings, like->rings,
                   sizeof *out->rings * (size_t)like->ring_count);
        }
    } else {
        out->ring_count = lay_rings(eye, by->start_m, horizon_m, by->rise_m,
                                    by->column_rad, by->coarser, out->rings);
    }
    memset(&out->laid, 0, sizeof out->laid);
    if (out->ring_count > 0) {
        memcpy(&out->laid, by, sizeof *by);
    }
    return out->ring_count > 0;
}

void pel_mesh_plan(const struct pel_mesh_eye *eye,
                   const struct pel_camera *camera, const struct pel_mesh *like,
                   struct pel_mesh *out)
{
    double shift = likely_shift(eye->sea);
    double h = eye->height_m;
    double dip = dip_of(eye);
    double horizon_m = PEL_EARTH_RADIUS * dip;
    struct reach r = find_reach(camera, h, dip, shift);
    double columns = ceil(2.0 * PEL_PI / (eye->cell_px * eye->pixel));
    out->columns_around = (int)pel_clamp(columns, 24.0, MAX_COLUMNS);
    double start = 0.0, coarser = 1.0;
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        out->column_rad = 2.0 * PEL_PI / out->columns_around;
        struct pel_mesh_laid by;
        memset(&by, 0, sizeof by);
        by.height_m = h;
        by.pixel = eye->pixel;
        by.start_m = start;
        by.rise_m = shift;
        by.column_rad = out->column_rad;
        by.coarser = coarser;
        by.losses = eye->losses->serial;
        if (take_rings(eye, &by, horizon_m, like, out) &&
            choose_blocks(out, &r, shift)) {
            return;
        }
        /* First leave out what is nearer than the view needs, in powers of
         * two so that neighbours agree; then use larger cells, and where a
         * whole circle of such columns is too much, fewer of them. */
        double near_power = r.nearest_m > 1.0 && r.nearest_m < horizon_m
                                ? exp2(floor(log2(r.nearest_m)))
                                : 0.0;
        if (start < near_power) {
            start = near_power;
        } else if (attempt < RING_ATTEMPTS || out->columns_around < 48) {
            coarser *= 1.5;
        } else {
            out->columns_around /= 2;
        }
    }
    out->ring_count = out->block_count = out->vertex_count = 0;
    memset(&out->laid, 0, sizeof out->laid);
}
