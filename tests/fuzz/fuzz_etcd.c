/* What a store of sealed frames answers and tells (server/cluster): JSON of
 * etcd's gateway, what is packed in it, what is made of that. The store itself
 * is this file's own: pel_etcd_send and pel_etcd_watch give the input. Lines;
 * the first byte of each says what it is: A answers what was asked, W is of the
 * watch, L drops what the watch has; K, M, N, H, P: a pair of the log, the
 * master, a node, the head, the places, whose value follows in hex. */
#include <glib.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "cluster/etcdtext.h"
#include "cluster/seals.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

struct pel_etcd {
    pel_etcd_done done;
    void *done_user;
    pel_etcd_event event;
    void (*lost)(void *user);
    void *user;
};
static struct pel_etcd store;
static unsigned told;

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

enum pel_err pel_etcd_create(const struct pel_etcd_options *options,
                             struct pel_etcd **out, struct pel_fault *fault)
{
    (void)options;
    (void)fault;
    memset(&store, 0, sizeof store);
    *out = &store;
    return PEL_OK;
}

void pel_etcd_destroy(struct pel_etcd *etcd)
{
    (void)etcd;
}

static void finish_txn(struct pel_etcd_txn *txn)
{
    char *text = pel_etcd_text_txn(txn);
    struct pel_etcd_text read;
    demand(!pel_etcd_text_read(text, strlen(text), &read)); /* it is JSON */
    pel_etcd_text_finish(&read);
    g_free(text);
    g_string_free(txn->compare, TRUE);
    g_string_free(txn->success, TRUE);
    g_string_free(txn->failure, TRUE);
}

struct pel_etcd_request *pel_etcd_send(struct pel_etcd *etcd,
                                       struct pel_etcd_txn *txn,
                                       pel_etcd_done done, void *user)
{
    finish_txn(txn);
    etcd->done = done;
    etcd->done_user = user;
    return (struct pel_etcd_request *)etcd;
}

void pel_etcd_drop(struct pel_etcd_request *request)
{
    ((struct pel_etcd *)request)->done = NULL;
}

void pel_etcd_watch(struct pel_etcd *etcd, const char *prefix,
                    uint64_t from_revision, pel_etcd_event event,
                    void (*lost)(void *user), void *user)
{
    g_free(pel_etcd_text_watch(prefix, from_revision));
    etcd->event = event;
    etcd->lost = lost;
    etcd->user = user;
}

void pel_etcd_watch_elsewhere(struct pel_etcd *etcd)
{
    (void)etcd;
}

void pel_etcd_count(const struct pel_etcd *etcd, uint64_t *attempts,
                    uint64_t *failures)
{
    (void)etcd;
    *attempts = *failures = 0;
}

/* --- who is told ---------------------------------------------------------- */

static void look_at(const ProtobufCMessage *message)
{
    size_t size = protobuf_c_message_get_packed_size(message);
    uint8_t *bytes = g_malloc(size + 1);
    demand(protobuf_c_message_pack(message, bytes) == size);
    g_free(bytes);
    told++;
}

static void on_frame(void *user, uint64_t number,
                     const Pelagos__SealedFrame *frame, uint64_t revision)
{
    (void)user;
    (void)revision;
    demand(number > 0);
    look_at(&frame->base);
}

static void on_master(void *user, const Pelagos__ClusterMaster *master)
{
    (void)user;
    demand(master->name && master->address);
    look_at(&master->base);
}

static void on_node(void *user, const Pelagos__ClusterNode *node)
{
    (void)user;
    look_at(&node->base);
}

static void on_places(void *user, const struct pel_seals_places *what)
{
    (void)user;
    if (what->places) {
        look_at(&what->places->base);
    }
}

static void on_placed(void *user, bool yes, const struct pel_seals_places *now)
{
    (void)yes;
    on_places(user, now);
}

static void on_lost(void *user)
{
    (void)user;
}

static void on_done(void *user, bool yes, uint64_t revision,
                    const struct pel_seals_view *view)
{
    (void)user;
    (void)yes;
    (void)revision;
    demand(!view->master || view->master->name);
    if (view->head) {
        look_at(&view->head->base);
    }
    if (view->last) {
        look_at(&view->last->base);
    }
}

/* --- what comes ----------------------------------------------------------- */

static void ask(struct pel_seals *seals, unsigned what)
{
    Pelagos__ClusterMaster master = PELAGOS__CLUSTER_MASTER__INIT;
    Pelagos__ClusterHead head = PELAGOS__CLUSTER_HEAD__INIT;
    Pelagos__SealedFrame frame = PELAGOS__SEALED_FRAME__INIT;
    Pelagos__ClusterNode node = PELAGOS__CLUSTER_NODE__INIT;
    Pelagos__ClusterPlaces places = PELAGOS__CLUSTER_PLACES__INIT;
    master.name = node.name = (char[]){ "one" };
    master.address = (char[]){ "10.0.0.1:1" };
    switch (what % 8) {
    case 0:
        pel_seals_look(seals, on_done, NULL);
        break;
    case 1:
        pel_seals_found(seals, &master, &head, on_done, NULL);
        break;
    case 2:
        pel_seals_put(seals, &master, 1, &frame, on_done, NULL);
        break;
    case 3:
        pel_seals_take(seals, &master, 1, &master, on_done, NULL);
        break;
    case 4:
        pel_seals_head(seals, &master, &head);
        break;
    case 5:
        pel_seals_node(seals, &node, what % 16 < 8);
        break;
    case 6:
        pel_seals_places(seals, what % 16 < 8 ? &master : NULL, 1, &places,
                         on_placed, NULL);
        break;
    default:
        pel_seals_ignore(seals);
        break;
    }
}

/* Those that have a key, as pel_etcd has them. */
static void take_text(const char *text, size_t size, bool answers)
{
    struct pel_etcd_text read;
    if (!pel_etcd_text_read(text, size, &read)) {
        demand(memchr(read.why, 0, sizeof read.why) != NULL);
        pel_etcd_done done = store.done;
        store.done = NULL;
        if (answers && done) {
            done(store.done_user, &read.answer);
        }
        for (guint i = 0; !answers && i < read.answer.kvs->len; i++) {
            const struct pel_etcd_kv *kv =
                g_ptr_array_index(read.answer.kvs, i);
            if (kv->key) {
                store.event(store.user, kv);
            }
        }
    }
    pel_etcd_text_finish(&read);
}

static void take_pair(const char *key, const char *hex, size_t size,
                      bool answers)
{
    GByteArray *value = g_byte_array_new();
    for (size_t i = 0; i + 1 < size; i += 2) {
        unsigned high = (unsigned)g_ascii_xdigit_value(hex[i]);
        unsigned low = (unsigned)g_ascii_xdigit_value(hex[i + 1]);
        guint8 byte = (guint8)((high & 15) << 4 | (low & 15));
        g_byte_array_append(value, &byte, 1);
    }
    char *k = g_base64_encode((const guchar *)key, strlen(key));
    char *v = g_base64_encode(value->data, value->len);
    char *text = g_strdup_printf(
        answers ? "{\"header\":{\"revision\":\"7\"},\"responses\":[{\"response_"
                  "range\":{\"kvs\":[{\"key\":\"%s\",\"mod_revision\":\"5\","
                  "\"version\":\"1\",\"value\":\"%s\"}]}}]}"
                : "{\"result\":{\"events\":[{\"kv\":{\"key\":\"%s\","
                  "\"mod_revision\":\"5\",\"version\":\"1\",\"value\":\"%s\"}}]"
                  "}}",
        k, v);
    take_text(text, strlen(text), answers);
    g_free(text);
    g_free(v);
    g_free(k);
    g_byte_array_unref(value);
}

static void take(struct pel_seals *seals, const char *line, size_t size)
{
    static const char *const keys[] = { "bridge/log", "bridge/master",
                                        "bridge/nodes/two", "bridge/head",
                                        "bridge/place" };
    static const char letters[] = "KMNHP";
    const char *pair = strchr(letters, *line);
    if (*line == 'A' || *line == 'W') {
        take_text(line + 1, size - 1, *line == 'A');
    } else if (*line == 'L') {
        store.lost(store.user);
    } else if (pair && *pair) {
        take_pair(keys[pair - letters], line + 1, size - 1, size % 2 == 0);
    } else {
        ask(seals, (unsigned char)*line);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct pel_seals_options options = {
        .url = "http://127.0.0.1:2379/bridge",
        .events = { on_frame, on_master, on_node, on_places, on_lost, NULL },
    };
    struct pel_seals *seals;
    char *text = g_strndup((const char *)data, size);
    demand(!pel_seals_create(&options, &seals, NULL));
    pel_seals_follow(seals, 3);
    char **lines = g_strsplit(text, "\n", 64);
    for (char **line = lines; *line; line++) {
        if (**line) {
            take(seals, *line, strlen(*line));
        }
    }
    pel_seals_destroy(seals);
    g_strfreev(lines);
    g_free(text);
    return 0;
}
