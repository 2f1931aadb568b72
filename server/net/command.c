#include "net/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "bounds.h"
#include "fault.h"
#include "fields.h"
#include "json.h"
#include "message.h"
#include "wire.h"

#define MAX_POINTS PEL_BOUND_SURFACE_POINTS

static enum pel_err refuse(struct pel_fault *fault, enum pel_err code,
                           const char *path, const struct pel_field *info,
                           double value, const char *what)
{
    pel_fault_set(fault, code, "%s %s", path, what);
    if (!fault) {
        return code;
    }
    snprintf(fault->path, sizeof fault->path, "%s", path);
    snprintf(fault->value, sizeof fault->value, "%.15g", value);
    if (info) {
        fault->unit = info->unit;
        if (info->ranged) {
            fault->minimum = info->minimum;
            fault->maximum = info->maximum;
        }
    }
    return code;
}

static enum pel_err out_of_range(const char *path, const struct pel_field *info,
                                 double value, struct pel_fault *fault)
{
    bool unit = info->unit && strcmp(info->unit, "1") != 0;
    char what[128];
    snprintf(what, sizeof what, "must be between %.15g and %.15g%s%s",
             info->minimum, info->maximum, unit ? " " : "",
             unit ? info->unit : "");
    return refuse(fault, PEL_ERR_OUT_OF_RANGE, path, info, value, what);
}

static enum pel_err check_number(const ProtobufCMessage *message,
                                 const ProtobufCFieldDescriptor *field,
                                 const char *path, struct pel_fault *fault)
{
    const struct pel_field *info = pel_field_info(message->descriptor, field);
    double value = 0.0;
    if (!pel_message_number(message, field, &value)) {
        return PEL_OK;
    }
    if (!isfinite(value)) {
        return refuse(fault, PEL_ERR_INVALID, path, info, value,
                      "is not a finite number");
    }
    if (field->type == PROTOBUF_C_TYPE_ENUM &&
        !protobuf_c_enum_descriptor_get_value(field->descriptor, (int)value)) {
        return refuse(fault, PEL_ERR_INVALID, path, info, value,
                      "is not a value of its kind");
    }
    if (info && info->ranged &&
        (value < info->minimum || value > info->maximum)) {
        return out_of_range(path, info, value, fault);
    }
    return PEL_OK;
}

enum pel_err pel_fault_value(struct pel_fault *fault, enum pel_err code,
                             const char *path, const char *value,
                             const char *message)
{
    pel_fault_set(fault, code, "%.60s: %s", path, message);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", path);
        snprintf(fault->value, sizeof fault->value, "%s", value ? value : "");
    }
    return code;
}

enum pel_err pel_command_number(const ProtobufCMessageDescriptor *type,
                                const char *name, const char *text, double *out,
                                struct pel_fault *fault)
{
    const ProtobufCFieldDescriptor *field =
        pel_field_by_name(type, name, strlen(name));
    const struct pel_field *info = field ? pel_field_info(type, field) : NULL;
    char *end = NULL;
    double value = g_ascii_strtod(text, &end);
    bool decimal = *text && *end == '\0' && isfinite(value) &&
                   strspn(text, "+-.0123456789eE") == strlen(text);
    bool whole = field && (field->type == PROTOBUF_C_TYPE_UINT32 ||
                           field->type == PROTOBUF_C_TYPE_UINT64);
    if (!info || !decimal || (whole && value != floor(value))) {
        return pel_fault_value(fault, PEL_ERR_INVALID, name, text,
                               whole ? "must be a whole number"
                                     : "must be a number");
    }
    if (info->ranged && (value < info->minimum || value > info->maximum)) {
        return out_of_range(name, info, value, fault);
    }
    *out = value;
    return PEL_OK;
}

/* The schema has no recursive messages, so the depth is bounded. */
static enum pel_err check_below(const ProtobufCMessage *message,
                                const char *prefix, struct pel_fault *fault)
{
    for (unsigned i = 0; i < message->descriptor->n_fields; i++) {
        const ProtobufCFieldDescriptor *field = &message->descriptor->fields[i];
        if (!pel_message_has(message, field)) {
            continue;
        }
        const struct pel_field *info =
            pel_field_info(message->descriptor, field);
        char path[96];
        snprintf(path, sizeof path, "%s%s%s", prefix, *prefix ? "." : "",
                 info ? info->name : field->name);
        enum pel_err err = PEL_OK;
        bool list = field->label == PROTOBUF_C_LABEL_REPEATED;
        if (field->type != PROTOBUF_C_TYPE_MESSAGE) {
            err = list ? PEL_OK : check_number(message, field, path, fault);
        } else if (!list) {
            const ProtobufCMessage *const *child =
                pel_message_member(message, field);
            err = check_below(*child, path, fault);
        } else {
            size_t count = 0;
            ProtobufCMessage **items = pel_message_list(message, field, &count);
            for (size_t k = 0; k < count && err == PEL_OK; k++) {
                char item[128];
                snprintf(item, sizeof item, "%s.%zu", path, k);
                err = check_below(items[k], item, fault);
            }
        }
        if (err != PEL_OK) {
            return err;
        }
    }
    return PEL_OK;
}

enum pel_err pel_command_check(const ProtobufCMessage *command,
                               struct pel_fault *fault)
{
    return check_below(command, "", fault);
}

enum pel_err pel_command_spectrum(struct pel_scene *scene,
                                  const Pelagos__SpectrumQuery *query,
                                  pel_spectrum_done done, void *user,
                                  struct pel_fault *fault)
{
    /* The patch keeps the paths and the words of a patch. */
    Pelagos__SpectrumQuery own = *query;
    own.patch = NULL;
    enum pel_err err = pel_command_check(&own.base, fault);
    return err ? err : pel_scene_ask_spectrum(scene, query, done, user, fault);
}

enum pel_err pel_command_optics(struct pel_frames *frames,
                                const Pelagos__OpticsQuery *query,
                                pel_optics_callback done, void *user,
                                struct pel_fault *fault)
{
    Pelagos__OpticsQuery own = *query;
    own.patch = NULL;
    enum pel_err err = pel_command_check(&own.base, fault);
    return err ? err : pel_frames_optics(frames, query, done, user, fault);
}

static bool in_range(const struct pel_field *info, double value)
{
    return value >= info->minimum && value <= info->maximum;
}

/* Somebody waits for the answer: what is good is seen without its path being
 * written, what is not goes the way of all messages. */
static enum pel_err take_points(const Pelagos__SurfaceQuery *query,
                                struct pel_vec2 *out, struct pel_fault *fault)
{
    const ProtobufCMessageDescriptor *type = &pelagos__point__descriptor;
    const struct pel_field *east =
        pel_field_info(type, pel_field_by_name(type, "east", 4));
    const struct pel_field *north =
        pel_field_info(type, pel_field_by_name(type, "north", 5));
    for (size_t i = 0; i < query->n_points; i++) {
        const Pelagos__Point *point = query->points[i];
        if (!point->has_east || !point->has_north ||
            !in_range(east, point->east) || !in_range(north, point->north)) {
            char path[96];
            snprintf(path, sizeof path, "points.%zu", i);
            enum pel_err err = check_below(&point->base, path, fault);
            return err ? err
                       : refuse(fault, PEL_ERR_INVALID, path, NULL, (double)i,
                                "needs east and north");
        }
        out[i] = (struct pel_vec2){ point->east, point->north };
    }
    return PEL_OK;
}

enum pel_err pel_command_surface(struct pel_frames *frames,
                                 const Pelagos__SurfaceQuery *query,
                                 const void *asker, enum pel_rank rank,
                                 const struct pel_surface_form *form,
                                 pel_surface_callback done, void *user,
                                 struct pel_fault *fault)
{
    if (query->n_points > MAX_POINTS) {
        return refuse(fault, PEL_ERR_OUT_OF_RANGE, "points", NULL,
                      (double)query->n_points,
                      "must have at most 10000 elements");
    }
    Pelagos__SurfaceQuery own = *query;
    own.n_points = 0; /* the points are checked faster below */
    enum pel_err err = pel_command_check(&own.base, fault);
    if (err != PEL_OK) {
        return err;
    }
    struct pel_vec2 *points = g_new(struct pel_vec2, query->n_points + 1);
    err = take_points(query, points, fault);
    if (err != PEL_OK) {
        g_free(points);
        return err;
    }
    const struct pel_surface_wish wish = {
        .points_m = points,
        .count = query->n_points,
        .has_time = query->has_time,
        .time_s = query->time,
        .moving = query->has_acceleration && query->acceleration,
        .foam = query->has_foam && query->foam,
        .asker = asker,
        .rank = rank,
        .form = form,
        .frame = query->has_frame ? query->frame : 0,
    };
    err = pel_frames_surface(frames, &wish, done, user, fault);
    g_free(points);
    return err;
}

/* One allocation holds a point and its vectors. */
struct point_block {
    Pelagos__SurfacePoint point;
    Pelagos__Vector normal, velocity, acceleration;
};

static void set_vector(Pelagos__Vector *out, struct pel_vec3 v)
{
    pelagos__vector__init(out);
    out->has_east = out->has_north = out->has_up = true;
    out->east = v.x;
    out->north = v.y;
    out->up = v.z;
}

Pelagos__Surface *pel_surface_message(double time_s,
                                      const struct pel_surface_sample *samples,
                                      size_t count)
{
    Pelagos__Surface *surface = g_new(Pelagos__Surface, 1);
    pelagos__surface__init(surface);
    surface->has_time = true;
    surface->time = time_s;
    struct point_block *blocks = g_new(struct point_block, count + 1);
    surface->n_points = count;
    surface->points = g_new(Pelagos__SurfacePoint *, count + 1);
    for (size_t i = 0; i < count; i++) {
        struct point_block *block = &blocks[i];
        pelagos__surface_point__init(&block->point);
        block->point.has_height = true;
        block->point.height = samples[i].height_m;
        if (!isnan(samples[i].depth_m)) {
            block->point.has_depth = block->point.has_sounding = true;
            block->point.depth = samples[i].depth_m;
            block->point.sounding =
                fmax(samples[i].depth_m + samples[i].height_m, 0.0);
        }
        block->point.has_foam = !isnan(samples[i].foam);
        block->point.foam = block->point.has_foam ? samples[i].foam : 0;
        set_vector(&block->normal, samples[i].normal);
        set_vector(&block->velocity, samples[i].velocity_mps);
        block->point.normal = &block->normal;
        block->point.velocity = &block->velocity;
        if (!isnan(samples[i].acceleration_mps2.x)) {
            set_vector(&block->acceleration, samples[i].acceleration_mps2);
            block->point.acceleration = &block->acceleration;
        }
        surface->points[i] = &block->point;
    }
    surface->points[count] = &blocks[0].point; /* kept for the free */
    return surface;
}

void pel_surface_message_free(Pelagos__Surface *surface)
{
    g_free(surface->points[surface->n_points]);
    g_free(surface->points);
    g_free(surface);
}

uint8_t *pel_fault_reply(bool has_id, uint64_t id,
                         const struct pel_fault *fault, size_t *size)
{
    Pelagos__Error error;
    struct pel_fault shown = *fault;
    pel_fault_clean(&shown);
    pel_fault_to_error(&shown, &error);
    Pelagos__Reply reply = PELAGOS__REPLY__INIT;
    reply.has_id = has_id;
    reply.id = id;
    reply.result_case = PELAGOS__REPLY__RESULT_ERROR;
    reply.error = &error;
    return pel_wire_pack(&reply.base, size);
}
