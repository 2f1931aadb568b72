/* Answers without an end: Motion JPEG, MPEG-TS, WebSocket. */
#include <stdio.h>
#include <sys/socket.h>

#include "base/clock.h"
#include "net/http_client.h"

#define STREAM_BLOCK 65536
#define STREAM_SOCKET_BUFFER (256 * 1024)

/* --- Motion JPEG and MPEG-TS ---------------------------------------------- */

/* The stream's own memory: it dies with the response, which the library may
 * keep a little longer than the request. */
struct stream {
    struct client *client;
    struct pel_viewer *viewer; /* or: */
    struct pel_ts_viewer *ts;
};

static void wake_stream(void *user)
{
    struct stream *stream = user;
    pel_http_resume(stream->client);
}

static ssize_t read_stream(void *user, uint64_t position, char *out,
                           size_t size)
{
    (void)position;
    struct stream *stream = user;
    if (stream->client->server->closing ||
        stream->client->phase == PHASE_CLOSED) {
        return MHD_CONTENT_READER_END_WITH_ERROR;
    }
    ssize_t n = stream->ts ? pel_ts_viewer_read(stream->ts, out, size)
                           : pel_viewer_read(stream->viewer, out, size);
    if (n == 0) {
        pel_http_suspend(stream->client);
    }
    return n < 0 ? MHD_CONTENT_READER_END_OF_STREAM : n;
}

static void free_stream(void *user)
{
    struct stream *stream = user;
    pel_viewer_destroy(stream->viewer);
    pel_ts_viewer_destroy(stream->ts);
    g_free(stream);
}

enum MHD_Result pel_http_send_stream(struct client *client,
                                     struct pel_http_answer *answer)
{
    struct pel_http_server *server = client->server;
    struct pel_fault fault;
    struct stream *stream = g_new0(struct stream, 1);
    stream->client = client;
    bool ts = answer->kind == PEL_HTTP_TS;
    enum pel_err err =
        ts ? pel_ts_viewer_create(pel_http_frames(client), answer->view,
                                  &answer->profile, &server->ts, wake_stream,
                                  stream, &stream->ts, &fault)
           : pel_viewer_create(pel_http_frames(client), answer->view,
                               answer->quality, answer->fps, &client->who,
                               &server->mjpeg, wake_stream, stream,
                               &stream->viewer, &fault);
    if (err != PEL_OK) {
        g_free(stream);
        return pel_http_send_fault(client, 0, &fault);
    }
    int size = STREAM_SOCKET_BUFFER;
    setsockopt(client->fd, SOL_SOCKET, SO_SNDBUF, &size, sizeof size);
    MHD_set_connection_option(client->connection, MHD_CONNECTION_OPTION_TIMEOUT,
                              (unsigned)(server->limits.http_stall_s + 0.999));
    struct MHD_Response *response = MHD_create_response_from_callback(
        MHD_SIZE_UNKNOWN, STREAM_BLOCK, read_stream, stream, free_stream);
    MHD_set_response_options(response, MHD_RF_HTTP_1_0_COMPATIBLE_STRICT,
                             MHD_RO_END);
    char unix_s[32]; /* for viewers whose clock is another */
    snprintf(unix_s, sizeof unix_s, "%.3f", (double)pel_unix_ns() * 1e-9);
    MHD_add_response_header(response, "X-Pelagos-Unix", unix_s);
    MHD_add_response_header(response, "Content-Type",
                            ts ? PEL_TS_TYPE : PEL_MJPEG_TYPE);
    MHD_add_response_header(response, "Cache-Control", "no-store");
    enum MHD_Result result = pel_http_queue(client, 200, response);
    client->phase = PHASE_STREAM;
    return result;
}

/* --- WebSocket ------------------------------------------------------------ */

static void on_live_closed(void *user)
{
    struct client *client = user;
    pel_http_end_live(client);
}

/* The socket is ours until MHD_UPGRADE_ACTION_CLOSE. */
static void on_upgraded(void *user, struct MHD_Connection *connection,
                        void *state, const char *early, size_t early_size,
                        MHD_socket fd, struct MHD_UpgradeResponseHandle *handle)
{
    (void)connection;
    (void)user;
    struct client *client = state;
    struct pel_http_server *server = client->server;
    struct pel_fault fault;
    client->upgraded = handle;
    struct pel_frames *frames = pel_http_frames(client);
    if (client->phase != PHASE_CLOSED && frames) {
        client->phase = PHASE_STREAM;
        client->live = pel_live_viewer_create(frames, &client->wish, fd, early,
                                              early_size, &server->live,
                                              on_live_closed, client, &fault);
    }
    if (!client->live) {
        pel_http_end_live(client);
    }
}

void pel_http_end_live(struct client *client)
{
    pel_live_viewer_destroy(client->live);
    client->live = NULL;
    if (client->upgraded) {
        struct MHD_UpgradeResponseHandle *handle = client->upgraded;
        client->upgraded = NULL;
        client->phase = PHASE_CLOSED;
        MHD_upgrade_action(handle, MHD_UPGRADE_ACTION_CLOSE);
        pel_http_kick(client->server);
    }
}

enum MHD_Result pel_http_send_live(struct client *client,
                                   const struct pel_http_answer *answer)
{
    client->wish = (struct pel_live_wish){ .profile = answer->profile,
                                           .credit = answer->credit };
    snprintf(client->wish.view, sizeof client->wish.view, "%s", answer->view);
    struct MHD_Response *response =
        MHD_create_response_for_upgrade(on_upgraded, client);
    MHD_add_response_header(response, "Upgrade", "websocket");
    MHD_add_response_header(response, "Sec-WebSocket-Accept", answer->accept);
    if (answer->subprotocol) {
        MHD_add_response_header(response, "Sec-WebSocket-Protocol", "pelagos");
    }
    return pel_http_queue(client, 101, response);
}
