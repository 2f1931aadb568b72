#include "pelagos.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "stream.h"
#include "token.h"

#define PEL_CLIENT_NOTICE 256

struct pel_client {
    struct stream stream;
    char *address;
    int timeout_ms;
    uint64_t last_id;
    char notice[PEL_CLIENT_NOTICE];
    uint64_t watch_id;       /* 0: not watching */
    Pelagos__State *watched; /* newest that nobody has taken yet, or NULL */
};

static void copy_text(char *out, size_t size, const char *text)
{
    snprintf(out, size, "%s", text ? text : "");
}

/* The daemon's refusal, in the caller's hands. */
static enum pel_client_code refuse(const Pelagos__Error *from,
                                   struct pel_client_error *error)
{
    enum pel_client_code code = PEL_CLIENT_INTERNAL;
    if (from->has_code && (int)from->code >= PEL_CLIENT_MALFORMED &&
        (int)from->code <= PEL_CLIENT_FORBIDDEN) {
        code = (enum pel_client_code)from->code;
    }
    if (error) {
        *error = (struct pel_client_error){ .code = code, .minimum = 1 };
        copy_text(error->path, sizeof error->path, from->path);
        copy_text(error->value, sizeof error->value, from->value);
        copy_text(error->unit, sizeof error->unit, from->unit);
        copy_text(error->message, sizeof error->message, from->message);
        if (from->has_minimum && from->has_maximum) {
            error->minimum = from->minimum;
            error->maximum = from->maximum;
        }
    }
    return code;
}

static enum pel_client_code stream_fail(struct pel_client *client,
                                        enum stream_result result,
                                        struct pel_client_error *error)
{
    switch (result) {
    case STREAM_TIMEOUT:
        return client_fail(error, PEL_CLIENT_TIMEOUT,
                           "pelagosd at %s did not answer within %d ms",
                           client->address, client->timeout_ms);
    case STREAM_MALFORMED:
        return client_fail(
            error, PEL_CLIENT_PROTOCOL,
            "what answers at %s does not speak Pelagos' protocol: it is "
            "another program's port, or pelagosd's HTTP; --tcp of pelagosd is "
            "the one (7878)",
            client->address);
    case STREAM_CLOSED:
    case STREAM_OK:
        break;
    }
    return client_fail(error, PEL_CLIENT_CLOSED,
                       "pelagosd at %s closed the connection", client->address);
}

static enum pel_client_code login_by_environment(struct pel_client *client,
                                                 struct pel_client_error *error)
{
    char token[CLIENT_TOKEN_MAX + 1], why[256];
    enum pel_client_code code = PEL_CLIENT_OK;
    if (client_token(token, why, sizeof why) != 0) {
        return client_fail(error, PEL_CLIENT_UNAUTHORIZED, "%s", why);
    }
    if (token[0]) {
        code = pel_client_login(client, token, error);
    }
    explicit_bzero(token, sizeof token);
    return code;
}

/* The forms of an address, with the one that was probably meant: protobuf has
 * another port than HTTP. */
static enum pel_client_code bad_address(struct pel_client_error *error,
                                        const char *address)
{
    static const char wanted[] =
        "is not tcp:HOST:PORT, tls:HOST:PORT or unix:PATH";
    const char *host = strstr(address, "://");
    if (host) {
        bool secure = host - address == 5; /* https */
        host += 3;
        size_t length = strcspn(host, *host == '[' ? "]/" : ":/");
        length += host[length] == ']';
        return client_fail(
            error, PEL_CLIENT_BAD_ADDRESS,
            "\"%.60s\" %s; protobuf has a port of its own beside HTTP's "
            "(pelagosd --tcp); did you mean %s:%.*s:7878?",
            address, wanted, secure ? "tls" : "tcp",
            (int)(length < 60 ? length : 60), host);
    }
    const char *scheme = address[0] == '/' ? "unix:"
                         : strncmp(address, "tcp:", 4) == 0 ||
                                 strncmp(address, "tls:", 4) == 0 ||
                                 strncmp(address, "unix:", 5) == 0 ||
                                 !strchr(address, ':')
                             ? NULL
                             : "tcp:";
    return client_fail(error, PEL_CLIENT_BAD_ADDRESS, "\"%.60s\" %s%s%s%.60s",
                       address, wanted, scheme ? "; did you mean " : "",
                       scheme ? scheme : "", scheme ? address : "");
}

enum pel_client_code pel_client_connect(const char *address, int timeout_ms,
                                        struct pel_client **out,
                                        struct pel_client_error *error)
{
    if (!address) {
        address = getenv(PEL_CLIENT_SERVER_VARIABLE);
    }
    if (!address || !*address) {
        address = PEL_CLIENT_DEFAULT_SERVER;
    }
    struct stream stream;
    char why[256];
    switch (stream_open(&stream, address, timeout_ms, why, sizeof why)) {
    case STREAM_OPENED:
        break;
    case STREAM_BAD_ADDRESS:
        return bad_address(error, address);
    case STREAM_UNREACHABLE:
        return client_fail(error, PEL_CLIENT_UNREACHABLE,
                           "pelagosd does not answer at %s: %s", address, why);
    }
    struct pel_client *client = calloc(1, sizeof *client);
    char *copy = strdup(address);
    if (!client || !copy) {
        free(client);
        free(copy);
        stream_close(&stream);
        return client_fail(error, PEL_CLIENT_INTERNAL, "out of memory");
    }
    client->stream = stream;
    client->address = copy;
    client->timeout_ms = timeout_ms;
    enum pel_client_code code = login_by_environment(client, error);
    if (code != PEL_CLIENT_OK) {
        pel_client_close(client);
        return code;
    }
    *out = client;
    return PEL_CLIENT_OK;
}

static void drop_watched(struct pel_client *client)
{
    if (client->watched) {
        pelagos__state__free_unpacked(client->watched, NULL);
        client->watched = NULL;
    }
}

void pel_client_close(struct pel_client *client)
{
    if (client) {
        drop_watched(client);
        stream_close(&client->stream);
        free(client->address);
        free(client);
    }
}

const char *pel_client_address(const struct pel_client *client)
{
    return client->address;
}

void pel_client_set_timeout(struct pel_client *client, int timeout_ms)
{
    client->timeout_ms = timeout_ms;
}

int pel_client_fd(const struct pel_client *client)
{
    return client->stream.fd;
}

/* Takes the state out of a reply before that is freed. */
static Pelagos__State *take_state(Pelagos__Reply *reply)
{
    Pelagos__State *state = reply->state;
    reply->state = NULL;
    reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
    return state;
}

/* One reply, whoever it is for. */
static enum stream_result read_reply(struct pel_client *client,
                                     int64_t deadline_ns, Pelagos__Reply **out)
{
    const uint8_t *data = NULL;
    size_t size = 0;
    enum stream_result result =
        stream_read(&client->stream, deadline_ns, &data, &size);
    if (result != STREAM_OK) {
        return result;
    }
    Pelagos__Reply *reply = pelagos__reply__unpack(NULL, size, data);
    stream_consume(&client->stream);
    if (!reply) {
        return STREAM_MALFORMED;
    }
    *out = reply;
    return STREAM_OK;
}

/* Keeps a state that was sent because of pel_client_watch. */
static bool keep_if_watched(struct pel_client *client, Pelagos__Reply *reply)
{
    if (client->watch_id == 0 || reply->id != client->watch_id ||
        reply->result_case != PELAGOS__REPLY__RESULT_STATE) {
        return false;
    }
    drop_watched(client);
    client->watched = take_state(reply);
    return true;
}

/* Sends `request` under a new id and waits for the reply of kind `wanted`. */
static enum pel_client_code call(struct pel_client *client,
                                 Pelagos__Request *request,
                                 Pelagos__Reply__ResultCase wanted,
                                 Pelagos__Reply **out,
                                 struct pel_client_error *error)
{
    int64_t deadline_ns = stream_deadline(client->timeout_ms);
    request->has_id = 1;
    request->id = ++client->last_id;
    enum stream_result result =
        stream_write(&client->stream, &request->base, deadline_ns);
    if (result != STREAM_OK) {
        return stream_fail(client, result, error);
    }
    for (;;) {
        Pelagos__Reply *reply = NULL;
        result = read_reply(client, deadline_ns, &reply);
        if (result != STREAM_OK) {
            return stream_fail(client, result, error);
        }
        enum pel_client_code code = PEL_CLIENT_OK;
        /* A request too broken to have an id is refused without one. */
        bool mine = reply->id == request->id || !reply->has_id;
        if (mine && reply->result_case == PELAGOS__REPLY__RESULT_ERROR) {
            code = refuse(reply->error, error);
        } else if (mine && reply->result_case == wanted) {
            *out = reply;
            return PEL_CLIENT_OK;
        } else if (mine) {
            code = stream_fail(client, STREAM_MALFORMED, error);
        } else {
            keep_if_watched(client, reply);
        }
        pelagos__reply__free_unpacked(reply, NULL);
        if (code != PEL_CLIENT_OK) {
            return code;
        }
    }
}

/* A call that is answered with a state; out NULL: not wanted. */
static enum pel_client_code call_for_state(struct pel_client *client,
                                           Pelagos__Request *request,
                                           Pelagos__State **out,
                                           struct pel_client_error *error)
{
    Pelagos__Reply *reply = NULL;
    client->notice[0] = '\0';
    enum pel_client_code code =
        call(client, request, PELAGOS__REPLY__RESULT_STATE, &reply, error);
    if (code == PEL_CLIENT_OK) {
        copy_text(client->notice, sizeof client->notice, reply->notice);
        if (out) {
            *out = take_state(reply);
        }
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_login(struct pel_client *client,
                                      const char *token,
                                      struct pel_client_error *error)
{
    Pelagos__Login login = PELAGOS__LOGIN__INIT;
    login.token = (char *)token;
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_LOGIN;
    request.login = &login;
    return call_for_state(client, &request, NULL, error);
}

enum pel_client_code pel_client_get(struct pel_client *client,
                                    Pelagos__State **out,
                                    struct pel_client_error *error)
{
    Pelagos__Get get = PELAGOS__GET__INIT;
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_GET;
    request.get = &get;
    return call_for_state(client, &request, out, error);
}

enum pel_client_code pel_client_patch(struct pel_client *client,
                                      const Pelagos__Patch *patch,
                                      Pelagos__State **out,
                                      struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_PATCH;
    request.patch = (Pelagos__Patch *)patch;
    return call_for_state(client, &request, out, error);
}

const char *pel_client_notice(const struct pel_client *client)
{
    return client->notice;
}

enum pel_client_code pel_client_frame(struct pel_client *client,
                                      const Pelagos__FrameRequest *wanted,
                                      Pelagos__Frame **out,
                                      struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_FRAME;
    request.frame = (Pelagos__FrameRequest *)wanted;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_FRAME, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->frame;
        reply->frame = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_frames(struct pel_client *client,
                                       const Pelagos__FramesRequest *wanted,
                                       Pelagos__Frames **out,
                                       struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_FRAMES;
    request.frames = (Pelagos__FramesRequest *)wanted;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_FRAMES, &reply, error);
    if (code != PEL_CLIENT_OK) {
        return code;
    }
    if (reply->frames->n_frames != wanted->n_frames) {
        code = stream_fail(client, STREAM_MALFORMED, error);
    } else {
        *out = reply->frames;
        reply->frames = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
    }
    pelagos__reply__free_unpacked(reply, NULL);
    return code;
}

#define MAX_POINTS 10000
/* Points of one request: 20 bytes each, and requests end at 64 KiB. */
#define POINTS_AT_ONCE 3000

static enum pel_client_code send_points(struct pel_client *client,
                                        Pelagos__SurfaceQuery *query,
                                        Pelagos__Surface **out,
                                        struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_SURFACE;
    request.surface = query;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_SURFACE, &reply, error);
    if (code != PEL_CLIENT_OK) {
        return code;
    }
    if (reply->surface->n_points != query->n_points) {
        code = stream_fail(client, STREAM_MALFORMED, error);
    } else {
        *out = reply->surface;
        reply->surface = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
    }
    pelagos__reply__free_unpacked(reply, NULL);
    return code;
}

/* Moves the points of `more` (freed) to the end of `all`; false: no memory. */
static bool join_points(Pelagos__Surface *all, Pelagos__Surface *more)
{
    size_t count = all->n_points + more->n_points;
    void *grown = realloc(all->points, count * sizeof *all->points);
    if (grown) {
        all->points = grown;
        memcpy(all->points + all->n_points, more->points,
               more->n_points * sizeof *all->points);
        all->n_points = count;
        more->n_points = 0;
    }
    pelagos__surface__free_unpacked(more, NULL);
    return grown != NULL;
}

/* `list` in as many requests as it takes, all at the time of the first. */
static enum pel_client_code ask_points(struct pel_client *client,
                                       Pelagos__Point **list, size_t count,
                                       const struct pel_client_sea *sea,
                                       Pelagos__Surface **out,
                                       struct pel_client_error *error)
{
    Pelagos__Surface *all = NULL;
    for (size_t done = 0; done < count;) {
        size_t left = count - done;
        Pelagos__SurfaceQuery query = PELAGOS__SURFACE_QUERY__INIT;
        query.n_points = left < POINTS_AT_ONCE ? left : POINTS_AT_ONCE;
        query.points = list + done;
        query.has_time = sea->time_s != NULL || all != NULL;
        query.time = all ? all->time : sea->time_s ? *sea->time_s : 0.0;
        query.has_frame = sea->frame != 0;
        query.frame = sea->frame;
        query.has_acceleration = query.acceleration = sea->acceleration;
        query.has_foam = query.foam = sea->foam;
        Pelagos__Surface *part = NULL;
        enum pel_client_code code = send_points(client, &query, &part, error);
        if (code == PEL_CLIENT_OK && !all) {
            all = part;
        } else if (code == PEL_CLIENT_OK && !join_points(all, part)) {
            code = client_fail(error, PEL_CLIENT_INTERNAL, "out of memory");
        }
        if (code != PEL_CLIENT_OK) {
            if (all) {
                pelagos__surface__free_unpacked(all, NULL);
            }
            return code;
        }
        done += query.n_points;
    }
    *out = all;
    return PEL_CLIENT_OK;
}

enum pel_client_code
pel_client_surface(struct pel_client *client, const double (*east_north_m)[2],
                   size_t count, const struct pel_client_sea *sea,
                   Pelagos__Surface **out, struct pel_client_error *error)
{
    static const struct pel_client_sea present = { 0 };
    if (count < 1 || count > MAX_POINTS) {
        return client_fail(error, PEL_CLIENT_OUT_OF_RANGE,
                           "%zu points; a query has 1 to %d", count,
                           MAX_POINTS);
    }
    Pelagos__Point *points = calloc(count, sizeof *points);
    Pelagos__Point **list = calloc(count, sizeof *list);
    enum pel_client_code code = PEL_CLIENT_INTERNAL;
    if (points && list) {
        for (size_t i = 0; i < count; i++) {
            pelagos__point__init(&points[i]);
            points[i].has_east = points[i].has_north = 1;
            points[i].east = east_north_m[i][0];
            points[i].north = east_north_m[i][1];
            list[i] = &points[i];
        }
        code =
            ask_points(client, list, count, sea ? sea : &present, out, error);
    } else {
        client_fail(error, code, "out of memory");
    }
    free(points);
    free(list);
    return code;
}

enum pel_client_code pel_client_spectrum(struct pel_client *client,
                                         const Pelagos__SpectrumQuery *query,
                                         Pelagos__Spectrum **out,
                                         struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_SPECTRUM;
    request.spectrum = (Pelagos__SpectrumQuery *)query;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_SPECTRUM, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->spectrum;
        reply->spectrum = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_models(struct pel_client *client,
                                       const Pelagos__ModelsQuery *query,
                                       Pelagos__Models **out,
                                       struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_MODELS;
    request.models = (Pelagos__ModelsQuery *)query;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_MODELS, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->models;
        reply->models = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code
pel_client_recordings(struct pel_client *client,
                      const Pelagos__RecordingCommand *command,
                      Pelagos__Recordings **out, struct pel_client_error *error)
{
    Pelagos__RecordingsQuery query = PELAGOS__RECORDINGS_QUERY__INIT;
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = command ? PELAGOS__REQUEST__COMMAND_RECORDING
                                   : PELAGOS__REQUEST__COMMAND_RECORDINGS;
    if (command) {
        request.recording = (Pelagos__RecordingCommand *)command;
    } else {
        request.recordings = &query;
    }
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code = call(
        client, &request, PELAGOS__REPLY__RESULT_RECORDINGS, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->recordings;
        reply->recordings = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_debrief(struct pel_client *client,
                                        const Pelagos__DebriefCommand *command,
                                        Pelagos__Debrief **out,
                                        struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_DEBRIEF;
    request.debrief = (Pelagos__DebriefCommand *)command;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_DEBRIEF, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->debrief;
        reply->debrief = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_exercise(
    struct pel_client *client, const Pelagos__ExerciseCommand *command,
    Pelagos__ExerciseStatus **out, struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_EXERCISE;
    request.exercise = (Pelagos__ExerciseCommand *)command;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_EXERCISE, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->exercise;
        reply->exercise = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

static enum pel_client_code ask_cluster(struct pel_client *client,
                                        Pelagos__Request *request,
                                        Pelagos__Cluster **out,
                                        struct pel_client_error *error)
{
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, request, PELAGOS__REPLY__RESULT_CLUSTER, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->cluster;
        reply->cluster = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_cluster(struct pel_client *client,
                                        Pelagos__Cluster **out,
                                        struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    Pelagos__ClusterQuery query = PELAGOS__CLUSTER_QUERY__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_CLUSTER;
    request.cluster = &query;
    return ask_cluster(client, &request, out, error);
}

enum pel_client_code
pel_client_place(struct pel_client *client,
                 const Pelagos__ClusterPlaceCommand *command,
                 Pelagos__Cluster **out, struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_PLACE;
    request.place = (Pelagos__ClusterPlaceCommand *)command;
    return ask_cluster(client, &request, out, error);
}

enum pel_client_code pel_client_optics(struct pel_client *client,
                                       const Pelagos__OpticsQuery *query,
                                       Pelagos__Optics **out,
                                       struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_OPTICS;
    request.optics = (Pelagos__OpticsQuery *)query;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_OPTICS, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->optics;
        reply->optics = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_series(struct pel_client *client,
                                       const Pelagos__SeriesQuery *query,
                                       Pelagos__Series **out,
                                       struct pel_client_error *error)
{
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_SERIES;
    request.series = (Pelagos__SeriesQuery *)query;
    Pelagos__Reply *reply = NULL;
    enum pel_client_code code =
        call(client, &request, PELAGOS__REPLY__RESULT_SERIES, &reply, error);
    if (code == PEL_CLIENT_OK) {
        *out = reply->series;
        reply->series = NULL;
        reply->result_case = PELAGOS__REPLY__RESULT__NOT_SET;
        pelagos__reply__free_unpacked(reply, NULL);
    }
    return code;
}

enum pel_client_code pel_client_step(struct pel_client *client, double seconds,
                                     Pelagos__State **out,
                                     struct pel_client_error *error)
{
    Pelagos__ClockStep step = PELAGOS__CLOCK_STEP__INIT;
    step.has_seconds = 1;
    step.seconds = seconds;
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_STEP;
    request.step = &step;
    return call_for_state(client, &request, out, error);
}

enum pel_client_code pel_client_step_to(struct pel_client *client,
                                        double time_s, Pelagos__State **out,
                                        struct pel_client_error *error)
{
    Pelagos__ClockStep step = PELAGOS__CLOCK_STEP__INIT;
    step.has_until = 1;
    step.until = time_s;
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_STEP;
    request.step = &step;
    return call_for_state(client, &request, out, error);
}

enum pel_client_code pel_client_watch(struct pel_client *client,
                                      Pelagos__State **out,
                                      struct pel_client_error *error)
{
    Pelagos__Watch watch = PELAGOS__WATCH__INIT;
    Pelagos__Request request = PELAGOS__REQUEST__INIT;
    request.command_case = PELAGOS__REQUEST__COMMAND_WATCH;
    request.watch = &watch;
    enum pel_client_code code = call_for_state(client, &request, out, error);
    if (code == PEL_CLIENT_OK) {
        client->watch_id = request.id;
    }
    return code;
}

enum pel_client_code pel_client_next_state(struct pel_client *client,
                                           int timeout_ms, Pelagos__State **out,
                                           struct pel_client_error *error)
{
    int64_t deadline_ns = stream_deadline(timeout_ms);
    while (!client->watched) {
        Pelagos__Reply *reply = NULL;
        enum stream_result result = read_reply(client, deadline_ns, &reply);
        if (result == STREAM_TIMEOUT) {
            return client_fail(error, PEL_CLIENT_TIMEOUT, "nothing changed");
        }
        if (result != STREAM_OK) {
            return stream_fail(client, result, error);
        }
        enum pel_client_code code = PEL_CLIENT_OK;
        if (!keep_if_watched(client, reply) &&
            reply->result_case == PELAGOS__REPLY__RESULT_ERROR) {
            code = refuse(reply->error, error);
        }
        pelagos__reply__free_unpacked(reply, NULL);
        if (code != PEL_CLIENT_OK) {
            return code;
        }
    }
    *out = client->watched;
    client->watched = NULL;
    return PEL_CLIENT_OK;
}

const char *pel_client_code_name(enum pel_client_code code)
{
    switch (code) {
    case PEL_CLIENT_OK:
        return "OK";
    case PEL_CLIENT_MALFORMED:
        return "MALFORMED";
    case PEL_CLIENT_NOT_FOUND:
        return "NOT_FOUND";
    case PEL_CLIENT_OUT_OF_RANGE:
        return "OUT_OF_RANGE";
    case PEL_CLIENT_INVALID:
        return "INVALID";
    case PEL_CLIENT_CONFLICT:
        return "CONFLICT";
    case PEL_CLIENT_BUSY:
        return "BUSY";
    case PEL_CLIENT_INTERNAL:
        return "INTERNAL";
    case PEL_CLIENT_UNAUTHORIZED:
        return "UNAUTHORIZED";
    case PEL_CLIENT_FORBIDDEN:
        return "FORBIDDEN";
    case PEL_CLIENT_BAD_ADDRESS:
        return "BAD_ADDRESS";
    case PEL_CLIENT_UNREACHABLE:
        return "UNREACHABLE";
    case PEL_CLIENT_TIMEOUT:
        return "TIMEOUT";
    case PEL_CLIENT_CLOSED:
        return "CLOSED";
    case PEL_CLIENT_PROTOCOL:
        return "PROTOCOL";
    }
    return "INTERNAL";
}
