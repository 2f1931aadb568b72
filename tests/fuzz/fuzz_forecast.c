/* Weather as pelagos-weather reads it. A first byte N: a NetCDF file that the
 * text behind it describes, through the reader and over the wire to the daemon,
 * which takes what the reader gives. K: how a field calls itself, T: its
 * time, F: a file as it is, GRIB too. */
#include <math.h>
#include <stdio.h>

#include "fuzz_file.h"
#include "fuzz_kept.h"
#include "weather/wire.h"

#define malloc(n) fuzz_keep(malloc(n))
#define calloc(n, s) fuzz_keep(calloc(n, s))
#define free(p) fuzz_drop(p)
#include "weather/reader/forecast.c" /* NOLINT(bugprone-suspicious-include) */
#undef malloc
#undef calloc
#undef free

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

/* As pelagos-weather writes it, to the daemon. */
static void hand_over(const struct pel_weather_grid *grid)
{
    const struct pel_weather *w = NULL;
    struct pel_fault fault = { 0 };
    char *bytes = NULL;
    size_t size = 0;
    FILE *to = open_memstream(&bytes, &size);
    demand(to != NULL && pel_weather_wire_write(grid, to) && fclose(to) == 0);
    /* Or it has a reason that its fields do not suffice. */
    if (pel_weather_wire_read((unsigned char *)bytes, size, &w, &fault)) {
        demand(fault.code != PEL_ERR_MALFORMED && fault.message[0] != '\0');
    } else {
        pel_weather_unref(w);
    }
    free(bytes);
}

static void read_file(const char *path)
{
    struct pel_weather_grid grid;
    struct pel_fault fault = { 0 };
    if (pel_forecast_read(path, &grid, &fault)) {
        demand(fault.message[0] != '\0');
    } else {
        hand_over(&grid);
    }
    fuzz_release();
}

/* variable|standard|discipline|category|number|paramId; the variable is tried
 * as a unit, too. */
static void name_kind(char *text)
{
    struct pel_forecast_kind kind;
    struct pel_forecast_name name = { .parameter = { -1, -1, -1 } };
    const char *part[6] = { NULL };
    for (int i = 0; i < 6 && text; i++) {
        part[i] = strsep(&text, "|");
    }
    name.variable = part[0];
    name.standard = part[1] && *part[1] ? part[1] : NULL;
    for (int i = 0; i < 3; i++) {
        name.parameter[i] = part[2 + i] ? strtol(part[2 + i], NULL, 10) : -1;
    }
    name.id = part[5] ? strtol(part[5], NULL, 10) : -1;
    if (pel_forecast_kind_of(&name, &kind)) {
        demand((unsigned)kind.number < PEL_FORECAST_NUMBERS &&
               kind.factor != 0 && pel_forecast_name_of(kind.number));
    }
    for (int q = PEL_CF_MPS; part[0] && q <= PEL_CF_DEG; q++) {
        double factor = 0;
        if (pel_cf_unit(part[0], (enum pel_cf_quantity)q, &factor)) {
            demand(factor >= 0);
        }
    }
}

/* value units|calendar */
static void name_time(char *text)
{
    struct pel_fault fault;
    double unix_s = 0, value = strtod(text, &text);
    const char *units = strsep(&text, "|");
    if (!pel_cf_time(units + (*units == ' '), text, value, &unix_s, &fault)) {
        demand(isfinite(unix_s));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static bool prepared;
    const char *places[PEL_FORECAST_MOST_PLACES + 1];
    if (!prepared) {
        pel_forecast_prepare(places);
        prepared = true;
    }
    if (size == 0) {
        return 0;
    }
    char *text = strndup((const char *)data + 1, size - 1);
    const char *path = NULL;
    demand(text != NULL);
    if (data[0] == 'N') {
        path = fuzz_netcdf(data + 1, size - 1, NC_CLOBBER);
    } else if (data[0] == 'F') {
        path = fuzz_file(data + 1, size - 1);
    } else if (data[0] == 'K') {
        name_kind(text);
    } else {
        name_time(text);
    }
    free(text);
    if (path) {
        read_file(path);
    }
    return 0;
}
