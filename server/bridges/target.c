#include "bridges/target.h"

#include <gio/gio.h>
#include <glib.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "base/hostport.h"
#include "base/log.h"
#include "base/trial.h"
#include "base/watch.h"

#define FIRST_RETRY_MS 1000u
#define LAST_RETRY_MS 30000u
#define FRESH_MS 60000u
#define FAILED_MS 5000u

struct pel_target {
    char *option, *text;
    char host[PEL_HOST_SIZE];
    uint16_t port;
    int family;
    bool named; /* else a number, which stays */
    bool told;  /* that it is not resolved */
    struct sockaddr_storage address;
    socklen_t size;       /* 0: not resolved */
    GCancellable *lookup; /* NULL: none under way */
    guint timer;
    unsigned retry_ms;
    int64_t looked_ns;
    struct pel_metrics *metrics;
};

/* --- looking up ----------------------------------------------------------- */

static void look_in(struct pel_target *t, unsigned ms);

static const char *lacks(const struct pel_target *t)
{
    return t->family == AF_INET    ? "it has no IPv4 address"
           : t->family == AF_INET6 ? "it has no IPv6 address"
                                   : "it has no address";
}

static void unresolved(struct pel_target *t, const char *why)
{
    if (!t->told) {
        pel_warn("TGT-001",
                 "--%s: %s is not resolved: %s; %s, and the look-up is "
                 "repeated, in the end every 30 s",
                 t->option, t->host, why,
                 t->size > 0 ? "its last address stays in use"
                             : "nothing is sent there meanwhile");
    }
    t->told = true;
    t->retry_ms =
        t->retry_ms == 0 ? FIRST_RETRY_MS : MIN(2 * t->retry_ms, LAST_RETRY_MS);
    look_in(t, t->retry_ms);
}

/* The first of the family; the one that is in use, if it still is among them:
 * servers of names shuffle. */
static void resolved(struct pel_target *t, GList *list)
{
    struct sockaddr_storage before = t->address;
    socklen_t size = t->size;
    bool found = false;
    for (int turn = 0; turn < 2 && !found; turn++) {
        for (GList *each = list; each && !found; each = each->next) {
            g_autofree char *number = g_inet_address_to_string(each->data);
            found =
                pel_hostport_address(number, t->port, t->family, &t->address,
                                     &t->size) &&
                (turn == 1 || memcmp(&before, &t->address, sizeof before) == 0);
            if (found && (size == 0 || t->told ||
                          memcmp(&before, &t->address, sizeof before) != 0)) {
                pel_info("TGT-002", "--%s: %s is at %s, port %u", t->option,
                         t->host, number, t->port);
            }
        }
    }
    if (!found) {
        t->address = before;
        t->size = size;
        unresolved(t, lacks(t));
        return;
    }
    t->told = false;
    t->retry_ms = 0;
    look_in(t, FRESH_MS);
}

static void on_looked(GObject *source, GAsyncResult *result, gpointer user)
{
    PEL_WATCH("names");
    GError *error = NULL;
    GList *list =
        g_resolver_lookup_by_name_finish(G_RESOLVER(source), result, &error);
    if (g_error_matches(error, G_IO_ERROR, G_IO_ERROR_CANCELLED)) {
        g_clear_error(&error); /* whoever asked is gone */
        return;
    }
    struct pel_target *t = user;
    g_clear_object(&t->lookup);
    if (error) {
        unresolved(t, error->message);
        g_clear_error(&error);
    } else {
        resolved(t, list);
    }
    g_resolver_free_addresses(list);
}

static void look(struct pel_target *t)
{
    g_autoptr(GResolver) resolver = g_resolver_get_default();
    t->looked_ns = pel_now_ns();
    t->lookup = g_cancellable_new();
    g_resolver_lookup_by_name_async(resolver, t->host, t->lookup, on_looked, t);
}

static gboolean on_timer(gpointer user)
{
    PEL_WATCH("names");
    struct pel_target *t = user;
    t->timer = 0;
    look(t);
    return G_SOURCE_REMOVE;
}

static void look_in(struct pel_target *t, unsigned ms)
{
    if (t->timer) {
        g_source_remove(t->timer);
    }
    t->timer = g_timeout_add(ms, on_timer, t);
}

void pel_target_failed(struct pel_target *t)
{
    if (t->named && !t->lookup && t->size > 0 &&
        pel_now_ns() - t->looked_ns > FAILED_MS * 1000000LL) {
        look_in(t, 0);
        t->looked_ns = pel_now_ns();
    }
}

/* --- life ----------------------------------------------------------------- */

static void collect(void *user, struct pel_metrics_page *page)
{
    const struct pel_target *t = user;
    char label[PEL_HOST_SIZE + 64];
    snprintf(label, sizeof label, "option=\"%s\",host=\"%s:%u\"", t->option,
             t->host, t->port);
    pel_metric(page, "pelagos_target_resolved", PEL_METRIC_GAUGE,
               "Whether the name of a host that is sent to has an address.",
               label, t->size > 0);
}

/* For --check: looks the name up once, as a start would. */
static void try_name(struct pel_target *t)
{
    g_autoptr(GResolver) resolver = g_resolver_get_default();
    GError *error = NULL;
    GList *list = g_resolver_lookup_by_name(resolver, t->host, NULL, &error);
    bool found = false;
    for (GList *each = list; each && !found; each = each->next) {
        g_autofree char *number = g_inet_address_to_string(each->data);
        found = pel_hostport_address(number, t->port, t->family, &t->address,
                                     &t->size);
    }
    if (!found) {
        pel_trial_note("--%s: %s is not resolved: %s; a daemon starts, and "
                       "looks it up again",
                       t->option, t->host, error ? error->message : lacks(t));
    }
    g_clear_error(&error);
    g_resolver_free_addresses(list);
}

enum pel_err pel_target_create(const struct pel_target_options *options,
                               struct pel_target **out, struct pel_fault *fault)
{
    struct pel_target *t = g_new0(struct pel_target, 1);
    *out = NULL;
    t->option = g_strdup(options->option);
    t->text = g_strdup(options->text);
    t->family = options->family;
    enum pel_host kind = pel_hostport_split(options->text, t->host, &t->port);
    if (kind == PEL_HOST_NONE || t->port == 0) {
        enum pel_err err = pel_fault_set(
            fault, PEL_ERR_INVALID,
            "--%s: '%.80s' is not HOST:PORT; write 127.0.0.1:10111, "
            "[::1]:10111 or chart.example:10111",
            options->option, options->text);
        pel_target_destroy(t);
        return err;
    }
    t->named = kind == PEL_HOST_NAME;
    if (!t->named && !pel_hostport_address(t->host, t->port, t->family,
                                           &t->address, &t->size)) {
        enum pel_err err = pel_fault_set(
            fault, PEL_ERR_INVALID,
            "--%s: '%.80s' and the address that it is sent from are of "
            "different kinds; write IPv4 for both, or IPv6",
            options->option, options->text);
        pel_target_destroy(t);
        return err;
    }
    if (t->named && pel_trial()) {
        try_name(t);
    } else if (t->named) {
        look(t);
    }
    if (t->named && options->metrics) {
        t->metrics = options->metrics;
        pel_metrics_add(t->metrics, collect, t);
    }
    *out = t;
    return PEL_OK;
}

void pel_target_destroy(struct pel_target *t)
{
    if (!t) {
        return;
    }
    if (t->lookup) {
        g_cancellable_cancel(t->lookup);
        g_object_unref(t->lookup);
    }
    if (t->timer) {
        g_source_remove(t->timer);
    }
    if (t->metrics) {
        pel_metrics_remove(t->metrics, collect, t);
    }
    g_free(t->option);
    g_free(t->text);
    g_free(t);
}

const struct sockaddr *pel_target_address(const struct pel_target *t,
                                          socklen_t *size)
{
    *size = t->size;
    return t->size > 0 ? (const struct sockaddr *)&t->address : NULL;
}

const char *pel_target_text(const struct pel_target *t)
{
    return t->text;
}
