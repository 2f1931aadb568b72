#include "scene/record.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "pelog.h"
#include "wire.h"

#define MAX_KEPT 999
#define MIB 1048576.0
/* Steps that frames or a host make are written so often [simulated s]; those
 * of clients all are. */
#define STEP_INTERVAL_S 0.1

struct pel_record {
    struct pel_scene *scene;
    char *path;
    int fd; /* -1: the recording has ended */
    double limit;
    uint64_t size; /* bytes that are whole entries */
    uint64_t entries, lost;
    double step_s; /* time of the last entry */
};

/* --- writing -------------------------------------------------------------- */

static void stop(struct pel_record *record, const char *why)
{
    pel_error("REC-002", "%s: recording ended after %llu entries: %s",
              record->path, (unsigned long long)record->entries, why);
    /* What is there of a torn entry goes, so that the log stays readable. */
    if (ftruncate(record->fd, (off_t)record->size) != 0) {
        pel_warn("REC-003", "%s may end with part of an entry", record->path);
    }
    close(record->fd);
    record->fd = -1;
}

/* One write a message: what has been accepted is in the file even if the
 * process is killed the next moment. */
static bool put(struct pel_record *record, const uint8_t *data, size_t size)
{
    size_t done = 0;
    if ((double)(record->size + size) > record->limit) {
        stop(record, "the limit of its size is reached");
        return false;
    }
    while (done < size) {
        ssize_t n = write(record->fd, data + done, size - done);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            stop(record, n < 0 ? strerror(errno) : "nothing is written");
            return false;
        }
        done += (size_t)n;
    }
    record->size += size;
    return true;
}

static void put_entry(struct pel_record *record, Pelagos__LogEntry *entry)
{
    size_t size;
    if (record->fd < 0) {
        record->lost++;
        return;
    }
    uint8_t *data = pel_wire_pack(&entry->base, &size);
    bool done = false;
    if (size > PEL_LOG_MAX_ENTRY) {
        stop(record, "a command is too large for a log");
    } else {
        done = put(record, data, size);
    }
    record->entries += done;
    record->lost += !done;
    free(data);
}

static void fill(struct pel_record *record, double time_s, uint64_t revision,
                 Pelagos__LogEntry *entry)
{
    pelagos__log_entry__init(entry);
    entry->has_time = entry->has_revision = true;
    entry->time = time_s;
    entry->revision = revision;
    record->step_s = time_s;
}

static void put_step(struct pel_record *record, double time_s,
                     uint64_t revision)
{
    Pelagos__LogEntry entry;
    Pelagos__ClockStep step = PELAGOS__CLOCK_STEP__INIT;
    fill(record, time_s, revision, &entry);
    step.has_until = true;
    step.until = time_s;
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_STEP;
    entry.step = &step;
    put_entry(record, &entry);
}

static void on_command(void *user, double time_s, const Pelagos__Patch *patch)
{
    struct pel_record *record = user;
    const Pelagos__State *state = pel_scene_state(record->scene);
    if (patch) {
        Pelagos__LogEntry entry;
        fill(record, time_s, state->revision, &entry);
        entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_PATCH;
        entry.patch = (Pelagos__Patch *)patch;
        put_entry(record, &entry);
    } else if (state->clock->mode == PELAGOS__CLOCK_MODE__STEPPED ||
               time_s - record->step_s >= STEP_INTERVAL_S ||
               time_s < record->step_s) {
        put_step(record, time_s, state->revision);
    }
}

/* --- life ----------------------------------------------------------------- */

static void put_head(struct pel_record *record,
                     const struct pel_record_options *o,
                     const Pelagos__State *state)
{
    Pelagos__LogEntry entry;
    Pelagos__LogHead head = PELAGOS__LOG_HEAD__INIT;
    char began[32];
    time_t now = time(NULL);
    struct tm utc;
    gmtime_r(&now, &utc);
    strftime(began, sizeof began, "%Y-%m-%dT%H:%M:%SZ", &utc);
    pelagos__log_entry__init(&entry);
    entry.has_time = entry.has_revision = true;
    entry.time = record->step_s = state->clock->time;
    entry.revision = state->revision;
    head.has_version = head.has_waves = true;
    head.version = PEL_LOG_VERSION;
    head.waves = (uint32_t)o->wave_count;
    head.program = (char *)o->program;
    head.device = (char *)o->device;
    head.began = began;
    head.state = (Pelagos__State *)state;
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_HEAD;
    entry.head = &head;
    put_entry(record, &entry);
}

/* Gives an earlier log a name of its own. */
static enum pel_err keep(const char *path, struct pel_fault *fault)
{
    if (access(path, F_OK) != 0) {
        return PEL_OK;
    }
    for (int i = 1; i <= MAX_KEPT; i++) {
        g_autofree char *other = g_strdup_printf("%s.%d", path, i);
        if (renameat2(AT_FDCWD, path, AT_FDCWD, other, RENAME_NOREPLACE) == 0) {
            pel_info("REC-004", "the log that was there is kept as %s", other);
            return PEL_OK;
        }
        if (errno != EEXIST) {
            return pel_fault_set(fault, PEL_ERR_IO, "--record: %s: %s", other,
                                 strerror(errno));
        }
    }
    return pel_fault_set(fault, PEL_ERR_CONFLICT,
                         "--record: %s and its numbers up to %d are there; "
                         "take some away",
                         path, MAX_KEPT);
}

enum pel_err pel_record_create(const struct pel_record_options *o,
                               struct pel_scene *scene, struct pel_record **out,
                               struct pel_fault *fault)
{
    *out = NULL;
    enum pel_err err = keep(o->path, fault);
    if (err) {
        return err;
    }
    int fd =
        open(o->path, O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0640);
    if (fd < 0) {
        return pel_fault_set(fault, PEL_ERR_IO, "--record: %s: %s", o->path,
                             strerror(errno));
    }
    struct pel_record *record = g_new0(struct pel_record, 1);
    record->scene = scene;
    record->path = g_strdup(o->path);
    record->fd = fd;
    record->limit = o->limit_mib * MIB;
    if (put(record, (const uint8_t *)PEL_LOG_MAGIC, PEL_LOG_MAGIC_SIZE)) {
        put_head(record, o, pel_scene_listen(scene, on_command, record));
    }
    if (record->fd < 0) {
        pel_record_destroy(record);
        return pel_fault_set(fault, PEL_ERR_IO,
                             "--record: %s cannot be written", o->path);
    }
    pel_info("REC-001", "recording to %s", o->path);
    *out = record;
    return PEL_OK;
}

void pel_record_destroy(struct pel_record *record)
{
    if (!record) {
        return;
    }
    (void)pel_scene_listen(record->scene, NULL, NULL);
    if (record->fd >= 0) {
        const Pelagos__State *state = pel_scene_state(record->scene);
        put_step(record, state->clock->time, state->revision);
    }
    if (record->fd >= 0) {
        if (fdatasync(record->fd) != 0) {
            pel_warn("REC-005", "%s: %s", record->path, strerror(errno));
        }
        close(record->fd);
    }
    g_free(record->path);
    g_free(record);
}

void pel_record_collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_record *record = user;
    pel_metric(page, "pelagos_record_entries_total", PEL_METRIC_COUNTER,
               "Commands written to the command log.", NULL,
               (double)record->entries);
    pel_metric(page, "pelagos_record_lost_total", PEL_METRIC_COUNTER,
               "Commands that came after the recording had ended.", NULL,
               (double)record->lost);
    pel_metric(page, "pelagos_record_bytes", PEL_METRIC_GAUGE,
               "Bytes of the command log.", NULL, (double)record->size);
    pel_metric(page, "pelagos_record_active", PEL_METRIC_GAUGE,
               "1 while commands are recorded, 0 after a failure.", NULL,
               record->fd >= 0);
}
