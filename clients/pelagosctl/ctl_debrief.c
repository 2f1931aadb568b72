/* The commands about recordings on the server, and about its debrief. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "json.h"

#define LOOK_US 100000 /* between two questions how far it is */

static enum ctl_exit print_json(const ProtobufCMessage *message)
{
    char *text = pel_json_from_message(message, true);
    puts(text);
    free(text);
    return CTL_DONE;
}

static void print_recordings(const Pelagos__Recordings *all)
{
    if (!all->possible) {
        puts("pelagosd has no --recordings DIRECTORY");
    }
    for (size_t i = 0; i < all->n_recordings; i++) {
        const Pelagos__RecordingInfo *r = all->recordings[i];
        ctl_print(stdout, "%-40s %-20s %10.3f .. %.3f s  %8.1f kB%s%s%s\n",
                  r->name, r->began ? r->began : "", r->from, r->to,
                  (double)r->bytes / 1000, r->writing ? "  being written" : "",
                  r->error ? "  " : "", r->error ? r->error : "");
    }
}

enum ctl_exit ctl_recordings(struct ctl *ctl)
{
    const char *verb = ctl->arg_count > 0 ? ctl->args[0] : "list";
    Pelagos__RecordingCommand command = PELAGOS__RECORDING_COMMAND__INIT;
    Pelagos__Recordings *all = NULL;
    struct pel_client_error error;
    if (strcmp(verb, "start") == 0) {
        command.start = ctl->arg_count > 1 ? (char *)ctl->args[1] : "";
    } else if (strcmp(verb, "stop") == 0) {
        command.has_stop = command.stop = 1;
    } else if (strcmp(verb, "list") != 0) {
        return ctl_say(CTL_USAGE, "recordings %s? list, start or stop", verb);
    }
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    if (pel_client_recordings(
            ctl->client, command.start || command.has_stop ? &command : NULL,
            &all, &error)) {
        return ctl_report(ctl, &error);
    }
    if (ctl_flag(ctl, "json")) {
        status = print_json(&all->base);
    } else {
        print_recordings(all);
    }
    pelagos__recordings__free_unpacked(all, NULL);
    return status;
}

static const char *word_of(const Pelagos__Debrief *d)
{
    const ProtobufCEnumValue *value = protobuf_c_enum_descriptor_get_value(
        &pelagos__debrief_state__descriptor, (int)d->state);
    return value ? value->name : "?";
}

static enum ctl_exit print_debrief(struct ctl *ctl, const Pelagos__Debrief *d)
{
    if (ctl_flag(ctl, "json")) {
        return print_json(&d->base);
    }
    ctl_print(stdout, "%s %s\n", word_of(d), d->recording ? d->recording : "");
    if (d->state == PELAGOS__DEBRIEF_STATE__OPEN) {
        printf("at %.3f s, %.3f of %.3f s after the beginning%s\n", d->time,
               d->position, d->length, d->playing ? ", playing" : "");
        if (!d->same_device) {
            ctl_print(stdout, "recorded on %s: pictures differ in bits\n",
                      d->device ? d->device : "another device");
        }
    }
    if (d->error) {
        ctl_print(stdout, "%s\n", d->error);
    }
    return CTL_DONE;
}

/* Until it is neither opening nor closing nor on its way. */
static enum ctl_exit settle(struct ctl *ctl, Pelagos__Debrief **d)
{
    const Pelagos__DebriefCommand nothing = PELAGOS__DEBRIEF_COMMAND__INIT;
    struct pel_client_error error;
    while (!ctl_interrupted && !(*d)->playing &&
           ((*d)->busy || (*d)->state == PELAGOS__DEBRIEF_STATE__CLOSING)) {
        g_usleep(LOOK_US);
        pelagos__debrief__free_unpacked(*d, NULL);
        *d = NULL;
        if (pel_client_debrief(ctl->client, &nothing, d, &error)) {
            return ctl_report(ctl, &error);
        }
    }
    return ctl_interrupted ? CTL_FAILED : CTL_DONE;
}

static enum ctl_exit read_words(struct ctl *ctl, Pelagos__DebriefCommand *c)
{
    const char *verb = ctl->arg_count > 0 ? ctl->args[0] : "status";
    const char *what = ctl->arg_count > 1 ? ctl->args[1] : NULL;
    bool opens = strcmp(verb, "open") == 0, goes = strcmp(verb, "go") == 0;
    bool plays = strcmp(verb, "play") == 0;
    if ((opens || goes) != (what != NULL)) {
        return ctl_say(CTL_USAGE,
                       opens  ? "open which recording?"
                       : goes ? "go to which time?"
                              : "%s takes no argument",
                       verb);
    }
    if (goes && !ctl_parse_number(what, &c->time)) {
        return ctl_say(CTL_USAGE, "go %s: simulated seconds are wanted", what);
    }
    c->recording = opens ? (char *)what : NULL;
    c->has_time = goes;
    c->has_playing = plays || strcmp(verb, "pause") == 0;
    c->playing = plays;
    c->has_close = c->close = strcmp(verb, "close") == 0;
    c->has_rate = plays && ctl_value(ctl, "rate");
    c->rate = 1;
    if (c->has_rate && ctl_number(ctl, "rate", 0.1, 20, &c->rate)) {
        return CTL_USAGE;
    }
    return opens || goes || c->has_playing || c->has_close ||
                   strcmp(verb, "status") == 0
               ? CTL_DONE
               : ctl_say(CTL_USAGE,
                         "debrief %s? open, go, play, pause, close or status",
                         verb);
}

enum ctl_exit ctl_debrief(struct ctl *ctl)
{
    Pelagos__DebriefCommand command = PELAGOS__DEBRIEF_COMMAND__INIT;
    Pelagos__Debrief *debrief = NULL;
    struct pel_client_error error;
    enum ctl_exit status = read_words(ctl, &command);
    if (status == CTL_DONE) {
        status = ctl_connect(ctl);
    }
    if (status != CTL_DONE) {
        return status;
    }
    ctl_catch_signals();
    if (pel_client_debrief(ctl->client, &command, &debrief, &error)) {
        return ctl_report(ctl, &error);
    }
    status = settle(ctl, &debrief);
    if (status == CTL_DONE) {
        status = print_debrief(ctl, debrief);
    }
    if (debrief) {
        bool failed = debrief->error && (command.recording || command.has_time);
        status = status == CTL_DONE && failed ? CTL_REFUSED : status;
        pelagos__debrief__free_unpacked(debrief, NULL);
    }
    return status;
}
