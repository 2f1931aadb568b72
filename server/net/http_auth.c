#include "net/http_auth.h"

#include <string.h>

/* A page cannot give a WebSocket headers, only names of subprotocols. */
struct pel_who pel_http_who(const struct pel_http_context *context,
                            const struct pel_http_request *request)
{
    struct pel_who who = { PEL_RANK_NOBODY, 0 };
    if (!context->token) {
        return (struct pel_who){ PEL_RANK_INSTRUCT, 0 };
    }
    size_t count = 0;
    const char *given = pel_http_find_header(request, "Authorization", &count);
    if (count == 1) {
        return pel_token_authorizes(context->token, given);
    }
    const char *list =
        pel_http_find_header(request, "Sec-WebSocket-Protocol", NULL);
    while (count == 0 && list && *list && who.rank == PEL_RANK_NOBODY) {
        list += strspn(list, " \t,");
        size_t length = strcspn(list, " \t,");
        if (length > 7 && strncmp(list, "bearer.", 7) == 0) {
            who = pel_token_who(context->token, list + 7, length - 7);
        }
        list += length;
    }
    return who;
}

enum pel_role pel_http_role(const struct pel_http_context *context,
                            const struct pel_http_request *request)
{
    return pel_role_of_rank(pel_http_who(context, request).rank);
}

bool pel_http_is_authorized(const struct pel_http_context *context,
                            const struct pel_http_request *request)
{
    return pel_http_role(context, request) != PEL_ROLE_NONE;
}

void pel_http_refuse_stranger(const struct pel_http_request *request,
                              struct pel_http_answer *answer)
{
    struct pel_fault fault;
    bool gave = pel_http_find_header(request, "Authorization", NULL) ||
                pel_http_find_header(request, "Sec-WebSocket-Protocol", NULL);
    /* A browser that is asked for Basic by a page's own request opens a window
     * of its own; the page asks by itself. */
    const char *mode = pel_http_find_header(request, "Sec-Fetch-Mode", NULL);
    pel_fault_set(&fault, PEL_ERR_UNAUTHORIZED,
                  gave ? "the token is wrong"
                       : "this server asks for a token: send "
                         "`Authorization: Bearer TOKEN`");
    pel_http_problem(answer, 401, &fault);
    answer->close = true;
    answer->challenge = true;
    answer->challenge_basic = !mode || strcmp(mode, "navigate") == 0;
}
