#include "scene/journal.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/log.h"
#include "pelog.h"
#include "scene/check.h"
#include "scene/edit.h"
#include "scene/logentry.h"

#define AGAIN_NS 5000000000 /* after one that could not be begun */

struct pel_journal {
    char *path, *fresh; /* PATH.journal; the one to come */
    struct pel_worker *worker;
    int fd;            /* -1: nothing can be kept */
    size_t size;       /* bytes that are whole entries */
    bool unsynced;     /* since the last sync began */
    guint sync_timer;  /* 0: nothing to bring to the disk */
    GByteArray *since; /* entries since a new one is being begun; NULL: none */
    int64_t again_ns;  /* none is begun before */
    double step_s;     /* time of the last entry */
    bool broken;       /* it was said */
    bool lacks;        /* an edit that it could not take */
    bool cut;          /* so does `since` */
    uint64_t lost, turns;
};

static char *journal_name(const char *path)
{
    return g_strconcat(path, ".journal", NULL);
}

/* --- loading -------------------------------------------------------------- */

/* The edit as pel_scene_patch does it, without its files. */
static enum pel_err apply(Pelagos__State **state,
                          const Pelagos__LogEntry *entry,
                          struct pel_fault *fault)
{
    Pelagos__State *next;
    (*state)->clock->time = entry->time;
    enum pel_err err = pel_state_apply(*state, entry->patch, &next, fault);
    if (err) {
        return err;
    }
    next->revision = entry->revision;
    err = pel_state_check(next, fault);
    if (!err) {
        err = pel_sea_settle(next, fault);
    }
    pelagos__state__free_unpacked(err ? next : *state, NULL);
    if (!err) {
        *state = next;
    }
    return err;
}

/* Takes the state that the journal begins with where the state file has none
 * or an older one. */
static enum pel_err begin_with(Pelagos__State **state, Pelagos__LogHead *head,
                               struct pel_fault *fault)
{
    if (*state && (*state)->revision >= head->state->revision) {
        return PEL_OK;
    }
    pel_state_fill(head->state, head->state->clock->time);
    enum pel_err err = pel_state_check(head->state, fault);
    if (!err) {
        if (*state) {
            pelagos__state__free_unpacked(*state, NULL);
        }
        *state = head->state;
        head->state = NULL;
    }
    return err;
}

static enum pel_err take_entry(Pelagos__State **state, Pelagos__LogEntry *entry,
                               unsigned *edits, struct pel_fault *fault)
{
    if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD) {
        return begin_with(state, entry->head, fault);
    }
    bool patch = entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH;
    if (patch && entry->revision > (*state)->revision) {
        enum pel_err err = apply(state, entry, fault);
        *edits += !err;
        return err;
    }
    if (!patch && entry->revision == (*state)->revision &&
        entry->time > (*state)->clock->time) {
        (*state)->clock->time = entry->time;
        ++*edits;
    }
    return PEL_OK;
}

enum pel_err pel_journal_load(const char *path, Pelagos__State **state,
                              unsigned *edits, struct pel_fault *fault)
{
    char *bytes = NULL;
    size_t size = 0;
    g_autofree char *name = journal_name(path);
    struct pel_log_reader reader;
    Pelagos__LogEntry *entry;
    *edits = 0;
    enum pel_err err =
        pel_file_read(name, 2 * PEL_JOURNAL_MOST_BYTES, &bytes, &size, fault);
    if (err || size == 0) {
        free(bytes);
        return err == PEL_ERR_NOT_FOUND ? PEL_OK : err;
    }
    err = pel_log_open(&reader, bytes, size, fault);
    while (!err && !(err = pel_log_next(&reader, &entry, fault)) && entry) {
        err = take_entry(state, entry, edits, fault);
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
    free(bytes);
    return err == PEL_ERR_CONFLICT && reader.entries == 0 ? err
           : err                                          ? PEL_ERR_MALFORMED
                                                          : PEL_OK;
}

/* --- beginning ------------------------------------------------------------ */

static uint8_t *pack_head(const Pelagos__State *state, size_t *size)
{
    Pelagos__LogHead head = PELAGOS__LOG_HEAD__INIT;
    head.has_version = true;
    head.version = PEL_LOG_VERSION;
    head.state = (Pelagos__State *)state;
    return pel_log_pack_head(&head, size);
}

/* A journal of this head, with room for the others; -1: errno. Any thread. */
static int begin_file(const char *name, const uint8_t *head, size_t size)
{
    int fd = open(name,
                  O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_NOCTTY |
                      O_NONBLOCK | O_CLOEXEC,
                  0644);
    if (fd < 0) {
        return -1;
    }
    /* Not every file system can; then edits are kept while there is room. */
    int room =
        fallocate(fd, FALLOC_FL_KEEP_SIZE, 0, 2 * (off_t)PEL_JOURNAL_BYTES);
    bool full = room != 0 && errno == ENOSPC;
    if (full || !pel_file_write(fd, PEL_LOG_MAGIC, PEL_LOG_MAGIC_SIZE) ||
        !pel_file_write(fd, head, size) || fdatasync(fd) != 0) {
        int why = full ? ENOSPC : errno;
        close(fd);
        unlink(name);
        errno = why;
        return -1;
    }
    return fd;
}

static void say_broken(struct pel_journal *j, int why)
{
    j->again_ns = pel_now_ns() + AGAIN_NS;
    if (!j->broken) {
        pel_error("SCN-012",
                  "edits are not kept before they are in the state file, until "
                  "%s can be written: %s",
                  j->path, g_strerror(why));
    }
    j->broken = true;
}

/* Takes the new one, whose entries are those of its head. */
static void begun(struct pel_journal *j, int fd, size_t size)
{
    if (rename(j->fresh, j->path) != 0) {
        say_broken(j, errno);
        close(fd);
        return;
    }
    if (j->fd >= 0) {
        close(j->fd);
    }
    j->fd = fd;
    j->size = size;
    j->turns++;
    if (j->broken) {
        pel_info("SCN-013", "edits are kept again in %s", j->path);
    }
    j->broken = j->lacks = false;
}

struct pel_journal *pel_journal_create(const char *path,
                                       const Pelagos__State *state,
                                       struct pel_worker *worker)
{
    struct pel_journal *j = g_new0(struct pel_journal, 1);
    size_t size;
    uint8_t *head = pack_head(state, &size);
    j->path = journal_name(path);
    j->fresh = g_strconcat(j->path, ".new", NULL);
    j->worker = worker;
    j->step_s = state->clock->time;
    j->fd = -1;
    int fd = begin_file(j->fresh, head, size);
    if (fd < 0) {
        say_broken(j, errno);
    } else {
        begun(j, fd, PEL_LOG_MAGIC_SIZE + size);
    }
    free(head);
    return j;
}

/* --- anew ----------------------------------------------------------------- */

struct turn {
    struct pel_task task;
    struct pel_journal *journal;
    uint8_t *head;
    size_t size;
    int fd, why;
};

static void do_turn(struct pel_task *task)
{
    struct turn *t = (struct turn *)task;
    t->fd = begin_file(t->journal->fresh, t->head, t->size);
    t->why = errno;
}

static void turned(struct pel_task *task, bool dropped)
{
    struct turn *t = (struct turn *)task;
    struct pel_journal *j = t->journal;
    if (t->fd < 0 && !dropped) {
        say_broken(j, t->why);
    } else if (t->fd >= 0 && (j->cut || !pel_file_write(t->fd, j->since->data,
                                                        j->since->len))) {
        say_broken(j, j->cut ? ETIMEDOUT : errno);
        close(t->fd);
        unlink(j->fresh);
    } else if (t->fd >= 0) {
        begun(j, t->fd, PEL_LOG_MAGIC_SIZE + t->size + j->since->len);
    }
    g_byte_array_unref(j->since);
    j->since = NULL;
    free(t->head);
    g_free(t);
}

bool pel_journal_is_full(const struct pel_journal *j)
{
    return (j->fd < 0 || j->lacks || j->size >= PEL_JOURNAL_BYTES) &&
           !j->since && pel_now_ns() >= j->again_ns;
}

void pel_journal_turn(struct pel_journal *j, const Pelagos__State *state)
{
    struct turn *t = g_new0(struct turn, 1);
    t->task.work = do_turn;
    t->task.done = turned;
    t->journal = j;
    t->fd = -1;
    t->head = pack_head(state, &t->size);
    j->since = g_byte_array_new();
    j->cut = false;
    pel_worker_push(j->worker, &t->task);
}

/* --- to the disk ---------------------------------------------------------- */

struct sync {
    struct pel_task task;
    int fd;
};

static void do_sync(struct pel_task *task)
{
    (void)!fdatasync(((struct sync *)task)->fd);
}

static void synced(struct pel_task *task, bool dropped)
{
    (void)dropped;
    close(((struct sync *)task)->fd);
    g_free(task);
}

static gboolean on_sync_timer(gpointer user)
{
    struct pel_journal *j = user;
    if (j->unsynced && pel_worker_count(j->worker) > 0) {
        return G_SOURCE_CONTINUE; /* a disk that hangs gathers no tasks */
    }
    int fd = j->fd >= 0 ? fcntl(j->fd, F_DUPFD_CLOEXEC, 0) : -1;
    if (!j->unsynced) {
        j->sync_timer = 0;
    }
    if (j->unsynced && fd >= 0) {
        struct sync *s = g_new0(struct sync, 1);
        s->task.work = do_sync;
        s->task.done = synced;
        s->fd = fd;
        fd = -1;
        pel_worker_push(j->worker, &s->task);
    }
    if (fd >= 0) {
        close(fd);
    }
    j->unsynced = false;
    return j->sync_timer != 0;
}

/* --- adding --------------------------------------------------------------- */

static void stop(struct pel_journal *j, int why)
{
    say_broken(j, why);
    /* What is there of a torn entry goes, so that what follows can be read. */
    if (ftruncate(j->fd, (off_t)j->size) != 0) {
        close(j->fd);
        j->fd = -1;
    }
}

static void put(struct pel_journal *j, const uint8_t *data, size_t size)
{
    if (j->since && j->since->len + size <= PEL_JOURNAL_MOST_BYTES) {
        g_byte_array_append(j->since, data, (guint)size);
    } else if (j->since) {
        j->cut = true; /* a disk that hangs: what is gathered is of no use */
    }
    bool fits =
        j->fd >= 0 && !j->lacks && j->size + size <= PEL_JOURNAL_MOST_BYTES;
    if (!fits || !pel_file_write(j->fd, data, size)) {
        if (fits) {
            stop(j, errno);
        }
        j->lacks = true; /* what follows would lead elsewhere */
        j->lost++;
        return;
    }
    j->size += size;
    j->unsynced = true;
    if (j->sync_timer == 0) {
        j->sync_timer = g_timeout_add(PEL_JOURNAL_SYNC_MS, on_sync_timer, j);
    }
}

void pel_journal_add(struct pel_journal *j, double time_s,
                     const Pelagos__Patch *patch, const Pelagos__State *state)
{
    size_t size;
    uint8_t *data;
    if (patch) {
        data = pel_log_pack_patch(time_s, state->revision, patch, &size);
    } else if (pel_log_wants_step(state->clock->mode ==
                                      PELAGOS__CLOCK_MODE__STEPPED,
                                  time_s, j->step_s)) {
        data = pel_log_pack_step(time_s, state->revision, &size);
    } else {
        return;
    }
    j->step_s = time_s;
    put(j, data, size);
    free(data);
}

void pel_journal_remove(const char *path)
{
    g_autofree char *name = journal_name(path);
    unlink(name);
}

/* --- the end -------------------------------------------------------------- */

bool pel_journal_close(struct pel_journal *j, bool saved)
{
    if (!j) {
        return true;
    }
    bool whole = saved;
    if (j->sync_timer != 0) {
        g_source_remove(j->sync_timer);
    }
    if (j->fd >= 0) {
        whole = whole || (!j->lacks && fdatasync(j->fd) == 0);
        close(j->fd);
    }
    if (saved) {
        unlink(j->path);
    }
    g_free(j->fresh);
    g_free(j->path);
    g_free(j);
    return whole;
}

void pel_journal_collect(const struct pel_journal *j,
                         struct pel_metrics_page *page)
{
    pel_metric(page, "pelagos_scene_journal_bytes", PEL_METRIC_GAUGE,
               "Bytes of the journal of edits.", NULL, (double)j->size);
    pel_metric(page, "pelagos_scene_journal_lost_total", PEL_METRIC_COUNTER,
               "Edits that took effect and that the journal could not keep.",
               NULL, (double)j->lost);
}
