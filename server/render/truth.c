#include "render/truth.h"

#include <math.h>
#include <stdlib.h>

#include "models/model.h"
#include "optics/atmosphere.h"
#include "render/uniforms.h"

#define NEAR_M 0.05 /* object.vert */
#define LEVEL_PX 0.25
#define MOST_CORNERS 5 /* of a triangle cut by two planes */

struct looker {
    const struct pel_camera *camera;
    double eye_m; /* above the sea's zero */
    double sea_level_m;
    double pitch_x, pitch_y, first_x, first_y; /* pixels on the lattice */
    int width, height;
};

/* A corner of a triangle: in the camera, and its height over the waterline. */
struct corner {
    struct pel_vec3 p;
    double above;
};

static struct looker looker_of(const struct pel_picture *picture,
                               const struct pel_camera *camera,
                               const struct pel_environment *env)
{
    struct pel_block_view view; /* the very rays of the shaders */
    const struct pel_filter filter = PEL_FILTER_DEFAULT;
    pel_fill_view(camera, &filter, &view);
    return (struct looker){
        .camera = camera,
        .eye_m = camera->altitude_m - env->sea_level_m,
        .sea_level_m = env->sea_level_m,
        .pitch_x = (double)view.pixel.x,
        .pitch_y = (double)view.pixel.y,
        .first_x = (double)view.pixel.z,
        .first_y = (double)view.pixel.w,
        .width = (int)picture->width,
        .height = (int)picture->height,
    };
}

/* --- from the model to the picture ---------------------------------------- */

/* From the eye's nadir and the sea's zero, on the flat map. */
static struct pel_vec3 level_of(const struct looker *l,
                                const struct pel_object *o, struct pel_vec3 p)
{
    const struct pel_vec3 origin = { o->east_m - l->camera->east_m,
                                     o->north_m - l->camera->north_m,
                                     o->altitude_m - l->sea_level_m };
    return pel_vec3_add(origin, pel_mat3_apply(&o->world_from_model, p));
}

/* Right, down, ahead; over the sphere as lib/model.glsl lays it. */
static struct pel_vec3 into_camera(const struct looker *l, struct pel_vec3 p)
{
    const struct pel_mat3 *m = &l->camera->world_from_camera;
    double a2 = (p.x * p.x + p.y * p.y) *
                (0.25 / (PEL_EARTH_RADIUS * PEL_EARTH_RADIUS));
    double bent = 1.0 - 0.5 * a2;
    const struct pel_vec3 q = {
        p.x * bent, p.y * bent,
        p.z - 2.0 * PEL_EARTH_RADIUS * a2 * (1.0 - a2 / 3.0) - l->eye_m
    };
    return (struct pel_vec3){ pel_vec3_dot(m->x, q), -pel_vec3_dot(m->y, q),
                              -pel_vec3_dot(m->z, q) };
}

static double length(struct pel_vec3 p)
{
    return sqrt(pel_vec3_dot(p, p));
}

static double pixel_x(const struct looker *l, struct pel_vec3 p)
{
    return p.x / p.z / l->pitch_x - l->first_x;
}

static double pixel_y(const struct looker *l, struct pel_vec3 p)
{
    return p.y / p.z / l->pitch_y - l->first_y;
}

static struct pel_truth_point
point_of(const struct looker *l, const struct pel_object *o, struct pel_vec3 p)
{
    struct pel_vec3 level = level_of(l, o, p);
    struct pel_truth_point out = {
        .world = { level.x + l->camera->east_m, level.y + l->camera->north_m,
                   level.z + l->sea_level_m },
        .camera = into_camera(l, level),
    };
    out.before = out.camera.z > NEAR_M;
    if (out.before) {
        out.x = pixel_x(l, out.camera);
        out.y = pixel_y(l, out.camera);
    }
    return out;
}

/* --- its whole shape ------------------------------------------------------ */

static double over_plane(const struct corner *c, bool waterline)
{
    return waterline ? c->above : c->p.z - NEAR_M;
}

/* What of a convex polygon is on the near side of a plane. */
static int cut(const struct corner *in, int n, bool waterline,
               struct corner *out)
{
    int count = 0;
    for (int i = 0; i < n; i++) {
        const struct corner *a = &in[i], *b = &in[(i + 1) % n];
        double da = over_plane(a, waterline), db = over_plane(b, waterline);
        if (da >= 0) {
            out[count++] = *a;
        }
        if ((da >= 0) != (db >= 0)) {
            double t = da / (da - db);
            out[count++] = (struct corner){
                pel_vec3_add(pel_vec3_scale(a->p, 1 - t),
                             pel_vec3_scale(b->p, t)),
                a->above * (1 - t) + b->above * t,
            };
        }
    }
    return count;
}

struct canvas {
    uint16_t *stamps; /* a pixel: the last that covered it */
    uint16_t stamp;
    const float *id;
    float wanted;
    struct pel_truth *to;
};

static void cover_row(const struct looker *l, struct canvas *c, int y,
                      double from, double to)
{
    int first = (int)ceil(pel_clamp(from, 0, l->width) - 0.5);
    int end = (int)ceil(pel_clamp(to, 0, l->width) - 0.5);
    for (int x = first; x < end; x++) {
        size_t i = (size_t)y * (size_t)l->width + (size_t)x;
        if (c->stamps[i] != c->stamp) {
            c->stamps[i] = c->stamp;
            c->to->whole_pixels++;
            c->to->shown_pixels += c->id[i] == c->wanted;
        }
    }
}

static void widen(struct pel_truth_box *box, double x, double y)
{
    box->left = fmin(box->left, x);
    box->top = fmin(box->top, y);
    box->right = fmax(box->right, x);
    box->bottom = fmax(box->bottom, y);
}

/* Pixels whose middle is in a convex polygon. */
static void cover(const struct looker *l, struct canvas *c,
                  const double (*at)[2], int n)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < n; i++) {
        low = fmin(low, at[i][1]);
        high = fmax(high, at[i][1]);
        widen(&c->to->whole, at[i][0], at[i][1]);
    }
    int first = (int)ceil(pel_clamp(low, 0, l->height) - 0.5);
    int end = (int)ceil(pel_clamp(high, 0, l->height) - 0.5);
    for (int y = first; y < end; y++) {
        double middle = y + 0.5, from = HUGE_VAL, to = -HUGE_VAL;
        for (int i = 0; i < n; i++) {
            const double *a = at[i], *b = at[(i + 1) % n];
            if ((a[1] <= middle) != (b[1] <= middle)) {
                double x =
                    a[0] + (b[0] - a[0]) * (middle - a[1]) / (b[1] - a[1]);
                from = fmin(from, x);
                to = fmax(to, x);
            }
        }
        cover_row(l, c, y, from, to);
    }
}

static void cover_triangle(const struct looker *l, struct canvas *c,
                           const struct pel_object *o, const uint32_t *indices)
{
    struct corner corners[3], cut_once[MOST_CORNERS], rest[MOST_CORNERS];
    double at[MOST_CORNERS][2];
    for (int i = 0; i < 3; i++) {
        const float *v = o->model->vertices[indices[i]].position;
        const struct pel_vec3 p = { (double)v[0], (double)v[1], (double)v[2] };
        corners[i] = (struct corner){ into_camera(l, level_of(l, o, p)), p.z };
    }
    int n = cut(corners, 3, true, cut_once);
    n = cut(cut_once, n, false, rest);
    for (int i = 0; i < n; i++) {
        at[i][0] = pixel_x(l, rest[i].p);
        at[i][1] = pixel_y(l, rest[i].p);
    }
    if (n > 0) {
        cover(l, c, at, n);
    }
}

static void cover_model(const struct looker *l, struct canvas *c,
                        const struct pel_object *o)
{
    const struct pel_model *model = o->model;
    struct pel_vec3 middle =
        into_camera(l, level_of(l, o, (struct pel_vec3){ 0, 0, 0 }));
    if (middle.z < -model->radius_m) {
        return;
    }
    double away = fmax(length(middle) - model->radius_m, NEAR_M);
    double pixels_per_m = 1.0 / (fmin(l->pitch_x, l->pitch_y) * away);
    const struct pel_model_level *level =
        &model->levels[pel_model_level_for(model, pixels_per_m, LEVEL_PX)];
    for (size_t i = 0; i < level->part_count; i++) {
        const struct pel_model_part *part = &level->parts[i];
        for (uint32_t k = 0; k + 2 < part->count; k += 3) {
            cover_triangle(l, c, o, model->indices + part->first + k);
        }
    }
}

/* --- what is seen ----------------------------------------------------------
 */

static const struct pel_truth_box NOWHERE = { HUGE_VAL, HUGE_VAL, -HUGE_VAL,
                                              -HUGE_VAL };

/* By the id layer; places[id + 1]: of `out`, plus one. */
static void count_seen(const struct looker *l, const float *id,
                       const uint16_t *places, struct pel_truth *out)
{
    for (int y = 0; y < l->height; y++) {
        for (int x = 0; x < l->width; x++) {
            float value = id[(size_t)y * (size_t)l->width + (size_t)x];
            int place = value > 0 ? places[(uint32_t)value] : 0;
            if (place > 0) {
                struct pel_truth *t = &out[place - 1];
                t->pixels++;
                widen(&t->visible, x, y);
                widen(&t->visible, x + 1, y + 1);
            }
        }
    }
}

static void describe(const struct looker *l, struct pel_truth *t)
{
    const struct pel_object *o = t->object;
    const struct pel_model *m = o->model;
    for (int i = 0; i < 8; i++) {
        const struct pel_vec3 p = { i & 1 ? m->high.x : m->low.x,
                                    i & 2 ? m->high.y : m->low.y,
                                    i & 4 ? m->high.z : m->low.z };
        t->corners[i] = point_of(l, o, p);
    }
    double half = 0.5 * m->length_m;
    t->waterline[0] = point_of(l, o, (struct pel_vec3){ half, 0, 0 });
    t->waterline[1] = point_of(l, o, (struct pel_vec3){ -half, 0, 0 });
    struct pel_vec3 level = level_of(l, o, (struct pel_vec3){ 0, 0, 0 });
    t->distance_m = length(into_camera(l, level));
    t->bearing_rad = atan2(level.x, level.y);
}

enum pel_err pel_truth_find(const struct pel_picture *picture,
                            const struct pel_camera *camera,
                            const struct pel_environment *env,
                            struct pel_truth out[PEL_MAX_ENTITIES],
                            size_t *count)
{
    struct looker l = looker_of(picture, camera, env);
    size_t n = (size_t)picture->width * picture->height, kept = 0;
    uint16_t *places = calloc(UINT16_MAX + 2, sizeof *places);
    struct canvas c = { .stamps = calloc(n, sizeof *c.stamps),
                        .id = picture->id };
    *count = 0;
    if (!places || !c.stamps) {
        free(places);
        free(c.stamps);
        return PEL_ERR_NO_MEMORY;
    }
    for (size_t i = 0; i < env->object_count; i++) {
        out[i] = (struct pel_truth){ .object = &env->objects[i],
                                     .visible = NOWHERE,
                                     .whole = NOWHERE };
        places[env->objects[i].id + 1] = (uint16_t)(i + 1);
    }
    count_seen(&l, picture->id, places, out);
    for (size_t i = 0; i < env->object_count; i++) {
        struct pel_truth *t = &out[i];
        c.stamp = (uint16_t)(i + 1);
        c.wanted = (float)t->object->id + 1.0f;
        c.to = t;
        cover_model(&l, &c, t->object);
        if (t->pixels > 0 || t->whole_pixels > 0) {
            describe(&l, t);
            out[kept++] = *t;
        }
    }
    free(places);
    free(c.stamps);
    *count = kept;
    return PEL_OK;
}
