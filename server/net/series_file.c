/* A series as lists, as CSV, and as what goes out to who asked. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "bounds.h"
#include "json.h"
#include "message.h"
#include "net/series_parts.h"
#include "wire.h"

#define CSV_NUMBERS (3 * PEL_BOUND_SERIES_VALUES)

static char *copy(const char *text)
{
    return text ? pel_sure_strdup(text) : NULL;
}

static void fill(Pelagos__SeriesList *list, const char *name, const char *unit,
                 const char *text, const char *standard, const double *values,
                 size_t count)
{
    list->name = copy(name);
    list->unit = copy(unit ? unit : "1");
    list->text = copy(text ? text : "");
    list->standard_name = copy(standard);
    list->values = pel_sure_malloc((count + 1) * sizeof *list->values);
    memcpy(list->values, values, count * sizeof *values);
    list->n_values = count;
}

static Pelagos__SeriesList *append(Pelagos__Series *out, const char *which)
{
    return (Pelagos__SeriesList *)pel_message_append(
        &out->base, protobuf_c_message_descriptor_get_field_by_name(
                        out->base.descriptor, which));
}

static void add_axes(const struct pel_series_table *table, Pelagos__Series *out)
{
    const struct pel_series_plan *plan = table->plan;
    for (unsigned i = 0; i < plan->axis_count; i++) {
        const struct pel_series_axis *axis = &plan->axes[i];
        const struct pel_field *info =
            pel_field_info(axis->message, axis->field);
        fill(append(out, "axes"), axis->name, info->unit,
             pel_cf_text(axis->message, axis->field),
             pel_cf_name(axis->message, axis->field), axis->values,
             axis->count);
    }
    for (int i = 0; i < PEL_INNER_COUNT; i++) {
        const ProtobufCMessageDescriptor *message;
        const ProtobufCFieldDescriptor *field =
            pel_series_inner_field(i, &message);
        if (table->inner_size[i] == 0) {
            continue;
        }
        fill(append(out, "axes"), pel_series_inner_name(i),
             field ? pel_field_info(message, field)->unit : "1",
             i == PEL_INNER_DIRECTION ? "Direction that waves come from."
             : field                  ? pel_cf_text(message, field)
                                      : "Number of the point.",
             field ? pel_cf_name(message, field) : NULL, table->inner_values[i],
             table->inner_size[i]);
    }
}

static void name_axes(const struct pel_series_table *table, bool outer,
                      unsigned inner, Pelagos__SeriesList *list)
{
    const struct pel_series_plan *plan = table->plan;
    for (unsigned i = 0; i < plan->axis_count && outer; i++) {
        pel_message_append_string(&list->axes, &list->n_axes,
                                  plan->axes[i].name);
    }
    for (int i = 0; i < PEL_INNER_COUNT; i++) {
        if (inner >> i & 1) {
            pel_message_append_string(&list->axes, &list->n_axes,
                                      pel_series_inner_name(i));
        }
    }
}

/* Where the points of a surface are. */
static void add_points(const struct pel_series_table *table,
                       Pelagos__Series *out)
{
    const Pelagos__SeriesQuery *query = table->plan->query;
    size_t count = table->inner_size[PEL_INNER_POINT];
    const ProtobufCMessageDescriptor *type = &pelagos__point__descriptor;
    if (query->question_case != PELAGOS__SERIES_QUERY__QUESTION_SURFACE ||
        count == 0) {
        return;
    }
    static const char *const names[] = { "east", "north" };
    g_autofree double *values = g_new(double, count);
    for (int k = 0; k < 2; k++) {
        const ProtobufCFieldDescriptor *field =
            pel_field_by_name(type, names[k], strlen(names[k]));
        const struct pel_field *info = pel_field_info(type, field);
        for (size_t i = 0; i < count; i++) {
            const Pelagos__Point *p = query->surface->points[i];
            values[i] = k ? p->north : p->east;
        }
        Pelagos__SeriesList *list = append(out, "variables");
        fill(list, info->name, info->unit, info->doc, pel_cf_name(type, field),
             values, count);
        name_axes(table, false, 1u << PEL_INNER_POINT, list);
    }
}

static char *title_of(const Pelagos__SeriesQuery *query)
{
    static const char *const optics[] = {
        [PELAGOS__OPTICS_QUERY__QUESTION_BRDF] =
            "Sunlight reflected by the sea",
        [PELAGOS__OPTICS_QUERY__QUESTION_SKY] = "Light of the sky",
        [PELAGOS__OPTICS_QUERY__QUESTION_WATER] = "Light that leaves the water",
    };
    GString *out = g_string_new(
        query->question_case == PELAGOS__SERIES_QUERY__QUESTION_OPTICS
            ? optics[query->optics->question_case]
        : query->question_case == PELAGOS__SERIES_QUERY__QUESTION_SPECTRUM
            ? "Spectrum of the sea"
            : "Surface of the sea");
    for (size_t i = 0; i < query->n_sweep; i++) {
        g_string_append_printf(out, "%s%s", i ? ", " : " over ",
                               query->sweep[i]->over);
    }
    char *title = copy(out->str);
    g_string_free(out, TRUE);
    return title;
}

Pelagos__Series *pel_series_message(const struct pel_series_table *table,
                                    const struct pel_series_origin *origin)
{
    Pelagos__Series *out =
        (Pelagos__Series *)pel_message_new(&pelagos__series__descriptor);
    const struct pel_series_plan *plan = table->plan;
    char *question = pel_json_from_message(&plan->query->base, false);
    g_autofree char *history =
        g_strdup_printf("%s pelagosd %s on %s: %s", origin->when, PEL_VERSION,
                        origin->device, question);
    free(question);
    out->title = title_of(plan->query);
    out->history = copy(history);
    out->state = pel_json_from_message(&origin->state->base, false);
    add_axes(table, out);
    add_points(table, out);
    for (guint i = 0; i < table->columns->len; i++) {
        const struct pel_series_column *c =
            &g_array_index(table->columns, struct pel_series_column, i);
        Pelagos__SeriesList *list = append(out, "variables");
        fill(list, c->name, c->unit, c->text, pel_cf_name(c->message, c->field),
             c->values, c->block * plan->cells);
        name_axes(table, true, c->inner, list);
    }
    return out;
}

/* --- CSV ------------------------------------------------------------------ */

static void put_number(GString *out, double v)
{
    char text[32];
    if (isfinite(v)) {
        pel_json_number(v, text);
        g_string_append(out, text);
    }
}

static void put_comments(GString *out, const Pelagos__Series *s)
{
    g_string_append_printf(out, "# %s\r\n# %s\r\n# state: %s\r\n", s->title,
                           s->history, s->state);
    for (int pass = 0; pass < 2; pass++) {
        size_t count = pass ? s->n_variables : s->n_axes;
        for (size_t i = 0; i < count; i++) {
            const Pelagos__SeriesList *l = pass ? s->variables[i] : s->axes[i];
            g_string_append_printf(out, "# %s [%s] %s\r\n", l->name, l->unit,
                                   l->text);
        }
    }
    for (size_t i = 0; i < s->n_axes; i++) {
        g_string_append_printf(out, "%s%s", i ? "," : "", s->axes[i]->name);
    }
    for (size_t i = 0; i < s->n_variables; i++) {
        g_string_append_printf(out, ",%s", s->variables[i]->name);
    }
    g_string_append(out, "\r\n");
}

/* Which of a variable's values a row has, given the row's place on all axes. */
static size_t place_of(const Pelagos__Series *s, const Pelagos__SeriesList *v,
                       const size_t *at)
{
    size_t index = 0;
    for (size_t k = 0; k < v->n_axes; k++) {
        for (size_t i = 0; i < s->n_axes; i++) {
            if (strcmp(s->axes[i]->name, v->axes[k]) == 0) {
                index = index * s->axes[i]->n_values + at[i];
            }
        }
    }
    return index;
}

/* Rows of a CSV; 0 and a fault: too many for a text that repeats numbers. */
static size_t rows_of(const Pelagos__Series *s, struct pel_fault *fault)
{
    size_t rows = 1, columns = s->n_axes + s->n_variables;
    for (size_t i = 0; i < s->n_axes; i++) {
        rows *= s->axes[i]->n_values; /* at most all values of a variable */
    }
    if (rows * columns <= CSV_NUMBERS) {
        return rows;
    }
    pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                  "format: as CSV, which repeats what does not depend on every "
                  "axis, the series would have %zu numbers, more than %d: ask "
                  "for json or netcdf",
                  rows * columns, CSV_NUMBERS);
    return 0;
}

/* A row for each combination of all axes; what does not depend on one is
 * repeated. */
static char *csv(const Pelagos__Series *s, size_t rows, size_t *size)
{
    enum { MOST = PEL_SERIES_AXES + PEL_INNER_COUNT };
    GString *out = g_string_new(NULL);
    size_t at[MOST] = { 0 };
    put_comments(out, s);
    for (size_t row = 0; row < rows; row++) {
        size_t rest = row;
        for (size_t i = s->n_axes; i-- > 0;) {
            at[i] = rest % s->axes[i]->n_values;
            rest /= s->axes[i]->n_values;
        }
        for (size_t i = 0; i < s->n_axes; i++) {
            g_string_append(out, i ? "," : "");
            put_number(out, s->axes[i]->values[at[i]]);
        }
        for (size_t i = 0; i < s->n_variables; i++) {
            g_string_append_c(out, ',');
            put_number(
                out, s->variables[i]->values[place_of(s, s->variables[i], at)]);
        }
        g_string_append(out, "\r\n");
    }
    *size = out->len;
    return g_string_free(out, FALSE);
}

/* --- out ------------------------------------------------------------------ */

static void drop(Pelagos__SeriesList ***lists, size_t *count)
{
    for (size_t i = 0; i < *count; i++) {
        pelagos__series_list__free_unpacked((*lists)[i], NULL);
    }
    free(*lists);
    *lists = NULL;
    *count = 0;
}

static void pack_reply(Pelagos__Series *series,
                       const struct pel_series_form *form,
                       struct pel_series_answer *answer)
{
    Pelagos__Reply reply = PELAGOS__REPLY__INIT;
    if (answer->data) { /* the file instead of the lists */
        drop(&series->axes, &series->n_axes);
        drop(&series->variables, &series->n_variables);
        series->has_file = true;
        series->file =
            (ProtobufCBinaryData){ answer->size, (uint8_t *)answer->data };
    }
    reply.has_id = form->has_id;
    reply.id = form->id;
    reply.result_case = PELAGOS__REPLY__RESULT_SERIES;
    reply.series = series;
    answer->data = (char *)pel_wire_pack(&reply.base, &answer->size);
}

enum pel_err pel_series_file(const struct pel_series_table *table,
                             const struct pel_series_origin *origin,
                             const struct pel_series_form *form,
                             struct pel_series_answer *answer,
                             struct pel_fault *fault)
{
    Pelagos__SeriesFormat format = table->plan->query->format;
    Pelagos__Series *series = pel_series_message(table, origin);
    unsigned char *bytes = NULL;
    enum pel_err err = PEL_OK;
    if (format == PELAGOS__SERIES_FORMAT__CSV) {
        size_t rows = rows_of(series, fault);
        answer->type = "text/csv; charset=utf-8";
        answer->data = rows ? csv(series, rows, &answer->size) : NULL;
        err = rows ? PEL_OK : PEL_ERR_OUT_OF_RANGE;
    } else if (format == PELAGOS__SERIES_FORMAT__NETCDF) {
        answer->type = "application/netcdf";
        err = pel_series_netcdf(series, origin, &bytes, &answer->size, fault);
        answer->data = (char *)bytes;
    } else if (!form->reply) {
        answer->type = "application/json";
        answer->data = pel_json_from_message(&series->base, false);
        answer->size = strlen(answer->data);
    }
    if (!err && form->reply) {
        pack_reply(series, form, answer);
    }
    pelagos__series__free_unpacked(series, NULL);
    return err;
}

bool pel_series_format(const char *word, const char *accept,
                       Pelagos__SeriesFormat *out)
{
    static const struct {
        const char *word, *type;
        Pelagos__SeriesFormat format;
    } all[] = {
        { "json", "application/json", PELAGOS__SERIES_FORMAT__LISTS },
        { "csv", "text/csv", PELAGOS__SERIES_FORMAT__CSV },
        { "netcdf", "netcdf", PELAGOS__SERIES_FORMAT__NETCDF },
    };
    *out = PELAGOS__SERIES_FORMAT__LISTS;
    const char *first = NULL;
    for (size_t i = 0; i < G_N_ELEMENTS(all); i++) {
        if (word && g_ascii_strcasecmp(word, all[i].word) == 0) {
            *out = all[i].format;
            return true;
        }
        const char *at = accept ? strstr(accept, all[i].type) : NULL;
        if (!word && at && (!first || at < first)) {
            first = at; /* the one that is named first */
            *out = all[i].format;
        }
    }
    return word == NULL;
}
