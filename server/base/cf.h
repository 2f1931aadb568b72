/* Units and times as NetCDF files write them (CF conventions, UDUNITS). Pure
 * functions, any thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/err.h"

/* The quantity that a number measures. */
enum pel_cf_quantity {
    PEL_CF_MPS,
    PEL_CF_M,
    PEL_CF_S,
    PEL_CF_HZ,
    PEL_CF_DEG,
};

/* The factor from a unit, as files write it ("m s**-1", "knots", "degree
 * true", "0.01 m", "US survey foot"), to that of the quantity. False: it is
 * unknown, or of another quantity. */
bool pel_cf_unit(const char *unit, enum pel_cf_quantity quantity,
                 double *factor);

/* A unit as powers of metre, second and radian, times a factor: "m2/Hz/degr",
 * "m2 s rad-1". An angle without any unit is none. */
struct pel_cf_power {
    int metres, seconds, radians;
    double factor;
};
bool pel_cf_product(const char *unit, struct pel_cf_power *out);

/* Seconds in a unit of time; 0: it is none of a steady length. */
double pel_cf_unit_s(const char *unit, size_t length);

/* Seconds since 1970 of `value` in CF's "UNIT since TIME" by a calendar (NULL:
 * CF's default, the Julian before 15 October 1582 and the Gregorian after),
 * to the millisecond. INVALID: it is not that; the day is none of ours. */
#define PEL_CF_MOST_UNIX_S 1e11
PEL_CHECK enum pel_err pel_cf_time(const char *units, const char *calendar,
                                   double value, double *unix_s,
                                   struct pel_fault *fault);
/* Seconds since 1970 of a Gregorian day; the year at most 9999 from 0. */
double pel_cf_day_s(long year, long month, long day);
/* "2026-06-21T12:00:00Z". */
const char *pel_cf_when(double unix_s, char out[32]);
