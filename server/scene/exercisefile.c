/* The directory of exercises. Files are of 1 MiB at most, which take some 30 ms
 * each; what was read once is known until the file changes. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/reserve.h"
#include "fault.h"
#include "json.h"
#include "message.h"
#include "scene/exercise_parts.h"

#define ENDING ".json"
#define MOST_FILES 256

/* Counted; of more than one thread. */
struct known {
    struct timespec changed;
    off_t size;
    char *title, *digest; /* NULL: none */
    struct pel_fault fault;
    enum pel_err err;
};

struct pel_exercise_files {
    char *directory;    /* NULL: none */
    GMutex lock;        /* of the next */
    GHashTable *known;  /* name → struct known */
    GPtrArray *listing; /* control thread: as of its last look */
    struct known *last; /* control thread: of the last digest */
};

static void known_clear(gpointer data)
{
    struct known *k = data;
    g_free(k->title);
    g_free(k->digest);
}

static void known_unref(gpointer data)
{
    if (data) {
        g_atomic_rc_box_release_full(data, known_clear);
    }
}

struct pel_exercise_files *pel_exercise_files_create(const char *directory)
{
    struct pel_exercise_files *files = g_new0(struct pel_exercise_files, 1);
    files->directory = g_strdup(directory);
    files->known =
        g_hash_table_new_full(g_str_hash, g_str_equal, g_free, known_unref);
    g_mutex_init(&files->lock);
    files->listing = g_ptr_array_new_with_free_func(g_free);
    return files;
}

void pel_exercise_files_destroy(struct pel_exercise_files *files)
{
    g_ptr_array_free(files->listing, TRUE);
    known_unref(files->last);
    g_hash_table_destroy(files->known);
    g_mutex_clear(&files->lock);
    g_free(files->directory);
    g_free(files);
}

static enum pel_err path_of(const struct pel_exercise_files *files,
                            const char *name, char **out,
                            struct pel_fault *fault)
{
    *out = NULL;
    if (!files->directory) {
        pel_fault_refuse(PEL_ERR_CONFLICT, "name", name,
                         "cannot be: this daemon has no exercises; start it "
                         "with --exercises DIRECTORY",
                         fault);
        return PEL_ERR_CONFLICT;
    }
    if (!pel_exercise_good_name(name) || *name == '-') {
        pel_fault_refuse(PEL_ERR_INVALID, "name", name,
                         "must be 1 to 64 of A-Z a-z 0-9 _ -, and no - first",
                         fault);
        return PEL_ERR_INVALID;
    }
    *out = g_strdup_printf("%s/%s" ENDING, files->directory, name);
    return PEL_OK;
}

enum pel_err pel_exercise_files_read(struct pel_exercise_files *files,
                                     const char *name, Pelagos__Exercise **out,
                                     struct pel_fault *fault)
{
    g_autofree char *path = NULL;
    char *text = NULL;
    size_t size;
    struct pel_fault why;
    enum pel_err err = path_of(files, name, &path, fault);
    *out = NULL;
    if (err) {
        return err;
    }
    err = pel_file_read_in(files->directory, strrchr(path, '/') + 1,
                           PEL_JSON_MAX_BYTES, &text, &size, &why);
    if (err == PEL_ERR_NOT_FOUND) {
        return pel_fault_refuse(err, "name", name,
                                "is no exercise; `pelagosctl exercise list` "
                                "says which there are",
                                fault);
    }
    if (err) {
        if (fault) {
            *fault = why;
        }
        return err;
    }
    err = pel_exercise_read(text, size, out, fault);
    free(text);
    return err;
}

char *pel_exercise_digest(const Pelagos__Exercise *exercise)
{
    size_t size = pelagos__exercise__get_packed_size(exercise);
    g_autofree uint8_t *bytes = g_malloc(size + 1);
    pelagos__exercise__pack(exercise, bytes);
    char *digest = g_compute_checksum_for_data(G_CHECKSUM_SHA256, bytes, size);
    digest[32] = '\0';
    return digest;
}

/* --- listing -------------------------------------------------------------- */

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Names of the files that are there, sorted. Any thread. */
static GPtrArray *look(const struct pel_exercise_files *files)
{
    GPtrArray *listing = g_ptr_array_new_with_free_func(g_free);
    GDir *dir = files->directory ? g_dir_open(files->directory, 0, NULL) : NULL;
    const char *entry;
    while (dir && (entry = g_dir_read_name(dir))) {
        if (g_str_has_suffix(entry, ENDING)) {
            char *name = g_strndup(entry, strlen(entry) - strlen(ENDING));
            if (pel_exercise_good_name(name) && *name != '-') {
                g_ptr_array_add(listing, name);
            } else {
                g_free(name);
            }
        }
    }
    if (dir) {
        g_dir_close(dir);
    }
    g_ptr_array_sort(listing, by_name);
    if (listing->len > MOST_FILES) {
        g_ptr_array_set_size(listing, MOST_FILES);
    }
    return listing;
}

const GPtrArray *pel_exercise_files_names(struct pel_exercise_files *files)
{
    g_ptr_array_free(files->listing, TRUE);
    files->listing = look(files);
    return files->listing;
}

/* The entry of a file that has not changed, or NULL; known_unref(). */
static struct known *recall(struct pel_exercise_files *files, const char *name,
                            const struct stat *info)
{
    g_mutex_lock(&files->lock);
    struct known *k = g_hash_table_lookup(files->known, name);
    bool same = k && k->size == info->st_size &&
                k->changed.tv_sec == info->st_mtim.tv_sec &&
                k->changed.tv_nsec == info->st_mtim.tv_nsec;
    k = same ? g_atomic_rc_box_acquire(k) : NULL;
    g_mutex_unlock(&files->lock);
    return k;
}

static void remember(struct pel_exercise_files *files, const char *name,
                     struct known *k)
{
    g_mutex_lock(&files->lock);
    if (g_hash_table_size(files->known) >= 2 * MOST_FILES) {
        g_hash_table_remove_all(files->known); /* most are of no file now */
    }
    g_hash_table_replace(files->known, g_strdup(name),
                         g_atomic_rc_box_acquire(k));
    g_mutex_unlock(&files->lock);
}

/* Reads it where that is not known; known_unref(). Any thread. */
static struct known *know(struct pel_exercise_files *files, const char *name)
{
    struct stat info = { 0 };
    g_autofree char *path = NULL;
    if (path_of(files, name, &path, NULL) || stat(path, &info) != 0) {
        info.st_size = -1;
    }
    struct known *k = recall(files, name, &info);
    if (k) {
        return k;
    }
    Pelagos__Exercise *exercise = NULL;
    k = g_atomic_rc_box_new0(struct known);
    k->changed = info.st_mtim;
    k->size = info.st_size;
    k->err = pel_exercise_files_read(files, name, &exercise, &k->fault);
    if (!k->err && exercise) {
        k->title = g_strdup(exercise->title);
        k->digest = pel_exercise_digest(exercise);
        pelagos__exercise__free_unpacked(exercise, NULL);
    }
    remember(files, name, k);
    return k;
}

const char *pel_exercise_files_digest(struct pel_exercise_files *files,
                                      const char *name, struct pel_fault *fault)
{
    known_unref(files->last);
    files->last = know(files, name);
    if (files->last->err) {
        *fault = files->last->fault;
    }
    return files->last->digest;
}

void pel_exercise_files_list(struct pel_exercise_files *files,
                             Pelagos__ExerciseStatus *out)
{
    g_autoptr(GPtrArray) listing = look(files);
    out->exercises = pel_sure_calloc(listing->len + 1, sizeof *out->exercises);
    for (guint i = 0; i < listing->len; i++) {
        const char *name = g_ptr_array_index(listing, i);
        struct known *k = know(files, name);
        Pelagos__ExerciseInfo *info = pel_sure_malloc(sizeof *info);
        pelagos__exercise_info__init(info);
        info->name = strdup(name);
        info->title = k->title ? strdup(k->title) : NULL;
        if (k->err) {
            Pelagos__Error error;
            struct pel_fault shown = k->fault;
            pel_fault_clean(&shown);
            pel_fault_to_error(&shown, &error);
            info->error = (Pelagos__Error *)pel_message_copy(&error.base);
        }
        out->exercises[out->n_exercises++] = info;
        known_unref(k);
    }
}

/* --- writing -------------------------------------------------------------- */

bool pel_exercise_replace(const char *path, const void *data, size_t size)
{
    g_autofree char *fresh = g_strconcat(path, ".new", NULL);
    unlink(fresh);
    int fd =
        open(fresh, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOCTTY, 0644);
    if (fd < 0) {
        return false;
    }
    bool good = pel_file_write(fd, data, size);
    int why = errno;
    close(fd);
    if (good && rename(fresh, path) == 0) {
        return true;
    }
    why = good ? errno : why;
    unlink(fresh);
    errno = why;
    return false;
}

enum pel_err pel_exercise_files_save(struct pel_exercise_files *files,
                                     const char *name,
                                     const Pelagos__Exercise *exercise,
                                     struct pel_fault *fault)
{
    g_autofree char *path = NULL;
    enum pel_err err = path_of(files, name, &path, fault);
    if (!err) {
        err = pel_exercise_check(exercise, fault);
    }
    if (err) {
        return err;
    }
    g_autoptr(GPtrArray) listing = look(files);
    if (listing->len >= MOST_FILES && !g_file_test(path, G_FILE_TEST_EXISTS)) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "there are %d exercises already; remove one",
                             MOST_FILES);
    }
    char *text = pel_json_from_message(&exercise->base, true);
    size_t size = strlen(text);
    bool good = size <= PEL_JSON_MAX_BYTES;
    errno = EFBIG;
    good = good && pel_exercise_replace(path, text, size);
    free(text);
    return good ? PEL_OK
                : pel_fault_set(fault, PEL_ERR_IO, "%.120s is not saved: %s",
                                path, g_strerror(errno));
}

enum pel_err pel_exercise_files_delete(struct pel_exercise_files *files,
                                       const char *name,
                                       struct pel_fault *fault)
{
    g_autofree char *path = NULL;
    enum pel_err err = path_of(files, name, &path, fault);
    if (err) {
        return err;
    }
    if (unlink(path) == 0) {
        return PEL_OK;
    }
    return errno == ENOENT
               ? pel_fault_refuse(PEL_ERR_NOT_FOUND, "name", name,
                                  "is no exercise", fault)
               : pel_fault_set(fault, PEL_ERR_IO, "%.120s is not removed: %s",
                               path, g_strerror(errno));
}
