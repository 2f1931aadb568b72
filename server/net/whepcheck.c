/* Chooses the candidates of an offer that are sent ICE checks. */
#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>

#include <glib.h>

#include "net/whepoffer.h"

/* IPv4 as mapped; false: it is no numeric address. */
static bool address_of(const char *text, struct sockaddr_in6 *out)
{
    struct in_addr four;
    *out = (struct sockaddr_in6){ .sin6_family = AF_INET6 };
    if (inet_pton(AF_INET, text, &four) == 1) {
        memset(&out->sin6_addr.s6_addr[10], 0xff, 2);
        memcpy(&out->sin6_addr.s6_addr[12], &four, sizeof four);
        return true;
    }
    return inet_pton(AF_INET6, text, &out->sin6_addr) == 1;
}

static bool is_same(const struct sockaddr_in6 *a, const struct sockaddr_in6 *b)
{
    return memcmp(&a->sin6_addr, &b->sin6_addr, sizeof a->sin6_addr) == 0;
}

static bool text_of(const struct sockaddr *a, char out[INET6_ADDRSTRLEN])
{
    const void *at = !a ? NULL
                     : a->sa_family == AF_INET
                         ? (void *)&((struct sockaddr_in *)a)->sin_addr
                     : a->sa_family == AF_INET6
                         ? (void *)&((struct sockaddr_in6 *)a)->sin6_addr
                         : NULL;
    return at && inet_ntop(a->sa_family, at, out, INET6_ADDRSTRLEN);
}

static bool is_of_this_machine(const struct sockaddr_in6 *a)
{
    struct pel_allow loopback;
    struct ifaddrs *all = NULL;
    bool found = pel_allow_parse(NULL, &loopback, NULL) == PEL_OK &&
                 pel_allow_has(&loopback, (const struct sockaddr *)a);
    if (found || getifaddrs(&all) != 0) {
        return found;
    }
    for (struct ifaddrs *i = all; i && !found; i = i->ifa_next) {
        char text[INET6_ADDRSTRLEN];
        struct sockaddr_in6 own;
        found = text_of(i->ifa_addr, text) && address_of(text, &own) &&
                is_same(&own, a);
    }
    freeifaddrs(all);
    return found;
}

void pel_whep_offer_keep(struct pel_whep_offer *offer, const char *asker,
                         const struct pel_allow *peers)
{
    struct pel_whep_transport *t = &offer->transport;
    struct sockaddr_in6 own, a;
    size_t kept = 0;
    bool known = asker && address_of(asker, &own), own_is_there = false;
    for (size_t i = 0; i < t->candidate_count && kept < PEL_WHEP_TARGETS; i++) {
        char text[48];
        if (sscanf(t->candidates[i], "%*s %*u %*s %*u %47s", text) != 1 ||
            !address_of(text, &a)) {
            continue;
        }
        bool is_own =
            known ? is_same(&a, &own) : !asker && is_of_this_machine(&a);
        if (is_own || pel_allow_has(peers, (const struct sockaddr *)&a)) {
            own_is_there = own_is_there || is_own;
            memmove(t->candidates[kept++], t->candidates[i],
                    sizeof t->candidates[0]);
        }
    }
    if (known && !own_is_there) {
        kept = MIN(kept, PEL_WHEP_TARGETS - 1);
        snprintf(t->candidates[kept++], sizeof t->candidates[0],
                 "0 1 UDP 1 %s 9 typ host", asker);
    }
    t->candidate_count = kept;
}
