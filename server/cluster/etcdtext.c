#include "cluster/etcdtext.h"

#include <stdlib.h>
#include <string.h>

#include "jsonwalk.h"

static void kv_free(gpointer data)
{
    struct pel_etcd_kv *kv = data;
    g_free(kv->key);
    g_free(kv->value);
    g_free(kv);
}

/* The pair that a path such as `responses.0.response_range.kvs.1.value` is
 * about; NULL: none. */
static struct pel_etcd_kv *pair_of(struct pel_etcd_text *text, const char *path,
                                   const char *leaf)
{
    size_t length = (size_t)(leaf - path);
    bool is_pair = strstr(path, "kvs.") || strstr(path, ".kv.");
    if (!is_pair || length >= sizeof text->prefix) {
        return NULL;
    }
    if (strlen(text->prefix) != length ||
        memcmp(text->prefix, path, length) != 0) {
        memcpy(text->prefix, path, length);
        text->prefix[length] = '\0';
        g_ptr_array_add(text->answer.kvs, g_new0(struct pel_etcd_kv, 1));
    }
    return g_ptr_array_index(text->answer.kvs, text->answer.kvs->len - 1);
}

static void read_pair(struct pel_etcd_kv *kv, const char *name,
                      const char *value)
{
    gsize size = 0;
    if (strcmp(name, "key") == 0) {
        guchar *key = g_base64_decode(value, &size);
        g_free(kv->key); /* given twice: the last counts */
        kv->key = g_strndup((const char *)key, size);
        g_free(key);
    } else if (strcmp(name, "value") == 0) {
        g_free(kv->value);
        kv->value = g_base64_decode(value, &size);
        kv->size = size;
    } else if (strcmp(name, "version") == 0) {
        kv->version = strtoull(value, NULL, 10);
    } else if (strcmp(name, "mod_revision") == 0) {
        kv->mod_revision = strtoull(value, NULL, 10);
    }
}

static void each(void *user, const char *path, const char *value)
{
    struct pel_etcd_text *text = user;
    const char *dot = strrchr(path, '.');
    const char *leaf = dot ? dot + 1 : path;
    struct pel_etcd_kv *kv = pair_of(text, path, leaf);
    if (kv) {
        read_pair(kv, leaf, value);
    } else if (strcmp(path, "succeeded") == 0) {
        text->answer.succeeded = strcmp(value, "true") == 0;
    } else if (strcmp(path, "header.revision") == 0 ||
               strcmp(path, "result.header.revision") == 0) {
        text->answer.revision = strtoull(value, NULL, 10);
    } else if (strcmp(path, "result.canceled") == 0) {
        text->ended = strcmp(value, "true") == 0;
    } else if (strcmp(leaf, "compact_revision") == 0) {
        text->compacted = strcmp(value, "0") != 0;
    } else if (strcmp(path, "error") == 0 ||
               strcmp(path, "error.message") == 0) {
        text->failed = true;
        g_strlcpy(text->why, value, sizeof text->why);
    }
}

enum pel_err pel_etcd_text_read(const char *data, size_t size,
                                struct pel_etcd_text *out)
{
    *out = (struct pel_etcd_text){ 0 };
    out->answer.kvs = g_ptr_array_new_with_free_func(kv_free);
    return pel_json_walk(data, size, each, out, NULL);
}

void pel_etcd_text_finish(struct pel_etcd_text *text)
{
    g_ptr_array_free(text->answer.kvs, TRUE);
}

const struct pel_etcd_kv *pel_etcd_find(const struct pel_etcd_answer *answer,
                                        const char *key)
{
    for (guint i = 0; i < answer->kvs->len; i++) {
        const struct pel_etcd_kv *kv = g_ptr_array_index(answer->kvs, i);
        if (kv->key && strcmp(kv->key, key) == 0) {
            return kv;
        }
    }
    return NULL;
}

/* --- writing -------------------------------------------------------------- */

static void add_bytes(GString *to, const char *name, const void *data,
                      size_t size)
{
    g_autofree char *text = g_base64_encode(data, size);
    g_string_append_printf(to, "\"%s\":\"", name);
    g_string_append(to, text);
    g_string_append_c(to, '"');
}

/* The first key after all that begin with `prefix`, which ends in a letter or a
 * slash. */
static void add_range(GString *to, const char *prefix)
{
    g_autofree char *end = g_strdup(prefix);
    end[strlen(end) - 1]++;
    add_bytes(to, "key", prefix, strlen(prefix));
    g_string_append_c(to, ',');
    add_bytes(to, "range_end", end, strlen(end));
}

static GString *next(GString *list)
{
    if (list->len > 0) {
        g_string_append_c(list, ',');
    }
    return list;
}

void pel_etcd_txn_init(struct pel_etcd_txn *txn)
{
    txn->compare = g_string_new(NULL);
    txn->success = g_string_new(NULL);
    txn->failure = g_string_new(NULL);
}

void pel_etcd_if_version(struct pel_etcd_txn *txn, const char *key,
                         uint64_t version)
{
    GString *to = next(txn->compare);
    g_string_append_c(to, '{');
    add_bytes(to, "key", key, strlen(key));
    g_string_append_printf(to, ",\"target\":\"VERSION\",\"version\":\"%llu\"}",
                           (unsigned long long)version);
}

void pel_etcd_if_value(struct pel_etcd_txn *txn, const char *key,
                       const uint8_t *value, size_t size)
{
    GString *to = next(txn->compare);
    g_string_append_c(to, '{');
    add_bytes(to, "key", key, strlen(key));
    g_string_append(to, ",\"target\":\"VALUE\",");
    add_bytes(to, "value", value, size);
    g_string_append_c(to, '}');
}

void pel_etcd_put(struct pel_etcd_txn *txn, const char *key,
                  const uint8_t *value, size_t size)
{
    GString *to = next(txn->success);
    g_string_append(to, "{\"request_put\":{");
    add_bytes(to, "key", key, strlen(key));
    g_string_append_c(to, ',');
    add_bytes(to, "value", value, size);
    g_string_append(to, "}}");
}

void pel_etcd_get(struct pel_etcd_txn *txn, bool then, const char *key,
                  bool prefix)
{
    GString *to = next(then ? txn->success : txn->failure);
    g_string_append(to, "{\"request_range\":{");
    if (prefix) {
        add_range(to, key);
    } else {
        add_bytes(to, "key", key, strlen(key));
    }
    g_string_append(to, "}}");
}

char *pel_etcd_text_txn(const struct pel_etcd_txn *txn)
{
    return g_strdup_printf("{\"compare\":[%s],\"success\":[%s],\"failure\":[%s]"
                           "}",
                           txn->compare->str, txn->success->str,
                           txn->failure->str);
}

char *pel_etcd_text_watch(const char *prefix, uint64_t from_revision)
{
    GString *to = g_string_new("{\"create_request\":{");
    add_range(to, prefix);
    g_string_append_printf(to, ",\"start_revision\":\"%llu\"}}",
                           (unsigned long long)from_revision);
    return g_string_free(to, FALSE);
}
