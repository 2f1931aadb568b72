#include "scene/catalogue.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/reserve.h"
#include "bounds.h"
#include "fault.h"
#include "message.h"
#include "models/builtin.h"
#include "models/modelload.h"
#include "scene/scene_parts.h"

#define MOST_WAITING 16
#define MOST_FILES 512
#define MOST_DEPTH 4
#define MOST_NS (INT64_C(4) * 1000000000)

/* Only the thread of scene->shapes looks into it. */
struct pel_catalogue {
    GHashTable *known; /* name → struct known */
};

struct known {
    char *stamp; /* size and time of its files; "" of what is built in */
    Pelagos__ModelInfo *info;
};

static void known_free(gpointer data)
{
    struct known *k = data;
    pelagos__model_info__free_unpacked(k->info, NULL);
    g_free(k->stamp);
    g_free(k);
}

void pel_catalogue_free(struct pel_catalogue *catalogue)
{
    if (catalogue) {
        g_hash_table_destroy(catalogue->known);
        g_free(catalogue);
    }
}

/* --- what a model is --------------------------------------------------------
 */

#define SET(to, field, value) ((to)->has_##field = true, (to)->field = (value))

static void add_points(const struct pel_model *m, Pelagos__ModelInfo *to)
{
    to->eyes = g_new0(Pelagos__ModelPoint *, m->eye_count + 1);
    for (size_t i = 0; i < m->eye_count; i++) {
        Pelagos__ModelPoint *p = (Pelagos__ModelPoint *)pel_message_new(
            &pelagos__model_point__descriptor);
        p->name = pel_sure_strdup(m->eyes[i].name);
        SET(p, forward, m->eyes[i].at.x);
        SET(p, right, -m->eyes[i].at.y);
        SET(p, up, m->eyes[i].at.z);
        to->eyes[to->n_eyes++] = p;
    }
    to->lights = g_new0(Pelagos__ModelLight *, m->light_count + 1);
    for (size_t i = 0; i < m->light_count; i++) {
        const struct pel_model_light *from = &m->lights[i];
        Pelagos__ModelLight *l = (Pelagos__ModelLight *)pel_message_new(
            &pelagos__model_light__descriptor);
        uint32_t colour = 0;
        for (int k = 0; k < 3; k++) {
            colour =
                colour << 8 | (uint32_t)lround(255.0 * (double)from->colour[k]);
        }
        l->name = pel_sure_strdup(from->name);
        SET(l, forward, from->at.x);
        SET(l, right, -from->at.y);
        SET(l, up, from->at.z);
        SET(l, colour, colour);
        SET(l, range, (double)from->range_m / 1852);
        SET(l, from, (double)from->from_rad / PEL_DEG);
        SET(l, to, (double)from->to_rad / PEL_DEG);
        to->lights[to->n_lights++] = l;
    }
}

static void fill(const struct pel_model *m, Pelagos__ModelInfo *to)
{
    SET(to, class_, (Pelagos__ModelClass)m->class);
    SET(to, length, m->length_m);
    SET(to, beam, m->beam_m);
    SET(to, draught, m->draught_m);
    SET(to, height, m->height_m);
    SET(to, bytes, m->bytes);
    to->triangles = g_new0(uint32_t, PEL_MODEL_LEVELS);
    for (int i = 0; i < m->level_count; i++) {
        to->triangles[to->n_triangles++] = (uint32_t)m->levels[i].triangles;
    }
    add_points(m, to);
}

static Pelagos__Error *error_of(const struct pel_fault *fault)
{
    Pelagos__Error error = PELAGOS__ERROR__INIT;
    pel_fault_to_error(fault, &error);
    return (Pelagos__Error *)pel_message_copy(&error.base);
}

static Pelagos__ModelInfo *look_at(const char *name, const char *directory)
{
    Pelagos__ModelInfo *info =
        (Pelagos__ModelInfo *)pel_message_new(&pelagos__model_info__descriptor);
    Pelagos__Model wish = PELAGOS__MODEL__INIT;
    const struct pel_builtin_kind *kind = pel_builtin_find(name);
    const struct pel_model *model = NULL;
    struct pel_fault fault = { 0 };
    char notes[PEL_MODEL_NOTES];
    wish.name = (char *)name;
    info->name = pel_sure_strdup(name);
    SET(info, builtin, kind != NULL);
    if (pel_fleet_make(&wish, directory, &model, notes, &fault)) {
        info->error = error_of(&fault);
        return info;
    }
    fill(model, info);
    if (kind || *notes) {
        info->text = pel_sure_strdup(kind ? kind->text : notes);
    }
    pel_model_unref(model);
    return info;
}

/* --- on a thread -------------------------------------------------------------
 */

struct asked {
    struct pel_task task;
    struct pel_scene *scene;
    char *name; /* NULL: all */
    int64_t end_ns;
    Pelagos__Models *answer;
    pel_models_done done;
    void *user;
};

/* Of the file and of its description. */
static char *stamp_of(const char *directory, const char *name)
{
    struct stat is = { 0 }, described = { 0 };
    g_autofree char *path = g_strdup_printf("%s/%s", directory, name);
    char *dot = strrchr(path, '.');
    g_autofree char *json =
        g_strdup_printf("%.*s.json", dot ? (int)(dot - path) : 0, path);
    if (stat(path, &is) || stat(json, &described)) {
        described.st_size = described.st_size > 0 ? described.st_size : 0;
    }
    return g_strdup_printf("%lld %lld.%ld %lld %lld.%ld", (long long)is.st_size,
                           (long long)is.st_mtim.tv_sec, is.st_mtim.tv_nsec,
                           (long long)described.st_size,
                           (long long)described.st_mtim.tv_sec,
                           described.st_mtim.tv_nsec);
}

static const Pelagos__ModelInfo *know(struct asked *a, const char *name)
{
    struct pel_catalogue *c = a->scene->catalogue;
    const char *directory = a->scene->files.models;
    char *stamp = pel_builtin_find(name) || !directory
                      ? g_strdup("")
                      : stamp_of(directory, name);
    struct known *k = g_hash_table_lookup(c->known, name);
    if (k && strcmp(k->stamp, stamp) == 0) {
        g_free(stamp);
        return k->info;
    }
    if (pel_now_ns() > a->end_ns) {
        g_free(stamp);
        return NULL;
    }
    k = g_new0(struct known, 1);
    k->stamp = stamp;
    k->info = look_at(name, directory);
    g_hash_table_replace(c->known, g_strdup(name), k);
    return k->info;
}

/* What is known of a model before it is read. */
static Pelagos__ModelInfo *not_yet(const char *name)
{
    const struct pel_builtin_kind *kind = pel_builtin_find(name);
    Pelagos__ModelInfo *info =
        (Pelagos__ModelInfo *)pel_message_new(&pelagos__model_info__descriptor);
    info->name = pel_sure_strdup(name);
    info->text = pel_sure_strdup("not read yet: ask again");
    if (kind) {
        SET(info, builtin, 1);
        SET(info, class_, (Pelagos__ModelClass)kind->class);
        SET(info, length, kind->length_m);
        SET(info, beam, kind->beam_m);
        SET(info, draught, kind->draught_m);
        SET(info, height, kind->height_m);
    }
    return info;
}

static void list(struct asked *a, const char *name)
{
    Pelagos__Models *out = a->answer;
    const Pelagos__ModelInfo *info = know(a, name);
    out->models = g_renew(Pelagos__ModelInfo *, out->models, out->n_models + 1);
    out->models[out->n_models++] =
        info ? (Pelagos__ModelInfo *)pel_message_copy(&info->base)
             : not_yet(name);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* NULL: it is none, or a link that leads out. */
static GDir *open_folder(const char *directory, const char *below)
{
    int fd;
    if (pel_file_find_in(directory, *below ? below : ".", &fd, NULL)) {
        return NULL;
    }
    g_autofree char *link = g_strdup_printf("/proc/self/fd/%d", fd);
    GDir *dir = g_dir_open(link, 0, NULL);
    close(fd);
    return dir;
}

/* NOLINTNEXTLINE(misc-no-recursion): MOST_DEPTH deep. */
static void find_files(const char *directory, const char *below, int depth,
                       GPtrArray *out)
{
    GDir *dir = depth <= MOST_DEPTH ? open_folder(directory, below) : NULL;
    const char *entry;
    while (dir && out->len < MOST_FILES && (entry = g_dir_read_name(dir))) {
        g_autofree char *name =
            *below ? g_strdup_printf("%s/%s", below, entry) : g_strdup(entry);
        g_autofree char *whole = g_build_filename(directory, name, NULL);
        if (entry[0] == '.' || entry[0] == '-' ||
            strlen(name) > PEL_BOUND_FILE_BYTES ||
            !g_utf8_validate(name, -1, NULL)) {
            continue;
        }
        if (g_file_test(whole, G_FILE_TEST_IS_DIR)) {
            find_files(directory, name, depth + 1, out);
        } else if (pel_model_is_file(name)) {
            g_ptr_array_add(out, g_steal_pointer(&name));
        }
    }
    if (dir) {
        g_dir_close(dir);
    }
}

static void work(struct pel_task *task)
{
    struct asked *a = (struct asked *)task;
    const char *directory = a->scene->files.models;
    size_t count;
    const struct pel_builtin_kind *kinds = pel_builtin_kinds(&count);
    a->end_ns = pel_now_ns() + MOST_NS;
    a->answer =
        (Pelagos__Models *)pel_message_new(&pelagos__models__descriptor);
    if (!a->scene->catalogue) {
        a->scene->catalogue = g_new0(struct pel_catalogue, 1);
        a->scene->catalogue->known =
            g_hash_table_new_full(g_str_hash, g_str_equal, g_free, known_free);
    }
    if (a->name) {
        list(a, a->name);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        list(a, kinds[i].name);
    }
    GPtrArray *files = g_ptr_array_new_with_free_func(g_free);
    if (directory) {
        find_files(directory, "", 1, files);
        qsort(files->pdata, files->len, sizeof *files->pdata, by_name);
    }
    for (guint i = 0; i < files->len; i++) {
        list(a, g_ptr_array_index(files, i));
    }
    g_ptr_array_free(files, TRUE);
}

static void tell(struct pel_task *task, bool dropped)
{
    struct asked *a = (struct asked *)task;
    struct pel_fault fault = { 0 };
    enum pel_err err = dropped ? pel_fault_set(&fault, PEL_ERR_CONFLICT,
                                               "the daemon is stopping")
                               : PEL_OK;
    a->done(a->user, err, &fault, err ? NULL : a->answer);
    if (a->answer) {
        pelagos__models__free_unpacked(a->answer, NULL);
    }
    g_free(a->name);
    g_free(a);
}

enum pel_err pel_scene_ask_models(struct pel_scene *scene, const char *name,
                                  pel_models_done done, void *user,
                                  struct pel_fault *fault)
{
    if (pel_worker_count(scene->shapes) >= MOST_WAITING) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d lists of models are asked for already",
                             MOST_WAITING);
    }
    struct asked *a = g_new0(struct asked, 1);
    a->task = (struct pel_task){ .work = work, .done = tell };
    a->scene = scene;
    a->name = g_strdup(name);
    a->done = done;
    a->user = user;
    pel_worker_push(scene->shapes, &a->task);
    return PEL_OK;
}
