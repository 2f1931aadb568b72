/* Options whose value is a list: one reader for all of them, and what their
 * elements may be. */
#include <arpa/inet.h>
#include <glib.h>
#include <stdlib.h>
#include <string.h>

#include "base/hostport.h"
#include "bridges/endpoint.h"
#include "options.h"

#define BLANKS " \t"

enum pel_err pel_options_list(const struct pel_option *option,
                              const char *value, char out[PEL_OPTION_TEXT],
                              char *why, size_t why_size)
{
    size_t used = 0;
    *out = 0;
    if (value[strspn(value, BLANKS)] == 0) {
        return PEL_OK;
    }
    g_auto(GStrv) words = g_strsplit(value, ",", -1);
    for (size_t i = 0; words[i]; i++) {
        const char *word = g_strstrip(words[i]);
        const char *wrong = *word == 0 ? "nothing stands between two commas"
                            : option->element ? option->element(word)
                                              : NULL;
        if (wrong) {
            g_snprintf(why, why_size, "holds '%.60s': %s", word, wrong);
            return PEL_ERR_INVALID;
        }
        used += (size_t)g_snprintf(out + used, PEL_OPTION_TEXT - used, "%s%s",
                                   i > 0 ? "," : "", word);
    }
    return PEL_OK; /* no longer than the value, which fits */
}

char **pel_options_split(const char *list)
{
    return *list ? g_strsplit(list, ",", -1) : NULL;
}

/* --- elements ------------------------------------------------------------- */

static bool is_port(const char *text)
{
    guint64 port;
    return g_ascii_string_to_unsigned(text, 10, 1, 65535, &port, NULL);
}

static bool is_host(const char *text)
{
    char host[PEL_HOST_SIZE];
    uint16_t port;
    g_autofree char *whole = g_strconcat(text, ":1", NULL);
    return pel_hostport_split(whole, host, &port) != PEL_HOST_NONE;
}

const char *pel_options_host(const char *text)
{
    uint8_t binary[16];
    return strstr(text, "://")
               ? "a Host has no scheme and no path; write ship.example"
           : inet_pton(AF_INET6, text, binary) == 1 || *text == '[' ||
                   inet_pton(AF_INET, text, binary) == 1
               ? "numeric addresses are allowed as they are; names are wanted"
           : strchr(text, ':') ? "a port is not compared; write the name alone"
           : is_host(text)     ? NULL
                               : "no name of a host; write ship.example";
}

/* As browsers write it: a pair of scheme and host never has more. */
const char *pel_options_origin(const char *text)
{
    const char *scheme_end = strstr(text, "://");
    size_t scheme = scheme_end ? (size_t)(scheme_end - text) : 0;
    if (scheme == 0 || !g_ascii_isalpha(*text) ||
        strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                     "0123456789+.-") < scheme) {
        return "no origin; write scheme://host[:port], as https://desk.example";
    }
    const char *host = scheme_end + 3;
    if (strpbrk(host, "/?#")) {
        return "an origin has no path; end it after the host or its port";
    }
    if (strchr(host, '@')) {
        return "an origin has no user";
    }
    const char *bracket = strrchr(host, ']');
    const char *colon = strrchr(bracket ? bracket : host, ':');
    if (colon && !is_port(colon + 1)) {
        return "the port is no number within 1 .. 65535";
    }
    if (colon && ((g_ascii_strncasecmp(text, "http:", 5) == 0 &&
                   atoi(colon + 1) == 80) ||
                  (g_ascii_strncasecmp(text, "https:", 6) == 0 &&
                   atoi(colon + 1) == 443))) {
        return "browsers leave out the port that the scheme has anyway; leave "
               "it out";
    }
    g_autofree char *name =
        g_strndup(host, colon ? (size_t)(colon - host) : strlen(host));
    return is_host(name) ? NULL : "no host after ://";
}

const char *pel_options_numeric(const char *text)
{
    uint8_t binary[16];
    return inet_pton(AF_INET, text, binary) == 1 ||
                   inet_pton(AF_INET6, text, binary) == 1
               ? NULL
               : "no numeric address; write 127.0.0.1 or ::1";
}

const char *pel_options_network(const char *text)
{
    struct pel_allow allow;
    return pel_allow_parse(text, &allow, NULL) == PEL_OK
               ? NULL
               : "no address or network; write 10.0.0.7 or 192.168.1.0/24";
}

const char *pel_options_relay(const char *text)
{
    const char *const kinds[] = { "stun://", "turn://", "turns://" };
    for (size_t i = 0; i < G_N_ELEMENTS(kinds); i++) {
        if (g_str_has_prefix(text, kinds[i]) && text[strlen(kinds[i])] &&
            !strpbrk(text, BLANKS)) {
            return NULL;
        }
    }
    return "neither stun://HOST:PORT nor turn://USER:PASSWORD@HOST:PORT";
}

const char *pel_options_device(const char *text)
{
    size_t length = strlen(text);
    bool number = length < 4 && strspn(text, "0123456789") == length;
    return number || strcmp(text, "auto") == 0 ||
                   strcmp(text, "software") == 0 || strcmp(text, "all") == 0
               ? NULL
               : "neither all, auto, software nor a number within 0 .. 999";
}

const char *pel_options_outlet(const char *text)
{
    const char *at = strchr(text, '@');
    char host[PEL_HOST_SIZE];
    uint16_t port;
    guint64 id;
    g_autofree char *entity =
        at ? g_strndup(text, (size_t)(at - text)) : g_strdup("0");
    return g_ascii_string_to_unsigned(entity, 10, 0, 65535, &id, NULL) &&
                   pel_hostport_split(at ? at + 1 : text, host, &port) !=
                       PEL_HOST_NONE &&
                   port > 0
               ? NULL
               : "not [ENTITY@]HOST:PORT, as 127.0.0.1:10111 or "
                 "7@chart.example:10110";
}
