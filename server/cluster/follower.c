/* A node that is led: it joins, applies the log, and takes over. */
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "base/watch.h"
#include "cluster/cluster_parts.h"
#include "message.h"
#include "scene/led.h"

#define SILENCE_NS 250000000LL
#define RANK_NS 50000000LL
#define ASK_NS 500000000LL /* one who never takes over looks again */
#define RETRY_MS 1000      /* from one attempt to join to the next */

/* --- joining -------------------------------------------------------------- */

static gboolean on_retry(gpointer user)
{
    PEL_WATCH("cluster");
    struct pel_cluster *c = user;
    c->retry = 0;
    pel_cluster_join(c);
    return G_SOURCE_REMOVE;
}

static void join_later(struct pel_cluster *c)
{
    if (!c->retry) {
        c->retry = g_timeout_add(RETRY_MS, on_retry, c);
    }
}

static void caught_up(struct pel_cluster *c)
{
    c->role = PELAGOS__CLUSTER_ROLE__FOLLOWER;
    c->sealed_ns = pel_now_ns();
    pel_cluster_lead(c);
    pel_info("CLU-003", "node %s follows node %s, from frame %llu on", c->name,
             c->master->name, (unsigned long long)c->number);
    pel_cluster_show(c, false, 0);
    pel_cluster_say(c, false);
}

static void founded(void *user, bool yes, uint64_t revision,
                    const struct pel_seals_view *view)
{
    struct pel_cluster *c = user;
    c->asking = false;
    if (!yes) {
        (void)view;
        pel_cluster_join(c); /* somebody else was first */
        return;
    }
    pel_info("CLU-004", "node %s begins the exercise", c->name);
    pel_cluster_keep_begin(c);
    pel_seals_follow(c->seals, revision);
    pel_cluster_become_master(c);
}

/* The exercise begins with the scene as it is here. */
static void found(struct pel_cluster *c)
{
    Pelagos__ClusterMaster me = PELAGOS__CLUSTER_MASTER__INIT;
    me.name = c->name;
    me.address = c->address;
    me.has_term = true;
    me.term = 1;
    pel_cluster_know_master(c, &me);
    double time_s = pel_scene_time(c->scene);
    pel_scene_anew(c->scene, time_s);
    Pelagos__ClusterHead *head =
        pel_cluster_head(c, 0, pel_scene_state_at(c->scene, time_s));
    pel_cluster_pack(c, head->state, c->digest, &c->packed);
    c->number = 0;
    c->alike = true;
    c->asking = true;
    pel_seals_found(c->seals, &me, head, founded, c);
    pelagos__cluster_head__free_unpacked(head, NULL);
}

/* Whether this program can show what that of the head does. */
static bool is_admitted(const struct pel_cluster *c,
                        const Pelagos__ClusterHead *head)
{
    static struct pel_log_limit limit;
    if (g_strcmp0(head->program, c->program) == 0 &&
        head->waves == (uint32_t)c->options.wave_count) {
        return true;
    }
    pel_log_limited(&limit, PEL_LOG_ERROR, "CLU-005",
                    "node %s cannot take part: the exercise is of %s with "
                    "--waves %u, this is %s with %d",
                    c->name, head->program, head->waves, c->program,
                    c->options.wave_count);
    return false;
}

static void looked(void *user, bool yes, uint64_t revision,
                   const struct pel_seals_view *view)
{
    static struct pel_log_limit limit;
    struct pel_cluster *c = user;
    struct pel_fault fault;
    (void)yes;
    (void)revision;
    c->asking = false;
    if (!view->head || !view->head->state || !view->master) {
        found(c);
        return;
    }
    pel_cluster_know_master(c, view->master);
    if (!is_admitted(c, view->head)) {
        join_later(c);
        return;
    }
    Pelagos__State *state =
        (Pelagos__State *)pel_message_copy(&view->head->state->base);
    if (pel_scene_begin_anew(c->scene, state, &fault)) {
        pel_log_limited(&limit, PEL_LOG_ERROR, "CLU-006",
                        "node %s cannot show the state of the exercise: %s %s",
                        c->name, fault.path, fault.message);
        join_later(c);
        return;
    }
    double time_s = pel_scene_time(c->scene);
    uint8_t digest[PEL_DIGEST_SIZE];
    pel_cluster_pack(c, pel_scene_state_at(c->scene, time_s), digest,
                     &c->packed);
    pel_cluster_advance(c, view->head->number,
                        pel_scene_snapshot_at(c->scene, time_s), time_s,
                        (uint64_t)pel_cluster_unix_ns(c), 0, digest);
    pel_scene_set_aside(c->scene);
    /* As it was put: with these bits all begin. */
    pel_cluster_pack(c, view->head->state, digest, &c->packed);
    pel_cluster_keep_begin(c);
    c->alike =
        g_strcmp0(view->head->device, pel_frames_device(c->frames)) == 0 &&
        view->head->canary.len == PEL_DIGEST_SIZE &&
        memcmp(view->head->canary.data, c->canary, PEL_DIGEST_SIZE) == 0;
    c->goal = view->number;
    c->following = true;
    pel_seals_follow(c->seals, view->head_revision);
    if (c->number >= c->goal) {
        caught_up(c);
    }
}

void pel_cluster_join(struct pel_cluster *c)
{
    c->role = PELAGOS__CLUSTER_ROLE__JOINING;
    c->following = false;
    c->since_ns = c->listened_ns;
    pel_cluster_lead(c);
    if (c->joined_ns && pel_now_ns() - c->joined_ns < RETRY_MS * 1000000LL) {
        join_later(c); /* what fails at once is not tried in a circle */
        return;
    }
    c->joined_ns = pel_now_ns();
    c->joins++;
    c->asking = true;
    pel_seals_look(c->seals, looked, c);
}

/* --- following ------------------------------------------------------------ */

/* For tests: this node's state becomes another one. */
static void stray(struct pel_cluster *c)
{
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__LogEntry entry = PELAGOS__LOG_ENTRY__INIT;
    struct pel_fault fault;
    clock.has_reckoning = true;
    clock.reckoning = 59;
    state.clock = &clock;
    patch.state = &state;
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_PATCH;
    entry.patch = &patch;
    entry.time = c->time_s;
    c->strayed = true;
    (void)!pel_scene_play(c->scene, &entry, &fault);
}

static bool play(struct pel_cluster *c, const Pelagos__SealedFrame *frame,
                 uint8_t digest[PEL_DIGEST_SIZE], struct pel_fault *fault)
{
    const Pelagos__Seal *seal = frame->seal;
    for (size_t i = 0; i < frame->n_entries; i++) {
        if (pel_scene_play(c->scene, frame->entries[i], fault)) {
            return false;
        }
    }
    if (pel_scene_play_to(c->scene, seal->time, fault)) {
        return false;
    }
    pel_scene_set_host_frame(c->scene, seal->host_frame);
    pel_cluster_pack(c, pel_scene_state_at(c->scene, seal->time), digest,
                     &c->packed);
    if (seal->digest.len != PEL_DIGEST_SIZE ||
        memcmp(seal->digest.data, digest, PEL_DIGEST_SIZE) != 0) {
        pel_fault_set(fault, PEL_ERR_CONFLICT, "the state is another one");
        return false;
    }
    if (seal->anew) {
        pel_scene_anew(c->scene, seal->time);
    }
    return true;
}

static void follow(struct pel_cluster *c, uint64_t number,
                   const Pelagos__SealedFrame *frame)
{
    const Pelagos__Seal *seal = frame->seal;
    struct pel_fault fault;
    uint8_t digest[PEL_DIGEST_SIZE];
    if (number != c->number + 1 || !seal) {
        c->gaps++;
        pel_warn("CLU-007",
                 "node %s was told of frame %llu after frame %llu, and joins "
                 "anew",
                 c->name, (unsigned long long)number,
                 (unsigned long long)c->number);
        pel_cluster_join(c);
        return;
    }
    if (c->options.stray > 0 && number >= c->options.stray && !c->strayed) {
        stray(c);
    }
    if (!play(c, frame, digest, &fault)) {
        c->differences++;
        pel_error("CLU-008",
                  "node %s is not as frame %llu was sealed, and joins anew: %s "
                  "%s",
                  c->name, (unsigned long long)number, fault.path,
                  fault.message);
        pel_cluster_join(c);
        return;
    }
    pel_cluster_advance(c, number, pel_scene_snapshot_at(c->scene, seal->time),
                        seal->time, seal->present, seal->host_frame, digest);
    pel_cluster_keep(c, frame->entries, frame->n_entries, seal->anew);
    c->quality = seal->quality;
    if (c->role == PELAGOS__CLUSTER_ROLE__FOLLOWER) {
        pel_cluster_heard(c, seal);
        pel_cluster_show(c, false, 0);
    } else if (c->number >= c->goal) {
        caught_up(c);
    }
}

void pel_cluster_on_frame(void *user, uint64_t number,
                          const Pelagos__SealedFrame *frame, uint64_t revision)
{
    PEL_WATCH("cluster");
    struct pel_cluster *c = user;
    pel_cluster_hear(c);
    if (c->role == PELAGOS__CLUSTER_ROLE__MASTER) {
        const Pelagos__Seal *seal = frame->seal;
        bool ours = seal && g_strcmp0(seal->master, c->name) == 0 &&
                    seal->term == c->master->term;
        if (ours) {
            pel_cluster_heard(c, seal);
        }
        if (ours && c->pending.on && number == c->pending.number) {
            pel_seals_ignore(c->seals);
            pel_cluster_confirm(c, revision);
        } else if (!ours && number > c->number) {
            pel_cluster_step_down(c, "another node seals");
        }
    } else if (c->following && number > c->number) {
        follow(c, number, frame);
    }
}

void pel_cluster_on_master(void *user, const Pelagos__ClusterMaster *master)
{
    struct pel_cluster *c = user;
    pel_cluster_hear(c);
    if (c->master && master->term < c->master->term) {
        return; /* of the past */
    }
    if (c->role == PELAGOS__CLUSTER_ROLE__MASTER) {
        if (!pel_cluster_is_me(c, master)) {
            pel_cluster_know_master(c, master);
            pel_cluster_step_down(c, "another node has taken over");
        }
        return;
    }
    pel_cluster_know_master(c, master);
    pel_cluster_lead(c);
    c->sealed_ns = pel_now_ns();
}

void pel_cluster_on_lost(void *user)
{
    struct pel_cluster *c = user;
    c->gaps++;
    pel_warn("CLU-009",
             "the store does not keep the frames after %llu any more: node %s "
             "joins anew",
             (unsigned long long)c->number, c->name);
    if (c->role == PELAGOS__CLUSTER_ROLE__MASTER) {
        pel_cluster_step_down(c, "the store forgets too soon");
    } else {
        pel_cluster_join(c);
    }
}

/* --- taking over ---------------------------------------------------------- */

static void took(void *user, bool yes, uint64_t revision,
                 const struct pel_seals_view *view)
{
    struct pel_cluster *c = user;
    (void)revision;
    c->asking = false;
    if (c->role != PELAGOS__CLUSTER_ROLE__FOLLOWER) {
        return;
    }
    if (yes) {
        Pelagos__ClusterMaster me = PELAGOS__CLUSTER_MASTER__INIT;
        me.name = c->name;
        me.address = c->address;
        me.has_term = true;
        me.term = c->term;
        pel_warn("CLU-010",
                 "node %s takes over from node %s, which was silent for %.0f "
                 "ms, after frame %llu",
                 c->name, c->silent, (double)c->silent_ns * 1e-6,
                 (unsigned long long)c->number);
        pel_cluster_know_master(c, &me);
        c->takeovers++;
        pel_cluster_become_master(c);
        return;
    }
    if (view->number > c->number) {
        pel_seals_elsewhere(c->seals); /* what we watch is silent */
    }
    if (view->master) {
        pel_cluster_know_master(c, view->master);
        pel_cluster_lead(c);
    }
    c->sealed_ns = pel_now_ns();
}

/* Of one who never takes over: whether there are frames that it is not told. */
static void asked(void *user, bool yes, uint64_t revision,
                  const struct pel_seals_view *view)
{
    (void)yes;
    took(user, false, revision, view);
}

void pel_cluster_be_patient(struct pel_cluster *c)
{
    int64_t silent_ns = pel_now_ns() - c->sealed_ns;
    if (c->role != PELAGOS__CLUSTER_ROLE__FOLLOWER || c->asking) {
        return;
    }
    if (c->options.rank < 0) {
        if (silent_ns > ASK_NS) {
            c->asking = true;
            pel_seals_look(c->seals, asked, c);
        }
        return;
    }
    if (silent_ns > SILENCE_NS + RANK_NS * pel_cluster_order(c)) {
        Pelagos__ClusterMaster me = PELAGOS__CLUSTER_MASTER__INIT;
        me.name = c->name;
        me.address = c->address;
        me.has_term = true;
        me.term = c->term = c->master->term + 1;
        /* The store may tell of ourselves before it answers. */
        g_free(c->silent);
        c->silent = g_strdup(c->master->name);
        c->silent_ns = silent_ns;
        c->asking = true;
        pel_seals_take(c->seals, c->master, c->number, &me, took, c);
    }
}
