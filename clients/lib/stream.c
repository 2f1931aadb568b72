#include "stream.h"

#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "proto/wire.h"
#include "secure.h"

/* A 4096 × 4096 EXR with all layers as floats is 470 MB. */
#define MAX_REPLY ((size_t)512 << 20)
#define FIRST_CAPACITY ((size_t)64 << 10)

static int64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

int64_t stream_deadline(int timeout_ms)
{
    return timeout_ms < 0 ? INT64_MAX
                          : now_ns() + (int64_t)timeout_ms * 1000000;
}

enum stream_result stream_wait(int fd, short events, int64_t deadline_ns)
{
    for (;;) {
        int timeout_ms = -1;
        if (deadline_ns != INT64_MAX) {
            int64_t left_ns = deadline_ns - now_ns();
            timeout_ms = left_ns <= 0 ? 0 : (int)(left_ns / 1000000) + 1;
        }
        struct pollfd wanted = { .fd = fd, .events = events };
        int ready = poll(&wanted, 1, timeout_ms);
        if (ready > 0) {
            return STREAM_OK;
        }
        if (ready == 0) {
            return STREAM_TIMEOUT;
        }
        if (errno != EINTR) {
            return STREAM_CLOSED;
        }
    }
}

static int connect_to(const struct sockaddr *address, socklen_t size,
                      int64_t deadline_ns)
{
    int fd = socket(address->sa_family,
                    SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) {
        return -1;
    }
    int failure = 0;
    if (connect(fd, address, size) != 0) {
        failure = errno;
        if (failure == EINPROGRESS) {
            socklen_t length = sizeof failure;
            if (stream_wait(fd, POLLOUT, deadline_ns) != STREAM_OK) {
                failure = ETIMEDOUT;
            } else if (getsockopt(fd, SOL_SOCKET, SO_ERROR, &failure,
                                  &length) != 0) {
                failure = errno;
            }
        }
    }
    if (failure != 0) {
        close(fd);
        errno = failure;
        return -1;
    }
    return fd;
}

static int connect_unix(const char *path, int64_t deadline_ns)
{
    struct sockaddr_un address = { .sun_family = AF_UNIX };
    size_t length = strlen(path);
    if (length >= sizeof address.sun_path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    memcpy(address.sun_path, path, length + 1);
    return connect_to((const struct sockaddr *)&address, sizeof address,
                      deadline_ns);
}

/* Splits HOST:PORT or [HOST]:PORT. */
static int split_host(const char *text, char *host, size_t size,
                      const char **port)
{
    const char *colon = strrchr(text, ':');
    if (!colon || colon == text || !colon[1]) {
        return -1;
    }
    size_t length = (size_t)(colon - text);
    if (text[0] == '[' && text[length - 1] == ']') {
        text++;
        length -= 2;
    }
    if (length == 0 || length >= size) {
        return -1;
    }
    memcpy(host, text, length);
    host[length] = '\0';
    *port = colon + 1;
    return 0;
}

static int connect_tcp(const char *host, const char *port, int64_t deadline_ns,
                       char *why, size_t why_size)
{
    struct addrinfo hints = { .ai_socktype = SOCK_STREAM };
    struct addrinfo *list = NULL;
    int failure = getaddrinfo(host, port, &hints, &list);
    if (failure != 0) {
        snprintf(why, why_size, "%s", gai_strerror(failure));
        return -1;
    }
    int fd = -1;
    for (struct addrinfo *a = list; a && fd < 0; a = a->ai_next) {
        fd = connect_to(a->ai_addr, a->ai_addrlen, deadline_ns);
    }
    snprintf(why, why_size, "%s", strerror(errno));
    freeaddrinfo(list);
    if (fd >= 0) {
        int one = 1;
        /* Without it a request may wait 40 ms for an acknowledgement. */
        setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    }
    return fd;
}

enum stream_open stream_open(struct stream *stream, const char *address,
                             int timeout_ms, char *why, size_t why_size)
{
    *stream = (struct stream){ .fd = -1 };
    int64_t deadline_ns = stream_deadline(timeout_ms);
    if (strncmp(address, "unix:", 5) == 0 && address[5]) {
        stream->fd = connect_unix(address + 5, deadline_ns);
        snprintf(why, why_size, "%s", strerror(errno));
    } else if (strncmp(address, "tcp:", 4) == 0 ||
               strncmp(address, "tls:", 4) == 0) {
        char host[256];
        const char *port = NULL;
        if (split_host(address + 4, host, sizeof host, &port) != 0) {
            return STREAM_BAD_ADDRESS;
        }
        stream->fd = connect_tcp(host, port, deadline_ns, why, why_size);
        if (stream->fd >= 0 && address[1] == 'l' &&
            secure_open(stream->fd, host, deadline_ns, &stream->secure, why,
                        why_size) != STREAM_OK) {
            stream_close(stream);
        }
    } else {
        return STREAM_BAD_ADDRESS;
    }
    return stream->fd < 0 ? STREAM_UNREACHABLE : STREAM_OPENED;
}

void stream_close(struct stream *stream)
{
    secure_close(stream->secure);
    if (stream->fd >= 0) {
        close(stream->fd);
    }
    free(stream->buffer);
    *stream = (struct stream){ .fd = -1 };
}

enum stream_result stream_write(struct stream *stream,
                                const ProtobufCMessage *message,
                                int64_t deadline_ns)
{
    size_t size = 0;
    uint8_t *bytes = pel_wire_pack(message, &size);
    if (!bytes) {
        return STREAM_CLOSED;
    }
    enum stream_result result = stream_send(stream, bytes, size, deadline_ns);
    free(bytes);
    return result;
}

enum stream_result stream_send(struct stream *stream, const void *data,
                               size_t size, int64_t deadline_ns)
{
    const uint8_t *bytes = data;
    size_t sent = 0;
    enum stream_result result = STREAM_OK;
    if (stream->secure) {
        return secure_send(stream->secure, data, size, deadline_ns);
    }
    while (sent < size && result == STREAM_OK) {
        ssize_t n = send(stream->fd, bytes + sent, size - sent, MSG_NOSIGNAL);
        if (n >= 0) {
            sent += (size_t)n;
        } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
            result = stream_wait(stream->fd, POLLOUT, deadline_ns);
        } else if (errno != EINTR) {
            result = STREAM_CLOSED;
        }
    }
    return result;
}

/* Room for `more` bytes after those that are there. */
static int reserve(struct stream *stream, size_t more)
{
    if (stream->start > 0) {
        memmove(stream->buffer, stream->buffer + stream->start,
                stream->end - stream->start);
        stream->end -= stream->start;
        stream->start = 0;
    }
    size_t needed = stream->end + more;
    if (needed <= stream->capacity) {
        return 0;
    }
    size_t capacity = stream->capacity ? stream->capacity : FIRST_CAPACITY;
    while (capacity < needed) {
        capacity *= 2;
    }
    uint8_t *buffer = realloc(stream->buffer, capacity);
    if (!buffer) {
        return -1;
    }
    stream->buffer = buffer;
    stream->capacity = capacity;
    return 0;
}

enum stream_result stream_receive(struct stream *stream, size_t missing,
                                  int64_t deadline_ns)
{
    size_t room = missing > FIRST_CAPACITY / 2 ? missing : FIRST_CAPACITY / 2;
    if (reserve(stream, room) != 0) {
        return STREAM_CLOSED;
    }
    if (stream->secure) {
        size_t got = 0;
        enum stream_result result =
            secure_receive(stream->secure, stream->buffer + stream->end,
                           stream->capacity - stream->end, deadline_ns, &got);
        stream->end += got;
        return result;
    }
    for (;;) {
        ssize_t n = recv(stream->fd, stream->buffer + stream->end,
                         stream->capacity - stream->end, 0);
        if (n > 0) {
            stream->end += (size_t)n;
            return STREAM_OK;
        }
        if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
            return STREAM_CLOSED;
        }
        if (errno == EAGAIN) {
            enum stream_result result =
                stream_wait(stream->fd, POLLIN, deadline_ns);
            if (result != STREAM_OK) {
                return result;
            }
        }
    }
}

enum stream_result stream_read(struct stream *stream, int64_t deadline_ns,
                               const uint8_t **data, size_t *size)
{
    for (;;) {
        size_t offset = 0, length = 0;
        size_t there = stream->end - stream->start;
        if (there > 0) {
            const uint8_t *start = stream->buffer + stream->start;
            /* The other port; as a message of ours it would be malformed. */
            if (there >= 5 && memcmp(start, "HTTP/", 5) == 0) {
                return STREAM_MALFORMED;
            }
            enum pel_wire found =
                pel_wire_next(start, there, MAX_REPLY, &offset, &length);
            if (found == PEL_WIRE_MESSAGE) {
                *data = start + offset;
                *size = length;
                stream->used = offset + length;
                return STREAM_OK;
            }
            if (found != PEL_WIRE_MORE) {
                return STREAM_MALFORMED;
            }
        }
        size_t whole = length + PEL_WIRE_MAX_PREFIX;
        enum stream_result result = stream_receive(
            stream, whole > there ? whole - there : 1, deadline_ns);
        if (result != STREAM_OK) {
            return result;
        }
    }
}

void stream_consume(struct stream *stream)
{
    stream->start += stream->used;
    stream->used = 0;
    if (stream->start == stream->end) {
        stream->start = stream->end = 0;
        /* A float EXR now and then should not be held for ever. */
        if (stream->capacity > (size_t)16 << 20) {
            free(stream->buffer);
            stream->buffer = NULL;
            stream->capacity = 0;
        }
    }
}
