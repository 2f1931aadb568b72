/* The commands that ask for pictures and for the sea surface. */
#include "pelagosctl/ctl.h"

#include <errno.h>
#include <string.h>

#include <glib.h>

#include "proto/formats.h"

/* The format by --format or by the file's ending. */
static enum ctl_exit find_format(const struct ctl *ctl, const char *path,
                                 Pelagos__FrameFormat *out)
{
    const char *named = ctl_value(ctl, "format");
    const struct pel_format *format =
        named ? pel_format_by_ending(named) : pel_format_by_path(path);
    if (!format) {
        return ctl_say(CTL_USAGE,
                       "%s: the ending says the format: %s (or --format)", path,
                       pel_format_endings);
    }
    *out = format->format;
    return CTL_DONE;
}

static enum ctl_exit set_size(const struct ctl *ctl,
                              Pelagos__FrameRequest *request)
{
    double width = 0, height = 0, quality = 90, time_s = 0;
    if (ctl_number(ctl, "width", 1, 65535, &width) ||
        ctl_number(ctl, "height", 1, 65535, &height) ||
        ctl_number(ctl, "quality", 1, 100, &quality) ||
        ctl_number(ctl, "time", 0, 1e9, &time_s)) {
        return CTL_USAGE;
    }
    request->has_width = width > 0;
    request->width = (uint32_t)width;
    request->has_height = height > 0;
    request->height = (uint32_t)height;
    request->has_quality = 1;
    request->quality = (uint32_t)quality;
    request->has_time = ctl_flag(ctl, "time");
    request->time = time_s;
    return CTL_DONE;
}

static enum ctl_exit save(const char *path, const Pelagos__Frame *frame)
{
    bool standard = strcmp(path, "-") == 0;
    FILE *file = standard ? stdout : fopen(path, "wb");
    if (!file) {
        return ctl_say(CTL_FAILED, "%s: %s", path, strerror(errno));
    }
    bool whole =
        fwrite(frame->data.data, 1, frame->data.len, file) == frame->data.len;
    if ((standard ? fflush(file) : fclose(file)) != 0 || !whole) {
        return ctl_say(CTL_FAILED, "%s: %s", path, strerror(errno));
    }
    return CTL_DONE;
}

static void describe(FILE *out, const char *path, const Pelagos__Frame *frame,
                     bool json)
{
    if (json) {
        fputs("{\"file\":", out);
        ctl_print_string(out, path);
        fputs(",\"view\":", out);
        ctl_print_string(out, frame->view ? frame->view : "");
        fprintf(out,
                ",\"number\":%llu,\"revision\":%llu,\"time\":%.17g,"
                "\"width\":%u,\"height\":%u,\"bytes\":%zu,"
                "\"renderMs\":%.3f,\"encodeMs\":%.3f}\n",
                (unsigned long long)frame->number,
                (unsigned long long)frame->revision, frame->time, frame->width,
                frame->height, frame->data.len, frame->render_ms,
                frame->encode_ms);
        return;
    }
    fprintf(out,
            "%s: %s %ux%u at %.3f s, %zu kB, drawn in %.1f ms, encoded in "
            "%.1f ms\n",
            path, frame->view ? frame->view : "?", frame->width, frame->height,
            frame->time, (frame->data.len + 999) / 1000, frame->render_ms,
            frame->encode_ms);
}

static enum ctl_exit keep(const struct ctl *ctl, const char *path,
                          const Pelagos__Frame *frame)
{
    enum ctl_exit status = save(path, frame);
    if (status == CTL_DONE && !ctl_flag(ctl, "quiet")) {
        FILE *out = strcmp(path, "-") == 0 ? stderr : stdout;
        describe(out, path, frame, ctl_flag(ctl, "json"));
    }
    return status;
}

/* Several views of one frame; each is saved with its name for %s. */
static enum ctl_exit save_set(struct ctl *ctl, const char *path,
                              const Pelagos__FrameRequest *each)
{
    g_auto(GStrv) place = g_strsplit(path, "%s", 3);
    if (g_strv_length(place) != 2) {
        return ctl_say(CTL_USAGE,
                       "%s: several views need %%s in FILE, once, where their "
                       "names go",
                       path);
    }
    g_auto(GStrv) names = g_strsplit(each->view, ",", -1);
    size_t count = g_strv_length(names);
    g_autofree Pelagos__FrameRequest *requests =
        g_new(Pelagos__FrameRequest, count);
    g_autofree Pelagos__FrameRequest **list =
        g_new(Pelagos__FrameRequest *, count);
    Pelagos__FramesRequest set = PELAGOS__FRAMES_REQUEST__INIT;
    for (size_t i = 0; i < count; i++) {
        requests[i] = *each;
        requests[i].view = names[i];
        requests[i].has_time = 0;
        list[i] = &requests[i];
    }
    set.frames = list;
    set.n_frames = count;
    set.has_time = each->has_time;
    set.time = each->time;
    Pelagos__Frames *frames = NULL;
    struct pel_client_error error;
    if (pel_client_frames(ctl->client, &set, &frames, &error)) {
        return ctl_report(ctl, &error);
    }
    enum ctl_exit status = CTL_DONE;
    for (size_t i = 0; i < count && status == CTL_DONE; i++) {
        g_autofree char *file = g_strconcat(place[0], names[i], place[1], NULL);
        status = keep(ctl, file, frames->frames[i]);
    }
    pelagos__frames__free_unpacked(frames, NULL);
    return status;
}

enum ctl_exit ctl_frame(struct ctl *ctl)
{
    const char *path = ctl->args[1];
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    request.has_format = 1;
    request.view = (char *)ctl->args[0];
    enum ctl_exit status = find_format(ctl, path, &request.format);
    if (status == CTL_DONE) {
        status = set_size(ctl, &request);
    }
    if (status == CTL_DONE) {
        status = ctl_connect(ctl);
    }
    if (status != CTL_DONE) {
        return status;
    }
    g_auto(GStrv) layers = NULL;
    if (ctl_value(ctl, "layers")) {
        layers = g_strsplit(ctl_value(ctl, "layers"), ",", -1);
        request.layers = layers;
        request.n_layers = g_strv_length(layers);
    }
    request.has_float_samples = request.float_samples = ctl_flag(ctl, "float");
    request.has_debrief = request.debrief = ctl_flag(ctl, "debrief");
    if (request.debrief && strchr(request.view, ',')) {
        return ctl_say(CTL_USAGE, "--debrief is for one view at a time");
    }
    if (strchr(request.view, ',')) {
        return save_set(ctl, path, &request);
    }
    Pelagos__Frame *frame = NULL;
    struct pel_client_error error;
    if (pel_client_frame(ctl->client, &request, &frame, &error)) {
        return ctl_report(ctl, &error);
    }
    status = keep(ctl, path, frame);
    pelagos__frame__free_unpacked(frame, NULL);
    return status;
}

/* What is known as text, else `none`. */
static void metres(bool known, double value, const char *format,
                   const char *none, char out[32])
{
    if (known) {
        g_snprintf(out, 32, format, value);
    } else {
        g_strlcpy(out, none, 32);
    }
}

static void print_points(const Pelagos__Surface *surface,
                         const double (*points)[2],
                         const struct pel_client_sea *sea)
{
    printf("# at %.3f s\n%12s %12s %9s  %23s  %23s %9s %9s%s%s\n",
           surface->time, "east m", "north m", "height m",
           "normal east, north, up", "velocity m/s", "depth m", "sounding",
           sea->acceleration ? "       acceleration m/s2" : "",
           sea->foam ? "   foam" : "");
    for (size_t i = 0; i < surface->n_points; i++) {
        const Pelagos__SurfacePoint *p = surface->points[i];
        char depth[32], sounding[32];
        metres(p->has_depth, p->depth, "%.2f", "-", depth);
        metres(p->has_sounding, p->sounding, "%.2f", "-", sounding);
        printf("%12.3f %12.3f %9.4f  %7.4f %7.4f %7.4f  %7.3f %7.3f %7.3f "
               "%9s %9s",
               points[i][0], points[i][1], p->height, p->normal->east,
               p->normal->north, p->normal->up, p->velocity->east,
               p->velocity->north, p->velocity->up, depth, sounding);
        if (sea->acceleration) {
            printf(" %7.3f %7.3f %7.3f", p->acceleration->east,
                   p->acceleration->north, p->acceleration->up);
        }
        if (sea->foam) {
            printf(" %6.4f", p->foam);
        }
        putchar('\n');
    }
}

static void print_vector(const char *name, const Pelagos__Vector *v)
{
    printf(",\"%s\":[%.17g,%.17g,%.17g]", name, v->east, v->north, v->up);
}

static void print_points_json(const Pelagos__Surface *surface,
                              const double (*points)[2],
                              const struct pel_client_sea *sea)
{
    printf("{\"time\":%.17g,\"points\":[", surface->time);
    for (size_t i = 0; i < surface->n_points; i++) {
        const Pelagos__SurfacePoint *p = surface->points[i];
        char depth[32], sounding[32];
        metres(p->has_depth, p->depth, "%.17g", "null", depth);
        metres(p->has_sounding, p->sounding, "%.17g", "null", sounding);
        printf("%s\n{\"east\":%.17g,\"north\":%.17g,\"height\":%.17g",
               i ? "," : "", points[i][0], points[i][1], p->height);
        print_vector("normal", p->normal);
        print_vector("velocity", p->velocity);
        if (sea->acceleration) {
            print_vector("acceleration", p->acceleration);
        }
        if (sea->foam) {
            printf(",\"foam\":%.17g", p->foam);
        }
        printf(",\"depth\":%s,\"sounding\":%s}", depth, sounding);
    }
    puts("]}");
}

/* Whether every point came with what was asked for. */
static bool is_whole(const Pelagos__Surface *surface,
                     const struct pel_client_sea *sea)
{
    for (size_t i = 0; i < surface->n_points; i++) {
        const Pelagos__SurfacePoint *p = surface->points[i];
        if (!p->normal || !p->velocity ||
            (sea->acceleration && !p->acceleration) ||
            (sea->foam && !p->has_foam)) {
            return false;
        }
    }
    return true;
}

/* The options: which sea is asked for. */
static bool read_sea(struct ctl *ctl, double *time_s,
                     struct pel_client_sea *sea)
{
    double frame = 0;
    if (ctl_number(ctl, "time", 0, 1e9, time_s) ||
        ctl_number(ctl, "frame", 1, 9007199254740992.0, &frame)) {
        return false;
    }
    *sea = (struct pel_client_sea){
        .time_s = ctl_flag(ctl, "time") ? time_s : NULL,
        .frame = (uint64_t)frame,
        .acceleration = ctl_flag(ctl, "acceleration"),
        .foam = ctl_flag(ctl, "foam"),
    };
    return true;
}

/* --sweep: the points at many times. */
static enum ctl_exit surface_series(struct ctl *ctl, const double (*points)[2],
                                    size_t count,
                                    const struct pel_client_sea *sea)
{
    Pelagos__SeriesQuery series = PELAGOS__SERIES_QUERY__INIT;
    Pelagos__SurfaceQuery query = PELAGOS__SURFACE_QUERY__INIT;
    g_autofree Pelagos__Point *all = g_new(Pelagos__Point, count);
    g_autofree Pelagos__Point **list = g_new(Pelagos__Point *, count);
    for (size_t i = 0; i < count; i++) {
        pelagos__point__init(&all[i]);
        all[i].has_east = all[i].has_north = true;
        all[i].east = points[i][0];
        all[i].north = points[i][1];
        list[i] = &all[i];
    }
    query.points = list;
    query.n_points = count;
    query.has_time = sea->time_s != NULL;
    query.time = sea->time_s ? *sea->time_s : 0;
    query.has_frame = sea->frame != 0;
    query.frame = sea->frame;
    query.has_acceleration = query.has_foam = true;
    query.acceleration = sea->acceleration;
    query.foam = sea->foam;
    series.question_case = PELAGOS__SERIES_QUERY__QUESTION_SURFACE;
    series.surface = &query;
    return ctl_series(ctl, &series);
}

enum ctl_exit ctl_surface(struct ctl *ctl)
{
    size_t count = ctl->arg_count / 2;
    if (ctl->arg_count % 2 != 0) {
        return ctl_say(CTL_USAGE, "points are pairs: EAST NORTH, in metres");
    }
    double time_s = 0;
    struct pel_client_sea sea;
    if (!read_sea(ctl, &time_s, &sea)) {
        return CTL_USAGE;
    }
    g_autofree double(*points)[2] = g_malloc_n(count, sizeof *points);
    for (size_t i = 0; i < ctl->arg_count; i++) {
        if (!ctl_parse_number(ctl->args[i], &points[i / 2][i % 2])) {
            return ctl_say(CTL_USAGE, "\"%s\" is not a number of metres",
                           ctl->args[i]);
        }
    }
    enum ctl_exit status = ctl_connect(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    if (ctl_wants_series(ctl)) {
        return surface_series(ctl, (const double(*)[2])points, count, &sea);
    }
    Pelagos__Surface *surface = NULL;
    struct pel_client_error error;
    if (pel_client_surface(ctl->client, (const double(*)[2])points, count, &sea,
                           &surface, &error)) {
        return ctl_report(ctl, &error);
    }
    if (!is_whole(surface, &sea)) {
        status =
            ctl_say(CTL_UNREACHABLE, "the answer lacks what was asked for");
    } else if (ctl_flag(ctl, "json")) {
        print_points_json(surface, (const double(*)[2])points, &sea);
    } else {
        print_points(surface, (const double(*)[2])points, &sea);
    }
    pelagos__surface__free_unpacked(surface, NULL);
    return status;
}
