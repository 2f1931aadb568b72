#include "net/http_head.h"

#include <stdio.h>
#include <string.h>
#include <sys/socket.h>

/* The library (0.9.75) keeps a head in one piece, and puts NULs where tokens
 * and lines end; what it hands out points there. So what lies between two of
 * its strings shows what it passed over. */
struct walk {
    const char *at, *end; /* not looked at yet */
    bool plain;
};

/* Goes on to `to`: on the way there are ends of lines and spaces alone. */
static void pass(struct walk *walk, const char *to)
{
    walk->plain = walk->plain && to >= walk->at && to <= walk->end;
    while (walk->plain && walk->at < to) {
        char c = *walk->at++;
        walk->plain =
            c == '\0' || c == ' ' || c == '\t' || c == '\r' || c == '\n';
    }
}

static enum MHD_Result pass_header(void *user, enum MHD_ValueKind kind,
                                   const char *name, const char *value)
{
    (void)kind;
    struct walk *walk = user;
    pass(walk, name);
    if (walk->plain) {
        walk->at = name + strlen(name);
        value = value ? value : walk->at;
        pass(walk, value);
        walk->at = value + strlen(value);
    }
    return walk->plain ? MHD_YES : MHD_NO;
}

const char *pel_http_head_version(const char *target)
{
    const char *version = target + strlen(target) + 1;
    return strncmp(version, "HTTP/", 5) == 0 ? version + strlen(version) : NULL;
}

static size_t head_size(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(
        connection, MHD_CONNECTION_INFO_REQUEST_HEADER_SIZE);
    return info ? info->header_size : 0;
}

bool pel_http_head_is_in(struct MHD_Connection *connection)
{
    return head_size(connection) > 0;
}

bool pel_http_head_is_plain(struct MHD_Connection *connection,
                            const char *method, const char *target,
                            const char *version)
{
    struct walk walk = { method + strlen(method), target, version != NULL };
    pass(&walk, target);
    walk.at = version; /* the target has been unescaped in its place */
    walk.end = method + head_size(connection);
    if (walk.plain) {
        MHD_get_connection_values(connection, MHD_HEADER_KIND, pass_header,
                                  &walk);
    }
    pass(&walk, walk.end);
    return walk.plain;
}

void pel_http_head_refuse(struct client *client, int status,
                          const struct pel_fault *fault)
{
    struct pel_http_answer answer = { .kind = PEL_HTTP_WHOLE };
    pel_http_problem(&answer, status, fault);
    char head[256];
    int n =
        snprintf(head, sizeof head,
                 "HTTP/1.1 %d %s\r\nConnection: close\r\n"
                 "Content-Type: %s\r\nContent-Length: %zu\r\n\r\n",
                 status, status == 413 ? "Content Too Large" : "Bad Request",
                 answer.type, answer.size);
    client->server->answers[status]++;
    client->server->malformed++;
    struct iovec parts[] = { { head, (size_t)n },
                             { (void *)answer.body, answer.size } };
    struct msghdr message = { .msg_iov = parts, .msg_iovlen = 2 };
    ssize_t sent = sendmsg(client->fd, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    (void)sent; /* a courtesy */
    pel_http_answer_finish(&answer);
}
