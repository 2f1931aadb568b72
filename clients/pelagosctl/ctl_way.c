/* record --waypoints: a view goes the way that a file describes. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "proto/fault.h"
#include "proto/json.h"

#define MOST_BYTES 65536

static enum ctl_exit read_text(const char *path, char **out)
{
    g_autoptr(GError) error = NULL;
    gsize size = 0;
    if (!g_file_get_contents(path, out, &size, &error)) {
        return ctl_say(CTL_FAILED, "%s", error->message);
    }
    if (size > MOST_BYTES || strlen(*out) != size) {
        return ctl_say(CTL_FAILED,
                       "%s: is no list of waypoints, CSV or JSON of at most "
                       "64 kB",
                       path);
    }
    return CTL_DONE;
}

/* One line of a CSV as an object; an empty value is left out. */
static enum ctl_exit add_row(const char *path, size_t number,
                             const char *const *names, const char *line,
                             GString *json)
{
    g_auto(GStrv) cells = g_strsplit(line, ",", -1);
    if (g_strv_length(cells) != g_strv_length((GStrv)names)) {
        return ctl_say(CTL_FAILED, "%s: line %zu has not the head's columns",
                       path, number);
    }
    g_string_append(json, json->str[json->len - 1] == '[' ? "{" : ",{");
    for (size_t i = 0; names[i]; i++) {
        double value;
        if (!*g_strstrip(cells[i])) {
            continue;
        }
        if (!ctl_parse_number(cells[i], &value)) {
            return ctl_say(CTL_FAILED, "%s: line %zu: \"%s\" is no number",
                           path, number, cells[i]);
        }
        bool first = json->str[json->len - 1] == '{';
        g_string_append_printf(json, "%s\"%s\":%.17g", first ? "" : ",",
                               names[i], value);
    }
    g_string_append_c(json, '}');
    return CTL_DONE;
}

/* Columns are named in the head as the schema names a Waypoint's fields. */
static enum ctl_exit from_csv(const char *path, const char *text, GString *json)
{
    g_auto(GStrv) lines = g_strsplit(text, "\n", -1);
    g_auto(GStrv) names = g_strsplit(lines[0], ",", -1);
    enum ctl_exit status = CTL_DONE;
    for (size_t i = 0; names[i]; i++) {
        g_strstrip(names[i]);
        if (!*names[i] || strspn(names[i], "abcdefghijklmnopqrstuvwxyz"
                                           "ABCDEFGHIJKLMNOPQRSTUVWXYZ") !=
                              strlen(names[i])) {
            return ctl_say(CTL_FAILED,
                           "%s: the first line must name columns: "
                           "time,latitude,longitude,height,heading,pitch,roll",
                           path);
        }
    }
    g_string_append_c(json, '[');
    for (size_t i = 1; lines[i] && status == CTL_DONE; i++) {
        if (*g_strstrip(lines[i])) {
            status = add_row(path, i + 1, (const char *const *)names, lines[i],
                             json);
        }
    }
    g_string_append_c(json, ']');
    return status;
}

static enum ctl_exit send(struct ctl *ctl, const char *path, const char *json,
                          double *first_s, double *last_s)
{
    struct pel_fault fault;
    Pelagos__Patch *patch = NULL;
    if (pel_json_merge_patch(json, strlen(json), &patch, &fault)) {
        ctl_say(CTL_FAILED, "%s: is not a list of waypoints", path);
        return ctl_report_fault(ctl, &fault);
    }
    const Pelagos__View *view = patch->state->views[0];
    enum ctl_exit status = CTL_DONE;
    if (view->n_waypoints == 0) {
        status = ctl_say(CTL_FAILED, "%s: has no waypoint", path);
    } else {
        *first_s = view->waypoints[0]->time;
        *last_s = view->waypoints[view->n_waypoints - 1]->time;
        status = ctl_patch(ctl, patch, NULL);
    }
    pelagos__patch__free_unpacked(patch, NULL);
    return status;
}

enum ctl_exit ctl_way(struct ctl *ctl, const char *view, double *first_s,
                      double *last_s)
{
    const char *path = ctl_value(ctl, "waypoints");
    g_autofree char *text = NULL;
    enum ctl_exit status = read_text(path, &text);
    if (status != CTL_DONE) {
        return status;
    }
    g_autoptr(GString) json = g_string_new("{\"views\":{");
    char *name = pel_json_string(view);
    g_string_append(json, name);
    free(name);
    g_string_append(json, ":{\"entity\":null,\"at\":null,\"orbit\":null,"
                          "\"satellite\":null,\"waypoints\":");
    char *begin = g_strchug(text);
    if (*begin == '[') {
        g_string_append(json, begin);
    } else {
        status = from_csv(path, begin, json);
    }
    g_string_append(json, "}}}");
    return status == CTL_DONE ? send(ctl, path, json->str, first_s, last_s)
                              : status;
}
