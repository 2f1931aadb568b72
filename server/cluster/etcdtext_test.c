#include "cluster/etcdtext.h"

#include <string.h>

#include "base/near.h"

static struct pel_etcd_text text;

static const struct pel_etcd_answer *read_text(const char *json)
{
    assert_int_equal(pel_etcd_text_read(json, strlen(json), &text), PEL_OK);
    return &text.answer;
}

/* As etcd 3.4.23 writes them. */
static void answers_are_read(void **state)
{
    (void)state;
    const struct pel_etcd_answer *a = read_text(
        "{\"header\":{\"cluster_id\":\"14841639068965178418\",\"member_id\":"
        "\"10276657743932975437\",\"revision\":\"57\",\"raft_term\":\"2\"},"
        "\"responses\":[{\"response_range\":{\"header\":{\"revision\":\"57\"},"
        "\"kvs\":[{\"key\":\"YnJpZGdlL2xvZw==\",\"create_revision\":\"2\","
        "\"mod_revision\":\"56\",\"version\":\"41\",\"value\":\"AAEC\"}],"
        "\"count\":\"1\"}},{\"response_range\":{\"header\":{\"revision\":"
        "\"57\"},\"kvs\":[{\"key\":\"YnJpZGdlL21hc3Rlcg==\",\"mod_revision\":"
        "\"3\",\"version\":\"1\",\"value\":\"Zg==\"}],\"count\":\"1\"}}]}");
    const struct pel_etcd_kv *log = pel_etcd_find(a, "bridge/log");
    assert_false(a->succeeded);
    assert_int_equal(a->revision, 57);
    assert_int_equal(a->kvs->len, 2);
    assert_int_equal(log->version, 41);
    assert_int_equal(log->mod_revision, 56);
    assert_int_equal(log->size, 3);
    assert_memory_equal(log->value, "\0\1\2", 3);
    assert_memory_equal(pel_etcd_find(a, "bridge/master")->value, "f", 1);
    assert_null(pel_etcd_find(a, "bridge/head"));
    pel_etcd_text_finish(&text);

    a = read_text("{\"header\":{\"revision\":\"8\"},\"succeeded\":true,"
                  "\"responses\":[{\"response_put\":{\"header\":{\"revision\":"
                  "\"8\"}}}]}");
    assert_true(a->succeeded);
    assert_int_equal(a->kvs->len, 0);
    pel_etcd_text_finish(&text);

    /* Given twice: the last counts, and the first is not kept. */
    a = read_text("{\"kvs\":[{\"key\":\"YQ==\",\"value\":\"MQ==\",\"key\":"
                  "\"Yg==\",\"value\":\"MjM=\"}]}");
    assert_int_equal(a->kvs->len, 1);
    assert_null(pel_etcd_find(a, "a"));
    assert_int_equal(pel_etcd_find(a, "b")->size, 2);
    assert_memory_equal(pel_etcd_find(a, "b")->value, "23", 2);
    pel_etcd_text_finish(&text);
}

static void a_watch_is_read(void **state)
{
    (void)state;
    const struct pel_etcd_answer *a = read_text(
        "{\"result\":{\"header\":{\"revision\":\"9\"},\"events\":[{\"kv\":{"
        "\"key\":\"YQ==\",\"mod_revision\":\"8\",\"version\":\"1\",\"value\":"
        "\"MQ==\"}},{\"type\":\"DELETE\",\"kv\":{\"key\":\"YQ==\","
        "\"mod_revision\":\"9\"}}]}}");
    assert_int_equal(a->kvs->len, 2);
    assert_int_equal(a->revision, 9);
    const struct pel_etcd_kv *gone = g_ptr_array_index(a->kvs, 1);
    assert_int_equal(gone->version, 0);
    pel_etcd_text_finish(&text);

    (void)read_text("{\"result\":{\"header\":{\"revision\":\"9000\"},"
                    "\"canceled\":true,\"compact_revision\":\"8000\"}}");
    assert_true(text.ended && text.compacted);
    pel_etcd_text_finish(&text);

    (void)read_text("{\"error\":\"etcdserver: request timed out\",\"message\":"
                    "\"etcdserver: request timed out\",\"code\":14}");
    assert_true(text.failed);
    assert_string_equal(text.why, "etcdserver: request timed out");
    pel_etcd_text_finish(&text);

    assert_int_equal(pel_etcd_text_read("<html>", 6, &text), PEL_ERR_MALFORMED);
    pel_etcd_text_finish(&text);
    assert_int_equal(pel_etcd_text_read("", 0, &text), PEL_ERR_MALFORMED);
    pel_etcd_text_finish(&text);
}

static void transactions_are_written(void **state)
{
    (void)state;
    struct pel_etcd_txn txn;
    pel_etcd_txn_init(&txn);
    pel_etcd_if_version(&txn, "b/log", 41);
    pel_etcd_if_value(&txn, "b/master", (const uint8_t *)"me", 2);
    pel_etcd_put(&txn, "b/log", (const uint8_t *)"\0\1", 2);
    pel_etcd_get(&txn, false, "b/nodes/", true);
    g_autofree char *body = pel_etcd_text_txn(&txn);
    assert_string_equal(
        body,
        "{\"compare\":[{\"key\":\"Yi9sb2c=\",\"target\":\"VERSION\","
        "\"version\":\"41\"},{\"key\":\"Yi9tYXN0ZXI=\",\"target\":\"VALUE\","
        "\"value\":\"bWU=\"}],\"success\":[{\"request_put\":{\"key\":"
        "\"Yi9sb2c=\",\"value\":\"AAE=\"}}],\"failure\":[{\"request_range\":{"
        "\"key\":\"Yi9ub2Rlcy8=\",\"range_end\":\"Yi9ub2RlczA=\"}}]}");
    g_string_free(txn.compare, TRUE);
    g_string_free(txn.success, TRUE);
    g_string_free(txn.failure, TRUE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_are_read),
        cmocka_unit_test(a_watch_is_read),
        cmocka_unit_test(transactions_are_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
