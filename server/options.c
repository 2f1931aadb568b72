#include "options.h"

#include <arpa/inet.h>
#include <errno.h>
#include <glib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hostport.h"
#include "base/log.h"
#include "base/nearest.h"

#define MOST_CONFIG (1 << 20) /* bytes */

/* --- one value ----------------------------------------------------------- */

static void *field(const struct pel_option *option, struct pel_options *options)
{
    return (char *)options + option->offset;
}

static enum pel_err refuse(struct pel_fault *fault,
                           const struct pel_option *option, const char *where,
                           const char *value, const char *why)
{
    pel_fault_set(fault, PEL_ERR_INVALID, "%s: '%.60s' %s", where, value, why);
    if (fault) {
        g_strlcpy(fault->path, option->name, sizeof fault->path);
        g_strlcpy(fault->value, value, sizeof fault->value);
    }
    return PEL_ERR_INVALID;
}

static enum pel_err set_number(const struct pel_option *option,
                               const char *value, const char *where,
                               struct pel_options *options,
                               struct pel_fault *fault)
{
    char why[160], words[64] = "";
    char *end = NULL;
    bool whole = option->kind == PEL_OPTION_INT;
    errno = 0;
    double number =
        whole ? (double)strtol(value, &end, 10) : g_ascii_strtod(value, &end);
    bool is_number = end != value && *end == 0;
    for (int i = 0; option->choices && option->choices[i]; i++) {
        if (strcmp(value, option->choices[i]) == 0) {
            *(double *)field(option, options) = option->values[i];
            return PEL_OK;
        }
        g_strlcat(words, i > 0 ? ", " : "neither ", sizeof words);
        g_strlcat(words, option->choices[i], sizeof words);
    }
    g_strlcat(words, *words ? " nor" : "not", sizeof words);
    if (!is_number || errno == ERANGE ||
        !(number >= option->minimum && number <= option->maximum)) {
        snprintf(why, sizeof why, "is %s %s within %.12g .. %.12g%s%s", words,
                 whole ? "a whole number" : "a number", option->minimum,
                 option->maximum, *option->unit ? " " : "", option->unit);
        return refuse(fault, option, where, value, why);
    }
    if (whole) {
        *(int *)field(option, options) = (int)number;
    } else {
        *(double *)field(option, options) = number;
    }
    return PEL_OK;
}

static enum pel_err set_choice(const struct pel_option *option,
                               const char *value, const char *where,
                               struct pel_options *options,
                               struct pel_fault *fault)
{
    char why[128] = "is none of";
    for (int i = 0; option->choices[i]; i++) {
        if (strcmp(value, option->choices[i]) == 0) {
            *(int *)field(option, options) = i;
            return PEL_OK;
        }
        g_strlcat(why, i > 0 ? ", " : " ", sizeof why);
        g_strlcat(why, option->choices[i], sizeof why);
    }
    return refuse(fault, option, where, value, why);
}

static enum pel_err set_flag(const struct pel_option *option, const char *value,
                             const char *where, struct pel_options *options,
                             struct pel_fault *fault)
{
    static const char *const yes[] = { "yes", "true", "on", "1", NULL };
    static const char *const no[] = { "no", "false", "off", "0", NULL };
    bool on = g_strv_contains(yes, value);
    if (!on && !g_strv_contains(no, value)) {
        return refuse(fault, option, where, value, "is neither yes nor no");
    }
    *(bool *)field(option, options) = on;
    return PEL_OK;
}

bool pel_options_split_ports(const char *text, uint16_t *first, uint16_t *last)
{
    g_auto(GStrv) words = g_strsplit(text, "-", 3);
    guint64 low, high;
    if (g_strv_length(words) != 2 ||
        !g_ascii_string_to_unsigned(words[0], 10, 1, 65535, &low, NULL) ||
        !g_ascii_string_to_unsigned(words[1], 10, low, 65535, &high, NULL)) {
        return false;
    }
    *first = (uint16_t)low;
    *last = (uint16_t)high;
    return true;
}

static enum pel_err set_list(const struct pel_option *option, const char *value,
                             const char *where, struct pel_options *options,
                             struct pel_fault *fault)
{
    char text[PEL_OPTION_TEXT], why[256];
    if (pel_options_list(option, value, text, why, sizeof why) != PEL_OK) {
        return refuse(fault, option, where, value, why);
    }
    g_strlcpy(field(option, options), text, PEL_OPTION_TEXT);
    return PEL_OK;
}

static enum pel_err set_text(const struct pel_option *option, const char *value,
                             const char *where, struct pel_options *options,
                             struct pel_fault *fault)
{
    char *text = field(option, options);
    bool can_be_off = option->kind != PEL_OPTION_TEXT_KIND;
    char host[PEL_HOST_SIZE];
    uint16_t port;
    if (strlen(value) >= PEL_OPTION_TEXT) {
        return refuse(fault, option, where, value,
                      "is longer than 255 characters");
    }
    if (can_be_off && strcmp(value, "off") == 0) {
        *text = 0;
        return PEL_OK;
    }
    if (option->kind == PEL_OPTION_ADDRESS &&
        pel_hostport_split(value, host, &port) != PEL_HOST_NUMBER) {
        return refuse(fault, option, where, value,
                      "is neither ADDRESS:PORT (127.0.0.1:8080, [::1]:8080, "
                      "port 0 .. 65535) nor off");
    }
    if (option->kind == PEL_OPTION_TARGET &&
        (pel_hostport_split(value, host, &port) == PEL_HOST_NONE ||
         port == 0)) {
        return refuse(fault, option, where, value,
                      "is neither HOST:PORT (127.0.0.1:8000, [::1]:8000, "
                      "vm.example:8000, port 1 .. 65535) nor off");
    }
    if (option->kind == PEL_OPTION_LIST) {
        return set_list(option, value, where, options, fault);
    }
    if (option->kind == PEL_OPTION_PATH && *value == 0) {
        return refuse(fault, option, where, value, "is no path; try off");
    }
    g_strlcpy(text, value, PEL_OPTION_TEXT);
    return PEL_OK;
}

enum pel_err pel_option_set(const struct pel_option *option, const char *value,
                            const char *where, struct pel_options *options,
                            struct pel_fault *fault)
{
    switch (option->kind) {
    case PEL_OPTION_DOUBLE:
    case PEL_OPTION_INT:
        return set_number(option, value, where, options, fault);
    case PEL_OPTION_CHOICE:
        return set_choice(option, value, where, options, fault);
    case PEL_OPTION_FLAG:
        return set_flag(option, value, where, options, fault);
    case PEL_OPTION_TEXT_KIND:
    case PEL_OPTION_ADDRESS:
    case PEL_OPTION_TARGET:
    case PEL_OPTION_LIST:
    case PEL_OPTION_PATH:
        break;
    }
    return set_text(option, value, where, options, fault);
}

bool pel_option_equal(const struct pel_option *option,
                      const struct pel_options *a, const struct pel_options *b)
{
    const char *x = (const char *)a + option->offset;
    const char *y = (const char *)b + option->offset;
    switch (option->kind) {
    case PEL_OPTION_DOUBLE:
        return *(const double *)x == *(const double *)y;
    case PEL_OPTION_INT:
    case PEL_OPTION_CHOICE:
        return *(const int *)x == *(const int *)y;
    case PEL_OPTION_FLAG:
        return *(const bool *)x == *(const bool *)y;
    case PEL_OPTION_TEXT_KIND:
    case PEL_OPTION_ADDRESS:
    case PEL_OPTION_TARGET:
    case PEL_OPTION_LIST:
    case PEL_OPTION_PATH:
        break;
    }
    return strcmp(x, y) == 0;
}

void pel_option_text(const struct pel_option *option,
                     const struct pel_options *options,
                     char out[PEL_OPTION_TEXT])
{
    const void *at = (const char *)options + option->offset;
    switch (option->kind) {
    case PEL_OPTION_DOUBLE: {
        double number = *(const double *)at;
        const char *word = NULL;
        for (int i = 0; option->choices && option->choices[i]; i++) {
            word = number == option->values[i] ? option->choices[i] : word;
        }
        g_snprintf(out, PEL_OPTION_TEXT, "%.15g", number);
        if (word) {
            g_strlcpy(out, word, PEL_OPTION_TEXT);
        }
        return;
    }
    case PEL_OPTION_INT:
        g_snprintf(out, PEL_OPTION_TEXT, "%d", *(const int *)at);
        return;
    case PEL_OPTION_CHOICE:
        g_strlcpy(out, option->choices[*(const int *)at], PEL_OPTION_TEXT);
        return;
    case PEL_OPTION_FLAG:
        g_strlcpy(out, *(const bool *)at ? "yes" : "no", PEL_OPTION_TEXT);
        return;
    case PEL_OPTION_ADDRESS:
    case PEL_OPTION_TARGET:
    case PEL_OPTION_PATH:
        g_strlcpy(out, *(const char *)at ? at : "off", PEL_OPTION_TEXT);
        return;
    case PEL_OPTION_LIST:
    case PEL_OPTION_TEXT_KIND:
        break;
    }
    g_strlcpy(out, at, PEL_OPTION_TEXT);
}

void pel_options_log_changes(const struct pel_options *from,
                             const struct pel_options *to)
{
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        if (!pel_option_equal(o, from, to)) {
            pel_log(o->live ? PEL_LOG_INFO : PEL_LOG_WARNING, "DMN-021",
                    o->live ? "%s has changed"
                            : "%s has changed: restart to use it",
                    o->name);
        }
    }
}

void pel_options_init(struct pel_options *options)
{
    const struct pel_option *tables[] = { pel_option_table,
                                          pel_developer_table };
    *options = (struct pel_options){ 0 };
    for (size_t i = 0; i < sizeof tables / sizeof *tables; i++) {
        for (const struct pel_option *o = tables[i]; o->name; o++) {
            struct pel_fault fault;
            if (pel_option_set(o, o->initial, o->name, options, &fault)) {
                g_error("default of %s", fault.message); /* our own mistake */
            }
        }
    }
}

static enum pel_err read_environment(struct pel_options *options,
                                     struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    for (const struct pel_option *o = pel_developer_table;
         o->name && err == PEL_OK; o++) {
        const char *value = getenv(o->name);
        if (value && *value) {
            err = pel_option_set(o, value, o->name, options, fault);
        }
    }
    return err;
}

/* --- key file ------------------------------------------------------------ */

static const struct pel_option *find(const char *name)
{
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        if (strcmp(o->name, name) == 0) {
            return o;
        }
    }
    return NULL;
}

static enum pel_err set_key(GKeyFile *file, const char *path, const char *group,
                            const char *key, struct pel_options *options,
                            struct pel_fault *fault)
{
    const struct pel_option *option = find(key);
    if (!option) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "%s: [%s] %s is no option", path, group, key);
    }
    if (strcmp(option->section, group) != 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%s: %s belongs into [%s], not [%s]", path, key,
                             option->section, group);
    }
    char where[160];
    snprintf(where, sizeof where, "%s: [%s] %s", path, group, key);
    char *value = g_key_file_get_string(file, group, key, NULL);
    enum pel_err err =
        pel_option_set(option, value ? value : "", where, options, fault);
    options->from[option - pel_option_table] = path;
    g_free(value);
    return err;
}

static enum pel_err read_file(const char *path, struct pel_options *options,
                              struct pel_fault *fault)
{
    char *text;
    size_t size;
    enum pel_err err = pel_file_read(path, MOST_CONFIG, &text, &size, fault);
    if (err) {
        return err;
    }
    GKeyFile *file = g_key_file_new();
    GError *error = NULL;
    bool good =
        g_key_file_load_from_data(file, text, size, G_KEY_FILE_NONE, &error);
    free(text);
    if (!good) {
        err = pel_fault_set(fault, PEL_ERR_IO, "%s: %s", path, error->message);
        g_clear_error(&error);
        g_key_file_free(file);
        return err;
    }
    char **groups = g_key_file_get_groups(file, NULL);
    for (int g = 0; groups[g] && err == PEL_OK; g++) {
        char **keys = g_key_file_get_keys(file, groups[g], NULL, NULL);
        for (int k = 0; keys && keys[k] && err == PEL_OK; k++) {
            err = set_key(file, path, groups[g], keys[k], options, fault);
        }
        g_strfreev(keys);
    }
    g_strfreev(groups);
    g_key_file_free(file);
    return err;
}

/* --- command line -------------------------------------------------------- */

/* Actions, and --config, which is read before the others. */
static bool read_action(const char *name, enum pel_options_action *action)
{
    static const struct {
        const char *name;
        enum pel_options_action action;
    } actions[] = {
        { "help", PEL_ACTION_HELP },
        { "version", PEL_ACTION_VERSION },
        { "print-man", PEL_ACTION_MAN },
        { "print-completion", PEL_ACTION_COMPLETION },
        { "print-config", PEL_ACTION_CONFIG },
        { "check", PEL_ACTION_CHECK },
    };
    for (size_t i = 0; i < sizeof actions / sizeof *actions; i++) {
        if (strcmp(name, actions[i].name) == 0) {
            *action = actions[i].action;
            return true;
        }
    }
    return false;
}

/* One argument, split; `value` NULL where the argument gives none. */
struct argument {
    char name[64];
    const char *value;
    int used; /* elements of argv */
};

static bool takes_value(const char *name)
{
    const struct pel_option *option = find(name);
    return strcmp(name, "config") == 0 ||
           (option && option->kind != PEL_OPTION_FLAG);
}

/* Says so of the option itself, not of a value that follows it. */
static enum pel_err refuse_unknown(const char *name, struct pel_fault *fault)
{
    const char *names[128] = { "config", "help", "version" };
    size_t count = 3;
    for (const struct pel_option *o = pel_option_table;
         o->name && count < G_N_ELEMENTS(names); o++) {
        names[count++] = o->name;
    }
    const char *near = pel_nearest(name, names, count);
    return pel_fault_set(
        fault, PEL_ERR_NOT_FOUND, "--%s is no option%s%s%s; see --help", name,
        near ? "; did you mean --" : "", near ? near : "", near ? "?" : "");
}

static enum pel_err split_argument(int argc, char **argv, int i,
                                   struct argument *out,
                                   struct pel_fault *fault)
{
    const char *text = argv[i];
    *out = (struct argument){ .used = 1 };
    if (strcmp(text, "-h") == 0) {
        text = "--help";
    }
    if (strncmp(text, "--", 2) != 0 || text[2] == 0) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "'%.60s' is no option; see --help", text);
    }
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) - 2 : strlen(text) - 2;
    if (length < sizeof out->name) {
        memcpy(out->name, text + 2, length);
    }
    enum pel_options_action action;
    if (!find(out->name) && strcmp(out->name, "config") != 0 &&
        (equals || !read_action(out->name, &action))) {
        return refuse_unknown(out->name, fault);
    }
    if (equals) {
        out->value = equals + 1;
    } else if (takes_value(out->name)) {
        if (i + 1 >= argc) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "%s wants a value; see --help", text);
        }
        out->value = argv[i + 1];
        out->used = 2;
    }
    return PEL_OK;
}

static enum pel_err apply_argument(const struct argument *argument,
                                   struct pel_options *options,
                                   enum pel_options_action *action,
                                   struct pel_fault *fault)
{
    const struct pel_option *option = find(argument->name);
    char where[80];
    if (strcmp(argument->name, "config") == 0) {
        return PEL_OK;
    }
    if (!option) {
        if (!argument->value && read_action(argument->name, action)) {
            return PEL_OK;
        }
        return refuse_unknown(argument->name, fault);
    }
    snprintf(where, sizeof where, "--%s", argument->name);
    options->from[option - pel_option_table] = "the command line";
    return pel_option_set(option, argument->value ? argument->value : "yes",
                          where, options, fault);
}

enum pel_err pel_options_read(int argc, char **argv,
                              struct pel_options *options,
                              enum pel_options_action *action,
                              struct pel_fault *fault)
{
    struct argument argument;
    pel_options_init(options);
    enum pel_err err = read_environment(options, fault);
    *action = PEL_ACTION_RUN;
    for (int i = 1; i < argc && err == PEL_OK; i += argument.used) {
        err = split_argument(argc, argv, i, &argument, fault);
        if (err == PEL_OK && strcmp(argument.name, "config") == 0) {
            err = read_file(argument.value, options, fault);
        }
    }
    for (int i = 1; i < argc && err == PEL_OK; i += argument.used) {
        err = split_argument(argc, argv, i, &argument, fault);
        if (err == PEL_OK) {
            err = apply_argument(&argument, options, action, fault);
        }
    }
    return err == PEL_OK ? pel_options_check(options, fault) : err;
}

/* --- all together -------------------------------------------------------- */

static bool is_loopback(const char *address)
{
    char host[PEL_HOST_SIZE];
    uint16_t port;
    uint8_t binary[4];
    if (*address == 0) {
        return true;
    }
    if (pel_hostport_split(address, host, &port) != PEL_HOST_NUMBER) {
        return false;
    }
    return inet_pton(AF_INET, host, binary) == 1 ? binary[0] == 127
                                                 : strcmp(host, "::1") == 0;
}

/* An interface with a token of its own, on a network. */
static enum pel_err check_open(const struct pel_options *options,
                               const char *name, const char *address,
                               struct pel_fault *fault)
{
    bool http = strcmp(name, "http") == 0;
    if (!*options->token_file) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "--%s: '%s' is not loopback, and nobody is asked "
                             "who he is; name a token's file with "
                             "--token-file, or bind 127.0.0.1",
                             name, address);
    }
    if (options->plain || (!http && *options->tls_cert)) {
        return PEL_OK;
    }
    return pel_fault_set(
        fault, PEL_ERR_CONFLICT,
        http ? "--%s: '%s' is not loopback, and HTTP has no TLS of its own; "
               "bind 127.0.0.1 behind nginx (packaging/nginx), or say --plain"
             : "--%s: '%s' is not loopback and has no TLS; name a certificate "
               "with --tls-cert and --tls-key, or say --plain",
        name, address);
}

/* Whether the list of [ENTITY@]ADDRESS:PORT has this address. */
static bool sends_to(const char *list, const char *address)
{
    g_auto(GStrv) words = pel_options_split(list);
    for (size_t i = 0; words && words[i]; i++) {
        const char *at = strchr(words[i], '@');
        if (strcmp(at ? at + 1 : words[i], address) == 0) {
            return true;
        }
    }
    return false;
}

static enum pel_err check_whep(const struct pel_options *options,
                               struct pel_fault *fault)
{
    uint16_t first, last;
    if (*options->whep_ports &&
        !pel_options_split_ports(options->whep_ports, &first, &last)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "--whep-ports: '%.60s' is not FIRST-LAST, ports "
                             "within 1 .. 65535, as 50000-50063",
                             options->whep_ports);
    }
    return PEL_OK;
}

enum pel_err pel_options_check(const struct pel_options *options,
                               struct pel_fault *fault)
{
    const struct {
        const char *name, *address, *allow, *list;
    } open[] = {
        { "http", options->http, NULL, NULL },
        { "tcp", options->tcp, NULL, NULL },
        { "rtsp", options->rtsp, NULL, NULL },
        { "modbus", options->modbus, options->modbus_allow, "modbus" },
        { "nmea", options->nmea, options->nmea_allow, "nmea" },
        { "nmea-tcp", options->nmea_tcp, options->nmea_allow, "nmea" },
        { "cigi", options->cigi, options->cigi_allow, "cigi" },
    };
    if (check_whep(options, fault) != PEL_OK) {
        return fault->code;
    }
    if (!*options->device ||
        (strchr(options->device, ',') && strstr(options->device, "all"))) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "--device: '%.60s' is neither all nor a list of "
                             "auto, software and numbers within 0 .. 999",
                             options->device);
    }
    if (*options->nmea && sends_to(options->nmea_out, options->nmea)) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "--nmea-out: %s is where --nmea listens",
                             options->nmea);
    }
    if (!*options->tls_cert != !*options->tls_key) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "--tls-cert and --tls-key go together");
    }
    if (!*options->exercise_cert != !*options->exercise_key) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "--exercise-cert and --exercise-key go together");
    }
    if (!*options->console != !*options->console_table) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "--console and --console-table go together");
    }
    for (size_t i = 0; i < sizeof open / sizeof *open; i++) {
        if (is_loopback(open[i].address) || (open[i].allow && *open[i].allow)) {
            continue;
        }
        if (open[i].allow) {
            return pel_fault_set(fault, PEL_ERR_CONFLICT,
                                 "--%s: '%s' is open to a network; say with "
                                 "--%s-allow who may use it",
                                 open[i].name, open[i].address, open[i].list);
        }
        enum pel_err err =
            check_open(options, open[i].name, open[i].address, fault);
        if (err != PEL_OK) {
            return err;
        }
    }
    return PEL_OK;
}
