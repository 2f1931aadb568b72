#include "net/http_share.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>

#include "base/log.h"
#include "net/listener.h"

static struct in6_addr address_of(const struct sockaddr *address)
{
    struct in6_addr out = in6addr_any;
    if (address->sa_family == AF_INET6) {
        out = ((const struct sockaddr_in6 *)(const void *)address)->sin6_addr;
    } else if (address->sa_family == AF_INET) {
        out.s6_addr[10] = out.s6_addr[11] = 0xff;
        memcpy(&out.s6_addr[12],
               &((const struct sockaddr_in *)(const void *)address)->sin_addr,
               4);
    }
    return out;
}

/* A numeric address; false: it is none. */
static bool read_address(const char *text, struct in6_addr *out)
{
    struct sockaddr_in four = { .sin_family = AF_INET };
    if (inet_pton(AF_INET, text, &four.sin_addr) == 1) {
        *out = address_of((const struct sockaddr *)&four);
        return true;
    }
    return inet_pton(AF_INET6, text, out) == 1;
}

static bool is_loopback(const struct in6_addr *address)
{
    struct sockaddr_in6 six = { .sin6_family = AF_INET6,
                                .sin6_addr = *address };
    return pel_address_is_loopback((const struct sockaddr *)&six);
}

struct pel_http_source pel_http_source_of(const struct pel_http_server *server,
                                          const struct sockaddr *address)
{
    struct pel_http_source source = { .address = address_of(address) };
    source.loopback = pel_address_is_loopback(address);
    const char *const *proxy = server->context.proxies;
    for (; proxy && *proxy; proxy++) {
        struct in6_addr its;
        source.proxy =
            source.proxy || (read_address(*proxy, &its) &&
                             IN6_ARE_ADDR_EQUAL(&its, &source.address));
    }
    return source;
}

static bool same_source(const struct pel_http_source *a,
                        const struct pel_http_source *b)
{
    return a->loopback
               ? b->loopback
               : !b->loopback && IN6_ARE_ADDR_EQUAL(&a->address, &b->address);
}

static unsigned share_of(const struct pel_http_server *server,
                         const struct pel_http_source *source)
{
    return source->loopback ? server->limits.http_per_loopback
                            : server->limits.http_per_source;
}

/* --- connections ---------------------------------------------------------- */

/* The one that has been in the middle of a head or a body for longest: whoever
 * sends whole requests is not crowded out by those who do not. */
static struct client *find_victim(const struct pel_http_server *server,
                                  bool reserve,
                                  const struct pel_http_source *source)
{
    struct client *oldest = NULL;
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *each = g_ptr_array_index(server->clients, i);
        bool half = each->phase == PHASE_HEADERS || each->phase == PHASE_BODY;
        if (half && each->reserve == reserve &&
            (!source || same_source(&each->source, source)) &&
            (!oldest || each->since_ns < oldest->since_ns)) {
            oldest = each;
        }
    }
    return oldest;
}

static void refuse_client(int fd, int status, const char *words)
{
    char text[256];
    int n = snprintf(text, sizeof text,
                     "HTTP/1.1 %d %s\r\nRetry-After: 1\r\n"
                     "Connection: close\r\nContent-Length: 0\r\n\r\n",
                     status, words);
    ssize_t sent = send(fd, text, (size_t)n, MSG_NOSIGNAL | MSG_DONTWAIT);
    (void)sent; /* a courtesy */
}

bool pel_http_share_open(struct pel_http_server *server, int fd,
                         const struct pel_http_source *source, bool *reserve)
{
    static struct pel_log_limit limit;
    unsigned open = 0, same = 0, reserved = 0;
    for (guint i = 0; i < server->clients->len; i++) {
        const struct client *each = g_ptr_array_index(server->clients, i);
        bool counts = each->phase != PHASE_CLOSED;
        reserved += counts && each->reserve;
        open += counts && !each->reserve;
        same += counts && !each->reserve && same_source(&each->source, source);
    }
    bool many = !source->proxy && same >= share_of(server, source);
    *reserve = false;
    if (!many && open < server->limits.http_connections) {
        return true;
    }
    struct client *victim = find_victim(server, false, many ? source : NULL);
    if (!victim) {
        *reserve = true;
        if (reserved < PEL_HTTP_RESERVE) {
            return true;
        }
        victim = find_victim(server, true, NULL);
    }
    if (victim) {
        server->evicted++;
        pel_http_shut(victim);
        return true;
    }
    server->refused++;
    pel_log_limited(&limit, PEL_LOG_WARNING, "NET-020",
                    "HTTP client refused: %u connections, %u of them from "
                    "its source",
                    open, same);
    refuse_client(fd, many ? 429 : 503,
                  many ? "Too Many Requests" : "Service Unavailable");
    return false;
}

/* --- requests ------------------------------------------------------------- */

/* The client that a proxy speaks for: the last address it gives is what it has
 * seen itself. */
static bool read_forwarded(const struct pel_http_request *request,
                           struct in6_addr *out)
{
    size_t count = 0;
    const char *value =
        pel_http_find_header(request, "X-Forwarded-For", &count);
    if (count == 0) {
        value = pel_http_find_header(request, "X-Real-IP", &count);
    }
    if (count != 1) {
        return false;
    }
    const char *last = strrchr(value, ',');
    last = last ? last + 1 : value;
    last += strspn(last, " \t");
    char text[INET6_ADDRSTRLEN];
    size_t length = strcspn(last, " \t");
    if (length >= sizeof text) {
        return false;
    }
    memcpy(text, last, length);
    text[length] = '\0';
    return read_address(text, out);
}

/* Others of the same source that are in the middle of something. */
static unsigned count_busy(const struct client *client, bool streams)
{
    unsigned count = 0;
    const GPtrArray *clients = client->server->clients;
    for (guint i = 0; i < clients->len; i++) {
        const struct client *each = g_ptr_array_index(clients, i);
        bool busy = each->phase == PHASE_STREAM ||
                    (!streams && (each->phase == PHASE_BODY ||
                                  each->phase == PHASE_ANSWER));
        count += busy && each != client &&
                 same_source(&each->source, &client->source);
    }
    return count;
}

static bool refuse_many(struct client *client, struct pel_http_answer *answer,
                        const char *what, unsigned most)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_BUSY,
                  "%s of this address are taken, %u: end one, or try again "
                  "later",
                  what, most);
    client->server->refused++;
    pel_http_problem(answer, 429, &fault);
    answer->retry_after_s = 1;
    answer->close = true;
    return false;
}

bool pel_http_share_admit(struct client *client,
                          const struct pel_http_request *request, bool open,
                          bool holder, struct pel_http_answer *answer)
{
    struct in6_addr address;
    if (client->source.proxy && read_forwarded(request, &address)) {
        client->source.address = address;
        client->source.loopback = is_loopback(&address);
    }
    if (open || (client->reserve && holder)) {
        return true;
    }
    unsigned most = share_of(client->server, &client->source);
    if (client->reserve ||
        (client->source.proxy && count_busy(client, false) >= most)) {
        return refuse_many(client, answer, "the connections", most);
    }
    return true;
}

bool pel_http_share_stream(struct client *client,
                           struct pel_http_answer *answer)
{
    unsigned share = share_of(client->server, &client->source);
    unsigned most = client->source.loopback ? share - share / 8 : share;
    unsigned all = 0;
    const GPtrArray *clients = client->server->clients;
    for (guint i = 0; i < clients->len; i++) {
        const struct client *each = g_ptr_array_index(clients, i);
        all += each->phase == PHASE_STREAM;
    }
    unsigned total = client->server->limits.http_connections;
    if (client->reserve || all >= total - total / 8 ||
        count_busy(client, true) >= most) {
        pel_http_answer_finish(answer);
        *answer = (struct pel_http_answer){ .kind = PEL_HTTP_WHOLE };
        return refuse_many(client, answer, "the live views", most);
    }
    return true;
}
