/* record: a view as a clip, drawn for it or as it is streamed. */
#include "pelagosctl/ctl.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <glib.h>

#include "base/clock.h"
#include "lib/token.h"
#include "pelagosctl/clip.h"
#include "proto/formats.h"

struct recording {
    const char *path;
    struct clip *clip;
    double seconds, fps, first_time_s;
    bool exact, terminal;
    size_t wanted, written;
    Pelagos__FrameRequest request;
};

static enum ctl_exit read_options(struct ctl *ctl, struct recording *r)
{
    double width = 0, height = 0, quality = 90;
    if (ctl_number(ctl, "from", 0, 1e9, &r->first_time_s) ||
        ctl_number(ctl, "seconds", 0.1, 86400, &r->seconds) ||
        ctl_number(ctl, "fps", 1, 60, &r->fps) ||
        ctl_number(ctl, "width", 1, 65535, &width) ||
        ctl_number(ctl, "height", 1, 65535, &height) ||
        ctl_number(ctl, "quality", 1, 100, &quality)) {
        return CTL_USAGE;
    }
    r->request.has_format = r->request.has_quality = 1;
    r->request.format = PELAGOS__FRAME_FORMAT__JPEG;
    r->request.quality = (uint32_t)quality;
    r->request.has_width = width > 0;
    r->request.width = (uint32_t)width;
    r->request.has_height = height > 0;
    r->request.height = (uint32_t)height;
    r->wanted = (size_t)(r->seconds * r->fps + 0.5);
    r->wanted = r->wanted > 0 ? r->wanted : 1;
    return CTL_DONE;
}

/* Adds one frame; the first opens the file and settles the size. */
static enum ctl_exit take_frame(struct recording *r,
                                const Pelagos__Frame *frame, double time_s)
{
    g_autofree char *why = NULL;
    if (!r->clip) {
        r->clip = clip_open(r->path, frame->width, frame->height, r->fps,
                            &ctl_interrupted, &why);
        if (!r->clip) {
            return ctl_say(CTL_FAILED, "%s", why);
        }
        r->request.has_width = r->request.has_height = 1;
        r->request.width = frame->width;
        r->request.height = frame->height;
        r->first_time_s = frame->time;
    }
    if (clip_add(r->clip, frame->data.data, frame->data.len, time_s, &why)) {
        return ctl_say(CTL_FAILED, "%s: %s", r->path, why);
    }
    r->written++;
    if (r->terminal) {
        fprintf(stderr, "\r%5.1f of %.1f s, %zu frames, %.1f ms each ", time_s,
                r->seconds, r->written, frame->render_ms + frame->encode_ms);
    }
    return CTL_DONE;
}

static void sleep_until(int64_t due_ns)
{
    struct timespec due = { .tv_sec = due_ns / 1000000000,
                            .tv_nsec = due_ns % 1000000000 };
    while (!ctl_interrupted && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME,
                                               &due, NULL) == EINTR) {
    }
}

static enum ctl_exit record_frames(struct ctl *ctl, struct recording *r)
{
    int64_t start_ns = 0;
    enum ctl_exit status = CTL_DONE;
    for (size_t i = 0; i < r->wanted && !ctl_interrupted;) {
        double time_s = (double)i / r->fps;
        if (r->exact && i > 0) {
            r->request.has_time = 1;
            r->request.time = r->first_time_s + time_s;
        } else if (i > 0) {
            sleep_until(start_ns + (int64_t)(time_s * 1e9));
        }
        Pelagos__Frame *frame = NULL;
        struct pel_client_error error;
        if (pel_client_frame(ctl->client, &r->request, &frame, &error)) {
            return ctl_report(ctl, &error);
        }
        /* Live time starts with the first picture, not with its drawing. */
        start_ns = i == 0 ? pel_now_ns() : start_ns;
        status = take_frame(r, frame, time_s);
        pelagos__frame__free_unpacked(frame, NULL);
        if (status != CTL_DONE) {
            return status;
        }
        size_t due =
            (size_t)((double)(pel_now_ns() - start_ns) * 1e-9 * r->fps);
        i = r->exact || due < i + 1 ? i + 1 : due + 1;
    }
    return status;
}

static void report_done(struct ctl *ctl, const struct recording *r)
{
    struct stat file = { 0 };
    stat(r->path, &file);
    bool stream = ctl_flag(ctl, "stream");
    if (ctl_flag(ctl, "json")) {
        fputs("{\"file\":", stdout);
        ctl_print_string(stdout, r->path);
        if (stream) {
            printf(",\"frames\":%zu,\"bytes\":%lld}\n", r->written,
                   (long long)file.st_size);
            return;
        }
        printf(",\"frames\":%zu,\"wanted\":%zu,\"width\":%u,\"height\":%u,"
               "\"bytes\":%lld}\n",
               r->written, r->wanted, r->request.width, r->request.height,
               (long long)file.st_size);
    } else if (stream && !ctl_flag(ctl, "quiet")) {
        printf("%s: %zu pictures, %lld kB\n", r->path, r->written,
               (long long)(file.st_size + 999) / 1000);
    } else if (!ctl_flag(ctl, "quiet")) {
        printf("%s: %zu frames of %ux%u, %lld kB", r->path, r->written,
               r->request.width, r->request.height,
               (long long)(file.st_size + 999) / 1000);
        printf(r->written < r->wanted ? "; %zu were not drawn in time\n" : "\n",
               r->wanted - r->written);
    }
}

/* --- as it is streamed --------------------------------------------------- */

static void show_stream(void *user, double seconds, size_t frames)
{
    const struct recording *r = user;
    if (r->terminal) {
        struct stat file = { 0 };
        stat(r->path, &file);
        fprintf(stderr, "\r%5.1f of %.1f s, %zu pictures, %.1f MB ", seconds,
                r->seconds, frames, (double)file.st_size * 1e-6);
    }
}

/* The stream's address: of --url, else of the daemon's host. */
static char *stream_url(struct ctl *ctl, const struct recording *r)
{
    const char *base = ctl_value(ctl, "url");
    base = base ? base : g_getenv(PEL_LIVE_URL_VARIABLE);
    base = base ? base : PEL_LIVE_DEFAULT_URL;
    size_t length = strlen(base);
    GString *url = g_string_new(NULL);
    g_string_printf(url, "%.*s/v1/views/%s/ts?",
                    (int)(length - (length > 0 && base[length - 1] == '/')),
                    base, r->request.view);
    if (r->request.has_width) {
        g_string_append_printf(url, "width=%u&", r->request.width);
    }
    if (r->request.has_height) {
        g_string_append_printf(url, "height=%u&", r->request.height);
    }
    if (ctl_flag(ctl, "bitrate")) {
        g_string_append_printf(url, "bitrate=%s&", ctl_value(ctl, "bitrate"));
    }
    g_string_truncate(url, url->len - 1); /* ? or & */
    return g_string_free(url, FALSE);
}

static enum ctl_exit record_stream(struct ctl *ctl, struct recording *r)
{
    double kbps = 0;
    if (ctl_number(ctl, "bitrate", 100, 100000, &kbps)) {
        return CTL_USAGE;
    }
    char token[CLIENT_TOKEN_MAX + 1], said[256];
    if (client_token(token, said, sizeof said) != 0) {
        return ctl_say(CTL_FAILED, "%s", said);
    }
    g_autofree char *url = stream_url(ctl, r), *why = NULL;
    const struct clip_stream wish = { .url = url,
                                      .path = r->path,
                                      .seconds = r->seconds,
                                      .token = *token ? token : NULL,
                                      .stop = &ctl_interrupted,
                                      .progress = show_stream,
                                      .user = r };
    ctl_catch_signals();
    int result = clip_stream(&wish, &r->written, &why);
    if (r->terminal) {
        fputs("\r\033[K", stderr);
    }
    if (result != 0) {
        return ctl_say(CTL_FAILED, "%s", why);
    }
    r->wanted = r->written;
    report_done(ctl, r);
    return CTL_DONE;
}

/* --- the command --------------------------------------------------------- */

/* Options that say nothing for this kind of file would be passed over. */
static enum ctl_exit check_options(const struct ctl *ctl, bool sequence)
{
    static const char *const of_sequences[] = { "layers", "float", "resume" };
    static const char *const of_streams[] = { "url", "bitrate" };
    static const char *const of_drawings[] = { "exact", "from", "fps",
                                               "quality", "waypoints" };
    bool stream = ctl_flag(ctl, "stream");
    for (size_t i = 0; !sequence && i < G_N_ELEMENTS(of_sequences); i++) {
        if (ctl_flag(ctl, of_sequences[i])) {
            return ctl_say(CTL_USAGE, "--%s is for sequences: %s",
                           of_sequences[i], pel_format_endings);
        }
    }
    for (size_t i = 0; !stream && i < G_N_ELEMENTS(of_streams); i++) {
        if (ctl_flag(ctl, of_streams[i])) {
            return ctl_say(CTL_USAGE, "--%s needs --stream", of_streams[i]);
        }
    }
    for (size_t i = 0; stream && i < G_N_ELEMENTS(of_drawings); i++) {
        if (ctl_flag(ctl, of_drawings[i])) {
            return ctl_say(CTL_USAGE, "--stream is as it is streamed: no --%s",
                           of_drawings[i]);
        }
    }
    if (stream && sequence) {
        return ctl_say(CTL_USAGE, "--stream goes into .mkv or .mp4");
    }
    if (!sequence && ctl_flag(ctl, "from") && !ctl_flag(ctl, "exact") &&
        !ctl_flag(ctl, "waypoints")) {
        return ctl_say(CTL_USAGE, "--from needs --exact");
    }
    return CTL_DONE;
}

/* From the way's beginning to its end, both with a frame, unless it is said
 * otherwise. */
static enum ctl_exit go_way(struct ctl *ctl, struct recording *r)
{
    double first_s, last_s;
    enum ctl_exit status = ctl_connect(ctl);
    if (status == CTL_DONE) {
        status = ctl_way(ctl, r->request.view, &first_s, &last_s);
    }
    if (status != CTL_DONE) {
        return status;
    }
    r->exact = true;
    if (!r->request.has_time) {
        r->request.has_time = 1;
        r->request.time = first_s;
    }
    if (!ctl_flag(ctl, "seconds")) {
        double seconds = last_s - r->request.time;
        r->seconds = seconds > 0 ? seconds : 0;
        r->wanted = (size_t)(r->seconds * r->fps + 1e-6) + 1;
    }
    return CTL_DONE;
}

enum ctl_exit ctl_record(struct ctl *ctl)
{
    struct recording r = {
        .path = ctl->args[1],
        .seconds = 10.0,
        .fps = 15.0,
        .exact = ctl_flag(ctl, "exact"),
        .terminal = isatty(STDERR_FILENO) && !ctl_flag(ctl, "quiet"),
        .request = PELAGOS__FRAME_REQUEST__INIT,
    };
    r.request.view = (char *)ctl->args[0];
    enum ctl_exit status = read_options(ctl, &r);
    bool sequence = ctl_sequence_is(r.path);
    if (status == CTL_DONE) {
        status = check_options(ctl, sequence);
    }
    if (status == CTL_DONE && ctl_flag(ctl, "from")) {
        r.request.has_time = 1; /* else from the present on */
        r.request.time = r.first_time_s;
    }
    bool goes = ctl_flag(ctl, "waypoints");
    if (status == CTL_DONE && sequence && goes) {
        status = go_way(ctl, &r);
    }
    if (status == CTL_DONE && sequence) {
        return ctl_record_sequence(ctl, r.fps, r.wanted, &r.request);
    }
    if (status == CTL_DONE && !ctl_flag(ctl, "overwrite") &&
        access(r.path, F_OK) == 0) {
        status = ctl_say(CTL_FAILED,
                         "%s exists already: --overwrite replaces it", r.path);
    }
    if (status == CTL_DONE && ctl_flag(ctl, "stream")) {
        return record_stream(ctl, &r);
    }
    if (status == CTL_DONE) {
        status = goes ? go_way(ctl, &r) : ctl_connect(ctl);
    }
    if (status != CTL_DONE) {
        return status;
    }
    ctl_catch_signals();
    status = record_frames(ctl, &r);
    if (r.terminal) {
        fputs("\r\033[K", stderr);
    }
    g_autofree char *why = NULL;
    if (r.clip && clip_close(r.clip, &why) != 0 && status == CTL_DONE) {
        status = ctl_say(CTL_FAILED, "%s: %s", r.path, why);
    }
    if (status == CTL_DONE && r.written > 0) {
        report_done(ctl, &r);
    }
    return status;
}
