/* Offers of WebRTC peers, answered when terms are named; and their ends. */
#include "net/http_client.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <string.h>

static void on_answer(void *user, enum pel_err err,
                      const struct pel_fault *fault, const char *sdp,
                      const char *id)
{
    struct client *client = pel_http_wait_end(user);
    if (!client) {
        return;
    }
    if (err != PEL_OK) {
        pel_http_send_fault(client, 0, fault);
    } else {
        struct pel_http_answer out = { .status = 201, .type = PEL_WHEP_TYPE };
        out.owned = g_strdup(sdp);
        out.body = out.owned;
        out.size = strlen(sdp);
        snprintf(out.location, sizeof out.location, "%s%s", PEL_WHEP_PLACE, id);
        pel_http_send(client, &out);
    }
    pel_http_resume(client);
}

static enum MHD_Result end(struct client *client,
                           struct pel_http_answer *answer)
{
    struct pel_fault fault;
    struct pel_http_answer out = { .status = 204 };
    enum pel_err err =
        pel_whep_end(client->server->whep, answer->file, &client->who, &fault);
    pel_http_answer_finish(answer);
    return err ? pel_http_send_fault(client, 0, &fault)
               : pel_http_send(client, &out);
}

/* NULL: this machine. */
static const char *asker(const struct client *client,
                         char out[INET6_ADDRSTRLEN])
{
    const struct in6_addr *a = &client->source.address;
    if (client->source.loopback) {
        return NULL;
    }
    return IN6_IS_ADDR_V4MAPPED(a)
               ? inet_ntop(AF_INET, &a->s6_addr[12], out, INET6_ADDRSTRLEN)
               : inet_ntop(AF_INET6, a, out, INET6_ADDRSTRLEN);
}

enum MHD_Result pel_http_send_whep(struct client *client,
                                   struct pel_http_answer *answer)
{
    struct pel_fault fault;
    char from[INET6_ADDRSTRLEN];
    if (answer->kind == PEL_HTTP_WHEP_END) {
        return end(client, answer);
    }
    const struct pel_whep_wish wish = {
        .view = answer->view,
        .profile = answer->profile,
        .offer = client->body ? client->body->str : "",
        .offer_size = client->body ? client->body->len : 0,
        .from = asker(client, from),
    };
    struct waiter *waiter = pel_http_wait_begin(client);
    enum pel_err err =
        pel_whep_ask(client->server->whep, &wish, on_answer, waiter, &fault);
    pel_http_answer_finish(answer);
    if (err != PEL_OK) {
        pel_http_wait_end(waiter);
        return pel_http_send_fault(client, 0, &fault);
    }
    pel_http_suspend(client);
    return MHD_YES;
}
