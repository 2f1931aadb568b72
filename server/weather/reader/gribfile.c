/* GRIB 1 and 2 by ecCodes: which messages are wind and waves of the sea, at one
 * instant, of one run. */
#include <eccodes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "weather/reader/forecast.h"

/* Beyond what any number can be. */
#define MISSING 1e34

static void say_nothing(const codes_context *c, int level, const char *text)
{
    (void)c;
    (void)level;
    (void)text;
}

void pel_forecast_prepare(const char *places[PEL_FORECAST_MOST_PLACES + 1])
{
    static char path[4096];
    codes_context *c = codes_context_get_default();
    char *rest = NULL, *own = codes_definition_path(c);
    size_t count = 0;
    codes_context_set_logging_proc(c, say_nothing);
    /* Its own reading of several fields in one message frees twice what a bad
     * one has: they are taken apart here. */
    codes_grib_multi_support_off(c);
    /* The C library's own name for no file locking: that is a system call
     * which the sandbox has not. */
    setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
    snprintf(path, sizeof path, "%s", own ? own : "");
    for (char *at = strtok_r(path, ":", &rest);
         at && count < PEL_FORECAST_MOST_PLACES;
         at = strtok_r(NULL, ":", &rest)) {
        places[count++] = at;
    }
    places[count] = NULL;
}

/* --- what a message says of itself ---------------------------------------- */

static long number(codes_handle *h, const char *key, long otherwise)
{
    long v = otherwise;
    return codes_get_long(h, key, &v) ? otherwise : v;
}

static const char *word(codes_handle *h, const char *key, char out[40])
{
    size_t size = 40;
    if (codes_get_string(h, key, out, &size)) {
        snprintf(out, 40, "?");
    }
    return out;
}

static void describe(codes_handle *h, char out[48])
{
    char name[40], level[40];
    word(h, "shortName", name);
    word(h, "typeOfLevel", level);
    if (strcmp(level, "unknown") == 0) {
        snprintf(level, sizeof level, "surface type %ld",
                 number(h, "typeOfFirstFixedSurface",
                        number(h, "indicatorOfTypeOfLevel", -1)));
    }
    snprintf(out, 48, "%.12s %.22s %ld", name, level, number(h, "level", 0));
}

enum surface { OTHER, SEA, TEN_METRES, SEQUENCE };

/* GRIB2's code table 4.5. */
static enum surface surface_of_2(codes_handle *h)
{
    long type = number(h, "typeOfFirstFixedSurface", -1);
    long value = number(h, "scaledValueOfFirstFixedSurface", 0);
    double at =
        (double)value *
        pow(10, -(double)number(h, "scaleFactorOfFirstFixedSurface", 0));
    bool is_layer = number(h, "typeOfSecondFixedSurface", 255) != 255;
    if (is_layer) {
        return OTHER;
    }
    switch (type) {
    case 1:
    case 101: /* mean sea level */
        return SEA;
    case 102: /* above mean sea level */
    case 103: /* above the ground */
        return fabs(at - 10) < 1e-6 ? TEN_METRES : at == 0 ? SEA : OTHER;
    case 241: /* ordered sequence */
        return at == 1 ? SEQUENCE : OTHER;
    default:
        return OTHER;
    }
}

/* GRIB1's code table 3. */
static enum surface surface_of_1(codes_handle *h)
{
    long at = number(h, "level", 0);
    switch (number(h, "indicatorOfTypeOfLevel", -1)) {
    case 1:
    case 102:
        /* The ECMWF codes its wind at 10 m so. */
        return SEA;
    case 103:
    case 105:
        return at == 10 ? TEN_METRES : at == 0 ? SEA : OTHER;
    case 241:
        return at == 1 ? SEQUENCE : OTHER;
    default:
        return OTHER;
    }
}

/* Whether it is of the height that its kind needs. Wind that is coded at the
 * surface counts after wind at 10 m, but where it is the ECMWF's own number for
 * wind at 10 m. */
static bool at_its_height(codes_handle *h, long edition, long id,
                          struct pel_forecast_kind *kind)
{
    enum surface s = edition == 1 ? surface_of_1(h) : surface_of_2(h);
    bool ten = id == 165 || id == 166 || id == 207 || id == 260260;
    switch (kind->height) {
    case PEL_FORECAST_AT_10_M:
        if (s == SEA && !ten) {
            kind->rank += 4;
            kind->remark = "wind that is coded at the surface is taken as "
                           "that 10 m above it";
        }
        return s == TEN_METRES || s == SEA;
    case PEL_FORECAST_IN_SEQUENCE:
        kind->rank += s == SEQUENCE ? 4 : 0;
        return s != OTHER;
    default: /* waves have no height, and files any near the surface */
        return s == SEA || s == TEN_METRES;
    }
}

/* The kind of a field that is not of one instant of one run; NULL: it is. */
static const char *other_product(codes_handle *h, long edition, bool *control,
                                 char out[48])
{
    char type[40], data[40], stream[40];
    long template = number(h, "productDefinitionTemplateNumber", 0);
    long made = number(h, "typeOfGeneratingProcess", 2);
    long member = number(h, "perturbationNumber", 0);
    word(h, "stepType", type);
    word(h, "dataType", data);
    word(h, "stream", stream);
    *control = false;
    if (strcmp(type, "instant") != 0 ||
        (edition == 2 && template >= 8 && template <= 14)) {
        snprintf(out, 48, "%.8s over %.12s h",
                 strcmp(type, "instant") ? type : "statistic",
                 word(h, "stepRange", data));
        return out;
    }
    if (strstr(" moda mnth msmm mnfc edmo ewmo wamo wamd edmm ewmm msda mdfc ",
               stream) &&
        strlen(stream) == 4) {
        snprintf(out, 48, "monthly mean (stream %.8s)", stream);
        return out;
    }
    if (edition == 2 && template != 0 && template != 1 && template != 60) {
        snprintf(out, 48, "of template 4.%ld", template);
        return template == 2 || template == 3 || template == 4
                   ? "derived of an ensemble"
               : template == 5 ? "probability"
               : template == 6 ? "percentile"
                               : out;
    }
    if (edition == 2 && (made == 5 || made == 6 || made == 7 || made == 9)) {
        return made == 5   ? "probability"
               : made == 6 ? "forecast error"
               : made == 7 ? "analysis error"
                           : "climatology";
    }
    static const char *const derived[] = { "em",  "es", "ep",  "taem", "taes",
                                           "cl",  "me", "fcm", "fcs",  "eme",
                                           "ses", "ef", "fp" };
    for (size_t i = 0; edition == 1 && i < sizeof derived / sizeof *derived;
         i++) {
        if (strcmp(data, derived[i]) == 0) {
            snprintf(out, 48, "derived of an ensemble (type %.8s)", data);
            return out;
        }
    }
    bool many = (edition == 2 && (template == 1 || template == 60)) ||
                strcmp(data, "pf") == 0 || strcmp(data, "cf") == 0 ||
                number(h, "numberOfForecastsInEnsemble", 0) > 1;
    long drawn = number(h, "typeOfEnsembleForecast", 0);
    bool perturbed =
        edition == 2 && (drawn == 2 || drawn == 3 ||
                         (strcmp(data, "pf") == 0 && drawn != 0 && drawn != 1));
    if (member != 0 || perturbed) {
        snprintf(out, 48, "ensemble member %ld", member);
        return out;
    }
    *control = many;
    return NULL;
}

/* Seconds of a unit of GRIB's code tables 4 (1) and 4.4 (2); 0: of no steady
 * length. */
static double unit_s(long edition, long unit)
{
    switch (unit) {
    case 0:
        return 60;
    case 1:
        return 3600;
    case 2:
        return 86400;
    case 10:
        return 3 * 3600;
    case 11:
        return 6 * 3600;
    case 12:
        return 12 * 3600;
    case 13:
        return edition == 2 ? 1 : 900;
    case 14:
        return edition == 2 ? 0 : 1800;
    case 254:
        return edition == 2 ? 0 : 1;
    default:
        return 0;
    }
}

static bool time_of(codes_handle *h, long edition,
                    struct pel_forecast_slice *slice)
{
    long date = number(h, "dataDate", 0);
    long year = date / 10000, month = date / 100 % 100, day = date % 100;
    long unit = number(
        h, edition == 2 ? "indicatorOfUnitOfTimeRange" : "unitOfTimeRange", -1);
    long range = number(h, "timeRangeIndicator", 0);
    long step = edition == 2 ? number(h, "forecastTime", 0)
                : range == 1 ? 0
                             : number(h, "P1", 0);
    if (edition == 1 && range == 10) {
        step = step << 8 | number(h, "P2", 0);
    }
    double one = unit_s(edition, unit);
    if (year < 1 || year > 9999 || month < 1 || month > 12 || day < 1 ||
        day > 31 || (step != 0 && one == 0)) {
        return false;
    }
    slice->run_s = pel_cf_day_s(year, month, day) +
                   3600.0 * (double)number(h, "hour", 0) +
                   60.0 * (double)number(h, "minute", 0) +
                   (double)(edition == 2 ? number(h, "second", 0) : 0);
    slice->unix_s = slice->run_s + one * (double)step;
    return fabs(slice->unix_s) < PEL_CF_MOST_UNIX_S;
}

/* --- its grid --------------------------------------------------------------
 */

static enum pel_err refuse_grid(codes_handle *h, const char *label,
                                struct pel_fault *fault)
{
    char type[40];
    bool turned = number(h, "uvRelativeToGrid", 0) == 1;
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "%s: its grid is %s; equal steps of latitude and "
                         "longitude (regular_ll) are read: bring it to them, "
                         "as by %s",
                         label, word(h, "gridType", type),
                         turned ? "wgrib2 IN -new_grid_winds earth -new_grid "
                                  "latlon …"
                                : "cdo remapbil,global_0.25 IN OUT");
}

static enum pel_err grid_of(codes_handle *h, const char *label,
                            struct pel_forecast_slice *out,
                            struct pel_fault *fault)
{
    char type[40];
    double a[2], b[2];
    long nx = number(h, "Ni", 0), ny = number(h, "Nj", 0);
    if (strcmp(word(h, "gridType", type), "regular_ll") != 0 ||
        codes_get_double(h, "latitudeOfFirstGridPointInDegrees", &a[1]) ||
        codes_get_double(h, "longitudeOfFirstGridPointInDegrees", &a[0]) ||
        codes_get_double(h, "latitudeOfLastGridPointInDegrees", &b[1]) ||
        codes_get_double(h, "longitudeOfLastGridPointInDegrees", &b[0])) {
        return refuse_grid(h, label, fault);
    }
    if (number(h, "edition", 1) == 2 && number(h, "scanningMode", 0) & 15) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%s: its rows are offset against each other "
                             "(scanning mode %ld): bring it to a plain grid, "
                             "as by cdo remapbil,global_0.25 IN OUT",
                             label, number(h, "scanningMode", 0));
    }
    if (nx < 2 || ny < 2 || nx > PEL_WEATHER_MOST_COLUMNS ||
        ny > PEL_WEATHER_MOST_ROWS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "%ld × %ld nodes; at least 2 × 2, at most %d × %d",
                             nx, ny, PEL_WEATHER_MOST_COLUMNS,
                             PEL_WEATHER_MOST_ROWS);
    }
    bool west = number(h, "iScansNegatively", 0) == 1;
    double first = west ? b[0] : a[0], last = west ? a[0] : b[0];
    last += last < first - 1e-9 ? 360 * ceil((first - last) / 360) : 0;
    out->x =
        (struct pel_forecast_axis){ (int)nx, first,
                                    (last - first) / (double)(nx - 1), west };
    bool north = number(h, "jScansPositively", 0) == 1;
    out->y = (struct pel_forecast_axis){ (int)ny, fmin(a[1], b[1]),
                                         fabs(b[1] - a[1]) / (double)(ny - 1),
                                         !north };
    /* The steps that it tells, rounded as GRIB rounds them (to 0.001°, 1e-6°),
     * must be those. */
    double di = 0, dj = 0;
    bool told = !codes_get_double(h, "iDirectionIncrementInDegrees", &di) &&
                !codes_get_double(h, "jDirectionIncrementInDegrees", &dj) &&
                number(h, "ijDirectionIncrementGiven", 1) == 1 && di > 0 &&
                dj > 0 && di < 360 && dj < 180;
    double allowed = 0.0011 + 0.01 * fmin(out->x.step, out->y.step);
    if (north != (b[1] > a[1]) || !(out->x.step > 0) || !(out->y.step > 0) ||
        (told && (fabs(di - out->x.step) > allowed ||
                  fabs(dj - out->y.step) > allowed))) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "%s: its grid contradicts itself: %ld × %ld nodes from %g, %g to "
            "%g, %g in steps of %g and %g, rows towards the %s",
            label, nx, ny, a[1], a[0], b[1], b[0], dj, di,
            north ? "north" : "south");
    }
    return PEL_OK;
}

/* --- several fields in one message ------------------------------------------
 */

#define SECTIONS 8
#define HEAD 16u /* of GRIB2 */

/* A field's sections by their number; section 6 is the bitmap's. */
struct field {
    const unsigned char *section[SECTIONS];
    size_t size[SECTIONS];
};

/* The sections of the message's `wanted`th field; how many fields there are, 0
 * where its sections are not as they say. */
static size_t walk(const unsigned char *m, size_t size, size_t wanted,
                   struct field *out)
{
    struct field now = { .size = { 0 } };
    const unsigned char *bitmap = NULL;
    size_t count = 0, bitmap_size = 0;
    for (size_t at = HEAD; at + 9 <= size && memcmp(m + at, "7777", 4) != 0;) {
        size_t length = (size_t)m[at] << 24 | (size_t)m[at + 1] << 16 |
                        (size_t)m[at + 2] << 8 | m[at + 3];
        unsigned number = m[at + 4];
        if (number == 0 || number >= SECTIONS || length < 6 ||
            length > size - 4 - at) {
            return 0;
        }
        now.section[number] = m + at;
        now.size[number] = length;
        if (number == 6 && m[at + 5] == 0) {
            bitmap = m + at;
            bitmap_size = length;
        } else if (number == 6 && m[at + 5] == 254 && bitmap) {
            now.section[6] = bitmap; /* that of the field before */
            now.size[6] = bitmap_size;
        }
        if (number == 7 && count++ == wanted) {
            *out = now;
        }
        at += length;
    }
    return count;
}

static size_t fields_in(codes_handle *h)
{
    const void *bytes = NULL;
    size_t size = 0;
    struct field ignored;
    return number(h, "edition", 0) == 2 && !codes_get_message(h, &bytes, &size)
               ? walk(bytes, size, 0, &ignored)
               : 1;
}

/* A message of its own; NULL: it cannot be. */
static codes_handle *field_of(codes_handle *h, size_t wanted)
{
    const void *bytes = NULL;
    size_t size = 0, total = HEAD;
    struct field f = { .size = { 0 } };
    if (codes_get_message(h, &bytes, &size) ||
        walk(bytes, size, wanted, &f) <= wanted) {
        return NULL;
    }
    /* Its sections are not more than the message's, but for one bitmap. */
    unsigned char *own = malloc(2 * size);
    if (!own) {
        return NULL;
    }
    memcpy(own, bytes, HEAD);
    for (size_t n = 1; n < SECTIONS; n++) {
        if (f.section[n]) {
            memcpy(own + total, f.section[n], f.size[n]);
            total += f.size[n];
        }
    }
    memcpy(own + total, "7777", 4);
    total += 4;
    for (size_t i = 0; i < 8; i++) {
        own[8 + i] = (unsigned char)(total >> (56 - 8 * i));
    }
    codes_handle *one = codes_handle_new_from_message_copy(
        codes_context_get_default(), own, total);
    free(own);
    return one;
}

/* --- listing ----------------------------------------------------------------
 */

/* Whether a field of the same number, height and product was told of before. */
static bool was_told(struct pel_forecast_file *file, codes_handle *h)
{
    static const char *const keys[] = {
        "discipline",
        "parameterCategory",
        "parameterNumber",
        "typeOfFirstFixedSurface",
        "scaledValueOfFirstFixedSurface",
        "productDefinitionTemplateNumber",
        "indicatorOfParameter",
        "indicatorOfTypeOfLevel",
        "level",
    };
    long sum = 1;
    bool grib1 = number(h, "edition", 2) == 1;
    for (size_t i = grib1 ? 6 : 0; i < (grib1 ? 9u : 6u); i++) {
        sum = (long)((unsigned long)sum * 1000003u +
                     (unsigned long)number(h, keys[i], -1));
    }
    for (size_t i = 0; i < file->told_count; i++) {
        if (file->told[i] == sum) {
            return true;
        }
    }
    if (file->told_count < sizeof file->told / sizeof *file->told) {
        file->told[file->told_count++] = sum;
    }
    return false;
}

/* ecCodes' names take it long: they are asked for what is kept, or told of. */
static void leave_out(struct pel_forecast_file *file, codes_handle *h,
                      const char *other)
{
    char label[48];
    if (!pel_forecast_words_full(&file->unread) && !was_told(file, h)) {
        describe(h, label);
        pel_forecast_words_add(&file->unread, "%s%s%s", label, other ? " " : "",
                               other ? other : "");
    }
}

static void name_of(codes_handle *h, long edition,
                    struct pel_forecast_name *out)
{
    *out = (struct pel_forecast_name){ .parameter = { -1, -1, -1 }, .id = -1 };
    if (edition == 2) {
        out->parameter[0] = number(h, "discipline", -1);
        out->parameter[1] = number(h, "parameterCategory", -1);
        out->parameter[2] = number(h, "parameterNumber", -1);
    } else {
        out->id = number(h, "paramId", -1);
    }
}

static enum pel_err take(struct pel_forecast_file *file, codes_handle *h,
                         size_t place, size_t part, struct pel_fault *fault)
{
    long edition = number(h, "edition", 0);
    struct pel_forecast_slice slice = { .place = place, .part = part };
    struct pel_forecast_name name;
    char product[48];
    name_of(h, edition, &name);
    if (!pel_forecast_kind_of(&name, &slice.kind)) {
        if ((name.parameter[0] == 10 && name.parameter[1] == 0) ||
            (name.id > 140000 && name.id < 141000)) {
            leave_out(file, h, NULL);
        }
        return PEL_OK;
    }
    if (!at_its_height(h, edition, name.id, &slice.kind)) {
        leave_out(file, h, NULL);
        return PEL_OK;
    }
    const char *other = other_product(h, edition, &slice.control, product);
    if (other) {
        leave_out(file, h, other);
        return PEL_OK;
    }
    describe(h, slice.label);
    if (!time_of(h, edition, &slice)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%s: its time cannot be read: %ld, step %ld in "
                             "unit %ld of GRIB's table",
                             slice.label, number(h, "dataDate", 0),
                             number(h, "forecastTime", number(h, "P1", 0)),
                             number(h, "indicatorOfUnitOfTimeRange",
                                    number(h, "unitOfTimeRange", -1)));
    }
    enum pel_err err = grid_of(h, slice.label, &slice, fault);
    return err ? err : pel_forecast_add(file, &slice, fault);
}

static enum pel_err cut(size_t messages, int why, struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_MALFORMED,
                         "after %zu whole fields the GRIB file is cut or "
                         "damaged (%.80s): fetch it again",
                         messages, codes_get_error_message(why));
}

/* Whether another message begins behind `end`. */
static bool goes_on(FILE *from, long end)
{
    size_t matched = 0;
    int c;
    if (fseek(from, end, SEEK_SET)) {
        return false;
    }
    while (matched < 4 && (c = getc(from)) != EOF) {
        matched = c == "GRIB"[matched] ? matched + 1 : c == 'G';
    }
    return matched == 4;
}

/* Takes the fields of a message, mostly one. */
static enum pel_err take_all(struct pel_forecast_file *file, codes_handle *h,
                             struct pel_fault *fault)
{
    size_t place = (size_t)number(h, "offset", 0), count = fields_in(h);
    enum pel_err err = count > 1 ? PEL_OK : take(file, h, place, 0, fault);
    for (size_t i = 0; count > 1 && !err && i < count; i++) {
        codes_handle *one = field_of(h, i);
        if (!one) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "field %zu of the GRIB message at byte %zu "
                                 "cannot be read",
                                 i + 1, place);
        }
        err = take(file, one, place, i, fault);
        codes_handle_delete(one);
    }
    return err;
}

static enum pel_err list(struct pel_forecast_file *file, FILE *from,
                         bool *is_one, struct pel_fault *fault)
{
    size_t messages = 0;
    long end = 0;
    enum pel_err err = PEL_OK;
    int why = 0;
    for (codes_handle *h;
         !err && (h = codes_handle_new_from_file(codes_context_get_default(),
                                                 from, PRODUCT_GRIB, &why));
         messages++) {
        end = ftell(from);
        err = take_all(file, h, fault);
        codes_handle_delete(h);
    }
    bool fails = why && why != CODES_END_OF_FILE;
    *is_one = messages > 0 || fails || goes_on(from, 0);
    return !err && *is_one && (fails || goes_on(from, end))
               ? cut(messages, fails ? why : CODES_PREMATURE_END_OF_FILE, fault)
               : err;
}

/* --- its numbers ------------------------------------------------------------
 */

/* The scanning mode of a message (GRIB's flag table 3.4), by which a node's
 * value is found: columns from west, rows from south. */
struct scan {
    size_t nx, ny;
    bool west, north, columns, to_and_fro;
};

static size_t place_of(const struct scan *s, size_t x, size_t y)
{
    size_t i = s->west ? s->nx - 1 - x : x;
    size_t j = s->north ? y : s->ny - 1 - y;
    size_t line = s->columns ? i : j, along = s->columns ? j : i;
    size_t length = s->columns ? s->ny : s->nx;
    along = s->to_and_fro && line % 2 == 1 ? length - 1 - along : along;
    return line * length + along;
}

static enum pel_err decode(codes_handle *h,
                           const struct pel_forecast_slice *slice,
                           double *plane, struct pel_fault *fault)
{
    char packing[40];
    const struct scan s = {
        .nx = (size_t)slice->x.count,
        .ny = (size_t)slice->y.count,
        .west = slice->x.falling,
        .north = !slice->y.falling,
        .columns = number(h, "jPointsAreConsecutive", 0) == 1,
        .to_and_fro = number(h, "alternativeRowScanning", 0) == 1,
    };
    size_t count = 0, nodes = s.nx * s.ny;
    double *values = malloc(nodes * sizeof *values);
    if (!values) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    (void)codes_set_double(h, "missingValue", MISSING);
    int why = codes_get_size(h, "values", &count);
    why = why || count != nodes
              ? why ? why : CODES_WRONG_ARRAY_SIZE
              : codes_get_double_array(h, "values", values, &count);
    if (why) {
        free(values);
        return pel_fault_set(
            fault, PEL_ERR_MALFORMED,
            "%s cannot be read (packing %s: %s): grib_set -r -s "
            "packingType=grid_simple IN OUT makes it one that can",
            slice->label, word(h, "packingType", packing),
            codes_get_error_message(why));
    }
    for (size_t y = 0; y < s.ny; y++) {
        for (size_t x = 0; x < s.nx; x++) {
            double v = values[place_of(&s, x, y)];
            plane[y * s.nx + x] = v < MISSING / 2 ? v : NAN;
        }
    }
    free(values);
    return PEL_OK;
}

static enum pel_err read_slice(struct pel_forecast_file *file,
                               const struct pel_forecast_slice *slice,
                               double *plane, struct pel_fault *fault)
{
    int why = 0;
    codes_handle *h =
        fseeko(file->user, (off_t)slice->place, SEEK_SET)
            ? NULL
            : codes_handle_new_from_file(codes_context_get_default(),
                                         file->user, PRODUCT_GRIB, &why);
    codes_handle *one = h && fields_in(h) > 1 ? field_of(h, slice->part) : h;
    enum pel_err err =
        one ? decode(one, slice, plane, fault)
            : pel_fault_set(fault, PEL_ERR_MALFORMED, "%s cannot be read: %s",
                            slice->label, codes_get_error_message(why));
    if (one && one != h) {
        codes_handle_delete(one);
    }
    if (h) {
        codes_handle_delete(h);
    }
    return err;
}

static void declare(const struct pel_forecast_file *file,
                    const struct pel_forecast_slice *slice, double value,
                    char out[112])
{
    double room = 1e-3 * fabs(value);
    (void)file;
    (void)slice;
    snprintf(out, 112, "cdo setrtomiss,%.6g,%.6g IN OUT", value - room,
             value + room);
}

static void finish(struct pel_forecast_file *file)
{
    if (file->user) {
        fclose(file->user);
    }
}

enum pel_err pel_forecast_list_grib(const char *path,
                                    struct pel_forecast_file *out, bool *is_one,
                                    struct pel_fault *fault)
{
    *is_one = false;
    out->user = fopen(path, "rb");
    out->read = read_slice;
    out->declare = declare;
    out->finish = finish;
    out->shown_by = "grib_ls FILE";
    return out->user ? list(out, out->user, is_one, fault) : PEL_OK;
}
