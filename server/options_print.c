#include "options.h"

#include <glib.h>
#include <stdlib.h>
#include <string.h>

struct action_text {
    const char *name, *help;
};

static const struct action_text actions[] = {
    { "config FILE", "Reads this key file first; the command line wins." },
    { "check", "Does what a start does short of listening, says what a start "
               "would refuse, and ends. Nothing is written." },
    { "print-config", "Writes a key file of every option as the files and the "
                      "command line set it, with where each is from, and "
                      "ends." },
    { "print-completion", "Writes completion for bash, and ends." },
    { "print-man", "Writes the manual page, and ends." },
    { "version", "Writes the version, and ends." },
    { "help", "Writes this, and ends." },
};
#define ACTION_COUNT (sizeof actions / sizeof *actions)

/* Heading of a section of the key file. */
static const char *title(const char *section)
{
    static const struct action_text titles[] = {
        { "network", "Clients" },     { "scene", "Scene" },
        { "render", "Drawing" },      { "bridges", "Simulators" },
        { "nodes", "Several nodes" }, { "log", "Log" },
    };
    for (size_t i = 0; i < sizeof titles / sizeof *titles; i++) {
        if (strcmp(titles[i].name, section) == 0) {
            return titles[i].help;
        }
    }
    return section;
}

static bool begins_section(const struct pel_option *option)
{
    return option == pel_option_table ||
           strcmp(option->section, option[-1].section) != 0;
}

/* "[1 .. 240 Hz; 30]", the choices, or just the default. */
static void describe(const struct pel_option *o, char *text, size_t size)
{
    if (o->kind == PEL_OPTION_DOUBLE || o->kind == PEL_OPTION_INT) {
        char *words =
            o->choices ? g_strjoinv(", ", (char **)o->choices) : g_strdup("");
        snprintf(text, size, "%s%s%.12g .. %.12g%s%s; %s", words,
                 *words ? ", " : "", o->minimum, o->maximum,
                 *o->unit ? " " : "", o->unit, o->initial);
        g_free(words);
        return;
    }
    if (o->kind != PEL_OPTION_CHOICE) {
        snprintf(text, size, "%s", o->initial);
        return;
    }
    size_t used = 0;
    for (int i = 0; o->choices[i] && used < size; i++) {
        used += (size_t)snprintf(text + used, size - used, "%s%s",
                                 i > 0 ? "|" : "", o->choices[i]);
    }
    if (used < size) {
        snprintf(text + used, size - used, "; %s", o->initial);
    }
}

static void print_wrapped(FILE *to, const char *text, int indent)
{
    int column = 0;
    while (*text) {
        int length = (int)strcspn(text, " ");
        if (column == 0 || column + 1 + length > 78) {
            fprintf(to, "%s%*s", column ? "\n" : "", indent, "");
            column = indent;
        } else {
            fputc(' ', to);
            column++;
        }
        fprintf(to, "%.*s", length, text);
        column += length;
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', to);
}

void pel_options_print_help(FILE *to)
{
    char values[160], text[512];
    fprintf(to, "usage: pelagosd [OPTION]...\n\n"
                "Draws the sea without a window and serves its pictures. "
                "In brackets: legal\nvalues; default. `kill -HUP` re-reads "
                "the key file.\n");
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        if (begins_section(o)) {
            fprintf(to, "\n%s:\n", title(o->section));
        }
        fprintf(to, "  --%s%s%s\n", o->name, *o->argument ? " " : "",
                o->argument);
        describe(o, values, sizeof values);
        snprintf(text, sizeof text, "%s%s%s%s", o->help, *values ? " [" : "",
                 values, *values ? "]" : "");
        print_wrapped(to, text, 8);
    }
    fprintf(to, "\nGeneral:\n");
    for (size_t i = 0; i < ACTION_COUNT; i++) {
        fprintf(to, "  --%s\n", actions[i].name);
        print_wrapped(to, actions[i].help, 8);
    }
}

/* --- manual page --------------------------------------------------------- */

/* roff takes a bare minus for a hyphen, and backslashes for its own. */
static void print_roff(FILE *to, const char *text)
{
    for (; *text; text++) {
        if (*text == '-' || *text == '\\') {
            fputc('\\', to);
        }
        fputc(*text, to);
    }
}

static void print_man_option(FILE *to, const char *name, const char *argument,
                             const char *help, const char *values)
{
    fputs(".TP\n.B \\-\\-", to);
    print_roff(to, name);
    if (*argument) {
        fputs(" \\fI", to);
        print_roff(to, argument);
        fputs("\\fR", to);
    }
    fputc('\n', to);
    print_roff(to, help);
    if (*values) {
        fputs(" [", to);
        print_roff(to, values);
        fputs("]", to);
    }
    fputc('\n', to);
}

static void print_man_head(FILE *to)
{
    fputs(".TH PELAGOSD 8 \"\" \"Pelagos " PEL_VERSION "\" \"Pelagos\"\n"
          ".SH NAME\npelagosd \\- draws the sea without a window and serves "
          "its pictures\n"
          ".SH SYNOPSIS\n.B pelagosd\n[\\fIOPTION\\fR]...\n"
          ".SH DESCRIPTION\n"
          "Takes a ship's motion and a sea state over sockets (protobuf, "
          "HTTP, Modbus, NMEA 0183), draws the ocean, and gives the pictures "
          "back in as many views as are asked for: JPEG, PNG, OpenEXR, and "
          "live.\n.PP\n"
          "Every option is also a key of the file that \\fB\\-\\-config\\fR "
          "names, in the group shown with it; the command line wins. In "
          "brackets stand the legal values and the default.\n"
          ".SH OPTIONS\n",
          to);
}

static void print_man_tail(FILE *to)
{
    fputs(
        ".SH SIGNALS\n"
        ".TP\n.B SIGTERM, SIGINT\nRefuses new clients, finishes what is under "
        "way, and ends within 5 s.\n"
        ".TP\n.B SIGHUP\nReads and checks the key file again. What can change "
        "while running does so; for the rest the log says that a restart is "
        "needed. A file that is wrong changes nothing.\n"
        ".SH EXIT STATUS\n"
        ".TP\n.B 0\nEnded by a signal, or did what a printing option says.\n"
        ".TP\n.B 1\nCould not start or go on; the log says why.\n"
        ".TP\n.B 2\nAn option is wrong.\n"
        ".SH ENVIRONMENT\n"
        ".TP\n.B NOTIFY_SOCKET, WATCHDOG_USEC\nReadiness and watchdog, as "
        "\\fBsystemd\\fR(1) sets them.\n"
        ".TP\n.B MESA_SHADER_CACHE_DIR\nWhere Mesa keeps compiled shaders.\n"
        ".TP\n.B XDG_CACHE_HOME\nWhere NVIDIA's driver keeps them, ~/.cache "
        "without it. It makes no such directory: where there is none that it "
        "can write to, each start and each loss of the device takes seconds "
        "more.\n",
        to);
    for (const struct pel_option *o = pel_developer_table; o->name; o++) {
        char values[160];
        describe(o, values, sizeof values);
        fprintf(to, ".TP\n.B %s=\\fI%s\\fR\n", o->name, o->argument);
        print_roff(to, "For developers. ");
        print_roff(to, o->help);
        fprintf(to, " [%s]\n", values);
    }
    fputs(".SH SECURITY\n"
          "HTTP and protobuf are served to this machine only; for other "
          "networks put nginx with TLS in front. Modbus and NMEA know no "
          "passwords: beyond this machine they want a list of peers.\n"
          ".SH SEE ALSO\n.BR pelagosctl (1)\n",
          to);
}

void pel_options_print_man(FILE *to)
{
    char values[160];
    print_man_head(to);
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        if (begins_section(o)) {
            fprintf(to, ".SS %s: group [%s]\n", title(o->section), o->section);
        }
        describe(o, values, sizeof values);
        print_man_option(to, o->name, o->argument, o->help, values);
    }
    fputs(".SS General\n", to);
    for (size_t i = 0; i < ACTION_COUNT; i++) {
        print_man_option(to, actions[i].name, "", actions[i].help, "");
    }
    print_man_tail(to);
}

/* --- completion, example
 * ------------------------------------------------------ */

static void print_words(FILE *to, const struct pel_option *o)
{
    if (o->choices) {
        for (int i = 0; o->choices[i]; i++) {
            fprintf(to, "%s%s", i > 0 ? " " : "", o->choices[i]);
        }
    } else if (strcmp(o->name, "device") == 0) {
        fputs("auto software 0 1", to);
    } else {
        fprintf(to, "%s%s", o->initial,
                o->kind == PEL_OPTION_ADDRESS || o->kind == PEL_OPTION_TARGET
                    ? " off"
                    : "");
    }
}

void pel_options_print_completion(FILE *to)
{
    fputs("# bash completion for pelagosd\n_pelagosd() {\n"
          "    local cur=${COMP_WORDS[COMP_CWORD]}\n"
          "    local prev=${COMP_WORDS[COMP_CWORD-1]}\n"
          "    case $prev in\n"
          "    --config)\n"
          "        COMPREPLY=($(compgen -f -- \"$cur\")); return;;\n",
          to);
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        if (o->kind == PEL_OPTION_FLAG) {
            continue;
        }
        fprintf(to, "    --%s)\n        COMPREPLY=($(compgen %s-W \"", o->name,
                o->kind == PEL_OPTION_PATH ? "-f " : "");
        print_words(to, o);
        fputs("\" -- \"$cur\")); return;;\n", to);
    }
    fputs("    esac\n    COMPREPLY=($(compgen -W \"", to);
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        fprintf(to, "--%s ", o->name);
    }
    for (size_t i = 0; i < ACTION_COUNT; i++) {
        fprintf(to, "--%.*s ", (int)strcspn(actions[i].name, " "),
                actions[i].name);
    }
    fputs("\" -- \"$cur\"))\n}\ncomplete -F _pelagosd pelagosd\n", to);
}

/* A password may not stand in a log of who asks for help. */
static bool has_secret(const struct pel_option *o, const char *value)
{
    return o->secret && strchr(value, '@');
}

/* turn://user:SECRET@host to turn://user:***@host. */
static void print_masked(FILE *to, const char *value)
{
    g_auto(GStrv) words = g_strsplit(value, ",", -1);
    for (size_t i = 0; words[i]; i++) {
        char *at = strrchr(words[i], '@');
        char *start = strstr(words[i], "://");
        char *colon = start && at
                          ? memchr(start + 3, ':', (size_t)(at - start - 3))
                          : NULL;
        fprintf(to, "%s%.*s%s", i > 0 ? "," : "",
                colon ? (int)(colon - words[i]) : (int)strlen(words[i]),
                words[i], colon ? ":***" : "");
        fputs(colon ? at : "", to);
    }
}

static void print_developer(FILE *to, const struct pel_options *options)
{
    char value[PEL_OPTION_TEXT];
    for (const struct pel_option *o = pel_developer_table; o->name; o++) {
        const char *set = getenv(o->name);
        if (set && *set) {
            pel_option_text(o, options, value);
            fprintf(to, "\n# The environment sets %s=%s, which has no key.\n",
                    o->name, value);
        }
    }
}

void pel_options_print_config(FILE *to, const struct pel_options *options)
{
    char values[160], value[PEL_OPTION_TEXT];
    fputs("# Key file of pelagosd: what is in force, and where it is from. "
          "See pelagosd(8).\n",
          to);
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        const char *from = options->from[o - pel_option_table];
        if (begins_section(o)) {
            fprintf(to, "\n[%s]\n", o->section);
        }
        describe(o, values, sizeof values);
        pel_option_text(o, options, value);
        fprintf(to, "# %s [%s]%s\n", o->help, values,
                o->live ? " Changes on SIGHUP." : "");
        if (from) {
            fprintf(to, "# From %s:\n", from);
        }
        if (has_secret(o, value)) {
            fputs("# Its password is not printed.\n# ", to);
            fprintf(to, "%s=", o->name);
            print_masked(to, value);
            fputc('\n', to);
        } else {
            fprintf(to, "%s=%s\n", o->name, value);
        }
    }
    print_developer(to, options);
}
