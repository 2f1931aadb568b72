/* One complete Modbus/TCP ADU to its answer. The form is tested here, the map
 * decides, libmodbus makes the bytes: its context writes into one end of a
 * socket pair of ours and never sees a client. Control thread. */
#pragma once

#include <modbus/modbus.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/modbus_map.h"

#define PEL_MODBUS_HEADER 7 /* transaction, protocol, length, unit */
#define PEL_MODBUS_MAX_ADU 260
#define PEL_MODBUS_FC_ENCAPSULATED 0x2b
#define PEL_MODBUS_MEI_IDENTIFY 0x0e

struct pel_modbus_responder {
    modbus_t *context;
    modbus_mapping_t *mapping;
    int ends[2]; /* libmodbus writes to the first, we read the second */
};

PEL_CHECK enum pel_err
pel_modbus_responder_init(struct pel_modbus_responder *responder,
                          struct pel_fault *fault);
void pel_modbus_responder_finish(struct pel_modbus_responder *responder);

/* `adu` has PEL_MODBUS_MAX_ADU bytes, of which `size`, 8 or more, are the
 * request. Writes the answer, at most PEL_MODBUS_MAX_ADU bytes, and returns
 * its size, 0 if libmodbus failed. *code is the exception answered. */
size_t pel_modbus_answer(struct pel_modbus_responder *responder,
                         struct pel_modbus_map *map, const uint8_t *adu,
                         size_t size, uint8_t *answer,
                         enum pel_modbus_exception *code);

/* An exception answer without looking at the request's body. */
size_t pel_modbus_refuse(struct pel_modbus_responder *responder,
                         const uint8_t *adu, enum pel_modbus_exception code,
                         uint8_t *answer);
