#include "scene/recordings.h"

#include <errno.h>
#include <glib.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "pelog.h"

static void segment_finish(struct pel_recording_segment *s)
{
    g_free(s->path);
    g_free(s->recording);
    g_free(s->began);
    g_free(s->program);
    g_free(s->device);
}

void pel_recording_finish(struct pel_recording *r)
{
    for (size_t i = 0; i < r->count; i++) {
        segment_finish(&r->segments[i]);
    }
    g_free(r->segments);
    g_free(r->why);
    *r = (struct pel_recording){ 0 };
}

void pel_recordings_finish(struct pel_recordings *all)
{
    for (size_t i = 0; i < all->count; i++) {
        pel_recording_finish(&all->items[i]);
    }
    g_free(all->items);
    *all = (struct pel_recordings){ 0 };
}

/* --- files ---------------------------------------------------------------- */

/* The first entry of a log; false: the file is none. */
static bool read_head(int fd, struct pel_recording_segment *out)
{
    uint8_t first[64];
    struct pel_log_reader reader;
    Pelagos__LogEntry *entry = NULL;
    ssize_t got = pread(fd, first, sizeof first, 0);
    size_t size = got > 0 ? pel_log_head_bytes(first, (size_t)got) : 0;
    g_autofree uint8_t *bytes = size > 0 ? g_malloc(size) : NULL;
    got = bytes ? pread(fd, bytes, size, 0) : -1;
    if (got < 0 || pel_log_open(&reader, bytes, (size_t)got, NULL) ||
        pel_log_next(&reader, &entry, NULL) || !entry) {
        return false;
    }
    const Pelagos__LogHead *head = entry->head;
    out->recording = g_strdup(head->recording);
    out->began = g_strdup(head->began);
    out->program = g_strdup(head->program);
    out->device = g_strdup(head->device);
    out->number = head->segment;
    out->waves = head->waves;
    out->from_s = entry->time;
    pelagos__log_entry__free_unpacked(entry, NULL);
    return true;
}

static bool look_at(const char *directory, const char *name,
                    struct pel_recording_segment *out)
{
    struct stat about;
    int fd;
    *out = (struct pel_recording_segment){ 0 };
    if (pel_file_open_in(directory, name, &fd, NULL)) {
        return false;
    }
    bool is =
        fstat(fd, &about) == 0 && S_ISREG(about.st_mode) && read_head(fd, out);
    close(fd);
    if (is) {
        out->path = g_build_filename(directory, name, NULL);
        out->bytes = (uint64_t)about.st_size;
    }
    return is;
}

enum pel_err pel_recording_open(const struct pel_recording_segment *s,
                                struct pel_logfile **out,
                                struct pel_fault *fault)
{
    *out = NULL;
    if (s->bytes > PEL_RECORDING_SEGMENT_BYTES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%.160s has more than %zu bytes", s->path,
                             PEL_RECORDING_SEGMENT_BYTES);
    }
    g_autofree char *directory = g_path_get_dirname(s->path);
    g_autofree char *name = g_path_get_basename(s->path);
    int fd;
    enum pel_err err = pel_file_open_in(directory, name, &fd, fault);
    return err ? err : pel_logfile_take(fd, out, fault);
}

/* Time of the last whole entry. */
static enum pel_err find_end(const struct pel_recording_segment *s, double *out,
                             struct pel_fault *fault)
{
    struct pel_logfile *log;
    enum pel_err err = pel_recording_open(s, &log, fault);
    if (!err) {
        err = pel_logfile_last(log, out, fault);
        pel_logfile_close(log);
    }
    return err;
}

/* --- recordings ----------------------------------------------------------- */

static int in_order(const void *a, const void *b)
{
    const struct pel_recording_segment *x = a, *y = b;
    int by = g_strcmp0(x->recording, y->recording);
    return by != 0 ? by : (x->number > y->number) - (x->number < y->number);
}

/* The newest first, by when they began: ISO 8601 sorts as text. */
static int newest(const void *a, const void *b)
{
    const struct pel_recording *x = a, *y = b;
    int by = g_strcmp0(y->segments[0].began, x->segments[0].began);
    return by != 0 ? by : g_strcmp0(y->segments[0].path, x->segments[0].path);
}

static enum pel_err find_segments(const char *directory, GArray *found,
                                  bool *more, struct pel_fault *fault)
{
    g_autoptr(GError) why = NULL;
    GDir *dir = g_dir_open(directory, 0, &why);
    const char *name;
    if (!dir) {
        return pel_fault_set(fault, PEL_ERR_IO, "--recordings: %.200s",
                             why->message);
    }
    while ((name = g_dir_read_name(dir))) {
        struct pel_recording_segment s;
        if (found->len == PEL_RECORDINGS_LISTED) {
            *more = true;
            break;
        }
        if (!g_str_has_suffix(name, ".new") && look_at(directory, name, &s)) {
            g_array_append_val(found, s);
        }
    }
    g_dir_close(dir);
    if (found->len > 0) {
        qsort(found->data, found->len, sizeof(struct pel_recording_segment),
              in_order);
    }
    return PEL_OK;
}

static bool follows(const struct pel_recording_segment *a,
                    const struct pel_recording_segment *b)
{
    return a->recording && b->recording &&
           strcmp(a->recording, b->recording) == 0 &&
           b->number == a->number + 1;
}

/* Takes the segments over. */
static void join(struct pel_recording_segment *segments, size_t count,
                 struct pel_recording *out)
{
    *out = (struct pel_recording){ .count = count };
    out->segments = g_memdup2(segments, count * sizeof *segments);
    for (size_t i = 0; i < count; i++) {
        out->bytes += segments[i].bytes;
    }
    out->to_s = segments[count - 1].from_s;
}

static void parts(GArray *found, struct pel_recordings *out)
{
    struct pel_recording_segment *all = (void *)found->data;
    out->items = g_new0(struct pel_recording, found->len + 1);
    for (size_t i = 0, end; i < found->len; i = end) {
        end = i + 1;
        while (end < found->len && follows(&all[end - 1], &all[end])) {
            end++;
        }
        join(&all[i], end - i, &out->items[out->count++]);
    }
    qsort(out->items, out->count, sizeof *out->items, newest);
}

enum pel_err pel_recordings_list(const char *directory,
                                 struct pel_recordings *out,
                                 struct pel_fault *fault)
{
    g_autoptr(GArray) found =
        g_array_new(FALSE, FALSE, sizeof(struct pel_recording_segment));
    *out = (struct pel_recordings){ 0 };
    enum pel_err err = find_segments(directory, found, &out->more, fault);
    if (err) {
        return err;
    }
    parts(found, out);
    for (size_t i = 0; i < out->count; i++) {
        struct pel_recording *r = &out->items[i];
        struct pel_fault why;
        if (find_end(&r->segments[r->count - 1], &r->to_s, &why)) {
            r->why = g_strdup(why.message);
        }
    }
    return PEL_OK;
}

static bool is_of(const struct pel_recording *r, const char *name)
{
    for (size_t i = 0; i < r->count; i++) {
        g_autofree char *file = g_path_get_basename(r->segments[i].path);
        const size_t begin = strlen(name);
        if (strcmp(file, name) == 0 ||
            (strncmp(file, name, begin) == 0 &&
             strcmp(file + begin, PEL_RECORDING_SUFFIX) == 0) ||
            g_strcmp0(r->segments[i].recording, name) == 0) {
            return true;
        }
    }
    return false;
}

/* Why a file of this name is no recording; NOT_FOUND: there is none. */
static enum pel_err why_not(const char *directory, const char *name,
                            struct pel_fault *fault)
{
    uint8_t first[PEL_LOG_BEGIN_SIZE];
    struct pel_log_reader reader;
    struct pel_fault why;
    int fd;
    enum pel_err err = pel_file_open_in(directory, name, &fd, &why);
    if (err) {
        return err == PEL_ERR_INVALID
                   ? pel_fault_set(fault, err, "%s", why.message)
                   : pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                                   "there is no recording \"%.80s\"", name);
    }
    pel_fault_set(&why, PEL_ERR_MALFORMED, "its head cannot be read");
    ssize_t got = pread(fd, first, sizeof first, 0);
    close(fd);
    err = pel_log_open(&reader, first, got > 0 ? (size_t)got : 0, &why);
    err = err ? err : PEL_ERR_MALFORMED;
    return pel_fault_set(fault, err, "%.80s: %.200s", name, why.message);
}

enum pel_err pel_recording_find(const char *directory, const char *name,
                                struct pel_recording *out,
                                struct pel_fault *fault)
{
    g_autoptr(GArray) found =
        g_array_new(FALSE, FALSE, sizeof(struct pel_recording_segment));
    struct pel_recordings all = { 0 };
    *out = (struct pel_recording){ 0 };
    if (!*name || *name == '.' || strchr(name, '/')) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "\"%.80s\" is no name of a recording", name);
    }
    enum pel_err err = find_segments(directory, found, &all.more, fault);
    if (err) {
        return err;
    }
    parts(found, &all);
    for (size_t i = 0; i < all.count && out->count == 0; i++) {
        if (is_of(&all.items[i], name)) {
            *out = all.items[i];
            all.items[i] = (struct pel_recording){ 0 };
        }
    }
    pel_recordings_finish(&all);
    if (out->count == 0) {
        return why_not(directory, name, fault);
    }
    if (out->bytes > PEL_RECORDING_BYTES) {
        pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                      "the recording has %.1f MiB; a debrief reads up to %.0f "
                      "MiB. `pelagosctl replay` plays it; or keep fewer "
                      "segments (--record-keep)",
                      (double)out->bytes / 1048576,
                      (double)PEL_RECORDING_BYTES / 1048576);
        pel_recording_finish(out);
        return PEL_ERR_OUT_OF_RANGE;
    }
    return PEL_OK;
}
