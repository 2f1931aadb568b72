#include "scene/store.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "json.h"
#include "scene/check.h"
#include "scene/edit.h"

static enum pel_err system_fault(const char *verb, const char *path,
                                 struct pel_fault *fault)
{
    return pel_fault_set(fault,
                         errno == ENOENT ? PEL_ERR_NOT_FOUND : PEL_ERR_IO,
                         "cannot %s %s: %s", verb, path, g_strerror(errno));
}

/* At most one byte more than a state may have. */
static enum pel_err read_file(const char *path, char **text, size_t *length,
                              struct pel_fault *fault)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        return system_fault("open", path, fault);
    }
    size_t room = PEL_JSON_MAX_BYTES + 1;
    char *bytes = g_malloc(room);
    size_t used = 0;
    ssize_t got = 1;
    while (used < room && got > 0) {
        got = read(fd, bytes + used, room - used);
        if (got > 0) {
            used += (size_t)got;
        } else if (got < 0 && errno == EINTR) {
            got = 1;
        }
    }
    enum pel_err err = PEL_OK;
    if (got < 0) {
        system_fault("read", path, fault);
        err = PEL_ERR_IO;
        g_free(bytes);
        bytes = NULL;
    }
    close(fd);
    *text = bytes;
    *length = used;
    return err;
}

static void set_aside(const char *path)
{
    g_autofree char *bad = g_strconcat(path, ".bad", NULL);
    if (rename(path, bad) != 0) {
        /* The next save replaces it; the report said what was wrong. */
        unlink(path);
    }
}

enum pel_err pel_store_load(const char *path, Pelagos__State **out,
                            struct pel_fault *fault)
{
    char *text = NULL;
    size_t length = 0;
    ProtobufCMessage *message = NULL;
    enum pel_err err = read_file(path, &text, &length, fault);
    if (err) {
        return err;
    }
    err = pel_json_to_message(text, length, &pelagos__state__descriptor,
                              &message, fault);
    g_free(text);
    Pelagos__State *state = (Pelagos__State *)message;
    if (!err) {
        pel_state_fill(state, state->clock ? state->clock->time : 0);
        err = pel_state_check(state, fault);
    }
    if (err) {
        if (state) {
            pelagos__state__free_unpacked(state, NULL);
        }
        set_aside(path);
        /* A missing field is no missing file. */
        return err == PEL_ERR_NOT_FOUND ? PEL_ERR_INVALID : err;
    }
    *out = state;
    return PEL_OK;
}

static bool write_all(int fd, const char *bytes, size_t length)
{
    while (length > 0) {
        ssize_t wrote = write(fd, bytes, length);
        if (wrote < 0 && errno != EINTR) {
            return false;
        }
        if (wrote > 0) {
            bytes += wrote;
            length -= (size_t)wrote;
        }
    }
    return true;
}

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

enum pel_err pel_store_save(const char *path, const Pelagos__State *state,
                            struct pel_fault *fault)
{
    g_autofree char *temporary = g_strconcat(path, ".new", NULL);
    int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0) {
        return system_fault("create", temporary, fault);
    }
    char *text = pel_json_from_message(&state->base, true);
    bool good = write_all(fd, text, strlen(text)) && write_all(fd, "\n", 1) &&
                fsync(fd) == 0;
    int why = errno;
    good = close(fd) == 0 && good;
    free(text);
    if (!good || rename(temporary, path) != 0) {
        errno = good ? errno : why;
        system_fault("write", path, fault);
        unlink(temporary);
        return PEL_ERR_IO;
    }
    sync_directory(path);
    return PEL_OK;
}
