/* Modbus RTU in a stream of bytes (RTU over TCP, as serial servers speak it):
 * frames of a unit, a request, a CRC, without the header of Modbus/TCP. No
 * silence parts them, so a frame's length is that of its function; one of a
 * function that is not known ends where its CRC fits. Pure: any thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* CRC-16 of Modbus over serial line V1.02, 6.2.2; the low byte goes first. */
uint16_t pel_modbus_crc(const uint8_t *bytes, size_t size);

/* Judges the frame that begins with these bytes. */
enum pel_modbus_frame {
    PEL_MODBUS_PART,   /* more is to come */
    PEL_MODBUS_WHOLE,  /* unit and request, and its CRC is right */
    PEL_MODBUS_BROKEN, /* the CRC is wrong, or it is longer than a frame may be
                        */
};
enum pel_modbus_frame pel_modbus_rtu_frame(const uint8_t *bytes, size_t size);

/* A whole frame as an ADU of Modbus/TCP, in place: `size` bytes become the
 * size that is returned, at most 4 more. */
size_t pel_modbus_rtu_to_tcp(uint8_t *bytes, size_t size);

/* An answer of Modbus/TCP as a frame, in place; returns its size. */
size_t pel_modbus_tcp_to_rtu(uint8_t *bytes, size_t size);
