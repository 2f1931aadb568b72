#include "base/allow.h"

#include <arpa/inet.h>
#include <glib.h>
#include <netinet/in.h>
#include <string.h>

static const uint8_t mapped_prefix[12] = { [10] = 0xff, [11] = 0xff };

static bool read_rule(char *text, uint8_t address[16], int *bits)
{
    char *slash = strchr(text, '/');
    guint64 width = 0;
    if (slash) {
        *slash = 0;
        if (!g_ascii_string_to_unsigned(slash + 1, 10, 0, 128, &width, NULL)) {
            return false;
        }
    }
    if (inet_pton(AF_INET, text, address + 12) == 1) {
        memcpy(address, mapped_prefix, sizeof mapped_prefix);
        *bits = slash ? (int)width + 96 : 128;
        return width <= 32;
    }
    *bits = slash ? (int)width : 128;
    return inet_pton(AF_INET6, text, address) == 1;
}

enum pel_err pel_allow_parse(const char *text, struct pel_allow *out,
                             struct pel_fault *fault)
{
    *out = (struct pel_allow){ 0 };
    if (!text || !*text) {
        text = "127.0.0.0/8,::1";
    }
    while (*text) {
        size_t length = strcspn(text, ", ");
        char entry[64];
        if (length >= sizeof entry || out->count == PEL_MAX_ALLOWED) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "the list of allowed addresses takes at most "
                                 "%d of at most %zu characters",
                                 PEL_MAX_ALLOWED, sizeof entry - 1);
        }
        memcpy(entry, text, length);
        entry[length] = 0;
        if (length > 0) {
            if (!read_rule(entry, out->rules[out->count].address,
                           &out->rules[out->count].bits)) {
                return pel_fault_set(fault, PEL_ERR_INVALID,
                                     "%.*s is no address or network; write "
                                     "10.0.0.7 or 192.168.1.0/24",
                                     (int)length, text);
            }
            out->count++;
        }
        text += length + (text[length] != 0);
    }
    return PEL_OK;
}

static bool to_bytes(const struct sockaddr *peer, uint8_t out[16])
{
    if (peer->sa_family == AF_INET) {
        const struct sockaddr_in *v4 = (const struct sockaddr_in *)peer;
        memcpy(out, mapped_prefix, sizeof mapped_prefix);
        memcpy(out + 12, &v4->sin_addr, 4);
        return true;
    }
    if (peer->sa_family == AF_INET6) {
        const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)peer;
        memcpy(out, &v6->sin6_addr, 16);
        return true;
    }
    return false;
}

bool pel_allow_has(const struct pel_allow *allow, const struct sockaddr *peer)
{
    uint8_t address[16];
    if (!to_bytes(peer, address)) {
        return false;
    }
    for (size_t i = 0; i < allow->count; i++) {
        int bits = allow->rules[i].bits;
        const uint8_t *rule = allow->rules[i].address;
        size_t whole = (size_t)bits / 8;
        uint8_t mask = (uint8_t)(0xff00 >> bits % 8);
        if (memcmp(address, rule, whole) == 0 &&
            (whole == 16 || ((address[whole] ^ rule[whole]) & mask) == 0)) {
            return true;
        }
    }
    return false;
}
