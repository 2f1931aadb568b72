/* The facts of an own ship as CSV, a row a simulated second. A row is made of
 * the moment and of the row before it, whose numbers it reads as they stand
 * there: so a rewind and a restart go on as if nothing had been. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/log.h"
#include "base/vec.h"
#include "scene/exercise_parts.h"
#include "scene/geodesy.h"

#define MOST_BYTES (64u << 20) /* of all own ships */
#define COLUMNS 18             /* before those of targets */
#define TARGET_COLUMNS 5
#define ALL_TARGETS 128 /* of all own ships, whose rows then take 0.4 ms */

enum column {
    TIME,
    CLOCK,
    LATITUDE,
    LONGITUDE,
    HEADING,
    COURSE,
    SPEED,
    SPEED_MAX,
    OVER_LIMIT,
    OVER_LIMIT_S,
    UNDER_KEEL,
    UNDER_KEEL_MIN,
    AGROUND,
    GROUNDINGS,
    COLLISIONS,
    CLOSEST_ID,
    CLOSEST,
    EVENTS,
};

static const char *const names[COLUMNS] = {
    "time_s",         "clock_s",      "latitude_deg", "longitude_deg",
    "heading_deg",    "course_deg",   "speed_mps",    "speed_max_mps",
    "over_limit_mps", "over_limit_s", "under_keel_m", "under_keel_min_m",
    "aground",        "groundings",   "collisions",   "closest_id",
    "closest_m",      "events",
};

struct pel_exercise_sheet {
    uint32_t ship;
    size_t most; /* bytes */
    char *path;  /* NULL: they are not kept */
    int fd;      /* -1: nor now */
    GString *text;
    GArray *rows; /* of struct row */
    uint32_t targets[PEL_EXERCISE_TARGETS];
    size_t target_count, most_targets;
    bool full;
};

struct row {
    double time_s;
    size_t at; /* in the text */
};

/* --- the text ------------------------------------------------------------- */

static void add_target(struct pel_exercise_sheet *f, uint32_t id)
{
    size_t i = 0;
    while (i < f->target_count && f->targets[i] < id) {
        i++;
    }
    if (id == f->ship || f->target_count == f->most_targets ||
        (i < f->target_count && f->targets[i] == id)) {
        return;
    }
    memmove(&f->targets[i + 1], &f->targets[i],
            (f->target_count - i) * sizeof *f->targets);
    f->targets[i] = id;
    f->target_count++;
}

static void add_targets(struct pel_exercise_sheet *f,
                        const Pelagos__State *state)
{
    for (size_t i = 0; state && i < state->n_entities; i++) {
        if (state->entities[i]->has_id) {
            add_target(f, state->entities[i]->id);
        }
    }
}

static void write_head(struct pel_exercise_sheet *f)
{
    for (int i = 0; i < COLUMNS; i++) {
        g_string_append_printf(f->text, "%s%s", i ? "," : "", names[i]);
    }
    for (size_t i = 0; i < f->target_count; i++) {
        unsigned id = f->targets[i];
        g_string_append_printf(f->text,
                               ",range_%u_m,cpa_%u_m,tcpa_%u_s,hulls_%u_m,"
                               "closest_%u_m",
                               id, id, id, id, id);
    }
    g_string_append_c(f->text, '\n');
}

static void stop_keeping(struct pel_exercise_sheet *f)
{
    pel_warn("EXR-004", "%s: the facts of the exercise are not kept: %s",
             f->path, g_strerror(errno));
    if (f->fd >= 0) {
        close(f->fd);
    }
    f->fd = -1;
}

/* Takes over the rows of the same exercise up to since_s. */
static void take_over(struct pel_exercise_sheet *f, double since_s)
{
    char *old = NULL;
    size_t size = 0, head = f->text->len;
    if (!f->path || since_s < 0 ||
        pel_file_read(f->path, MOST_BYTES, &old, &size, NULL) || size < head ||
        memcmp(old, f->text->str, head) != 0) {
        free(old);
        return;
    }
    for (const char *at = old + head; at < old + size;) {
        const char *end = memchr(at, '\n', (size_t)(old + size - at));
        char *stop;
        double time_s = g_ascii_strtod(at, &stop);
        if (!end || *stop != ',' || time_s > since_s) {
            break;
        }
        struct row row = { time_s, f->text->len };
        g_array_append_val(f->rows, row);
        g_string_append_len(f->text, at, end + 1 - at);
        at = end + 1;
    }
    free(old);
}

static void begin_file(struct pel_exercise_sheet *f)
{
    f->fd = f->path ? open(f->path,
                           O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC |
                               O_NOCTTY | O_NONBLOCK,
                           0640)
                    : -1;
    if (f->path &&
        (f->fd < 0 || !pel_file_write(f->fd, f->text->str, f->text->len))) {
        stop_keeping(f);
    }
}

struct pel_exercise_sheet *
pel_exercise_sheet_create(const Pelagos__Exercise *exercise, size_t ship,
                          const char *path, double since_s)
{
    struct pel_exercise_sheet *f = g_new0(struct pel_exercise_sheet, 1);
    f->ship = pel_exercise_ship(exercise, ship);
    f->most = MOST_BYTES / pel_exercise_ship_count(exercise);
    f->most_targets = MIN(PEL_EXERCISE_TARGETS,
                          ALL_TARGETS / pel_exercise_ship_count(exercise));
    f->path = g_strdup(path);
    f->text = g_string_new(NULL);
    f->rows = g_array_new(FALSE, FALSE, sizeof(struct row));
    for (size_t i = 0; i < pel_exercise_ship_count(exercise); i++) {
        add_target(f, pel_exercise_ship(exercise, i));
    }
    add_targets(f, exercise->state);
    for (size_t i = 0; i < exercise->n_events; i++) {
        add_targets(f, exercise->events[i]->patch->state);
    }
    write_head(f);
    take_over(f, since_s);
    begin_file(f);
    return f;
}

void pel_exercise_sheet_destroy(struct pel_exercise_sheet *f)
{
    if (f) {
        if (f->fd >= 0) {
            close(f->fd);
        }
        g_array_free(f->rows, TRUE);
        g_string_free(f->text, TRUE);
        g_free(f->path);
        g_free(f);
    }
}

void pel_exercise_sheet_cut(struct pel_exercise_sheet *f, double time_s)
{
    guint keep = f->rows->len;
    while (keep > 0 &&
           g_array_index(f->rows, struct row, keep - 1).time_s > time_s) {
        keep--;
    }
    if (keep == f->rows->len) {
        return;
    }
    size_t size = g_array_index(f->rows, struct row, keep).at;
    g_array_set_size(f->rows, keep);
    g_string_truncate(f->text, size);
    f->full = false;
    if (f->fd >= 0 && ftruncate(f->fd, (off_t)size) != 0) {
        stop_keeping(f);
    }
}

char *pel_exercise_sheet_text(const struct pel_exercise_sheet *f, double time_s,
                              size_t most, double *more)
{
    guint first = 0, end;
    while (first < f->rows->len &&
           g_array_index(f->rows, struct row, first).time_s < time_s) {
        first++;
    }
    size_t from = time_s <= 0 ? 0
                  : first < f->rows->len
                      ? g_array_index(f->rows, struct row, first).at
                      : f->text->len;
    size_t to = f->text->len;
    *more = NAN;
    for (end = first; end < f->rows->len; end++) {
        const struct row *row = &g_array_index(f->rows, struct row, end);
        if (end > first && row->at - from > most) {
            const struct row *last =
                &g_array_index(f->rows, struct row, end - 1);
            to = last->at > from ? last->at : row->at;
            *more = last->at > from ? last->time_s : row->time_s;
            break;
        }
    }
    return g_strndup(f->text->str + from, to - from);
}

size_t pel_exercise_sheet_bytes(const struct pel_exercise_sheet *f)
{
    return f->text->len;
}

/* --- a row ---------------------------------------------------------------- */

/* The cells of the row before; NULL: there is none. */
static char **last_row(const struct pel_exercise_sheet *f)
{
    if (f->rows->len == 0) {
        return NULL;
    }
    size_t at = g_array_index(f->rows, struct row, f->rows->len - 1).at;
    g_autofree char *line = g_strndup(f->text->str + at, f->text->len - at - 1);
    return g_strsplit(line, ",", 0);
}

/* A number of the row before, or `none`. */
static double before(char **cells, size_t column, double none)
{
    return cells && *cells[column] ? g_ascii_strtod(cells[column], NULL) : none;
}

void pel_exercise_sheet_glance(const struct pel_exercise_sheet *f,
                               struct pel_exercise_glance *out)
{
    char **cells = last_row(f);
    out->facts = f->rows->len;
    out->groundings = (uint32_t)before(cells, GROUNDINGS, 0);
    out->collisions = (uint32_t)before(cells, COLLISIONS, 0);
    g_strfreev(cells);
}

static double rounded(double value, int decimals)
{
    double scale = decimals == 7 ? 1e7 : decimals == 3 ? 1e3 : 1;
    value = round(value * scale) / scale;
    return value == 0 ? 0 : value; /* no -0 */
}

static void put(struct pel_exercise_sheet *f, double value, int decimals)
{
    char text[G_ASCII_DTOSTR_BUF_SIZE], format[8];
    g_snprintf(format, sizeof format, "%%.%df", decimals);
    if (isfinite(value)) {
        g_string_append(f->text, g_ascii_formatd(text, sizeof text, format,
                                                 rounded(value, decimals)));
    }
    g_string_append_c(f->text, ',');
}

static double true_degrees(const struct pel_exercise_moment *m,
                           const struct pel_exercise_body *b, double local_rad)
{
    const struct pel_snapshot *s = m->snapshot;
    double turned = pel_geo_convergence(s->origin_latitude_rad / PEL_DEG,
                                        s->origin_longitude_rad / PEL_DEG,
                                        b->latitude, b->longitude);
    return rounded(pel_bearing_deg((local_rad - turned) / PEL_DEG, 3), 3);
}

static double over_limit(const struct pel_exercise_moment *m, uint32_t ship,
                         const struct pel_exercise_body *own)
{
    double over = 0;
    for (size_t i = 0; i < m->exercise->n_limits; i++) {
        const Pelagos__ExerciseLimit *limit = m->exercise->limits[i];
        bool meant = !limit->has_ship || limit->ship == ship;
        if (meant &&
            pel_exercise_in_area(limit->area, own->latitude, own->longitude)) {
            over = fmax(over, own->speed_mps - limit->speed);
        }
    }
    return rounded(over, 3);
}

/* What the distances to targets come to. */
struct nearness {
    double closest_m;
    uint32_t closest_id;
    unsigned collisions; /* begun in this row */
};

/* The cells of targets. */
static void look_around(struct pel_exercise_sheet *f,
                        struct pel_exercise_moment *m,
                        const struct pel_exercise_body *own, char **cells,
                        struct nearness *near)
{
    for (size_t i = 0; i < f->target_count; i++) {
        size_t column = COLUMNS + TARGET_COLUMNS * i;
        const struct pel_exercise_body *b =
            own ? pel_exercise_body_of(m, f->targets[i]) : NULL;
        double range = NAN, cpa = NAN, tcpa = NAN, hulls = NAN;
        double closest = before(cells, column + 4, INFINITY);
        if (b) {
            range = rounded(pel_exercise_range(own, b), 3);
            pel_exercise_cpa(own, b, &cpa, &tcpa);
            hulls = rounded(pel_exercise_hulls(own, b), 3);
            near->collisions += hulls == 0 && before(cells, column + 3, 1) != 0;
            closest = fmin(closest, range);
        }
        if (closest < near->closest_m) {
            near->closest_m = closest;
            near->closest_id = f->targets[i];
        }
        put(f, range, 3);
        put(f, cpa, 3);
        put(f, tcpa, 3);
        put(f, hulls, 3);
        put(f, closest, 3);
    }
}

/* Names of those that took effect since the row before, with blanks between. */
static void put_events(struct pel_exercise_sheet *f,
                       const struct pel_exercise_moment *m)
{
    double since_s =
        f->rows->len > 0
            ? g_array_index(f->rows, struct row, f->rows->len - 1).time_s
            : -1;
    const char *gap = "";
    for (size_t i = 0; i < m->exercise->n_events; i++) {
        const Pelagos__ExerciseDone *done =
            pel_exercise_done(m->state->exercise, m->exercise->events[i]->name);
        if (done && done->count > 0 && done->time > since_s &&
            done->time <= m->time_s) {
            g_string_append_printf(f->text, "%s%s", gap, done->event);
            gap = " ";
        }
    }
    g_string_append_c(f->text, ',');
}

static void put_own(struct pel_exercise_sheet *f, struct pel_exercise_moment *m,
                    const struct pel_exercise_body *own, char **cells)
{
    double most = before(cells, SPEED_MAX, 0);
    double least = before(cells, UNDER_KEEL_MIN, INFINITY);
    double over_s = before(cells, OVER_LIMIT_S, 0);
    double groundings = before(cells, GROUNDINGS, 0);
    double aground = before(cells, AGROUND, 0), over = NAN, keel = NAN;
    put(f, own ? own->latitude : NAN, 7);
    put(f, own ? own->longitude : NAN, 7);
    put(f, own ? true_degrees(m, own, own->heading_rad) : NAN, 3);
    put(f, own ? true_degrees(m, own, own->course_rad) : NAN, 3);
    put(f, own ? own->speed_mps : NAN, 3);
    if (own) {
        most = fmax(most, rounded(own->speed_mps, 3));
        over = over_limit(m, f->ship, own);
        over_s += over > 0 && cells
                      ? rounded(m->time_s, 3) - before(cells, TIME, 0)
                      : 0;
        keel = rounded(pel_exercise_under_keel(m, own), 3);
        least = fmin(least, keel); /* of a NaN the other */
        groundings += keel <= 0 && aground == 0;
        aground = keel <= 0;
    }
    put(f, most, 3);
    put(f, over, 3);
    put(f, over_s, 3);
    put(f, keel, 3);
    put(f, least, 3);
    put(f, aground, 0);
    put(f, groundings, 0);
}

void pel_exercise_sheet_add(struct pel_exercise_sheet *f,
                            struct pel_exercise_moment *m)
{
    struct row row = { rounded(m->time_s, 3), f->text->len };
    const struct pel_exercise_body *own = pel_exercise_body_of(m, f->ship);
    struct nearness near = { INFINITY, 0, 0 };
    if (f->full || f->text->len > f->most) {
        if (!f->full) {
            pel_warn("EXR-005",
                     "the facts of ship %u end at %.0f s: those of an exercise "
                     "have 64 MiB",
                     f->ship, m->time_s);
        }
        f->full = true;
        return;
    }
    char **cells = last_row(f);
    put(f, m->time_s, 3);
    put(f, m->clock_s, 3);
    put_own(f, m, own, cells);
    GString *line = f->text;
    f->text = g_string_new(NULL);
    look_around(f, m, own, cells, &near);
    GString *targets = f->text;
    f->text = line;
    put(f, before(cells, COLLISIONS, 0) + near.collisions, 0);
    put(f, near.closest_id ? near.closest_id : NAN, 0);
    put(f, near.closest_m, 3);
    put_events(f, m);
    g_string_append_len(f->text, targets->str, (gssize)targets->len);
    g_string_free(targets, TRUE);
    f->text->str[f->text->len - 1] = '\n'; /* the last comma */
    g_strfreev(cells);
    g_array_append_val(f->rows, row);
    if (f->fd >= 0 &&
        !pel_file_write(f->fd, f->text->str + row.at, f->text->len - row.at)) {
        stop_keeping(f);
    }
}
