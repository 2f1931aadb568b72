/* Which units a Modbus server answers, and what a silent one leaves behind:
 * the texts of two options. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "registers.h"

#define PEL_MODBUS_MAX_UNITS 16

/* One unit: a source of its own with its own stage, heartbeat and commits. */
struct pel_modbus_unit {
    int number; /* 1..247, -1: 0, 1 and 255 */
    enum pel_modbus_order order;
    uint32_t entity;     /* that its registers of entity 1 mean */
    bool has_entity;     /* named: its registers of ownShip are its helm's */
    unsigned first_view; /* that its registers of views[0] mean */
};

/* Reads `any`, or a list `UNIT[:ORDER[:ENTITY[:VIEW]]]` like
 * `1,2:cdab:2:4`. What is left out is `order`, entity 1 and view 0. INVALID
 * says which part is wrong. */
PEL_CHECK enum pel_err
pel_modbus_units_read(const char *text, enum pel_modbus_order order,
                      struct pel_modbus_unit out[PEL_MODBUS_MAX_UNITS],
                      size_t *count, struct pel_fault *fault);

/* Reads `PATH=VALUE,PATH=VALUE` into a patch; *out is NULL for an empty text,
 * else freed with pelagos__patch__free_unpacked. INVALID, NOT_FOUND: the path
 * or the form of its value; ranges are tested when it is applied. */
PEL_CHECK enum pel_err pel_modbus_safe_read(const char *text,
                                            Pelagos__Patch **out,
                                            struct pel_fault *fault);
