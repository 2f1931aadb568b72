#include "pelagosctl/ctl.h"

#include <string.h>

#include <glib.h>

#include "proto/path.h"

/* What the words of one command's line may be, for the three shells. */

static void put_words(const struct ctl_option *options)
{
    for (; options && options->name; options++) {
        printf(" --%s", options->name);
    }
}

/* The values of options that have a list of them; several go by commas. */
static void bash_values(void)
{
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        for (const struct ctl_option *o = c->options; o && o->name; o++) {
            if (c->summary && o->words) {
                printf("    %s:--%s) values='%s' ;;\n", c->name, o->name,
                       o->words);
            }
        }
    }
}

static void bash_case(const struct ctl_command *command)
{
    printf("    %s) options='", command->name);
    put_words(command->options);
    printf("'; kind='%s' ;;\n", command->completes ? command->completes : "");
}

static void complete_bash(void)
{
    fputs("# bash completion of pelagosctl\n"
          "_pelagosctl() {\n"
          "  local cur=${COMP_WORDS[COMP_CWORD]} command= word options= kind= "
          "values= before=\n"
          "  local common='",
          stdout);
    put_words(ctl_global_options);
    fputs("' words=()\n"
          "  COMPREPLY=()\n"
          "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
          "    case $word in -*) ;; *) command=$word; break ;; esac\n"
          "  done\n"
          "  case $command in\n",
          stdout);
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (c->summary) {
            bash_case(c);
        }
    }
    fputs("    '') options='", stdout);
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (c->summary) {
            printf("%s ", c->name);
        }
    }
    fputs("' ;;\n"
          "  esac\n"
          "  case $command:${COMP_WORDS[COMP_CWORD-1]} in\n",
          stdout);
    bash_values();
    fputs("  esac\n"
          "  if [[ -n $values ]]; then\n"
          "    [[ $cur == *,* ]] && before=${cur%,*},\n"
          "    COMPREPLY=($(compgen -P \"$before\" -W \"$values\" -- "
          "\"${cur##*,}\"))\n"
          "    return\n"
          "  fi\n"
          "  if [[ $cur == -* || -z $command ]]; then\n"
          "    COMPREPLY=($(compgen -W \"$options $common\" -- \"$cur\"))\n"
          "  elif [[ $kind == files ]]; then\n"
          "    compopt -o default\n"
          "  elif [[ -n $kind ]]; then\n"
          "    COMPREPLY=($(compgen -W \"$(pelagosctl complete $kind)\" -- "
          "\"$cur\"))\n"
          "    [[ $command == set ]] && {\n"
          "      COMPREPLY=(\"${COMPREPLY[@]/%/=}\"); compopt -o nospace; }\n"
          "    [[ $kind == views ]] && compopt -o default\n"
          "  fi\n"
          "}\n"
          "complete -F _pelagosctl pelagosctl\n",
          stdout);
}

/* Single quotes inside single quotes, and the brackets of zsh's _arguments. */
static void zsh_text(const char *text)
{
    for (; *text; text++) {
        if (*text == '\'') {
            fputs("'\\''", stdout);
        } else if (strchr("[]:", *text)) {
            printf("\\%c", *text);
        } else {
            putchar(*text);
        }
    }
}

static void zsh_options(const struct ctl_option *options)
{
    for (; options && options->name; options++) {
        printf(" '--%s[", options->name);
        zsh_text(options->help);
        fputs("]", stdout);
        if (options->arg) {
            printf(":%s:", options->arg);
        }
        if (options->words) {
            printf("_values -s , %s %s", options->arg, options->words);
        }
        fputs("'", stdout);
    }
}

static void complete_zsh(void)
{
    fputs("#compdef pelagosctl\n"
          "_pelagosctl_words() { compadd -- $(pelagosctl complete $1) }\n"
          "_pelagosctl_set() { compadd -S = -- $(pelagosctl complete paths) }\n"
          "_pelagosctl_views() { _pelagosctl_words views; _files }\n"
          "_pelagosctl() {\n"
          "  local -a commands=(\n",
          stdout);
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (c->summary) {
            printf("    '%s:", c->name);
            zsh_text(c->summary);
            fputs("'\n", stdout);
        }
    }
    fputs("  )\n  local command=${words[(r)[a-z]*]:-}\n"
          "  shift words; (( CURRENT-- ))\n"
          "  if (( CURRENT == 1 )); then\n"
          "    _describe command commands; _arguments",
          stdout);
    zsh_options(ctl_global_options);
    fputs("; return\n  fi\n  case ${words[1]} in\n", stdout);
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (!c->summary) {
            continue;
        }
        const char *kind = c->completes ? c->completes : "";
        printf("  %s) _arguments", c->name);
        zsh_options(c->options);
        zsh_options(ctl_global_options);
        if (strcmp(c->name, "set") == 0) {
            fputs(" '*:field:_pelagosctl_set'", stdout);
        } else if (strcmp(kind, "views") == 0) {
            fputs(" '*:view:_pelagosctl_views'", stdout);
        } else if (strcmp(kind, "files") == 0) {
            fputs(" '*:file:_files'", stdout);
        } else if (*kind) {
            printf(" '*:%s:_pelagosctl_words %s'", kind, kind);
        }
        fputs(" ;;\n", stdout);
    }
    fputs("  esac\n}\n_pelagosctl \"$@\"\n", stdout);
}

static void fish_text(const char *text)
{
    for (; *text; text++) {
        if (*text == '\'' || *text == '\\') {
            putchar('\\');
        }
        putchar(*text);
    }
}

static void fish_options(const char *command, const struct ctl_option *options)
{
    for (; options && options->name; options++) {
        fputs("complete -c pelagosctl", stdout);
        if (command) {
            printf(" -n '__fish_seen_subcommand_from %s'", command);
        }
        printf(" -l %s", options->name);
        if (options->letter) {
            printf(" -s %c", options->letter);
        }
        if (options->arg) {
            fputs(" -r", stdout);
        }
        if (options->words) {
            printf(" -f -a '%s'", options->words);
        }
        fputs(" -d '", stdout);
        fish_text(options->help);
        fputs("'\n", stdout);
    }
}

static void complete_fish(void)
{
    fputs("# fish completion of pelagosctl\n"
          "complete -c pelagosctl -n __fish_use_subcommand -f\n",
          stdout);
    fish_options(NULL, ctl_global_options);
    for (const struct ctl_command *c = ctl_commands; c->name; c++) {
        if (!c->summary) {
            continue;
        }
        printf("complete -c pelagosctl -n __fish_use_subcommand -a %s -d '",
               c->name);
        fish_text(c->summary);
        fputs("'\n", stdout);
        fish_options(c->name, c->options);
        const char *kind = c->completes ? c->completes : "";
        if (*kind && strcmp(kind, "files") != 0) {
            printf("complete -c pelagosctl -n '__fish_seen_subcommand_from %s' "
                   "-a '(pelagosctl complete %s)'\n",
                   c->name, kind);
        }
    }
}

enum ctl_exit ctl_completion(struct ctl *ctl)
{
    const char *shell = ctl->args[0];
    if (strcmp(shell, "bash") == 0) {
        complete_bash();
    } else if (strcmp(shell, "zsh") == 0) {
        complete_zsh();
    } else if (strcmp(shell, "fish") == 0) {
        complete_fish();
    } else {
        return ctl_say(CTL_USAGE, "bash, zsh or fish, not \"%s\"", shell);
    }
    return CTL_DONE;
}

static void print_schema_path(const char *path,
                              const struct pel_path_info *info, void *user)
{
    (void)info;
    (void)user;
    if (!strchr(path, '*')) {
        puts(path);
    }
}

/* Words for the shells: of the running scene, else of the schema. Silent when
 * pelagosd does not run: a shell is waiting. */
enum ctl_exit ctl_complete(struct ctl *ctl)
{
    const char *kind = ctl->args[0];
    if (strcmp(kind, "shells") == 0) {
        puts("bash\nzsh\nfish");
        return CTL_DONE;
    }
    if (strcmp(kind, "commands") == 0) {
        for (const struct ctl_command *c = ctl_commands; c->name; c++) {
            if (c->summary) {
                puts(c->name);
            }
        }
        return CTL_DONE;
    }
    Pelagos__State *state = NULL;
    bool paths = strcmp(kind, "paths") == 0;
    if (pel_client_connect(ctl_value(ctl, "server"), 500, &ctl->client, NULL) ||
        pel_client_get(ctl->client, &state, NULL)) {
        if (paths) {
            pel_path_each(print_schema_path, NULL);
        }
        return CTL_DONE;
    }
    if (paths) {
        struct ctl_leaves leaves = ctl_flatten(state);
        for (size_t i = 0; i < leaves.count; i++) {
            puts(leaves.items[i].path);
        }
        ctl_leaves_free(&leaves);
    } else if (strcmp(kind, "views") == 0) {
        for (size_t i = 0; i < state->n_views; i++) {
            puts(state->views[i]->name);
        }
    }
    pelagos__state__free_unpacked(state, NULL);
    return CTL_DONE;
}
