#include "net/http_share.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "bounds.h"
#include "net/listener.h"

/* Newcomers have so long, and there are so many times a source's share. */
#define NEW_NS (500 * INT64_C(1000000))
#define NEWCOMERS (PEL_BOUND_HTTP_NEWCOMERS / PEL_BOUND_HTTP_PER_LOOPBACK)

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

struct pel_who pel_http_first_who(const struct pel_http_server *server)
{
    return (struct pel_who){ server->context.token ? PEL_RANK_NOBODY
                                                   : PEL_RANK_INSTRUCT,
                             0 };
}

/* --- connections ---------------------------------------------------------- */

/* Nothing is lost with it but an answer that anybody may ask for again. */
static bool may_go(const struct client *each)
{
    return each->phase == PHASE_HEADERS || each->phase == PHASE_BODY ||
           (each->phase == PHASE_ANSWER && each->open);
}

/* The client of the lowest rank, among those with a place, that has been idle
 * or in the middle of a head or a body for longest: clients that send whole
 * requests are not crowded out by those that do not. Ranks up to `spared` are
 * spared. */
static struct client *find_victim(const struct pel_http_server *server,
                                  bool reserve,
                                  const struct pel_http_source *source,
                                  int spared)
{
    struct client *found = NULL;
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *each = g_ptr_array_index(server->clients, i);
        bool better = !found || each->who.rank > found->who.rank ||
                      (each->who.rank == found->who.rank &&
                       each->since_ns < found->since_ns);
        if (each->placed && may_go(each) && better &&
            each->reserve == reserve && (int)each->who.rank > spared &&
            (!source || same_source(&each->source, source))) {
            found = each;
        }
    }
    return found;
}

/* Those whose first head has not been read, or was refused. A
 * source has as many as its share, and four times as many while they have not
 * had time to say what they want; then the oldest makes room. */
void pel_http_share_open(struct pel_http_server *server,
                         const struct pel_http_source *source)
{
    struct client *oldest = NULL;
    unsigned count = 0, share = share_of(server, source);
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *each = g_ptr_array_index(server->clients, i);
        if (!each->placed && each->phase != PHASE_CLOSED &&
            same_source(&each->source, source)) {
            count++;
            oldest =
                !oldest || each->since_ns < oldest->since_ns ? each : oldest;
        }
    }
    bool late = oldest && pel_now_ns() - oldest->since_ns > NEW_NS;
    if (oldest && count >= (late ? share : NEWCOMERS * share)) {
        server->evicted++;
        pel_http_shut(oldest);
    }
}

bool pel_http_share_starved(struct pel_http_server *server)
{
    struct client *found = NULL;
    for (guint i = 0; i < server->clients->len; i++) {
        struct client *each = g_ptr_array_index(server->clients, i);
        bool spare = may_go(each) || (each->phase != PHASE_CLOSED &&
                                      each->who.rank >= PEL_RANK_WATCH);
        bool better = !found || may_go(each) > may_go(found) ||
                      (may_go(each) == may_go(found) &&
                       (each->who.rank > found->who.rank ||
                        (each->who.rank == found->who.rank &&
                         each->since_ns < found->since_ns)));
        found = spare && better ? each : found;
    }
    if (found) {
        server->evicted++;
        pel_http_shut(found);
    }
    return found != NULL;
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

/* Where places are counted: of one source, or of all. */
struct scope {
    bool of_source, streams;
    unsigned places;
};

static bool is_busy(const struct client *each, const struct scope *in)
{
    return each->phase == PHASE_STREAM ||
           (!in->streams &&
            (each->phase == PHASE_BODY || each->phase == PHASE_ANSWER));
}

/* Counts all clients but this one. */
static struct pel_taken count_busy(const struct client *client,
                                   const struct scope *in)
{
    struct pel_taken taken = { { 0 }, 0 };
    const GPtrArray *clients = client->server->clients;
    for (guint i = 0; i < clients->len; i++) {
        const struct client *each = g_ptr_array_index(clients, i);
        if (each != client && each->placed && is_busy(each, in) &&
            (!in->of_source || same_source(&each->source, &client->source))) {
            pel_taken_add(&taken, &client->who, &each->who, 1);
        }
    }
    /* A class behind one address has one token. */
    if (in->of_source && !client->source.loopback) {
        taken.of_token = 0;
    }
    return taken;
}

/* Ends the oldest of the lowest rank below the client's; `open`: or of any
 * rank, but what it asks for is public. False: there is none. */
static bool make_room(const struct client *client, const struct scope *in,
                      bool open)
{
    struct client *found = NULL;
    const GPtrArray *clients = client->server->clients;
    for (guint i = 0; i < clients->len; i++) {
        struct client *each = g_ptr_array_index(clients, i);
        bool better = !found || each->who.rank > found->who.rank ||
                      (each->who.rank == found->who.rank &&
                       each->since_ns < found->since_ns);
        bool lower = open ? each->open : each->who.rank > client->who.rank;
        if (each != client && each->placed && is_busy(each, in) && lower &&
            better &&
            (!in->of_source || same_source(&each->source, &client->source))) {
            found = each;
        }
    }
    if (found) {
        client->server->evicted++;
        pel_http_shut(found);
    }
    return found != NULL;
}

static bool refuse_many(struct client *client, struct pel_http_answer *answer,
                        const char *what, const char *whose, uint64_t most)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_BUSY,
                  "%s %s are taken, %u: end one, or try again later", what,
                  whose, (unsigned)most);
    client->server->refused++;
    pel_http_answer_finish(answer);
    *answer = (struct pel_http_answer){ .kind = PEL_HTTP_WHOLE };
    pel_http_problem(answer, 429, &fault);
    answer->retry_after_s = 1;
    answer->close = true;
    return false;
}

/* Whether the client's share of these places has one more. */
static bool has_share(struct client *client, const struct scope *in,
                      const char *what, struct pel_http_answer *answer)
{
    const struct pel_who *who = &client->who;
    for (;;) {
        struct pel_taken taken = count_busy(client, in);
        enum pel_share_answer share = pel_share_ask(in->places, &taken, who, 1);
        if (!share) {
            return true;
        }
        if (who->rank >= PEL_RANK_WATCH || !make_room(client, in, false)) {
            bool all =
                share != PEL_SHARE_TOKEN_FULL && who->rank == PEL_RANK_INSTRUCT;
            return refuse_many(client, answer, what,
                               all ? in->of_source ? "of this address"
                                                   : "of all addresses"
                                   : pel_share_words(share, who->rank),
                               share == PEL_SHARE_TOKEN_FULL
                                   ? pel_share_of_token(in->places, who->rank)
                                   : pel_share_of_rank(in->places, who->rank));
        }
    }
}

/* Counts the other clients that have a place outside the reserve. */
static unsigned count_placed(const struct client *client, bool of_source)
{
    unsigned count = 0;
    const GPtrArray *clients = client->server->clients;
    for (guint i = 0; i < clients->len; i++) {
        const struct client *each = g_ptr_array_index(clients, i);
        count += each != client && each->placed && !each->reserve &&
                 each->phase != PHASE_CLOSED &&
                 (!of_source || same_source(&each->source, &client->source));
    }
    return count;
}

static unsigned count_reserve(const struct pel_http_server *server)
{
    unsigned count = 0;
    for (guint i = 0; i < server->clients->len; i++) {
        const struct client *each = g_ptr_array_index(server->clients, i);
        count += each->placed && each->reserve && each->phase != PHASE_CLOSED;
    }
    return count;
}

static bool end_victim(struct pel_http_server *server, struct client *victim)
{
    if (victim) {
        server->evicted++;
        pel_http_shut(victim);
    }
    return victim != NULL;
}

/* A place for a connection whose first head has been read: instead of one that
 * is idle, or one of the last ones. */
static bool find_place(struct client *client, struct pel_http_answer *answer)
{
    static struct pel_log_limit limit;
    struct pel_http_server *server = client->server;
    unsigned share = share_of(server, &client->source);
    unsigned same = count_placed(client, true);
    unsigned open = count_placed(client, false);
    bool many = !client->source.proxy && same >= share;
    bool above = server->context.token && client->who.rank < PEL_RANK_WATCH;
    const struct scope in = { many, false,
                              many ? share : server->limits.http_connections };
    client->reserve = false;
    if ((!many && open < server->limits.http_connections) ||
        /* idle ones of one's own rank, not of those above */
        end_victim(server,
                   find_victim(server, false, many ? &client->source : NULL,
                               (int)client->who.rank - 1)) ||
        (above && make_room(client, &in, false))) {
        return true;
    }
    if (above || client->open) {
        client->reserve = true;
        if (count_reserve(server) < PEL_HTTP_RESERVE ||
            end_victim(server, find_victim(server, true, NULL, -1))) {
            return true;
        }
        client->reserve = false;
    }
    pel_log_limited(&limit, PEL_LOG_WARNING, "NET-020",
                    "HTTP client refused: %u connections, %u of them from "
                    "its source",
                    open, same);
    refuse_many(client, answer, "the connections",
                many ? "of this address" : "of all addresses", in.places);
    answer->status = many ? 429 : 503;
    return false;
}

bool pel_http_share_admit(struct client *client,
                          const struct pel_http_request *request,
                          struct pel_http_answer *answer)
{
    struct in6_addr address;
    const struct pel_http_server *server = client->server;
    if (client->source.proxy && read_forwarded(request, &address)) {
        client->source.address = address;
        client->source.loopback = is_loopback(&address);
    }
    if (!client->placed && !find_place(client, answer)) {
        return false;
    }
    client->placed = true;
    const struct scope source = { true, false,
                                  share_of(server, &client->source) };
    const struct scope all = { false, false, server->limits.http_connections };
    if (client->open) {
        struct pel_taken taken = count_busy(client, &all);
        if (pel_share_ask(all.places, &taken, &client->who, 1)) {
            make_room(client, &all, true);
        }
        return true;
    }
    bool tokens = server->context.token != NULL;
    bool above = tokens && client->who.rank < PEL_RANK_WATCH;
    if (client->reserve && above) {
        return true;
    }
    if (client->reserve) { /* it had asked for what is public */
        client->placed = false;
        return refuse_many(client, answer, "the connections", "of this address",
                           source.places);
    }
    client->placed = !(tokens || client->source.proxy) ||
                     (has_share(client, &source, "the connections", answer) &&
                      has_share(client, &all, "the connections", answer));
    return client->placed;
}

bool pel_http_share_stream(struct client *client,
                           struct pel_http_answer *answer)
{
    unsigned share = share_of(client->server, &client->source);
    unsigned total = client->server->limits.http_connections;
    const struct scope source = { true, true,
                                  client->source.loopback ? share - share / 8
                                                          : share };
    const struct scope all = { false, true, total - total / 8 };
    if (client->reserve) {
        return refuse_many(client, answer, "the live views", "of this address",
                           source.places);
    }
    return has_share(client, &source, "the live views", answer) &&
           has_share(client, &all, "the live views", answer);
}
