#include "net/http_auth.h"

#include <string.h>

/* A page cannot give a WebSocket headers, only names of subprotocols. */
bool pel_http_is_authorized(const struct pel_http_context *context,
                            const struct pel_http_request *request)
{
    if (!context->token) {
        return true;
    }
    size_t count = 0;
    const char *given = pel_http_find_header(request, "Authorization", &count);
    if (count == 1) {
        return pel_token_authorizes(context->token, given);
    }
    const char *list =
        pel_http_find_header(request, "Sec-WebSocket-Protocol", NULL);
    while (count == 0 && list && *list) {
        list += strspn(list, " \t,");
        size_t length = strcspn(list, " \t,");
        if (length > 7 && strncmp(list, "bearer.", 7) == 0 &&
            pel_token_is(context->token, list + 7, length - 7)) {
            return true;
        }
        list += length;
    }
    return false;
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
