#include "scene/prepare.h"

#include <glib.h>

#include "scene/helm.h"
#include "scene/ship.h"
#include "scene/ship_ahead.h"

struct pel_resources pel_resources_ref(const struct pel_resources *from)
{
    struct pel_resources to = { 0 };
    to.sea = from->sea ? pel_shared_sea_ref(from->sea) : NULL;
    to.ground.key = g_strdup(from->ground.key);
    to.ground.bed = pel_seabed_ref(from->ground.bed);
    to.fleet = pel_fleet_ref(&from->fleet);
    to.sky = pel_sky_file_ref(&from->sky);
    to.weather = pel_weather_file_ref(&from->weather);
    return to;
}

void pel_resources_finish(struct pel_resources *resources)
{
    pel_shared_sea_unref(resources->sea);
    pel_ground_finish(&resources->ground);
    pel_fleet_finish(&resources->fleet);
    pel_sky_file_finish(&resources->sky);
    pel_weather_file_finish(&resources->weather);
    resources->sea = NULL;
}

bool pel_resources_fits(const struct pel_resources *resources,
                        const Pelagos__State *state,
                        const struct pel_sea_means *means)
{
    return resources->sea && pel_ground_is(&resources->ground, state) &&
           pel_shared_sea_is(resources->sea, state, means,
                             &resources->ground) &&
           pel_fleet_has(&resources->fleet, state) &&
           pel_sky_file_is(&resources->sky, state) &&
           pel_weather_file_is(&resources->weather, state);
}

enum pel_err pel_resources_get(const Pelagos__State *state,
                               const struct pel_sea_means *means,
                               const struct pel_files *files,
                               const struct pel_resources *present,
                               struct pel_resources *out,
                               struct pel_fault *fault)
{
    *out = (struct pel_resources){ 0 };
    enum pel_err err = pel_ground_get(state, files->bathymetry,
                                      &present->ground, &out->ground, fault);
    if (!err) {
        err = pel_shared_sea_get(state, means, &out->ground, present->sea,
                                 &out->sea, fault);
    }
    if (!err) {
        err = pel_fleet_get(state, files->models, files->forgiving,
                            &present->fleet, &out->fleet, fault);
    }
    if (!err) {
        err = pel_sky_file_get(state, files->panoramas, files->forgiving,
                               &present->sky, &out->sky, fault);
    }
    if (!err) {
        err = pel_weather_file_get(state, files->weather, files->forgiving,
                                   &present->weather, &out->weather, fault);
    }
    if (err) {
        pel_resources_finish(out);
    }
    return err;
}

/* What ships under way ask of a new sea when it takes effect, soon. */
static void prepare_ships(const Pelagos__State *state,
                          const struct pel_sea *sea)
{
    if (pel_helm_any(state) &&
        state->clock->mode == PELAGOS__CLOCK_MODE__FREE) {
        pel_ships_hold_sea(sea, state->clock->time,
                           pel_ship_step_s(state->clock->rate));
    }
}

static void work(struct pel_task *task)
{
    struct pel_preparation *p = (struct pel_preparation *)task;
    p->err = pel_resources_get(p->state, p->means, p->files, &p->present,
                               &p->got, &p->fault);
    if (!p->err) {
        prepare_ships(p->state, pel_shared_sea_value(p->got.sea));
    }
}

static void ended(struct pel_task *task, bool dropped)
{
    struct pel_preparation *p = (struct pel_preparation *)task;
    p->dropped = dropped;
    p->done(p->user, p);
}

struct pel_preparation *pel_preparation_begin(
    struct pel_worker *worker, Pelagos__State *state,
    const struct pel_sea_means *means, const struct pel_files *files,
    const struct pel_resources *present,
    void (*done)(void *user, struct pel_preparation *ready), void *user)
{
    struct pel_preparation *p = g_new0(struct pel_preparation, 1);
    *p = (struct pel_preparation){
        .task = { .work = work, .done = ended },
        .done = done,
        .user = user,
        .state = state,
        .means = means,
        .files = files,
        .present = pel_resources_ref(present),
    };
    pel_worker_push(worker, &p->task);
    return p;
}

void pel_preparation_free(struct pel_preparation *p)
{
    pel_resources_finish(&p->got);
    pel_resources_finish(&p->present);
    pelagos__state__free_unpacked(p->state, NULL);
    g_free(p);
}
