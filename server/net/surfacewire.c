#include "net/surfacewire.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/reserve.h"
#include "json.h"
#include "net/command.h"
#include "pelagos.pb-c.h"
#include "wire.h"

/* Tags: number << 3 | type; a double is fixed64, 1, and a message 2. */
enum tag {
    REPLY_ID = 1 << 3,
    SURFACE_TIME = 1 << 3 | 1,
    SURFACE_POINTS = 2 << 3 | 2,
    POINT_HEIGHT = 1 << 3 | 1,
    POINT_NORMAL = 2 << 3 | 2,
    POINT_VELOCITY = 3 << 3 | 2,
    POINT_ACCELERATION = 4 << 3 | 2,
    POINT_FOAM = 5 << 3 | 1,
    POINT_DEPTH = 12 << 3 | 1,
    POINT_SOUNDING = 13 << 3 | 1,
    VECTOR_EAST = 1 << 3 | 1,
    VECTOR_NORTH = 2 << 3 | 1,
    VECTOR_UP = 3 << 3 | 1,
};
enum { DOUBLE = 1 + 8, VECTOR = 3 * DOUBLE, MOST_VARINT = 10 };

static uint8_t *put_double(uint8_t *to, enum tag tag, double value)
{
    *to++ = (uint8_t)tag;
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 8; i++) {
        to[i] = (uint8_t)(bits >> 8 * i);
    }
    return to + 8;
}

static uint8_t *put_vector(uint8_t *to, enum tag tag, struct pel_vec3 v)
{
    *to++ = (uint8_t)tag;
    *to++ = VECTOR;
    to = put_double(to, VECTOR_EAST, v.x);
    to = put_double(to, VECTOR_NORTH, v.y);
    return put_double(to, VECTOR_UP, v.z);
}

static size_t point_size(const struct pel_surface_sample *s)
{
    return DOUBLE + 2 * (2 + VECTOR) +
           (isnan(s->acceleration_mps2.x) ? 0 : 2 + VECTOR) +
           (isnan(s->foam) ? 0 : DOUBLE) + (isnan(s->depth_m) ? 0 : 2 * DOUBLE);
}
_Static_assert(4 * DOUBLE + 3 * (2 + VECTOR) < 128, "a length is one byte");

static uint8_t *put_point(uint8_t *to, const struct pel_surface_sample *s)
{
    *to++ = SURFACE_POINTS;
    *to++ = (uint8_t)point_size(s);
    to = put_double(to, POINT_HEIGHT, s->height_m);
    to = put_vector(to, POINT_NORMAL, s->normal);
    to = put_vector(to, POINT_VELOCITY, s->velocity_mps);
    if (!isnan(s->acceleration_mps2.x)) {
        to = put_vector(to, POINT_ACCELERATION, s->acceleration_mps2);
    }
    if (!isnan(s->foam)) {
        to = put_double(to, POINT_FOAM, s->foam);
    }
    if (!isnan(s->depth_m)) {
        to = put_double(to, POINT_DEPTH, s->depth_m);
        to =
            put_double(to, POINT_SOUNDING, fmax(s->depth_m + s->height_m, 0.0));
    }
    return to;
}

static size_t put_varint(uint8_t *to, uint64_t value)
{
    size_t n = 0;
    for (; value >= 0x80; value >>= 7) {
        to[n++] = (uint8_t)(value | 0x80);
    }
    to[n++] = (uint8_t)value;
    return n;
}

static char *reply_slice(const struct pel_surface_sample *samples, size_t first,
                         size_t count, size_t *size)
{
    (void)first;
    *size = 0;
    for (size_t i = 0; i < count; i++) {
        *size += 2 + point_size(&samples[i]);
    }
    uint8_t *out = pel_sure_malloc(*size + 1), *to = out;
    for (size_t i = 0; i < count; i++) {
        to = put_point(to, &samples[i]);
    }
    return (char *)out;
}

static size_t reply_head(const struct pel_surface_form *form, double time_s,
                         size_t count, size_t size, char out[PEL_SURFACE_HEAD])
{
    enum { REPLY_SURFACE = PELAGOS__REPLY__RESULT_SURFACE << 3 | 2 };
    uint8_t head[1 + MOST_VARINT + 1 + MOST_VARINT];
    size_t surface = DOUBLE + size, before = 0;
    (void)count;
    if (form->has_id) {
        head[before++] = REPLY_ID;
        before += put_varint(head + before, form->id);
    }
    head[before++] = REPLY_SURFACE;
    before += put_varint(head + before, surface);
    uint8_t *to = (uint8_t *)out;
    to += pel_wire_prefix(before + surface, to);
    memcpy(to, head, before);
    to = put_double(to + before, SURFACE_TIME, time_s);
    return (size_t)(to - (uint8_t *)out);
}
_Static_assert(PEL_WIRE_MAX_PREFIX + 2 * (1 + MOST_VARINT) + DOUBLE <=
                   PEL_SURFACE_HEAD,
               "the head has room");

struct pel_surface_form pel_surface_reply(bool has_id, uint64_t id)
{
    return (struct pel_surface_form){
        .slice = reply_slice, .head = reply_head, .has_id = has_id, .id = id
    };
}

/* --- JSON ----------------------------------------------------------------- */

static char *json_slice(const struct pel_surface_sample *samples, size_t first,
                        size_t count, size_t *size)
{
    Pelagos__Surface *surface = pel_surface_message(0, samples, count);
    GString *out = g_string_new(NULL);
    for (size_t i = 0; i < count; i++) {
        char *point = pel_json_from_message(&surface->points[i]->base, false);
        g_string_append(out, first + i > 0 ? "," : "");
        g_string_append(out, point);
        free(point);
    }
    pel_surface_message_free(surface);
    *size = out->len;
    return g_string_free(out, FALSE);
}

static size_t json_head(const struct pel_surface_form *form, double time_s,
                        size_t count, size_t size, char out[PEL_SURFACE_HEAD])
{
    char time[32];
    (void)form;
    (void)size;
    pel_json_number(time_s, time);
    return (size_t)snprintf(out, PEL_SURFACE_HEAD, "{\"time\":%s%s", time,
                            count > 0 ? ",\"points\":[" : "");
}

static const char *json_tail(size_t count)
{
    return count > 0 ? "]}" : "}";
}

const struct pel_surface_form pel_surface_json = {
    .slice = json_slice, .head = json_head, .tail = json_tail, .slow = true
};
