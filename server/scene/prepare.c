#include "scene/prepare.h"

#include <glib.h>

static struct pel_provision provision_ref(const struct pel_provision *from)
{
    struct pel_provision to = { 0 };
    to.sea = from->sea ? pel_shared_sea_ref(from->sea) : NULL;
    to.ground.key = g_strdup(from->ground.key);
    to.ground.bed = pel_seabed_ref(from->ground.bed);
    return to;
}

void pel_provision_finish(struct pel_provision *provision)
{
    pel_shared_sea_unref(provision->sea);
    pel_ground_finish(&provision->ground);
    provision->sea = NULL;
}

bool pel_provision_fits(const struct pel_provision *provision,
                        const Pelagos__State *state,
                        const struct pel_sea_means *means)
{
    return provision->sea && pel_shared_sea_is(provision->sea, state, means) &&
           pel_ground_is(&provision->ground, state);
}

enum pel_err pel_provision_get(const Pelagos__State *state,
                               const struct pel_sea_means *means,
                               const char *bathymetry,
                               const struct pel_provision *present,
                               struct pel_provision *out,
                               struct pel_fault *fault)
{
    *out = (struct pel_provision){ 0 };
    enum pel_err err =
        pel_shared_sea_get(state, means, present->sea, &out->sea, fault);
    if (err) {
        return err;
    }
    err = pel_ground_get(state, bathymetry, &present->ground, &out->ground,
                         fault);
    if (err) {
        pel_shared_sea_unref(out->sea);
        out->sea = NULL;
    }
    return err;
}

static void work(struct pel_task *task)
{
    struct pel_preparation *p = (struct pel_preparation *)task;
    p->err = pel_provision_get(p->state, p->means, p->bathymetry, &p->present,
                               &p->got, &p->fault);
    if (!p->err) {
        pel_shared_sea_value(p->got.sea);
    }
}

static void ended(struct pel_task *task, bool dropped)
{
    struct pel_preparation *p = (struct pel_preparation *)task;
    p->dropped = dropped;
    p->done(p->user, p);
}

struct pel_preparation *
pel_preparation_begin(struct pel_worker *worker, Pelagos__State *state,
                      const struct pel_sea_means *means, const char *bathymetry,
                      const struct pel_provision *present,
                      void (*done)(void *user, struct pel_preparation *ready),
                      void *user)
{
    struct pel_preparation *p = g_new0(struct pel_preparation, 1);
    *p = (struct pel_preparation){
        .task = { .work = work, .done = ended },
        .done = done,
        .user = user,
        .state = state,
        .means = means,
        .bathymetry = bathymetry,
        .present = provision_ref(present),
    };
    pel_worker_push(worker, &p->task);
    return p;
}

void pel_preparation_free(struct pel_preparation *p)
{
    pel_provision_finish(&p->got);
    pel_provision_finish(&p->present);
    pelagos__state__free_unpacked(p->state, NULL);
    g_free(p);
}
