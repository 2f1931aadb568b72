#include "tests/bench/fleet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "models/builtin.h"
#include "models/shape.h"

#define MOST 256

static struct pel_object objects[MOST];
static size_t count;

const char *bench_fleet_name(enum bench_fleet fleet)
{
    static const char *const names[BENCH_FLEETS] = {
        "none",         "tanker, 220 m",     "tanker, 2 km",
        "a buoy, 50 m", "hull and 20 buoys", "256 boats"
    };
    return names[fleet];
}

static const struct pel_model *make(const char *name)
{
    const struct pel_builtin what = { .name = name };
    const struct pel_model *model = NULL;
    struct pel_fault fault;
    return pel_builtin_make(&what, &model, &fault) == PEL_OK ? model : NULL;
}

/* Up to 0.1 m, alike for corners at one place. */
static void unsettle(struct pel_model_vertex *v)
{
    double a = 12.9898 * (double)v->position[0] +
               78.233 * (double)v->position[1] +
               37.719 * (double)v->position[2];
    v->position[2] += (float)(0.1 * sin(a));
}

static struct pel_model_vertex between(const struct pel_model_vertex *a,
                                       const struct pel_model_vertex *b,
                                       const struct pel_model_vertex *c,
                                       float u, float v)
{
    struct pel_model_vertex out;
    memset(&out, 0, sizeof out);
    for (int i = 0; i < 3; i++) {
        out.position[i] = (1 - u - v) * a->position[i] + u * b->position[i] +
                          v * c->position[i];
    }
    return out;
}

/* Each triangle in nine, uneven, so that fewer would not do from close by. */
static void divide(const struct pel_model *m, struct pel_shape *s)
{
    enum { PARTS = 3 };
    for (size_t i = 0; i < m->material_count; i++) {
        pel_shape_material(s, &m->materials[i]);
    }
    int node = pel_shape_node(s, "all");
    for (size_t p = 0; p < m->levels[0].part_count; p++) {
        const struct pel_model_part *part = &m->levels[0].parts[p];
        for (uint32_t k = part->first; k < part->first + part->count; k += 3) {
            const struct pel_model_vertex *c[3];
            for (uint32_t j = 0; j < 3; j++) {
                c[j] = &m->vertices[m->indices[k + j]];
            }
            for (int t = 0; t < PARTS * PARTS; t++) {
                int row = (int)sqrt(t), at = t - row * row;
                int x = at / 2, y = PARTS - 1 - row;
                bool down = at % 2;
                const int places[2][3][2] = {
                    { { x, y }, { x + 1, y }, { x, y + 1 } },
                    { { x + 1, y }, { x + 1, y + 1 }, { x, y + 1 } }
                };
                struct pel_model_vertex corners[3];
                for (int j = 0; j < 3; j++) {
                    const int *q = places[down][j];
                    corners[j] = between(c[0], c[1], c[2], (float)q[0] / PARTS,
                                         (float)q[1] / PARTS);
                    unsettle(&corners[j]);
                }
                pel_shape_triangle(s, corners, part->material, node);
            }
        }
    }
}

static const struct pel_model *make_hull(void)
{
    const struct pel_model *plain = make("ferry"), *model = NULL;
    static struct pel_shape shape = { .name = "hull" };
    struct pel_model_draft draft = { 0 };
    struct pel_fault fault;
    if (plain) {
        shape.class = plain->class;
        divide(plain, &shape);
    }
    if (pel_shape_finish(&shape, &draft, &fault) == PEL_OK &&
        pel_model_create(&draft.model, &model, &fault) != PEL_OK) {
        model = NULL;
    }
    pel_model_draft_clear(&draft);
    pel_shape_clear(&shape);
    return model;
}

static bool put(const struct pel_environment *env,
                const struct pel_model *model, double east_m, double north_m,
                double heading)
{
    struct pel_fault fault;
    struct pel_surface_sample at;
    if (!model || pel_model_shade(model, &fault) != PEL_OK) {
        return false;
    }
    pel_sea_sample(env->sea, east_m, north_m, env->time_s, &at);
    double s = sin(heading * PEL_DEG), c = cos(heading * PEL_DEG);
    objects[count] = (struct pel_object){
        .id = (uint32_t)count + 1,
        .model = model,
        .east_m = east_m,
        .north_m = north_m,
        .altitude_m = model->length_m < 40 ? at.height_m : 0,
        .world_from_model = { { s, c, 0 }, { -c, s, 0 }, { 0, 0, 1 } },
    };
    count++;
    return true;
}

static bool put_marks(const struct pel_environment *env)
{
    static const struct pel_model *hull, *buoys[2];
    if (!hull) {
        hull = make_hull();
        buoys[0] = make("lateral-port-a");
        buoys[1] = make("lateral-starboard-a");
    }
    bool ok = put(env, hull, 0, 300, 60);
    for (int i = 0; i < 20; i++) {
        ok = ok &&
             put(env, buoys[i % 2], i % 2 ? 40 : -40, 80.0 + 80.0 * (i / 2), 0);
    }
    return ok;
}

static bool put_boats(const struct pel_environment *env)
{
    static const char *const names[4] = { "fishing-boat", "pilot-launch",
                                          "patrol-boat", "rib" };
    static const struct pel_model *boats[4];
    bool ok = true;
    for (int i = 0; i < 4 && !boats[i]; i++) {
        boats[i] = make(names[i]);
    }
    for (int i = 0; i < MOST && ok; i++) {
        double away = 200 + 5800 * (i / 255.0);
        double bearing = (i * 37 % 53 - 26) * PEL_DEG;
        ok = put(env, boats[i % 4], away * sin(bearing), away * cos(bearing),
                 i * 71 % 360);
    }
    return ok;
}

bool bench_fleet_set(enum bench_fleet fleet, struct pel_environment *env)
{
    static const struct pel_model *tanker, *buoy;
    bool ok = true;
    count = 0;
    if ((fleet == BENCH_TANKER_NEAR || fleet == BENCH_TANKER_FAR)) {
        tanker = tanker ? tanker : make("tanker");
        ok = put(env, tanker, 0, fleet == BENCH_TANKER_NEAR ? 220 : 2000, 60);
    } else if (fleet == BENCH_BUOY) {
        buoy = buoy ? buoy : make("cardinal-north");
        ok = put(env, buoy, 0, 50, 0);
    } else if (fleet == BENCH_MARKS) {
        ok = put_marks(env);
    } else if (fleet == BENCH_BOATS) {
        ok = put_boats(env);
    }
    env->objects = objects;
    env->object_count = count;
    return ok;
}

bool bench_fleet_wakes(int ships, double away_m, struct pel_environment *env)
{
    static struct pel_wake_moment moment;
    const double speed = 6.17, turn = speed / 500;
    static struct pel_wake_track track;
    for (int i = 0; i < ships && i < PEL_WAKES; i++) {
        track.hull = (struct pel_hull){ 100, 15, 6, 0.7 };
        track.count = 121;
        double now = env->time_s, east = (i % 3 - 1) * 700.0;
        double north = away_m + 600.0 * (i / 3);
        for (int k = 0; k < track.count; k++) {
            double before = 5.0 * (track.count - 1 - k);
            double a = i - turn * before;
            track.point[k] =
                (struct pel_wake_point){ now - before,
                                         east + 500 * (sin(a) - sin(i)),
                                         north + 500 * (cos(a) - cos(i)) };
        }
        struct pel_wake *wake;
        if (pel_wake_create(&track, env->time_s, 0, &wake)) {
            return false;
        }
        moment.wake[i] = *wake; /* its texels stay */
        free(wake);
        moment.id[i] = (uint32_t)i + 2;
        moment.count = (size_t)i + 1;
    }
    env->wakes = moment.count ? &moment : NULL;
    return true;
}
