#include "scene/logfile.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

#define WINDOW ((size_t)256 << 10)
/* Of an entry and what is before it. */
#define LONGEST ((size_t)PEL_LOG_MAX_ENTRY + PEL_LOG_FRAME_SIZE)

struct pel_logfile {
    int fd;
    uint64_t size;
    uint8_t *bytes; /* of the file from reader.base on: reader.size of them */
    size_t room;
    struct pel_log_reader reader;
};

static enum pel_err make_room(struct pel_logfile *f, size_t room,
                              struct pel_fault *fault)
{
    uint8_t *bytes = room > f->room ? realloc(f->bytes, room) : f->bytes;
    if (!bytes) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    f->bytes = bytes;
    f->reader.data = bytes;
    f->room = room > f->room ? room : f->room;
    return PEL_OK;
}

/* The window from a byte of the file on; shorter at its end. */
static enum pel_err read_at(struct pel_logfile *f, uint64_t from,
                            struct pel_fault *fault)
{
    struct pel_log_reader *r = &f->reader;
    uint64_t left = f->size > from ? f->size - from : 0;
    size_t wanted = left < f->room ? (size_t)left : f->room;
    size_t used = 0;
    while (used < wanted) {
        ssize_t got =
            pread(f->fd, f->bytes + used, wanted - used, (off_t)(from + used));
        if (got < 0 && errno != EINTR) {
            return pel_fault_set(fault, PEL_ERR_IO, "cannot read it: %s",
                                 strerror(errno));
        }
        if (got == 0) { /* it was cut meanwhile */
            f->size = from + used;
            break;
        }
        used += got > 0 ? (size_t)got : 0;
    }
    r->base = from;
    r->at = 0;
    r->size = used;
    return PEL_OK;
}

static bool reaches_end(const struct pel_logfile *f)
{
    return f->reader.base + f->reader.size >= f->size;
}

/* Has the next entry whole in the window, if the file has. */
static enum pel_err fill(struct pel_logfile *f, struct pel_fault *fault)
{
    struct pel_log_reader *r = &f->reader;
    enum pel_err err = PEL_OK;
    size_t needs = pel_log_entry_bytes(r);
    if (reaches_end(f) || (needs > 0 && needs <= r->size - r->at)) {
        return PEL_OK;
    }
    if (r->at > 0 || r->size == 0) {
        err = read_at(f, r->base + r->at, fault);
        needs = pel_log_entry_bytes(r);
    }
    if (!err && !reaches_end(f) && (needs == 0 || needs > r->size)) {
        err = make_room(f, needs > 0 ? 2 * needs : 2 * LONGEST, fault);
        err = err ? err : read_at(f, r->base, fault);
    }
    return err;
}

/* Whether nothing but zeroes follows what is in the window. */
static bool only_zeroes_follow(const struct pel_logfile *f)
{
    uint8_t block[4096];
    uint64_t at = f->reader.base + f->reader.at;
    for (ssize_t got = 1; at < f->size && got > 0; at += (uint64_t)got) {
        got = pread(f->fd, block, sizeof block, (off_t)at);
        for (ssize_t i = 0; i < got; i++) {
            if (block[i] != 0) {
                return false;
            }
        }
    }
    return true;
}

enum pel_err pel_logfile_next(struct pel_logfile *f, Pelagos__LogEntry **out,
                              struct pel_fault *fault)
{
    *out = NULL;
    enum pel_err err = fill(f, fault);
    bool whole = reaches_end(f);
    err = err ? err : pel_log_next(&f->reader, out, fault);
    if (err || *out) {
        return err;
    }
    if (!whole && !only_zeroes_follow(f)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "entry %zu, at byte %llu, is damaged: its "
                             "checksum does not fit",
                             f->reader.entries + 1,
                             (unsigned long long)f->reader.base + f->reader.at);
    }
    f->size = f->reader.base + f->reader.at;
    return PEL_OK;
}

struct pel_logfile_place pel_logfile_place(const struct pel_logfile *f)
{
    return (struct pel_logfile_place){ f->reader.base + f->reader.at,
                                       f->reader.entries, f->reader.time_s };
}

void pel_logfile_go(struct pel_logfile *f, struct pel_logfile_place place)
{
    struct pel_log_reader *r = &f->reader;
    bool inside = place.at >= r->base && place.at - r->base <= r->size;
    r->at = inside ? (size_t)(place.at - r->base) : 0;
    if (!inside) {
        r->base = place.at;
        r->size = 0;
    }
    r->entries = place.entries;
    r->time_s = place.time_s;
    r->torn = false;
}

/* --- the end -------------------------------------------------------------- */

static bool time_of(const uint8_t *data, size_t size, double *out)
{
    Pelagos__LogEntry *entry = pelagos__log_entry__unpack(NULL, size, data);
    bool has = entry && entry->has_time;
    if (has) {
        *out = entry->time;
    }
    if (entry) {
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
    return has;
}

/* From window to window, each of which has the beginning of the one behind it,
 * as much as an entry may be long. */
static enum pel_err last_by_tag(struct pel_logfile *f, double *out, bool *found,
                                struct pel_fault *fault)
{
    const uint8_t *data;
    size_t size, most = WINDOW;
    const uint64_t end = f->size;
    for (uint64_t to = end; !*found && to > PEL_LOG_BEGIN_SIZE;) {
        size_t behind = end - to < LONGEST ? (size_t)(end - to) : LONGEST;
        size_t part = to - PEL_LOG_BEGIN_SIZE < most
                          ? (size_t)(to - PEL_LOG_BEGIN_SIZE)
                          : most;
        to -= part;
        enum pel_err err = make_room(f, part + behind, fault);
        err = err ? err : read_at(f, to, fault);
        if (err) {
            return err;
        }
        *found = pel_log_last(&f->reader, part, &data, &size) &&
                 time_of(data, size, out);
        most = LONGEST;
    }
    return PEL_OK;
}

static enum pel_err last_by_steps(struct pel_logfile *f, double *out,
                                  bool *found, struct pel_fault *fault)
{
    const uint8_t *data;
    size_t size, last_size = 0;
    uint64_t last = 0;
    enum pel_err err;
    pel_logfile_go(f, (struct pel_logfile_place){ .at = PEL_LOG_MAGIC_SIZE });
    while (!(err = fill(f, fault)) && pel_log_skip(&f->reader, &data, &size)) {
        last = f->reader.base + (uint64_t)(data - f->reader.data);
        last_size = size;
    }
    err = err ? err : make_room(f, last_size, fault);
    err = err ? err : read_at(f, last, fault);
    *found = !err && f->reader.size >= last_size &&
             time_of(f->reader.data, last_size, out);
    return err;
}

enum pel_err pel_logfile_last(struct pel_logfile *f, double *out,
                              struct pel_fault *fault)
{
    struct pel_logfile_place here = pel_logfile_place(f);
    bool found = false;
    enum pel_err err = f->reader.form < PEL_LOG_FORM
                           ? last_by_steps(f, out, &found, fault)
                           : last_by_tag(f, out, &found, fault);
    f->reader.size = 0; /* the window is another */
    pel_logfile_go(f, here);
    return err || found ? err
                        : pel_fault_set(fault, PEL_ERR_MALFORMED,
                                        "no entry of it is whole");
}

/* --- life ----------------------------------------------------------------- */

enum pel_err pel_logfile_open(const char *path, struct pel_logfile **out,
                              struct pel_fault *fault)
{
    int fd;
    *out = NULL;
    enum pel_err err = pel_file_open(path, &fd, fault);
    return err ? err : pel_logfile_take(fd, out, fault);
}

enum pel_err pel_logfile_take(int fd, struct pel_logfile **out,
                              struct pel_fault *fault)
{
    struct stat is;
    *out = NULL;
    struct pel_logfile *f = calloc(1, sizeof *f);
    if (!f) {
        close(fd);
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    f->fd = fd;
    f->size = fstat(fd, &is) == 0 ? (uint64_t)is.st_size : 0;
    enum pel_err err = make_room(f, WINDOW, fault);
    err = err ? err : read_at(f, 0, fault);
    err = err ? err : pel_log_open(&f->reader, f->bytes, f->reader.size, fault);
    if (err) {
        pel_logfile_close(f);
        return err;
    }
    *out = f;
    return PEL_OK;
}

void pel_logfile_close(struct pel_logfile *f)
{
    if (f) {
        close(f->fd);
        free(f->bytes);
        free(f);
    }
}
