#include "pelagosctl/ctl.h"

#include <string.h>

#include <glib.h>

static void print_options(FILE *out, const struct ctl_option *options)
{
    for (; options && options->name; options++) {
        char left[64];
        char letter[8] = "    ";
        if (options->letter) {
            g_snprintf(letter, sizeof letter, "-%c, ", options->letter);
        }
        g_snprintf(left, sizeof left, "%s--%s%s%s", letter, options->name,
                   options->arg ? " " : "", options->arg ? options->arg : "");
        fprintf(out, "  %-26s %s%s%s\n", left, options->help,
                options->words ? ": " : "",
                options->words ? options->words : "");
    }
}

/* Paragraphs folded at 76 columns. */
static void print_text(FILE *out, const char *text)
{
    size_t column = 0;
    g_auto(GStrv) words = g_strsplit_set(text, " \n", -1);
    for (size_t i = 0; words[i]; i++) {
        size_t length = strlen(words[i]);
        if (length == 0) {
            fputs("\n\n", out);
            column = 0;
            continue;
        }
        if (column > 0 && column + 1 + length > 76) {
            fputc('\n', out);
            column = 0;
        }
        column += (size_t)fprintf(out, "%s%s", column > 0 ? " " : "", words[i]);
    }
    fputc('\n', out);
}

static void print_examples(FILE *out, const char *const *examples)
{
    for (; examples && *examples; examples++) {
        g_auto(GStrv) parts = g_strsplit(*examples, "\n", 2);
        fprintf(out, "  %s\n        %s\n", parts[0], parts[1]);
    }
}

static void print_overview(FILE *out)
{
    fputs("pelagosctl: the command line of pelagosd, the headless ocean\n\n"
          "usage: pelagosctl [OPTION…] COMMAND [ARGUMENT…]\n\ncommands:\n",
          out);
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (c->summary) {
            fprintf(out, "  %-12s %s\n", c->name, c->summary);
        }
    }
    fputs("\noptions:\n", out);
    print_options(out, ctl_global_options);
    fputs("\n`pelagosctl help COMMAND` says more.\n", out);
}

void ctl_print_help(FILE *out, const struct ctl_command *command)
{
    if (!command) {
        print_overview(out);
        return;
    }
    fprintf(out, "usage: pelagosctl %s%s%s%s\n\n", command->name,
            command->options ? " [OPTION…]" : "",
            *command->arguments ? " " : "", command->arguments);
    print_text(out, command->text);
    if (command->options) {
        fputs("\noptions:\n", out);
        print_options(out, command->options);
    }
    fputs("\noptions of every command:\n", out);
    print_options(out, ctl_global_options);
    if (command->examples) {
        fputs("\nexamples:\n", out);
        print_examples(out, command->examples);
    }
}

enum ctl_exit ctl_help(struct ctl *ctl)
{
    const struct ctl_command *command = NULL;
    if (ctl->arg_count > 0) {
        command = ctl_find_command(ctl->args[0]);
        if (!command) {
            return ctl_no_command(ctl->args[0]);
        }
    }
    ctl_print_help(stdout, command);
    return CTL_DONE;
}

/* Text as roff: hyphens and backslashes kept, no line taken for a request. */
static void print_roff(FILE *out, const char *text)
{
    bool start = true;
    for (const char *c = text; *c; c++) {
        if (start && (*c == '.' || *c == '\'')) {
            fputs("\\&", out);
        }
        start = *c == '\n';
        if (*c == '\\') {
            fputs("\\e", out);
        } else if (*c == '-') {
            fputs("\\-", out);
        } else if (*c == '`') {
            fputs("\\(ga", out);
        } else {
            fputc(*c, out);
        }
    }
}

static void roff_options(FILE *out, const struct ctl_option *options)
{
    for (; options && options->name; options++) {
        fputs(".TP\n", out);
        if (options->letter) {
            fprintf(out, "\\fB\\-%c\\fR, ", options->letter);
        }
        fputs("\\fB\\-\\-", out);
        print_roff(out, options->name);
        fputs("\\fR", out);
        if (options->arg) {
            fputs(" \\fI", out);
            print_roff(out, options->arg);
            fputs("\\fR", out);
        }
        fputc('\n', out);
        print_roff(out, options->help);
        if (options->words) {
            fputs(": ", out);
            print_roff(out, options->words);
        }
        fputs(".\n", out);
    }
}

static void roff_paragraphs(FILE *out, const char *text)
{
    g_auto(GStrv) paragraphs = g_strsplit(text, "\n\n", -1);
    for (size_t i = 0; paragraphs[i]; i++) {
        fputs(".PP\n", out);
        print_roff(out, paragraphs[i]);
        fputc('\n', out);
    }
}

static void roff_command(FILE *out, const struct ctl_command *command)
{
    fprintf(out, ".SS \"");
    print_roff(out, command->name);
    if (*command->arguments) {
        fputc(' ', out);
        print_roff(out, command->arguments);
    }
    fputs("\"\n", out);
    roff_paragraphs(out, command->text);
    roff_options(out, command->options);
    for (const char *const *e = command->examples; e && *e; e++) {
        g_auto(GStrv) parts = g_strsplit(*e, "\n", 2);
        fputs(".IP\n.EX\n", out);
        print_roff(out, parts[0]);
        fputs("\n.EE\n.IP\n", out);
        print_roff(out, parts[1]);
        fputs("\n", out);
    }
}

static const char *const roff_end =
    ".SH \"EXIT STATUS\"\n"
    ".TP\n0\nDone.\n"
    ".TP\n1\nFailed here: a file, a missing encoder, an interruption.\n"
    ".TP\n2\nThe command line is wrong.\n"
    ".TP\n3\npelagosd does not answer.\n"
    ".TP\n4\npelagosd refused; nothing was changed.\n"
    ".SH ENVIRONMENT\n"
    ".TP\n\\fBPELAGOS_SERVER\\fR\nWhere pelagosd listens, as for "
    "\\-\\-server.\n"
    ".TP\n\\fBPELAGOS_TOKEN_FILE\\fR, \\fBPELAGOS_TOKEN\\fR\nThe token that "
    "pelagosd asks for: its file, as for \\-\\-token\\-file, or itself.\n"
    ".TP\n\\fBPELAGOS_CA\\fR\nA file of certificates (PEM) that tls: trusts "
    "instead of the system's.\n"
    ".SH \"SEE ALSO\"\n\\fBpelagosd\\fR(8)\n";

void ctl_print_manual(FILE *out)
{
    fprintf(out,
            ".TH PELAGOSCTL 1 \"\" \"Pelagos %s\" \"Pelagos\"\n"
            ".SH NAME\npelagosctl \\- the command line of pelagosd, the "
            "headless ocean\n"
            ".SH SYNOPSIS\n\\fBpelagosctl\\fR [\\fIOPTION\\fR…] "
            "\\fICOMMAND\\fR [\\fIARGUMENT\\fR…]\n"
            ".SH DESCRIPTION\n"
            "Reads and changes the scene that a running pelagosd draws, "
            "fetches its pictures, and feeds it recorded voyages.\n"
            "A field is named by its path: sea.windSpeed, views.bridge.yaw, "
            "entities.1.heading. What can be named is listed by "
            "\\fBpelagosctl get\\fR.\n"
            ".SH OPTIONS\n",
            PEL_VERSION);
    roff_options(out, ctl_global_options);
    fputs(".SH COMMANDS\n", out);
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (c->summary) {
            roff_command(out, c);
        }
    }
    fputs(roff_end, out);
}

enum ctl_exit ctl_manual(struct ctl *ctl)
{
    (void)ctl;
    ctl_print_manual(stdout);
    return CTL_DONE;
}
