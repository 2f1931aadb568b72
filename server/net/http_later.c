/* Two threads read bodies and write answers for the HTTP server. One of them
 * serves edits alone, so that no large question keeps edits waiting. */
#include <string.h>

#include "base/watch.h"
#include "frames/mailbox.h"
#include "net/http_client.h"

#define QUESTION_NICE 10

/* A body to be read, or an answer to be written. */
struct later {
    struct pel_task task;
    struct waiter *waiter;
    struct pel_http_server *server;
    GString *body; /* NULL: an answer */
    const char *name;
    bool edits;
    struct pel_http_read read;
    struct pel_http_answer answer;
};

static struct pel_worker *worker_of(const struct client *client)
{
    return client->edits ? client->server->edit_worker
                         : client->server->question_worker;
}

static void begin(struct client *client, struct later *later)
{
    later->waiter = pel_http_wait_begin(client);
    pel_http_suspend(client);
    pel_worker_push(worker_of(client), &later->task);
}

/* --- turns ---------------------------------------------------------------- */

/* Requests that came together are taken for so long at once: each takes a tenth
 * of a millisecond or a few, and the library hands over all that it has. */
#define TURN_NS 300000

bool pel_http_take_later(struct client *client)
{
    struct pel_http_server *server = client->server;
    if (client->queued || client->parsed ||
        (pel_watch_spent_ns() < TURN_NS && g_queue_is_empty(&server->takers))) {
        return false;
    }
    client->queued = true;
    g_queue_push_tail(&server->takers, client);
    g_source_set_ready_time(server->taking, 0);
    pel_http_suspend(client);
    return true;
}

static void take_queued(void *user)
{
    struct pel_http_server *server = user;
    struct client *client;
    do {
        client = g_queue_pop_head(&server->takers);
        if (client) {
            (void)pel_http_take(client); /* still marked: it is its turn */
            client->queued = false;
            pel_http_resume(client);
        }
    } while (client && pel_watch_spent_ns() < TURN_NS);
    if (!g_queue_is_empty(&server->takers)) {
        g_source_set_ready_time(server->taking, 0);
    }
}

void pel_http_begin_later(struct pel_http_server *server)
{
    g_queue_init(&server->takers);
    server->taking = pel_alarm_create(NULL, "http", take_queued, server);
    server->edit_worker = pel_worker_create("edits");
    server->question_worker = pel_worker_create("answers");
    pel_worker_set_nice(server->question_worker, QUESTION_NICE);
}

void pel_http_end_later(struct pel_http_server *server)
{
    pel_worker_destroy(server->edit_worker);
    pel_worker_destroy(server->question_worker);
    g_source_destroy(server->taking);
    g_source_unref(server->taking);
    g_queue_clear(&server->takers);
}

/* --- bodies --------------------------------------------------------------- */

static void read_body(struct pel_task *task)
{
    struct later *later = (struct later *)task;
    pel_http_read(later->name, later->body->str, later->body->len,
                  &later->read);
}

static void body_read(struct pel_task *task, bool dropped)
{
    struct later *later = (struct later *)task;
    struct client *client = pel_http_wait_end(later->waiter);
    later->server->reading -= later->edits;
    if (client && !dropped) {
        client->parsed = &later->read;
        pel_http_take(client);
        client->parsed = NULL;
        pel_http_resume(client);
    }
    pel_http_read_finish(&later->read);
    g_string_free(later->body, TRUE);
    g_free(later);
}

bool pel_http_read_later(struct client *client,
                         const struct pel_http_request *request)
{
    struct pel_http_server *server = client->server;
    const char *name = pel_http_about(request, &client->edits);
    if (client->parsed || !client->body || !name) {
        return false;
    }
    /* No edit overtakes one that is being read. */
    bool behind = client->edits && server->reading > 0;
    if (!behind && client->body->len <= PEL_HTTP_AT_ONCE) {
        return false;
    }
    struct later *later = g_new0(struct later, 1);
    later->task.work = read_body;
    later->task.done = body_read;
    later->server = server;
    later->body = client->body;
    later->name = name;
    later->edits = client->edits;
    server->reading += client->edits;
    client->body = NULL;
    begin(client, later);
    return true;
}

/* --- answers -------------------------------------------------------------- */

static void write_answer(struct pel_task *task)
{
    pel_http_write(&((struct later *)task)->answer);
}

static void answer_written(struct pel_task *task, bool dropped)
{
    struct later *later = (struct later *)task;
    struct client *client = pel_http_wait_end(later->waiter);
    if (client && !dropped) {
        pel_http_send(client, &later->answer);
        pel_http_resume(client);
    }
    pel_http_answer_finish(&later->answer);
    g_free(later);
}

static void forget(struct pel_task *task)
{
    pel_http_answer_finish(&((struct later *)task)->answer);
}

static void forgotten(struct pel_task *task, bool dropped)
{
    if (dropped) {
        forget(task);
    }
    g_free(task);
}

void pel_http_forget_later(struct client *client,
                           struct pel_http_answer *answer)
{
    if (!client->parsed) { /* it is short */
        pel_http_answer_finish(answer);
        return;
    }
    struct later *later = g_new0(struct later, 1);
    later->task.work = forget;
    later->task.done = forgotten;
    later->answer = *answer;
    *answer = (struct pel_http_answer){ .kind = PEL_HTTP_WHOLE };
    pel_worker_push(worker_of(client), &later->task);
}

bool pel_http_write_later(struct client *client, struct pel_http_answer *answer)
{
    if (!pel_http_is_long(answer)) {
        pel_http_write(answer);
        return false;
    }
    struct later *later = g_new0(struct later, 1);
    later->task.work = write_answer;
    later->task.done = answer_written;
    later->answer = *answer;
    *answer = (struct pel_http_answer){ .kind = PEL_HTTP_WHOLE };
    begin(client, later);
    return true;
}
