/* Weather as pelagos-weather reads it. A first byte N: a NetCDF file that the
 * text behind it describes, through the reader and over the wire to the daemon,
 * which takes what the reader gives. K: how a band calls itself, T: its time,
 * F: a file as it is. */
#include <math.h>
#include <stdio.h>

#include "fuzz_file.h"
#include "fuzz_kept.h"
#include "weather/wire.h"

#include <gdal.h>

static GDALDatasetH open_sets[72];
static size_t open_count;

static GDALDatasetH keep_set(GDALDatasetH set)
{
    if (set && open_count < sizeof open_sets / sizeof *open_sets) {
        open_sets[open_count++] = set;
    }
    return set;
}

#define malloc(n) fuzz_keep(malloc(n))
#define calloc(n, s) fuzz_keep(calloc(n, s))
#define free(p) fuzz_drop(p)
#define GDALOpenEx(a, b, c, d, e) keep_set(GDALOpenEx(a, b, c, d, e))
#include "weather/reader/forecast.c" /* NOLINT(bugprone-suspicious-include) */
#undef malloc
#undef calloc
#undef free
#undef GDALOpenEx

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

/* The wire's head and what comes behind it, as pelagos-weather writes it. */
static void hand_over(const struct pel_weather_grid *grid)
{
    const struct pel_weather *w = NULL;
    struct pel_fault fault = { 0 };
    unsigned char head[PEL_WEATHER_WIRE_HEAD];
    char *bytes = NULL;
    size_t size = 0, times = (size_t)grid->times;
    size_t count = (size_t)grid->columns * (size_t)grid->rows * times;
    FILE *to = open_memstream(&bytes, &size);
    demand(to != NULL);
    pel_weather_wire_head(grid, head);
    demand(fwrite(head, sizeof head, 1, to) == 1 &&
           fwrite(grid->unix_s, sizeof *grid->unix_s, times, to) == times);
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        const int16_t *v = grid->values[n];
        demand(!v || fwrite(v, sizeof *v, count, to) == count);
    }
    demand(fclose(to) == 0);
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
    while (open_count > 0) {
        GDALClose(open_sets[--open_count]);
    }
    fuzz_release();
}

/* element|standard|level|discipline|category|number */
static void name_kind(char *text)
{
    struct pel_forecast_kind kind;
    struct pel_forecast_name name = { .parameter = { -1, -1, -1 } };
    const char *part[6] = { NULL };
    for (int i = 0; i < 6 && text; i++) {
        part[i] = strsep(&text, "|");
    }
    name.element = part[0];
    name.standard = part[1];
    name.level = part[2] && *part[2] ? part[2] : NULL;
    for (int i = 0; i < 3; i++) {
        name.parameter[i] =
            part[3 + i] ? (int)strtol(part[3 + i], NULL, 10) : -1;
    }
    if (pel_forecast_kind_of(&name, &kind)) {
        demand((unsigned)kind.number < PEL_WEATHER_NUMBERS && kind.factor != 0);
    }
}

static void name_time(char *text)
{
    double unix_s = 0, value = strtod(text, &text);
    if (pel_forecast_time(text + (*text == ' '), value, &unix_s)) {
        demand(isfinite(unix_s));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static bool prepared;
    const char *places[PEL_GDAL_MOST_PLACES + 1];
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
