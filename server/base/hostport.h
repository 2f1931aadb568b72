/* HOST:PORT as options and lists give it: 127.0.0.1:1502, [::1]:1502,
 * localhost:0, chart.example:10110. Pure functions. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#define PEL_HOST_SIZE 254

enum pel_host {
    PEL_HOST_NONE,   /* not HOST:PORT */
    PEL_HOST_NUMBER, /* IPv4, or IPv6 in brackets */
    PEL_HOST_NAME,   /* letters, digits, hyphens, dots */
};

/* Host without brackets, localhost as 127.0.0.1; port 0..65535. */
enum pel_host pel_hostport_split(const char *text, char host[PEL_HOST_SIZE],
                                 uint16_t *port);

/* Whether `host` is a numeric address of `family` (AF_UNSPEC: of either), and
 * the address of a socket there. */
bool pel_hostport_address(const char *host, uint16_t port, int family,
                          struct sockaddr_storage *out, socklen_t *size);
