/* Changes of the state under a name: preset list, save, apply, delete. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "proto/fault.h"
#include "proto/json.h"
#include "proto/message.h"
#include "proto/path.h"

static const Pelagos__Preset *find(const Pelagos__State *state,
                                   const char *name)
{
    for (size_t i = 0; i < state->n_presets; i++) {
        if (strcmp(state->presets[i]->name, name) == 0) {
            return state->presets[i];
        }
    }
    return NULL;
}

/* The one of that name, or why there is none. */
static enum ctl_exit need(struct ctl *ctl, const Pelagos__State *state,
                          const char *name, const Pelagos__Preset **out)
{
    struct pel_fault fault;
    *out = find(state, name);
    if (*out) {
        return CTL_DONE;
    }
    pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                  "there is no preset called \"%.64s\"; `pelagosctl preset "
                  "list` shows those that there are",
                  name);
    g_snprintf(fault.path, sizeof fault.path, "presets.%.64s", name);
    return ctl_report_fault(ctl, &fault);
}

static enum ctl_exit list(struct ctl *ctl, const Pelagos__State *state)
{
    if (ctl_flag(ctl, "json")) {
        Pelagos__State only = PELAGOS__STATE__INIT;
        only.presets = state->presets;
        only.n_presets = state->n_presets;
        char *text = pel_json_from_message(&only.base, true);
        puts(state->n_presets ? text : "{\"presets\":[]}");
        free(text);
        return CTL_DONE;
    }
    for (size_t i = 0; i < state->n_presets; i++) {
        const Pelagos__Preset *preset = state->presets[i];
        ctl_print(stdout, "%-20s %-24s %s\n", preset->name,
                  preset->title ? preset->title : "-",
                  preset->patch ? preset->patch : "{}");
    }
    return CTL_DONE;
}

/* --- save ----------------------------------------------------------------- */

struct parts {
    const Pelagos__State *state;
    GString *text;
    const char *open; /* the part that is being written; NULL: none */
};

static const ProtobufCMessage *part_of(const Pelagos__State *state,
                                       const char *path)
{
    return g_str_has_prefix(path, "sea.")     ? &state->sea->base
           : g_str_has_prefix(path, "sky.")   ? &state->sky->base
           : g_str_has_prefix(path, "water.") ? &state->water->base
                                              : NULL;
}

/* A field right below sea, sky or water: its value, null where it has none. */
static void add_field(const char *path, const struct pel_path_info *info,
                      void *user)
{
    struct parts *parts = user;
    const ProtobufCMessage *part = part_of(parts->state, path);
    const char *dot = strchr(path, '.');
    if (!part || strchr(dot + 1, '.')) {
        return;
    }
    const char *type = part->descriptor->short_name;
    if (parts->open != type) {
        g_string_append_printf(parts->text, "%s\"%.*s\":{",
                               parts->open ? "}," : "{", (int)(dot - path),
                               path);
        parts->open = type;
    } else {
        g_string_append_c(parts->text, ',');
    }
    char *value = pel_message_has(part, info->field)
                      ? pel_json_from_field(part, info->field, false)
                      : NULL;
    g_string_append_printf(parts->text, "\"%s\":%s", dot + 1,
                           value ? value : "null");
    free(value);
}

/* The merge patch that brings sea, sky and water back; g_free(). */
static char *patch_of(const Pelagos__State *state)
{
    struct parts parts = { state, g_string_new(NULL), NULL };
    pel_path_each(add_field, &parts);
    g_string_append(parts.text, "}}");
    return g_string_free(parts.text, FALSE);
}

static enum ctl_exit save(struct ctl *ctl, const Pelagos__State *state,
                          const char *name)
{
    const char *given = ctl_value(ctl, "patch");
    g_autofree char *text = given ? g_strdup(given) : patch_of(state);
    Pelagos__Preset preset = PELAGOS__PRESET__INIT, *presets = &preset;
    Pelagos__State only = PELAGOS__STATE__INIT;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    preset.name = (char *)name;
    preset.title = (char *)ctl_value(ctl, "title");
    preset.patch = text;
    only.n_presets = 1;
    only.presets = &presets;
    patch.state = &only;
    return ctl_patch(ctl, &patch, NULL);
}

/* --- apply, delete -------------------------------------------------------- */

static enum ctl_exit apply(struct ctl *ctl, const Pelagos__State *state,
                           const char *name)
{
    const Pelagos__Preset *preset = NULL;
    struct pel_fault fault;
    Pelagos__Patch *patch = NULL;
    enum ctl_exit status = need(ctl, state, name, &preset);
    if (status != CTL_DONE) {
        return status;
    }
    const char *text = preset->patch ? preset->patch : "{}";
    if (pel_json_merge_patch(text, strlen(text), &patch, &fault)) {
        return ctl_report_fault(ctl, &fault);
    }
    status = ctl_patch(ctl, patch, NULL);
    pelagos__patch__free_unpacked(patch, NULL);
    return status;
}

static enum ctl_exit forget(struct ctl *ctl, const Pelagos__State *state,
                            const char *name)
{
    const Pelagos__Preset *preset = NULL;
    enum ctl_exit status = need(ctl, state, name, &preset);
    if (status != CTL_DONE) {
        return status;
    }
    g_autofree char *path = g_strdup_printf("presets.%s", name);
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    patch.n_remove = 1;
    patch.remove = &path;
    return ctl_patch(ctl, &patch, NULL);
}

enum ctl_exit ctl_preset(struct ctl *ctl)
{
    static const struct {
        const char *name;
        enum ctl_exit (*run)(struct ctl *ctl, const Pelagos__State *state,
                             const char *name_of_it);
    } verbs[] = { { "save", save }, { "apply", apply }, { "delete", forget } };
    const char *verb = ctl->args[0];
    bool lists = strcmp(verb, "list") == 0;
    size_t at = 0;
    while (at < G_N_ELEMENTS(verbs) && strcmp(verbs[at].name, verb) != 0) {
        at++;
    }
    if (!lists && at == G_N_ELEMENTS(verbs)) {
        return ctl_say(CTL_USAGE,
                       "preset %s? list, save NAME, apply NAME or "
                       "delete NAME",
                       verb);
    }
    if (ctl->arg_count != (lists ? 1 : 2)) {
        return ctl_say(CTL_USAGE,
                       lists ? "preset list takes no name"
                             : "preset %s needs one name",
                       verb);
    }
    Pelagos__State *state = NULL;
    enum ctl_exit status = ctl_fetch(ctl, &state);
    if (status == CTL_DONE) {
        status =
            lists ? list(ctl, state) : verbs[at].run(ctl, state, ctl->args[1]);
        pelagos__state__free_unpacked(state, NULL);
    }
    return status;
}
