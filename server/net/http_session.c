/* /v1/session: what the token of a request may do, by proto/roles.def. */
#include <string.h>

#include <glib.h>

#include "net/http_auth.h"
#include "net/http_view.h"

static const struct {
    const char *method, *pattern, *flags;
} routes[] = {
#define PEL_ROUTE(method, pattern, flags, ...) { method, pattern, #flags },
#include "proto/routes.def"
};

/* Of a list of words that need no escape. */
static void add(GString *out, const char *before, const char *text)
{
    const char *comma = g_str_has_suffix(out->str, "[") ? "" : ",";
    g_string_append_printf(out, "%s\"%s%s\"", comma, before, text);
}

void pel_http_get_session(const struct pel_http_call *call)
{
    enum pel_role role = pel_http_role(call->context, call->request);
    GString *out = g_string_new(NULL);
    const char *field;
    g_string_append_printf(out, "{\"role\":\"%s\",\"routes\":[",
                           pel_role_name(role));
    for (size_t i = 0; i < G_N_ELEMENTS(routes); i++) {
        if (!strstr(routes[i].flags, "ROUTE_OPEN") &&
            role >= pel_role_of_route(routes[i].method, routes[i].pattern)) {
            g_autofree char *method = g_strconcat(routes[i].method, " ", NULL);
            add(out, method, routes[i].pattern);
        }
    }
    g_string_append(out, "],\"fields\":[");
    for (size_t i = 0; (field = pel_role_field(role, i)); i++) {
        add(out, "", field);
    }
    g_string_append(out, "]}");
    pel_http_json(call->answer, 200, g_string_free(out, FALSE));
}
