/* Spectra in NetCDF, by the names and units of their variables: WAVEWATCH III
 * (efth), SWAN (density), ERA5 (d2fd), NDBC (spectral_wave_density). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <netcdf.h>
#include <sys/stat.h>

#include "base/vec.h"
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

static enum pel_err find(struct file *f, struct pel_fault *fault)
{
    static const char *const densities[] = { "efth", "density", "d2fd",
                                             "spectral_wave_density" };
    static const char *const times[] = { "time", "valid_time", NULL },
                             *const frequencies[] = { "frequency", "freq",
                                                      NULL },
                             *const directions[] = { "direction", "dir", NULL },
                             *const stations[] = { "station", "points", "site",
                                                   NULL },
                             *const latitudes[] = { "latitude", "lat", NULL },
                             *const longitudes[] = { "longitude", "lon", NULL };
    f->density = -1;
    for (size_t i = 0; i < 4 && f->density < 0; i++) {
        if (nc_inq_varid(f->id, densities[i], &f->density) == 0) {
            f->logarithms = i == 2;
        } else {
            f->density = -1;
        }
    }
    if (f->density < 0) {
        return bad("has no efth, density, d2fd or spectral_wave_density",
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

/* "seconds since 1970-01-01T00:00:00Z" */
static bool clock_of(const char *units, double *step_s, double *epoch_s)
{
    static const struct {
        const char *word;
        double s;
    } steps[] = { { "seconds since ", 1 },
                  { "second since ", 1 },
                  { "minutes since ", 60 },
                  { "hours since ", 3600 },
                  { "days since ", 86400 } };
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        size_t length = strlen(steps[i].word);
        if (strncmp(units, steps[i].word, length) == 0) {
            int y, m, d, hour = 0, minute = 0;
            double second = 0;
            if (sscanf(units + length, "%4d-%2d-%2d%*[ T]%2d:%2d:%lf", &y, &m,
                       &d, &hour, &minute, &second) < 3) {
                return false;
            }
            *step_s = steps[i].s;
            *epoch_s =
                pel_shelf_unix(y, m, d, 3600.0 * hour + 60.0 * minute + second);
            return isfinite(*epoch_s);
        }
    }
    return false;
}

static enum pel_err choose_time(const struct file *f,
                                const struct pel_want *want, size_t *at,
                                double *unix_s, struct pel_fault *fault)
{
    static double times[PEL_SHELF_TIMES];
    char units[80];
    double step, epoch;
    if (!whole(f, "time", f->time.size, times, units) &&
        !whole(f, "valid_time", f->time.size, times, units)) {
        return bad("has no time", fault);
    }
    if (!clock_of(units, &step, &epoch)) {
        return bad("has times in no unit as seconds since 1970-01-01", fault);
    }
    for (size_t i = 0; i < f->time.size; i++) {
        times[i] = epoch + step * times[i];
    }
    int chosen = pel_shelf_time(want, times, f->time.size, fault);
    if (chosen < 0) {
        return PEL_ERR_NOT_FOUND;
    }
    *at = (size_t)chosen;
    *unix_s = times[chosen];
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
        if (!whole(f, "latitude", f->latitude.size, a, units) ||
            !whole(f, "longitude", f->longitude.size, b, units)) {
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

/* ERA5 counts its frequencies and directions: 0.03453 Hz · 1.1^(i−1), and
 * 7.5° + 15° (k−1) that waves go to (ECMWF, 2D wave spectra). */
static enum pel_err axes(const struct file *f, double *frequency, double *to,
                         struct pel_fault *fault)
{
    char units[80], name[80] = "";
    int var;
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
    if (!whole(f, "frequency", f->frequency.size, frequency, units) &&
        !whole(f, "freq", f->frequency.size, frequency, units)) {
        return bad("has no frequency", fault);
    }
    if (f->direction.dim < 0) {
        return PEL_OK;
    }
    const char *variable = "direction";
    if (!whole(f, variable, nd, to, units)) {
        variable = "dir";
        if (!whole(f, variable, nd, to, units)) {
            return bad("has no direction", fault);
        }
    }
    nc_inq_varid(f->id, variable, &var);
    attribute(f, var, "standard_name", name);
    bool from = strstr(name, "from") != NULL;
    double unit = strncmp(units, "rad", 3) == 0 ? 1.0 : PEL_DEG;
    for (size_t k = 0; k < nd; k++) {
        to[k] = (from ? 1.5 : 0.5) * PEL_PI - unit * to[k];
    }
    return PEL_OK;
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

/* A buoy's: by moments, all or none. */
static enum pel_err buoy(const struct file *f, const double *frequency,
                         size_t time, size_t place, struct pel_measured *out,
                         struct pel_fault *fault)
{
    static const char *const names[] = { "spectral_wave_density",
                                         "mean_wave_dir", "principal_wave_dir",
                                         "wave_spectrum_r1",
                                         "wave_spectrum_r2" };
    static double v[5][PEL_MEASURED_MOST];
    int n = (int)f->frequency.size;
    bool all = true;
    for (int i = 0; i < 5; i++) {
        int var = 0, rank = 0;
        bool there = nc_inq_varid(f->id, names[i], &var) == 0 &&
                     nc_inq_varndims(f->id, var, &rank) == 0 &&
                     rank == f->rank && part(f, var, time, place, v[i]);
        all = all && there;
        if (i == 0 && !there) {
            return bad("cannot be read", fault);
        }
    }
    out->count = n;
    for (int k = 0; k < n; k++) {
        bool known = all && v[1][k] >= 0 && v[1][k] <= 360 && v[2][k] >= 0 &&
                     v[2][k] <= 360 && v[3][k] >= 0 && v[3][k] <= 1 &&
                     v[4][k] >= 0 && v[4][k] <= 1;
        out->frequency_hz[k] = frequency[k];
        out->density[k] = v[0][k] > 0 ? v[0][k] : 0;
        out->alpha1_rad[k] =
            known ? remainder(270.0 - v[1][k], 360.0) * PEL_DEG : 0;
        out->alpha2_rad[k] =
            known ? remainder(270.0 - v[2][k], 360.0) * PEL_DEG : 0;
        out->r1[k] = known ? v[3][k] : 0;
        out->r2[k] = known ? v[4][k] : 0;
    }
    return pel_shelf_frequencies(frequency, n, fault);
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
    return pel_shelf_collapse(frequency, (int)f->frequency.size, to,
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
