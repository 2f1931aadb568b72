/* What the kernel knows of a TCP connection. */
#pragma once

#include <stdint.h>

/* Bytes received so far; 0 where that is not known. Any thread. */
uint64_t pel_tcp_received(int fd);
