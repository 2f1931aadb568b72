#include "cluster/seals.h"

#include <glib.h>
#include <string.h>

#include "base/log.h"
#include "cluster/etcd.h"
#include "message.h"

struct pel_seals {
    struct pel_etcd *etcd;
    uint64_t foreign; /* values that no daemon has put */
    struct pel_seals_events events;
    char *root; /* `bridge/` */
    char *log, *master, *head, *nodes, *place;
    struct {
        struct pel_etcd_request *request; /* NULL: none */
        pel_seals_done done;
        void *user;
        /* A put that was done, though its answer was lost, is found by this. */
        GBytes *frame;
        GBytes *as; /* whoever it makes master; NULL: nobody */
        uint64_t number;
        bool always;
        bool look;
    } asked;
    struct pel_etcd_request *head_request, *node_request;
    struct {
        struct pel_etcd_request *request; /* NULL: none */
        pel_seals_placed done;
        void *user;
        Pelagos__ClusterPlaces *places;
        uint64_t version; /* when it is put */
    } placing;
};

static GBytes *pack(const ProtobufCMessage *message)
{
    size_t size = protobuf_c_message_get_packed_size(message);
    uint8_t *data = g_malloc(size + 1);
    protobuf_c_message_pack(message, data);
    return g_bytes_new_take(data, size);
}

static void *unpack(const ProtobufCMessageDescriptor *type,
                    const struct pel_etcd_kv *kv)
{
    return kv && kv->size > 0
               ? protobuf_c_message_unpack(type, NULL, kv->size, kv->value)
               : NULL;
}

static void release(void *message)
{
    if (message) {
        protobuf_c_message_free_unpacked(message, NULL);
    }
}

/* NULL: none, or not one that a daemon has put. */
static Pelagos__ClusterMaster *unpack_master(const struct pel_etcd_kv *kv)
{
    Pelagos__ClusterMaster *master =
        unpack(&pelagos__cluster_master__descriptor, kv);
    if (master && (!master->name || !master->address)) {
        release(master);
        master = NULL;
    }
    return master;
}

/* A value that is there and says nothing. */
static void foreign(struct pel_seals *seals, const struct pel_etcd_kv *kv)
{
    static struct pel_log_limit limit;
    seals->foreign++;
    pel_log_limited(
        &limit, PEL_LOG_WARNING, "CLU-023",
        "%.80s of etcd holds %zu bytes that no daemon has put there "
        "(version %llu): they are passed over; find who writes "
        "there, and let nodes alone do so",
        kv->key, kv->size, (unsigned long long)kv->version);
}

/* NULL: none, or not one that a daemon has put. */
static Pelagos__SealedFrame *unpack_frame(const struct pel_etcd_kv *kv)
{
    Pelagos__SealedFrame *frame =
        unpack(&pelagos__sealed_frame__descriptor, kv);
    if (frame && !frame->seal) {
        release(frame);
        frame = NULL;
    }
    return frame;
}

/* places: to be released. */
static struct pel_seals_places places_of(const struct pel_etcd_kv *kv,
                                         uint64_t revision)
{
    return (struct pel_seals_places){
        .places = unpack(&pelagos__cluster_places__descriptor, kv),
        .version = kv ? kv->version : 0,
        .revision = kv ? kv->mod_revision : revision,
    };
}

static void put(struct pel_etcd_txn *txn, const char *key, GBytes *value)
{
    gsize size;
    const uint8_t *data = g_bytes_get_data(value, &size);
    pel_etcd_put(txn, key, data, size);
}

static void if_master(struct pel_seals *seals, struct pel_etcd_txn *txn,
                      const Pelagos__ClusterMaster *master)
{
    gsize size;
    g_autoptr(GBytes) value = pack(&master->base);
    const uint8_t *data = g_bytes_get_data(value, &size);
    pel_etcd_if_value(txn, seals->master, data, size);
}

/* --- what is asked -------------------------------------------------------- */

static void forget(struct pel_seals *seals)
{
    g_clear_pointer(&seals->asked.frame, g_bytes_unref);
    g_clear_pointer(&seals->asked.as, g_bytes_unref);
    memset(&seals->asked, 0, sizeof seals->asked);
}

void pel_seals_drop(struct pel_seals *seals)
{
    if (seals->asked.request) {
        pel_etcd_drop(seals->asked.request);
    }
    forget(seals);
}

void pel_seals_ignore(struct pel_seals *seals)
{
    seals->asked.done = NULL;
}

static bool is_value(const struct pel_etcd_kv *kv, GBytes *value)
{
    gsize size;
    const void *data = value ? g_bytes_get_data(value, &size) : NULL;
    return kv && data && size > 0 && kv->size == size &&
           memcmp(kv->value, data, size) == 0;
}

static void answered(void *user, const struct pel_etcd_answer *answer)
{
    struct pel_seals *seals = user;
    const struct pel_etcd_kv *log = pel_etcd_find(answer, seals->log);
    const struct pel_etcd_kv *master = pel_etcd_find(answer, seals->master);
    const struct pel_etcd_kv *head = pel_etcd_find(answer, seals->head);
    struct pel_seals_view view = {
        .master = unpack_master(master),
        .head = unpack(&pelagos__cluster_head__descriptor, head),
        .number = log ? log->version : 0,
        .last = unpack_frame(log),
    };
    const struct {
        const struct pel_etcd_kv *kv;
        const void *message;
    } values[] = { { log, view.last },
                   { master, view.master },
                   { head, view.head } };
    for (size_t i = 0; i < G_N_ELEMENTS(values); i++) {
        if (values[i].kv && !values[i].message) {
            foreign(seals, values[i].kv);
        }
    }
    /* The head before the first frame was put with the master. */
    view.head_revision = view.head && view.head->store_revision
                             ? view.head->store_revision
                         : head ? head->mod_revision
                                : 0;
    uint64_t revision = answer->revision;
    bool yes = answer->succeeded;
    if (!yes && log && log->version == seals->asked.number &&
        is_value(log, seals->asked.frame)) {
        yes = true;
        revision = log->mod_revision;
    } else if (!yes && is_value(master, seals->asked.as)) {
        yes = true;
    }
    pel_seals_done done = seals->asked.done;
    void *to = seals->asked.user;
    bool look = seals->asked.look;
    forget(seals);
    if (look) {
        struct pel_seals_places places =
            places_of(pel_etcd_find(answer, seals->place), answer->revision);
        seals->events.places(seals->events.user, &places);
        release((void *)places.places);
    }
    if (done) {
        done(to, yes, revision, &view);
    }
    for (guint i = 0; i < answer->kvs->len; i++) {
        const struct pel_etcd_kv *kv = g_ptr_array_index(answer->kvs, i);
        if (kv->key && g_str_has_prefix(kv->key, seals->nodes)) {
            void *node = unpack(&pelagos__cluster_node__descriptor, kv);
            if (node) {
                seals->events.node(seals->events.user, node);
            } else {
                foreign(seals, kv);
            }
            release(node);
        }
    }
    release((void *)view.master);
    release((void *)view.head);
    release((void *)view.last);
}

static void ask(struct pel_seals *seals, struct pel_etcd_txn *txn,
                pel_seals_done done, void *user)
{
    seals->asked.done = done;
    seals->asked.user = user;
    seals->asked.request = pel_etcd_send(seals->etcd, txn, answered, seals);
}

void pel_seals_look(struct pel_seals *seals, pel_seals_done done, void *user)
{
    struct pel_etcd_txn txn;
    pel_seals_drop(seals);
    pel_etcd_txn_init(&txn);
    pel_etcd_get(&txn, true, seals->log, false);
    pel_etcd_get(&txn, true, seals->master, false);
    pel_etcd_get(&txn, true, seals->head, false);
    pel_etcd_get(&txn, true, seals->place, false);
    pel_etcd_get(&txn, true, seals->nodes, true);
    seals->asked.look = true;
    ask(seals, &txn, done, user);
}

void pel_seals_found(struct pel_seals *seals,
                     const Pelagos__ClusterMaster *master,
                     const Pelagos__ClusterHead *head, pel_seals_done done,
                     void *user)
{
    struct pel_etcd_txn txn;
    g_autoptr(GBytes) state = pack(&head->base);
    pel_seals_drop(seals);
    seals->asked.as = pack(&master->base);
    pel_etcd_txn_init(&txn);
    pel_etcd_if_version(&txn, seals->master, 0);
    put(&txn, seals->master, seals->asked.as);
    put(&txn, seals->head, state);
    pel_etcd_get(&txn, false, seals->master, false);
    ask(seals, &txn, done, user);
}

void pel_seals_put(struct pel_seals *seals,
                   const Pelagos__ClusterMaster *master, uint64_t number,
                   const Pelagos__SealedFrame *frame, pel_seals_done done,
                   void *user)
{
    struct pel_etcd_txn txn;
    pel_seals_drop(seals);
    seals->asked.frame = pack(&frame->base);
    seals->asked.number = number;
    pel_etcd_txn_init(&txn);
    pel_etcd_if_version(&txn, seals->log, number - 1);
    if_master(seals, &txn, master);
    put(&txn, seals->log, seals->asked.frame);
    pel_etcd_get(&txn, false, seals->log, false);
    pel_etcd_get(&txn, false, seals->master, false);
    ask(seals, &txn, done, user);
}

void pel_seals_take(struct pel_seals *seals, const Pelagos__ClusterMaster *from,
                    uint64_t number, const Pelagos__ClusterMaster *to,
                    pel_seals_done done, void *user)
{
    struct pel_etcd_txn txn;
    pel_seals_drop(seals);
    seals->asked.as = pack(&to->base);
    pel_etcd_txn_init(&txn);
    pel_etcd_if_version(&txn, seals->log, number);
    if_master(seals, &txn, from);
    put(&txn, seals->master, seals->asked.as);
    pel_etcd_get(&txn, false, seals->log, false);
    pel_etcd_get(&txn, false, seals->master, false);
    ask(seals, &txn, done, user);
}

/* --- what is only told ---------------------------------------------------- */

static void head_put(void *user, const struct pel_etcd_answer *answer)
{
    struct pel_seals *seals = user;
    (void)answer;
    seals->head_request = NULL;
}

void pel_seals_head(struct pel_seals *seals,
                    const Pelagos__ClusterMaster *master,
                    const Pelagos__ClusterHead *head)
{
    struct pel_etcd_txn txn;
    g_autoptr(GBytes) value = pack(&head->base);
    if (seals->head_request) {
        pel_etcd_drop(seals->head_request);
    }
    pel_etcd_txn_init(&txn);
    if_master(seals, &txn, master);
    put(&txn, seals->head, value);
    seals->head_request = pel_etcd_send(seals->etcd, &txn, head_put, seals);
}

static void node_put(void *user, const struct pel_etcd_answer *answer)
{
    struct pel_seals *seals = user;
    (void)answer;
    seals->node_request = NULL;
}

void pel_seals_node(struct pel_seals *seals, const Pelagos__ClusterNode *node,
                    bool if_idle)
{
    struct pel_etcd_txn txn;
    if (seals->node_request && if_idle) {
        return;
    }
    g_autoptr(GBytes) value = pack(&node->base);
    g_autofree char *key = g_strconcat(seals->nodes, node->name, NULL);
    if (seals->node_request) {
        pel_etcd_drop(seals->node_request);
    }
    pel_etcd_txn_init(&txn);
    put(&txn, key, value);
    seals->node_request = pel_etcd_send(seals->etcd, &txn, node_put, seals);
}

/* --- places --------------------------------------------------------------- */

void pel_seals_places_drop(struct pel_seals *seals)
{
    if (seals->placing.request) {
        pel_etcd_drop(seals->placing.request);
    }
    release(seals->placing.places);
    memset(&seals->placing, 0, sizeof seals->placing);
}

static void places_put(void *user, const struct pel_etcd_answer *answer)
{
    struct pel_seals *seals = user;
    const struct pel_etcd_kv *kv = pel_etcd_find(answer, seals->place);
    Pelagos__ClusterPlaces *ours = seals->placing.places;
    struct pel_seals_places now = { ours, seals->placing.version,
                                    answer->revision };
    if (!answer->succeeded) {
        now = places_of(kv, answer->revision);
    }
    pel_seals_placed done = seals->placing.done;
    void *to = seals->placing.user;
    memset(&seals->placing, 0, sizeof seals->placing);
    done(to, answer->succeeded, &now);
    if (!answer->succeeded) {
        release((void *)now.places);
    }
    release(ours);
}

void pel_seals_places(struct pel_seals *seals,
                      const Pelagos__ClusterMaster *master, uint64_t version,
                      const Pelagos__ClusterPlaces *places,
                      pel_seals_placed done, void *user)
{
    struct pel_etcd_txn txn;
    g_autoptr(GBytes) value = pack(&places->base);
    pel_seals_places_drop(seals);
    seals->placing.places =
        (Pelagos__ClusterPlaces *)pel_message_copy(&places->base);
    seals->placing.version = version + 1;
    seals->placing.done = done;
    seals->placing.user = user;
    pel_etcd_txn_init(&txn);
    pel_etcd_if_version(&txn, seals->place, version);
    if (master) {
        if_master(seals, &txn, master);
    }
    put(&txn, seals->place, value);
    pel_etcd_get(&txn, false, seals->place, false);
    seals->placing.request =
        pel_etcd_send(seals->etcd, &txn, places_put, seals);
}

/* --- what comes ----------------------------------------------------------- */

static void on_event(void *user, const struct pel_etcd_kv *kv)
{
    struct pel_seals *seals = user;
    const struct pel_seals_events *to = &seals->events;
    void *message = NULL;
    if (strcmp(kv->key, seals->place) == 0) {
        struct pel_seals_places places = places_of(kv, kv->mod_revision);
        to->places(to->user, &places);
        release((void *)places.places);
    } else if (kv->version == 0) {
        return; /* somebody has deleted it */
    } else if (strcmp(kv->key, seals->head) == 0) {
        return; /* for those who join */
    } else if (strcmp(kv->key, seals->log) == 0) {
        message = unpack_frame(kv);
        if (message) {
            to->frame(to->user, kv->version, message, kv->mod_revision);
        }
    } else if (strcmp(kv->key, seals->master) == 0) {
        message = unpack_master(kv);
        if (message) {
            to->master(to->user, message);
        }
    } else if (g_str_has_prefix(kv->key, seals->nodes)) {
        message = unpack(&pelagos__cluster_node__descriptor, kv);
        if (message) {
            to->node(to->user, message);
        }
    }
    if (kv->version > 0 && !message && strcmp(kv->key, seals->place) != 0) {
        foreign(seals, kv);
    }
    release(message);
}

static void on_lost(void *user)
{
    struct pel_seals *seals = user;
    seals->events.lost(seals->events.user);
}

void pel_seals_follow(struct pel_seals *seals, uint64_t after_revision)
{
    pel_etcd_watch(seals->etcd, seals->root, after_revision + 1, on_event,
                   on_lost, seals);
}

void pel_seals_elsewhere(struct pel_seals *seals)
{
    pel_etcd_watch_elsewhere(seals->etcd);
}

/* --- life ----------------------------------------------------------------- */

enum pel_err pel_seals_create(const struct pel_seals_options *options,
                              struct pel_seals **out, struct pel_fault *fault)
{
    const char *slash = strrchr(options->url, '/');
    const char *last = strrchr(options->url, ',');
    const char *scheme = strstr(last ? last : options->url, "://");
    *out = NULL;
    if (!scheme || !slash || slash <= scheme + 3 || !slash[1] ||
        strspn(slash + 1, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                          "0123456789._-") != strlen(slash + 1)) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "'%.100s' does not end in the exercise's name, as in "
            "http://10.0.0.1:2379,http://10.0.0.2:2379/bridge",
            options->url);
    }
    struct pel_seals *seals = g_new0(struct pel_seals, 1);
    g_autofree char *endpoints =
        g_strndup(options->url, (gsize)(slash - options->url));
    const struct pel_etcd_options etcd = { endpoints, options->cert,
                                           options->key, options->ca };
    seals->events = options->events;
    seals->root = g_strconcat(slash + 1, "/", NULL);
    seals->log = g_strconcat(seals->root, "log", NULL);
    seals->master = g_strconcat(seals->root, "master", NULL);
    seals->head = g_strconcat(seals->root, "head", NULL);
    seals->nodes = g_strconcat(seals->root, "nodes/", NULL);
    seals->place = g_strconcat(seals->root, "place", NULL);
    enum pel_err err = pel_etcd_create(&etcd, &seals->etcd, fault);
    if (err) {
        pel_seals_destroy(seals);
        return err;
    }
    *out = seals;
    return PEL_OK;
}

void pel_seals_destroy(struct pel_seals *seals)
{
    if (!seals) {
        return;
    }
    pel_etcd_destroy(seals->etcd);
    seals->placing.request = NULL;
    pel_seals_places_drop(seals);
    forget(seals);
    g_free(seals->root);
    g_free(seals->log);
    g_free(seals->master);
    g_free(seals->head);
    g_free(seals->nodes);
    g_free(seals->place);
    g_free(seals);
}

uint64_t pel_seals_foreign(const struct pel_seals *seals)
{
    return seals->foreign;
}

void pel_seals_count(const struct pel_seals *seals, uint64_t *attempts,
                     uint64_t *failures)
{
    pel_etcd_count(seals->etcd, attempts, failures);
}
