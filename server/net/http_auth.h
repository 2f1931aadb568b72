/* Authentication of HTTP requests by the token, where there is one. Any
 * thread. */
#pragma once

#include <stdbool.h>

#include "net/http_route.h"

/* The asker by the request's token, { 0 } where none is asked for: in
 * Authorization (pel_token_authorizes), or as subprotocol `bearer.TOKEN` of a
 * WebSocket. */
struct pel_who pel_http_who(const struct pel_http_context *context,
                            const struct pel_http_request *request);

/* The role. */
enum pel_role pel_http_role(const struct pel_http_context *context,
                            const struct pel_http_request *request);

/* Whether it has any. */
bool pel_http_is_authorized(const struct pel_http_context *context,
                            const struct pel_http_request *request);

/* Answers 401. */
void pel_http_refuse_stranger(const struct pel_http_request *request,
                              struct pel_http_answer *answer);
