#include "scene/check.h"

#include <glib.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "fault.h"
#include "fields.h"
#include "json.h"
#include "message.h"
#include "scene/snapshot.h"
#include "scene/sun.h"

#define PATH_SIZE 192
#define MAX_TEXT 64
#define MIN_ANGLE_DEG 0.01 /* so that its width is far above rounding */
#define MAX_PIXELS (4096.0 * 4096.0)

static enum pel_err refuse(enum pel_err code, const char *path,
                           const char *value, const char *what,
                           struct pel_fault *fault)
{
    pel_fault_set(fault, code, "%.90s %s", path, what);
    pel_fault_at(fault, path, value);
    return code;
}

static enum pel_err check_number(const struct pel_field *info, const char *path,
                                 double value, struct pel_fault *fault)
{
    bool finite = isfinite(value);
    if (finite &&
        (!info->ranged || (value >= info->minimum && value <= info->maximum))) {
        return PEL_OK;
    }
    char text[32] = "not a finite number", what[160], low[32], high[32];
    const char *unit =
        info->unit && strcmp(info->unit, "1") != 0 ? info->unit : "";
    if (finite) {
        pel_json_number(value, text);
    }
    if (info->ranged) {
        pel_json_number(info->minimum, low);
        pel_json_number(info->maximum, high);
        g_snprintf(what, sizeof what, "is %s%s%s; it must be %s to %s%s%s",
                   text, finite && *unit ? " " : "", finite ? unit : "", low,
                   high, *unit ? " " : "", unit);
    } else {
        g_snprintf(what, sizeof what, "is %s", text);
    }
    return refuse(PEL_ERR_OUT_OF_RANGE, path, text, what, fault);
}

static enum pel_err check_text(const char *path, const char *text,
                               struct pel_fault *fault)
{
    size_t length = strlen(text);
    const char *what = NULL;
    if (length > MAX_TEXT) {
        what = "is longer than 64 bytes";
    } else if (!g_utf8_validate(text, (gssize)length, NULL)) {
        what = "is not UTF-8";
    }
    for (const char *p = text; !what && *p; p++) {
        if ((unsigned char)*p < 0x20 || *p == 0x7f) {
            what = "holds a control character";
        }
    }
    return what ? refuse(PEL_ERR_INVALID, path,
                         g_utf8_validate(text, (gssize)length, NULL) ? text
                                                                     : NULL,
                         what, fault)
                : PEL_OK;
}

static enum pel_err check_message(const ProtobufCMessage *message,
                                  const char *path, struct pel_fault *fault);

static void element_path(const ProtobufCMessage *element, const char *list,
                         size_t index, char out[PATH_SIZE])
{
    const ProtobufCFieldDescriptor *key = pel_field_key(element->descriptor);
    double number;
    if (!key || !pel_message_has(element, key)) {
        g_snprintf(out, PATH_SIZE, "%s.%zu", list, index);
    } else if (pel_message_number(element, key, &number)) {
        g_snprintf(out, PATH_SIZE, "%s.%.0f", list, number);
    } else {
        g_snprintf(out, PATH_SIZE, "%s.%.64s", list,
                   *(char *const *)pel_message_member(element, key));
    }
}

static enum pel_err check_field(const ProtobufCMessage *message,
                                const ProtobufCFieldDescriptor *field,
                                const char *path, struct pel_fault *fault)
{
    const struct pel_field *info = pel_field_info(message->descriptor, field);
    const void *member = pel_message_member(message, field);
    double number;
    if (field->label == PROTOBUF_C_LABEL_REPEATED) {
        size_t count;
        ProtobufCMessage **list = pel_message_list(message, field, &count);
        for (size_t i = 0; i < count; i++) {
            char below[PATH_SIZE];
            element_path(list[i], path, i, below);
            enum pel_err err = check_message(list[i], below, fault);
            if (err) {
                return err;
            }
        }
        return PEL_OK;
    }
    if (field->type == PROTOBUF_C_TYPE_MESSAGE) {
        return check_message(*(ProtobufCMessage *const *)member, path, fault);
    }
    if (field->type == PROTOBUF_C_TYPE_STRING) {
        return check_text(path, *(char *const *)member, fault);
    }
    if (!pel_message_number(message, field, &number)) {
        return PEL_OK;
    }
    if (field->type == PROTOBUF_C_TYPE_ENUM &&
        !protobuf_c_enum_descriptor_get_value(field->descriptor, (int)number)) {
        char text[32];
        pel_json_number(number, text);
        return refuse(PEL_ERR_INVALID, path, text, "is not a value of its enum",
                      fault);
    }
    return check_number(info, path, number, fault);
}

static enum pel_err check_message(const ProtobufCMessage *message,
                                  const char *path, struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type = message->descriptor;
    for (unsigned i = 0; i < type->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &type->fields[i];
        if (!pel_message_has(message, field)) {
            continue;
        }
        char below[PATH_SIZE];
        g_snprintf(below, sizeof below, "%s%s%s", path, path[0] ? "." : "",
                   pel_field_info(type, field)->name);
        enum pel_err err = check_field(message, field, below, fault);
        if (err) {
            return err;
        }
    }
    return PEL_OK;
}

static enum pel_err check_count(size_t count, size_t limit, const char *path,
                                struct pel_fault *fault)
{
    if (count <= limit) {
        return PEL_OK;
    }
    char value[24], what[64];
    g_snprintf(value, sizeof value, "%zu", count);
    g_snprintf(what, sizeof what, "would have %zu elements; at most %zu", count,
               limit);
    refuse(PEL_ERR_OUT_OF_RANGE, path, value, what, fault);
    if (fault) {
        fault->minimum = 0;
        fault->maximum = (double)limit;
    }
    return PEL_ERR_OUT_OF_RANGE;
}

static bool good_view_name(const char *name)
{
    size_t length = strlen(name);
    return length > 0 && length < PEL_NAME_SIZE &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                        "abcdefghijklmnopqrstuvwxyz0123456789_-") == length;
}

static enum pel_err check_frustum(const Pelagos__View *view,
                                  struct pel_fault *fault)
{
    const Pelagos__Frustum *f = view->frustum;
    char path[PATH_SIZE];
    g_snprintf(path, sizeof path, "views.%s.frustum", view->name);
    if (!f->has_left || !f->has_right || !f->has_top || !f->has_bottom) {
        return refuse(PEL_ERR_INVALID, path, NULL,
                      "needs all of left, right, top and bottom", fault);
    }
    if (!(f->left + MIN_ANGLE_DEG <= f->right) ||
        !(f->bottom + MIN_ANGLE_DEG <= f->top)) {
        return refuse(PEL_ERR_INVALID, path, NULL,
                      "needs left < right and bottom < top, 0.01 deg apart",
                      fault);
    }
    return PEL_OK;
}

static enum pel_err check_meter(const Pelagos__State *state,
                                const Pelagos__View *view,
                                struct pel_fault *fault)
{
    char path[PATH_SIZE];
    g_snprintf(path, sizeof path, "views.%s.meter", view->name);
    if (!good_view_name(view->meter)) {
        return refuse(PEL_ERR_INVALID, path, view->meter,
                      "needs a name of 1 to 64 of A-Z a-z 0-9 _ -", fault);
    }
    int alike = 0;
    for (size_t i = 0; i < state->n_views; i++) {
        alike += state->views[i]->meter &&
                 strcmp(state->views[i]->meter, view->meter) == 0;
    }
    return alike <= PEL_METER_SIGHTS
               ? PEL_OK
               : refuse(PEL_ERR_CONFLICT, path, view->meter,
                        "is the meter of more than 12 views", fault);
}

static enum pel_err check_view(const Pelagos__State *state, size_t index,
                               struct pel_fault *fault)
{
    const Pelagos__View *view = state->views[index];
    char path[PATH_SIZE], value[24], what[96];
    if (!view->name || !good_view_name(view->name)) {
        return refuse(PEL_ERR_INVALID, "views", view->name,
                      "needs names of 1 to 64 of A-Z a-z 0-9 _ -", fault);
    }
    for (size_t i = 0; i < index; i++) {
        if (strcmp(state->views[i]->name, view->name) == 0) {
            return refuse(PEL_ERR_CONFLICT, "views", view->name,
                          "has a name twice", fault);
        }
    }
    if (view->has_entity) {
        bool found = false;
        for (size_t i = 0; i < state->n_entities; i++) {
            found = found || state->entities[i]->id == view->entity;
        }
        if (!found) {
            g_snprintf(path, sizeof path, "views.%s.entity", view->name);
            g_snprintf(value, sizeof value, "%u", view->entity);
            g_snprintf(what, sizeof what,
                       "names entity %u, which is not there: add it, or give "
                       "the view another",
                       view->entity);
            return refuse(PEL_ERR_CONFLICT, path, value, what, fault);
        }
    }
    if (view->meter) {
        enum pel_err err = check_meter(state, view, fault);
        if (err) {
            return err;
        }
    }
    if ((double)view->width * view->height > MAX_PIXELS) {
        g_snprintf(path, sizeof path, "views.%s.width", view->name);
        return refuse(PEL_ERR_OUT_OF_RANGE, path, NULL,
                      "times height is more than 16777216 pixels", fault);
    }
    return view->frustum ? check_frustum(view, fault) : PEL_OK;
}

static enum pel_err check_entity(const Pelagos__State *state, size_t index,
                                 struct pel_fault *fault)
{
    const Pelagos__Entity *entity = state->entities[index];
    if (!entity->has_id) {
        return refuse(PEL_ERR_INVALID, "entities", entity->name,
                      "needs an id for each element", fault);
    }
    for (size_t i = 0; i < index; i++) {
        if (state->entities[i]->id == entity->id) {
            char value[24];
            g_snprintf(value, sizeof value, "%u", entity->id);
            return refuse(PEL_ERR_CONFLICT, "entities", value,
                          "has an id twice", fault);
        }
    }
    return PEL_OK;
}

static enum pel_err check_utc(const Pelagos__Clock *clock,
                              struct pel_fault *fault)
{
    double unix_s;
    enum pel_err err = pel_utc_parse(clock->utc, &unix_s);
    if (err == PEL_ERR_OUT_OF_RANGE) {
        return refuse(err, "clock.utc", clock->utc,
                      "must be in the years 1900 to 2100", fault);
    }
    return err ? refuse(err, "clock.utc", clock->utc,
                        "must be ISO 8601 with its zone, like "
                        "2026-06-21T12:00:00Z",
                        fault)
               : PEL_OK;
}

/* All of `count` values, or none: *present says which. */
static bool whole(const protobuf_c_boolean *const has[], int count,
                  bool *present)
{
    int found = 0;
    for (int i = 0; i < count; i++) {
        found += *has[i] ? 1 : 0;
    }
    *present = found > 0;
    return found == 0 || found == count;
}

static enum pel_err check_water(const Pelagos__Water *w,
                                struct pel_fault *fault)
{
    const protobuf_c_boolean *const coefficients[] = {
        &w->has_absorption_680, &w->has_absorption_550, &w->has_absorption_440,
        &w->has_scattering_680, &w->has_scattering_550, &w->has_scattering_440,
    };
    const protobuf_c_boolean *const albedos[] = {
        &w->has_albedo_680,
        &w->has_albedo_550,
        &w->has_albedo_440,
    };
    bool direct, given;
    if (!whole(coefficients, 6, &direct)) {
        return refuse(PEL_ERR_INVALID, "water", NULL,
                      "needs absorption and scattering at all of 680, 550 and "
                      "440 nm, or none of the six",
                      fault);
    }
    if (!whole(albedos, 3, &given)) {
        return refuse(PEL_ERR_INVALID, "water", NULL,
                      "needs albedo at all of 680, 550 and 440 nm, or none",
                      fault);
    }
    if (direct + (w->has_jerlov != 0) + (w->has_named != 0) > 1) {
        return refuse(PEL_ERR_CONFLICT, "water", NULL,
                      "is described twice: only one of jerlov, named, and "
                      "absorption with scattering; remove the other",
                      fault);
    }
    return PEL_OK;
}

static enum pel_err check_seabed(const Pelagos__Seabed *s,
                                 struct pel_fault *fault)
{
    const protobuf_c_boolean *const place[] = {
        &s->has_latitude,
        &s->has_longitude,
        &s->has_spacing,
    };
    bool given;
    return whole(place, 3, &given)
               ? PEL_OK
               : refuse(PEL_ERR_INVALID, "seabed", NULL,
                        "needs all of latitude, longitude and spacing, or none",
                        fault);
}

enum pel_err pel_state_check(const Pelagos__State *state,
                             struct pel_fault *fault)
{
    enum pel_err err =
        check_count(state->n_views, PEL_MAX_VIEWS, "views", fault);
    if (!err) {
        err =
            check_count(state->n_entities, PEL_MAX_ENTITIES, "entities", fault);
    }
    if (!err && state->sea) {
        err = check_count(state->sea->n_swell, PEL_SEA_MAX_SWELLS, "sea.swell",
                          fault);
    }
    if (!err && state->sea) {
        err = check_count(state->sea->n_wave, PEL_SEA_MAX_SINGLES, "sea.wave",
                          fault);
    }
    if (!err) {
        err = check_message(&state->base, "", fault);
    }
    if (!err && state->clock) {
        err = check_utc(state->clock, fault);
    }
    if (!err && state->water) {
        err = check_water(state->water, fault);
    }
    if (!err && state->seabed) {
        err = check_seabed(state->seabed, fault);
    }
    for (size_t i = 0; !err && i < state->n_entities; i++) {
        err = check_entity(state, i, fault);
    }
    for (size_t i = 0; !err && i < state->n_views; i++) {
        err = check_view(state, i, fault);
    }
    return err;
}
