#include "fault.h"

#include <stdio.h>
#include <string.h>

#include "fields.h"
#include "path.h"

static Pelagos__ErrorCode code_of(enum pel_err err)
{
    switch (err) {
    case PEL_ERR_MALFORMED:
        return PELAGOS__ERROR_CODE__MALFORMED;
    case PEL_ERR_NOT_FOUND:
        return PELAGOS__ERROR_CODE__NOT_FOUND;
    case PEL_ERR_OUT_OF_RANGE:
        return PELAGOS__ERROR_CODE__OUT_OF_RANGE;
    case PEL_ERR_INVALID:
        return PELAGOS__ERROR_CODE__INVALID;
    case PEL_ERR_CONFLICT:
        return PELAGOS__ERROR_CODE__CONFLICT;
    case PEL_ERR_BUSY:
        return PELAGOS__ERROR_CODE__BUSY;
    case PEL_ERR_UNAUTHORIZED:
        return PELAGOS__ERROR_CODE__UNAUTHORIZED;
    case PEL_ERR_FORBIDDEN:
        return PELAGOS__ERROR_CODE__FORBIDDEN;
    case PEL_ERR_FULL:
        return PELAGOS__ERROR_CODE__IO;
    default:
        return PELAGOS__ERROR_CODE__INTERNAL;
    }
}

static enum pel_err err_of(Pelagos__ErrorCode code)
{
    for (enum pel_err err = PEL_ERR_MALFORMED; err < PEL_ERR_INTERNAL; err++) {
        if (code_of(err) == code) {
            return err;
        }
    }
    return PEL_ERR_INTERNAL;
}

static char *or_null(const char *text)
{
    return text[0] ? (char *)text : NULL;
}

void pel_fault_to_error(const struct pel_fault *fault, Pelagos__Error *out)
{
    pelagos__error__init(out);
    out->has_code = true;
    out->code = code_of(fault->code);
    out->path = or_null(fault->path);
    out->value = or_null(fault->value);
    out->unit = (char *)fault->unit;
    out->has_minimum = out->has_maximum = fault->minimum <= fault->maximum;
    out->minimum = out->has_minimum ? fault->minimum : 0;
    out->maximum = out->has_maximum ? fault->maximum : 0;
    out->message = or_null(fault->message);
}

static const char *known_unit(const char *unit)
{
    for (size_t i = 0; unit && i < pel_field_table_count; i++) {
        const struct pel_field_table *table = &pel_field_tables[i];
        for (unsigned k = 0; k < table->message->n_fields; k++) {
            if (table->fields[k].unit &&
                strcmp(table->fields[k].unit, unit) == 0) {
                return table->fields[k].unit;
            }
        }
    }
    return NULL;
}

/* Cuts at a whole UTF-8 character. */
static void copy(char *to, size_t size, const char *from)
{
    size_t length = strnlen(from, size);
    if (length == size) {
        length = size - 1;
        while (length > 0 && ((unsigned char)from[length] & 0xc0) == 0x80) {
            length--;
        }
    }
    memcpy(to, from, length);
    to[length] = '\0';
}

void pel_fault_from_error(const Pelagos__Error *error, struct pel_fault *out)
{
    *out = (struct pel_fault){
        .code = error->has_code ? err_of(error->code) : PEL_ERR_INTERNAL,
        .unit = known_unit(error->unit),
        .minimum = 1,
        .maximum = 0,
    };
    if (error->has_minimum && error->has_maximum) {
        out->minimum = error->minimum;
        out->maximum = error->maximum;
    }
    copy(out->path, sizeof out->path, error->path ? error->path : "");
    copy(out->value, sizeof out->value, error->value ? error->value : "");
    copy(out->message, sizeof out->message,
         error->message ? error->message : "");
    pel_fault_clean(out);
}

void pel_fault_at(struct pel_fault *fault, const char *path, const char *value)
{
    if (!fault) {
        return;
    }
    copy(fault->path, sizeof fault->path, path ? path : "");
    copy(fault->value, sizeof fault->value, value ? value : "");
    pel_fault_clean(fault);
    struct pel_path_info found;
    if (path && pel_path_find(path, &found, NULL) == PEL_OK && found.info) {
        fault->unit = found.info->unit;
        if (found.info->ranged) {
            fault->minimum = found.info->minimum;
            fault->maximum = found.info->maximum;
        }
    }
}

enum pel_err pel_fault_refuse(enum pel_err code, const char *path,
                              const char *value, const char *what,
                              struct pel_fault *fault)
{
    pel_fault_set(fault, code, "%.90s %s", path, what);
    pel_fault_at(fault, path, value);
    return code;
}
