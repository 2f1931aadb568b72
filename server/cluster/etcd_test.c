/* The client of etcd against servers that answer without end, in one huge
 * piece, or in nonsense: it takes no more than its bounds, and the loop goes on
 * meanwhile. */
#include "cluster/etcd.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/log.h"

enum answer {
    ANSWER_ENDLESS, /* a text that does not end */
    ANSWER_HUGE,    /* 3 MiB of keys, whole */
    ANSWER_DEEP,    /* lists in lists */
    ANSWER_LINES,   /* of a watch, without end */
    ANSWER_LONG,    /* a line of a watch, 2 MiB, then a short one */
};

struct server {
    int fd;
    enum answer answer;
    GThread *thread;
    char url[64];
};

static bool say(int fd, const char *text, size_t size)
{
    while (size > 0) {
        ssize_t n = send(fd, text, size, MSG_NOSIGNAL);
        if (n <= 0) {
            return false;
        }
        text += n;
        size -= (size_t)n;
    }
    return true;
}

static bool chunk(int fd, const char *text, size_t size)
{
    char head[24];
    int n = snprintf(head, sizeof head, "%zx\r\n", size);
    return say(fd, head, (size_t)n) && say(fd, text, size) &&
           say(fd, "\r\n", 2);
}

static GString *event(unsigned count, unsigned revision)
{
    GString *text = g_string_new(NULL);
    g_string_append_printf(text,
                           "{\"result\":{\"header\":{\"revision\":\"%u\"},"
                           "\"events\":[",
                           revision);
    for (unsigned i = 0; i < count; i++) {
        g_string_append_printf(
            text,
            "%s{\"kv\":{\"key\":\"YQ==\",\"mod_revision\":\"%u\",\"version\":"
            "\"%u\",\"value\":\"MQ==\"}}",
            i > 0 ? "," : "", revision, i + 1);
    }
    g_string_append(text, "]}}\n");
    return text;
}

static void answer_one(const struct server *server, int fd)
{
    static const char head[] = "HTTP/1.1 200 OK\r\nContent-Type: "
                               "application/json\r\nTransfer-Encoding: "
                               "chunked\r\n\r\n";
    char block[16384];
    g_autoptr(GString) text = NULL;
    (void)!recv(fd, block, sizeof block, 0);
    bool open = say(fd, head, sizeof head - 1);
    memset(block, ' ', sizeof block);
    switch (server->answer) {
    case ANSWER_ENDLESS:
        while (open) {
            open = chunk(fd, block, sizeof block);
        }
        return;
    case ANSWER_DEEP:
        memset(block, '[', sizeof block);
        for (int i = 0; i < 200 && open; i++) {
            open = chunk(fd, block, sizeof block);
        }
        break;
    case ANSWER_HUGE:
        text = g_string_new("{\"responses\":[{\"response_range\":{\"kvs\":[");
        while (text->len < 3u << 20) {
            g_string_append(text, "{\"key\":\"YQ==\",\"value\":\"MQ==\"},");
        }
        g_string_append(text, "{}]}}]}");
        open = open && chunk(fd, text->str, text->len);
        break;
    case ANSWER_LINES:
        text = event(1, 5);
        while (open) {
            open = chunk(fd, text->str, text->len);
        }
        return;
    case ANSWER_LONG:
        text = event(30000, 7);
        open = open && chunk(fd, text->str, text->len);
        g_string_free(text, TRUE);
        text = event(1, 8);
        (void)(open && chunk(fd, text->str, text->len));
        (void)!recv(fd, block, sizeof block, 0); /* the watch goes on */
        return;
    }
    if (open) {
        (void)say(fd, "0\r\n\r\n", 5);
    }
}

static gpointer serve_one(gpointer user)
{
    int *call = user;
    struct server server = { .answer = (enum answer)call[1] };
    answer_one(&server, call[0]);
    close(call[0]);
    g_free(call);
    return NULL;
}

static gpointer serve(gpointer user)
{
    struct server *server = user;
    for (int fd; (fd = accept(server->fd, NULL, NULL)) >= 0;) {
        int *call = g_new(int, 2);
        call[0] = fd;
        call[1] = (int)server->answer;
        g_thread_unref(g_thread_new("answer", serve_one, call));
    }
    return NULL;
}

static void begin(struct server *server, enum answer answer)
{
    struct sockaddr_in at = { .sin_family = AF_INET,
                              .sin_addr = { htonl(INADDR_LOOPBACK) } };
    socklen_t size = sizeof at;
    server->answer = answer;
    server->fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(server->fd, (struct sockaddr *)&at, size), 0);
    assert_int_equal(listen(server->fd, 16), 0);
    assert_int_equal(getsockname(server->fd, (struct sockaddr *)&at, &size), 0);
    snprintf(server->url, sizeof server->url, "http://127.0.0.1:%u",
             ntohs(at.sin_port));
    server->thread = g_thread_new("etcd", serve, server);
}

static void end(struct server *server)
{
    shutdown(server->fd, SHUT_RDWR);
    g_thread_join(server->thread);
    close(server->fd);
}

static struct pel_etcd *client_of(const struct server *server)
{
    const struct pel_etcd_options options = { .endpoints = server->url };
    struct pel_etcd *etcd;
    assert_int_equal(pel_etcd_create(&options, &etcd, NULL), PEL_OK);
    return etcd;
}

static double processor_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A turn of the loop; what the longest so far has taken of the processor. */
static double longest_s;
static void turn(void)
{
    double begin_s = processor_s();
    g_main_context_iteration(NULL, TRUE);
    double took_s = processor_s() - begin_s;
    longest_s = took_s > longest_s ? took_s : longest_s;
}

static void never(void *user, const struct pel_etcd_answer *answer)
{
    (void)user;
    (void)answer;
    fail_msg("such an answer is none");
}

static void count_event(void *user, const struct pel_etcd_kv *kv)
{
    unsigned *count = user;
    assert_string_equal(kv->key, "a");
    (*count)++;
}

static void lost(void *user)
{
    (void)user;
}

static void bad_answers_are_bounded(void **state)
{
    (void)state;
    static const enum answer bad[] = { ANSWER_ENDLESS, ANSWER_DEEP,
                                       ANSWER_HUGE };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct server server;
        struct pel_etcd_txn txn;
        uint64_t attempts, failures = 0;
        begin(&server, bad[i]);
        struct pel_etcd *etcd = client_of(&server);
        pel_etcd_txn_init(&txn);
        pel_etcd_get(&txn, true, "a", false);
        pel_etcd_send(etcd, &txn, never, NULL);
        longest_s = 0;
        while (failures < 3) {
            turn();
            pel_etcd_count(etcd, &attempts, &failures);
        }
        print_message("answer %d: a turn took %.2f ms of processor at most\n",
                      (int)bad[i], longest_s * 1e3);
        pel_etcd_destroy(etcd);
        end(&server);
    }
}

/* Others have their turns between. */
static gboolean count_turn(gpointer user)
{
    (*(unsigned *)user)++;
    return G_SOURCE_CONTINUE;
}

static void a_watch_leaves_room(void **state)
{
    (void)state;
    struct server server;
    unsigned events = 0, others = 0;
    begin(&server, ANSWER_LINES);
    struct pel_etcd *etcd = client_of(&server);
    pel_etcd_watch(etcd, "a", 1, count_event, lost, &events);
    guint timer = g_timeout_add(1, count_turn, &others);
    longest_s = 0;
    while (others < 100) {
        turn();
    }
    assert_true(events > 0);
    print_message("lines: %u events, a turn took %.2f ms of processor at "
                  "most\n",
                  events, longest_s * 1e3);
    g_source_remove(timer);
    pel_etcd_destroy(etcd);
    end(&server);
}

/* In order, whoever reads them. */
static void a_long_line_is_told_whole(void **state)
{
    (void)state;
    struct server server;
    unsigned events = 0;
    begin(&server, ANSWER_LONG);
    struct pel_etcd *etcd = client_of(&server);
    pel_etcd_watch(etcd, "a", 7, count_event, lost, &events);
    longest_s = 0;
    while (events < 30001) {
        turn();
    }
    assert_int_equal(events, 30001);
    print_message("a line of 2 MiB: a turn took %.2f ms of processor at "
                  "most\n",
                  longest_s * 1e3);
    pel_etcd_destroy(etcd);
    end(&server);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_answers_are_bounded),
        cmocka_unit_test(a_watch_leaves_room),
        cmocka_unit_test(a_long_line_is_told_whole),
    };
    pel_log_set_level(PEL_LOG_ERROR);
    return cmocka_run_group_tests_name("etcd", tests, NULL, NULL);
}
