#include "scene/store.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/aside.h"
#include "base/checksum.h"
#include "base/file.h"
#include "base/trial.h"
#include "json.h"
#include "scene/check.h"
#include "scene/edit.h"

#define VERSION_NAME "stateVersion"
#define CHECKSUM_NAME "stateChecksum"
#define LINEAGE_NAME "stateLineage"
#define DIGITS 8 /* of the checksum */
#define JSON_SPACE " \t\r\n"

/* What is at PATH, as far as this daemon knows. */
enum there { NOTHING, GOOD_STATE, BAD_STATE };

struct pel_store {
    char *path, *temporary, *lock_path;
    char *before; /* PATH.prev */
    enum there there;
    char *lineage;
    bool knows; /* the lineage is the file's */
    int lock;
};

static enum pel_err system_fault(const char *verb, const char *path,
                                 struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_IO, "cannot %s %.160s: %s", verb, path,
                         g_strerror(errno));
}

/* --- the lock ------------------------------------------------------------- */

static enum pel_err unwritable(const char *path, int why,
                               struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_IO,
                         "--state: %.120s cannot be written: %s; name a file "
                         "in a directory that this user may write, or --state "
                         "off",
                         path, g_strerror(why));
}

/* Where the state is written later can be written now. */
static enum pel_err try_writing(const char *temporary, struct pel_fault *fault)
{
    int fd = open(temporary,
                  O_WRONLY | O_CREAT | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, 0644);
    if (fd < 0) {
        return unwritable(temporary, errno, fault);
    }
    close(fd);
    return unlink(temporary) == 0 ? PEL_OK
                                  : unwritable(temporary, errno, fault);
}

/* A file that is locked and still the one of that name: a daemon removes it
 * when it ends. */
static int open_lock(const char *path)
{
    struct stat own, named;
    for (;;) {
        int fd = open(
            path, O_RDWR | O_CREAT | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, 0600);
        if (fd < 0) {
            return -1;
        }
        bool locked = flock(fd, LOCK_EX | LOCK_NB) == 0;
        int why = errno;
        if (locked && fstat(fd, &own) == 0 && stat(path, &named) == 0 &&
            own.st_ino == named.st_ino && own.st_dev == named.st_dev) {
            return fd;
        }
        close(fd);
        if (!locked) {
            errno = why;
            return -1;
        }
    }
}

static enum pel_err lock(struct pel_store *store, struct pel_fault *fault)
{
    store->lock = open_lock(store->lock_path);
    if (store->lock >= 0) {
        return PEL_OK;
    }
    return errno == EWOULDBLOCK
               ? pel_fault_set(fault, PEL_ERR_CONFLICT,
                               "--state: another daemon keeps its state in "
                               "%.120s; end it, or name another file",
                               store->path)
               : unwritable(store->lock_path, errno, fault);
}

/* For --check: a daemon that has the state now may be the one that is to be
 * restarted. */
static enum pel_err try_lock(struct pel_store *store, struct pel_fault *fault)
{
    int fd =
        open(store->lock_path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    store->lock = -1;
    if (fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        pel_trial_note("--state: a daemon keeps its state in %.200s now; "
                       "another one starts when that has ended",
                       store->path);
    }
    if (fd >= 0) {
        close(fd);
    }
    return pel_trial_write("state", store->path, fault);
}

enum pel_err pel_store_open(const char *path, struct pel_store **out,
                            struct pel_fault *fault)
{
    struct pel_store *store = g_new0(struct pel_store, 1);
    store->path = g_strdup(path);
    store->temporary = g_strconcat(path, ".new", NULL);
    store->lock_path = g_strconcat(path, ".lock", NULL);
    store->before = g_strconcat(path, PEL_STATE_BEFORE, NULL);
    store->lineage = g_uuid_string_random();
    enum pel_err err =
        pel_trial() ? try_lock(store, fault) : lock(store, fault);
    if (!err && !pel_trial()) {
        err = try_writing(store->temporary, fault);
    }
    if (err) {
        pel_store_close(store);
        return err;
    }
    *out = store;
    return PEL_OK;
}

void pel_store_close(struct pel_store *store)
{
    if (store) {
        if (store->lock >= 0) {
            unlink(store->lock_path);
            close(store->lock);
        }
        g_free(store->lock_path);
        g_free(store->before);
        g_free(store->lineage);
        g_free(store->temporary);
        g_free(store->path);
        g_free(store);
    }
}

/* --- loading -------------------------------------------------------------- */

/* The member that every file begins with, taken out of the text; files from
 * before there were versions have none, and are read as version 1. */
static bool take_version(char *text, uint64_t *version)
{
    static const char name[] = "\"" VERSION_NAME "\"";
    size_t at = strspn(text, JSON_SPACE);
    *version = 1;
    if (text[at] != '{') {
        return true;
    }
    at += 1 + strspn(text + at + 1, JSON_SPACE);
    if (strncmp(text + at, name, sizeof name - 1) != 0) {
        return true;
    }
    size_t from = at;
    at += sizeof name - 1 + strspn(text + at + sizeof name - 1, JSON_SPACE);
    bool good = text[at] == ':';
    at += good + strspn(text + at + good, JSON_SPACE);
    size_t digits = strspn(text + at, "0123456789");
    *version = good ? g_ascii_strtoull(text + at, NULL, 10) : 0;
    at += digits + strspn(text + at + digits, JSON_SPACE);
    good = *version >= 1 && (text[at] == ',' || text[at] == '}');
    *version = good ? *version : 0;
    at += text[at] == ',';
    memset(text + from, ' ', at - from);
    return good;
}

/* Likewise a member with a text, or nothing: *out is a copy, g_free. False: it
 * is no text. */
static bool take_text(char *text, const char *member, char **out)
{
    g_autofree char *name = g_strdup_printf("\"%s\"", member);
    char *at = text + strspn(text, JSON_SPACE);
    *out = NULL;
    if (*at != '{') {
        return true;
    }
    char *from = at + 1 + strspn(at + 1, JSON_SPACE);
    if (strncmp(from, name, strlen(name)) != 0) {
        return true;
    }
    char *value = from + strlen(name);
    value += strspn(value, JSON_SPACE);
    value += *value == ':';
    value += strspn(value, JSON_SPACE);
    size_t length = *value == '"' ? strcspn(value + 1, "\"\\") : 0;
    if (*value != '"' || value[1 + length] != '"') {
        return false;
    }
    *out = g_strndup(value + 1, length);
    char *end = value + length + 2;
    end += strspn(end, JSON_SPACE);
    end += *end == ',';
    memset(from, ' ', (size_t)(end - from));
    return true;
}

/* The result of the file's checksum, which is made with eight zeroes in its
 * place. */
enum checked { UNSAID, GOOD, BAD };

static enum checked check_sum(const char *text, size_t length)
{
    static const char name[] = "\"" CHECKSUM_NAME "\"";
    static const char zeroes[] = "00000000";
    /* It is among the first members; the name in a text is behind them. */
    const char *at = g_strstr_len(text, (gssize)MIN(length, 256), name);
    if (!at) {
        return UNSAID;
    }
    at += sizeof name - 1;
    at += strspn(at, JSON_SPACE ":");
    const char *digits = at + (*at == '"');
    size_t before = (size_t)(digits - text);
    if (*at != '"' || length - before < DIGITS) {
        return BAD;
    }
    uint32_t sum = pel_crc32c(0, text, before);
    sum = pel_crc32c(sum, zeroes, DIGITS);
    sum = pel_crc32c(sum, digits + DIGITS, length - before - DIGITS);
    g_autofree char *wanted = g_strdup_printf("%08x", sum);
    return memcmp(digits, wanted, DIGITS) == 0 ? GOOD : BAD;
}

static enum pel_err newer(const char *path, uint64_t version,
                          struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_IO,
                         "%.90s is of version %llu, which a newer pelagosd "
                         "wrote, and this one reads version %d: start that "
                         "one, or name another file",
                         path, (unsigned long long)version, PEL_STATE_VERSION);
}

static enum pel_err read_state(const char *text, size_t length,
                               Pelagos__State **out, struct pel_fault *fault)
{
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_json_to_message(
        text, length, &pelagos__state__descriptor, &message, fault);
    Pelagos__State *state = (Pelagos__State *)message;
    if (!err) {
        pel_state_fill(state, state->clock ? state->clock->time : 0);
        err = pel_state_check(state, fault);
    }
    if (err && state) {
        pelagos__state__free_unpacked(state, NULL);
    }
    *out = err ? NULL : state;
    return err;
}

static enum pel_err damaged(struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "its checksum does not fit: it is damaged, or was "
                         "changed by hand, and then its line " CHECKSUM_NAME
                         " has to be removed");
}

/* Without the members that are the file's. */
static enum pel_err take_state(struct pel_store *store, char *text,
                               size_t length, Pelagos__State **out,
                               struct pel_fault *fault)
{
    g_autofree char *sum = NULL, *lineage = NULL;
    if (!take_text(text, CHECKSUM_NAME, &sum) ||
        !take_text(text, LINEAGE_NAME, &lineage)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             CHECKSUM_NAME " and " LINEAGE_NAME
                                           " must be texts");
    }
    enum pel_err err = read_state(text, length, out, fault);
    if (!err && lineage && *lineage) {
        g_free(store->lineage);
        store->lineage = g_steal_pointer(&lineage);
        store->knows = true;
    }
    return err;
}

/* Keeps what does not load. */
static char *keep_aside(const char *path, struct pel_fault *fault)
{
    char *aside = pel_trial() ? g_strconcat(path, ".bad", NULL) /* it would */
                              : pel_aside_keep(path, ".bad");
    if (!aside) {
        pel_fault_set(fault, PEL_ERR_IO,
                      "--state: %.100s does not load and cannot be put aside; "
                      "move it away",
                      path);
    }
    return aside;
}

/* As pel_store_load, of either generation. */
static enum pel_err load(struct pel_store *store, const char *path,
                         Pelagos__State **out, char **aside,
                         struct pel_fault *fault)
{
    char *text = NULL;
    size_t length = 0;
    *aside = NULL;
    enum pel_err err =
        pel_file_read(path, PEL_JSON_MAX_BYTES, &text, &length, fault);
    if (err == PEL_ERR_NOT_FOUND) {
        return err;
    }
    if (err && err != PEL_ERR_OUT_OF_RANGE) {
        return PEL_ERR_IO; /* a directory, a FIFO, no permission */
    }
    uint64_t version = 1;
    enum checked sum = err ? UNSAID : check_sum(text, length);
    bool good = err || take_version(text, &version);
    if (version > PEL_STATE_VERSION && sum != BAD) {
        free(text);
        return newer(path, version, fault);
    }
    if (!err) {
        err = sum == BAD ? damaged(fault)
              : good     ? take_state(store, text, length, out, fault)
                         : pel_fault_set(fault, PEL_ERR_INVALID,
                                         VERSION_NAME " must be a number from 1");
    }
    free(text);
    if (err && !(*aside = keep_aside(path, fault))) {
        return PEL_ERR_IO;
    }
    /* A missing field is no missing file. */
    return err == PEL_ERR_NOT_FOUND || err == PEL_ERR_IO ? PEL_ERR_INVALID
                                                         : err;
}

enum pel_err pel_store_load(struct pel_store *store, Pelagos__State **out,
                            char **aside, struct pel_fault *fault)
{
    enum pel_err err = load(store, store->path, out, aside, fault);
    store->there = err == PEL_ERR_NOT_FOUND ? NOTHING
                   : err                    ? BAD_STATE
                                            : GOOD_STATE;
    return err;
}

enum pel_err pel_store_load_before(struct pel_store *store,
                                   Pelagos__State **out, double *older_s,
                                   struct pel_fault *fault)
{
    struct stat newest, before;
    g_autofree char *aside = NULL;
    enum pel_err err = load(store, store->before, out, &aside, fault);
    *older_s = 0;
    if (!err && stat(store->path, &newest) == 0 &&
        stat(store->before, &before) == 0) {
        *older_s =
            (double)(newest.st_mtim.tv_sec - before.st_mtim.tv_sec) +
            1e-9 * (double)(newest.st_mtim.tv_nsec - before.st_mtim.tv_nsec);
    }
    return err;
}

char *pel_store_set_aside(struct pel_store *store)
{
    char *aside = pel_aside_keep(store->path, ".aside");
    if (aside) {
        unlink(store->path);
        store->there = NOTHING;
    }
    return aside;
}

const char *pel_store_lineage(const struct pel_store *store)
{
    return store->lineage;
}

const char *pel_store_loaded_lineage(const struct pel_store *store)
{
    return store->knows ? store->lineage : NULL;
}

/* --- saving --------------------------------------------------------------- */

/* The rename is on the disk once its directory is. */
static void sync_directory(const char *path)
{
    g_autofree char *directory = g_path_get_dirname(path);
    int fd = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        /* Some file systems refuse this; the file itself is synced. */
        (void)!fsync(fd);
        close(fd);
    }
}

/* The file's own members, of which the checksum is the second, and the state;
 * g_free. */
static char *whole_text(const struct pel_store *store,
                        const Pelagos__State *state, size_t *size)
{
    char *json = pel_json_from_message(&state->base, true);
    GString *out = g_string_new(NULL);
    g_string_append_printf(out,
                           "{\n  \"" VERSION_NAME "\": %d,\n  "
                           "\"" CHECKSUM_NAME "\": \"",
                           PEL_STATE_VERSION);
    size_t at = out->len;
    g_string_append_printf(out,
                           "00000000\",\n  \"" LINEAGE_NAME "\": \"%s\",%s\n",
                           store->lineage, json + 1);
    free(json);
    g_autofree char *sum =
        g_strdup_printf("%08x", pel_crc32c(0, out->str, out->len));
    memcpy(out->str + at, sum, DIGITS);
    *size = out->len;
    return g_string_free(out, FALSE);
}

/* The new file takes its name, and the one that had it becomes the generation
 * before, unless it is damaged: then the good one before it stays. What is
 * before a file that somebody has removed is nobody's. At each moment a whole
 * file has the name. */
static bool take_name(struct pel_store *store)
{
    const char *new = store->temporary;
    if (store->there == GOOD_STATE &&
        renameat2(AT_FDCWD, new, AT_FDCWD, store->path, RENAME_EXCHANGE) == 0) {
        if (rename(new, store->before) != 0) {
            unlink(new);
        }
        return true;
    }
    if (store->there != BAD_STATE) {
        unlink(store->before);
    }
    if (store->there == GOOD_STATE) { /* a file system without exchange */
        (void)!link(store->path, store->before);
    }
    return rename(new, store->path) == 0;
}

enum pel_err pel_store_save(struct pel_store *store,
                            const Pelagos__State *state,
                            struct pel_fault *fault)
{
    int fd = open(
        store->temporary,
        O_WRONLY | O_CREAT | O_TRUNC | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, 0644);
    if (fd < 0) {
        return system_fault("create", store->temporary, fault);
    }
    size_t size;
    char *text = whole_text(store, state, &size);
    bool good = pel_file_write(fd, text, size) && fsync(fd) == 0;
    int why = errno;
    good = close(fd) == 0 && good;
    g_free(text);
    if (!good || !take_name(store)) {
        errno = good ? errno : why;
        system_fault("write", store->path, fault);
        unlink(store->temporary);
        return PEL_ERR_IO;
    }
    store->there = GOOD_STATE;
    sync_directory(store->path);
    return PEL_OK;
}
