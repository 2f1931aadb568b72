/* The numbers of a series' answers, by the schema: each number of an answer is
 * a column, a list adds a dimension. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bounds.h"
#include "message.h"
#include "net/series_parts.h"

void pel_series_table_init(const struct pel_series_plan *plan,
                           struct pel_series_table *out)
{
    *out = (struct pel_series_table){ .plan = plan };
    out->columns = g_array_new(FALSE, TRUE, sizeof(struct pel_series_column));
}

void pel_series_table_finish(struct pel_series_table *table)
{
    for (guint i = 0; table->columns && i < table->columns->len; i++) {
        struct pel_series_column *c =
            &g_array_index(table->columns, struct pel_series_column, i);
        g_free(c->text);
        free(c->values);
        g_free(c->given);
    }
    for (int i = 0; i < PEL_INNER_COUNT; i++) {
        g_free(table->inner_values[i]);
    }
    if (table->columns) {
        g_array_free(table->columns, TRUE);
    }
    *table = (struct pel_series_table){ 0 };
}

const char *pel_series_inner_name(enum pel_series_inner inner)
{
    static const char *const names[] = { "wavelength", "omega", "theta",
                                         "point" };
    return names[inner];
}

const ProtobufCFieldDescriptor *
pel_series_inner_field(enum pel_series_inner inner,
                       const ProtobufCMessageDescriptor **message)
{
    static const char *const fields[] = { "wavelength", "omega", "direction" };
    *message = inner == PEL_INNER_WAVELENGTH
                   ? &pelagos__water_light__descriptor
                   : &pelagos__spectrum_row__descriptor;
    return inner == PEL_INNER_POINT
               ? NULL
               : protobuf_c_message_descriptor_get_field_by_name(*message,
                                                                 fields[inner]);
}

/* Where in the answer the walk is. */
struct place {
    size_t cell;
    const char *prefix; /* of names */
    const char *about;  /* of texts */
    const char *unit;   /* of numbers that have none of their own, or NULL */
    unsigned inner;
    size_t index; /* in the inner dimensions */
};

static bool is_axis(const struct pel_series_table *table, const char *name)
{
    for (unsigned i = 0; i < table->plan->axis_count; i++) {
        if (strcmp(table->plan->axes[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

static size_t block_of(const struct pel_series_table *table, unsigned inner)
{
    size_t block = 1;
    for (int i = 0; i < PEL_INNER_COUNT; i++) {
        block *= inner >> i & 1 ? table->inner_size[i] : 1;
    }
    return block;
}

static struct pel_series_column *find(struct pel_series_table *table,
                                      const char *name)
{
    for (guint i = 0; i < table->columns->len; i++) {
        struct pel_series_column *c =
            &g_array_index(table->columns, struct pel_series_column, i);
        if (strcmp(c->name, name) == 0) {
            return c;
        }
    }
    return NULL;
}

/* The column of a field, made where it is new; NULL: there are too many
 * numbers. */
static struct pel_series_column *
column(struct pel_series_table *table, const struct place *at,
       const ProtobufCMessageDescriptor *message,
       const ProtobufCFieldDescriptor *field, unsigned inner)
{
    const struct pel_field *info = pel_field_info(message, field);
    bool plain = !info->unit || strcmp(info->unit, "1") == 0;
    struct pel_series_column new = { .unit = plain && at->unit ? at->unit
                                                               : info->unit,
                                     .message = message,
                                     .field = field,
                                     .inner = inner,
                                     .block = block_of(table, inner) };
    g_snprintf(new.name, sizeof new.name, "%s%s", at->prefix, info->name);
    struct pel_series_column *known = find(table, new.name);
    size_t size = new.block * table->plan->cells;
    if (known) {
        return known;
    }
    if (size > PEL_BOUND_SERIES_VALUES - table->values) {
        return NULL;
    }
    table->values += size;
    /* Untouched: filling it at once would take the control thread long. */
    new.values = calloc(size + 1, sizeof *new.values);
    new.given = g_new0(bool, table->plan->cells);
    if (!new.values) {
        g_free(new.given);
        return NULL;
    }
    const char *doc = pel_cf_text(message, field);
    new.text =
        *at->about ? g_strdup_printf("%s %s", at->about, doc) : g_strdup(doc);
    g_array_append_val(table->columns, new);
    return find(table, new.name);
}

/* The values of a column in a cell. */
static double *block(struct pel_series_column *column, size_t cell)
{
    double *values = column->values + cell * column->block;
    for (size_t i = 0; !column->given[cell] && i < column->block; i++) {
        values[i] = NAN;
    }
    column->given[cell] = true;
    return values;
}

void pel_series_table_end(struct pel_series_table *table)
{
    for (guint i = 0; i < table->columns->len; i++) {
        struct pel_series_column *c =
            &g_array_index(table->columns, struct pel_series_column, i);
        for (size_t cell = 0; cell < table->plan->cells; cell++) {
            block(c, cell);
        }
    }
}

static enum pel_err too_many(struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                         "the series has more than %d numbers: take fewer "
                         "values, frequencies, directions or points",
                         PEL_BOUND_SERIES_VALUES);
}

static enum pel_err walk(struct pel_series_table *table, const struct place *at,
                         const ProtobufCMessage *message,
                         struct pel_fault *fault);

static enum pel_err take_number(struct pel_series_table *table,
                                const struct place *at,
                                const ProtobufCMessage *message,
                                const ProtobufCFieldDescriptor *field,
                                double value, struct pel_fault *fault)
{
    const char *name = pel_field_info(message->descriptor, field)->name;
    if (!*at->prefix && is_axis(table, name)) {
        return PEL_OK; /* it says what was asked */
    }
    if (at->inner & 1u << PEL_INNER_OMEGA && strcmp(name, "omega") == 0) {
        table->inner_values[PEL_INNER_OMEGA][at->index] = value;
        return PEL_OK;
    }
    struct pel_series_column *c =
        column(table, at, message->descriptor, field, at->inner);
    if (!c) {
        return too_many(fault);
    }
    if (at->index < c->block) {
        block(c, at->cell)[at->index] = value;
    }
    return PEL_OK;
}

/* The size of an inner dimension, which the first answer decides. */
static size_t settle(struct pel_series_table *table,
                     enum pel_series_inner inner, size_t count)
{
    if (table->inner_size[inner] == 0 && count > 0) {
        table->inner_size[inner] = count;
        table->inner_values[inner] = g_new0(double, count);
        for (size_t i = 0; i < count; i++) {
            table->inner_values[inner][i] =
                inner == PEL_INNER_DIRECTION ? 360.0 * (double)i / (double)count
                                             : (double)i;
        }
    }
    return MIN(count, table->inner_size[inner]);
}

static enum pel_err take_list(struct pel_series_table *table,
                              const struct place *at,
                              const ProtobufCMessage *message,
                              const ProtobufCFieldDescriptor *field,
                              struct pel_fault *fault)
{
    size_t count =
        *(const size_t *)((const char *)message + field->quantifier_offset);
    const double *v = *(double *const *)pel_message_member(message, field);
    bool rows = message->descriptor == &pelagos__spectrum_row__descriptor;
    enum pel_series_inner inner =
        rows ? PEL_INNER_DIRECTION : PEL_INNER_WAVELENGTH;
    if (!rows && is_axis(table, "wavelength")) {
        return count == 1 ? take_number(table, at, message, field, v[0], fault)
                          : PEL_OK;
    }
    count = settle(table, inner, count);
    if (!rows && strcmp(field->name, "wavelength") == 0) {
        memcpy(table->inner_values[inner], v, count * sizeof *v);
        return PEL_OK;
    }
    struct pel_series_column *c =
        column(table, at, message->descriptor, field, at->inner | 1u << inner);
    if (!c) {
        return too_many(fault);
    }
    size_t first = at->index * table->inner_size[inner];
    if (first + count <= c->block) {
        memcpy(block(c, at->cell) + first, v, count * sizeof *v);
    }
    return PEL_OK;
}

static enum pel_err take_messages(struct pel_series_table *table,
                                  const struct place *at,
                                  const ProtobufCMessage *message,
                                  const ProtobufCFieldDescriptor *field,
                                  struct pel_fault *fault)
{
    size_t count = 0;
    ProtobufCMessage **list = pel_message_list(message, field, &count);
    enum pel_series_inner inner =
        field->descriptor == &pelagos__spectrum_row__descriptor
            ? PEL_INNER_OMEGA
            : PEL_INNER_POINT;
    enum pel_err err = PEL_OK;
    count = settle(table, inner, count);
    for (size_t i = 0; i < count && !err; i++) {
        struct place below = *at;
        below.inner |= 1u << inner;
        below.index = i;
        err = walk(table, &below, list[i], fault);
    }
    return err;
}

/* What is one of several (Optics.brdf) adds nothing to the names. */
static enum pel_err take_message(struct pel_series_table *table,
                                 const struct place *at,
                                 const ProtobufCMessage *message,
                                 const ProtobufCFieldDescriptor *field,
                                 struct pel_fault *fault)
{
    const ProtobufCMessage *child =
        *(ProtobufCMessage *const *)pel_message_member(message, field);
    const struct pel_field *info = pel_field_info(message->descriptor, field);
    struct place below = *at;
    below.unit = info->unit; /* a vector's numbers have that of the vector */
    g_autofree char *prefix = g_strdup_printf("%s%s_", at->prefix, info->name);
    bool one_of = field->flags & PROTOBUF_C_FIELD_FLAG_ONEOF;
    if (!one_of) {
        below.prefix = prefix;
        below.about = info->doc ? info->doc : "";
    }
    return walk(table, &below, child, fault);
}

static enum pel_err walk(struct pel_series_table *table, const struct place *at,
                         const ProtobufCMessage *message,
                         struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    for (unsigned i = 0; i < message->descriptor->n_fields && !err; i++) {
        const ProtobufCFieldDescriptor *field = &message->descriptor->fields[i];
        bool list = field->label == PROTOBUF_C_LABEL_REPEATED;
        double value;
        if (!pel_message_has(message, field) ||
            field->type == PROTOBUF_C_TYPE_ENUM ||
            field->type == PROTOBUF_C_TYPE_BOOL) {
            continue;
        }
        if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
            err = (list ? take_messages : take_message)(table, at, message,
                                                        field, fault);
        } else if (list && field->type == PROTOBUF_C_TYPE_DOUBLE) {
            err = take_list(table, at, message, field, fault);
        } else if (!list && pel_message_number(message, field, &value)) {
            err = take_number(table, at, message, field, value, fault);
        }
    }
    return err;
}

enum pel_err pel_series_table_take(struct pel_series_table *table, size_t cell,
                                   const ProtobufCMessage *answer,
                                   struct pel_fault *fault)
{
    const struct place at = { .cell = cell, .prefix = "", .about = "" };
    return walk(table, &at, answer, fault);
}
