/* record into numbered files: a sequence of EXRs, PNGs or JPEGs, each drawn
 * for its own moment. */
#include "pelagosctl/ctl.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include <glib.h>

#include "proto/formats.h"

#include "base/clock.h"
#include "base/file.h"

#define MAX_DIGITS 9

struct sequence {
    char *before, *after; /* of the number */
    int digits;
    double fps, first_time_s;
    size_t wanted, written, kept;
    int64_t bytes, started_ns;
    Pelagos__FrameRequest request;
    bool terminal, resume, overwrite;
};

/* --- names --------------------------------------------------------------- */

bool ctl_sequence_is(const char *path)
{
    return pel_format_by_path(path) != NULL;
}

/* Parts the path at its %d or %05d; without one the number comes before the
 * ending. */
static enum ctl_exit split(struct sequence *s, const char *path)
{
    const char *mark = strchr(path, '%');
    if (!mark) {
        const char *dot = strrchr(path, '.');
        s->before = g_strdup_printf("%.*s_", (int)(dot - path), path);
        s->after = g_strdup(dot);
        s->digits = 5;
        return CTL_DONE;
    }
    char *end;
    unsigned long digits = strtoul(mark + 1, &end, 10);
    if (*end != 'd' || digits > MAX_DIGITS || strchr(end, '%')) {
        return ctl_say(CTL_USAGE,
                       "%s: the number's place is one %%d or %%05d (0 to %d "
                       "digits)",
                       path, MAX_DIGITS);
    }
    s->before = g_strndup(path, (gsize)(mark - path));
    s->after = g_strdup(end + 1);
    s->digits = (int)digits;
    return CTL_DONE;
}

static char *name_of(const struct sequence *s, size_t i)
{
    return g_strdup_printf("%s%0*zu%s", s->before, s->digits, i, s->after);
}

static bool exists(const struct sequence *s, size_t i)
{
    g_autofree char *path = name_of(s, i);
    return access(path, F_OK) == 0;
}

/* --- what is there already ----------------------------------------------- */

/* Simulated time in the header of an EXR that pelagosd made. */
static bool read_time(const char *path, double *time_s)
{
    static const char mark[] = "pelagos.time\0double\0\x08\0\0"; /* and a 0 */
    char head[16384];
    int fd = -1;
    if (pel_file_open(path, &fd, NULL)) {
        return false;
    }
    ssize_t got = read(fd, head, sizeof head);
    size_t size = got > 0 ? (size_t)got : 0;
    close(fd);
    const char *at = size > 0 ? memmem(head, size, mark, sizeof mark) : NULL;
    if (!at || at + sizeof mark + sizeof *time_s > head + size) {
        return false;
    }
    memcpy(time_s, at + sizeof mark, sizeof *time_s);
    return true;
}

/* Refuses to write over what is there; when it goes on with it, finds out
 * which time the first frame is of. */
static enum ctl_exit look(struct sequence *s)
{
    size_t there = 0;
    for (size_t i = 0; i < s->wanted; i++) {
        there += exists(s, i);
    }
    s->kept = s->resume ? there : 0;
    g_autofree char *first = name_of(s, 0);
    if (there > 0 && !s->resume && !s->overwrite) {
        return ctl_say(CTL_FAILED,
                       "%zu of the %zu files (%s, …) exist already: --resume "
                       "draws the missing ones, --overwrite all of them",
                       there, s->wanted, first);
    }
    if (there == 0 || !s->resume || s->request.has_time) {
        return CTL_DONE;
    }
    if (!read_time(first, &s->first_time_s)) {
        return ctl_say(CTL_FAILED,
                       "%s does not say its simulated time: give that of the "
                       "first frame (--from SECONDS)",
                       first);
    }
    s->request.has_time = 1;
    return CTL_DONE;
}

static enum ctl_exit make_folder(const struct sequence *s)
{
    g_autofree char *first = name_of(s, 0);
    g_autofree char *folder = g_path_get_dirname(first);
    if (g_mkdir_with_parents(folder, 0777) != 0) {
        return ctl_say(CTL_FAILED, "%s: %s", folder, g_strerror(errno));
    }
    return CTL_DONE;
}

/* --- one file ------------------------------------------------------------ */

/* Whole or not at all: under another name until it is. */
static enum ctl_exit save(struct sequence *s, const char *path,
                          const Pelagos__Frame *frame)
{
    g_autofree char *part = g_strconcat(path, ".part", NULL);
    FILE *file = fopen(part, "wb");
    bool whole = file && fwrite(frame->data.data, 1, frame->data.len, file) ==
                             frame->data.len;
    int error = whole ? 0 : errno;
    if (file && fclose(file) != 0 && error == 0) {
        error = errno;
    }
    if (error == 0 && rename(part, path) != 0) {
        error = errno;
    }
    if (error == 0) {
        s->bytes += (int64_t)frame->data.len;
        s->written++;
        return CTL_DONE;
    }
    if (file) {
        unlink(part);
    }
    return ctl_say(CTL_FAILED,
                   "%s: %s; %zu of %zu frames are there, each whole: go on "
                   "with --resume",
                   path, g_strerror(error), s->written + s->kept, s->wanted);
}

static void show(const struct sequence *s, size_t i)
{
    if (s->terminal) {
        double spent = (double)(pel_now_ns() - s->started_ns) * 1e-9;
        double each = s->written ? spent / (double)s->written : 0.0;
        fprintf(stderr,
                "\r%zu of %zu frames, %.1f MB, %.0f ms each, %.0f s to go ",
                i + 1, s->wanted, (double)s->bytes * 1e-6, 1e3 * each,
                each * (double)(s->wanted - i - 1));
    }
}

static enum ctl_exit draw(struct ctl *ctl, struct sequence *s, size_t i,
                          const char *path)
{
    Pelagos__Frame *frame = NULL;
    struct pel_client_error error;
    s->request.time = s->first_time_s + (double)i / s->fps;
    if (pel_client_frame(ctl->client, &s->request, &frame, &error)) {
        return ctl_report(ctl, &error);
    }
    if (!s->request.has_time) { /* the first, of the present */
        s->first_time_s = frame->time - (double)i / s->fps;
        s->request.has_time = 1;
    }
    s->request.has_width = s->request.has_height = 1;
    s->request.width = frame->width;
    s->request.height = frame->height;
    enum ctl_exit status = save(s, path, frame);
    pelagos__frame__free_unpacked(frame, NULL);
    return status;
}

static enum ctl_exit draw_all(struct ctl *ctl, struct sequence *s)
{
    enum ctl_exit status = CTL_DONE;
    s->started_ns = pel_now_ns();
    for (size_t i = 0; i < s->wanted && status == CTL_DONE; i++) {
        g_autofree char *path = name_of(s, i);
        if (ctl_interrupted) {
            return ctl_say(CTL_FAILED,
                           "interrupted; %zu of %zu frames are there: go on "
                           "with --resume",
                           s->written + s->kept, s->wanted);
        }
        if (s->resume && access(path, F_OK) == 0) {
            continue;
        }
        status = draw(ctl, s, i, path);
        show(s, i);
    }
    return status;
}

/* --- the command --------------------------------------------------------- */

static void report(struct ctl *ctl, const struct sequence *s)
{
    g_autofree char *first = name_of(s, 0);
    if (ctl_flag(ctl, "json")) {
        fputs("{\"file\":", stdout);
        ctl_print_string(stdout, first);
        printf(",\"frames\":%zu,\"kept\":%zu,\"wanted\":%zu,\"width\":%u,"
               "\"height\":%u,\"bytes\":%lld,\"time\":%.17g}\n",
               s->written, s->kept, s->wanted, s->request.width,
               s->request.height, (long long)s->bytes, s->first_time_s);
    } else if (!ctl_flag(ctl, "quiet")) {
        printf("%s …: %zu frames of %ux%u from %.3f s on, %lld kB", first,
               s->written, s->request.width, s->request.height, s->first_time_s,
               (long long)(s->bytes + 999) / 1000);
        printf(s->kept ? "; %zu were there\n" : "\n", s->kept);
    }
}

enum ctl_exit ctl_record_sequence(struct ctl *ctl, double fps, size_t wanted,
                                  const Pelagos__FrameRequest *request)
{
    struct sequence s = {
        .fps = fps,
        .wanted = wanted,
        .request = *request,
        .terminal = isatty(STDERR_FILENO) && !ctl_flag(ctl, "quiet"),
        .resume = ctl_flag(ctl, "resume"),
        .overwrite = ctl_flag(ctl, "overwrite"),
    };
    const char *path = ctl->args[1];
    s.request.format = pel_format_by_path(path)->format;
    g_auto(GStrv) layers = NULL;
    if (ctl_value(ctl, "layers")) {
        layers = g_strsplit(ctl_value(ctl, "layers"), ",", -1);
        s.request.layers = layers;
        s.request.n_layers = g_strv_length(layers);
    }
    s.request.has_float_samples = s.request.float_samples =
        ctl_flag(ctl, "float");
    s.first_time_s = request->time;
    enum ctl_exit status = split(&s, path);
    if (status == CTL_DONE) {
        status = look(&s);
    }
    if (status == CTL_DONE) {
        status = make_folder(&s);
    }
    if (status == CTL_DONE && !ctl->client) {
        status = ctl_connect(ctl);
    }
    if (status == CTL_DONE) {
        ctl_catch_signals();
        status = draw_all(ctl, &s);
        if (s.terminal) {
            fputs("\r\033[K", stderr);
        }
    }
    if (status == CTL_DONE) {
        report(ctl, &s);
    }
    g_free(s.before);
    g_free(s.after);
    return status;
}
