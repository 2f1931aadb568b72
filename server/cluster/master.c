/* The node that takes the inputs. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "cluster/cluster_parts.h"
#include "frames/present.h"
#include "message.h"
#include "scene/led.h"

#define HEAD_NS 10000000000LL   /* from one whole state to the next */
#define GIVE_UP_NS 3000000000LL /* then what was not sealed is undone */

Pelagos__ClusterHead *pel_cluster_head(struct pel_cluster *c, uint64_t number,
                                       const Pelagos__State *state)
{
    Pelagos__ClusterHead *head = (Pelagos__ClusterHead *)pel_message_new(
        &pelagos__cluster_head__descriptor);
    head->has_number = true;
    head->number = number;
    head->state = (Pelagos__State *)pel_message_copy(&state->base);
    head->program = strdup(c->program);
    head->has_waves = true;
    head->waves = (uint32_t)c->options.wave_count;
    head->device = strdup(pel_frames_device(c->frames));
    head->has_canary = true;
    head->canary.data = malloc(PEL_DIGEST_SIZE);
    head->canary.len = head->canary.data ? PEL_DIGEST_SIZE : 0;
    if (head->canary.data) {
        memcpy(head->canary.data, c->canary, PEL_DIGEST_SIZE);
    }
    return head;
}

/* --- what was accepted ---------------------------------------------------- */

void pel_cluster_on_command(void *user, double time_s,
                            const Pelagos__Patch *patch)
{
    struct pel_cluster *c = user;
    if (c->role != PELAGOS__CLUSTER_ROLE__MASTER || !patch) {
        return; /* a step's time is in the seal */
    }
    Pelagos__LogEntry *entry =
        (Pelagos__LogEntry *)pel_message_new(&pelagos__log_entry__descriptor);
    entry->has_time = entry->has_revision = true;
    entry->time = time_s;
    entry->revision = pel_scene_state(c->scene)->revision;
    entry->command_case = PELAGOS__LOG_ENTRY__COMMAND_PATCH;
    entry->patch = (Pelagos__Patch *)pel_message_copy(&patch->base);
    g_ptr_array_add(c->entries, entry);
}

static void free_entry(gpointer entry)
{
    pelagos__log_entry__free_unpacked(entry, NULL);
}

GPtrArray *pel_cluster_entries(void)
{
    return g_ptr_array_new_with_free_func(free_entry);
}

static void clear_pending(struct pel_cluster *c)
{
    if (c->pending.entries) {
        g_ptr_array_unref(c->pending.entries);
    }
    g_free(c->pending.packed.bytes);
    memset(&c->pending, 0, sizeof c->pending);
}

void pel_cluster_drop_pending(struct pel_cluster *c)
{
    pel_snapshot_unref(c->pending.snapshot);
    if (c->pending.head) {
        pelagos__cluster_head__free_unpacked(c->pending.head, NULL);
    }
    clear_pending(c);
    g_ptr_array_set_size(c->entries, 0);
}

/* --- a frame -------------------------------------------------------------- */

static void put_done(void *user, bool yes, uint64_t revision,
                     const struct pel_seals_view *view)
{
    struct pel_cluster *c = user;
    if (yes) {
        pel_cluster_confirm(c, revision);
        return;
    }
    if (view->master) {
        pel_cluster_know_master(c, view->master);
    }
    pel_cluster_step_down(c, "another node has taken over");
}

/* Simulated time of the frame: in PACED it advances by a frame. */
static double frame_moment(struct pel_cluster *c)
{
    static struct pel_log_limit limit;
    const Pelagos__Clock *clock = pel_scene_state(c->scene)->clock;
    struct pel_fault fault;
    if (clock->mode == PELAGOS__CLOCK_MODE__PACED &&
        !pel_scene_holds(c->scene) &&
        pel_scene_step(c->scene, clock->rate / c->options.rate_hz, &fault)) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "CLU-011",
                        "simulated time could not be advanced: %s",
                        fault.message);
    }
    return pel_scene_moment(c->scene);
}

static void begin_frame(struct pel_cluster *c, Pelagos__Seal *seal)
{
    int64_t now_ns = pel_now_ns();
    double time_s = frame_moment(c);
    bool head = c->head_ns == 0 || now_ns - c->head_ns > HEAD_NS;
    const Pelagos__State *state = pel_scene_state_at(c->scene, time_s);
    c->pending.on = true;
    c->pending.number = c->number + 1;
    c->pending.time_s = time_s;
    c->pending.begun_ns = now_ns;
    c->pending.host_frame = pel_scene_host_frame(c->scene);
    pel_cluster_pack(c, state, c->pending.digest, &c->pending.packed);
    if (head) {
        c->head_ns = now_ns;
        c->pending.head = pel_cluster_head(c, c->pending.number, state);
        pel_scene_anew(c->scene, time_s);
    }
    c->pending.snapshot = pel_scene_snapshot_at(c->scene, time_s);
    uint64_t made = (uint64_t)pel_cluster_unix_ns(c);
    c->pending.present_unix_ns =
        made + (uint64_t)(pel_cluster_slowest_ns(c) +
                          (int64_t)(PEL_DELIVERY_MS * 1e6));
    seal->has_number = seal->has_time = seal->has_made = true;
    seal->has_present = seal->has_digest = seal->has_term = true;
    seal->has_host_frame = seal->has_anew = true;
    seal->number = c->pending.number;
    seal->time = time_s;
    seal->made = made;
    seal->present = c->pending.present_unix_ns;
    seal->digest.data = c->pending.digest;
    seal->digest.len = PEL_DIGEST_SIZE;
    seal->master = c->name;
    seal->term = c->master->term;
    seal->host_frame = c->pending.host_frame;
    seal->has_quality = true;
    seal->quality = c->pending.quality = pel_cluster_quality(c);
    seal->anew = head;
}

void pel_cluster_seal(struct pel_cluster *c)
{
    Pelagos__SealedFrame frame = PELAGOS__SEALED_FRAME__INIT;
    Pelagos__Seal seal = PELAGOS__SEAL__INIT;
    if (c->pending.on) {
        c->overdue = true;
        if (pel_now_ns() - c->pending.begun_ns > GIVE_UP_NS) {
            pel_cluster_step_down(c, "the store does not answer");
        }
        return;
    }
    c->overdue = false;
    begin_frame(c, &seal);
    frame.seal = &seal;
    frame.n_entries = c->entries->len;
    frame.entries = (Pelagos__LogEntry **)c->entries->pdata;
    pel_seals_put(c->seals, c->master, seal.number, &frame, put_done, c);
    c->pending.entries = c->entries;
    c->entries = pel_cluster_entries();
    pel_scene_gate(c->scene, seal.number + 1);
}

void pel_cluster_confirm(struct pel_cluster *c, uint64_t revision)
{
    int64_t now_ns = pel_now_ns();
    Pelagos__ClusterHead *head = c->pending.head;
    c->sealed_ms[c->sealed++ % PEL_SEAL_WINDOW] =
        (float)((double)(now_ns - c->pending.begun_ns) * 1e-6);
    pel_cluster_advance(c, c->pending.number, c->pending.snapshot,
                        c->pending.time_s, c->pending.present_unix_ns,
                        c->pending.host_frame, c->pending.digest);
    g_free(c->packed.bytes);
    c->packed = c->pending.packed;
    c->pending.packed.bytes = NULL;
    pel_cluster_keep(c, (Pelagos__LogEntry **)c->pending.entries->pdata,
                     c->pending.entries->len, head != NULL);
    c->quality = c->pending.quality;
    clear_pending(c);
    pel_cluster_show(c, false, 0);
    pel_scene_sealed(c->scene, c->number);
    if (head) {
        head->has_store_revision = true;
        head->store_revision = revision;
        pel_seals_head(c->seals, c->master, head);
        pelagos__cluster_head__free_unpacked(head, NULL);
    }
    if (c->overdue) {
        g_source_set_ready_time(c->tick, 0);
    }
}

/* --- coming and going ----------------------------------------------------- */

void pel_cluster_become_master(struct pel_cluster *c)
{
    c->role = PELAGOS__CLUSTER_ROLE__MASTER;
    c->head_ns = 0;
    c->overdue = false;
    c->sealed_ns = pel_now_ns();
    pel_cluster_drop_pending(c);
    pel_scene_gate(c->scene, c->number + 1);
    pel_scene_unlead(c->scene);
    pel_info("CLU-012", "node %s is the master, from frame %llu on", c->name,
             (unsigned long long)c->number + 1);
    pel_cluster_seal(c);
}

void pel_cluster_step_down(struct pel_cluster *c, const char *why)
{
    struct pel_fault fault;
    pel_warn("CLU-013",
             "node %s is not the master any more, after frame %llu: %s",
             c->name, (unsigned long long)c->number, why);
    pel_fault_set(&fault, PEL_ERR_CONFLICT,
                  "it was not sealed before node %s stopped being the master "
                  "of the exercise: look whether it was done, and send it to "
                  "node %s, %s",
                  c->name, c->master->name, c->master->address);
    c->stepped_down++;
    c->role = PELAGOS__CLUSTER_ROLE__JOINING;
    pel_seals_drop(c->seals);
    pel_cluster_drop_pending(c);
    pel_cluster_lead(c);
    pel_scene_ungate(c->scene, &fault);
    pel_cluster_join(c);
}
