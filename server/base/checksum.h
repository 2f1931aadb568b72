/* A checksum against damage, not against forgery. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* CRC-32C (Castagnoli 1993, polynomial 0x1edc6f41 reflected, as RFC 3720 has
 * it) of what came before, `crc` (0: nothing), and these bytes. Any thread. */
uint32_t pel_crc32c(uint32_t crc, const void *data, size_t size);
