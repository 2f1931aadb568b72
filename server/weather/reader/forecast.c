/* Chooses the fields of a file that count, and makes grids of them. */
#include "weather/reader/forecast.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "seabed/reader/gdal.h"

/* --- what a file hands over -------------------------------------------------
 */

bool pel_forecast_words_full(const struct pel_forecast_words *words)
{
    return strstr(words->text, "…") != NULL;
}

void pel_forecast_words_add(struct pel_forecast_words *words,
                            const char *format, ...)
{
    char word[128];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(word, sizeof word, format, arguments);
    va_end(arguments);
    size_t length = strlen(words->text);
    if (strstr(words->text, word) || pel_forecast_words_full(words)) {
        return;
    }
    bool fits = length + strlen(word) + 8 < sizeof words->text;
    snprintf(words->text + length, sizeof words->text - length, "%s%s",
             length ? ", " : "", fits ? word : "…");
}

void pel_forecast_note(struct pel_forecast_file *file, const char *format, ...)
{
    char note[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(note, sizeof note, format, arguments);
    va_end(arguments);
    size_t length = strlen(file->notes);
    if (!strstr(file->notes, note) &&
        length + strlen(note) + 3 < sizeof file->notes) {
        snprintf(file->notes + length, sizeof file->notes - length, "%s%s",
                 length ? "; " : "", note);
    }
}

enum pel_err pel_forecast_add(struct pel_forecast_file *file,
                              const struct pel_forecast_slice *slice,
                              struct pel_fault *fault)
{
    if (!file->slices) {
        file->slices = calloc(PEL_FORECAST_MOST_SLICES, sizeof *file->slices);
    }
    if (!file->slices) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    if (file->count == PEL_FORECAST_MOST_SLICES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "it has more than %d fields that are read",
                             PEL_FORECAST_MOST_SLICES);
    }
    file->slices[file->count++] = *slice;
    return PEL_OK;
}

/* --- which of them count ----------------------------------------------------
 */

#define CONTROL 16

/* The order among fields of one number: a single run before an ensemble's
 * control, then the least rank. */
static int key_of(const struct pel_forecast_slice *s)
{
    return s->kind.rank + (s->control ? CONTROL : 0);
}

static bool has_key(const struct pel_forecast_file *file, int number, int key)
{
    for (size_t i = 0; i < file->count; i++) {
        if (file->slices[i].kind.number == number &&
            key_of(&file->slices[i]) == key) {
            return true;
        }
    }
    return false;
}

#define MOST_KEYS (2 * CONTROL)

/* The least key of a number, and of its partner too, where it has one; -1:
 * none. */
static int best_key(const struct pel_forecast_file *file, int number,
                    int partner)
{
    for (int key = 0; key < MOST_KEYS; key++) {
        if (has_key(file, number, key) && has_key(file, partner, key)) {
            return key;
        }
    }
    return -1;
}

static bool same_axis(const struct pel_forecast_axis *a,
                      const struct pel_forecast_axis *b, double turn)
{
    double off = fabs(a->first - b->first);
    off = turn > 0 ? fabs(remainder(off, turn)) : off;
    double allowed = 1e-3 * a->step;
    return a->count == b->count && off <= allowed &&
           fabs(a->step - b->step) * a->count <= allowed;
}

static bool same_grid(const struct pel_forecast_slice *a,
                      const struct pel_forecast_slice *b)
{
    return same_axis(&a->x, &b->x, 360) && same_axis(&a->y, &b->y, 0);
}

static const char *describe_grid(const struct pel_forecast_slice *s,
                                 char out[72])
{
    snprintf(out, 72, "%d × %d from %.6g, %.6g by %.4g°", s->x.count,
             s->y.count, s->y.first, s->x.first, s->x.step);
    return out;
}

/* Numbers of one grid and times: the wind's, or the waves'. */
struct group {
    int numbers[PEL_FORECAST_NUMBERS], keys[PEL_FORECAST_NUMBERS];
    size_t count;
    const struct pel_forecast_slice *first; /* whose grid is that of all */
    double *times;
    int time_count;
};

static enum pel_err join(const struct pel_forecast_file *file, struct group *g,
                         int number, int key, struct pel_fault *fault)
{
    char a[72], b[72];
    for (size_t i = 0; i < file->count; i++) {
        const struct pel_forecast_slice *s = &file->slices[i];
        if (s->kind.number != number || key_of(s) != key) {
            continue;
        }
        g->first = g->first ? g->first : s;
        if (!same_grid(g->first, s)) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "%s is on another grid (%s) than %s (%s): "
                                 "bring both to one, as by cdo remapbil",
                                 s->label, describe_grid(s, a), g->first->label,
                                 describe_grid(g->first, b));
        }
    }
    g->numbers[g->count] = number;
    g->keys[g->count++] = key;
    return g->first ? PEL_OK
                    : pel_fault_set(fault, PEL_ERR_INTERNAL, "it has no %s",
                                    pel_forecast_name_of(number));
}

static int by_time(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* Times of the group's first number, which its others must have too. */
static enum pel_err find_times(const struct pel_forecast_file *file,
                               struct group *g, struct pel_fault *fault)
{
    size_t n = 0;
    double *times = calloc(file->count + 1, sizeof *times);
    if (!times) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (size_t i = 0; i < file->count; i++) {
        const struct pel_forecast_slice *s = &file->slices[i];
        if (s->kind.number == g->numbers[0] && key_of(s) == g->keys[0]) {
            times[n++] = s->unix_s;
        }
    }
    qsort(times, n, sizeof *times, by_time);
    size_t kept = n > 0;
    for (size_t i = 1; i < n; i++) {
        if (times[i] > times[kept - 1]) {
            times[kept++] = times[i];
        }
    }
    if (kept > PEL_WEATHER_MOST_TIMES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "it has %zu times; at most %d", kept,
                             PEL_WEATHER_MOST_TIMES);
    }
    g->times = times;
    g->time_count = (int)kept;
    return PEL_OK;
}

/* Whether the file has the number only as what was refused. */
static bool was_refused(const struct pel_forecast_file *file, int number,
                        struct pel_fault *fault)
{
    bool only = file->was_refused[number] && best_key(file, number, number) < 0;
    if (only && fault) {
        *fault = file->refused[number];
    }
    return only;
}

static enum pel_err lacks(const struct pel_forecast_file *file,
                          const char *what, struct pel_fault *fault)
{
    const char *unread = file->unread.text;
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "it has no %s%s%s; %s shows all", what,
                         *unread ? "; not read: " : "", unread, file->shown_by);
}

/* Wind by its components, else by speed and direction. */
static enum pel_err choose_wind(const struct pel_forecast_file *file,
                                struct group *g, struct pel_fault *fault)
{
    static const int pairs[][2] = {
        { PEL_WEATHER_WIND_EAST, PEL_WEATHER_WIND_NORTH },
        { PEL_FORECAST_SPEED, PEL_FORECAST_WIND_WAY },
    };
    for (size_t i = 0; i < 2; i++) {
        int key = best_key(file, pairs[i][0], pairs[i][1]);
        if (key >= 0) {
            enum pel_err err = join(file, g, pairs[i][0], key, fault);
            err = err ? err : join(file, g, pairs[i][1], key, fault);
            return err ? err : find_times(file, g, fault);
        }
    }
    static const int all[] = { PEL_WEATHER_WIND_EAST, PEL_WEATHER_WIND_NORTH,
                               PEL_FORECAST_SPEED, PEL_FORECAST_WIND_WAY };
    for (size_t i = 0; i < 4; i++) {
        if (was_refused(file, all[i], fault)) {
            return PEL_ERR_INVALID;
        }
    }
    bool east =
        best_key(file, PEL_WEATHER_WIND_EAST, PEL_WEATHER_WIND_EAST) >= 0;
    bool north =
        best_key(file, PEL_WEATHER_WIND_NORTH, PEL_WEATHER_WIND_NORTH) >= 0;
    return lacks(file,
                 north  ? pel_forecast_name_of(PEL_WEATHER_WIND_EAST)
                 : east ? pel_forecast_name_of(PEL_WEATHER_WIND_NORTH)
                        : "wind 10 m above the sea at instants of one run or "
                          "the control (UGRD, VGRD; u10, v10)",
                 fault);
}

/* Waves are whole or not there; parts that are not whole are left out. */
static enum pel_err choose_waves(struct pel_forecast_file *file,
                                 struct group *g, struct pel_fault *fault)
{
    int keys[PEL_WEATHER_NUMBERS];
    bool any = false, parts = true, some_part = false;
    enum pel_err err = PEL_OK;
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        keys[n] = best_key(file, n, n);
        bool wave = PEL_WEATHER_WAVES & 1u << n;
        bool part = PEL_WEATHER_PARTS & 1u << n;
        any = any || (wave && (keys[n] >= 0 || was_refused(file, n, NULL)));
        parts = parts && (!part || keys[n] >= 0);
        some_part = some_part || (part && keys[n] >= 0);
    }
    unsigned wanted =
        !any ? 0 : PEL_WEATHER_WAVES | (parts ? PEL_WEATHER_PARTS : 0);
    for (int n = 0; !err && n < PEL_WEATHER_NUMBERS; n++) {
        if ((wanted & 1u << n) && was_refused(file, n, fault)) {
            return PEL_ERR_INVALID;
        }
        if ((wanted & 1u << n) && keys[n] < 0) {
            return lacks(file, pel_forecast_name_of(n), fault);
        }
        if (wanted & 1u << n) {
            err = join(file, g, n, keys[n], fault);
        }
    }
    if (some_part && !(any && parts)) {
        pel_forecast_note(file, "wind sea and swell apart are left out: height "
                                "of the one, period and direction of the other "
                                "go together");
    }
    return err || !any ? err : find_times(file, g, fault);
}

/* --- their numbers -----------------------------------------------------------
 */

/* Above all that was measured over the sea, and below 99, a usual fill. */
#define MOST_WIND 98

/* What a number may be, before it is said to be a mistake of the file. */
static bool is_possible(const struct pel_forecast_kind *kind, double v)
{
    switch (kind->quantity) {
    case PEL_CF_MPS:
        return fabs(v) <= MOST_WIND &&
               (kind->number != PEL_FORECAST_SPEED || v >= 0);
    case PEL_CF_DEG:
        return fabs(v) <= 720;
    case PEL_CF_HZ:
        return v >= 0;
    default:
        return v >= -0.1 && v <= 31.9;
    }
}

static double ours(const struct pel_forecast_kind *kind, double v)
{
    switch (kind->quantity) {
    case PEL_CF_DEG:
        return remainder(v * kind->factor + kind->offset, 360) * (M_PI / 180);
    case PEL_CF_HZ:
        return v > 0 ? 1 / v : NAN;
    case PEL_CF_MPS:
        return v;
    default:
        return fmax(v * kind->factor, 0);
    }
}

static enum pel_err refuse_fill(const struct pel_forecast_file *file,
                                const struct pel_forecast_slice *s,
                                double value, const char *why,
                                struct pel_fault *fault)
{
    char at[32], cure[112];
    file->declare(file, s, value, cure);
    return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                         "%s (%.30s) at %s has %g, %s: a fill value that is "
                         "not declared? %s",
                         pel_forecast_name_of(s->kind.number), s->label,
                         pel_cf_when(s->unix_s, at), value, why, cure);
}

/* A field in our units, NAN where there is none. */
static enum pel_err read_slice(struct pel_forecast_file *file,
                               const struct pel_forecast_slice *s,
                               double *plane, struct pel_fault *fault)
{
    char at[32];
    size_t nodes = (size_t)s->x.count * (size_t)s->y.count;
    double odd;
    size_t count;
    enum pel_err err = file->read(file, s, plane, fault);
    if (!err &&
        pel_forecast_find_fill(s->kind.quantity, plane, nodes, &odd, &count)) {
        snprintf(at, sizeof at, "far from all, %zu ×", count);
        return refuse_fill(file, s, odd, at, fault);
    }
    for (size_t i = 0; !err && i < nodes; i++) {
        double v = plane[i];
        if (isnan(v)) {
            continue;
        }
        if (!is_possible(&s->kind, v)) {
            return refuse_fill(file, s, v, "which cannot be", fault);
        }
        plane[i] = ours(&s->kind, v);
        if (s->kind.quantity == PEL_CF_HZ && plane[i] > 31.9) {
            return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                                 "%s (%s) at %s has a period of %g s, which "
                                 "cannot be",
                                 pel_forecast_name_of(s->kind.number), s->label,
                                 pel_cf_when(s->unix_s, at), plane[i]);
        }
    }
    if (!err && s->kind.remark) {
        pel_forecast_note(file, "%s", s->kind.remark);
    }
    return err;
}

static bool same_values(const double *a, const double *b, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (isnan(a[i]) != isnan(b[i]) || fabs(a[i] - b[i]) > 0.05) {
            return false;
        }
    }
    return true;
}

static const struct pel_forecast_slice *find(const struct pel_forecast_file *f,
                                             const struct group *g, size_t k,
                                             double unix_s, double run_s)
{
    for (size_t i = 0; i < f->count; i++) {
        const struct pel_forecast_slice *s = &f->slices[i];
        if (s->kind.number == g->numbers[k] && key_of(s) == g->keys[k] &&
            s->unix_s == unix_s && (isnan(run_s) || s->run_s == run_s)) {
            return s;
        }
    }
    return NULL;
}

/* The newest run that has all of a group's numbers at a time: a wind whose
 * components are of two runs is of neither. */
static enum pel_err find_run(struct pel_forecast_file *file,
                             const struct group *g, double unix_s, double *run,
                             struct pel_fault *fault)
{
    char at[32];
    bool found = false, several = false;
    const struct pel_forecast_slice *any =
        find(file, g, 0, unix_s, (double)NAN);
    for (size_t k = 0; k < g->count; k++) {
        if (!find(file, g, k, unix_s, (double)NAN)) {
            return pel_fault_set(fault, PEL_ERR_INVALID, "it has no %s at %s",
                                 pel_forecast_name_of(g->numbers[k]),
                                 pel_cf_when(unix_s, at));
        }
    }
    for (size_t i = 0; i < file->count; i++) {
        const struct pel_forecast_slice *s = &file->slices[i];
        if (s->kind.number != g->numbers[0] || key_of(s) != g->keys[0] ||
            s->unix_s != unix_s) {
            continue;
        }
        several = several || s->run_s != any->run_s;
        bool whole = !found || s->run_s > *run;
        for (size_t k = 1; whole && k < g->count; k++) {
            whole = find(file, g, k, unix_s, s->run_s) != NULL;
        }
        *run = whole ? s->run_s : *run;
        found = found || whole;
    }
    if (several) {
        pel_forecast_note(file, "of times that several runs have, the newest "
                                "run's are taken");
    }
    return found ? PEL_OK
                 : pel_fault_set(fault, PEL_ERR_INVALID,
                                 "at %s no run has all of: %s and what goes "
                                 "with it; keep one run's fields, as by "
                                 "grib_copy -w dataTime=0 IN OUT",
                                 pel_cf_when(unix_s, at),
                                 pel_forecast_name_of(g->numbers[0]));
}

/* A group's number at a time of a run, whose fields of it must be the same.
 * `planes`: room for two. */
static enum pel_err read_at(struct pel_forecast_file *file,
                            const struct group *g, size_t k, double unix_s,
                            double run_s, double *planes,
                            struct pel_fault *fault)
{
    char at[32], run[32];
    size_t nodes = (size_t)g->first->x.count * (size_t)g->first->y.count;
    const struct pel_forecast_slice *best = find(file, g, k, unix_s, run_s);
    if (!best) {
        return pel_fault_set(fault, PEL_ERR_INTERNAL, "it has no %s",
                             pel_forecast_name_of(g->numbers[k]));
    }
    enum pel_err err = read_slice(file, best, planes, fault);
    for (size_t i = (size_t)(best - file->slices) + 1; !err && i < file->count;
         i++) {
        const struct pel_forecast_slice *s = &file->slices[i];
        if (s->kind.number != g->numbers[k] || key_of(s) != g->keys[k] ||
            s->unix_s != unix_s || s->run_s != best->run_s) {
            continue;
        }
        err = read_slice(file, s, planes + nodes, fault);
        if (!err && !same_values(planes, planes + nodes, nodes)) {
            return pel_fault_set(
                fault, PEL_ERR_INVALID,
                "at %s it has two different fields of one run (%s): %s and "
                "%s; keep one",
                pel_cf_when(unix_s, at),
                best->run_s > -PEL_CF_MOST_UNIX_S
                    ? pel_cf_when(best->run_s, run)
                    : "of no date",
                best->label, s->label);
        }
    }
    return err;
}

static enum pel_err place_grid(const struct group *g,
                               struct pel_weather_grid *out,
                               struct pel_fault *fault)
{
    const struct pel_forecast_axis *x = &g->first->x, *y = &g->first->y;
    out->columns = x->count;
    out->rows = y->count;
    out->times = g->time_count;
    out->unix_s = g->times;
    out->west_deg = x->first - (x->first > 360 ? 360 : 0);
    out->east_step = x->step;
    out->south_deg = y->first;
    out->north_step = y->step;
    /* Rounded single precision, as files have it. */
    if (fabs(out->south_deg + 90) < 1e-3) {
        out->south_deg = -90;
    }
    double north = out->south_deg + (out->rows - 1) * out->north_step;
    if (fabs(north - 90) < 1e-3) {
        out->north_step = (90 - out->south_deg) / (out->rows - 1);
    }
    if (out->columns > PEL_WEATHER_MOST_COLUMNS ||
        out->rows > PEL_WEATHER_MOST_ROWS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d nodes; at most %d × %d", out->columns,
                             out->rows, PEL_WEATHER_MOST_COLUMNS,
                             PEL_WEATHER_MOST_ROWS);
    }
    return PEL_OK;
}

static size_t values_of(const struct group *g)
{
    return g->count * (size_t)g->time_count * (size_t)g->first->x.count *
           (size_t)g->first->y.count;
}

/* The wind's components from its speed and the way that it goes. */
static void keep_polar(const double *speeds, const double *ways, size_t nodes,
                       int16_t *east, int16_t *north)
{
    for (size_t i = 0; i < nodes; i++) {
        /* Calm has no direction. */
        double way = speeds[i] == 0 && isnan(ways[i]) ? 0 : ways[i];
        east[i] =
            pel_weather_quantise(PEL_WEATHER_WIND_EAST, speeds[i] * cos(way));
        north[i] =
            pel_weather_quantise(PEL_WEATHER_WIND_NORTH, speeds[i] * sin(way));
    }
}

static enum pel_err read_group(struct pel_forecast_file *file,
                               const struct group *g,
                               struct pel_weather_grid *out,
                               struct pel_fault *fault)
{
    size_t nodes = (size_t)out->columns * (size_t)out->rows;
    bool polar = g->numbers[0] == PEL_FORECAST_SPEED;
    double *planes = calloc((polar ? 4 : 2) * nodes, sizeof *planes);
    int16_t *values[PEL_FORECAST_NUMBERS] = { NULL };
    enum pel_err err =
        planes && g->count >= 2 && out->times > 0 ? PEL_OK : PEL_ERR_NO_MEMORY;
    for (size_t k = 0; !err && k < g->count; k++) {
        int n = polar ? (int)k : g->numbers[k];
        values[k] = malloc(sizeof **values * nodes * (size_t)out->times);
        out->values[n] = values[k];
        err = values[k] ? PEL_OK : PEL_ERR_NO_MEMORY;
    }
    if (err || !planes || !values[0] || !values[1]) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int t = 0; !err && t < out->times; t++) {
        size_t from = nodes * (size_t)t;
        double run = NAN;
        err = find_run(file, g, out->unix_s[t], &run, fault);
        for (size_t k = 0; !err && k < g->count; k++) {
            double *plane = planes + (polar && k == 1 ? 2 * nodes : 0);
            err = read_at(file, g, k, out->unix_s[t], run, plane, fault);
            for (size_t i = 0; !err && !polar && i < nodes; i++) {
                values[k][from + i] = pel_weather_quantise(
                    (enum pel_weather_number)g->numbers[k], plane[i]);
            }
        }
        if (!err && polar) {
            keep_polar(planes, planes + 2 * nodes, nodes, values[0] + from,
                       values[1] + from);
        }
    }
    free(planes);
    return err;
}

/* Waves that have the wind's grid and times share it. */
static bool alike(const struct group *wind, const struct group *waves)
{
    bool same = same_grid(wind->first, waves->first) &&
                wind->time_count == waves->time_count;
    for (int t = 0; same && t < wind->time_count; t++) {
        same = wind->times[t] == waves->times[t];
    }
    return same;
}

static enum pel_err list(const char *path, struct pel_forecast_file *file,
                         struct pel_fault *fault)
{
    bool is_one = false;
    enum pel_err err = pel_forecast_list_netcdf(path, file, &is_one, fault);
    if (!is_one) {
        file->finish(file);
        err = pel_forecast_list_grib(path, file, &is_one, fault);
    }
    return err || is_one ? err
                         : pel_fault_set(fault, PEL_ERR_INVALID,
                                         "no GRIB or NetCDF with grids");
}

static enum pel_err make(struct pel_forecast_file *file, struct group *wind,
                         struct group *waves, struct pel_weather_grid *out,
                         struct pel_fault *fault)
{
    size_t all = values_of(wind) + (waves->first ? values_of(waves) : 0);
    if (all > PEL_WEATHER_MOST_VALUES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%d × %d nodes of %zu numbers at %d times are "
                             "more than %zu: a coarser grid, a smaller region "
                             "or fewer times",
                             wind->first->x.count, wind->first->y.count,
                             wind->count + waves->count, wind->time_count,
                             PEL_WEATHER_MOST_VALUES);
    }
    enum pel_err err = place_grid(wind, out, fault);
    err = err ? err : read_group(file, wind, out, fault);
    if (err || !waves->first) {
        return err;
    }
    struct pel_weather_grid *to = out;
    if (!alike(wind, waves)) {
        to = calloc(1, sizeof *to);
        out->waves = to;
        err = to ? place_grid(waves, to, fault)
                 : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    return err ? err : read_group(file, waves, to, fault);
}

enum pel_err pel_forecast_read(const char *path, struct pel_weather_grid *out,
                               struct pel_fault *fault)
{
    struct pel_forecast_file *file = calloc(1, sizeof *file);
    struct group wind = { .count = 0 }, waves = { .count = 0 };
    *out = (struct pel_weather_grid){ 0 };
    enum pel_err err =
        file ? pel_gdal_check_hdf5(path, fault)
             : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    err = err ? err : list(path, file, fault);
    err = err ? err : choose_wind(file, &wind, fault);
    err = err ? err : choose_waves(file, &waves, fault);
    err = err ? err : make(file, &wind, &waves, out, fault);
    if (!err && *file->unread.text) {
        pel_forecast_note(file, "not read: %s", file->unread.text);
    }
    if (file && file->finish) {
        file->finish(file);
    }
    out->notes = err ? NULL : file->notes;
    return err;
}
