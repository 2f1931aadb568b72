#include "base/metrics.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/log.h"

#define MAX_ROOMS 32

struct room {
    pel_metrics_collect collect;
    void *user;
};

struct pel_metrics {
    struct room rooms[MAX_ROOMS];
    size_t count;
};

struct family {
    char *name;
    char *help;
    enum pel_metric_type type;
    GString *samples;
};

struct pel_metrics_page {
    GTree *families; /* name -> struct family, in order */
};

static int compare_names(const void *a, const void *b, void *user)
{
    (void)user;
    return strcmp(a, b);
}

static void family_free(void *data)
{
    struct family *family = data;
    g_free(family->name);
    g_free(family->help);
    g_string_free(family->samples, TRUE);
    g_free(family);
}

static void append_value(GString *out, double value)
{
    if (isnan(value)) {
        g_string_append(out, "NaN");
    } else if (isinf(value)) {
        g_string_append(out, value > 0 ? "+Inf" : "-Inf");
    } else {
        char text[G_ASCII_DTOSTR_BUF_SIZE];
        g_ascii_formatd(text, sizeof text, "%.15g", value);
        g_string_append(out, text);
    }
}

void pel_metric(struct pel_metrics_page *page, const char *name,
                enum pel_metric_type type, const char *help, const char *labels,
                double value)
{
    struct family *family = g_tree_lookup(page->families, name);
    if (!family) {
        family = g_new0(struct family, 1);
        family->name = g_strdup(name);
        family->help = g_strdup(help);
        family->type = type;
        family->samples = g_string_new(NULL);
        g_tree_insert(page->families, family->name, family);
    }
    g_string_append(family->samples, name);
    if (labels && *labels) {
        g_string_append_printf(family->samples, "{%s}", labels);
    }
    g_string_append_c(family->samples, ' ');
    append_value(family->samples, value);
    g_string_append_c(family->samples, '\n');
}

struct pel_metrics *pel_metrics_create(void)
{
    return g_new0(struct pel_metrics, 1);
}

void pel_metrics_destroy(struct pel_metrics *metrics)
{
    g_free(metrics);
}

void pel_metrics_add(struct pel_metrics *metrics, pel_metrics_collect collect,
                     void *user)
{
    if (metrics->count == MAX_ROOMS) {
        pel_error("MET-001", "too many collectors of metrics");
        return;
    }
    metrics->rooms[metrics->count++] = (struct room){ collect, user };
}

void pel_metrics_remove(struct pel_metrics *metrics,
                        pel_metrics_collect collect, void *user)
{
    for (size_t i = 0; i < metrics->count; i++) {
        struct room *room = &metrics->rooms[i];
        if (room->collect == collect && room->user == user) {
            metrics->count--;
            memmove(room, room + 1,
                    (metrics->count - i) * sizeof metrics->rooms[0]);
            return;
        }
    }
}

static const char *type_name(enum pel_metric_type type)
{
    switch (type) {
    case PEL_METRIC_COUNTER:
        return "counter";
    case PEL_METRIC_SUMMARY:
        return "summary";
    case PEL_METRIC_GAUGE:
        break;
    }
    return "gauge";
}

static gboolean append_family(void *key, void *value, void *user)
{
    (void)key;
    const struct family *family = value;
    g_string_append_printf(user, "# HELP %s %s\n# TYPE %s %s\n%s", family->name,
                           family->help, family->name, type_name(family->type),
                           family->samples->str);
    return FALSE;
}

char *pel_metrics_text(struct pel_metrics *metrics, size_t *size)
{
    struct pel_metrics_page page = {
        .families = g_tree_new_full(compare_names, NULL, NULL, family_free),
    };
    for (size_t i = 0; i < metrics->count; i++) {
        metrics->rooms[i].collect(metrics->rooms[i].user, &page);
    }
    GString *out = g_string_new(NULL);
    g_tree_foreach(page.families, append_family, out);
    g_tree_unref(page.families);
    if (size) {
        *size = out->len;
    }
    return g_string_free(out, FALSE);
}
