#include "net/http_auth.h"

#include <string.h>

/* A page cannot give a WebSocket headers, only names of subprotocols. */
enum pel_role pel_http_role(const struct pel_http_context *context,
                            const struct pel_http_request *request)
{
    enum pel_role role = PEL_ROLE_NONE;
    if (!context->token) {
        return PEL_ROLE_INSTRUCT;
    }
    size_t count = 0;
    const char *given = pel_http_find_header(request, "Authorization", &count);
    if (count == 1) {
        return pel_token_authorizes(context->token, given);
    }
    const char *list =
        pel_http_find_header(request, "Sec-WebSocket-Protocol", NULL);
    while (count == 0 && list && *list && role == PEL_ROLE_NONE) {
        list += strspn(list, " \t,");
        size_t length = strcspn(list, " \t,");
        if (length > 7 && strncmp(list, "bearer.", 7) == 0) {
            role = pel_token_role(context->token, list + 7, length - 7);
        }
        list += length;
    }
    return role;
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
