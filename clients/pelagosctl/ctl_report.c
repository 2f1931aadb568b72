#include "pelagosctl/ctl.h"

#include <signal.h>
#include <stdarg.h>
#include <string.h>

#include <glib.h>

#include "base/err.h"
#include "base/text.h"
#include "proto/path.h"

volatile int ctl_interrupted;

static void on_signal(int number)
{
    (void)number;
    ctl_interrupted = 1;
}

void ctl_catch_signals(void)
{
    /* Without SA_RESTART, so that waits end early. A second one kills. */
    struct sigaction action = { .sa_handler = on_signal,
                                .sa_flags = (int)SA_RESETHAND };
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

static void print_shown(FILE *out, const char *format, va_list args)
{
    g_autofree char *text = g_strdup_vprintf(format, args);
    pel_text_clean_lines(text);
    fputs(text, out);
}

void ctl_print(FILE *out, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    print_shown(out, format, args);
    va_end(args);
}

enum ctl_exit ctl_say(enum ctl_exit status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fputs("pelagosctl: ", stderr);
    print_shown(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    return status;
}

struct candidates {
    GPtrArray *words;
    GPtrArray *owned;
    const char *wanted;
    bool field_exists; /* then its element does not */
};

/* Every path of the schema, with the wanted path's own keys for the `*`. */
static void add_candidate(const char *path, const struct pel_path_info *info,
                          void *user)
{
    (void)info;
    struct candidates *all = user;
    g_auto(GStrv) steps = g_strsplit(path, ".", -1);
    g_auto(GStrv) wanted = g_strsplit(all->wanted, ".", -1);
    guint depth = g_strv_length(wanted);
    for (guint i = 0; steps[i]; i++) {
        if (strcmp(steps[i], "*") == 0) {
            g_free(steps[i]);
            steps[i] = g_strdup(i < depth ? wanted[i] : "NAME");
        }
    }
    char *word = g_strjoinv(".", steps);
    g_ptr_array_add(all->owned, word);
    if (!ctl_path_below(word, all->wanted)) {
        g_ptr_array_add(all->words, word);
    }
    all->field_exists |= strcmp(word, all->wanted) == 0;
}

static void add_word(struct candidates *all, const char *list, const char *name)
{
    /* `frame bridg` names the view alone, `get views.bridg` its path. */
    bool path = strchr(all->wanted, '.') != NULL;
    char *word = path ? g_strdup_printf("%s.%s", list, name) : g_strdup(name);
    g_ptr_array_add(all->owned, word);
    g_ptr_array_add(all->words, word);
}

/* The views and entities that there are. */
static void add_elements(struct ctl *ctl, struct candidates *all)
{
    Pelagos__State *state = NULL;
    if (!ctl->client || pel_client_get(ctl->client, &state, NULL)) {
        return;
    }
    for (size_t i = 0; i < state->n_views; i++) {
        add_word(all, "views", state->views[i]->name);
    }
    for (size_t i = 0; i < state->n_entities; i++) {
        const char *name = state->entities[i]->name;
        if (name && *name) {
            add_word(all, "entities", name);
        }
    }
    pelagos__state__free_unpacked(state, NULL);
}

/* The field, view or entity that `path` was meant to be; g_free(), NULL: none.
 * `elements`: not a field. */
static char *nearest_path(struct ctl *ctl, const char *path, bool elements)
{
    struct candidates all = {
        .words = g_ptr_array_new(),
        .owned = g_ptr_array_new_with_free_func(g_free),
        .wanted = path,
    };
    if (!elements) {
        pel_path_each(add_candidate, &all);
    }
    g_auto(GStrv) steps = g_strsplit(path, ".", 3);
    g_autofree char *element = NULL;
    if (all.field_exists && steps[0] && steps[1]) {
        element = g_strdup_printf("%s.%s", steps[0], steps[1]);
        path = element;
        g_ptr_array_set_size(all.words, 0);
    }
    add_elements(ctl, &all);
    const char *near = ctl_nearest(path, (const char *const *)all.words->pdata,
                                   all.words->len);
    char *copy = g_strdup(near);
    g_ptr_array_unref(all.words);
    g_ptr_array_unref(all.owned);
    return copy;
}

static void print_json(const struct pel_client_error *error, const char *near)
{
    fputs("{\"error\":{\"code\":", stderr);
    ctl_print_string(stderr, pel_client_code_name(error->code));
    const char *const names[] = { "path", "value", "unit", "message",
                                  "nearest" };
    const char *const texts[] = { error->path, error->value, error->unit,
                                  error->message, near ? near : "" };
    for (size_t i = 0; i < G_N_ELEMENTS(names); i++) {
        if (*texts[i]) {
            fprintf(stderr, ",\"%s\":", names[i]);
            ctl_print_string(stderr, texts[i]);
        }
    }
    if (error->minimum <= error->maximum) {
        fprintf(stderr, ",\"minimum\":%.17g,\"maximum\":%.17g", error->minimum,
                error->maximum);
    }
    fputs("}}\n", stderr);
}

static const char *hint(enum pel_client_code code)
{
    switch (code) {
    case PEL_CLIENT_UNREACHABLE:
        return "start it with `make run` or `pelagosd`, or name another with "
               "--server or PELAGOS_SERVER";
    case PEL_CLIENT_TIMEOUT:
        return "allow it more with --timeout, or look into its log";
    case PEL_CLIENT_CLOSED:
    case PEL_CLIENT_PROTOCOL:
        return "is that the port of --tcp, not of --http?";
    case PEL_CLIENT_UNAUTHORIZED:
        return "name the file with pelagosd's token by --token-file or "
               "PELAGOS_TOKEN_FILE";
    case PEL_CLIENT_FORBIDDEN:
        return "ask who runs pelagosd for a token of that role";
    case PEL_CLIENT_BUSY:
        return "try again in a moment";
    case PEL_CLIENT_INTERNAL:
        return "pelagosd's log says more";
    default:
        return NULL;
    }
}

static void print_text(const struct pel_client_error *error, const char *near)
{
    bool has_path = *error->path && !strstr(error->message, error->path);
    bool has_value = *error->value && !strstr(error->message, error->value);
    ctl_print(stderr, "pelagosctl: %s%s%s%s%s%s\n", has_path ? error->path : "",
              has_path ? ": " : "", error->message, has_value ? ": \"" : "",
              has_value ? error->value : "", has_value ? "\"" : "");
    char maximum[32];
    g_snprintf(maximum, sizeof maximum, "%.10g", error->maximum);
    /* A conflict is with something else in the state: no range mends it. */
    if (error->code != PEL_CLIENT_CONFLICT &&
        error->minimum <= error->maximum && !strstr(error->message, maximum)) {
        bool unit = *error->unit && strcmp(error->unit, "1") != 0;
        ctl_print(stderr, "  legal: %.10g .. %.10g%s%s\n", error->minimum,
                  error->maximum, unit ? " " : "", unit ? error->unit : "");
    }
    if (near) {
        ctl_print(stderr, "  did you mean %s?\n", near);
    } else if (hint(error->code)) {
        fprintf(stderr, "  %s\n", hint(error->code));
    }
}

enum ctl_exit ctl_report(struct ctl *ctl, const struct pel_client_error *error)
{
    g_autofree char *near = NULL;
    if (error->code == PEL_CLIENT_NOT_FOUND) {
        bool view = strcmp(error->path, "view") == 0 && *error->value;
        near = nearest_path(ctl, view ? error->value : error->path, view);
    }
    if (ctl_flag(ctl, "json")) {
        print_json(error, near);
    } else {
        print_text(error, near);
    }
    switch (error->code) {
    case PEL_CLIENT_BAD_ADDRESS:
        return CTL_USAGE;
    case PEL_CLIENT_UNREACHABLE:
    case PEL_CLIENT_TIMEOUT:
    case PEL_CLIENT_CLOSED:
    case PEL_CLIENT_PROTOCOL:
        return CTL_UNREACHABLE;
    default:
        return CTL_REFUSED;
    }
}

enum ctl_exit ctl_report_fault(struct ctl *ctl, const struct pel_fault *fault)
{
    struct pel_client_error error = {
        .code = fault->code >= PEL_ERR_MALFORMED && fault->code <= PEL_ERR_BUSY
                    ? (enum pel_client_code)fault->code
                    : PEL_CLIENT_INTERNAL,
        .minimum = fault->minimum,
        .maximum = fault->maximum,
    };
    g_strlcpy(error.path, fault->path, sizeof error.path);
    g_strlcpy(error.value, fault->value, sizeof error.value);
    g_strlcpy(error.unit, fault->unit ? fault->unit : "", sizeof error.unit);
    g_strlcpy(error.message, fault->message, sizeof error.message);
    return ctl_report(ctl, &error);
}

enum ctl_exit ctl_connect(struct ctl *ctl)
{
    /* Many questions take long together. */
    bool many = ctl->command->run == ctl_plot || ctl_flag(ctl, "sweep");
    double seconds = many ? 120.0 : 10.0;
    enum ctl_exit status = ctl_number(ctl, "timeout", 0.01, 3600, &seconds);
    if (status != CTL_DONE) {
        return status;
    }
    struct pel_client_error error;
    if (pel_client_connect(ctl_value(ctl, "server"), (int)(seconds * 1000),
                           &ctl->client, &error) != PEL_CLIENT_OK) {
        return ctl_report(ctl, &error);
    }
    return CTL_DONE;
}

enum ctl_exit ctl_patch(struct ctl *ctl, const Pelagos__Patch *patch,
                        Pelagos__State **out)
{
    struct pel_client_error error;
    if (pel_client_patch(ctl->client, patch, out, &error)) {
        return ctl_report(ctl, &error);
    }
    const char *notice = pel_client_notice(ctl->client);
    return *notice ? ctl_say(CTL_DONE, "%s", notice) : CTL_DONE;
}

enum ctl_exit ctl_fetch(struct ctl *ctl, Pelagos__State **out)
{
    enum ctl_exit status = ctl_connect(ctl);
    struct pel_client_error error;
    if (status == CTL_DONE && pel_client_get(ctl->client, out, &error)) {
        status = ctl_report(ctl, &error);
    }
    return status;
}
