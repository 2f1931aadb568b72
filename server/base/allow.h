/* Lists of addresses and networks. Any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>

#include "base/err.h"

#define PEL_MAX_ALLOWED 32

struct pel_allow {
    size_t count;
    struct {
        uint8_t address[16]; /* IPv4 as ::ffff:a.b.c.d */
        int bits;
    } rules[PEL_MAX_ALLOWED];
};

/* Reads `10.0.0.7,192.168.1.0/24,fd00::/8`; NULL or "": loopback only.
 * INVALID names the entry. */
PEL_CHECK enum pel_err pel_allow_parse(const char *text, struct pel_allow *out,
                                       struct pel_fault *fault);
bool pel_allow_has(const struct pel_allow *allow, const struct sockaddr *peer);
