/* A client of etcd 3.4 and later: transactions and one watch, by its JSON
 * gateway. Nothing waits: answers come on the control thread, in the default
 * GLib main context.
 *
 * A request that stays unanswered is sent again, to the next endpoint, and
 * several may be under way at once. So what is asked must be safe to do twice:
 * transactions that compare before they put. */
#pragma once

#include <glib.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"

struct pel_etcd;

struct pel_etcd_options {
    const char *endpoints;       /* `https://a:2379,https://b:2379` */
    const char *cert, *key, *ca; /* PEM files; NULL: none */
};

struct pel_etcd_kv {
    char *key;
    uint8_t *value;
    size_t size;
    uint64_t version;      /* how often it was put, from 1 on */
    uint64_t mod_revision; /* of the store, when it was put */
};

struct pel_etcd_answer {
    bool succeeded;    /* what it compared was so */
    uint64_t revision; /* of the store */
    GPtrArray *kvs;    /* of struct pel_etcd_kv: what was got */
};

/* The first of that key; NULL: there is none. */
const struct pel_etcd_kv *pel_etcd_find(const struct pel_etcd_answer *answer,
                                        const char *key);

/* INVALID: the endpoints. */
PEL_CHECK enum pel_err pel_etcd_create(const struct pel_etcd_options *options,
                                       struct pel_etcd **out,
                                       struct pel_fault *fault);
void pel_etcd_destroy(struct pel_etcd *etcd); /* NULL allowed; nobody is told */

/* --- transactions --------------------------------------------------------- */

struct pel_etcd_txn {
    GString *compare, *success, *failure;
};
void pel_etcd_txn_init(struct pel_etcd_txn *txn);
void pel_etcd_if_version(struct pel_etcd_txn *txn, const char *key,
                         uint64_t version); /* 0: it is not there */
void pel_etcd_if_value(struct pel_etcd_txn *txn, const char *key,
                       const uint8_t *value, size_t size);
void pel_etcd_put(struct pel_etcd_txn *txn, const char *key,
                  const uint8_t *value, size_t size);
/* Gets a key, or all that begin with it; `then`: where what is compared is so,
 * else where it is not. */
void pel_etcd_get(struct pel_etcd_txn *txn, bool then, const char *key,
                  bool prefix);

/* Sends it, and takes it over. `done` (NULL allowed) is called once it was
 * answered, however long that takes, unless it is dropped before. */
typedef void (*pel_etcd_done)(void *user, const struct pel_etcd_answer *answer);
struct pel_etcd_request;
struct pel_etcd_request *pel_etcd_send(struct pel_etcd *etcd,
                                       struct pel_etcd_txn *txn,
                                       pel_etcd_done done, void *user);
/* Nobody waits for it any more; it may have been done. Not after `done`. */
void pel_etcd_drop(struct pel_etcd_request *request);

/* --- the watch ------------------------------------------------------------ */

/* Every put to a key that begins with `prefix`, in order, from this revision of
 * the store on. `lost`: the store does not keep that revision any more, and the
 * watch is over. Connections that end are made anew. Instead of the one before.
 */
typedef void (*pel_etcd_event)(void *user, const struct pel_etcd_kv *kv);
void pel_etcd_watch(struct pel_etcd *etcd, const char *prefix,
                    uint64_t from_revision, pel_etcd_event event,
                    void (*lost)(void *user), void *user);

/* Goes on watching by another endpoint: this one is silent. */
void pel_etcd_watch_elsewhere(struct pel_etcd *etcd);

/* Attempts of requests, and those that failed. */
void pel_etcd_count(const struct pel_etcd *etcd, uint64_t *attempts,
                    uint64_t *failures);
