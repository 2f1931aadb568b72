/* Weather from files, for pelagos-weather alone: a process that is thrown away,
 * so memory is freed by its end and files may be as bad as they like. One
 * thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/cf.h"
#include "base/err.h"
#include "weather/weather.h"

/* The numbers of a file: weather.h's, and the wind in its other form. */
enum {
    PEL_FORECAST_SPEED = PEL_WEATHER_NUMBERS, /* of the wind at 10 m, m/s */
    PEL_FORECAST_WIND_WAY,                    /* it blows to, rad from east */
    PEL_FORECAST_NUMBERS
};

/* The surface or height that a number belongs to. */
enum pel_forecast_height {
    PEL_FORECAST_AT_10_M,
    PEL_FORECAST_AT_SEA,
    PEL_FORECAST_IN_SEQUENCE, /* or the first of several swells */
};

/* The description of one field of a file. */
struct pel_forecast_kind {
    int number;
    int rank; /* of several kinds of a number that with the least counts */
    enum pel_cf_quantity quantity; /* of the file's numbers */
    enum pel_forecast_height height;
    double factor; /* from the quantity's unit above to ours; of frequencies to
                    * the period */
    double offset;
    const char *remark; /* what a user should know of it; NULL: nothing */
};

/* The names that a field has for itself; NULL and -1: none. */
struct pel_forecast_name {
    const char *variable; /* NetCDF's */
    const char *standard; /* CF's standard_name; counts before the variable's */
    long parameter[3];    /* GRIB2's discipline, category, number */
    long id;              /* ecCodes' paramId */
};

/* The number that the field holds; false: none of ours. */
bool pel_forecast_kind_of(const struct pel_forecast_name *name,
                          struct pel_forecast_kind *out);
/* The names of a number, for people and in files. */
const char *pel_forecast_name_of(int number);

/* Coordinates of a grid's nodes with equal steps. */
struct pel_forecast_axis {
    int count;
    double first, step; /* the least, > 0 */
    bool falling;       /* the file has them the other way round */
};
/* Fits them to coordinates that may be rounded to the digits with which they
 * are printed, and longitudes that jump by a turn. False: steps are unequal. */
bool pel_forecast_axis_fit(const double *degrees, size_t count, bool longitude,
                           struct pel_forecast_axis *out);

/* Several words with commas between them, each once, as many as have room. */
struct pel_forecast_words {
    char text[100];
};
void pel_forecast_words_add(struct pel_forecast_words *words,
                            const char *format, ...)
    __attribute__((format(printf, 2, 3)));
bool pel_forecast_words_full(const struct pel_forecast_words *words);

/* One of our numbers at one time. */
struct pel_forecast_slice {
    struct pel_forecast_kind kind;
    bool control; /* an ensemble's; else of one run alone */
    double unix_s, run_s;
    struct pel_forecast_axis x, y;
    size_t place, part; /* what its file finds it by */
    char label[48];
};

/* Finds a number that several nodes have to the bit and that is far from all
 * others, as a fill value is which nobody declared. */
bool pel_forecast_find_fill(enum pel_cf_quantity quantity, const double *plane,
                            size_t nodes, double *value, size_t *count);

#define PEL_FORECAST_MOST_SLICES 65536

struct pel_forecast_file {
    struct pel_forecast_slice *slices;
    size_t count;
    struct pel_forecast_words unread; /* wind and waves of other kinds */
    long told[64];                    /* which of them were looked at, hashed */
    size_t told_count;
    /* By number: why a variable was left out that is called as it is, and
     * would be refused were it the only one. */
    struct pel_fault refused[PEL_FORECAST_NUMBERS];
    bool was_refused[PEL_FORECAST_NUMBERS];
    char notes[PEL_WEATHER_MOST_NOTES];
    /* The slice's numbers in its quantity's unit above, rows from south, nodes
     * from west, NAN where there are none. */
    enum pel_err (*read)(struct pel_forecast_file *file,
                         const struct pel_forecast_slice *slice, double *plane,
                         struct pel_fault *fault);
    /* The command that makes the number, in the quantity's unit, none. */
    void (*declare)(const struct pel_forecast_file *file,
                    const struct pel_forecast_slice *slice, double value,
                    char out[112]);
    void (*finish)(struct pel_forecast_file *file);
    const char *shown_by; /* the command that lists its fields */
    void *user;
};

/* Adds a sentence to what the daemon logs, once. */
void pel_forecast_note(struct pel_forecast_file *file, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
PEL_CHECK enum pel_err pel_forecast_add(struct pel_forecast_file *file,
                                        const struct pel_forecast_slice *slice,
                                        struct pel_fault *fault);

/* Lists the file's fields, until out->finish. *is_one false: it is no such
 * file. */
PEL_CHECK enum pel_err pel_forecast_list_grib(const char *path,
                                              struct pel_forecast_file *out,
                                              bool *is_one,
                                              struct pel_fault *fault);
PEL_CHECK enum pel_err pel_forecast_list_netcdf(const char *path,
                                                struct pel_forecast_file *out,
                                                bool *is_one,
                                                struct pel_fault *fault);

#define PEL_FORECAST_MOST_PLACES 8

/* Before the sandbox is closed: where ecCodes' own files lie, NULL-terminated,
 * and no locks and no filters from elsewhere for HDF5. */
void pel_forecast_prepare(const char *places[PEL_FORECAST_MOST_PLACES + 1]);

/* Reads the file; out->waves is set where waves have a grid or times of their
 * own. Values, times and notes are never freed. */
PEL_CHECK enum pel_err pel_forecast_read(const char *path,
                                         struct pel_weather_grid *out,
                                         struct pel_fault *fault);
