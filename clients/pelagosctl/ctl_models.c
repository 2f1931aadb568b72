/* The commands that list models and judge their files. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "json.h"
#include "models/modelload.h"

static void print_triangles(GString *out, const uint32_t *levels, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        g_string_append_printf(out, "%s%u", i ? "/" : "", levels[i]);
    }
}

static const char *class_of(const Pelagos__ModelInfo *m)
{
    const ProtobufCEnumValue *value = protobuf_c_enum_descriptor_get_value(
        &pelagos__model_class__descriptor, (int)m->class_);
    return value ? value->name : "?";
}

static void print_model(const Pelagos__ModelInfo *m)
{
    if (m->error) {
        ctl_print(stdout, "%-22s %s\n", m->name, m->error->message);
        return;
    }
    if (m->n_triangles == 0) {
        ctl_print(stdout, "%-22s %s\n", m->name, m->text ? m->text : "");
        return;
    }
    g_autoptr(GString) levels = g_string_new(NULL);
    print_triangles(levels, m->triangles, m->n_triangles);
    ctl_print(stdout, "%-22s %-18s %6.4g %6.4g %6.4g %6.4g  %-26s %7.2f  %s\n",
              m->name, class_of(m), m->length, m->beam, m->draught, m->height,
              levels->str, (double)m->bytes / 1048576, m->text ? m->text : "");
}

static void print_all(const Pelagos__Models *models)
{
    printf("%-22s %-18s %6s %6s %6s %6s  %-26s %7s\n", "name", "class",
           "length", "beam", "draft", "height", "triangles", "MiB");
    for (size_t i = 0; i < models->n_models; i++) {
        print_model(models->models[i]);
    }
}

enum ctl_exit ctl_models(struct ctl *ctl)
{
    Pelagos__ModelsQuery query = PELAGOS__MODELS_QUERY__INIT;
    Pelagos__Models *models = NULL;
    struct pel_client_error error;
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    query.name = ctl->arg_count > 0 ? (char *)ctl->args[0] : NULL;
    if (pel_client_models(ctl->client, &query, &models, &error)) {
        return ctl_report(ctl, &error);
    }
    if (ctl_flag(ctl, "json")) {
        char *text = pel_json_from_message(&models->base, true);
        puts(text);
        free(text);
    } else {
        print_all(models);
    }
    bool refused =
        query.name && models->n_models == 1 && models->models[0]->error;
    pelagos__models__free_unpacked(models, NULL);
    return refused ? CTL_REFUSED : CTL_DONE;
}

static void print_found(const struct pel_model *m, const char *notes)
{
    g_autoptr(GString) levels = g_string_new(NULL);
    for (int i = 0; i < m->level_count; i++) {
        g_string_append_printf(levels, "%s%zu", i ? "/" : "",
                               m->levels[i].triangles);
    }
    ctl_print(stdout, "%s: %s, %.4g x %.4g m, draught %.4g m, height %.4g m\n",
              m->name, pel_model_class_text(m->class), m->length_m, m->beam_m,
              m->draught_m, m->height_m);
    printf("triangles %s, %zu materials, %zu textures, %zu nodes, %.2f MiB\n",
           levels->str, m->material_count, m->texture_count, m->node_count,
           (double)m->bytes / 1048576);
    if (m->column_count == 0) {
        puts("nothing of it is below the waterline: say its draught in the "
             ".json beside it");
    }
    if (*notes) {
        ctl_print(stdout, "%s\n", notes);
    }
}

enum ctl_exit ctl_model(struct ctl *ctl)
{
    if (strcmp(ctl->args[0], "check") != 0) {
        return ctl_say(CTL_USAGE, "model what? `pelagosctl model check FILE`");
    }
    g_autofree char *folder = g_path_get_dirname(ctl->args[1]);
    g_autofree char *name = g_path_get_basename(ctl->args[1]);
    const struct pel_model_source source = { .directory = folder,
                                             .file = name };
    const struct pel_model *model = NULL;
    struct pel_fault fault = { 0 };
    char notes[PEL_MODEL_NOTES];
    if (pel_model_load(&source, &model, notes, &fault)) {
        return ctl_say(CTL_FAILED, "%s", fault.message);
    }
    print_found(model, notes);
    pel_model_unref(model);
    return CTL_DONE;
}
