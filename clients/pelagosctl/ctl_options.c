#include "pelagosctl/ctl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

const struct ctl_command *ctl_find_command(const char *name)
{
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (strcmp(c->name, name) == 0) {
            return c;
        }
    }
    return NULL;
}

static size_t count_options(const struct ctl_option *options)
{
    size_t count = 0;
    while (options && options[count].name) {
        count++;
    }
    return count;
}

/* Option number `slot` of the global ones and then the command's. */
static const struct ctl_option *option_at(const struct ctl *ctl, size_t slot)
{
    size_t global = count_options(ctl_global_options);
    if (slot < global) {
        return &ctl_global_options[slot];
    }
    slot -= global;
    if (ctl->command && slot < count_options(ctl->command->options)) {
        return &ctl->command->options[slot];
    }
    return NULL;
}

/* Slot of --NAME (length bytes) or -LETTER; -1: no such option. */
static int find_option(const struct ctl *ctl, const char *name, size_t length,
                       char letter)
{
    for (size_t slot = 0; slot < CTL_MAX_OPTIONS; slot++) {
        const struct ctl_option *option = option_at(ctl, slot);
        if (!option) {
            break;
        }
        if (letter ? option->letter == letter
                   : strlen(option->name) == length &&
                         strncmp(option->name, name, length) == 0) {
            return (int)slot;
        }
    }
    return -1;
}

static enum ctl_exit unknown_option(const struct ctl *ctl, const char *text)
{
    const char *names[CTL_MAX_OPTIONS];
    size_t count = 0;
    const struct ctl_option *option = NULL;
    while (count < CTL_MAX_OPTIONS && (option = option_at(ctl, count))) {
        names[count++] = option->name;
    }
    g_autofree char *name = g_strndup(text + strspn(text, "-"),
                                      strcspn(text, "=") - strspn(text, "-"));
    const char *near = ctl_nearest(name, names, count);
    const char *command = ctl->command ? ctl->command->name : NULL;
    return ctl_say(CTL_USAGE, "no option %s%s%s%s; see `pelagosctl %s%s--help`",
                   text, near ? "; did you mean --" : "", near ? near : "",
                   near ? "?" : "", command ? command : "", command ? " " : "");
}

/* Takes argv[i], an option, and maybe argv[i + 1]; *taken counts them. */
static enum ctl_exit take_option(struct ctl *ctl, char **argv, int *taken)
{
    const char *text = argv[0];
    bool is_long = text[1] == '-';
    const char *equals = is_long ? strchr(text, '=') : NULL;
    size_t length =
        is_long ? (equals ? (size_t)(equals - text) : strlen(text)) - 2 : 0;
    int slot = find_option(ctl, text + 2, length, is_long ? 0 : text[1]);
    *taken = 1;
    if (slot < 0) {
        return unknown_option(ctl, text);
    }
    const struct ctl_option *option = option_at(ctl, (size_t)slot);
    const char *glued = equals                ? equals + 1
                        : !is_long && text[2] ? text + 2
                                              : NULL;
    if (!option->arg) {
        if (glued) {
            return ctl_say(CTL_USAGE, "--%s takes no value", option->name);
        }
        ctl->values[slot] = "";
        return CTL_DONE;
    }
    if (!glued) {
        glued = argv[1];
        *taken = 2;
    }
    if (!glued) {
        return ctl_say(CTL_USAGE, "--%s needs a value: --%s %s", option->name,
                       option->name, option->arg);
    }
    if (g_str_has_suffix(option->arg, "...") &&
        ctl->values[slot]) { /* lives as long as we do */
        g_autofree char *both =
            g_strconcat(ctl->values[slot], ";", glued, NULL);
        glued = g_intern_string(both);
    }
    ctl->values[slot] = glued;
    return CTL_DONE;
}

enum ctl_exit ctl_no_command(const char *name)
{
    const char *names[64];
    size_t count = 0;
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        names[count++] = c->name;
    }
    const char *near = ctl_nearest(name, names, count);
    return ctl_say(CTL_USAGE, "no command \"%s\"%s%s%s; see `pelagosctl help`",
                   name, near ? "; did you mean " : "", near ? near : "",
                   near ? "?" : "");
}

static enum ctl_exit take_command(struct ctl *ctl, const char *name)
{
    ctl->command = ctl_find_command(name);
    return ctl->command ? CTL_DONE : ctl_no_command(name);
}

/* -5 and -.5 are numbers, a lone - is standard output. */
static bool is_option(const char *text)
{
    return text[0] == '-' && text[1] && !g_ascii_isdigit(text[1]) &&
           text[1] != '.';
}

static enum ctl_exit check_count(const struct ctl *ctl)
{
    const struct ctl_command *command = ctl->command;
    if (ctl->arg_count < command->least || ctl->arg_count > command->most) {
        const char *more =
            ctl->arg_count > command->most ? ctl->args[command->most] : NULL;
        return ctl_say(CTL_USAGE,
                       "%s%s%susage: pelagosctl %s%s%s; see `pelagosctl %s "
                       "--help`",
                       more ? "\"" : "", more ? more : "",
                       more ? "\" is one argument too many; " : "",
                       command->name, *command->arguments ? " " : "",
                       command->arguments, command->name);
    }
    return CTL_DONE;
}

enum ctl_exit ctl_parse(struct ctl *ctl, int argc, char **argv)
{
    *ctl = (struct ctl){ 0 };
    ctl->args = g_new0(const char *, (size_t)argc + 1);
    bool only_arguments = false;
    for (int i = 1; i < argc;) {
        enum ctl_exit status = CTL_DONE;
        int taken = 1;
        if (!only_arguments && strcmp(argv[i], "--") == 0) {
            only_arguments = true;
        } else if (!only_arguments && is_option(argv[i])) {
            status = take_option(ctl, argv + i, &taken);
        } else if (!ctl->command) {
            status = take_command(ctl, argv[i]);
        } else {
            ctl->args[ctl->arg_count++] = argv[i];
        }
        if (status != CTL_DONE) {
            return status;
        }
        i += taken;
    }
    if (ctl_flag(ctl, "help") || ctl_flag(ctl, "version")) {
        return CTL_DONE;
    }
    if (!ctl->command) {
        return ctl_say(CTL_USAGE, "what to do? see `pelagosctl help`");
    }
    return check_count(ctl);
}

const char *ctl_value(const struct ctl *ctl, const char *name)
{
    int slot = find_option(ctl, name, strlen(name), 0);
    return slot < 0 ? NULL : ctl->values[slot];
}

bool ctl_flag(const struct ctl *ctl, const char *name)
{
    return ctl_value(ctl, name) != NULL;
}

bool ctl_parse_number(const char *text, double *out)
{
    char *end = NULL;
    double value = g_ascii_strtod(text, &end);
    if (end == text || *end || !isfinite(value)) {
        return false;
    }
    *out = value;
    return true;
}

enum ctl_exit ctl_number(const struct ctl *ctl, const char *name,
                         double minimum, double maximum, double *out)
{
    const char *text = ctl_value(ctl, name);
    double value = 0.0;
    if (!text) {
        return CTL_DONE;
    }
    if (!ctl_parse_number(text, &value) || value < minimum || value > maximum) {
        return ctl_say(CTL_USAGE, "--%s %s: a number from %g to %g is wanted",
                       name, text, minimum, maximum);
    }
    *out = value;
    return CTL_DONE;
}
