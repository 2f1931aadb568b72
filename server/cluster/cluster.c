#include "cluster/cluster.h"

#include <math.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "cluster/cluster_parts.h"
#include "frames/mailbox.h"
#include "message.h"
#include "scene/led.h"

#define PATIENCE_MS 25
#define COAST_AFTER_NS 100000000LL
#define COAST_NS 1000000000LL
#define BEAT_MS 250
#define NAMED "a-z A-Z 0-9 . _ -"

int64_t pel_cluster_unix_ns(const struct pel_cluster *c)
{
    return pel_unix_ns() + (int64_t)(c->options.ahead_ms * 1e6);
}

static struct pel_packed pack(const Pelagos__State *state,
                              uint8_t digest[PEL_DIGEST_SIZE])
{
    struct pel_packed packed = { .size =
                                     pelagos__state__get_packed_size(state) };
    gsize length = PEL_DIGEST_SIZE;
    packed.bytes = g_malloc(packed.size + 1);
    pelagos__state__pack(state, packed.bytes);
    GChecksum *sum = g_checksum_new(G_CHECKSUM_SHA256);
    g_checksum_update(sum, packed.bytes, (gssize)packed.size);
    g_checksum_get_digest(sum, digest, &length);
    g_checksum_free(sum);
    return packed;
}

void pel_cluster_digest(const Pelagos__State *state,
                        uint8_t out[PEL_DIGEST_SIZE])
{
    g_free(pack(state, out).bytes);
}

void pel_cluster_pack(const struct pel_cluster *c, const Pelagos__State *state,
                      uint8_t digest[PEL_DIGEST_SIZE],
                      struct pel_packed *packed)
{
    g_free(packed->bytes);
    *packed = pack(state, digest);
    if (!c->options.log && !pel_scene_keeps_sealed(c->scene)) {
        g_clear_pointer(&packed->bytes, g_free);
    }
}

void pel_cluster_know_master(struct pel_cluster *c,
                             const Pelagos__ClusterMaster *master)
{
    if (c->master && strcmp(c->master->name, master->name) != 0) {
        pel_cluster_suspect(c, c->master->name);
    }
    if (c->master) {
        pelagos__cluster_master__free_unpacked(c->master, NULL);
    }
    c->master = (Pelagos__ClusterMaster *)pel_message_copy(&master->base);
}

bool pel_cluster_is_me(const struct pel_cluster *c,
                       const Pelagos__ClusterMaster *master)
{
    return c->role == PELAGOS__CLUSTER_ROLE__MASTER && c->master &&
           pel_message_same(&master->base, &c->master->base);
}

void pel_cluster_lead(struct pel_cluster *c)
{
    g_autofree char *cure = NULL;
    if (c->role == PELAGOS__CLUSTER_ROLE__JOINING || !c->master) {
        cure = g_strdup_printf("node %s is joining the exercise and takes no "
                               "edits; a little later",
                               c->name);
    } else {
        cure = g_strdup_printf("node %s shows what the master of the exercise "
                               "does: send this to node %s, %s",
                               c->name, c->master->name, c->master->address);
    }
    pel_scene_lead(c->scene, cure);
}

/* --- what is shown -------------------------------------------------------- */

void pel_cluster_show(struct pel_cluster *c, bool coasts, double further_s)
{
    int64_t now_ns = pel_now_ns();
    int64_t present_ns =
        (int64_t)c->present_unix_ns - pel_cluster_unix_ns(c) + now_ns;
    const struct pel_sealed sealed = {
        .snapshot = c->snapshot,
        .time_s = c->time_s + further_s,
        .number = c->number,
        .present_ns = coasts ? now_ns : present_ns,
        .present_unix_ns = coasts ? 0 : c->present_unix_ns,
        .host_frame = c->host_frame,
        .quality = c->quality,
        .coasts = coasts,
    };
    pel_frames_show(c->frames, &sealed);
}

void pel_cluster_advance(struct pel_cluster *c, uint64_t number,
                         const struct pel_snapshot *snapshot, double time_s,
                         uint64_t present_unix_ns, uint32_t host_frame,
                         const uint8_t digest[PEL_DIGEST_SIZE])
{
    int64_t now_ns = pel_now_ns();
    if (c->role != PELAGOS__CLUSTER_ROLE__JOINING) {
        c->worst_gap_ms =
            fmax(c->worst_gap_ms, (double)(now_ns - c->sealed_ns) * 1e-6);
    }
    pel_snapshot_unref(c->snapshot);
    c->snapshot = snapshot;
    c->number = number;
    c->time_s = time_s;
    c->present_unix_ns = present_unix_ns;
    c->host_frame = host_frame;
    c->sealed_ns = now_ns;
    memcpy(c->digest, digest, sizeof c->digest);
}

/* --- the store's silence -------------------------------------------------- */

/* The longest pause of the store that is none. */
static int64_t pause_ns(const struct pel_cluster *c)
{
    return MAX(COAST_AFTER_NS, (int64_t)(3e9 / c->options.rate_hz));
}

void pel_cluster_hear(struct pel_cluster *c)
{
    int64_t now_ns = pel_now_ns();
    c->listened_ns += MIN(now_ns - c->told_ns, pause_ns(c));
    c->told_ns = now_ns;
}

bool pel_cluster_is_current(const struct pel_cluster *c)
{
    return c->role != PELAGOS__CLUSTER_ROLE__JOINING &&
           pel_now_ns() - c->told_ns < MAX(COAST_NS, pause_ns(c));
}

/* Without new seals the last one goes on for a second, by its clock, and says
 * so; then it stands. */
static void coast(struct pel_cluster *c, int64_t now_ns)
{
    int64_t late_ns = now_ns - c->sealed_ns;
    if (c->role == PELAGOS__CLUSTER_ROLE__JOINING || late_ns < pause_ns(c) ||
        late_ns > COAST_NS) {
        return;
    }
    bool goes = c->snapshot->mode == PEL_CLOCK_FREE;
    c->coasted++;
    pel_cluster_show(c, true,
                     goes ? (double)late_ns * 1e-9 * c->snapshot->rate : 0);
}

/* --- timers --------------------------------------------------------------- */

static void on_tick(void *user)
{
    PEL_WATCH("cluster");
    struct pel_cluster *c = user;
    int64_t now_ns = pel_now_ns();
    int64_t period_ns = (int64_t)(1e9 / c->options.rate_hz);
    int64_t late = (now_ns - c->next_tick_ns) / period_ns;
    c->next_tick_ns += (late > 0 ? late + 1 : 1) * period_ns;
    g_source_set_ready_time(c->tick, c->next_tick_ns / 1000);
    if (c->role == PELAGOS__CLUSTER_ROLE__MASTER) {
        pel_cluster_seal(c);
    }
    coast(c, now_ns);
}

static gboolean on_patience(gpointer user)
{
    PEL_WATCH("cluster");
    struct pel_cluster *c = user;
    pel_cluster_be_patient(c);
    pel_cluster_place_on(c);
    return G_SOURCE_CONTINUE;
}

static gboolean on_beat(gpointer user)
{
    PEL_WATCH("cluster");
    struct pel_cluster *c = user;
    pel_cluster_say(c, ++c->quarters % (1000 / BEAT_MS) == 0);
    return G_SOURCE_CONTINUE;
}

/* --- life ----------------------------------------------------------------- */

bool pel_cluster_is_name(const char *name)
{
    return *name && strlen(name) <= 64 &&
           strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                        "0123456789._-") == strlen(name);
}

enum pel_err pel_cluster_create(const struct pel_cluster_options *options,
                                struct pel_scene *scene,
                                struct pel_frames *frames,
                                struct pel_cluster **out,
                                struct pel_fault *fault)
{
    struct pel_cluster *c = g_new0(struct pel_cluster, 1);
    *out = NULL;
    c->options = *options;
    c->name = g_strdup(options->name ? options->name : g_get_host_name());
    c->address = g_strdup(options->address);
    c->program = g_strdup(options->program);
    c->scene = scene;
    c->frames = frames;
    c->entries = pel_cluster_entries();
    c->nodes = g_ptr_array_new();
    c->warmed = g_hash_table_new_full(g_str_hash, g_str_equal, g_free, NULL);
    c->told_ns = pel_now_ns();
    c->quickest_ms = c->quickest_next_ms = INFINITY;
    const struct pel_seals_options seals = {
        .url = options->url,
        .cert = options->cert,
        .key = options->key,
        .ca = options->ca,
        .events = { pel_cluster_on_frame, pel_cluster_on_master,
                    pel_cluster_on_node, pel_cluster_on_places,
                    pel_cluster_on_lost, c },
    };
    enum pel_err err =
        pel_cluster_is_name(c->name)
            ? pel_seals_create(&seals, &c->seals, fault)
            : pel_fault_set(fault, PEL_ERR_INVALID,
                            "--exercise-node: '%.70s' is not 1 to 64 of " NAMED,
                            c->name);
    if (err) {
        pel_cluster_destroy(c);
        return err;
    }
    pel_scene_listen(scene, pel_cluster_on_command, c);
    pel_cluster_lead(c);
    c->time_s = pel_scene_time(scene);
    c->snapshot = pel_scene_snapshot_at(scene, c->time_s);
    c->tick = pel_alarm_create(g_main_context_default(), "cluster", on_tick, c);
    c->next_tick_ns = c->sealed_ns = pel_now_ns();
    g_source_set_ready_time(c->tick, c->next_tick_ns / 1000);
    c->patience = g_timeout_add(PATIENCE_MS, on_patience, c);
    c->beats = g_timeout_add(BEAT_MS, on_beat, c);
    pel_info("CLU-002", "node %s looks for the exercise at %s", c->name,
             options->url);
    pel_cluster_draw_canary(c);
    *out = c;
    return PEL_OK;
}

void pel_cluster_destroy(struct pel_cluster *c)
{
    if (!c) {
        return;
    }
    guint timers[] = { c->patience, c->beats, c->retry, c->settled };
    for (size_t i = 0; i < G_N_ELEMENTS(timers); i++) {
        if (timers[i]) {
            g_source_remove(timers[i]);
        }
    }
    if (c->canary_id) {
        pel_frames_cancel(c->frames, c->canary_id);
    }
    if (c->tick) {
        g_source_destroy(c->tick);
        g_source_unref(c->tick);
        pel_scene_listen(c->scene, NULL, NULL);
    }
    pel_cluster_warm_free(c);
    pel_seals_destroy(c->seals);
    pel_cluster_places_free(c);
    pel_cluster_drop_pending(c);
    g_ptr_array_free(c->entries, TRUE);
    pel_cluster_nodes_free(c);
    if (c->master) {
        pelagos__cluster_master__free_unpacked(c->master, NULL);
    }
    pel_snapshot_unref(c->snapshot);
    g_free(c->packed.bytes);
    g_free(c->name);
    g_free(c->address);
    g_free(c->program);
    g_free(c->silent);
    g_free(c);
}

void pel_cluster_set_rate(struct pel_cluster *c, double rate_hz)
{
    c->options.rate_hz = rate_hz;
}
