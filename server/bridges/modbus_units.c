#include "bridges/modbus_units.h"

#include <glib.h>
#include <stdlib.h>
#include <string.h>

#include "path.h"
#include "scene/snapshot.h"

static bool read_number(const char *text, unsigned long most, unsigned *out)
{
    char *end;
    unsigned long n = strtoul(text, &end, 10);
    if (*text < '0' || *text > '9' || *end != 0 || n > most) {
        return false;
    }
    *out = (unsigned)n;
    return true;
}

static bool read_order(const char *text, enum pel_modbus_order *out)
{
    static const char *const words[] = { "abcd", "cdab", "badc", "dcba" };
    for (unsigned i = 0; i < G_N_ELEMENTS(words); i++) {
        if (strcmp(text, words[i]) == 0) {
            *out = (enum pel_modbus_order)i;
            return true;
        }
    }
    return false;
}

static bool read_unit(char **parts, struct pel_modbus_unit *unit)
{
    unsigned number, entity = 1;
    guint count = g_strv_length(parts);
    if (count < 1 || count > 4 || !read_number(parts[0], 247, &number) ||
        number == 0 || (count > 1 && !read_order(parts[1], &unit->order)) ||
        (count > 2 && !read_number(parts[2], 65535, &entity)) ||
        (count > 3 &&
         !read_number(parts[3], PEL_MAX_VIEWS - 1, &unit->first_view))) {
        return false;
    }
    unit->number = (int)number;
    unit->entity = entity;
    unit->has_entity = count > 2;
    return true;
}

enum pel_err
pel_modbus_units_read(const char *text, enum pel_modbus_order order,
                      struct pel_modbus_unit out[PEL_MODBUS_MAX_UNITS],
                      size_t *count, struct pel_fault *fault)
{
    const struct pel_modbus_unit plain = { .number = -1,
                                           .order = order,
                                           .entity = 1 };
    if (strcmp(text, "any") == 0) {
        out[0] = plain;
        *count = 1;
        return PEL_OK;
    }
    g_auto(GStrv) words = g_strsplit(text, ",", PEL_MODBUS_MAX_UNITS + 1);
    *count = g_strv_length(words);
    if (*count == 0 || *count > PEL_MODBUS_MAX_UNITS) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "--modbus-units: any, or 1 to %d units",
                             PEL_MODBUS_MAX_UNITS);
    }
    for (size_t i = 0; i < *count; i++) {
        g_auto(GStrv) parts = g_strsplit(words[i], ":", 5);
        out[i] = plain;
        if (!read_unit(parts, &out[i])) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "--modbus-units: '%.60s' is not "
                                 "UNIT[:ORDER[:ENTITY[:VIEW]]], 1..247, an "
                                 "order like abcd, 0..65535, 0..63",
                                 words[i]);
        }
        for (size_t k = 0; k < i; k++) {
            if (out[k].number == out[i].number) {
                return pel_fault_set(fault, PEL_ERR_INVALID,
                                     "--modbus-units: unit %d is there twice",
                                     out[i].number);
            }
        }
    }
    return PEL_OK;
}

enum pel_err pel_modbus_safe_read(const char *text, Pelagos__Patch **out,
                                  struct pel_fault *fault)
{
    *out = NULL;
    if (*text == 0) {
        return PEL_OK;
    }
    g_auto(GStrv) words = g_strsplit(text, ",", -1);
    Pelagos__Patch *patch = pel_patch_new();
    for (size_t i = 0; words[i]; i++) {
        char *equals = strchr(words[i], '=');
        enum pel_err err = PEL_ERR_INVALID;
        if (equals) {
            *equals = 0;
            err = pel_path_set(patch, NULL, words[i], equals + 1, fault);
        } else {
            pel_fault_set(fault, err, "'%.60s' is not PATH=VALUE", words[i]);
        }
        if (err) {
            pelagos__patch__free_unpacked(patch, NULL);
            return err;
        }
    }
    *out = patch;
    return PEL_OK;
}
