#include "pelagosctl/log_run.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "pelog.h"

static enum pel_err map_file(const char *name, GMappedFile **out,
                             struct pel_fault *fault)
{
    g_autoptr(GError) error = NULL;
    int fd;
    enum pel_err err = pel_file_open(name, &fd, fault);
    if (err) {
        return err;
    }
    *out = g_mapped_file_new_from_fd(fd, FALSE, &error);
    close(fd);
    return *out ? PEL_OK
                : pel_fault_set(fault, PEL_ERR_IO, "%.160s: %s", name,
                                error->message);
}

bool log_run_is(const char *name)
{
    GMappedFile *map;
    if (map_file(name, &map, NULL)) {
        return false;
    }
    const char *data = g_mapped_file_get_contents(map);
    /* Any version: faults of the head are reported as those of a log. */
    bool is = data && g_mapped_file_get_length(map) > 5 &&
              memcmp(data, "PELOG", 5) == 0;
    g_mapped_file_unref(map);
    return is;
}

static enum ctl_exit check(struct log_segment *s)
{
    struct pel_log_reader reader;
    struct pel_fault fault;
    enum pel_err err = pel_log_open(&reader, s->data, s->size, &fault);
    Pelagos__LogEntry *entry = NULL;
    while (!err) {
        err = pel_log_next(&reader, &entry, &fault);
        if (!entry) {
            break;
        }
        if (reader.entries == 1) {
            s->recording = g_strdup(entry->head->recording);
            s->segment = entry->head->segment;
        }
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
    if (err) {
        return ctl_say(CTL_FAILED, "%s: %s", s->name, fault.message);
    }
    if (reader.torn) {
        ctl_say(CTL_DONE,
                "%s ends inside entry %zu, which is left out: the "
                "recording was cut off",
                s->name, reader.entries + 1);
    }
    return CTL_DONE;
}

static enum ctl_exit load(struct log_segment *s)
{
    struct pel_fault fault;
    if (map_file(s->name, &s->map, &fault)) {
        return ctl_say(CTL_FAILED, "%s", fault.message);
    }
    s->size = g_mapped_file_get_length(s->map);
    s->data = g_mapped_file_get_contents(s->map);
    s->data = s->data ? s->data : "";
    return check(s);
}

static int by_number(const void *a, const void *b)
{
    const struct log_segment *x = a, *y = b;
    return (x->segment > y->segment) - (x->segment < y->segment);
}

static enum ctl_exit follows(const struct log_segment *a,
                             const struct log_segment *b)
{
    if (!a->recording || !b->recording ||
        strcmp(a->recording, b->recording) != 0) {
        return ctl_say(CTL_FAILED,
                       "%s and %s are of two recordings: replay them one by "
                       "one",
                       a->name, b->name);
    }
    if (a->segment == b->segment) {
        return ctl_say(CTL_FAILED, "%s and %s are both segment %u", a->name,
                       b->name, a->segment);
    }
    if (a->segment + 1 != b->segment) {
        return ctl_say(CTL_FAILED,
                       "segment %u is missing between %s and %s: replay what "
                       "is before it and what is behind it one by one",
                       a->segment + 1, a->name, b->name);
    }
    return CTL_DONE;
}

enum ctl_exit log_run_open(const char *const *names, size_t count,
                           struct log_run *out)
{
    enum ctl_exit status = CTL_DONE;
    out->count = count;
    out->segments = g_new0(struct log_segment, count);
    for (size_t i = 0; i < count && status == CTL_DONE; i++) {
        out->segments[i].name = names[i];
        status = load(&out->segments[i]);
    }
    if (status == CTL_DONE) {
        qsort(out->segments, count, sizeof *out->segments, by_number);
    }
    for (size_t i = 1; i < count && status == CTL_DONE; i++) {
        status = follows(&out->segments[i - 1], &out->segments[i]);
    }
    return status;
}

void log_run_finish(struct log_run *run)
{
    for (size_t i = 0; i < run->count; i++) {
        g_free(run->segments[i].recording);
        if (run->segments[i].map) {
            g_mapped_file_unref(run->segments[i].map);
        }
    }
    g_free(run->segments);
}
