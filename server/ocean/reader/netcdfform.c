/* Spectra in NetCDF, by the names and units of their variables: WAVEWATCH III
 * (efth), SWAN (density), ERA5 (d2fd), NDBC (spectral_wave_density), CDIP
 * (waveEnergyDensity), and any with CF's standard_name of such a density. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <netcdf.h>
#include <sys/stat.h>

#include "base/cf.h"
#include "base/vec.h"
#include "ocean/reader/buoy.h"
#include "ocean/reader/shelf.h"

#define MOST_CELLS ((size_t)PEL_MEASURED_MOST * PEL_SHELF_DIRECTIONS)

struct axis {
    int dim; /* -1: none */
    size_t size;
};

struct file {
    int id, density;
    int rank, dims[NC_MAX_VAR_DIMS];
    struct axis time, frequency, direction, station, latitude, longitude;
    bool logarithms; /* ERA5 */
    bool cdip;
    bool radians, periods; /* what its frequencies are in; neither: Hz */
};

static enum pel_err bad(const char *what, struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_MALFORMED, "the NetCDF %s", what);
}

static void attribute(const struct file *f, int var, const char *name,
                      char out[80])
{
    size_t length = 0;
    nc_type type;
    char text[512];
    out[0] = '\0';
    if (nc_inq_att(f->id, var, name, &type, &length) == 0 && type == NC_CHAR &&
        length < sizeof text && nc_get_att_text(f->id, var, name, text) == 0) {
        text[length] = '\0';
        snprintf(out, 80, "%.79s", text);
    }
}

/* Values of a part of a variable, unpacked; what is missing NAN. */
static bool unpacked(const struct file *f, int var, const size_t *start,
                     const size_t *count, size_t cells, double *out)
{
    double scale = 1, offset = 0, fill = NAN, missing = NAN;
    nc_type type;
    if (nc_inq_vartype(f->id, var, &type) || type == NC_CHAR ||
        type >= NC_STRING ||
        nc_get_vara_double(f->id, var, start, count, out)) {
        return false;
    }
    nc_get_att_double(f->id, var, "scale_factor", &scale);
    nc_get_att_double(f->id, var, "add_offset", &offset);
    nc_get_att_double(f->id, var, "_FillValue", &fill);
    nc_get_att_double(f->id, var, "missing_value", &missing);
    for (size_t i = 0; i < cells; i++) {
        out[i] = out[i] == fill || out[i] == missing || fabs(out[i]) > 9e36
                     ? NAN
                     : out[i] * scale + offset;
    }
    return true;
}

/* A variable of one dimension (or none) of this size. */
static bool whole(const struct file *f, const char *name, size_t size,
                  double *out, char units[80])
{
    int var, rank, dims[NC_MAX_VAR_DIMS];
    size_t length = 1, zero = 0;
    if (nc_inq_varid(f->id, name, &var) || nc_inq_varndims(f->id, var, &rank) ||
        rank != 1 || nc_inq_vardimid(f->id, var, dims) ||
        nc_inq_dimlen(f->id, dims[0], &length) || length != size) {
        return false;
    }
    attribute(f, var, "units", units);
    return unpacked(f, var, &zero, &size, size, out);
}

static const char *dim_name(const struct file *f, int dim,
                            char out[NC_MAX_NAME + 1])
{
    return nc_inq_dim(f->id, f->dims[dim], out, NULL) ? "" : out;
}

/* The coordinate of an axis: called like its dimension, or by another of the
 * names. */
static const char *coordinate(const struct file *f, struct axis axis,
                              const char *const *names, double *out,
                              char units[80])
{
    static char name[NC_MAX_NAME + 1];
    if (axis.dim >= 0 &&
        whole(f, dim_name(f, axis.dim, name), axis.size, out, units)) {
        return name;
    }
    for (; *names; names++) {
        if (whole(f, *names, axis.size, out, units)) {
            return *names;
        }
    }
    return NULL;
}

static struct axis axis_of(const struct file *f, const char *const *names)
{
    for (int i = 0; i < f->rank; i++) {
        char name[NC_MAX_NAME + 1];
        size_t size;
        if (nc_inq_dim(f->id, f->dims[i], name, &size)) {
            continue;
        }
        for (const char *const *n = names; *n; n++) {
            if (strcmp(name, *n) == 0) {
                return (struct axis){ i, size };
            }
        }
    }
    return (struct axis){ -1, 1 };
}

static const char *const times[] = { "time", "valid_time", "waveTime", NULL },
                         *const frequencies[] = { "frequency",       "freq",
                                                  "waveFrequency",   "f",
                                                  "frequencyNumber", NULL },
                         *const directions[] = { "direction",       "dir",
                                                 "directions",      "theta",
                                                 "directionNumber", NULL },
                         *const stations[] = { "station", "points", "site",
                                               NULL },
                         *const latitudes[] = { "latitude", "lat", NULL },
                         *const longitudes[] = { "longitude", "lon", NULL };

/* By its name, else by CF's. */
static void find_density(struct file *f)
{
    static const char *const names[] = { "efth", "density", "d2fd",
                                         "spectral_wave_density",
                                         "waveEnergyDensity" };
    static const char *const standards[] = {
        "sea_surface_wave_directional_variance_spectral_density",
        "sea_surface_wave_variance_spectral_density"
    };
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (nc_inq_varid(f->id, names[i], &f->density) == 0) {
            f->logarithms = i == 2;
            f->cdip = i == 4;
            return;
        }
    }
    int count = 0;
    nc_inq_nvars(f->id, &count);
    for (size_t i = 0; i < 2; i++) {
        for (f->density = 0; f->density < count; f->density++) {
            char name[80];
            attribute(f, f->density, "standard_name", name);
            if (strcmp(name, standards[i]) == 0) {
                return;
            }
        }
    }
    f->density = -1;
}

static enum pel_err find(struct file *f, struct pel_fault *fault)
{
    find_density(f);
    if (f->density < 0) {
        return bad("has no efth, density, d2fd, spectral_wave_density or "
                   "waveEnergyDensity",
                   fault);
    }
    if (nc_inq_varndims(f->id, f->density, &f->rank) || f->rank > 6 ||
        nc_inq_vardimid(f->id, f->density, f->dims)) {
        return bad("cannot be read", fault);
    }
    f->time = axis_of(f, times);
    f->frequency = axis_of(f, frequencies);
    f->direction = axis_of(f, directions);
    f->station = axis_of(f, stations);
    f->latitude = axis_of(f, latitudes);
    f->longitude = axis_of(f, longitudes);
    int known = (f->time.dim >= 0) + (f->frequency.dim >= 0) +
                (f->direction.dim >= 0) + (f->station.dim >= 0) +
                (f->latitude.dim >= 0) + (f->longitude.dim >= 0);
    if (f->frequency.dim < 0 || known != f->rank ||
        f->frequency.size > PEL_MEASURED_MOST ||
        f->direction.size > PEL_SHELF_DIRECTIONS ||
        f->time.size > PEL_SHELF_TIMES ||
        f->station.size > PEL_SHELF_STATIONS || f->latitude.size > 10000 ||
        f->longitude.size > 10000 ||
        f->latitude.size * f->longitude.size > PEL_SHELF_STATIONS) {
        return bad("has other dimensions than time, frequency, direction and a "
                   "station or latitude and longitude, or too long ones",
                   fault);
    }
    return PEL_OK;
}

static enum pel_err choose_time(const struct file *f,
                                const struct pel_want *want, size_t *at,
                                double *unix_s, struct pel_fault *fault)
{
    static double when[PEL_SHELF_TIMES];
    char units[80], calendar[80] = "";
    int var;
    const char *name = coordinate(f, f->time, times, when, units);
    if (!name) {
        return bad("has no time", fault);
    }
    if (nc_inq_varid(f->id, name, &var) == 0) {
        attribute(f, var, "calendar", calendar);
    }
    for (size_t i = 0; i < f->time.size; i++) {
        if (isfinite(when[i])) {
            enum pel_err err = pel_cf_time(units, *calendar ? calendar : NULL,
                                           when[i], &when[i], fault);
            if (err) {
                return err;
            }
        }
    }
    int chosen = pel_shelf_time(want, when, f->time.size, fault);
    if (chosen < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    *at = (size_t)chosen;
    *unix_s = when[chosen];
    return PEL_OK;
}

/* Latitude or longitude of the stations, which may vary with time. */
static void positions(const struct file *f, const char *name, double *out)
{
    int var, rank;
    char units[80];
    size_t start[2] = { 0, 0 }, count[2] = { 1, f->station.size };
    if (whole(f, name, f->station.size, out, units)) {
        return;
    }
    bool there = nc_inq_varid(f->id, name, &var) == 0 &&
                 nc_inq_varndims(f->id, var, &rank) == 0 && rank == 2 &&
                 unpacked(f, var, start, count, f->station.size, out);
    for (size_t i = 0; i < f->station.size && !there; i++) {
        out[i] = NAN;
    }
}

static enum pel_err list_places(const struct file *f, struct pel_place *places,
                                size_t *count, struct pel_fault *fault)
{
    static double a[PEL_SHELF_STATIONS], b[PEL_SHELF_STATIONS];
    char units[80];
    if (f->latitude.dim >= 0 && f->longitude.dim >= 0) {
        if (!coordinate(f, f->latitude, latitudes, a, units) ||
            !coordinate(f, f->longitude, longitudes, b, units)) {
            return bad("has no latitude and longitude", fault);
        }
        *count = f->latitude.size * f->longitude.size;
        for (size_t i = 0; i < *count; i++) {
            places[i] = (struct pel_place){ "", a[i / f->longitude.size],
                                            b[i % f->longitude.size] };
        }
        return PEL_OK;
    }
    *count = f->station.size;
    positions(f, "latitude", a);
    positions(f, "longitude", b);
    for (size_t i = 0; i < *count; i++) {
        places[i] = (struct pel_place){ "", a[i], b[i] };
    }
    int var, rank;
    size_t length = 0;
    int dims[2];
    if (nc_inq_varid(f->id, "station_name", &var) == 0 &&
        nc_inq_varndims(f->id, var, &rank) == 0 && rank == 2 &&
        nc_inq_vardimid(f->id, var, dims) == 0 &&
        nc_inq_dimlen(f->id, dims[1], &length) == 0) {
        /* WAVEWATCH III's have 16 or 40 characters, mostly blanks. */
        length = length < 39 ? length : 39;
        for (size_t i = 0; i < *count; i++) {
            size_t start[2] = { i, 0 }, part[2] = { 1, length };
            if (nc_get_vara_text(f->id, var, start, part, places[i].name)) {
                places[i].name[0] = '\0';
            }
            places[i].name[39] = '\0';
            for (size_t k = strlen(places[i].name);
                 k > 0 && places[i].name[k - 1] == ' '; k--) {
                places[i].name[k - 1] = '\0';
            }
        }
    }
    return PEL_OK;
}

/* To Hz, from radians a second and from periods as well; rising. */
static enum pel_err frequency_unit(struct file *f, const char *units,
                                   double *frequency, struct pel_fault *fault)
{
    struct pel_cf_power p = { 0, -1, 0, 1 };
    bool known = !*units || pel_cf_product(units, &p);
    f->radians = p.seconds == -1 && p.radians == 1;
    f->periods = p.seconds == 1;
    known = known && p.metres == 0 &&
            ((p.radians == 0 && abs(p.seconds) == 1) || f->radians);
    if (!known) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "its frequencies are in \"%.40s\"; Hz, rad/s or s "
                             "are read: ncatted -a units,frequency,o,c,Hz FILE",
                             units);
    }
    for (size_t i = 0; i < f->frequency.size; i++) {
        double v = frequency[i] * p.factor;
        frequency[i] = f->radians ? v / (2 * PEL_PI) : f->periods ? 1 / v : v;
    }
    return PEL_OK;
}

/* Directions in degrees or radians, to or from; each has to be said. */
static enum pel_err ways(const struct file *f, const char *variable,
                         const char *units, double *to, struct pel_fault *fault)
{
    char name[80] = "", words[80] = "";
    double unit = 1;
    int var;
    if (nc_inq_varid(f->id, variable, &var) == 0) {
        attribute(f, var, "standard_name", name);
        attribute(f, var, "long_name", words);
    }
    if (!pel_cf_unit(*units ? units : "degree", PEL_CF_DEG, &unit)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "its directions are in \"%.40s\"; degrees or "
                             "radians are read: ncatted -a "
                             "units,%.30s,o,c,degree FILE",
                             units, variable);
    }
    bool from = strstr(name, "from_direction") || strstr(words, "from");
    bool goes = strstr(name, "to_direction") || strstr(words, " to ") ||
                strstr(words, "toward");
    if (strstr(name, "_direction") && (from || goes)) {
        from = strstr(name, "from_direction") != NULL;
        goes = strstr(name, "to_direction") != NULL;
    }
    if (from == goes) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "its %.30s does not say whether waves come from "
                             "there or go there: ncatted -a standard_name,"
                             "%.30s,o,c,sea_surface_wave_from_direction FILE "
                             "(or …_to_direction)",
                             variable, variable);
    }
    double widest = 0;
    for (size_t k = 0; k < f->direction.size; k++) {
        widest = fmax(widest, fabs(to[k]));
        to[k] = (from ? 1.5 : 0.5) * PEL_PI - unit * PEL_DEG * to[k];
    }
    return !*units && widest < 7
               ? pel_fault_set(fault, PEL_ERR_INVALID,
                               "its %.30s, up to %g, does not say its unit: "
                               "ncatted -a units,%.30s,o,c,radian FILE",
                               variable, widest, variable)
               : PEL_OK;
}

/* The factor of the densities' unit to m²/(Hz rad); *by_frequency 1: for each
 * Hz, −1: for each second of period, 0: for each rad/s. */
static enum pel_err density_unit(struct file *f, double *factor,
                                 int *by_frequency, struct pel_fault *fault)
{
    char units[80];
    struct pel_cf_power p;
    int of_angle = f->direction.dim >= 0 ? -1 : 0;
    attribute(f, f->density, "units", units);
    *factor = 1;
    *by_frequency = 1;
    if (!*units || f->logarithms) {
        return f->radians || f->periods
                   ? pel_fault_set(fault, PEL_ERR_INVALID,
                                   "its densities do not say their unit, and "
                                   "its frequencies are not in Hz: ncatted -a "
                                   "units,density,o,c,'m2 s rad-2' FILE")
                   : PEL_OK;
    }
    bool known = pel_cf_product(units, &p) && p.metres == 2;
    bool says_hz = strstr(units, "Hz") || strstr(units, "hertz");
    if (known && p.seconds == 1 && p.radians == of_angle &&
        (!f->radians || says_hz)) {
        *by_frequency = 1;
    } else if (known && p.seconds == 1 && p.radians == of_angle - 1 &&
               !says_hz) {
        *by_frequency = 0;
    } else if (known && p.seconds == -1 && p.radians == of_angle &&
               f->periods && !says_hz) {
        *by_frequency = -1;
    } else {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "its densities are in \"%.50s\"; %s: ncatted -a units,VARIABLE,o,c,"
            "'%s' FILE",
            units,
            of_angle ? "m2/Hz/rad or, for each rad/s, m2 s/rad2 are read"
                     : "m2/Hz or, for each rad/s, m2 s/rad are read",
            of_angle ? "m2 s rad-1" : "m2/Hz");
    }
    *factor = p.factor;
    return PEL_OK;
}

static void swap(double *a, double *b)
{
    double other = *a;
    *a = *b;
    *b = other;
}

/* Densities, by frequency and then direction, to m²/Hz/rad, of rising
 * frequencies. */
static enum pel_err make_densities(struct file *f, double *frequency,
                                   double *density, struct pel_fault *fault)
{
    double factor;
    int by;
    size_t nf = f->frequency.size, nd = f->direction.size;
    enum pel_err err = density_unit(f, &factor, &by, fault);
    for (size_t i = 0; i < nf && !err; i++) {
        double t = 1 / frequency[i];
        double one = by == 0 ? 2 * PEL_PI : by < 0 ? t * t : 1;
        for (size_t k = 0; k < nd; k++) {
            density[i * nd + k] *= factor * one;
        }
    }
    bool falls = frequency[nf - 1] < frequency[0];
    for (size_t i = 0; i < nf / 2 && !err && falls; i++) {
        swap(&frequency[i], &frequency[nf - 1 - i]);
        for (size_t k = 0; k < nd; k++) {
            swap(&density[i * nd + k], &density[(nf - 1 - i) * nd + k]);
        }
    }
    return err;
}

/* ERA5 counts its frequencies and directions: 0.03453 Hz · 1.1^(i−1), and
 * 7.5° + 15° (k−1) that waves go to (ECMWF, 2D wave spectra). */
static enum pel_err axes(struct file *f, double *frequency, double *to,
                         struct pel_fault *fault)
{
    char units[80];
    size_t nd = f->direction.size;
    if (f->logarithms) {
        if (f->frequency.size != 30 || nd != 24) {
            return bad("is not of ERA5's 30 frequencies and 24 directions",
                       fault);
        }
        for (int i = 0; i < 30; i++) {
            frequency[i] = 0.03453 * pow(1.1, i);
        }
        for (int k = 0; k < 24; k++) {
            to[k] = PEL_PI / 2 - (7.5 + 15.0 * k) * PEL_DEG;
        }
        return PEL_OK;
    }
    if (!coordinate(f, f->frequency, frequencies, frequency, units)) {
        return bad("has no frequency", fault);
    }
    enum pel_err err = frequency_unit(f, units, frequency, fault);
    if (err || f->direction.dim < 0) {
        return err;
    }
    const char *name = coordinate(f, f->direction, directions, to, units);
    return name ? ways(f, name, units, to, fault)
                : bad("has no direction", fault);
}

/* What is chosen of a variable with the density's axes, by frequency and then
 * direction. */
static bool part(const struct file *f, int var, size_t time, size_t place,
                 double *out)
{
    static double raw[MOST_CELLS];
    size_t start[6] = { 0 }, count[6];
    size_t cells = f->frequency.size * f->direction.size;
    for (int i = 0; i < f->rank; i++) {
        start[i] = i == f->time.dim        ? time
                   : i == f->station.dim   ? place
                   : i == f->latitude.dim  ? place / f->longitude.size
                   : i == f->longitude.dim ? place % f->longitude.size
                                           : 0;
        count[i] = i == f->frequency.dim   ? f->frequency.size
                   : i == f->direction.dim ? f->direction.size
                                           : 1;
    }
    bool turned = f->direction.dim >= 0 && f->direction.dim < f->frequency.dim;
    if (!unpacked(f, var, start, count, cells, turned ? raw : out)) {
        return false;
    }
    for (size_t i = 0; i < cells && turned; i++) {
        out[i % f->frequency.size * f->direction.size + i / f->frequency.size] =
            raw[i];
    }
    return true;
}

/* A number of each band, NAN where it is missing or there is none. */
static bool band_numbers(const struct file *f, const char *name, size_t time,
                         size_t place, double *out)
{
    int var = 0, rank = 0;
    bool there = nc_inq_varid(f->id, name, &var) == 0 &&
                 nc_inq_varndims(f->id, var, &rank) == 0 && rank == f->rank &&
                 part(f, var, time, place, out);
    for (size_t k = 0; k < f->frequency.size && !there; k++) {
        out[k] = NAN;
    }
    return there;
}

/* NDBC's: angles and radii, which count where all four are in their ranges. */
static void take_polar(const struct file *f, size_t time, size_t place,
                       struct pel_bands *b)
{
    static const char *const names[] = { "mean_wave_dir", "principal_wave_dir",
                                         "wave_spectrum_r1",
                                         "wave_spectrum_r2" };
    static double v[4][PEL_MEASURED_MOST];
    for (int i = 0; i < 4; i++) {
        band_numbers(f, names[i], time, place, v[i]);
    }
    for (int k = 0; k < b->count; k++) {
        if (v[0][k] >= 0 && v[0][k] <= 360 && v[2][k] >= 0 && v[2][k] <= 1) {
            b->alpha1_rad[k] = pel_goes_to_rad(v[0][k]);
            b->r1[k] = v[2][k];
        }
        if (v[1][k] >= 0 && v[1][k] <= 360 && v[3][k] >= 0 && v[3][k] <= 1) {
            b->alpha2_rad[k] = pel_goes_to_rad(v[1][k]);
            b->r2[k] = v[3][k];
        }
    }
}

/* CDIP's: Fourier coefficients of the direction waves come from, from north,
 * clockwise; bad records are flagged. */
static enum pel_err take_coefficients(const struct file *f, size_t time,
                                      size_t place, struct pel_bands *b,
                                      struct pel_fault *fault)
{
    static const char *const names[] = { "waveA1Value", "waveB1Value",
                                         "waveA2Value", "waveB2Value" };
    static double v[4][PEL_MEASURED_MOST];
    int var;
    signed char flag = 1;
    if (nc_inq_varid(f->id, "waveFlagPrimary", &var) == 0 &&
        nc_get_var1_schar(f->id, var, &time, &flag) == 0 && flag > 2) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "CDIP flags the record as bad (waveFlagPrimary "
                             "%d): choose another measuredTime",
                             flag);
    }
    for (int i = 0; i < 4; i++) {
        band_numbers(f, names[i], time, place, v[i]);
    }
    for (int k = 0; k < b->count; k++) {
        double from1 = atan2(v[1][k], v[0][k]) / PEL_DEG;
        double from2 = 0.5 * atan2(v[3][k], v[2][k]) / PEL_DEG;
        b->r1[k] = hypot(v[0][k], v[1][k]);
        b->r2[k] = hypot(v[2][k], v[3][k]);
        b->alpha1_rad[k] = pel_goes_to_rad(from1);
        b->alpha2_rad[k] = pel_goes_to_rad(from2);
    }
    return PEL_OK;
}

static enum pel_err buoy(struct file *f, const double *frequency, size_t time,
                         size_t place, struct pel_measured *out,
                         struct pel_fault *fault)
{
    static struct pel_bands b;
    pel_bands_init(&b, (int)f->frequency.size);
    if (!part(f, f->density, time, place, b.density)) {
        return bad("cannot be read", fault);
    }
    for (int k = 0; k < b.count; k++) {
        b.frequency_hz[k] = frequency[k];
    }
    enum pel_err err = make_densities(f, b.frequency_hz, b.density, fault);
    if (!err && f->cdip) {
        err = take_coefficients(f, time, place, &b, fault);
    } else if (!err) {
        take_polar(f, time, place, &b);
    }
    return err ? err : pel_bands_take(&b, out, fault);
}

static enum pel_err read_file(struct file *f, const struct pel_want *want,
                              struct pel_measured *out, double *unix_s,
                              struct pel_fault *fault)
{
    static struct pel_place places[PEL_SHELF_STATIONS];
    static double cells[MOST_CELLS], to[PEL_SHELF_DIRECTIONS];
    double frequency[PEL_MEASURED_MOST];
    size_t count = 0, time = 0;
    enum pel_err err = find(f, fault);
    err = err ? err : axes(f, frequency, to, fault);
    err = err ? err : list_places(f, places, &count, fault);
    if (err) {
        return err;
    }
    int place = pel_shelf_place(want, places, count, fault);
    if (place < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    err = choose_time(f, want, &time, unix_s, fault);
    if (err) {
        return err;
    }
    if (f->direction.dim < 0) {
        return buoy(f, frequency, time, (size_t)place, out, fault);
    }
    if (!part(f, f->density, time, (size_t)place, cells)) {
        return bad("cannot be read", fault);
    }
    bool any = false;
    for (size_t i = 0; i < f->frequency.size * f->direction.size; i++) {
        cells[i] = f->logarithms ? pow(10, cells[i]) : cells[i];
        any = any || isfinite(cells[i]);
    }
    if (!any) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "the place has no data then");
    }
    err = make_densities(f, frequency, cells, fault);
    return err ? err
               : pel_shelf_collapse(frequency, (int)f->frequency.size, to,
                                    (int)f->direction.size, cells, out, fault);
}

/* A classic file that was cut short reads as zeros: the library does not tell.
 * Its values alone take this many bytes. */
static bool cut_short(const struct file *f, const char *path)
{
    int format = 0, vars = 0;
    double bytes = 0;
    struct stat is;
    if (nc_inq_format(f->id, &format) || format == NC_FORMAT_NETCDF4 ||
        format == NC_FORMAT_NETCDF4_CLASSIC || nc_inq_nvars(f->id, &vars) ||
        stat(path, &is)) {
        return false;
    }
    for (int v = 0; v < vars; v++) {
        nc_type type;
        int rank, dims[NC_MAX_VAR_DIMS];
        size_t size = 0, length;
        if (nc_inq_var(f->id, v, NULL, &type, &rank, dims, NULL) ||
            nc_inq_type(f->id, type, NULL, &size)) {
            return true;
        }
        double cells = 1;
        for (int i = 0; i < rank; i++) {
            cells *=
                nc_inq_dimlen(f->id, dims[i], &length) ? 0 : (double)length;
        }
        bytes += cells * (double)size;
    }
    return (double)is.st_size < bytes;
}

enum pel_err pel_read_netcdf(const char *path, const struct pel_want *want,
                             struct pel_measured *out, double *unix_s,
                             struct pel_fault *fault)
{
    struct file f = { 0 };
    int rc = nc_open(path, NC_NOWRITE, &f.id);
    if (rc) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "no NetCDF: %.100s",
                             nc_strerror(rc));
    }
    if (cut_short(&f, path)) {
        return bad("is cut short", fault);
    }
    return read_file(&f, want, out, unix_s, fault); /* the process ends */
}
