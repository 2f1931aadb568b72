#include "render/hullmap.h"

#include <math.h>

#include "shaders/lib/blocks.h"

#define HULL_TEXELS ((size_t)PEL_HULL_LENGTH * PEL_HULL_BREADTH)

/* Of PEL_HULL_LENGTH times `rows` texels, lowers those whose middles lie in the
 * triangle, in texels, to its z there. */
static void lower(const struct pel_vec3 c[3], int rows, float *out)
{
    double area = (c[1].x - c[0].x) * (c[2].y - c[0].y) -
                  (c[1].y - c[0].y) * (c[2].x - c[0].x);
    if (fabs(area) < 1e-12) {
        return; /* on its edge */
    }
    double low_x = fmin(c[0].x, fmin(c[1].x, c[2].x));
    double high_x = fmax(c[0].x, fmax(c[1].x, c[2].x));
    double low_y = fmin(c[0].y, fmin(c[1].y, c[2].y));
    double high_y = fmax(c[0].y, fmax(c[1].y, c[2].y));
    for (int y = (int)fmax(low_y, 0); y < fmin(high_y + 1, rows); y++) {
        for (int x = (int)fmax(low_x, 0); x < fmin(high_x + 1, PEL_HULL_LENGTH);
             x++) {
            double px = x + 0.5 - c[0].x, py = y + 0.5 - c[0].y;
            double u = (px * (c[2].y - c[0].y) - py * (c[2].x - c[0].x)) / area;
            double v = (py * (c[1].x - c[0].x) - px * (c[1].y - c[0].y)) / area;
            if (u >= 0 && v >= 0 && u + v <= 1) {
                float *at = &out[y * PEL_HULL_LENGTH + x];
                double z =
                    c[0].z + u * (c[1].z - c[0].z) + v * (c[2].z - c[0].z);
                *at = fminf(*at, (float)z);
            }
        }
    }
}

/* How far the model's cut at the waterline reaches in each row and column of
 * texels. */
struct cut {
    double row[PEL_HULL_BREADTH][2], column[PEL_HULL_LENGTH][2];
};

static void reach(double range[][2], int most, double from, double to,
                  double at_from, double at_to)
{
    double low = fmin(from, to), high = fmax(from, to);
    for (int i = (int)fmax(ceil(low - 0.5), 0); i < most && i + 0.5 <= high;
         i++) {
        double share = (i + 0.5 - from) / (to - from);
        double at = at_from + share * (at_to - at_from);
        range[i][0] = fmin(range[i][0], at);
        range[i][1] = fmax(range[i][1], at);
    }
}

/* Where the triangle, in texels, cuts the waterline's plane. */
static void cut_waterline(const struct pel_vec3 c[3], struct cut *cut)
{
    struct pel_vec3 at[3];
    int count = 0;
    for (int i = 0; i < 3; i++) {
        const struct pel_vec3 *a = &c[i], *b = &c[(i + 1) % 3];
        if ((a->z < 0) != (b->z < 0)) {
            double share = a->z / (a->z - b->z);
            at[count++] = pel_vec3_add(pel_vec3_scale(*a, 1 - share),
                                       pel_vec3_scale(*b, share));
        }
    }
    if (count == 2) {
        reach(cut->row, PEL_HULL_BREADTH, at[0].y, at[1].y, at[0].x, at[1].x);
        reach(cut->column, PEL_HULL_LENGTH, at[0].x, at[1].x, at[0].y, at[1].y);
    }
}

/* Under water, what lies beside the waterline's outline (a bulb, a rudder) has
 * the sea above it. */
static void keep_outline(const struct cut *cut, float *out)
{
    for (int y = 0; y < PEL_HULL_BREADTH; y++) {
        for (int x = 0; x < PEL_HULL_LENGTH; x++) {
            float *at = &out[y * PEL_HULL_LENGTH + x];
            bool within =
                x + 0.5 > cut->row[y][0] && x + 0.5 < cut->row[y][1] &&
                y + 0.5 > cut->column[x][0] && y + 0.5 < cut->column[x][1];
            *at = *at < 0 && !within ? (float)PEL_NO_HULL : *at;
        }
    }
}

static void fill(float *out, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        out[i] = (float)PEL_NO_HULL;
    }
}

/* Corners of the triangle `first` of the part, m. */
static void corners_of(const struct pel_model *m,
                       const struct pel_model_part *part, uint32_t first,
                       struct pel_vec3 out[3])
{
    for (uint32_t j = 0; j < 3; j++) {
        const float *p =
            m->vertices[m->indices[part->first + first + j]].position;
        out[j] = (struct pel_vec3){ (double)p[0], (double)p[1], (double)p[2] };
    }
}

static void add_below(const struct pel_model *m, struct pel_vec3 c[3],
                      struct cut *cut, float *out)
{
    double wide = PEL_HULL_LENGTH / fmax(m->high.x - m->low.x, 1e-6);
    double tall = PEL_HULL_BREADTH / fmax(m->high.y - m->low.y, 1e-6);
    for (int j = 0; j < 3; j++) {
        c[j].x = (c[j].x - m->low.x) * wide;
        c[j].y = (c[j].y - m->low.y) * tall;
    }
    lower(c, PEL_HULL_BREADTH, out);
    cut_waterline(c, cut);
}

void pel_hull_below(const struct pel_model *m, float *out)
{
    struct cut cut;
    fill(out, HULL_TEXELS);
    for (int i = 0; i < PEL_HULL_LENGTH; i++) {
        double *column = cut.column[i];
        column[0] = HUGE_VAL;
        column[1] = -HUGE_VAL;
        if (i < PEL_HULL_BREADTH) {
            cut.row[i][0] = HUGE_VAL;
            cut.row[i][1] = -HUGE_VAL;
        }
    }
    for (size_t i = 0; i < m->levels[0].part_count; i++) {
        const struct pel_model_part *part = &m->levels[0].parts[i];
        for (uint32_t k = 0; k + 2 < part->count; k += 3) {
            struct pel_vec3 c[3];
            corners_of(m, part, k, c);
            add_below(m, c, &cut, out);
        }
    }
    keep_outline(&cut, out);
}

void pel_hull_sides(const struct pel_model *m, float *out)
{
    const size_t half = (size_t)PEL_HULL_LENGTH * PEL_HULL_ROWS;
    double wide = PEL_HULL_LENGTH / fmax(m->high.x - m->low.x, 1e-6);
    double tall = PEL_HULL_ROWS / fmax(-m->low.z, 1e-6);
    fill(out, 2 * half);
    for (size_t i = 0; i < m->levels[0].part_count; i++) {
        const struct pel_model_part *part = &m->levels[0].parts[i];
        for (uint32_t k = 0; k + 2 < part->count; k += 3) {
            struct pel_vec3 from[3], side[3];
            corners_of(m, part, k, from);
            for (int port = 0; port < 2; port++) {
                for (int j = 0; j < 3; j++) {
                    side[j].x = (from[j].x - m->low.x) * wide;
                    side[j].y = (from[j].z - m->low.z) * tall;
                    side[j].z = port ? -from[j].y : from[j].y;
                }
                lower(side, PEL_HULL_ROWS, out + (port ? half : 0));
            }
        }
    }
}
