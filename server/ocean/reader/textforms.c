/* SWAN's and WAVEWATCH III's text, and NDBC's historical text. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/cf.h"
#include "base/vec.h"
#include "ocean/reader/buoy.h"
#include "ocean/reader/shelf.h"

#define MOST_CELLS (PEL_MEASURED_MOST * PEL_SHELF_DIRECTIONS)

struct text {
    char *bytes;
    const char *p; /* where it is read */
    double frequency[PEL_MEASURED_MOST];
    double to_rad[PEL_SHELF_DIRECTIONS];
    double cells[MOST_CELLS];
    struct pel_place places[PEL_SHELF_STATIONS];
    double times[PEL_SHELF_TIMES];
    int nf, nd, place_count, time_count;
};

static enum pel_err bad(const struct text *t, const char *what,
                        struct pel_fault *fault)
{
    int line = 1;
    for (const char *p = t->bytes; p < t->p; p++) {
        line += *p == '\n';
    }
    return pel_fault_set(fault, PEL_ERR_MALFORMED, "line %d: %s", line, what);
}

static struct text *open_text(const char *path, struct pel_fault *fault)
{
    struct text *t = calloc(1, sizeof *t);
    t = t && (t->bytes = pel_shelf_text(path)) ? t : NULL;
    if (!t) {
        pel_fault_set(fault, PEL_ERR_MALFORMED,
                      "it is no text that can be read");
        return NULL; /* the process ends with it */
    }
    t->p = t->bytes;
    return t;
}

static const char *line_end(const char *p)
{
    const char *end = strchr(p, '\n');
    return end ? end + 1 : p + strlen(p);
}

static void skip_space(struct text *t)
{
    while (isspace((unsigned char)*t->p)) {
        t->p++;
    }
}

static bool number(struct text *t, double *out)
{
    char *end;
    skip_space(t);
    *out = strtod(t->p, &end);
    if (end == t->p) {
        return false;
    }
    t->p = end;
    return true;
}

static bool numbers(struct text *t, double *out, int count)
{
    for (int i = 0; i < count; i++) {
        if (!number(t, &out[i])) {
            return false;
        }
    }
    return true;
}

static bool word(struct text *t, const char *what)
{
    size_t length = strlen(what);
    skip_space(t);
    if (strncmp(t->p, what, length) != 0) {
        return false;
    }
    t->p = line_end(t->p);
    return true;
}

/* A count behind which the line is a comment. */
static bool count_of(struct text *t, int most, int *out)
{
    double v;
    if (!number(t, &v) || !(v >= 1 && v <= most) || v != floor(v)) {
        return false;
    }
    t->p = line_end(t->p);
    *out = (int)v;
    return true;
}

/* "20161011.120000" or "20220912 060000"; NAN: no time. */
static double stamp(struct text *t)
{
    int y, m, d, hour, minute, second, used = 0;
    skip_space(t);
    if (sscanf(t->p, "%4d%2d%2d%*[. ]%2d%2d%2d%n", &y, &m, &d, &hour, &minute,
               &second, &used) != 6 ||
        used < 15) {
        return NAN;
    }
    t->p = line_end(t->p);
    return pel_shelf_unix(y, m, d, 3600.0 * hour + 60.0 * minute + second);
}

/* --- SWAN ------------------------------------------------------------------
 */

/* The name behind the coordinates, without its quotes. */
static void place_name(const char *p, char out[64])
{
    while (*p == ' ' || *p == '\t') {
        p++;
    }
    size_t length = strcspn(p, "\r\n");
    length = *p == '$' || *p == '!' ? 0 : length;
    while (length > 0 && isspace((unsigned char)p[length - 1])) {
        length--;
    }
    if (length >= 2 && (*p == '\'' || *p == '"') && p[length - 1] == *p) {
        p++;
        length -= 2;
    }
    while (length > 0 && *p == ' ') {
        p++;
        length--;
    }
    while (length > 0 && p[length - 1] == ' ') {
        length--;
    }
    snprintf(out, 64, "%.*s", (int)length, p);
}

static bool swan_places(struct text *t)
{
    bool degrees = word(t, "LONLAT");
    if ((!degrees && !word(t, "LOCATIONS")) ||
        !count_of(t, PEL_SHELF_STATIONS, &t->place_count)) {
        return false;
    }
    for (int i = 0; i < t->place_count; i++) {
        double xy[2];
        if (!numbers(t, xy, 2)) {
            return false;
        }
        place_name(t->p, t->places[i].name);
        t->p = line_end(t->p);
        t->places[i].longitude = degrees ? xy[0] : NAN;
        t->places[i].latitude = degrees ? xy[1] : NAN;
    }
    return true;
}

static bool swan_axes(struct text *t)
{
    if ((!word(t, "AFREQ") && !word(t, "RFREQ")) ||
        !count_of(t, PEL_MEASURED_MOST, &t->nf) ||
        !numbers(t, t->frequency, t->nf)) {
        return false;
    }
    bool nautical = word(t, "NDIR");
    if ((!nautical && !word(t, "CDIR")) ||
        !count_of(t, PEL_SHELF_DIRECTIONS, &t->nd) ||
        !numbers(t, t->to_rad, t->nd)) {
        return false;
    }
    for (int k = 0; k < t->nd; k++) {
        t->to_rad[k] =
            nautical ? pel_goes_to_rad(t->to_rad[k]) : t->to_rad[k] * PEL_DEG;
    }
    return true;
}

/* "m2/Hz/degr", or of energy "J/m2/Hz/degr", with words behind it. */
static bool swan_unit(struct text *t, bool variance, double *unit)
{
    char word[40];
    struct pel_cf_power power;
    skip_space(t);
    snprintf(word, sizeof word, "%.*s", (int)strcspn(t->p, " \t\r\n"), t->p);
    const char *plain = !variance && strncmp(word, "J/m2", 4) == 0 ? "m2" : "";
    char whole[48];
    snprintf(whole, sizeof whole, "%s%s", plain, word + (*plain ? 4 : 0));
    bool known = pel_cf_product(whole, &power) && power.metres == 2 &&
                 power.seconds == 1 && power.radians == -1;
    if (known) {
        *unit = power.factor / (variance ? 1.0 : 1025.0 * PEL_GRAVITY);
        t->p = line_end(t->p);
    }
    return known;
}

/* One quantity: variance or energy density; *unit makes m²/Hz/rad of it. */
static bool swan_quantity(struct text *t, double *unit, double *exception)
{
    int count;
    if (!word(t, "QUANT") || !count_of(t, 1, &count)) {
        return false;
    }
    bool variance = word(t, "VaDens");
    if (!variance && !word(t, "EnDens")) {
        return false;
    }
    if (!swan_unit(t, variance, unit)) {
        return false;
    }
    if (!number(t, exception)) {
        return false;
    }
    t->p = line_end(t->p);
    return true;
}

/* The density of one place at one time; *has: it has one. */
static bool swan_block(struct text *t, double unit, double exception, bool *has)
{
    int cells = t->nf * t->nd;
    double factor = 0;
    *has = false;
    if (word(t, "NODATA")) {
        return true;
    }
    *has = true;
    if (word(t, "ZERO")) {
        memset(t->cells, 0, (size_t)cells * sizeof *t->cells);
        return true;
    }
    if (!word(t, "FACTOR") || !number(t, &factor) ||
        !numbers(t, t->cells, cells)) {
        return false;
    }
    bool any = false;
    for (int i = 0; i < cells; i++) {
        bool none = t->cells[i] == exception;
        any = any || !none;
        t->cells[i] = none ? 0 : t->cells[i] * factor * unit;
    }
    *has = any;
    return true;
}

/* Whether the header says that times stand before the records. */
static bool swan_head(struct text *t, bool *timed)
{
    if (!word(t, "SWAN")) {
        return false;
    }
    for (;;) {
        skip_space(t);
        if (*t->p != '$') {
            break;
        }
        t->p = line_end(t->p);
    }
    *timed = word(t, "TIME");
    if (*timed) {
        t->p = line_end(t->p); /* the coding option; 1 is read */
    }
    return swan_places(t) && swan_axes(t);
}

enum pel_err pel_read_swan(const char *path, const struct pel_want *want,
                           struct pel_measured *out, double *unix_s,
                           struct pel_fault *fault)
{
    struct text *t = open_text(path, fault);
    double unit, exception;
    bool timed, has;
    if (!t) {
        return PEL_ERR_MALFORMED;
    }
    if (!swan_head(t, &timed) || !swan_quantity(t, &unit, &exception)) {
        return bad(t,
                   "not SWAN's head: places, frequencies, directions, one "
                   "quantity VaDens in m2/Hz/degr or EnDens in J/m2/Hz/degr",
                   fault);
    }
    int place = pel_shelf_place(want, t->places, (size_t)t->place_count, fault);
    if (place < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    /* First the times, then the record: the file is read twice. */
    const char *body = t->p;
    for (int pass = 0, at = 0; pass < 2; pass++) {
        t->p = body;
        for (int i = 0; skip_space(t), *t->p; i++) {
            if (i == PEL_SHELF_TIMES) {
                return bad(t, "too many times", fault);
            }
            t->times[i] = timed ? stamp(t) : 0;
            if (isnan(t->times[i])) {
                return bad(t, "not a time as 20161011.120000", fault);
            }
            for (int k = 0; k < t->place_count; k++) {
                if (!swan_block(t, unit, exception, &has)) {
                    return bad(t, "not a block of densities, or cut short",
                               fault);
                }
                if (pass == 1 && i == at && k == place) {
                    *unix_s = t->times[i];
                    return has ? pel_shelf_collapse(t->frequency, t->nf,
                                                    t->to_rad, t->nd, t->cells,
                                                    out, fault)
                               : pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                                               "the place has no data then");
                }
            }
            t->time_count = i + 1;
        }
        if (pass == 0 && timed) {
            at = pel_shelf_time(want, t->times, (size_t)t->time_count, fault);
        }
        if (at < 0 || t->time_count == 0) {
            return at < 0 ? PEL_ERR_NOT_FOUND : bad(t, "no record", fault);
        }
    }
    return bad(t, "no record", fault);
}

/* --- WAVEWATCH III ---------------------------------------------------------
 */

static bool ww3_head(struct text *t)
{
    double sizes[3];
    if (strncmp(t->p, "'WAVEWATCH III SPECTRA'", 23) != 0) {
        return false;
    }
    t->p += 23;
    if (!numbers(t, sizes, 3) ||
        !(sizes[0] >= 3 && sizes[0] <= PEL_MEASURED_MOST) ||
        !(sizes[1] >= 3 && sizes[1] <= PEL_SHELF_DIRECTIONS) ||
        !(sizes[2] >= 1 && sizes[2] <= PEL_SHELF_STATIONS)) {
        return false;
    }
    t->nf = (int)sizes[0];
    t->nd = (int)sizes[1];
    t->place_count = (int)sizes[2];
    t->p = line_end(t->p);
    if (!numbers(t, t->frequency, t->nf) || !numbers(t, t->to_rad, t->nd)) {
        return false;
    }
    for (int k = 0; k < t->nd; k++) {
        /* Directions waves go to, radians from north, clockwise. */
        t->to_rad[k] = PEL_PI / 2 - t->to_rad[k];
    }
    return true;
}

/* 'NAME ' latitude longitude depth wind direction current direction */
static bool ww3_point(struct text *t, struct pel_place *place)
{
    double v[7];
    skip_space(t);
    const char *end = *t->p == '\'' ? strchr(t->p + 1, '\'') : NULL;
    if (!end || end - t->p > 40) {
        return false;
    }
    int length = (int)(end - t->p) - 1;
    while (length > 0 && t->p[length] == ' ') {
        length--;
    }
    snprintf(place->name, sizeof place->name, "%.*s", length, t->p + 1);
    t->p = end + 1;
    if (!numbers(t, v, 7)) {
        return false;
    }
    place->latitude = v[0];
    place->longitude = v[1];
    return true;
}

enum pel_err pel_read_ww3(const char *path, const struct pel_want *want,
                          struct pel_measured *out, double *unix_s,
                          struct pel_fault *fault)
{
    struct text *t = open_text(path, fault);
    if (!t) {
        return PEL_ERR_MALFORMED;
    }
    if (!ww3_head(t)) {
        return bad(t, "not WAVEWATCH III's head", fault);
    }
    static double turned[MOST_CELLS];
    const char *body = t->p;
    int at = 0, place = 0;
    for (int pass = 0; pass < 2; pass++) {
        t->p = body;
        for (int i = 0; skip_space(t), *t->p; i++) {
            double when = i < PEL_SHELF_TIMES ? stamp(t) : NAN;
            if (isnan(when)) {
                return bad(t, "not a time as 20220912 060000", fault);
            }
            t->times[i] = when;
            for (int k = 0; k < t->place_count; k++) {
                if (!ww3_point(t, &t->places[k]) ||
                    !numbers(t, t->cells, t->nf * t->nd)) {
                    return bad(t, "not a point and its densities, or cut short",
                               fault);
                }
                if (pass == 1 && i == at && k == place) {
                    for (int c = 0; c < t->nf * t->nd; c++) {
                        /* Frequencies run first in the file. */
                        turned[c % t->nf * t->nd + c / t->nf] = t->cells[c];
                    }
                    *unix_s = when;
                    return pel_shelf_collapse(t->frequency, t->nf, t->to_rad,
                                              t->nd, turned, out, fault);
                }
            }
            t->time_count = i + 1;
        }
        place = pel_shelf_place(want, t->places, (size_t)t->place_count, fault);
        at = place < 0
                 ? -1
                 : pel_shelf_time(want, t->times, (size_t)t->time_count, fault);
        if (at < 0) {
            return PEL_ERR_NOT_FOUND;
        }
    }
    return bad(t, "no record", fault);
}

/* --- NDBC's historical text ------------------------------------------------
 */

#define MISSING 900.0

/* "YY MM DD hh" or with "mm"; *minutes: the head has them. */
static bool historical_head(struct text *t, bool *minutes)
{
    const char *end = line_end(t->p);
    t->p += *t->p == '#';
    if (strncmp(t->p, "YYYY", 4) != 0 && strncmp(t->p, "YY ", 3) != 0) {
        return false;
    }
    int words = 0;
    while (t->p < end && *t->p && !isdigit((unsigned char)*t->p) &&
           *t->p != '.') {
        if (isalpha((unsigned char)*t->p) &&
            (words == 0 || isspace((unsigned char)t->p[-1]))) {
            words++;
        }
        t->p++;
    }
    *minutes = words == 5;
    t->nf = 0;
    double v;
    while (skip_space(t), t->p < end && number(t, &v)) {
        if (t->nf == PEL_MEASURED_MOST) {
            return false;
        }
        t->frequency[t->nf++] = v;
    }
    t->p = end;
    return (words == 4 || words == 5) && t->nf >= 3;
}

/* Values of the record `at` of the times (or of the time nearest to the want),
 * each missing one NAN. */
static enum pel_err historical_rows(struct text *t, const struct pel_want *want,
                                    double *values, double *unix_s,
                                    struct pel_fault *fault)
{
    bool minutes;
    if (!historical_head(t, &minutes)) {
        return bad(t, "not a head as #YY MM DD hh mm .0200 .0325 …", fault);
    }
    const char *body = t->p;
    int at = -1;
    for (int pass = 0; pass < 2; pass++) {
        t->p = body;
        for (int i = 0; skip_space(t), *t->p; i++) {
            double v[5] = { 0 };
            if (*t->p == '#') { /* units, as #yr mo dy hr mn */
                t->p = line_end(t->p);
                i--;
                continue;
            }
            const char *row = t->p, *end = line_end(row);
            if (i == PEL_SHELF_TIMES || !numbers(t, v, minutes ? 5 : 4)) {
                return bad(t, "not a date and time", fault);
            }
            v[0] += v[0] < 70 ? 2000 : v[0] < 100 ? 1900 : 0;
            if (!(v[0] >= 0 && v[0] < 1e4 && v[1] >= 0 && v[1] < 100 &&
                  v[2] >= 0 && v[2] < 100)) {
                return bad(t, "not a date and time", fault);
            }
            t->times[i] = pel_shelf_unix((int)v[0], (int)v[1], (int)v[2],
                                         3600.0 * v[3] + 60.0 * v[4]);
            for (int k = 0; k < t->nf; k++) {
                skip_space(t);
                bool none = strncmp(t->p, "MM", 2) == 0;
                t->p += none ? 2 : 0;
                if ((!none && !number(t, &values[k])) || t->p > end) {
                    t->p = row;
                    return bad(t, "fewer values than frequencies", fault);
                }
                values[k] = none || values[k] >= MISSING ? NAN : values[k];
            }
            if (pass == 1 && i == at) {
                *unix_s = t->times[i];
                return PEL_OK;
            }
            t->time_count = i + 1;
        }
        at = pel_shelf_time(want, t->times, (size_t)t->time_count, fault);
        if (at < 0) {
            return PEL_ERR_NOT_FOUND;
        }
    }
    return bad(t, "no record", fault);
}

static const char *const of_letters[] = {
    ['d'] = "mean directions (alpha1)",
    ['i'] = "principal directions (alpha2)",
    ['j'] = "spreads (r1)",
    ['k'] = "spreads (r2)",
};

/* "44025d2019.txt" lies beside the densities of 44025w2019.txt, and its own
 * numbers look like any. */
static enum pel_err check_letter(const char *path, struct pel_fault *fault)
{
    const char *name = strrchr(path, '/');
    name = name ? name + 1 : path;
    size_t stem = strcspn(name, ".");
    if (stem < 6) {
        return PEL_OK;
    }
    for (size_t i = 1; i <= 4; i++) {
        if (!isdigit((unsigned char)name[stem - i])) {
            return PEL_OK;
        }
    }
    int letter = tolower((unsigned char)name[stem - 5]);
    bool moment = letter == 'd' || (letter >= 'i' && letter <= 'k');
    return !moment ? PEL_OK
                   : pel_fault_set(fault, PEL_ERR_INVALID,
                                   "by its name it holds %s, no densities: "
                                   "name %.*sw%.40s, beside which it is read",
                                   of_letters[letter], (int)(stem - 5), name,
                                   name + stem - 4);
}

/* Beside 41010w2019.txt: d alpha1, i alpha2, j r1, k r2. */
static bool beside(const char *path, char letter, char out[4096])
{
    snprintf(out, 4096, "%s", path);
    char *w = pel_shelf_letter(out);
    if (!w) {
        return false;
    }
    *w = *w == 'W' ? (char)toupper((unsigned char)letter) : letter;
    FILE *f = fopen(out, "rb");
    if (f) {
        fclose(f);
    }
    return f != NULL;
}

/* All four or none: one alone is no reason to do without the others. */
static enum pel_err has_directions(const char *path, bool *out,
                                   struct pel_fault *fault)
{
    char other[4096], has = 0, lacks = 0;
    for (const char *letter = "dijk"; *letter; letter++) {
        bool there = beside(path, *letter, other);
        has = there ? *letter : has;
        lacks = there ? lacks : *letter;
    }
    *out = !lacks;
    return !has || !lacks
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                               "beside it lies the file of '%c' (%s), and "
                               "that of '%c' (%s) does not: fetch it, or take "
                               "the other away",
                               has, of_letters[(int)has], lacks,
                               of_letters[(int)lacks]);
}

static int count_of_value(const double *density, int count, double v)
{
    int same = 0;
    for (int k = 0; k < count; k++) {
        same += density[k] == v;
    }
    return same;
}

/* Whether a density stands for none: nines that several bands have. */
static bool is_fill(const double *density, int count, double v)
{
    bool nines = v == 9.99 || v == 99 || v == 99.9 || v == 99.99;
    return nines && count_of_value(density, count, v) >= 3;
}

/* A sea has no spectrum that is flat, files of other things may be. */
static enum pel_err check_flat(const double *density, int count,
                               struct pel_fault *fault)
{
    double v = density[0];
    return v > 0 && !is_fill(density, count, v) &&
                   count_of_value(density, count, v) == count
               ? pel_fault_set(fault, PEL_ERR_INVALID,
                               "all of its %d bands are %g: a fill value, or "
                               "no densities; choose another measuredTime or "
                               "file",
                               count, v)
               : PEL_OK;
}

/* Files of months and years have r1 and r2 in hundredths, others as they are
 * (NDBC, "Measurement descriptions and units"). */
static double moment_unit(const double *r1, const double *r2, int count)
{
    for (int k = 0; k < count; k++) {
        if (r1[k] > 1.5 || r2[k] > 1.5) { /* false for NAN */
            return 0.01;
        }
    }
    return 1;
}

enum pel_err pel_read_historical(const char *path, const struct pel_want *want,
                                 struct pel_measured *out, double *unix_s,
                                 struct pel_fault *fault)
{
    static double v[5][PEL_MEASURED_MOST];
    char other[4096];
    bool directional = false;
    enum pel_err err = check_letter(path, fault);
    err = err ? err : has_directions(path, &directional, fault);
    if (err) {
        return err;
    }
    struct text *t = open_text(path, fault);
    err = t ? historical_rows(t, want, v[0], unix_s, fault) : PEL_ERR_MALFORMED;
    for (int i = 1; i < 5 && !err && directional; i++) {
        struct pel_want same = { "", *unix_s };
        double when = NAN;
        struct text *o =
            beside(path, "wdijk"[i], other) ? open_text(other, fault) : NULL;
        err = o ? historical_rows(o, &same, v[i], &when, fault)
                : PEL_ERR_MALFORMED;
        if (!err && (when != *unix_s || o->nf != t->nf)) {
            err =
                pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                              "the file of '%c' lacks the record", "wdijk"[i]);
        }
    }
    if (err) {
        return err;
    }
    err = check_flat(v[0], t->nf, fault);
    if (err) {
        return err;
    }
    static struct pel_bands bands;
    double unit = directional ? moment_unit(v[3], v[4], t->nf) : 1;
    pel_bands_init(&bands, t->nf);
    for (int k = 0; k < t->nf; k++) {
        bands.frequency_hz[k] = t->frequency[k];
        bands.density[k] = is_fill(v[0], t->nf, v[0][k]) ? NAN : v[0][k];
        if (directional) {
            bands.alpha1_rad[k] = pel_goes_to_rad(v[1][k]);
            bands.alpha2_rad[k] = pel_goes_to_rad(v[2][k]);
            bands.r1[k] = v[3][k] * unit;
            bands.r2[k] = v[4][k] * unit;
        }
    }
    return pel_bands_take(&bands, out, fault);
}
