#include "bridges/modbus_rtu.h"

#include <modbus/modbus.h>
#include <string.h>

#include "bridges/modbus_adu.h"

#define CRC 2
#define LONGEST 256 /* of a frame */

uint16_t pel_modbus_crc(const uint8_t *bytes, size_t size)
{
    unsigned crc = 0xffff;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc & 1 ? crc >> 1 ^ 0xa001 : crc >> 1;
        }
    }
    return (uint16_t)crc;
}

/* Bytes of the frame, CRC too; 0: not known yet, or by its CRC alone. */
static size_t length_of(const uint8_t *bytes, size_t size)
{
    switch (bytes[1]) {
    case MODBUS_FC_READ_COILS:
    case MODBUS_FC_READ_DISCRETE_INPUTS:
    case MODBUS_FC_READ_HOLDING_REGISTERS:
    case MODBUS_FC_READ_INPUT_REGISTERS:
    case MODBUS_FC_WRITE_SINGLE_COIL:
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
        return 6 + CRC;
    case MODBUS_FC_WRITE_MULTIPLE_COILS:
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
        return size > 6 ? 7 + (size_t)bytes[6] + CRC : 0;
    case MODBUS_FC_REPORT_SLAVE_ID:
        return 2 + CRC;
    case MODBUS_FC_MASK_WRITE_REGISTER:
        return 8 + CRC;
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
        return size > 10 ? 11 + (size_t)bytes[10] + CRC : 0;
    case PEL_MODBUS_FC_ENCAPSULATED:
        return size > 2 && bytes[2] == PEL_MODBUS_MEI_IDENTIFY ? 5 + CRC : 0;
    default:
        return 0;
    }
}

static int known(const uint8_t *bytes, size_t size)
{
    switch (bytes[1]) {
    case MODBUS_FC_WRITE_MULTIPLE_COILS:
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
        return 1;
    case PEL_MODBUS_FC_ENCAPSULATED:
        return size < 3 || bytes[2] == PEL_MODBUS_MEI_IDENTIFY;
    default:
        return length_of(bytes, size) > 0;
    }
}

enum pel_modbus_frame pel_modbus_rtu_frame(const uint8_t *bytes, size_t size)
{
    if (size < 2 + CRC) {
        return PEL_MODBUS_PART;
    }
    size_t whole = length_of(bytes, size);
    if (whole > LONGEST) {
        return PEL_MODBUS_BROKEN;
    }
    if (known(bytes, size) && (whole == 0 || size < whole)) {
        return PEL_MODBUS_PART;
    }
    uint16_t crc = pel_modbus_crc(bytes, size - CRC);
    if (bytes[size - 2] == (crc & 0xff) && bytes[size - 1] == crc >> 8) {
        return PEL_MODBUS_WHOLE;
    }
    return whole > 0 || size >= LONGEST ? PEL_MODBUS_BROKEN : PEL_MODBUS_PART;
}

size_t pel_modbus_rtu_to_tcp(uint8_t *bytes, size_t size)
{
    size_t body = size - CRC; /* unit and request */
    memmove(bytes + PEL_MODBUS_HEADER - 1, bytes, body);
    memset(bytes, 0, 4);
    bytes[4] = (uint8_t)(body >> 8);
    bytes[5] = (uint8_t)body;
    return body + PEL_MODBUS_HEADER - 1;
}

size_t pel_modbus_tcp_to_rtu(uint8_t *bytes, size_t size)
{
    if (size <= PEL_MODBUS_HEADER) {
        return 0;
    }
    size_t body = size - (PEL_MODBUS_HEADER - 1);
    memmove(bytes, bytes + PEL_MODBUS_HEADER - 1, body);
    uint16_t crc = pel_modbus_crc(bytes, body);
    bytes[body] = (uint8_t)crc;
    bytes[body + 1] = (uint8_t)(crc >> 8);
    return body + CRC;
}
