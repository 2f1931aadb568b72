#include "frames/job.h"

#include "frames/core.h"
#include "scene/lamps.h"
#include "scene/wakes.h"
#include "scene/washes.h"

static void stand(struct pel_job *job)
{
    struct pel_environment *env = &job->environment;
    pel_environment_light(job->snapshot, env);
    env->sea = pel_snapshot_sea(job->snapshot);
    env->objects = job->objects;
    env->object_count =
        pel_snapshot_objects(job->snapshot, env->time_s, job->objects);
    env->lamps = job->lamps;
    env->lamp_count =
        pel_snapshot_lamps(job->snapshot, env->time_s, job->objects,
                           env->object_count, job->lamps);
    const struct pel_lightning *l = &job->snapshot->lightning;
    env->storm = l->per_minute > 0 && l->thickness_m > 0;
    env->glow_count = pel_lightning_glows(l, env->time_s, PEL_FALL_SHUTTER_S,
                                          env->glows, PEL_LIGHTNING_GLOWS);
    env->wakes = pel_wakes_at(job->snapshot->wakes, env->time_s);
    env->wash = pel_snapshot_wash(job->snapshot, env->time_s);
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
