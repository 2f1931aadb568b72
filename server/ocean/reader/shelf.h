/* What a file of spectra has, which of it is asked for, and how a density over
 * directions becomes what a buoy would report. For pelagos-spectrum. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"
#include "ocean/sea.h"

#define PEL_SHELF_STATIONS 20000
#define PEL_SHELF_TIMES 200000
#define PEL_SHELF_DIRECTIONS 720

struct pel_place {
    char name[64];              /* "": none */
    double latitude, longitude; /* NAN: unknown */
};

struct pel_want {
    const char *station;
    double unix_s; /* NAN: the newest */
};

/* Index of the record's time; -1 and *fault, which lists those there are. */
int pel_shelf_time(const struct pel_want *want, const double *unix_s,
                   size_t count, struct pel_fault *fault);
/* The same of the place. */
int pel_shelf_place(const struct pel_want *want, const struct pel_place *places,
                    size_t count, struct pel_fault *fault);

/* A density e[i * nd + k] m²/Hz/rad at frequency i and direction k, the
 * mathematical one that waves travel to [rad], in any order. Directions share
 * the circle by their neighbours. Each frequency gets the density over all
 * directions and the first and second moments. Values that are negative or no
 * numbers count 0. OUT_OF_RANGE: too many or too few frequencies, not rising;
 * more than PEL_MEASURED_MOST are refused. */
PEL_CHECK enum pel_err pel_shelf_collapse(const double *frequency_hz, int nf,
                                          const double *to_rad, int nd,
                                          const double *e,
                                          struct pel_measured *out,
                                          struct pel_fault *fault);

/* Checks frequencies: 3..PEL_MEASURED_MOST, rising, 0.005 to 2 Hz; a record's
 * lower ones, to 0.001, are left out by the callers. */
PEL_CHECK enum pel_err pel_shelf_frequencies(const double *frequency_hz, int nf,
                                             struct pel_fault *fault);

/* Seconds since 1970 of a Gregorian date; NAN: there is none. */
double pel_shelf_unix(int year, int month, int day, double seconds);

/* The forms. *unix_s: of the record. */
typedef enum pel_err pel_shelf_form(const char *path,
                                    const struct pel_want *want,
                                    struct pel_measured *out, double *unix_s,
                                    struct pel_fault *fault);
PEL_CHECK pel_shelf_form pel_read_swan;       /* text */
PEL_CHECK pel_shelf_form pel_read_ww3;        /* text */
PEL_CHECK pel_shelf_form pel_read_historical; /* NDBC's, of a year */
PEL_CHECK pel_shelf_form pel_read_netcdf;     /* WW3, SWAN, ERA5, NDBC, CDIP */
PEL_CHECK pel_shelf_form pel_read_datawell;   /* .spt, text */
PEL_CHECK pel_shelf_form pel_read_spotter;    /* Sofar's, JSON */

/* In the path of NDBC's historical text the letter of what it holds, w or W:
 * the last before the year; NULL: there is none. */
char *pel_shelf_letter(char *path);

/* Bytes of a text with a 0 behind them; NULL: it is none, or too long. */
char *pel_shelf_text(const char *path);

/* From standard input to standard output: netcdfwrite.c. */
PEL_CHECK enum pel_err pel_write_netcdf(struct pel_fault *fault);
