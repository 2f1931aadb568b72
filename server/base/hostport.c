#include "base/hostport.h"

#include <arpa/inet.h>
#include <glib.h>
#include <netinet/in.h>
#include <string.h>

/* As resolvers take them. The last label is no number: such a text is a numeric
 * address with a slip. */
static bool is_name(const char *host)
{
    size_t length = strlen(host);
    const char *dot = strrchr(host, '.');
    const char *last = dot && dot[1] ? dot + 1 : host;
    return length > 0 && *host != '-' && *host != '.' && !strstr(host, "..") &&
           strspn(host, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                        "0123456789-._") == length &&
           strspn(last, "0123456789.") != strlen(last);
}

enum pel_host pel_hostport_split(const char *text, char host[PEL_HOST_SIZE],
                                 uint16_t *port)
{
    const char *colon = strrchr(text, ':');
    guint64 number;
    if (!colon ||
        !g_ascii_string_to_unsigned(colon + 1, 10, 0, 65535, &number, NULL)) {
        return PEL_HOST_NONE;
    }
    size_t length = (size_t)(colon - text);
    bool bracket = length > 2 && text[0] == '[' && colon[-1] == ']';
    length -= bracket ? 2 : 0;
    if (length >= PEL_HOST_SIZE) {
        return PEL_HOST_NONE;
    }
    memcpy(host, text + bracket, length);
    host[length] = 0;
    *port = (uint16_t)number;
    if (!bracket && g_ascii_strcasecmp(host, "localhost") == 0) {
        g_strlcpy(host, "127.0.0.1", PEL_HOST_SIZE);
    }
    uint8_t binary[16];
    return inet_pton(bracket ? AF_INET6 : AF_INET, host, binary) == 1
               ? PEL_HOST_NUMBER
           : !bracket && is_name(host) ? PEL_HOST_NAME
                                       : PEL_HOST_NONE;
}

bool pel_hostport_address(const char *host, uint16_t port, int family,
                          struct sockaddr_storage *out, socklen_t *size)
{
    struct sockaddr_storage address = { 0 };
    struct sockaddr_in *v4 = (struct sockaddr_in *)&address;
    struct sockaddr_in6 *v6 = (struct sockaddr_in6 *)&address;
    if (family != AF_INET6 && inet_pton(AF_INET, host, &v4->sin_addr) == 1) {
        v4->sin_family = AF_INET;
        v4->sin_port = htons(port);
        *size = sizeof *v4;
    } else if (family != AF_INET &&
               inet_pton(AF_INET6, host, &v6->sin6_addr) == 1) {
        v6->sin6_family = AF_INET6;
        v6->sin6_port = htons(port);
        *size = sizeof *v6;
    } else {
        return false;
    }
    *out = address;
    return true;
}
