/* The axes of a series, and the question of each cell. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "bounds.h"
#include "json.h"
#include "message.h"
#include "net/command.h"
#include "net/series_parts.h"
#include "path.h"
#include "scalar.h"

/* Numbers of a question that no axis can be of: they say which numbers the
 * answer has, not what they are. */
static const char *const shapes[] = {
    "wavelengthLast", "wavelengthStep", "frequencies", "directions",
    "lowest",         "highest",        "frame",
};

static enum pel_err refuse(struct pel_fault *fault, enum pel_err err,
                           const char *name, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static enum pel_err refuse(struct pel_fault *fault, enum pel_err err,
                           const char *name, const char *format, ...)
{
    char text[240];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    pel_fault_set(fault, err, "sweep: %s", text);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "sweep");
        snprintf(fault->value, sizeof fault->value, "%s", name);
    }
    return err;
}

/* The question itself: of optics the one inside. NULL: nothing is asked. */
static ProtobufCMessage *question_of(const Pelagos__SeriesQuery *query)
{
    switch (query->question_case) {
    case PELAGOS__SERIES_QUERY__QUESTION_OPTICS:
        return query->optics && query->optics->brdf ? &query->optics->brdf->base
                                                    : NULL;
    case PELAGOS__SERIES_QUERY__QUESTION_SPECTRUM:
        return &query->spectrum->base;
    case PELAGOS__SERIES_QUERY__QUESTION_SURFACE:
        return &query->surface->base;
    default:
        return NULL;
    }
}

static bool is_number(const ProtobufCFieldDescriptor *field)
{
    return field->label != PROTOBUF_C_LABEL_REPEATED &&
           (field->type == PROTOBUF_C_TYPE_DOUBLE ||
            field->type == PROTOBUF_C_TYPE_FLOAT ||
            field->type == PROTOBUF_C_TYPE_UINT32 ||
            field->type == PROTOBUF_C_TYPE_INT32);
}

static bool is_shape(const char *name)
{
    for (size_t i = 0; i < G_N_ELEMENTS(shapes); i++) {
        if (strcmp(shapes[i], name) == 0) {
            return true;
        }
    }
    return false;
}

/* A number of `message` by its name. */
static bool find_in(const ProtobufCMessageDescriptor *message, const char *name,
                    struct pel_series_axis *axis)
{
    const ProtobufCFieldDescriptor *field =
        pel_field_by_name(message, name, strlen(name));
    if (!field || !is_number(field)) {
        return false;
    }
    const char *own = pel_field_info(message, field)->name;
    if (is_shape(own)) {
        return false;
    }
    axis->field = field;
    axis->message = message;
    snprintf(axis->name, sizeof axis->name, "%s", own);
    return true;
}

static bool find_path(const char *path, struct pel_series_axis *axis)
{
    struct pel_path_info info;
    if (strlen(path) >= sizeof axis->path ||
        pel_path_find(path, &info, NULL) != PEL_OK || !is_number(info.field)) {
        return false;
    }
    axis->field = info.field;
    axis->message = info.message;
    snprintf(axis->path, sizeof axis->path, "%s", path);
    snprintf(axis->name, sizeof axis->name, "%s", info.info->name);
    return true;
}

/* `windSpeed` for `sea.windSpeed`. */
static bool find_short(const char *name, struct pel_series_axis *axis)
{
    static const char *const sections[] = { "sea", "sky", "water" };
    char path[96];
    for (size_t i = 0; i < G_N_ELEMENTS(sections); i++) {
        if (snprintf(path, sizeof path, "%s.%s", sections[i], name) <
                (int)sizeof path &&
            find_path(path, axis)) {
            return true;
        }
    }
    return false;
}

/* Names of the numbers that the question has, for people. */
static void list_names(const ProtobufCMessage *question, char out[160])
{
    out[0] = '\0';
    for (unsigned i = 0; i < question->descriptor->n_fields; i++) {
        const ProtobufCFieldDescriptor *f = &question->descriptor->fields[i];
        const char *name = pel_field_info(question->descriptor, f)->name;
        if (is_number(f) && !is_shape(name)) {
            size_t at = strlen(out);
            snprintf(out + at, 160 - at, "%s%s", at ? ", " : "", name);
        }
    }
}

static enum pel_err find(const Pelagos__SeriesQuery *query, const char *name,
                         struct pel_series_axis *axis, struct pel_fault *fault)
{
    const ProtobufCMessage *question = question_of(query);
    bool optics =
        query->question_case == PELAGOS__SERIES_QUERY__QUESTION_OPTICS;
    bool of_water = optics && query->optics->question_case ==
                                  PELAGOS__OPTICS_QUERY__QUESTION_WATER;
    bool found = false;
    if (strchr(name, '.')) {
        found = find_path(name, axis);
    } else if (find_in(question->descriptor, name, axis)) {
        found = true;
    } else if (optics && !of_water &&
               find_in(query->optics->base.descriptor, name, axis)) {
        found = axis->of_optics = true;
    } else {
        found = find_short(name, axis);
    }
    if (found && of_water && axis->path[0] &&
        strncmp(axis->path, "water.", 6) != 0) {
        return refuse(fault, PEL_ERR_INVALID, name,
                      "the light of water does not depend on %.60s, only on "
                      "water.* and on its own numbers: its Sun is where "
                      "sunZenith puts it",
                      axis->path);
    }
    if (!found) {
        char names[160];
        list_names(question, names);
        return refuse(fault, PEL_ERR_NOT_FOUND, name,
                      "`%.40s` is no number of the question%s%s, nor one of "
                      "the state (sea.windSpeed)",
                      name, *names ? ": " : "", names);
    }
    return PEL_OK;
}

/* As it would be typed: no 0.30000000000000004. */
static double tidy(double v)
{
    char text[32];
    g_ascii_formatd(text, sizeof text, "%.12g", v);
    return g_ascii_strtod(text, NULL);
}

static enum pel_err fill(const Pelagos__Sweep *sweep,
                         struct pel_series_axis *axis, struct pel_fault *fault)
{
    if (sweep->n_values > 0) {
        axis->count = sweep->n_values;
        axis->values =
            g_memdup2(sweep->values, sweep->n_values * sizeof *axis->values);
        return PEL_OK;
    }
    if (!sweep->has_first || !sweep->has_last) {
        return refuse(fault, PEL_ERR_INVALID, axis->name,
                      "%s needs first and last, or values", axis->name);
    }
    double span = sweep->last - sweep->first;
    double step = sweep->has_step ? sweep->step : span < 0 ? -1 : 1;
    if (!isfinite(span) || !isfinite(step) || step == 0 || span / step < 0) {
        return refuse(fault, PEL_ERR_INVALID, axis->name,
                      "no steps of %g lead %s from %g to %g", step, axis->name,
                      sweep->first, sweep->last);
    }
    double count = floor(span / step + 1e-9) + 1;
    if (count > PEL_BOUND_SERIES_QUESTIONS) {
        return refuse(fault, PEL_ERR_OUT_OF_RANGE, axis->name,
                      "%s has %.0f values, and a series has at most %d "
                      "questions: take longer steps",
                      axis->name, count, PEL_BOUND_SERIES_QUESTIONS);
    }
    axis->count = (size_t)count;
    axis->values = g_new(double, axis->count);
    for (size_t i = 0; i < axis->count; i++) {
        axis->values[i] = tidy(sweep->first + step * (double)i);
    }
    return PEL_OK;
}

static enum pel_err in_range(const struct pel_series_axis *axis,
                             struct pel_fault *fault)
{
    const char *name = pel_field_info(axis->message, axis->field)->name;
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < axis->count && !err; i++) {
        char text[32];
        double unused;
        pel_json_number(isfinite(axis->values[i]) ? axis->values[i] : 0, text);
        err =
            !isfinite(axis->values[i])
                ? refuse(fault, PEL_ERR_INVALID, axis->name, "%s is not finite",
                         axis->name)
                : pel_command_number(axis->message, name, text, &unused, fault);
    }
    return err;
}

static enum pel_err take_axis(struct pel_series_plan *plan, size_t index,
                              struct pel_fault *fault)
{
    const Pelagos__Sweep *sweep = plan->query->sweep[index];
    struct pel_series_axis *axis = &plan->axes[index];
    const char *over = sweep->over ? sweep->over : "";
    plan->axis_count++;
    enum pel_err err = find(plan->query, over, axis, fault);
    for (size_t i = 0; i < index && !err; i++) {
        if (strcmp(plan->axes[i].name, axis->name) == 0) {
            err = refuse(fault, PEL_ERR_INVALID, over, "two axes are named %s",
                         axis->name);
        }
    }
    if (!err) {
        err = fill(sweep, axis, fault);
    }
    if (!err) {
        err = in_range(axis, fault);
    }
    if (!err && axis->count > PEL_BOUND_SERIES_QUESTIONS / plan->cells) {
        return refuse(fault, PEL_ERR_OUT_OF_RANGE, over,
                      "the axes have more than %d combinations: take fewer "
                      "values or longer steps",
                      PEL_BOUND_SERIES_QUESTIONS);
    }
    plan->cells *= axis->count;
    return err;
}

/* The numbers that no axis is of. */
static enum pel_err check_rest(const struct pel_series_plan *plan,
                               struct pel_fault *fault)
{
    const Pelagos__SeriesQuery *query = plan->query;
    const Pelagos__OpticsQuery *optics =
        query->question_case == PELAGOS__SERIES_QUERY__QUESTION_OPTICS
            ? query->optics
            : NULL;
    bool of_water = optics && optics->question_case ==
                                  PELAGOS__OPTICS_QUERY__QUESTION_WATER;
    for (unsigned i = 0; i < plan->axis_count && of_water; i++) {
        if (strcmp(plan->axes[i].name, "wavelength") == 0 &&
            optics->water->has_wavelength_last) {
            return refuse(fault, PEL_ERR_INVALID, "wavelength",
                          "either the axis wavelength or wavelengthLast");
        }
    }
    if (query->question_case == PELAGOS__SERIES_QUERY__QUESTION_SURFACE &&
        query->surface->n_points == 0) {
        return pel_fault_value(fault, PEL_ERR_INVALID, "points", "",
                               "a surface needs at least one point");
    }
    if (query->question_case == PELAGOS__SERIES_QUERY__QUESTION_SPECTRUM) {
        Pelagos__SpectrumQuery own = *query->spectrum;
        own.patch = NULL; /* as any patch, with each question */
        if (own.format != PELAGOS__SPECTRUM_FORM__NUMBERS) {
            return pel_fault_value(fault, PEL_ERR_INVALID, "spectrum.format",
                                   "", "a series has its own format");
        }
        return pel_command_check(&own.base, fault);
    }
    return pel_command_check(question_of(query), fault);
}

void pel_series_plan_at(struct pel_series_plan *plan, double time_s)
{
    Pelagos__SeriesQuery *query = plan->query;
    if (query->question_case == PELAGOS__SERIES_QUERY__QUESTION_OPTICS &&
        !query->optics->has_time &&
        query->optics->question_case != PELAGOS__OPTICS_QUERY__QUESTION_WATER) {
        query->optics->has_time = true;
        query->optics->time = time_s;
    }
    if (query->question_case == PELAGOS__SERIES_QUERY__QUESTION_SURFACE &&
        !query->surface->has_time && !query->surface->has_frame) {
        query->surface->has_time = true;
        query->surface->time = time_s;
    }
}

enum pel_err pel_series_plan_make(const Pelagos__SeriesQuery *query,
                                  struct pel_series_plan *out,
                                  struct pel_fault *fault)
{
    *out = (struct pel_series_plan){ .cells = 1 };
    out->query = (Pelagos__SeriesQuery *)pel_message_copy(&query->base);
    if (!question_of(out->query)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "the series asks for nothing: give optics, "
                             "spectrum or surface, with its question");
    }
    size_t count = out->query->n_sweep;
    if (count > PEL_SERIES_AXES) {
        return refuse(fault, PEL_ERR_INVALID, "",
                      "a series has at most %d axes, not %zu", PEL_SERIES_AXES,
                      count);
    }
    enum pel_err err = PEL_OK;
    for (size_t i = 0; i < count && !err; i++) {
        err = take_axis(out, i, fault);
    }
    return err ? err : check_rest(out, fault);
}

void pel_series_plan_finish(struct pel_series_plan *plan)
{
    for (unsigned i = 0; i < plan->axis_count; i++) {
        g_free(plan->axes[i].values);
    }
    if (plan->query) {
        pelagos__series_query__free_unpacked(plan->query, NULL);
    }
    *plan = (struct pel_series_plan){ 0 };
}

double pel_series_at(const struct pel_series_plan *plan, unsigned axis,
                     size_t cell)
{
    for (unsigned i = plan->axis_count - 1; i > axis; i--) {
        cell /= plan->axes[i].count;
    }
    return plan->axes[axis].values[cell % plan->axes[axis].count];
}

size_t pel_series_cell(const struct pel_series_plan *plan, size_t n)
{
    size_t cell = 0;
    for (int pass = 0; pass < 2; pass++) { /* the fastest come first */
        for (unsigned i = plan->axis_count; i-- > 0;) {
            const struct pel_series_axis *axis = &plan->axes[i];
            size_t stride = 1;
            for (unsigned k = i + 1; k < plan->axis_count; k++) {
                stride *= plan->axes[k].count;
            }
            if ((axis->path[0] != '\0') == (pass == 1)) {
                cell += n % axis->count * stride;
                n /= axis->count;
            }
        }
    }
    return cell;
}

static Pelagos__Patch **patch_of(ProtobufCMessage *asked)
{
    if (asked->descriptor == &pelagos__optics_query__descriptor) {
        return &((Pelagos__OpticsQuery *)asked)->patch;
    }
    return asked->descriptor == &pelagos__spectrum_query__descriptor
               ? &((Pelagos__SpectrumQuery *)asked)->patch
               : NULL;
}

static enum pel_err set_axis(const struct pel_series_axis *axis, double value,
                             ProtobufCMessage *asked, struct pel_fault *fault)
{
    ProtobufCMessage *to = asked;
    if (axis->path[0]) {
        Pelagos__Patch **patch = patch_of(asked);
        if (!patch) {
            return refuse(fault, PEL_ERR_INVALID, axis->name,
                          "the surface is that of the state in force: %s "
                          "cannot be swept",
                          axis->path);
        }
        *patch = *patch ? *patch : pel_patch_new();
        return pel_path_set_number(*patch, NULL, axis->path, value, fault);
    }
    if (asked->descriptor == &pelagos__optics_query__descriptor &&
        !axis->of_optics) {
        to = &((Pelagos__OpticsQuery *)asked)->brdf->base; /* or its like */
    }
    char text[32];
    pel_json_number(value, text);
    if (scalar_parse_number(axis->field, text,
                            pel_message_member(to, axis->field)) != SCALAR_OK) {
        return refuse(fault, PEL_ERR_INVALID, axis->name, "%s cannot be %s",
                      axis->name, text);
    }
    pel_message_mark(to, axis->field);
    return PEL_OK;
}

enum pel_err pel_series_question(const struct pel_series_plan *plan,
                                 size_t cell, ProtobufCMessage **out,
                                 struct pel_fault *fault)
{
    const Pelagos__SeriesQuery *query = plan->query;
    const ProtobufCMessage *pattern = &query->surface->base; /* or its like */
    ProtobufCMessage *asked = pel_message_copy(pattern);
    enum pel_err err = PEL_OK;
    for (unsigned i = 0; i < plan->axis_count && !err; i++) {
        err = set_axis(&plan->axes[i], pel_series_at(plan, i, cell), asked,
                       fault);
    }
    if (err) {
        protobuf_c_message_free_unpacked(asked, NULL);
        return err;
    }
    *out = asked;
    return PEL_OK;
}
