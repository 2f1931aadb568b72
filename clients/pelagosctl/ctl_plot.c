/* The command that draws numbers: asks pelagosd, and hands the answers to
 * pelagos-plot, a process of the Python client. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <gio/gio.h>

#include "fields.h"
#include "json.h"
#include "message.h"
#include "path.h"
#include "scalar.h"
#include "sweep.h"

#define PROGRAM "pelagos-plot"

enum { OPTICS_BRDF, OPTICS_WATER, SPECTRUM, SURFACE, PICTURE };

static const struct kind {
    const char *name;
    int question;
    const char
        *lines;       /* the axis with a line for each value; --sweep's place */
    const char *axes; /* that the plot has, "" or NULL: none of its own */
} kinds[] = {
    { "rrs", OPTICS_WATER, NULL, "wavelength=400:700:5" },
    { "brdf", OPTICS_BRDF, "sunElevation=15,30,60",
      "viewAzimuth=0,180;viewZenith=0:89:1" },
    { "rose", SPECTRUM, NULL, NULL },
    { "height", SURFACE, NULL, NULL }, /* over --seconds from now on */
    { "rows", PICTURE, NULL, NULL },
};

struct plot {
    const struct kind *kind;
    Pelagos__SeriesQuery *query;
    ProtobufCMessage *question; /* in it, whose numbers NAME=VALUE sets */
    Pelagos__Patch *patch;      /* in it, or NULL: the surface has none */
};

static const struct kind *find_kind(const char *name)
{
    for (size_t i = 0; i < G_N_ELEMENTS(kinds); i++) {
        if (strcmp(kinds[i].name, name) == 0) {
            return &kinds[i];
        }
    }
    return NULL;
}

static ProtobufCMessage *child(ProtobufCMessage *message, const char *name)
{
    return pel_message_child(
        message, pel_field_by_name(message->descriptor, name, strlen(name)));
}

static void begin(struct plot *plot, const struct kind *kind)
{
    static const char *const names[] = { "optics", "optics", "spectrum",
                                         "surface" };
    plot->kind = kind;
    plot->query = (Pelagos__SeriesQuery *)pel_message_new(
        &pelagos__series_query__descriptor);
    plot->question = child(&plot->query->base, names[kind->question]);
    if (kind->question != SURFACE) {
        plot->patch = (Pelagos__Patch *)child(plot->question, "patch");
        child(&plot->patch->base, "state");
    }
    if (kind->question == OPTICS_BRDF || kind->question == OPTICS_WATER) {
        plot->question = child(
            plot->question, kind->question == OPTICS_BRDF ? "brdf" : "water");
    }
    if (kind->question == SPECTRUM) {
        Pelagos__SpectrumQuery *s = plot->query->spectrum;
        s->has_frequencies = s->has_directions = true;
        s->has_lowest = s->has_highest = true;
        s->frequencies = 200;
        s->directions = 72;
        s->lowest = 0.2;
        s->highest = 5;
    }
}

static enum ctl_exit set_number(const struct plot *plot, const char *text)
{
    const char *equals = strchr(text, '=');
    const ProtobufCMessageDescriptor *type = plot->question->descriptor;
    const ProtobufCFieldDescriptor *field =
        equals ? pel_field_by_name(type, text, (size_t)(equals - text)) : NULL;
    if (!field || field->type == PROTOBUF_C_TYPE_MESSAGE ||
        field->label == PROTOBUF_C_LABEL_REPEATED ||
        scalar_parse_number(field, equals + 1,
                            pel_message_member(plot->question, field)) !=
            SCALAR_OK) {
        return ctl_say(CTL_USAGE,
                       "\"%s\" is no number of the question, such as "
                       "sunZenith=40 of rrs (see %s in the manual), nor a "
                       "path of the state with its value, such as "
                       "sea.windSpeed=9",
                       text, type->short_name);
    }
    pel_message_mark(plot->question, field);
    return CTL_DONE;
}

/* NAME=VALUE and PATH=VALUE. */
static enum ctl_exit read_changes(struct ctl *ctl, const struct plot *plot,
                                  const Pelagos__State *now)
{
    enum ctl_exit status = CTL_DONE;
    for (size_t i = 1; i < ctl->arg_count && status == CTL_DONE; i++) {
        const char *text = ctl->args[i];
        g_autofree char *path = NULL;
        if (!memchr(text, '.', strcspn(text, "="))) {
            status = set_number(plot, text);
        } else if (!plot->patch) {
            status = ctl_say(CTL_USAGE,
                             "%s: heights are of the sea in force; change it "
                             "with `pelagosctl set %s`",
                             text, text);
        } else {
            status = ctl_assign(ctl, plot->patch, now, text, &path);
        }
    }
    return status;
}

static enum ctl_exit add_axes(const char *text, Pelagos__SeriesQuery *query)
{
    struct pel_fault fault;
    return text && pel_sweep_parse(text, query, &fault)
               ? ctl_say(CTL_USAGE, "%s", fault.message)
               : CTL_DONE;
}

static enum ctl_exit time_axis(struct ctl *ctl, const Pelagos__State *now,
                               Pelagos__SeriesQuery *query)
{
    double seconds = 600, step = 0.5, at[2] = { 0, 0 };
    const char *place = ctl_value(ctl, "at");
    enum ctl_exit status = ctl_number(ctl, "seconds", 10, 5000, &seconds);
    char text[120], numbers[2][32];
    if (status == CTL_DONE && place) {
        g_auto(GStrv) parts = g_strsplit(place, ",", 2);
        bool right = g_strv_length(parts) == 2 &&
                     ctl_parse_number(parts[0], &at[0]) &&
                     ctl_parse_number(parts[1], &at[1]);
        status =
            right ? CTL_DONE
                  : ctl_say(CTL_USAGE,
                            "--at %s: EAST,NORTH in metres is wanted", place);
    }
    Pelagos__Point *point = (Pelagos__Point *)pel_message_append(
        &query->surface->base,
        pel_field_by_name(query->surface->base.descriptor, "points", 6));
    point->has_east = point->has_north = true;
    point->east = at[0];
    point->north = at[1];
    pel_json_number(now->clock->time, numbers[0]);
    pel_json_number(now->clock->time + seconds, numbers[1]);
    g_snprintf(text, sizeof text, "time=%s:%s:%g", numbers[0], numbers[1],
               step);
    return status == CTL_DONE ? add_axes(text, query) : status;
}

/* The answers as {"series": […]}. */
static enum ctl_exit ask(struct ctl *ctl, const Pelagos__SeriesQuery *query,
                         GString *out)
{
    Pelagos__Series *series = NULL;
    struct pel_client_error error;
    if (pel_client_series(ctl->client, query, &series, &error)) {
        return ctl_report(ctl, &error);
    }
    char *text = pel_json_from_message(&series->base, false);
    g_string_append_printf(out, "%s%s", out->len > 12 ? "," : "", text);
    free(text);
    pelagos__series__free_unpacked(series, NULL);
    return CTL_DONE;
}

static enum ctl_exit ask_numbers(struct ctl *ctl, const struct kind *kind,
                                 GString *out)
{
    Pelagos__State *now = NULL;
    struct plot plot = { 0 };
    enum ctl_exit status = ctl_fetch(ctl, &now);
    if (status != CTL_DONE) {
        return status;
    }
    begin(&plot, kind);
    status = read_changes(ctl, &plot, now);
    if (status == CTL_DONE && kind->question == OPTICS_BRDF) {
        /* The Sun in the south, the eye in its plane. */
        status =
            pel_path_set_number(plot.patch, NULL, "sky.sunAzimuth", 180, NULL)
                ? CTL_FAILED
                : CTL_DONE;
    }
    const char *sweep = ctl_value(ctl, "sweep");
    if (status == CTL_DONE && sweep && !kind->axes) {
        status = ctl_say(CTL_USAGE, "--sweep is for rrs and brdf");
    }
    if (status == CTL_DONE) {
        status = add_axes(sweep ? sweep : kind->lines, plot.query);
    }
    if (status == CTL_DONE) {
        status = add_axes(kind->axes, plot.query);
    }
    if (status == CTL_DONE && kind->question == SURFACE) {
        status = time_axis(ctl, now, plot.query);
    }
    g_string_append(out, "{\"series\": [");
    if (status == CTL_DONE) {
        status = ask(ctl, plot.query, out);
    }
    if (status == CTL_DONE && kind->question == SURFACE) {
        Pelagos__SpectrumQuery whole = PELAGOS__SPECTRUM_QUERY__INIT;
        Pelagos__SeriesQuery also = PELAGOS__SERIES_QUERY__INIT;
        also.question_case = PELAGOS__SERIES_QUERY__QUESTION_SPECTRUM;
        also.spectrum = &whole;
        status = ask(ctl, &also, out);
    }
    g_string_append(out, "]}");
    pelagos__series_query__free_unpacked(plot.query, NULL);
    pelagos__state__free_unpacked(now, NULL);
    return status;
}

static enum ctl_exit ask_picture(struct ctl *ctl, GString *out)
{
    const char *view = ctl_value(ctl, "view");
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    Pelagos__Frame *frame = NULL;
    struct pel_client_error error;
    if (ctl->arg_count > 1 || ctl_flag(ctl, "sweep")) {
        return ctl_say(CTL_USAGE, "rows are of the scene as it is: --view NAME "
                                  "says of which view");
    }
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    request.view = (char *)(view ? view : "bridge");
    request.has_format = true;
    request.format = PELAGOS__FRAME_FORMAT__EXR;
    if (pel_client_frame(ctl->client, &request, &frame, &error)) {
        return ctl_report(ctl, &error);
    }
    g_string_append_len(out, (const char *)frame->data.data,
                        (gssize)frame->data.len);
    pelagos__frame__free_unpacked(frame, NULL);
    return CTL_DONE;
}

static enum ctl_exit draw(const char *kind, const char *file,
                          const GString *data)
{
    g_autofree char *program = ctl_beside(PROGRAM);
    g_autoptr(GError) error = NULL;
    g_autoptr(GBytes) input = g_bytes_new_static(data->str, data->len);
    if (!program) {
        return ctl_say(CTL_FAILED,
                       PROGRAM " is not installed: apt install python3-pelagos "
                               "python3-matplotlib (or pip install pelagos "
                               "matplotlib)");
    }
    g_autoptr(GSubprocess) process = g_subprocess_new(
        G_SUBPROCESS_FLAGS_STDIN_PIPE, &error, program, kind, file, NULL);
    if (!process ||
        !g_subprocess_communicate(process, input, NULL, NULL, NULL, &error)) {
        return ctl_say(CTL_FAILED, "%s: %s", program,
                       error ? error->message : "it failed");
    }
    /* What is wrong it has said itself. */
    return g_subprocess_get_successful(process) ? CTL_DONE : CTL_FAILED;
}

enum ctl_exit ctl_plot(struct ctl *ctl)
{
    const struct kind *kind = find_kind(ctl->args[0]);
    const char *file = ctl_value(ctl, "output");
    if (!kind) {
        return ctl_say(CTL_USAGE, "a plot of what? rrs, brdf, rose, height, "
                                  "rows; see `pelagosctl plot --help`");
    }
    if (!file ||
        !(g_str_has_suffix(file, ".svg") || g_str_has_suffix(file, ".png"))) {
        return ctl_say(CTL_USAGE, "--output FILE is wanted, an .svg or a .png");
    }
    g_autoptr(GString) data = g_string_new(NULL);
    enum ctl_exit status = kind->question == PICTURE
                               ? ask_picture(ctl, data)
                               : ask_numbers(ctl, kind, data);
    return status == CTL_DONE ? draw(kind->name, file, data) : status;
}
