/* exercise: what an instructor does with exercises. */
#include "pelagosctl/ctl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "base/file.h"
#include "json.h"

static const char *phase_of(const Pelagos__ExerciseRun *run)
{
    static const char *const words[] = { "none is loaded", "ready", "running",
                                         "paused", "ended" };
    return run->phase < G_N_ELEMENTS(words) ? words[run->phase] : "?";
}

static void print_status(const Pelagos__ExerciseStatus *s)
{
    if (!s->run || !s->run->name) {
        puts("no exercise is loaded");
        return;
    }
    ctl_print(stdout, "%s: %s, %.1f s%s\n", s->run->name, phase_of(s->run),
              s->time, s->leads ? "" : "; another leads it");
    if (s->title) {
        ctl_print(stdout, "  %s\n", s->title);
    }
    for (size_t i = 0; i < s->run->n_events; i++) {
        const Pelagos__ExerciseDone *d = s->run->events[i];
        if (d->count > 0) {
            ctl_print(stdout, "  %8.1f s  %s\n", d->time, d->event);
        }
    }
    if (s->next) {
        ctl_print(stdout, "  next: %s at %.1f s\n", s->next, s->next_time);
    }
}

static void print_list(const Pelagos__ExerciseStatus *s)
{
    for (size_t i = 0; i < s->n_exercises; i++) {
        const Pelagos__ExerciseInfo *e = s->exercises[i];
        ctl_print(stdout, "%-20s %s%s\n", e->name,
                  e->error ? "cannot be loaded: " : "",
                  e->error   ? e->error->message
                  : e->title ? e->title
                             : "");
    }
}

static void print_json(const ProtobufCMessage *message)
{
    char *text = pel_json_from_message(message, true);
    puts(text);
    free(text);
}

/* Sends the command; prints its answer. */
static enum ctl_exit ask(struct ctl *ctl,
                         const Pelagos__ExerciseCommand *command)
{
    Pelagos__ExerciseStatus *s = NULL;
    struct pel_client_error error;
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    if (pel_client_exercise(ctl->client, command, &s, &error)) {
        return ctl_report(ctl, &error);
    }
    if (s->exercise) {
        print_json(&s->exercise->base);
    } else if (ctl_flag(ctl, "json")) {
        print_json(&s->base);
    } else if (command->action == PELAGOS__EXERCISE_ACTION__LIST) {
        print_list(s);
    } else if (command->action == PELAGOS__EXERCISE_ACTION__CHECK) {
        puts("the exercise is good");
    } else {
        print_status(s);
    }
    pelagos__exercise_status__free_unpacked(s, NULL);
    return CTL_DONE;
}

/* Reads FILE as an exercise; whether it is a good one the daemon says. */
static enum ctl_exit read_file(const char *file, Pelagos__Exercise **out)
{
    char *text = NULL;
    size_t size;
    struct pel_fault fault;
    ProtobufCMessage *message = NULL;
    enum pel_err err =
        pel_file_read(file, PEL_JSON_MAX_BYTES, &text, &size, &fault);
    if (!err) {
        err = pel_json_to_message(text, size, &pelagos__exercise__descriptor,
                                  &message, &fault);
        free(text);
    }
    *out = (Pelagos__Exercise *)message;
    return err ? ctl_say(CTL_FAILED, "%s: %s", file, fault.message) : CTL_DONE;
}

static enum ctl_exit
send_file(struct ctl *ctl, Pelagos__ExerciseCommand *command, const char *file)
{
    enum ctl_exit status = read_file(file, &command->exercise);
    if (status == CTL_DONE) {
        status = ask(ctl, command);
        pelagos__exercise__free_unpacked(command->exercise, NULL);
    }
    return status;
}

/* The facts as CSV on standard output. */
static enum ctl_exit print_facts(struct ctl *ctl,
                                 Pelagos__ExerciseCommand *command)
{
    struct pel_client_error error;
    enum ctl_exit status = ctl_connect(ctl);
    for (bool more = status == CTL_DONE; more;) {
        Pelagos__ExerciseStatus *s = NULL;
        if (pel_client_exercise(ctl->client, command, &s, &error)) {
            return ctl_report(ctl, &error);
        }
        fputs(s->facts ? s->facts : "", stdout);
        more = s->has_more;
        command->has_time = true;
        command->time = s->more;
        pelagos__exercise_status__free_unpacked(s, NULL);
    }
    return status;
}

static const struct verb {
    const char *name;
    Pelagos__ExerciseAction action;
    const char *argument; /* NULL: none; in brackets: it may be absent */
} verbs[] = {
    { "status", PELAGOS__EXERCISE_ACTION__STATUS, NULL },
    { "list", PELAGOS__EXERCISE_ACTION__LIST, NULL },
    { "show", PELAGOS__EXERCISE_ACTION__SHOW, "NAME" },
    { "check", PELAGOS__EXERCISE_ACTION__CHECK, "FILE" },
    { "save", PELAGOS__EXERCISE_ACTION__SAVE, "NAME FILE" },
    { "delete", PELAGOS__EXERCISE_ACTION__DELETE, "NAME" },
    { "load", PELAGOS__EXERCISE_ACTION__LOAD, "NAME" },
    { "start", PELAGOS__EXERCISE_ACTION__START, NULL },
    { "pause", PELAGOS__EXERCISE_ACTION__PAUSE, NULL },
    { "rewind", PELAGOS__EXERCISE_ACTION__REWIND, "SECONDS" },
    { "stop", PELAGOS__EXERCISE_ACTION__STOP, NULL },
    { "facts", PELAGOS__EXERCISE_ACTION__FACTS, "[SHIP]" },
};

static const struct verb *find_verb(const char *name)
{
    for (size_t i = 0; i < G_N_ELEMENTS(verbs); i++) {
        if (strcmp(verbs[i].name, name) == 0) {
            return &verbs[i];
        }
    }
    return NULL;
}

static enum ctl_exit check_arguments(const struct ctl *ctl,
                                     const struct verb *verb)
{
    size_t wanted = !verb->argument ? 0 : strchr(verb->argument, ' ') ? 2 : 1;
    size_t given = ctl->arg_count - 1;
    bool absent = given == 0 && wanted && verb->argument[0] == '[';
    return given == wanted || absent
               ? CTL_DONE
               : ctl_say(CTL_USAGE, "usage: pelagosctl exercise %s%s%s",
                         verb->name, wanted ? " " : "",
                         wanted ? verb->argument : "");
}

static bool read_time(const char *text, double *out)
{
    char *end;
    *out = g_ascii_strtod(text, &end);
    return end != text && !*end && isfinite(*out);
}

/* Which own ship the facts are asked of. */
static enum ctl_exit read_ship(const struct ctl *ctl,
                               Pelagos__ExerciseCommand *command)
{
    guint64 ship = 0;
    if (ctl->arg_count < 2) {
        return CTL_DONE;
    }
    if (!g_ascii_string_to_unsigned(ctl->args[1], 10, 0, UINT32_MAX, &ship,
                                    NULL)) {
        return ctl_say(CTL_USAGE, "\"%s\" is no number of a ship",
                       ctl->args[1]);
    }
    command->has_ship = true;
    command->ship = (uint32_t)ship;
    return CTL_DONE;
}

enum ctl_exit ctl_exercise(struct ctl *ctl)
{
    const struct verb *verb =
        find_verb(ctl->arg_count > 0 ? ctl->args[0] : "status");
    Pelagos__ExerciseCommand command = PELAGOS__EXERCISE_COMMAND__INIT;
    if (!verb) {
        return ctl_say(CTL_USAGE,
                       "exercise %s? One of status, list, show, check, save, "
                       "delete, load, start, pause, rewind, stop, facts",
                       ctl->args[0]);
    }
    if (ctl->arg_count > 0 && check_arguments(ctl, verb) != CTL_DONE) {
        return CTL_USAGE;
    }
    command.has_action = true;
    command.action = verb->action;
    if (verb->argument && g_str_has_prefix(verb->argument, "NAME")) {
        command.name = (char *)ctl->args[1];
    }
    switch (verb->action) {
    case PELAGOS__EXERCISE_ACTION__CHECK:
        return send_file(ctl, &command, ctl->args[1]);
    case PELAGOS__EXERCISE_ACTION__SAVE:
        return send_file(ctl, &command, ctl->args[2]);
    case PELAGOS__EXERCISE_ACTION__FACTS:
        return read_ship(ctl, &command) == CTL_DONE ? print_facts(ctl, &command)
                                                    : CTL_USAGE;
    case PELAGOS__EXERCISE_ACTION__REWIND:
        command.has_time = true;
        if (!read_time(ctl->args[1], &command.time)) {
            return ctl_say(CTL_USAGE, "\"%s\" is no time in seconds",
                           ctl->args[1]);
        }
        return ask(ctl, &command);
    default:
        return ask(ctl, &command);
    }
}
