/* Delimited messages over one socket, with deadlines. Private to libpelagos;
 * one thread at a time. */
#pragma once

#include <protobuf-c/protobuf-c.h>
#include <stddef.h>
#include <stdint.h>

struct secure;

struct stream {
    int fd;
    struct secure *secure; /* TLS, or NULL */
    uint8_t *buffer;       /* bytes [start, end) are read and not yet used */
    size_t capacity, start, end;
    size_t used; /* bytes of the message handed out last */
};

enum stream_open {
    STREAM_OPENED,
    STREAM_BAD_ADDRESS,
    STREAM_UNREACHABLE,
};

enum stream_result {
    STREAM_OK,
    STREAM_TIMEOUT,
    STREAM_CLOSED,
    STREAM_MALFORMED,
};

/* Connects to tcp:HOST:PORT, tls:HOST:PORT or unix:PATH; `why` gets the reason
 * of UNREACHABLE. */
enum stream_open stream_open(struct stream *stream, const char *address,
                             int timeout_ms, char *why, size_t why_size);
void stream_close(struct stream *stream);

/* Waits for events of poll(2) on fd: OK or TIMEOUT; OK also where poll reports
 * an error, which the following read or write then meets. */
enum stream_result stream_wait(int fd, short events, int64_t deadline_ns);

/* CLOCK_MONOTONIC after timeout_ms; -1: never. */
int64_t stream_deadline(int timeout_ms);

enum stream_result stream_write(struct stream *stream,
                                const ProtobufCMessage *message,
                                int64_t deadline_ns);

/* Bytes as they are. */
enum stream_result stream_send(struct stream *stream, const void *data,
                               size_t size, int64_t deadline_ns);

/* Appends what comes, at least a byte, to [start, end), which may move; room
 * is made for `missing` bytes. */
enum stream_result stream_receive(struct stream *stream, size_t missing,
                                  int64_t deadline_ns);

/* The next message; its bytes are valid until stream_consume. After TIMEOUT
 * the bytes that came so far are kept. */
enum stream_result stream_read(struct stream *stream, int64_t deadline_ns,
                               const uint8_t **data, size_t *size);
void stream_consume(struct stream *stream);
