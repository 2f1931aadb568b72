#include "frames/job.h"

#include <math.h>
#include <stdlib.h>

#include "frames/core.h"
#include "scene/geodesy.h"
#include "scene/lamps.h"
#include "scene/wakes.h"
#include "scene/washes.h"

/* As a far place has them. */
struct pel_job_things {
    struct pel_object objects[PEL_MAX_ENTITIES];
    struct pel_lamp lamps[PEL_MAX_LAMPS];
};

/* The sea mirrors what is above the first entity (schedule.c); far from it,
 * what is above the eye. */
#define MIRRORS_M 5e3

static void see_things(const struct pel_job *job, const struct pel_place *place,
                       struct pel_object *objects, struct pel_lamp *lamps,
                       struct pel_environment *env)
{
    const struct pel_snapshot *s = job->snapshot;
    env->objects = objects;
    env->object_count = pel_snapshot_objects(s, env->time_s, place, objects);
    env->lamps = lamps;
    env->lamp_count = pel_snapshot_lamps(s, env->time_s, place, objects,
                                         env->object_count, lamps);
}

static void stand_place(struct pel_job *job, struct pel_job_place *there)
{
    struct pel_environment *env = &there->environment;
    const struct pel_place *place = &there->place;
    pel_place_settle(job->snapshot, &there->place);
    *env = job->environment;
    pel_environment_light_at(job->snapshot, place, env);
    if (hypot(place->east_m - env->own_east_m,
              place->north_m - env->own_north_m) > MIRRORS_M) {
        env->clouds_x_m += round(place->east_m) - env->own_east_m;
        env->clouds_y_m += round(place->north_m) - env->own_north_m;
        env->own_east_m = place->east_m;
        env->own_north_m = place->north_m;
    }
    if (place->far && !there->things) {
        there->things = calloc(1, sizeof *there->things);
    }
    if (there->things) { /* without memory the map is good enough */
        see_things(job, place, there->things->objects, there->things->lamps,
                   env);
    }
}

static void stand(struct pel_job *job)
{
    struct pel_environment *env = &job->environment;
    pel_environment_light(job->snapshot, env);
    env->sea = pel_snapshot_sea(job->snapshot);
    see_things(job, NULL, job->objects, job->lamps, env);
    const struct pel_lightning *l = &job->snapshot->lightning;
    env->storm = l->per_minute > 0 && l->thickness_m > 0;
    env->glow_count = pel_lightning_glows(l, env->time_s, PEL_FALL_SHUTTER_S,
                                          env->glows, PEL_LIGHTNING_GLOWS);
    env->wakes = pel_wakes_at(job->snapshot->wakes, env->time_s);
    env->wash = pel_snapshot_wash(job->snapshot, env->time_s);
    for (size_t i = 1; i < job->place_count; i++) {
        stand_place(job, &job->places[i - 1]);
    }
    for (size_t i = 0; i < job->draw_count; i++) {
        if (!job->parts[i].radar) {
            pel_snapshot_camera_in_wakes(job->snapshot, job->parts[i].view,
                                         env->time_s, &job->draws[i].camera);
        }
    }
}

void pel_job_stand(struct pel_job *job)
{
    pthread_mutex_lock(&job->standing);
    if (!job->stood) {
        stand(job);
        job->stood = true;
    }
    pthread_mutex_unlock(&job->standing);
}

void pel_job_settle(struct pel_job *job)
{
    pel_wake_moment_unref(job->environment.wakes);
    job->environment.wakes = NULL;
    pel_wash_destroy(job->environment.wash);
    job->environment.wash = NULL;
    job->stood = false;
}

void pel_job_end(struct pel_job *job)
{
    for (size_t i = 1; i < job->place_count; i++) {
        free(job->places[i - 1].things);
    }
    job->place_count = 0;
}

const struct pel_environment *pel_job_environment(const struct pel_job *job,
                                                  size_t draw)
{
    size_t place = job->parts[draw].place;
    return place > 0 ? &job->places[place - 1].environment : &job->environment;
}

double pel_job_turned(const struct pel_job *job, size_t draw)
{
    const struct pel_snapshot *s = job->snapshot;
    const struct pel_camera *c = &job->draws[draw].camera;
    double lat0 = s->origin_latitude_rad / PEL_DEG;
    double lon0 = s->origin_longitude_rad / PEL_DEG, lat, lon;
    if (job->parts[draw].place == 0) {
        return 0;
    }
    pel_geo_from_local(lat0, lon0, c->east_m, c->north_m, &lat, &lon);
    return pel_geo_turn(lat0, lon0, lat, lon);
}

void pel_job_settle_place(struct pel_job *job, size_t draw)
{
    struct pel_job_draw *part = &job->parts[draw];
    struct pel_place place = pel_snapshot_view_square(job->snapshot, part->view,
                                                      job->environment.time_s,
                                                      &job->draws[draw].camera);
    part->place = 0;
    if (place.origin) {
        return;
    }
    part->place = 1;
    while (part->place < job->place_count &&
           !pel_place_same(&job->places[part->place - 1].place, &place)) {
        part->place++;
    }
    if (part->place == job->place_count) {
        job->places[part->place - 1] = (struct pel_job_place){ .place = place };
        job->place_count++;
    }
}
