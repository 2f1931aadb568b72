/* The commands that read and change the state. */
#include "pelagosctl/ctl.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/err.h"
#include "proto/json.h"
#include "proto/path.h"

/* Prints what lies at or below `path`; false: nothing does. */
static bool print_below(const struct ctl_leaves *leaves, const char *path,
                        bool bare, bool json)
{
    bool found = false;
    for (size_t i = 0; i < leaves->count; i++) {
        const struct ctl_leaf *leaf = &leaves->items[i];
        if (!ctl_path_below(leaf->path, path)) {
            continue;
        }
        found = true;
        if (bare && strcmp(leaf->path, path) == 0) {
            puts(leaf->value);
        } else {
            ctl_print_leaf(stdout, leaf, json);
        }
    }
    return found;
}

/* Whether there is something at or below the path, or a field that is not
 * set: DONE, else the reason has been printed. */
static enum ctl_exit check_path(struct ctl *ctl, const Pelagos__State *state,
                                const struct ctl_leaves *leaves,
                                const char *path)
{
    for (size_t i = 0; i < leaves->count; i++) {
        if (ctl_path_below(leaves->items[i].path, path)) {
            return CTL_DONE;
        }
    }
    struct pel_path_info info;
    struct pel_fault fault;
    char text[64];
    if (pel_path_find(path, &info, &fault) != PEL_OK ||
        pel_path_get(state, path, text, sizeof text, &fault) ==
            PEL_ERR_NOT_FOUND) {
        return ctl_report_fault(ctl, &fault);
    }
    return CTL_DONE;
}

static enum ctl_exit get_path(struct ctl *ctl, const Pelagos__State *state,
                              const struct ctl_leaves *leaves, const char *path)
{
    bool json = ctl_flag(ctl, "json");
    bool alone = ctl->arg_count == 1;
    g_autofree char *full = ctl_canonical_path(state, path);
    if (print_below(leaves, full, alone && !json, json)) {
        return CTL_DONE;
    }
    enum ctl_exit status = check_path(ctl, state, leaves, full);
    if (status != CTL_DONE) {
        return status;
    }
    if (json) {
        printf("{\"path\":\"%s\",\"value\":null}\n", full);
    } else if (!alone) {
        printf("%s is not set\n", full);
    }
    return CTL_DONE;
}

enum ctl_exit ctl_get(struct ctl *ctl)
{
    Pelagos__State *state = NULL;
    enum ctl_exit status = ctl_fetch(ctl, &state);
    if (status != CTL_DONE) {
        return status;
    }
    if (ctl->arg_count == 0 && ctl_flag(ctl, "json")) {
        char *text = pel_json_from_message(&state->base, true);
        puts(text);
        free(text);
    } else {
        struct ctl_leaves leaves = ctl_flatten(state);
        if (ctl->arg_count == 0) {
            for (size_t i = 0; i < leaves.count; i++) {
                ctl_print_leaf(stdout, &leaves.items[i], false);
            }
        }
        for (size_t i = 0; i < ctl->arg_count && status == CTL_DONE; i++) {
            status = get_path(ctl, state, &leaves, ctl->args[i]);
        }
        ctl_leaves_free(&leaves);
    }
    pelagos__state__free_unpacked(state, NULL);
    return status;
}

/* Sends the patch and shows what the named paths are now. */
static enum ctl_exit send_patch(struct ctl *ctl, const Pelagos__Patch *patch,
                                char *const *paths)
{
    Pelagos__State *state = NULL;
    enum ctl_exit status = ctl_patch(ctl, patch, &state);
    if (status != CTL_DONE) {
        return status;
    }
    if (!ctl_flag(ctl, "quiet")) {
        struct ctl_leaves leaves = ctl_flatten(state);
        for (size_t i = 0; paths[i]; i++) {
            g_autofree char *full = ctl_canonical_path(state, paths[i]);
            print_below(&leaves, full, false, ctl_flag(ctl, "json"));
        }
        ctl_leaves_free(&leaves);
    }
    pelagos__state__free_unpacked(state, NULL);
    return CTL_DONE;
}

enum ctl_exit ctl_assign(struct ctl *ctl, Pelagos__Patch *patch,
                         const Pelagos__State *now, const char *text,
                         char **path)
{
    const char *equals = strchr(text, '=');
    if (!equals || equals == text) {
        return ctl_say(CTL_USAGE,
                       "\"%s\" is not PATH=VALUE, like "
                       "sea.windSpeed=12",
                       text);
    }
    *path = g_strndup(text, (size_t)(equals - text));
    struct pel_fault fault;
    if (pel_path_set(patch, now, *path, equals + 1, &fault) != PEL_OK) {
        return ctl_report_fault(ctl, &fault);
    }
    return CTL_DONE;
}

/* Whether the view or entity is there that a path is below of; any other path
 * is none's. */
static bool holder_exists(const Pelagos__State *now, const char *path)
{
    g_auto(GStrv) steps = g_strsplit(path, ".", 3);
    bool view = steps[0] && strcmp(steps[0], "views") == 0;
    if (!steps[0] || !steps[1] || (!view && strcmp(steps[0], "entities"))) {
        return true;
    }
    for (size_t i = 0; view && i < now->n_views; i++) {
        if (strcmp(now->views[i]->name, steps[1]) == 0) {
            return true;
        }
    }
    for (size_t i = 0; !view && i < now->n_entities; i++) {
        const Pelagos__Entity *entity = now->entities[i];
        g_autofree char *id = g_strdup_printf("%u", entity->id);
        if (strcmp(id, steps[1]) == 0 ||
            g_strcmp0(entity->name, steps[1]) == 0) {
            return true;
        }
    }
    return false;
}

/* A mistyped name is not to make a camera that nobody sees. */
static enum ctl_exit check_holder(struct ctl *ctl, const Pelagos__State *now,
                                  const char *path)
{
    struct pel_fault fault;
    if (ctl_flag(ctl, "create") || holder_exists(now, path)) {
        return CTL_DONE;
    }
    bool view = g_str_has_prefix(path, "views.");
    g_auto(GStrv) steps = g_strsplit(path, ".", 3);
    pel_fault_set(&fault, PEL_ERR_NOT_FOUND,
                  "there is no such %s; --create adds it",
                  view ? "view" : "entity");
    g_snprintf(fault.path, sizeof fault.path, "%s.%s", steps[0], steps[1]);
    return ctl_report_fault(ctl, &fault);
}

enum ctl_exit ctl_set(struct ctl *ctl)
{
    Pelagos__State *now = NULL;
    enum ctl_exit status = ctl_fetch(ctl, &now);
    if (status != CTL_DONE) {
        return status;
    }
    Pelagos__Patch *patch = pel_patch_new();
    g_auto(GStrv) paths = g_new0(char *, ctl->arg_count + 1);
    for (size_t i = 0; i < ctl->arg_count && status == CTL_DONE; i++) {
        status = ctl_assign(ctl, patch, now, ctl->args[i], &paths[i]);
        if (status == CTL_DONE) {
            status = check_holder(ctl, now, paths[i]);
        }
    }
    if (status == CTL_DONE) {
        status = send_patch(ctl, patch, paths);
    }
    pelagos__patch__free_unpacked(patch, NULL);
    pelagos__state__free_unpacked(now, NULL);
    return status;
}

enum ctl_exit ctl_unset(struct ctl *ctl)
{
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    patch.n_remove = ctl->arg_count;
    patch.remove = (char **)ctl->args;
    return send_patch(ctl, &patch, (char *const *)ctl->args);
}

enum ctl_exit ctl_step(struct ctl *ctl)
{
    double seconds = 1.0 / 30.0;
    if (ctl->arg_count > 0 && !ctl_parse_number(ctl->args[0], &seconds)) {
        return ctl_say(CTL_USAGE, "\"%s\" is not a number of seconds",
                       ctl->args[0]);
    }
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    Pelagos__State *state = NULL;
    struct pel_client_error error;
    if (pel_client_step(ctl->client, seconds, &state, &error)) {
        status = ctl_report(ctl, &error);
        if (error.code == PEL_CLIENT_CONFLICT && !ctl_flag(ctl, "json")) {
            fputs("  first: pelagosctl set clock.mode=STEPPED\n", stderr);
        }
        return status;
    }
    struct ctl_leaves leaves = ctl_flatten(state);
    print_below(&leaves, "clock.time", false, ctl_flag(ctl, "json"));
    ctl_leaves_free(&leaves);
    pelagos__state__free_unpacked(state, NULL);
    return CTL_DONE;
}

static void print_view_json(const Pelagos__View *view, bool last)
{
    char *text = pel_json_from_message(&view->base, false);
    printf("  %s%s\n", text, last ? "" : ",");
    free(text);
}

static void print_view(const Pelagos__View *view)
{
    char size[32], field[32];
    g_snprintf(size, sizeof size, "%ux%u", view->width, view->height);
    if (view->frustum) {
        g_strlcpy(field, "off-axis", sizeof field);
    } else {
        g_snprintf(field, sizeof field, "%g deg", view->field_of_view);
    }
    char holder[32] = "world";
    if (view->has_entity) {
        g_snprintf(holder, sizeof holder, "%u", view->entity);
    } else if (view->at || view->orbit || view->satellite ||
               view->n_waypoints > 0) {
        g_strlcpy(holder,
                  view->at          ? "at"
                  : view->orbit     ? "orbit"
                  : view->satellite ? "sat"
                                    : "way",
                  sizeof holder);
    }
    printf("%-16s %-10s %-9s %-7s yaw %g, pitch %g deg, up %g m\n", view->name,
           size, field, holder, view->yaw, view->pitch, view->up);
}

enum ctl_exit ctl_views(struct ctl *ctl)
{
    Pelagos__State *state = NULL;
    enum ctl_exit status = ctl_fetch(ctl, &state);
    if (status != CTL_DONE) {
        return status;
    }
    bool json = ctl_flag(ctl, "json");
    if (json) {
        puts("[");
    } else {
        printf("%-16s %-10s %-9s %-7s %s\n", "NAME", "SIZE", "FIELD", "ON",
               "CAMERA");
    }
    for (size_t i = 0; i < state->n_views; i++) {
        if (json) {
            print_view_json(state->views[i], i + 1 == state->n_views);
        } else {
            print_view(state->views[i]);
        }
    }
    if (json) {
        puts("]");
    }
    pelagos__state__free_unpacked(state, NULL);
    return CTL_DONE;
}

/* Whether a change of `path` is to be shown. Without filters time and the
 * revision are not: they change always. */
static bool is_watched(const char *path, char *const *filters)
{
    if (!filters[0]) {
        return strcmp(path, "clock.time") != 0 &&
               strcmp(path, "revision") != 0 &&
               !g_str_has_suffix(path, ".poseTime");
    }
    for (size_t i = 0; filters[i]; i++) {
        if (ctl_path_below(path, filters[i])) {
            return true;
        }
    }
    return false;
}

static GHashTable *index_leaves(const struct ctl_leaves *leaves)
{
    GHashTable *table = g_hash_table_new(g_str_hash, g_str_equal);
    for (size_t i = 0; i < leaves->count; i++) {
        g_hash_table_insert(table, leaves->items[i].path,
                            leaves->items[i].value);
    }
    return table;
}

/* Prints the leaves of `after` that differ and those that are gone; how many.
 */
static size_t print_changes(const struct ctl_leaves *before,
                            const struct ctl_leaves *after,
                            char *const *filters, bool json)
{
    size_t shown = 0;
    g_autoptr(GHashTable) old = index_leaves(before);
    g_autoptr(GHashTable) new = index_leaves(after);
    for (size_t i = 0; i < after->count; i++) {
        const struct ctl_leaf *leaf = &after->items[i];
        const char *value = g_hash_table_lookup(old, leaf->path);
        if ((!value || strcmp(value, leaf->value) != 0) &&
            is_watched(leaf->path, filters)) {
            ctl_print_leaf(stdout, leaf, json);
            shown++;
        }
    }
    for (size_t i = 0; i < before->count; i++) {
        const char *path = before->items[i].path;
        if (!g_hash_table_contains(new, path) && is_watched(path, filters)) {
            printf(json ? "{\"path\":\"%s\",\"value\":null}\n"
                        : "%s is not set\n",
                   path);
            shown++;
        }
    }
    fflush(stdout);
    return shown;
}

/* Shows changes until `count` lines, the deadline or a signal. */
static enum ctl_exit watch_loop(struct ctl *ctl, struct ctl_leaves *leaves,
                                char *const *filters, double count,
                                gint64 deadline_us)
{
    double shown = 0;
    while (shown < count && !ctl_interrupted) {
        gint64 left_us = deadline_us - g_get_monotonic_time();
        if (left_us <= 0) {
            break;
        }
        Pelagos__State *state = NULL;
        struct pel_client_error error;
        /* In slices, so that a signal is seen. */
        int slice_ms = left_us < 200000 ? (int)(left_us / 1000) + 1 : 200;
        enum pel_client_code code =
            pel_client_next_state(ctl->client, slice_ms, &state, &error);
        if (code == PEL_CLIENT_TIMEOUT) {
            continue;
        }
        if (code != PEL_CLIENT_OK) {
            return ctl_report(ctl, &error);
        }
        struct ctl_leaves now = ctl_flatten(state);
        pelagos__state__free_unpacked(state, NULL);
        shown +=
            (double)print_changes(leaves, &now, filters, ctl_flag(ctl, "json"));
        ctl_leaves_free(leaves);
        *leaves = now;
    }
    return CTL_DONE;
}

enum ctl_exit ctl_watch(struct ctl *ctl)
{
    double count = 1e15, seconds = 1e9;
    enum ctl_exit status = ctl_number(ctl, "count", 1, 1e9, &count);
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "seconds", 0.1, 1e9, &seconds);
    }
    if (status == CTL_DONE) {
        status = ctl_connect(ctl);
    }
    if (status != CTL_DONE) {
        return status;
    }
    Pelagos__State *state = NULL;
    struct pel_client_error error;
    if (pel_client_watch(ctl->client, &state, &error)) {
        return ctl_report(ctl, &error);
    }
    g_auto(GStrv) filters = g_new0(char *, ctl->arg_count + 1);
    for (size_t i = 0; i < ctl->arg_count; i++) {
        filters[i] = ctl_canonical_path(state, ctl->args[i]);
    }
    struct ctl_leaves leaves = ctl_flatten(state);
    for (size_t i = 0; filters[i] && status == CTL_DONE; i++) {
        status = check_path(ctl, state, &leaves, filters[i]);
    }
    pelagos__state__free_unpacked(state, NULL);
    if (status == CTL_DONE) {
        ctl_catch_signals();
        gint64 deadline_us = g_get_monotonic_time() + (gint64)(seconds * 1e6);
        status = watch_loop(ctl, &leaves, filters, count, deadline_us);
    }
    ctl_leaves_free(&leaves);
    return status;
}
