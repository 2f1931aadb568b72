#include "net/tcpinfo.h"

#include <netinet/in.h>
#include <sys/socket.h>

/* glibc's netinet/tcp.h has an older struct tcp_info. */
#include <linux/tcp.h>

uint64_t pel_tcp_received(int fd)
{
    struct tcp_info info = { 0 };
    socklen_t size = sizeof info;
    return getsockopt(fd, IPPROTO_TCP, TCP_INFO, &info, &size) == 0
               ? info.tcpi_bytes_received
               : 0;
}
