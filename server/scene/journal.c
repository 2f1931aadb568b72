#include "scene/journal.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/aside.h"
#include "base/clock.h"
#include "base/file.h"
#include "base/log.h"
#include "base/trial.h"
#include "pelog.h"
#include "scene/check.h"
#include "scene/edit.h"
#include "scene/logentry.h"

#define AGAIN_NS 5000000000 /* after one that could not be begun */

struct pel_journal {
    char *path, *fresh; /* PATH.journal; the one to come */
    char *lineage;      /* of the state file that it is beside */
    struct pel_worker *worker;
    struct pel_journal_cares cares;
    struct pel_log_writer writer;
    int fd;            /* -1: nothing can be kept */
    size_t size;       /* bytes that are whole entries */
    size_t room;       /* that the disk has promised */
    size_t limit;      /* it restarts there */
    bool unsynced;     /* since the last sync began */
    guint sync_timer;  /* 0: nothing to bring to the disk */
    guint again_timer; /* 0: nothing is wrong */
    GByteArray *since; /* entries since a new one is being begun; NULL: none */
    int64_t again_ns;  /* none is begun before */
    double step_s;     /* time of the last entry */
    int why;           /* errno of what is wrong; 0: nothing is */
    bool refuses;      /* the last edit did not fit */
    bool lacks;        /* an edit that took effect */
    bool cut;          /* so does `since` */
    uint64_t lost, refused, turns;
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

static void take_patch(Pelagos__State **state, const Pelagos__LogEntry *entry,
                       struct pel_journal_found *found)
{
    struct pel_fault why;
    if (apply(state, entry, &why)) {
        if (found->unfit == 0) {
            g_strlcpy(found->reason, why.message, sizeof found->reason);
        }
        found->unfit++;
    } else {
        found->edits++;
    }
}

static void take_entry(Pelagos__State **state, Pelagos__LogEntry *entry,
                       struct pel_journal_found *found)
{
    struct pel_fault why;
    if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD) {
        if (begin_with(state, entry->head, &why)) {
            g_strlcpy(found->reason, why.message, sizeof found->reason);
            found->unfit++;
        }
        return;
    }
    if (!*state) {
        found->unfit++; /* nothing that it could be an edit of */
        return;
    }
    bool patch = entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH;
    if (patch && entry->revision > (*state)->revision) {
        take_patch(state, entry, found);
    } else if (!patch && entry->revision == (*state)->revision &&
               entry->time > (*state)->clock->time) {
        (*state)->clock->time = entry->time;
        found->edits++;
    }
}

/* Whether the head says that it is of another state file. */
static bool is_foreign(const Pelagos__LogEntry *entry, const char *lineage)
{
    return entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD && lineage &&
           entry->head->recording && *entry->head->recording &&
           strcmp(entry->head->recording, lineage) != 0;
}

/* In numbers; what follows a loss is used, so its place says where to look. */
static void say_what_is_lost(struct pel_journal_found *found,
                             const struct pel_log_damage *d)
{
    GString *out = g_string_new(NULL);
    if (found->foreign) {
        g_string_append(out, "it is of another state file; nothing of it is "
                             "used");
    } else {
        g_string_append_printf(out, "%u edits of it are used", found->edits);
        if (d->lost > 0 || d->more) {
            g_string_append_printf(out, ", %u are lost%s", d->lost,
                                   d->more ? " and perhaps more" : "");
        }
        if (d->places > 0) {
            g_string_append_printf(
                out, ", %zu bytes in %u %s are damaged, first at byte %zu (%s)",
                d->bytes, d->places, d->places == 1 ? "place" : "places", d->at,
                d->reason);
        }
        if (d->twice > 0) {
            g_string_append_printf(out, ", %u entries are there twice",
                                   d->twice);
        }
        if (found->unfit > 0) {
            g_string_append_printf(out, ", %u do not apply (%s)", found->unfit,
                                   *found->reason ? found->reason
                                                  : "no state before them");
        }
    }
    g_strlcpy(found->words, out->str, sizeof found->words);
    g_string_free(out, TRUE);
}

/* Reads the journal into *state and *found. CONFLICT: of a newer version. */
static enum pel_err take_all(const void *bytes, size_t size,
                             const char *lineage, Pelagos__State **state,
                             struct pel_journal_found *found,
                             struct pel_log_reader *reader,
                             struct pel_fault *fault)
{
    Pelagos__LogEntry *entry;
    enum pel_err err = pel_log_mend(reader, bytes, size, fault);
    while (!err && !found->foreign &&
           !(err = pel_log_next(reader, &entry, fault)) && entry) {
        found->foreign = is_foreign(entry, lineage);
        if (!found->foreign) {
            take_entry(state, entry, found);
        }
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
    return err;
}

enum pel_err pel_journal_load(const char *path, const char *lineage,
                              Pelagos__State **state,
                              struct pel_journal_found *found,
                              struct pel_fault *fault)
{
    char *bytes = NULL;
    size_t size = 0;
    g_autofree char *name = journal_name(path);
    struct pel_log_reader reader = { 0 };
    *found = (struct pel_journal_found){ 0 };
    enum pel_err err =
        pel_file_read(name, 2 * PEL_JOURNAL_MOST_BYTES, &bytes, &size, fault);
    if (err) {
        return err == PEL_ERR_NOT_FOUND ? PEL_OK : err;
    }
    err = take_all(bytes, size, lineage, state, found, &reader, fault);
    if (err == PEL_ERR_MALFORMED) {
        g_strlcpy(reader.damage.reason, fault->message,
                  sizeof reader.damage.reason);
        reader.damage.places = 1;
        reader.damage.bytes = size;
        reader.damage.more = true;
        err = PEL_OK;
    }
    const struct pel_log_damage *d = &reader.damage;
    if (!err &&
        (d->places > 0 || d->lost > 0 || found->unfit > 0 || found->foreign)) {
        found->damaged = true;
        found->lost = d->lost;
        say_what_is_lost(found, d);
        found->kept = pel_trial() ? g_strconcat(name, ".bad", NULL)
                                  : pel_aside_keep(name, ".bad");
    } else if (!err && reader.form == PEL_LOG_FORM) {
        found->may_go_on = true;
        found->size = reader.at;
        memcpy(found->writer.tag, reader.tag, sizeof reader.tag);
        found->writer.count = reader.number;
    }
    free(bytes);
    return err;
}

/* --- beginning ------------------------------------------------------------ */

static uint8_t *pack_head(const struct pel_journal *j,
                          const Pelagos__State *state, size_t *size)
{
    Pelagos__LogHead head = PELAGOS__LOG_HEAD__INIT;
    head.has_version = true;
    head.version = PEL_LOG_VERSION;
    head.recording = j->lineage;
    head.state = (Pelagos__State *)state;
    return pel_log_pack_head(&head, size);
}

/* A new journal before it is the one of its name. */
struct begun {
    int fd, why;
    struct pel_log_writer writer;
    size_t size, room;
};

/* Bytes that a file may have. */
static size_t most_bytes(void)
{
    struct rlimit most;
    return getrlimit(RLIMIT_FSIZE, &most) == 0 &&
                   most.rlim_cur < PEL_JOURNAL_MOST_BYTES
               ? (size_t)most.rlim_cur
               : PEL_JOURNAL_MOST_BYTES;
}

/* Has the disk promise room for a journal: all of it, or as much as there is.
 * What it cannot promise, as a file system may not, is hoped for. 0: full. */
static size_t reserve(int fd, size_t head)
{
    size_t most = most_bytes();
    size_t want = MIN(most, 2 * (size_t)PEL_JOURNAL_BYTES + head);
    errno = EFBIG;
    for (; want >= head + PEL_JOURNAL_LEAST_BYTES; want -= want / 4) {
        if (fallocate(fd, FALLOC_FL_KEEP_SIZE, 0, (off_t)want) == 0) {
            return want;
        }
        if (errno != ENOSPC && errno != EDQUOT && errno != EFBIG) {
            return most;
        }
        int why = errno;
        if (ftruncate(fd, 0) != 0) { /* gives back what it got */
            break;
        }
        errno = why;
    }
    return 0;
}

/* What a thread does with a file, and then closes it. */
struct last {
    struct pel_task task;
    int fd;
    bool over; /* its name is gone, nothing of it is brought to the disk */
};

static void do_last(struct pel_task *task)
{
    struct last *last = (struct last *)task;
    if (!last->over) {
        (void)!fdatasync(last->fd);
    }
    close(last->fd);
    last->fd = -1;
}

static void did_last(struct pel_task *task, bool dropped)
{
    struct last *last = (struct last *)task;
    (void)dropped;
    if (last->fd >= 0) {
        close(last->fd);
    }
    g_free(last);
}

/* The last close of a file without a name gives back a megabyte of the disk and
 * of its cache: milliseconds. */
static void push_last(struct pel_journal *j, int fd, bool over)
{
    struct last *last = g_new(struct last, 1);
    *last = (struct last){ { .work = do_last, .done = did_last }, fd, over };
    pel_worker_push(j->worker, &last->task);
}

static bool write_head(struct begun *b, const uint8_t *head, size_t size)
{
    uint8_t first[PEL_LOG_BEGIN_SIZE];
    size_t framed_size;
    pel_log_begin(&b->writer, first);
    uint8_t *framed = pel_log_frame(&b->writer, head, size, &framed_size);
    pel_log_count(&b->writer, first + PEL_LOG_COUNT_AT);
    b->size = sizeof first + framed_size;
    b->room = reserve(b->fd, b->size);
    bool good = b->room > 0 && pel_file_write(b->fd, first, sizeof first) &&
                pel_file_write(b->fd, framed, framed_size) &&
                fdatasync(b->fd) == 0;
    free(framed);
    return good;
}

/* A journal of this head, with room for the others; fd -1: errno in why. Any
 * thread. */
static struct begun begin_file(const char *name, const uint8_t *head,
                               size_t size)
{
    struct begun b = { .fd = open(name,
                                  O_WRONLY | O_CREAT | O_TRUNC | O_NOCTTY |
                                      O_NONBLOCK | O_CLOEXEC,
                                  0644) };
    if (b.fd < 0) {
        b.why = errno;
    } else if (!write_head(&b, head, size)) {
        b.why = errno;
        close(b.fd);
        unlink(name);
        b.fd = -1;
    }
    return b;
}

static gboolean on_again_timer(gpointer user)
{
    struct pel_journal *j = user;
    j->again_timer = 0;
    j->cares.wants(j->cares.user);
    return G_SOURCE_REMOVE;
}

/* Tries again later, whether anybody edits or not. */
static void later(struct pel_journal *j)
{
    j->again_ns = pel_now_ns() + AGAIN_NS;
    if (j->again_timer != 0) {
        g_source_remove(j->again_timer); /* it would come before that time */
    }
    j->again_timer =
        g_timeout_add((guint)(AGAIN_NS / 1000000) + 1, on_again_timer, j);
}

static size_t room_left(const struct pel_journal *j)
{
    return j->fd >= 0 && j->room > j->size && !j->refuses && !j->lacks
               ? j->room - j->size
               : 0;
}

static const char *what_of_edits(const struct pel_journal *j)
{
    return j->cares.goes_on ? "not kept (--journal-full continue)" : "refused";
}

static void say_broken(struct pel_journal *j, int why)
{
    later(j);
    if (j->why == 0) {
        size_t left = room_left(j);
        g_autofree char *until =
            left > 0 ? g_strdup_printf("%zu KiB are left in this one, then ",
                                       left >> 10)
                     : g_strdup("");
        pel_error("SCN-012", "no new %s: %s; %sedits are %s", j->path,
                  g_strerror(why), until, what_of_edits(j));
    }
    j->why = why;
}

/* Takes the new one, whose entries are those of its head. over: the thread
 * ends. */
static void begun(struct pel_journal *j, const struct begun *b, bool over)
{
    if (rename(j->fresh, j->path) != 0) {
        say_broken(j, errno);
        close(b->fd);
        return;
    }
    if (j->fd >= 0 && over) {
        close(j->fd);
    } else if (j->fd >= 0) {
        push_last(j, j->fd, true);
    }
    j->fd = b->fd;
    j->size = b->size;
    j->room = b->room;
    j->limit = MIN((size_t)PEL_JOURNAL_BYTES, j->room / 2);
    j->limit = MAX(j->limit, b->size + 1);
    j->writer = b->writer;
    j->turns++;
    if (j->why != 0) {
        pel_info("SCN-013", "edits are kept again in %s", j->path);
    }
    j->why = 0;
    j->lacks = j->refuses = false;
}

/* The journal of the daemon before, whose end is the state now, where there is
 * no room for another: what it has reserved is there still. */
static bool go_on(struct pel_journal *j, const struct pel_journal_found *found)
{
    if (!found || !found->may_go_on) {
        return false;
    }
    struct stat is;
    int fd = open(j->path, O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0 || fstat(fd, &is) != 0 ||
        lseek(fd, (off_t)found->size, SEEK_SET) < 0) {
        if (fd >= 0) {
            close(fd);
        }
        return false;
    }
    j->fd = fd;
    j->size = found->size;
    j->room = (size_t)is.st_blocks * 512;
    j->limit = 0; /* a new one as soon as there is room */
    j->writer = found->writer;
    return true;
}

struct pel_journal *pel_journal_create(const char *path, const char *lineage,
                                       const Pelagos__State *state,
                                       const struct pel_journal_found *found,
                                       const struct pel_journal_cares *cares,
                                       struct pel_worker *worker)
{
    struct pel_journal *j = g_new0(struct pel_journal, 1);
    size_t size;
    j->path = journal_name(path);
    j->fresh = g_strconcat(j->path, ".new", NULL);
    j->lineage = g_strdup(lineage);
    j->cares = *cares;
    j->worker = worker;
    j->step_s = state->clock->time;
    j->fd = -1;
    uint8_t *head = pack_head(j, state, &size);
    struct begun b = begin_file(j->fresh, head, size);
    if (b.fd >= 0) {
        begun(j, &b, false);
    }
    if (j->fd < 0) {
        j->refuses = !go_on(j, found);
        say_broken(j, b.fd < 0 ? b.why : j->why);
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
    struct begun got;
};

static void do_turn(struct pel_task *task)
{
    struct turn *t = (struct turn *)task;
    t->got = begin_file(t->journal->fresh, t->head, t->size);
}

/* Writes the entries that have come since behind the new journal's head. */
static bool write_since(struct begun *b, const GByteArray *since)
{
    size_t size;
    uint8_t count[PEL_LOG_COUNT_SIZE];
    uint8_t *framed = pel_log_frame(&b->writer, since->data, since->len, &size);
    bool good = pel_file_write(b->fd, framed, size);
    b->size += size;
    pel_log_count(&b->writer, count);
    good = good && pwrite(b->fd, count, sizeof count, PEL_LOG_COUNT_AT) ==
                       (ssize_t)sizeof count;
    free(framed);
    return good;
}

static void turned(struct pel_task *task, bool dropped)
{
    struct turn *t = (struct turn *)task;
    struct pel_journal *j = t->journal;
    if (t->got.fd < 0 && !dropped) {
        say_broken(j, t->got.why);
    } else if (t->got.fd >= 0 && (j->cut || !write_since(&t->got, j->since))) {
        say_broken(j, j->cut ? ETIMEDOUT : errno);
        close(t->got.fd);
        unlink(j->fresh);
    } else if (t->got.fd >= 0) {
        begun(j, &t->got, dropped);
    }
    g_byte_array_unref(j->since);
    j->since = NULL;
    free(t->head);
    g_free(t);
}

bool pel_journal_is_full(const struct pel_journal *j)
{
    return (j->fd < 0 || j->lacks || j->refuses || j->size >= j->limit) &&
           !j->since && pel_now_ns() >= j->again_ns;
}

void pel_journal_turn(struct pel_journal *j, const Pelagos__State *state)
{
    struct turn *t = g_new0(struct turn, 1);
    t->task.work = do_turn;
    t->task.done = turned;
    t->journal = j;
    t->got.fd = -1;
    t->head = pack_head(j, state, &t->size);
    j->since = g_byte_array_new();
    j->cut = false;
    pel_worker_push(j->worker, &t->task);
}

/* --- to the disk ---------------------------------------------------------- */

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
        push_last(j, fd, false);
        fd = -1;
    }
    if (fd >= 0) {
        close(fd);
    }
    j->unsynced = false;
    return j->sync_timer != 0;
}

/* --- adding --------------------------------------------------------------- */

/* Overwrites the rest of a torn entry. Not by ftruncate, which would give back
 * the room that is reserved behind it. */
static void wipe(struct pel_journal *j)
{
    static const uint8_t zeroes[4096];
    off_t end = lseek(j->fd, 0, SEEK_CUR);
    off_t at = (off_t)j->size;
    bool good = end >= at;
    for (; good && at < end; at += (off_t)sizeof zeroes) {
        size_t part = MIN(sizeof zeroes, (size_t)(end - at));
        good = pwrite(j->fd, zeroes, part, at) == (ssize_t)part;
    }
    if (!good || lseek(j->fd, (off_t)j->size, SEEK_SET) < 0) {
        close(j->fd);
        j->fd = -1;
    }
}

/* The entry is in the file, behind the others; false: it is as it was. */
static bool write_entry(struct pel_journal *j, const uint8_t *data, size_t size)
{
    uint8_t count[PEL_LOG_COUNT_SIZE];
    struct pel_log_writer before = j->writer;
    size_t framed_size;
    uint8_t *framed = pel_log_frame(&j->writer, data, size, &framed_size);
    bool fits = j->size + framed_size <= PEL_JOURNAL_MOST_BYTES;
    errno = EFBIG;
    bool good = fits && pel_file_write(j->fd, framed, framed_size);
    int why = errno;
    free(framed);
    if (!good) {
        j->writer = before;
        if (fits) {
            wipe(j);
        }
        errno = why;
        return false;
    }
    j->size += framed_size;
    pel_log_count(&j->writer, count);
    /* Where it is not written, an end that is cut off is not known later. */
    (void)!pwrite(j->fd, count, sizeof count, PEL_LOG_COUNT_AT);
    return true;
}

static void gather(struct pel_journal *j, const uint8_t *data, size_t size)
{
    if (j->since && j->since->len + size <= PEL_JOURNAL_MOST_BYTES) {
        g_byte_array_append(j->since, data, (guint)size);
    } else if (j->since) {
        j->cut = true; /* a disk that hangs: what is gathered is of no use */
    }
}

static bool put(struct pel_journal *j, const uint8_t *data, size_t size)
{
    bool may = j->fd >= 0 && !j->lacks; /* what follows would lead elsewhere */
    if (may && write_entry(j, data, size)) {
        gather(j, data, size);
        j->refuses = false;
        j->unsynced = true;
        if (j->sync_timer == 0) {
            j->sync_timer =
                g_timeout_add(PEL_JOURNAL_SYNC_MS, on_sync_timer, j);
        }
        return true;
    }
    int why = may ? errno : j->why;
    bool first = !j->refuses && !j->lacks;
    if (j->cares.goes_on) {
        gather(j, data, size);
        j->lacks = true;
        j->lost++;
    } else {
        j->refuses = true;
        j->refused++;
    }
    if (first && j->why != 0) {
        pel_error("SCN-034",
                  "the room reserved for %s is used up: edits are %s", j->path,
                  j->cares.goes_on ? "not kept" : "refused");
    }
    if (first) {
        say_broken(j, why);
        j->again_ns = 0; /* there may be room for a new one at once */
    }
    return false;
}

bool pel_journal_add(struct pel_journal *j, double time_s,
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
        return true;
    }
    bool kept = put(j, data, size);
    if (kept || j->cares.goes_on) {
        j->step_s = time_s;
    }
    free(data);
    return kept;
}

bool pel_journal_refuses(const struct pel_journal *j)
{
    return j && j->refuses && !j->cares.goes_on;
}

bool pel_journal_lacks(const struct pel_journal *j)
{
    return j && j->lacks;
}

bool pel_journal_trouble(const struct pel_journal *j, char *out, size_t size)
{
    if (!j || j->why == 0) {
        return false;
    }
    if (j->lacks) {
        g_snprintf(out, (gulong)size,
                   "edits are answered and not kept: %s; make room on the disk "
                   "of %s",
                   g_strerror(j->why), j->path);
    } else if (room_left(j) == 0) {
        g_snprintf(out, (gulong)size,
                   "edits are refused: %s; make room on the disk of %s",
                   g_strerror(j->why), j->path);
    } else {
        g_snprintf(out, (gulong)size,
                   "edits are kept in the last %zu KiB that are reserved: %s; "
                   "make room on the disk of %s",
                   room_left(j) >> 10, g_strerror(j->why), j->path);
    }
    return true;
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
    if (j->again_timer != 0) {
        g_source_remove(j->again_timer);
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
    g_free(j->lineage);
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
    pel_metric(page, "pelagos_scene_journal_refused_total", PEL_METRIC_COUNTER,
               "Edits that were refused since the journal had no room.", NULL,
               (double)j->refused);
    pel_metric(page, "pelagos_scene_journal_room_bytes", PEL_METRIC_GAUGE,
               "Bytes that are reserved for edits to come.", NULL,
               (double)room_left(j));
}
