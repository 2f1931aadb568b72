#include "bridges/cigi_types.h"

#include <stdlib.h>
#include <string.h>

#include "fault.h"
#include "json.h"
#include "ranges.h"
#include "scene/fleet.h"

#define BLANKS " \t\r"

static enum pel_err read_model(const char *text, size_t length,
                               Pelagos__Model **out, struct pel_fault *fault)
{
    ProtobufCMessage *message = NULL;
    enum pel_err err = pel_json_to_message(
        text, length, &pelagos__model__descriptor, &message, fault);
    if (err) {
        return err;
    }
    *out = (Pelagos__Model *)message;
    err = pel_message_check(message, "", fault);
    if (!err && (!(*out)->name || !*(*out)->name)) {
        err = pel_fault_set(fault, PEL_ERR_INVALID,
                            "the model wants a name, say \"tanker\"");
    }
    return err ? err : pel_fleet_try(*out, fault);
}

static enum pel_err read_line(struct pel_cigi_types *types, const char *line,
                              size_t length, struct pel_fault *fault)
{
    const char *text = line;
    const char *stop = line + length;
    while (text < stop && strchr(BLANKS, *text)) {
        text++;
    }
    if (text == stop || *text == '#') {
        return PEL_OK;
    }
    unsigned number = 0;
    const char *digits = text;
    while (text < stop && *text >= '0' && *text <= '9' && number <= 65535) {
        number = 10 * number + (unsigned)(*text++ - '0');
    }
    if (text == digits || number > 65535 || text == stop ||
        !strchr(BLANKS "{", *text)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "a line begins with an entity type, a whole "
                             "number within 0 .. 65535, and goes on with a "
                             "model, say {\"name\": \"tanker\"}");
    }
    if (pel_cigi_types_find(types, number)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "type %u has an earlier line; remove one", number);
    }
    if (types->count == PEL_CIGI_TYPES_MOST) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "a table has at most %d types",
                             PEL_CIGI_TYPES_MOST);
    }
    struct pel_cigi_type *type = &types->types[types->count];
    enum pel_err err =
        read_model(text, (size_t)(stop - text), &type->model, fault);
    if (type->model) {
        type->number = (uint16_t)number;
        types->count++;
    }
    return err;
}

enum pel_err pel_cigi_types_read(const char *text, size_t size,
                                 struct pel_cigi_types *out,
                                 struct pel_fault *fault)
{
    const char *end = text + size;
    *out = (struct pel_cigi_types){ 0 };
    for (int number = 1; text < end; number++) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        stop = stop ? stop : end;
        struct pel_fault why = { 0 };
        enum pel_err err =
            memchr(text, 0, (size_t)(stop - text))
                ? pel_fault_set(&why, PEL_ERR_INVALID, "not a line of text")
                : read_line(out, text, (size_t)(stop - text), &why);
        if (err) {
            pel_cigi_types_finish(out);
            return pel_fault_set(fault, err, "line %d: %s", number,
                                 why.message);
        }
        text = stop + 1;
    }
    return out->count > 0
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_INVALID, "the table has no type");
}

void pel_cigi_types_finish(struct pel_cigi_types *types)
{
    for (size_t i = 0; i < types->count; i++) {
        pelagos__model__free_unpacked(types->types[i].model, NULL);
    }
    types->count = 0;
}

const Pelagos__Model *pel_cigi_types_find(const struct pel_cigi_types *types,
                                          unsigned number)
{
    for (size_t i = 0; i < types->count; i++) {
        if (types->types[i].number == number) {
            return types->types[i].model;
        }
    }
    return NULL;
}
