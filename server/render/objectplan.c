#include "render/objectplan.h"

#include <math.h>
#include <string.h>

#include "render/objectshadow.h"
#include "render/tiles.h"
#include "render/uniforms.h"

#define NEAR_M 0.05 /* object.vert */
/* An entity is left out where it would be smaller, px. */
#define LEAST_PX 0.25
/* As PEL_OBJECT_LEVEL_PX, of other views. */
#define LEVEL_PX_BESIDE                                                        \
    1.0 /* mirrored, which waves distort; texels of shadows */
/* Corners of boxes are found without the waves' and the Earth's little bends.
 */
#define BOX_MARGIN_PX 3.0
/* Smaller things have no shadow. */
#define SHADOW_PX 12.0
/* Waves take a mirrored image aside by as many standard deviations of slopes at
 * most; a smaller share of the mirrored light does not count. */
#define ASIDE 0.6
#define LEAST_SHARE 0.01
/* lib/mirrored.glsl: of a box, where what an object does begins. */
#define FADED 0.08
#define SHADE_FADED 0.02
/* Depression, as a tangent, below which nothing is seen through the water. */
#define LEAST_DOWN 0.04
#define EVERYWHERE_PX 1e6
#define FARTHEST_M 80000.0

/* From the eye, as lib/model.glsl lays it over the sphere; `level` from the
 * eye's nadir and above the sea's zero. */
static struct pel_vec3 over_sphere(struct pel_vec3 level, double eye_m)
{
    double half2 = 0.25 * (level.x * level.x + level.y * level.y) /
                   (PEL_EARTH_RADIUS * PEL_EARTH_RADIUS);
    double flat, drop; /* of half of the arc: cos and sin^2 */
    if (half2 < 1e-4) {
        /* To 127 km, by series to 4e-15: each triangle that may cast a shadow
         * goes through here six times a picture. */
        flat = 1 - half2 / 2 * (1 - half2 / 12);
        drop = half2 * (1 - half2 / 3 * (1 - half2 * (2.0 / 15)));
    } else {
        flat = cos(sqrt(half2));
        drop = 1 - flat * flat;
    }
    return (struct pel_vec3){ level.x * flat, level.y * flat,
                              level.z - 2 * PEL_EARTH_RADIUS * drop - eye_m };
}

struct pel_vec3 pel_object_origin(const struct pel_environment *env,
                                  const struct pel_object *object,
                                  const struct pel_camera *c)
{
    return (struct pel_vec3){ object->east_m - c->east_m,
                              object->north_m - c->north_m,
                              object->altitude_m - env->sea_level_m };
}

/* Where a picture may show something: tangents. */
struct region {
    double left, low, right, high;
    int before, behind; /* points on either side of the eye */
};

static void widen(const struct pel_camera *c, struct pel_vec3 p,
                  struct region *r)
{
    const struct pel_mat3 *m = &c->world_from_camera;
    double away = -pel_vec3_dot(m->z, p);
    if (away <= NEAR_M) {
        r->behind++;
        return;
    }
    double x = pel_vec3_dot(m->x, p) / away, y = pel_vec3_dot(m->y, p) / away;
    /* Not by fmin, which is a call for what is no number. */
    r->left = x < r->left ? x : r->left;
    r->low = y < r->low ? y : r->low;
    r->right = x > r->right ? x : r->right;
    r->high = y > r->high ? y : r->high;
    r->before++;
}

#define NOWHERE                                                                \
    {                                                                          \
        HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL, 0, 0                         \
    }

/* Its pixels, from xy to before zw; false: none. */
static bool pixels_in(const struct region *r, const struct pel_camera *c,
                      int out[4])
{
    double px = (c->tan_right - c->tan_left) / c->width;
    double py = (c->tan_top - c->tan_bottom) / c->height;
    double low_x = (r->left - c->tan_left) / px - BOX_MARGIN_PX;
    double low_y = (c->tan_top - r->high) / py - BOX_MARGIN_PX;
    double high_x = (r->right - c->tan_left) / px + BOX_MARGIN_PX;
    double high_y = (c->tan_top - r->low) / py + BOX_MARGIN_PX;
    if (r->before == 0) {
        return false;
    }
    if (r->behind > 0) { /* it reaches behind the eye */
        low_x = low_y = 0;
        high_x = c->width;
        high_y = c->height;
    }
    out[0] = (int)floor(pel_clamp(low_x, 0, c->width));
    out[1] = (int)floor(pel_clamp(low_y, 0, c->height));
    out[2] = (int)ceil(pel_clamp(high_x, 0, c->width));
    out[3] = (int)ceil(pel_clamp(high_y, 0, c->height));
    return out[2] > out[0] && out[3] > out[1];
}

/* The corners of its bounding box, from z_m up in the model's axes, from the
 * eye's nadir and the sea's zero. */
static void corners_of(const struct pel_environment *env,
                       const struct pel_object *object,
                       const struct pel_camera *c, double z_m,
                       struct pel_vec3 out[8])
{
    const struct pel_model *model = object->model;
    struct pel_vec3 origin = pel_object_origin(env, object, c);
    for (int i = 0; i < 8; i++) {
        const struct pel_vec3 corner = {
            i & 1 ? model->high.x : model->low.x,
            i & 2 ? model->high.y : model->low.y,
            i & 4 ? model->high.z : fmax(model->low.z, z_m),
        };
        out[i] = pel_vec3_add(
            origin, pel_mat3_apply(&object->world_from_model, corner));
    }
}

/* The pixels that it may cover. */
static bool box_of(const struct pel_vec3 corners[8], const struct pel_camera *c,
                   double eye_m, int out[4])
{
    struct region r = NOWHERE;
    for (int i = 0; i < 8; i++) {
        widen(c, over_sphere(corners[i], eye_m), &r);
    }
    return pixels_in(&r, c, out);
}

/* The same on the lattice that the picture is a part of. */
static void on_lattice(const struct region *r, const struct pel_camera *c,
                       float out[4])
{
    double px = pel_pixel_pitch(c->tan_left, c->tan_right, c->width);
    double py = pel_pixel_pitch(c->tan_bottom, c->tan_top, c->height);
    double all = r->behind > 0 ? EVERYWHERE_PX : 0;
    out[0] = (float)(r->left / px - all);
    out[1] = (float)(-r->high / py - all);
    out[2] = (float)(r->right / px + all);
    out[3] = (float)(-r->low / py + all);
}

/* How far below its image in a calm sea, as a tangent, the sea may show
 * something of a thing that looks so wide and tall: less than LEAST_SHARE of
 * what facets there mirror is it, by a normal distribution of their slopes. */
static double mirrored_to(double deviation, double wide, double tall)
{
    double to = 2 * deviation;
    for (int i = 0; i < 32 && to > 0.02; i++) {
        double steep = 0.5 * to / deviation;
        double density =
            exp(-0.5 * steep * steep) / (2 * PEL_PI * deviation * deviation);
        /* A ray that rises by a facet's slope along the sight goes aside by
         * the slope across times the angle between them. */
        double slopes = 0.5 * tall * wide / (to + 2 * tall);
        if (density * slopes >= LEAST_SHARE) {
            break;
        }
        to -= 2 * deviation / 32;
    }
    return to;
}

/* The sea that may mirror it: down from its image in a calm sea, as wide as
 * waves spread it, which is less the closer the sea is to the horizon. `taper`:
 * the row of the lattice above which the box is narrower, by how many pixels a
 * row, by how many at most. */
static bool box_mirrored(const struct pel_environment *env,
                         const struct pel_vec3 corners[8],
                         const struct pel_camera *c, double eye_m, int out[4],
                         float lattice[4], float taper[3])
{
    struct region r = NOWHERE;
    for (int i = 0; i < 8; i++) {
        struct pel_vec3 p = corners[i];
        p.z = -fmax(p.z, 0);
        widen(c, over_sphere(p, eye_m), &r);
        p.z = 0;
        widen(c, over_sphere(p, eye_m), &r);
    }
    double deviation = sqrt(
        fmax(env->sea->slope_variance_along, env->sea->slope_variance_cross));
    double waves = 3 * sqrt(env->sea->m0) / eye_m; /* crests before it */
    double tall = r.high - r.low, wide = r.right - r.left;
    double to = r.behind ? 2 * deviation : mirrored_to(deviation, wide, tall);
    double side = ASIDE * deviation;
    r.high += fmin(waves, 1) * tall;
    r.left -= side;
    r.right += side;
    r.low -= to;
    r.high += FADED * 1.5 * (r.high - r.low);
    on_lattice(&r, c, lattice);
    /* Where the pixel looks level, if down is down in the picture. */
    const struct pel_mat3 *m = &c->world_from_camera;
    bool upright = fabs(m->x.z) < 0.05 && m->y.z > 0.5 && !r.behind;
    taper[0] = taper[1] = taper[2] = 0;
    if (upright) {
        double level = m->z.z / m->y.z;
        double px = pel_pixel_pitch(c->tan_left, c->tan_right, c->width);
        double py = pel_pixel_pitch(c->tan_bottom, c->tan_top, c->height);
        double fade = FADED * (r.right - r.left);
        /* Aside by two deviations times the angle between the rays. */
        taper[0] = (float)((0.5 * ASIDE - tall - level) / py);
        taper[1] = (float)(2 * deviation * py / px);
        taper[2] =
            (float)(fmax(side - fmax(2 * deviation * tall, fade), 0) / px);
    }
    return pixels_in(&r, c, out);
}

/* The sea through which its hull may be seen: a refracted ray goes at most
 * REFRACTED times its depth aside. */
#define REFRACTED 1.13
static void widen_by_hull(const struct pel_environment *env,
                          const struct pel_vec3 corners[8],
                          const struct pel_camera *c, double eye_m,
                          struct region *r)
{
    double waves = 3 * sqrt(env->sea->m0);
    for (int i = 0; i < 8; i++) {
        double aside = REFRACTED * fmax(-corners[i].z, 0);
        for (int k = 0; k < 8; k++) {
            struct pel_vec3 p = corners[i];
            p.x += k & 1 ? aside : -aside;
            p.y += k & 2 ? aside : -aside;
            p.z = k & 4 ? waves : -waves;
            widen(c, over_sphere(p, eye_m), r);
        }
    }
}

/* From the eye, at eye_m above the sea, to the object's box in its own axes; 0:
 * within. */
static double away_from(const struct pel_environment *env,
                        const struct pel_object *object,
                        const struct pel_camera *c, double eye_m)
{
    const struct pel_model *model = object->model;
    const struct pel_mat3 *m = &object->world_from_model;
    struct pel_vec3 to = pel_object_origin(env, object, c);
    const struct pel_vec3 eye = { -to.x, -to.y, eye_m - to.z };
    const double at[3] = { pel_vec3_dot(m->x, eye), pel_vec3_dot(m->y, eye),
                           pel_vec3_dot(m->z, eye) };
    const double low[3] = { model->low.x, model->low.y, model->low.z };
    const double high[3] = { model->high.x, model->high.y, model->high.z };
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        double off = at[i] - pel_clamp(at[i], low[i], high[i]);
        sum += off * off;
    }
    return sqrt(sum);
}

/* How many pixels a metre of the object's nearest part is wide. */
static double pixels_of(const struct pel_environment *env,
                        const struct pel_object *object,
                        const struct pel_camera *c)
{
    double pitch = fmin(pel_pixel_pitch(c->tan_left, c->tan_right, c->width),
                        pel_pixel_pitch(c->tan_bottom, c->tan_top, c->height));
    double away = away_from(env, object, c, c->altitude_m);
    return away > FARTHEST_M ? 0 : 1.0 / (fmax(away, 1.0) * pitch);
}

static void mark_tiles(const struct pel_camera *c, const int box[4],
                       unsigned mark, uint32_t *tiles)
{
    int across = (int)(c->width + PEL_TILE - 1) / PEL_TILE;
    for (int y = box[1] / PEL_TILE; y * PEL_TILE < box[3]; y++) {
        for (int x = box[0] / PEL_TILE; x * PEL_TILE < box[2]; x++) {
            tiles[y * across + x] |= (uint32_t)mark;
        }
    }
}

/* The sea that may lie in its shadow. */
static bool box_shaded(const struct pel_environment *env,
                       const struct pel_vec3 corners[8],
                       const struct pel_camera *c, double eye_m, int out[4],
                       float lattice[4])
{
    const struct pel_vec3 to = env->lights[PEL_LIGHT_FIRST].direction;
    double waves = 3 * sqrt(env->sea->m0);
    struct region r = NOWHERE;
    for (int i = 0; i < (to.z > 0 ? 16 : 0); i++) {
        struct pel_vec3 p = corners[i / 2];
        double level = i % 2 ? waves : -waves;
        double length = pel_clamp((p.z - level) / to.z, -PEL_FARTHEST_SHADOW_M,
                                  PEL_FARTHEST_SHADOW_M);
        p.x -= to.x * length;
        p.y -= to.y * length;
        p.z = level;
        widen(c, over_sphere(p, eye_m), &r);
    }
    double edge = SHADE_FADED * 1.2 * (r.right - r.left + r.high - r.low);
    r.left -= edge;
    r.right += edge;
    r.low -= edge;
    r.high += edge;
    on_lattice(&r, c, lattice);
    return pixels_in(&r, c, out);
}

/* A level of detail whose shadow's outline is within two hundredths of the
 * model's radius. */
static const struct pel_model_level *outline_of(const struct pel_model *model)
{
    const double per_m = 50 / model->radius_m;
    return &model->levels[pel_model_level_for(model, per_m, 1.0)];
}

/* The sea between crests and troughs that a triangle may shade. */
static void widen_by_shadow(const struct pel_vec3 corners[3],
                            struct pel_vec3 to, double waves,
                            const struct pel_camera *c, double eye_m,
                            struct region *r)
{
    double highest = fmax(fmax(corners[0].z, corners[1].z), corners[2].z);
    for (int i = 0; i < 3 && highest > -waves; i++) {
        const struct pel_vec3 *p = &corners[i];
        const double level[2] = { -waves, fmin(waves, highest) };
        for (int k = 0; k < 2; k++) {
            double length = (p->z - level[k]) / to.z;
            length = pel_clamp(length, 0, PEL_FARTHEST_SHADOW_M);
            const struct pel_vec3 end = { p->x - to.x * length,
                                          p->y - to.y * length, level[k] };
            widen(c, over_sphere(end, eye_m), r);
        }
        /* A cut in the middle of an edge lies above both its ends. */
        const struct pel_vec3 foot = { p->x, p->y, -waves };
        if (p->z > -waves && p->z < waves) {
            widen(c, over_sphere(foot, eye_m), r);
        }
    }
}

/* Marks the tiles that its triangles shade, of those in the box. */
static void mark_shadow(const struct pel_environment *env,
                        const struct pel_object *object,
                        const struct pel_camera *c, const int box[4],
                        unsigned mark, uint32_t *tiles)
{
    const struct pel_model *model = object->model;
    const struct pel_model_level *level = outline_of(model);
    const struct pel_vec3 to = env->lights[PEL_LIGHT_FIRST].direction;
    struct pel_vec3 origin = pel_object_origin(env, object, c);
    double eye_m = fmax(c->altitude_m, PEL_LEAST_EYE_M);
    double waves = 3 * sqrt(env->sea->m0);
    double wider = (double)level->error_m * pixels_of(env, object, c);
    for (size_t p = 0; p < level->part_count; p++) {
        const struct pel_model_part *part = &level->parts[p];
        for (uint32_t i = 0; i + 2 < part->count; i += 3) {
            struct pel_vec3 corners[3];
            for (uint32_t k = 0; k < 3; k++) {
                const float *at =
                    model->vertices[model->indices[part->first + i + k]]
                        .position;
                const struct pel_vec3 v = { (double)at[0], (double)at[1],
                                            (double)at[2] };
                corners[k] = pel_vec3_add(
                    origin, pel_mat3_apply(&object->world_from_model, v));
            }
            struct region r = NOWHERE;
            int of[4];
            widen_by_shadow(corners, to, waves, c, eye_m, &r);
            if (pixels_in(&r, c, of)) {
                const int part_of[4] = {
                    (int)fmax(box[0], of[0] - wider),
                    (int)fmax(box[1], of[1] - wider),
                    (int)fmin(box[2], of[2] + wider),
                    (int)fmin(box[3], of[3] + wider),
                };
                mark_tiles(c, part_of, mark, tiles);
            }
        }
    }
}

/* The sea that may show its hull. Seen from so low that the water's light is
 * next to nothing, it is left out. */
static bool box_in_water(const struct pel_environment *env,
                         const struct pel_object *object,
                         const struct pel_vec3 corners[8],
                         const struct pel_camera *c, double eye_m, int out[4],
                         float lattice[4])
{
    struct region r = NOWHERE;
    if (eye_m < LEAST_DOWN * away_from(env, object, c, 0)) {
        return false;
    }
    widen_by_hull(env, corners, c, eye_m, &r);
    on_lattice(&r, c, lattice);
    return pixels_in(&r, c, out);
}

/* Without the tiles that are beside its narrower part. */
static void mark_mirror(const struct pel_camera *c, const int box[4],
                        const struct pel_object_drawn *d, unsigned mark,
                        uint32_t *tiles)
{
    double first_x =
        c->tan_left / pel_pixel_pitch(c->tan_left, c->tan_right, c->width);
    double first_y =
        -c->tan_top / pel_pixel_pitch(c->tan_bottom, c->tan_top, c->height);
    for (int y = box[1] / PEL_TILE; y * PEL_TILE < box[3]; y++) {
        double row = first_y + (y + 1) * PEL_TILE;
        double inset =
            pel_clamp(((double)d->taper[0] - row) * (double)d->taper[1], 0,
                      (double)d->taper[2]);
        double left = (double)d->in_mirror[0] + inset - first_x;
        double right = (double)d->in_mirror[2] - inset - first_x;
        const int part[4] = { (int)fmax(box[0], floor(left)), y * PEL_TILE,
                              (int)fmin(box[2], ceil(right)),
                              (y + 1) * PEL_TILE };
        if (part[0] < part[2]) {
            mark_tiles(c, part, mark, tiles);
        }
    }
}

/* Of those that look largest from here, in sight or not, so that all views of a
 * lattice have the same; -1: smaller. */
static int rank_of(const double px[], size_t count, size_t i)
{
    int larger = 0;
    for (size_t k = 0; k < count; k++) {
        larger += px[k] > px[i] || (px[k] == px[i] && k < i);
    }
    return px[i] >= SHADOW_PX && larger < PEL_OBJECT_SHADOWS ? larger : -1;
}

static int shadow_side(double px)
{
    int side = 64;
    while (side < 1.5 * px && side < PEL_SHADOW_SIZE) {
        side *= 2;
    }
    return side;
}

double pel_object_mirrored_below(const struct pel_environment *env)
{
    return 0.3 + 2 * sqrt(env->sea->m0);
}

/* The mirrored view of what is above the sea. */
static bool look_mirrored(const struct pel_environment *env,
                          const struct pel_object *object,
                          const struct pel_camera *c, double eye_m, double px,
                          struct pel_mirror_view *out)
{
    struct pel_vec3 corners[8], level = pel_object_origin(env, object, c);
    level.z = 0;
    corners_of(env, object, c, -pel_object_mirrored_below(env), corners);
    for (int i = 0; i < 8; i++) {
        corners[i] = over_sphere(corners[i], eye_m);
    }
    return pel_mirror_look(corners, 8, over_sphere(level, eye_m).z, px, out);
}

/* What it does to the sea in sight. */
static void plan_beside(struct pel_object_drawn *d,
                        const struct pel_environment *env,
                        const struct pel_camera *c, int rank, double px,
                        uint32_t *tiles)
{
    const struct pel_object *object = &env->objects[d->object];
    double eye_m = fmax(c->altitude_m, PEL_LEAST_EYE_M);
    struct pel_vec3 corners[8];
    int box[4];
    d->shades = d->mirrored = false;
    memset(d->in_mirror, 0, sizeof d->in_mirror);
    memset(d->taper, 0, sizeof d->taper);
    memset(d->in_shade, 0, sizeof d->in_shade);
    memset(d->in_water, 0, sizeof d->in_water);
    if (rank < 0) {
        return;
    }
    corners_of(env, object, c, -HUGE_VAL, corners);
    if (box_shaded(env, corners, c, eye_m, box, d->in_shade)) {
        mark_shadow(env, object, c, box, PEL_TILE_SHADE(rank), tiles);
        d->shades = true;
    }
    if (box_in_water(env, object, corners, c, eye_m, box, d->in_water)) {
        mark_tiles(c, box, PEL_TILE_SHADE(rank) | PEL_TILE_HULLS, tiles);
        d->shades = true;
    }
    for (size_t i = 0; i < env->object_count && !d->shades; i++) {
        d->shades = i != (size_t)d->object &&
                    pel_shadow_reaches(env, object, &env->objects[i]);
    }
    if (rank < PEL_OBJECT_MIRRORS &&
        box_mirrored(env, corners, c, eye_m, box, d->in_mirror, d->taper) &&
        look_mirrored(env, object, c, eye_m, px, &d->image)) {
        mark_mirror(c, box, d, PEL_TILE_MIRROR(rank), tiles);
        d->mirrored = true;
    }
}

/* Levels of detail, as its views can show. */
static void plan_levels(struct pel_object_drawn *d,
                        const struct pel_environment *env,
                        const struct pel_camera *c)
{
    const struct pel_object *object = &env->objects[d->object];
    const struct pel_model *model = object->model;
    d->level = pel_model_level_for(model, pixels_of(env, object, c),
                                   PEL_OBJECT_LEVEL_PX);
    d->mirror_level = d->shadow_level = d->level;
    if (d->mirrored) {
        d->mirror_level = pel_model_level_for(model, pixels_of(env, object, c),
                                              LEVEL_PX_BESIDE);
    }
    if (d->slot < PEL_OBJECT_SHADOWS) {
        double texels = d->shadow_px / (2 * model->radius_m);
        int level = pel_model_level_for(model, texels, LEVEL_PX_BESIDE);
        d->shadow_level = level > d->level ? level : d->level;
    }
}

bool pel_objects_plan(struct pel_objects *o, const struct pel_environment *env,
                      const struct pel_camera *c, bool through, uint32_t *tiles)
{
    double eye_m = c->altitude_m;
    double px[PEL_MAX_ENTITIES];
    bool any = false;
    int others = PEL_OBJECT_SHADOWS;
    o->drawn_count = 0;
    for (size_t i = 0; i < env->object_count; i++) {
        const struct pel_object *object = &env->objects[i];
        px[i] = 2 * object->model->radius_m * pixels_of(env, object, c);
        any = any || px[i] >= LEAST_PX;
    }
    for (size_t i = 0; i < env->object_count; i++) {
        const struct pel_object *object = &env->objects[i];
        struct pel_object_drawn *d = &o->drawn[o->drawn_count];
        struct pel_vec3 corners[8];
        int box[4], rank = rank_of(px, env->object_count, i);
        corners_of(env, object, c, -HUGE_VAL, corners);
        d->object = (int)i;
        const bool straight =
            px[i] >= LEAST_PX && box_of(corners, c, eye_m, box);
        d->seen = straight || (through && px[i] >= LEAST_PX);
        plan_beside(d, env, c, rank, px[i], tiles);
        if (!d->seen && !d->shades && !d->mirrored) {
            continue;
        }
        if (straight) {
            mark_tiles(c, box, PEL_TILE_OBJECTS, tiles);
        }
        d->model = pel_model_pool_find(&o->pool, object->model);
        d->slot = rank >= 0 ? rank : others++;
        d->shadow_px = shadow_side(px[i]);
        plan_levels(d, env, c);
        o->drawn_count++;
    }
    return any;
}
