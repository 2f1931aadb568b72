#include "scene/record.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/log.h"
#include "base/trial.h"
#include "pelog.h"
#include "scene/logentry.h"

#define MIB 1048576.0
#define MAX_NUMBER 999999999u
#define MOST_CLOSED 500 /* files, however short */

struct pel_record {
    struct pel_scene *scene;
    struct pel_sealedlog *sealed; /* NULL: the scene is recorded */
    char *path, *program, *device;
    int wave_count;
    char *recording; /* what its segments have in common */
    uint32_t segment;
    unsigned keep, next_number; /* of PATH.NNNNNN */
    double keep_days;           /* 0: however old */
    int fd;                     /* -1: nothing is written at present */
    struct pel_log_writer writer;
    double limit;
    uint64_t size, head_size; /* bytes that are whole entries; of the first */
    uint64_t entries, lost, begun, removed;
    int64_t pause_ns, again_ns; /* no new segment is tried before */
    double step_s;              /* time of the last entry */
    bool waits; /* for the first whole state of what is sealed */
};

/* --- writing -------------------------------------------------------------- */

static void pause_recording(struct pel_record *record, const char *why)
{
    pel_error("REC-002",
              "%s: not recording, after %llu entries, until a new segment can "
              "be begun: %s",
              record->path, (unsigned long long)record->entries, why);
    /* What is there of a torn entry goes, so that the log stays readable. */
    if (ftruncate(record->fd, (off_t)record->size) != 0) {
        pel_warn("REC-003", "%s may end with part of an entry", record->path);
    }
    close(record->fd);
    record->fd = -1;
    record->again_ns = pel_now_ns() + record->pause_ns;
}

/* One write a message: what has been accepted is in the file even if the
 * process is killed the next moment. */
static bool put(struct pel_record *record, const uint8_t *data, size_t size)
{
    size_t framed_size;
    uint8_t *framed = pel_log_frame(&record->writer, data, size, &framed_size);
    bool good = pel_file_write(record->fd, framed, framed_size);
    int why = errno;
    free(framed);
    if (!good) {
        pause_recording(record, strerror(why));
        return false;
    }
    record->size += framed_size;
    return true;
}

/* An entry of simulated time time_s; frees it. */
static void put_entry(struct pel_record *record, double time_s, uint8_t *data,
                      size_t size)
{
    bool done = false;
    record->step_s = time_s;
    if (record->fd >= 0 && size > PEL_LOG_MAX_ENTRY) {
        pause_recording(record, "a command is too large for a log");
    } else if (record->fd >= 0) {
        done = put(record, data, size);
    }
    record->entries += done;
    record->lost += !done;
    free(data);
}

static void put_step(struct pel_record *record, double time_s,
                     uint64_t revision)
{
    size_t size;
    uint8_t *data = pel_log_pack_step(time_s, revision, &size);
    put_entry(record, time_s, data, size);
}

/* --- segments ------------------------------------------------------------- */

static char *numbered(const struct pel_record *record, unsigned number)
{
    return g_strdup_printf("%s.%06u", record->path, number);
}

/* The number of a file named as our closed segments are; 0: it is not. */
static unsigned number_of(const char *name, const char *base)
{
    size_t length = strlen(base);
    if (strncmp(name, base, length) != 0 || name[length] != '.') {
        return 0;
    }
    const char *digits = name + length + 1;
    size_t count = strspn(digits, "0123456789");
    if (count < 6 || count > 9 || digits[count] != '\0') {
        return 0;
    }
    return (unsigned)strtoul(digits, NULL, 10);
}

/* A closed segment. */
struct closed {
    unsigned number;
    double bytes;
    time_t ended;
};

static int rising(const void *a, const void *b)
{
    const struct closed *x = a, *y = b;
    return (x->number > y->number) - (x->number < y->number);
}

/* The closed segments that are there, by rising numbers. */
static GArray *closed_ones(const struct pel_record *record)
{
    GArray *found = g_array_new(FALSE, FALSE, sizeof(struct closed));
    g_autofree char *folder = g_path_get_dirname(record->path);
    g_autofree char *base = g_path_get_basename(record->path);
    GDir *dir = g_dir_open(folder, 0, NULL);
    const char *name;
    while (dir && (name = g_dir_read_name(dir))) {
        struct closed one = { .number = number_of(name, base) };
        g_autofree char *path = g_build_filename(folder, name, NULL);
        struct stat is;
        if (one.number > 0 && lstat(path, &is) == 0) {
            one.bytes = (double)is.st_size;
            one.ended = is.st_mtime;
            g_array_append_val(found, one);
        }
    }
    if (dir) {
        g_dir_close(dir);
    }
    g_array_sort(found, rising);
    return found;
}

static void remove_one(struct pel_record *record, GArray *found, unsigned i)
{
    g_autofree char *name =
        numbered(record, g_array_index(found, struct closed, i).number);
    if (unlink(name) == 0) {
        record->removed++;
    } else {
        static struct pel_log_limit limit;
        pel_log_limited(&limit, PEL_LOG_WARNING, "REC-006",
                        "%s, an old segment, could not be removed: %s", name,
                        strerror(errno));
    }
    g_array_remove_index(found, i);
}

/* The part of a full segment that is used, 0 to 1. */
static double share_of(const struct pel_record *record, const GArray *found,
                       unsigned i)
{
    return fmin(g_array_index(found, struct closed, i).bytes / record->limit,
                1);
}

static unsigned shortest(const GArray *found)
{
    unsigned least = 0;
    for (unsigned i = 1; i < found->len; i++) {
        if (g_array_index(found, struct closed, i).bytes <
            g_array_index(found, struct closed, least).bytes) {
            least = i;
        }
    }
    return least;
}

/* By bytes: the oldest goes when what is left is as many full segments as are
 * to be kept, so that a short one, as a crash leaves it, makes nobody go. By
 * age, where that is bounded. Where there are too many files the shortest one
 * goes. */
static void remove_old(struct pel_record *record)
{
    GArray *found = closed_ones(record);
    double sum = 1; /* the one that is written */
    time_t from = time(NULL) - (time_t)(86400 * record->keep_days);
    for (unsigned i = 0; i < found->len; i++) {
        sum += share_of(record, found, i);
    }
    while (found->len > 0) {
        double share = share_of(record, found, 0);
        bool old = record->keep_days > 0 &&
                   g_array_index(found, struct closed, 0).ended < from;
        if (!old && sum - share < record->keep) {
            break;
        }
        sum -= share;
        remove_one(record, found, 0);
    }
    while (found->len > MOST_CLOSED) {
        remove_one(record, found, shortest(found));
    }
    g_array_free(found, TRUE);
}

static uint8_t *pack_head(const struct pel_record *record,
                          const Pelagos__State *state, size_t *size)
{
    Pelagos__LogHead head = PELAGOS__LOG_HEAD__INIT;
    char began[32];
    time_t now = time(NULL);
    struct tm utc;
    gmtime_r(&now, &utc);
    strftime(began, sizeof began, "%Y-%m-%dT%H:%M:%SZ", &utc);
    head.has_version = head.has_waves = head.has_segment = true;
    head.version = record->sealed ? PEL_LOG_VERSION_STATES : PEL_LOG_VERSION;
    head.waves = (uint32_t)record->wave_count;
    head.program = record->program;
    head.device = record->device;
    head.began = began;
    head.recording = record->recording;
    head.segment = record->segment;
    head.state = (Pelagos__State *)state;
    return pel_log_pack_head(&head, size);
}

static bool write_head(const struct pel_record *record, int fd,
                       const Pelagos__State *state,
                       struct pel_log_writer *writer, uint64_t *total)
{
    size_t size, framed_size;
    uint8_t first[PEL_LOG_BEGIN_SIZE];
    uint8_t *head = pack_head(record, state, &size);
    bool good = size <= PEL_LOG_MAX_ENTRY;
    pel_log_begin(writer, first);
    uint8_t *framed = pel_log_frame(writer, head, size, &framed_size);
    errno = EFBIG;
    good = good && pel_file_write(fd, first, sizeof first);
    good = good && pel_file_write(fd, framed, framed_size);
    int why = errno;
    *total = sizeof first + framed_size;
    free(framed);
    free(head);
    errno = why;
    return good;
}

/* Gives what is at PATH the next number, and PATH to the new segment. */
static bool exchange(struct pel_record *record, const char *name)
{
    while (record->next_number <= MAX_NUMBER) {
        g_autofree char *closed = numbered(record, record->next_number);
        if (renameat2(AT_FDCWD, record->path, AT_FDCWD, closed,
                      RENAME_NOREPLACE) == 0) {
            record->next_number++;
            break;
        }
        if (errno == ENOENT) {
            break;
        }
        if (errno != EEXIST) {
            return false;
        }
        record->next_number++;
    }
    return rename(name, record->path) == 0;
}

static void on_command(void *user, double time_s, const Pelagos__Patch *patch);

/* The state that a segment begins with. */
static const Pelagos__State *begin_state(struct pel_record *record)
{
    return record->sealed ? pel_sealedlog_head(record->sealed)
                          : pel_scene_listen(record->scene, on_command, record);
}

static void say_begun(const struct pel_record *record)
{
    pel_info("REC-001", "recording %s to %s", record->recording, record->path);
}

/* With errno. */
static void say_not_begun(const struct pel_record *record)
{
    pel_error("REC-009",
              "%s: not recording until the first segment can be begun: %s",
              record->path, strerror(errno));
}

/* Begins segment `segment` with the whole state. False, with errno:
 * the one before is as it was. */
static bool begin_segment(struct pel_record *record, uint32_t segment)
{
    g_autofree char *name = g_strconcat(record->path, ".new", NULL);
    unlink(name); /* left by a process killed in the middle of this */
    int fd =
        open(name, O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0640);
    if (fd < 0) {
        return false;
    }
    (void)flock(fd, LOCK_EX | LOCK_NB); /* see check_place */
    const Pelagos__State *state = begin_state(record);
    uint32_t before = record->segment;
    uint64_t size;
    struct pel_log_writer writer;
    record->segment = segment;
    if (!write_head(record, fd, state, &writer, &size) ||
        !exchange(record, name)) {
        int why = errno;
        record->segment = before;
        close(fd);
        unlink(name);
        errno = why;
        return false;
    }
    if (record->fd >= 0) {
        close(record->fd);
    }
    record->fd = fd;
    record->writer = writer;
    record->size = record->head_size = size;
    record->step_s = state->clock->time;
    record->waits = false;
    record->begun++;
    record->entries++;
    remove_old(record);
    return true;
}

/* The next segment when this one is full. It is twice its head at least, so
 * that a large state is not written with every command. Where it cannot be
 * begun this one goes on, for as much again. */
static void turn(struct pel_record *record)
{
    double full = fmax(record->limit, 2 * (double)record->head_size);
    if (record->fd < 0 || (double)record->size < full) {
        return;
    }
    if (pel_now_ns() >= record->again_ns) {
        if (begin_segment(record, record->segment + 1)) {
            return;
        }
        pel_warn("REC-007", "%s: no new segment: %s", record->path,
                 strerror(errno));
        record->again_ns = pel_now_ns() + record->pause_ns;
    }
    if ((double)record->size >= 2 * full) {
        pause_recording(record, "no new segment can be begun");
    }
}

/* What a pause has lost shows as a missing number. One that has waited for the
 * exercise has lost nothing. */
static void resume(struct pel_record *record)
{
    if (record->fd >= 0 || pel_now_ns() < record->again_ns) {
        return;
    }
    bool first = record->waits;
    if (!begin_segment(record, record->segment + (first ? 1 : 2))) {
        if (first) {
            say_not_begun(record);
        }
        record->again_ns = pel_now_ns() + record->pause_ns;
    } else if (first) {
        say_begun(record);
    } else {
        pel_info("REC-008", "recording again to %s, segment %u", record->path,
                 record->segment);
    }
}

static void on_command(void *user, double time_s, const Pelagos__Patch *patch)
{
    struct pel_record *record = user;
    const Pelagos__State *state = pel_scene_state(record->scene);
    if (patch) {
        size_t size;
        uint8_t *data =
            pel_log_pack_patch(time_s, state->revision, patch, &size);
        put_entry(record, time_s, data, size);
    } else if (pel_log_wants_step(state->clock->mode ==
                                      PELAGOS__CLOCK_MODE__STEPPED,
                                  time_s, record->step_s)) {
        put_step(record, time_s, state->revision);
    }
    resume(record);
    turn(record);
}

/* --- what is sealed ------------------------------------------------------- */

static void on_entries(void *user, const uint8_t *bytes, size_t size,
                       unsigned count)
{
    struct pel_record *record = user;
    bool done = record->fd >= 0 && put(record, bytes, size);
    record->entries += done ? count : 0;
    record->lost += done ? 0 : count;
}

/* A segment that is full ends before the state; but not where frames are
 * missing, which is told by the state's entry. */
static void on_anew(void *user, uint64_t missed)
{
    struct pel_record *record = user;
    const Pelagos__State *state = pel_sealedlog_head(record->sealed);
    uint64_t begun = record->begun;
    if (missed == 0) {
        turn(record);
    }
    if (record->fd >= 0 && record->begun == begun) {
        size_t size;
        uint8_t *data = pel_log_pack_state(state, missed, &size);
        put_entry(record, state->clock->time, data, size);
    }
    resume(record);
}

static void listen_sealed(struct pel_record *record)
{
    const struct pel_sealedlog_listener listener = { on_entries, on_anew,
                                                     record };
    pel_sealedlog_listen(record->sealed, &listener);
}

/* With the last whole state, and what has come since; where there is none yet,
 * with the first one. */
static bool begin_sealed(struct pel_record *record)
{
    size_t size;
    unsigned count;
    record->waits = !pel_sealedlog_head(record->sealed);
    if (!record->waits && !begin_segment(record, 1)) {
        return false;
    }
    const uint8_t *since = pel_sealedlog_since(record->sealed, &size, &count);
    if (size > 0) {
        on_entries(record, since, size, count);
    }
    listen_sealed(record);
    return true;
}

static void end_sealed(struct pel_record *record)
{
    uint64_t revision;
    pel_sealedlog_listen(record->sealed, NULL);
    if (record->fd >= 0) {
        double time_s = pel_sealedlog_time(record->sealed, &revision);
        put_step(record, time_s, revision);
    }
}

/* --- life ----------------------------------------------------------------- */

/* Or the beginning of one. */
static bool is_log(const char *bytes, size_t size)
{
    return memcmp(bytes, PEL_LOG_MAGIC, size) == 0 ||
           memcmp(bytes, PEL_LOG_MAGIC_BEFORE, size) == 0;
}

/* What is at PATH gets a number: only a log, and none that another daemon is
 * writing, which has it locked. */
static enum pel_err check_place(const char *path, struct pel_fault *fault)
{
    int fd;
    struct pel_fault why;
    char magic[PEL_LOG_MAGIC_SIZE];
    enum pel_err err = pel_file_open(path, &fd, &why);
    if (err) {
        return err == PEL_ERR_NOT_FOUND
                   ? PEL_OK
                   : pel_fault_set(fault, err, "--record: %s", why.message);
    }
    bool taken = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    ssize_t size = read(fd, magic, sizeof magic);
    close(fd);
    if (taken) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "--record: another daemon records to %.160s; end "
                             "it, or name another file",
                             path);
    }
    return size > 0 && !is_log(magic, (size_t)size)
               ? pel_fault_set(fault, PEL_ERR_INVALID,
                               "--record: %.160s is no log of commands; name "
                               "another file",
                               path)
               : PEL_OK;
}

enum pel_err pel_record_create(const struct pel_record_options *o,
                               struct pel_scene *scene, struct pel_record **out,
                               struct pel_fault *fault)
{
    struct pel_record *record = g_new0(struct pel_record, 1);
    *out = NULL;
    record->scene = scene;
    record->sealed = o->sealed;
    record->path = g_strdup(o->path);
    record->program = g_strdup(o->program);
    record->device = g_strdup(o->device);
    record->recording = g_uuid_string_random();
    record->wave_count = o->wave_count;
    record->limit = o->segment_mib * MIB;
    record->keep = o->keep;
    record->keep_days = o->keep_days;
    record->pause_ns = (int64_t)(o->again_s * 1e9);
    record->fd = -1;
    GArray *found = closed_ones(record);
    record->next_number =
        found->len > 0
            ? g_array_index(found, struct closed, found->len - 1).number + 1
            : 1;
    g_array_free(found, TRUE);
    enum pel_err err = check_place(o->path, fault);
    if (pel_trial()) {
        err = err ? err : pel_trial_write("record", o->path, fault);
        pel_record_destroy(record);
        return err;
    }
    bool begun = !err && (record->sealed ? begin_sealed(record)
                                         : begin_segment(record, 1));
    if (!err && !begun && (errno == ENOSPC || errno == EDQUOT)) {
        /* A full disk keeps nobody from starting. */
        say_not_begun(record);
        record->again_ns = pel_now_ns() + record->pause_ns;
        if (record->sealed) {
            listen_sealed(record);
        }
    } else if (!err && !begun) {
        err = pel_fault_set(fault, PEL_ERR_IO, "--record: %s: %s", o->path,
                            strerror(errno));
    }
    if (err) {
        pel_record_destroy(record);
        return err;
    }
    if (record->waits) {
        pel_info("REC-011", "%s: recording begins when this node takes part",
                 o->path);
    } else if (begun) {
        say_begun(record);
    }
    *out = record;
    return PEL_OK;
}

int pel_record_end(struct pel_record *record)
{
    if (record->sealed) {
        end_sealed(record);
    } else {
        (void)pel_scene_listen(record->scene, NULL, NULL);
    }
    if (record->fd >= 0 && !record->sealed) {
        const Pelagos__State *state = pel_scene_state(record->scene);
        put_step(record, state->clock->time, state->revision);
    }
    int fd = record->fd;
    g_free(record->recording);
    g_free(record->program);
    g_free(record->device);
    g_free(record->path);
    g_free(record);
    return fd;
}

void pel_record_destroy(struct pel_record *record)
{
    if (!record) {
        return;
    }
    g_autofree char *path = g_strdup(record->path);
    int fd = pel_record_end(record);
    if (fd >= 0) {
        if (fdatasync(fd) != 0) {
            pel_warn("REC-005", "%s may lack its last entries on the disk: %s",
                     path, strerror(errno));
        }
        close(fd);
    }
}

void pel_record_collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_record *record = user;
    pel_metric(page, "pelagos_record_entries_total", PEL_METRIC_COUNTER,
               "Commands written to the command log.", NULL,
               (double)record->entries);
    pel_metric(page, "pelagos_record_lost_total", PEL_METRIC_COUNTER,
               "Commands that came while nothing could be written.", NULL,
               (double)record->lost);
    pel_metric(page, "pelagos_record_bytes", PEL_METRIC_GAUGE,
               "Bytes of the segment that is written.", NULL,
               (double)record->size);
    pel_metric(page, "pelagos_record_segments_total", PEL_METRIC_COUNTER,
               "Segments of the command log that were begun.", NULL,
               (double)record->begun);
    pel_metric(page, "pelagos_record_removed_total", PEL_METRIC_COUNTER,
               "Old segments that made room.", NULL, (double)record->removed);
    pel_metric(page, "pelagos_record_active", PEL_METRIC_GAUGE,
               "1 while commands are recorded, 0 after a failure.", NULL,
               record->fd >= 0);
}
