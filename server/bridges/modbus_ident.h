/* Read Device Identification (function 43, MEI 14; Modbus Application Protocol
 * V1.1b3, 6.21): who made this device, what it is, which version. libmodbus
 * does not answer it. Control thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "bridges/modbus_adu.h"

/* The answer to a request of function 43 as pel_modbus_answer makes it; 0:
 * *code is the exception to be answered. Basic and regular objects, as a stream
 * or one by one. */
size_t pel_modbus_identify(const uint8_t *adu, size_t size, uint8_t *answer,
                           enum pel_modbus_exception *code);
