#include "bridges/cigi_sea.h"

#include <glib.h>
#include <stdlib.h>
#include <string.h>

#include "bridges/cigi_pose.h"
#include "message.h"
#include "scene/worker.h"

/* Heights below entities at one moment. */
struct heights {
    struct pel_task task;
    struct pel_cigi_sea *sea;
    const struct pel_snapshot *snapshot; /* NULL: nothing is asked */
    double time_s;
    size_t count;
    uint32_t ids[PEL_CIGI_FOLLOWERS];
    struct pel_vec2 points[PEL_CIGI_FOLLOWERS];
    struct pel_surface_sample samples[PEL_CIGI_FOLLOWERS];
};

struct pel_cigi_sea {
    struct pel_scene *scene;
    struct pel_cigi_world *world;
    struct pel_cigi_sea_calls calls;
    bool building;
    Pelagos__Patch *wish; /* the next sea; NULL: none */
    struct pel_worker *worker;
    bool finding;
    struct heights now, next;
};

/* --- another sea ---------------------------------------------------------- */

/* Lists of the sea are set whole: those of `with` go before ours. */
static void drop_list(Pelagos__Patch *patch, const Pelagos__Patch *with,
                      const char *name, bool set)
{
    char path[24];
    g_snprintf(path, sizeof path, "sea.%s", name);
    for (size_t i = 0; i < with->n_remove; i++) {
        set = set || strcmp(with->remove[i], path) == 0;
    }
    if (!set) {
        return;
    }
    const ProtobufCFieldDescriptor *field =
        protobuf_c_message_descriptor_get_field_by_name(
            &pelagos__sea__descriptor, name);
    if (patch->state && patch->state->sea) {
        pel_message_clear(&patch->state->sea->base, field);
    }
    for (size_t i = 0; i < patch->n_remove;) {
        if (strcmp(patch->remove[i], path) == 0) {
            free(patch->remove[i]);
            patch->remove[i] = patch->remove[--patch->n_remove];
        } else {
            i++;
        }
    }
}

/* Both as one: numbers of the later, by protobuf's own rule for messages that
 * are written one after the other. */
static Pelagos__Patch *merged(Pelagos__Patch *first, const Pelagos__Patch *then)
{
    const Pelagos__Sea *sea = then->state ? then->state->sea : NULL;
    drop_list(first, then, "swell", sea && sea->n_swell > 0);
    drop_list(first, then, "wave", sea && sea->n_wave > 0);
    drop_list(first, then, "areas", sea && sea->n_areas > 0);
    size_t one = protobuf_c_message_get_packed_size(&first->base);
    size_t other = protobuf_c_message_get_packed_size(&then->base);
    g_autofree uint8_t *bytes = g_malloc(one + other + 1);
    protobuf_c_message_pack(&first->base, bytes);
    protobuf_c_message_pack(&then->base, bytes + one);
    pelagos__patch__free_unpacked(first, NULL);
    return pelagos__patch__unpack(NULL, one + other, bytes);
}

static void built(void *user, enum pel_err err, const struct pel_fault *fault);

static void build(struct pel_cigi_sea *self, const Pelagos__Patch *patch)
{
    const struct pel_scene_wish wish = { .patch = patch, .source = self };
    self->building = true;
    pel_scene_submit(self->scene, &wish, built, self);
}

static void built(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct pel_cigi_sea *self = user;
    Pelagos__Patch *wish = self->wish;
    self->building = false;
    self->wish = NULL;
    if (err) {
        self->calls.refused(self->calls.user, fault);
    }
    if (wish) {
        build(self, wish);
        pelagos__patch__free_unpacked(wish, NULL);
    }
}

void pel_cigi_sea_ask(struct pel_cigi_sea *self, const Pelagos__Patch *patch)
{
    if (!self->building) {
        build(self, patch);
    } else if (self->wish) {
        self->wish = merged(self->wish, patch);
    } else {
        self->wish = (Pelagos__Patch *)pel_message_copy(&patch->base);
    }
}

/* --- heights below entities ----------------------------------------------- */

static void work(struct pel_task *task)
{
    struct heights *heights = (struct heights *)task;
    pel_snapshot_surface(heights->snapshot, heights->points, heights->count,
                         heights->time_s, false, heights->samples);
}

static void heights_end(struct heights *heights)
{
    pel_snapshot_unref(heights->snapshot);
    heights->snapshot = NULL;
}

static void heights_found(struct pel_task *task, bool dropped);

static void begin(struct pel_cigi_sea *self)
{
    self->now = self->next;
    self->next.snapshot = NULL;
    self->finding = true;
    self->now.sea = self;
    self->now.task = (struct pel_task){ .work = work, .done = heights_found };
    pel_worker_push(self->worker, &self->now.task);
}

static void heights_found(struct pel_task *task, bool dropped)
{
    struct heights *heights = (struct heights *)task;
    struct pel_cigi_sea *self = heights->sea;
    self->finding = false;
    for (size_t i = 0; i < heights->count && !dropped; i++) {
        for (size_t k = 0; k < PEL_CIGI_FOLLOWERS; k++) {
            struct pel_cigi_follower *f = &self->world->followers[k];
            if (f->used && f->id == heights->ids[i]) {
                f->known = true;
                f->sea_m = heights->samples[i].height_m;
                f->normal = heights->samples[i].normal;
            }
        }
    }
    heights_end(heights);
    if (dropped) {
        return;
    }
    self->calls.known(self->calls.user);
    if (self->next.snapshot) {
        begin(self);
    }
}

void pel_cigi_sea_find_heights(struct pel_cigi_sea *self,
                               const struct pel_snapshot *snapshot,
                               double time_s)
{
    struct heights *next = &self->next;
    if (!pel_snapshot_transforms(snapshot)) {
        return; /* computed at once where it is needed */
    }
    heights_end(next);
    next->count = 0;
    next->time_s = time_s;
    for (size_t i = 0; i < PEL_CIGI_FOLLOWERS; i++) {
        const struct pel_cigi_follower *f = &self->world->followers[i];
        struct pel_vec3 at;
        struct pel_mat3 axes;
        if (f->used && f->how != PEL_CIGI_ON_PARENT &&
            pel_cigi_entity_axes(snapshot, f->id, time_s, &at, &axes)) {
            next->ids[next->count] = f->id;
            next->points[next->count++] = (struct pel_vec2){ at.x, at.y };
        }
    }
    if (next->count > 0) {
        next->snapshot = pel_snapshot_ref(snapshot);
        if (!self->finding) {
            begin(self);
        }
    }
}

/* --- life ----------------------------------------------------------------- */

struct pel_cigi_sea *pel_cigi_sea_create(struct pel_scene *scene,
                                         struct pel_cigi_world *world,
                                         const struct pel_cigi_sea_calls *calls)
{
    struct pel_cigi_sea *self = g_new0(struct pel_cigi_sea, 1);
    self->scene = scene;
    self->world = world;
    self->calls = *calls;
    self->worker = pel_worker_create("cigi sea");
    return self;
}

void pel_cigi_sea_destroy(struct pel_cigi_sea *self)
{
    if (!self) {
        return;
    }
    pel_scene_forget(self->scene, self);
    pel_worker_destroy(self->worker);
    heights_end(&self->next);
    if (self->wish) {
        pelagos__patch__free_unpacked(self->wish, NULL);
    }
    g_free(self);
}

void pel_cigi_sea_settle(struct pel_cigi_sea *self)
{
    do {
        while (pel_worker_wait(self->worker)) {
        }
        pel_scene_settle(self->scene);
    } while (self->building || self->finding);
}
