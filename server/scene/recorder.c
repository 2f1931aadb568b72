#include "scene/recorder.h"

#include <glib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"
#include "scene/recordings.h"

#define NAME_LETTERS                                                           \
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-"
#define NAME_MOST 64

struct pel_recorder {
    struct pel_scene *scene;
    struct pel_record_options options; /* but for the path */
    char *program, *device, *directory;
    struct pel_record *record; /* NULL: nothing is recorded */
    char *name;                /* of its file, without the path */
    struct pel_worker *worker; /* brings what was ended to the disk */
};

static enum pel_err begin(struct pel_recorder *r, const char *path,
                          struct pel_fault *fault)
{
    struct pel_record_options options = r->options;
    options.path = path;
    enum pel_err err = pel_record_create(&options, r->scene, &r->record, fault);
    if (!err) {
        g_free(r->name);
        r->name = g_path_get_basename(path);
    }
    return err;
}

enum pel_err pel_recorder_create(const struct pel_recorder_options *o,
                                 struct pel_scene *scene,
                                 struct pel_recorder **out,
                                 struct pel_fault *fault)
{
    *out = NULL;
    if (o->directory && !g_file_test(o->directory, G_FILE_TEST_IS_DIR)) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "--recordings: %.140s is no directory; make it, "
                             "name another, or say off",
                             o->directory);
    }
    struct pel_recorder *r = g_new0(struct pel_recorder, 1);
    r->scene = scene;
    r->options = o->record;
    r->options.program = r->program = g_strdup(o->record.program);
    r->options.device = r->device = g_strdup(o->record.device);
    r->directory = g_strdup(o->directory);
    r->worker = pel_worker_create("recorder");
    enum pel_err err =
        o->record.path ? begin(r, o->record.path, fault) : PEL_OK;
    if (err) {
        pel_recorder_destroy(r);
        return err;
    }
    *out = r;
    return PEL_OK;
}

void pel_recorder_destroy(struct pel_recorder *r)
{
    if (!r) {
        return;
    }
    pel_record_destroy(r->record);
    pel_worker_destroy(r->worker);
    g_free(r->name);
    g_free(r->program);
    g_free(r->device);
    g_free(r->directory);
    g_free(r);
}

static char *name_of_now(void)
{
    char text[40];
    time_t now = time(NULL);
    struct tm utc;
    gmtime_r(&now, &utc);
    strftime(text, sizeof text, "%Y-%m-%dT%H-%M-%SZ", &utc);
    return g_strdup(text);
}

static enum pel_err check_name(const char *name, struct pel_fault *fault)
{
    size_t length = strlen(name);
    return length > NAME_MOST || *name == '.' || *name == '-' ||
                   strspn(name, NAME_LETTERS) != length
               ? pel_fault_set(fault, PEL_ERR_INVALID,
                               "a recording's name has 1 to %d of A-Z a-z 0-9 "
                               ". _ - and neither . nor - first, and \"%.80s\" "
                               "is another",
                               NAME_MOST, name)
               : PEL_OK;
}

enum pel_err pel_recorder_start(struct pel_recorder *r, const char *wanted,
                                struct pel_fault *fault)
{
    if (!r->directory) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "there is no place for recordings: start pelagosd "
                             "with --recordings DIRECTORY");
    }
    if (r->options.sealed && !pel_sealedlog_head(r->options.sealed)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "this node does not take part in the exercise "
                             "yet; a little later");
    }
    if (r->record) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "it is being recorded already, to %.120s; stop "
                             "that first",
                             r->name);
    }
    g_autofree char *name =
        wanted && *wanted ? g_strdup(wanted) : name_of_now();
    enum pel_err err = check_name(name, fault);
    if (err) {
        return err;
    }
    g_autofree char *path =
        g_strdup_printf("%s/%s" PEL_RECORDING_SUFFIX, r->directory, name);
    if (g_file_test(path, G_FILE_TEST_EXISTS)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "there is a recording %.80s.pelog already; give "
                             "another name",
                             name);
    }
    return begin(r, path, fault);
}

struct sync {
    struct pel_task task;
    int fd;
};

static void do_sync(struct pel_task *task)
{
    if (fdatasync(((struct sync *)task)->fd) != 0) {
        pel_warn("REC-010", "a recording that was ended may lack its last "
                            "entries on the disk");
    }
}

static void synced(struct pel_task *task, bool dropped)
{
    struct sync *s = (struct sync *)task;
    if (dropped) {
        (void)fdatasync(s->fd);
    }
    close(s->fd);
    g_free(s);
}

enum pel_err pel_recorder_stop(struct pel_recorder *r, struct pel_fault *fault)
{
    if (!r->record) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "nothing is recorded");
    }
    int fd = pel_record_end(r->record);
    r->record = NULL;
    g_free(r->name);
    r->name = NULL;
    if (fd >= 0) {
        struct sync *s = g_new0(struct sync, 1);
        s->task = (struct pel_task){ .work = do_sync, .done = synced };
        s->fd = fd;
        pel_worker_push(r->worker, &s->task);
    }
    return PEL_OK;
}

const char *pel_recorder_name(const struct pel_recorder *r)
{
    return r->record ? r->name : NULL;
}

const char *pel_recorder_directory(const struct pel_recorder *r)
{
    return r->directory;
}

void pel_recorder_collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_recorder *r = user;
    if (r->record) {
        pel_record_collect(r->record, page);
    }
}
