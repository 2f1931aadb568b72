#include "ocean/spectrumwrite.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/vec.h"
#include "ocean/netcdffile.h"

#define ACROSS 4 /* samples of a band, in ln f */
#define ALONG 3  /* of a sector */
#define MOST_DIRECTIONS 360

/* m²/Hz/rad at frequency i and direction k, row by row. */
struct table {
    int nf, nd;
    double hz[PEL_MEASURED_MOST], low[PEL_MEASURED_MOST],
        high[PEL_MEASURED_MOST];
    double *density;
    const struct pel_spectrum_place *place;
    struct tm at;
};

static double from_deg(const struct table *t, int k)
{
    return 360.0 * k / t->nd;
}

/* As the form prints it. */
static double printed(enum pel_spectrum_form form, double hz)
{
    static const char *const formats[] = { "%.2E", "%.5f", "%.3f", "%.7g" };
    char text[32];
    snprintf(text, sizeof text, formats[form], hz);
    return strtod(text, NULL); /* the C locale, as everywhere */
}

static void set_frequencies(const struct pel_spectrum_grid *grid,
                            enum pel_spectrum_form form, struct table *t)
{
    double ratio = grid->highest_hz / grid->lowest_hz;
    for (int i = 0; i < grid->frequencies; i++) {
        double hz =
            printed(form, grid->lowest_hz *
                              pow(ratio, (double)i / (grid->frequencies - 1)));
        if (t->nf == 0 || hz > t->hz[t->nf - 1]) {
            t->hz[t->nf++] = hz;
        }
    }
    for (int i = 0; i < t->nf; i++) {
        t->low[i] = i ? 0.5 * (t->hz[i - 1] + t->hz[i]) : t->hz[i];
        t->high[i] = i + 1 < t->nf ? 0.5 * (t->hz[i] + t->hz[i + 1]) : t->hz[i];
    }
}

/* The share of the band's energy in each sector. */
static void set_row(const struct pel_directional *spectrum, struct table *t,
                    int i)
{
    struct pel_band_moments band;
    double *row = t->density + (size_t)i * (size_t)t->nd, sum = 0;
    double sector = 2.0 * PEL_PI / t->nd;
    double lo = 2.0 * PEL_PI * t->low[i], hi = 2.0 * PEL_PI * t->high[i];
    pel_directional_continuous(spectrum,
                               pel_dispersion_k(lo, spectrum->depth_m),
                               pel_dispersion_k(hi, spectrum->depth_m), &band);
    for (int k = 0; k < t->nd; k++) {
        for (int j = 0; j < ACROSS * ALONG; j++) {
            double share = (j / ALONG + 0.5) / ACROSS;
            double omega = lo * pow(hi / lo, share);
            double from = from_deg(t, k) * PEL_DEG +
                          sector * ((j % ALONG + 0.5) / ALONG - 0.5);
            /* Each sample stands for a piece of ln ω. */
            row[k] += omega *
                      pel_directional_at(spectrum, omega, 1.5 * PEL_PI - from);
        }
        sum += row[k];
    }
    double scale =
        sum > 0 ? band.m0 / (t->high[i] - t->low[i]) / (sum * sector) : 0;
    for (int k = 0; k < t->nd; k++) {
        row[k] *= scale;
    }
}

/* --- text ----------------------------------------------------------------- */

static FILE *begin(struct pel_spectrum_files *out, const char *name, int which)
{
    snprintf(out->file[which].name, sizeof out->file[which].name, "%s", name);
    out->count = which + 1;
    return open_memstream((char **)&out->file[which].data,
                          &out->file[which].size);
}

static enum pel_err end(FILE *f, struct pel_fault *fault)
{
    bool whole = f && !ferror(f);
    whole = f && fclose(f) == 0 && whole;
    return whole ? PEL_OK
                 : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
}

/* As Fortran's E11.3: 0.123E+01. */
static void put_e(FILE *f, double v, int width, int *column, int columns)
{
    int exponent = v > 0 ? (int)floor(log10(v)) + 1 : 0;
    double mantissa = v > 0 ? v / pow(10, exponent) : 0;
    if (mantissa >= 0.9995) {
        mantissa /= 10;
        exponent++;
    }
    if (exponent < -98) {
        mantissa = exponent = 0;
    }
    fprintf(f, "%*s%.3fE%+03d", width - 9, "", mantissa, exponent);
    if (++*column == columns) {
        fputc('\n', f);
        *column = 0;
    }
}

static void end_row(FILE *f, int *column)
{
    if (*column) {
        fputc('\n', f);
    }
    *column = 0;
}

/* The direction that waves go to, from east on counterclockwise; rad from
 * north. */
static double ww3_direction(const struct table *t, int k)
{
    int quarter = t->nd % 4 == 0 ? t->nd / 4 : 0;
    return from_deg(t, (quarter - k + t->nd) % t->nd) * PEL_DEG;
}

/* The density of waves that go to a compass direction. */
static double going_to(const struct table *t, int i, double to_rad)
{
    double place = (to_rad / PEL_DEG + 180.0) / 360.0 * t->nd;
    int k = (int)floor(place + 1e-6) % t->nd;
    double share = place - floor(place + 1e-6); /* ½ where nd is odd */
    const double *row = t->density + (size_t)i * (size_t)t->nd;
    return (1 - share) * row[k] + share * row[(k + 1) % t->nd];
}

/* ww3_outp, ITYPE 1, OTYPE 3: the transfer file of spectra. */
static enum pel_err write_ww3(const struct table *t,
                              struct pel_spectrum_files *out,
                              struct pel_fault *fault)
{
    const struct pel_spectrum_place *p = t->place;
    double to_rad[MOST_DIRECTIONS];
    FILE *f = begin(out, "pelagos_ww3.spec", 0);
    int column = 0;
    if (!f) {
        return end(f, fault);
    }
    fprintf(f, "'WAVEWATCH III SPECTRA' %6d%6d%6d '%-30s'\n", t->nf, t->nd, 1,
            "pelagos");
    for (int i = 0; i < t->nf; i++) {
        put_e(f, t->hz[i], 10, &column, 8);
    }
    end_row(f, &column);
    for (int k = 0; k < t->nd; k++) {
        to_rad[k] = ww3_direction(t, k);
        put_e(f, to_rad[k], 11, &column, 7);
    }
    end_row(f, &column);
    fprintf(f, "%04d%02d%02d %02d%02d%02d\n", t->at.tm_year + 1900,
            t->at.tm_mon + 1, t->at.tm_mday, t->at.tm_hour, t->at.tm_min,
            t->at.tm_sec);
    fprintf(f, "'%-10.10s'%7.2f%7.2f%10.1f%7.2f%6.1f%7.2f%6.1f\n", p->station,
            p->latitude, p->longitude, p->depth_m > 0 ? p->depth_m : 9999.0,
            p->wind_mps, p->wind_from_deg, 0.0, 0.0);
    for (int k = 0; k < t->nd; k++) {
        for (int i = 0; i < t->nf; i++) {
            put_e(f, going_to(t, i, to_rad[k]), 11, &column, 7);
        }
    }
    end_row(f, &column);
    return end(f, fault);
}

static enum pel_err write_swan(const struct table *t,
                               struct pel_spectrum_files *out,
                               struct pel_fault *fault)
{
    enum { MOST = 99990 };
    double greatest = 0;
    FILE *f = begin(out, "pelagos.spc", 0);
    if (!f) {
        return end(f, fault);
    }
    for (int c = 0; c < t->nf * t->nd; c++) {
        greatest = fmax(greatest, t->density[c] * PEL_DEG);
    }
    fprintf(f,
            "SWAN   1                                Swan standard spectral "
            "file\n$   %.200s\nTIME                                    "
            "time-dependent data\n     1                                  "
            "time coding option\nLONLAT                                  "
            "locations in spherical coordinates\n     1                       "
            "           number of locations\n%12.6f%12.6f\nAFREQ             "
            "                      absolute frequencies in Hz\n%6d           "
            "                       number of frequencies\n",
            t->place->history, t->place->longitude, t->place->latitude, t->nf);
    for (int i = 0; i < t->nf; i++) {
        fprintf(f, "%11.5f\n", t->hz[i]);
    }
    fprintf(f,
            "NDIR                                    spectral nautical "
            "directions in degr\n%6d                                  number "
            "of directions\n",
            t->nd);
    for (int k = 0; k < t->nd; k++) {
        fprintf(f, "%11.4f\n", from_deg(t, k));
    }
    fprintf(f, "QUANT\n     1                                  number of "
               "quantities in table\nVaDens                                  "
               "variance densities in m2/Hz/degr\nm2/Hz/degr                 "
               "             unit\n   -99                                  "
               "exception value\n");
    fprintf(f,
            "%04d%02d%02d.%02d%02d%02d                         date and "
            "time\n",
            t->at.tm_year + 1900, t->at.tm_mon + 1, t->at.tm_mday,
            t->at.tm_hour, t->at.tm_min, t->at.tm_sec);
    if (!(greatest > 0)) {
        fputs("ZERO\n", f);
        return end(f, fault);
    }
    double unit = greatest / MOST;
    fprintf(f, "FACTOR\n%18.8E\n", unit);
    for (int c = 0; c < t->nf * t->nd; c++) {
        fprintf(f, "%6.0f%s", t->density[c] * PEL_DEG / unit,
                (c + 1) % t->nd ? "" : "\n");
    }
    return end(f, fault);
}

/* What a buoy would report at a frequency (Longuet-Higgins et al. 1963; NDBC:
 * D(A) = 1/π (½ + r1 cos(A − α1) + r2 cos 2(A − α2)), A compass, waves from).
 */
struct buoy {
    double density, alpha1_deg, alpha2_deg, r1, r2;
};

static struct buoy reported(const struct table *t, int i)
{
    double sum = 0, c1 = 0, s1 = 0, c2 = 0, s2 = 0;
    for (int k = 0; k < t->nd; k++) {
        double v = t->density[(size_t)i * (size_t)t->nd + (size_t)k];
        double a = from_deg(t, k) * PEL_DEG;
        sum += v;
        c1 += v * cos(a);
        s1 += v * sin(a);
        c2 += v * cos(2 * a);
        s2 += v * sin(2 * a);
    }
    struct buoy b = { sum * 2.0 * PEL_PI / t->nd, 999, 999, 999, 999 };
    if (sum > 0 && b.density >= 0.0005) { /* else it prints as 0.000 */
        b.r1 = hypot(c1, s1) / sum;
        b.r2 = hypot(c2, s2) / sum;
        b.alpha1_deg = fmod(atan2(s1, c1) / PEL_DEG + 360, 360);
        b.alpha2_deg = fmod(0.5 * atan2(s2, c2) / PEL_DEG + 360, 360);
        /* Of the two that are meant, the one near the first. */
        if (fabs(remainder(b.alpha2_deg - b.alpha1_deg, 360)) > 90) {
            b.alpha2_deg = fmod(b.alpha2_deg + 180, 360);
        }
    }
    return b;
}

static enum pel_err write_ndbc(const struct table *t,
                               struct pel_spectrum_files *out,
                               struct pel_fault *fault)
{
    static const char *const endings[] = { "data_spec", "swdir", "swdir2",
                                           "swr1", "swr2" };
    static const char *const words[] = { "spec", "alpha1", "alpha2", "r1",
                                         "r2" };
    enum pel_err err = PEL_OK;
    for (int which = 0; which < 5 && !err; which++) {
        char name[40];
        snprintf(name, sizeof name, "%.10s.%s", t->place->station,
                 endings[which]);
        FILE *f = begin(out, name, which);
        if (!f) {
            return end(f, fault);
        }
        const char *w = words[which];
        fprintf(f,
                "#YY  MM DD hh mm %s%s_1 (freq_1) %s_2 (freq_2) %s_3 "
                "(freq_3) ... >\n%04d %02d %02d %02d %02d%s",
                which ? "" : "Sep_Freq  < ", w, w, w, t->at.tm_year + 1900,
                t->at.tm_mon + 1, t->at.tm_mday, t->at.tm_hour, t->at.tm_min,
                which ? "" : " 9.999");
        for (int i = 0; i < t->nf; i++) {
            struct buoy b = reported(t, i);
            const double v[] = { b.density, b.alpha1_deg, b.alpha2_deg, b.r1,
                                 b.r2 };
            fprintf(f, " %.*f (%.3f)",
                    which == 0  ? 3
                    : which < 3 ? 1
                                : 2,
                    v[which], t->hz[i]);
        }
        fputs(" \n", f);
        err = end(f, fault);
    }
    return err;
}

/* --- NetCDF, as ww3_ounp writes it ---------------------------------------- */

enum { TIME, STATION, STRING, FREQUENCY, DIRECTION };

static int put_one(struct pel_netcdf *nc, const char *name,
                   enum pel_netcdf_type type, const int *dims, int rank,
                   const char *unit, const char *standard, const char *text,
                   const double *values, size_t count)
{
    int var = pel_netcdf_variable(nc, name, type, rank, dims);
    pel_netcdf_text(nc, var, "long_name", text);
    if (standard) {
        pel_netcdf_text(nc, var, "standard_name", standard);
    }
    if (unit) {
        pel_netcdf_text(nc, var, "units", unit);
    }
    pel_netcdf_values(nc, var, values, count);
    return var;
}

static void put_axes(struct pel_netcdf *nc, const struct table *t)
{
    static const int time = TIME, station = STATION, frequency = FREQUENCY,
                     direction = DIRECTION;
    static const int named[] = { STATION, STRING };
    char name[41];
    double days = (t->place->unix_s - 631152000.0) / 86400.0, one = 1;
    double to[MOST_DIRECTIONS];
    for (int k = 0; k < t->nd; k++) {
        to[k] = fmod(from_deg(t, k) + 180.0, 360.0);
    }
    int var = put_one(nc, "time", PEL_NETCDF_DOUBLE, &time, 1,
                      "days since 1990-01-01 00:00:00", "time",
                      "julian day (UT)", &days, 1);
    pel_netcdf_text(nc, var, "calendar", "standard");
    put_one(nc, "station", PEL_NETCDF_INT, &station, 1, "1", NULL, "station id",
            &one, 1);
    var = pel_netcdf_variable(nc, "station_name", PEL_NETCDF_CHAR, 2, named);
    pel_netcdf_text(nc, var, "long_name", "station name");
    pel_netcdf_text(nc, var, "cf_role", "timeseries_id");
    snprintf(name, sizeof name, "%-40.40s", t->place->station);
    pel_netcdf_chars(nc, var, name, 40);
    put_one(nc, "frequency", PEL_NETCDF_FLOAT, &frequency, 1, "s-1",
            "sea_surface_wave_frequency", "frequency of center band", t->hz,
            (size_t)t->nf);
    put_one(nc, "frequency1", PEL_NETCDF_FLOAT, &frequency, 1, "s-1", NULL,
            "frequency of lower band", t->low, (size_t)t->nf);
    put_one(nc, "frequency2", PEL_NETCDF_FLOAT, &frequency, 1, "s-1", NULL,
            "frequency of upper band", t->high, (size_t)t->nf);
    put_one(nc, "direction", PEL_NETCDF_FLOAT, &direction, 1, "degree",
            "sea_surface_wave_to_direction", "sea surface wave to direction",
            to, (size_t)t->nd);
}

static enum pel_err write_netcdf(const struct table *t,
                                 struct pel_spectrum_files *out,
                                 struct pel_fault *fault)
{
    static const int all[] = { TIME, STATION, FREQUENCY, DIRECTION };
    const struct pel_spectrum_place *p = t->place;
    const struct {
        const char *name, *unit, *standard, *text;
        double value;
    } points[] = {
        { "longitude", "degree_east", "longitude", "longitude", p->longitude },
        { "latitude", "degree_north", "latitude", "latitude", p->latitude },
        { "dpt", "m", "depth", "depth", p->depth_m > 0 ? p->depth_m : 9999.0 },
        { "wnd", "m s-1", "wind_speed", "wind speed at 10m", p->wind_mps },
        { "wnddir", "degree", "wind_from_direction", "wind direction",
          p->wind_from_deg },
        { "cur", "m s-1", "sea_water_speed", "sea water speed", 0 },
        { "curdir", "degree", "direction_of_sea_water_velocity",
          "direction from of sea water velocity", 0 },
    };
    struct pel_netcdf *nc = pel_netcdf_create();
    if (!nc) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    pel_netcdf_dimension(nc, "time", 1);
    pel_netcdf_dimension(nc, "station", 1);
    pel_netcdf_dimension(nc, "string40", 40);
    pel_netcdf_dimension(nc, "frequency", (size_t)t->nf);
    pel_netcdf_dimension(nc, "direction", (size_t)t->nd);
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "Conventions", "CF-1.10");
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "product_name", "pelagos_spec.nc");
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "data_type", "OCO spectra 2D");
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "area", "pelagos");
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "format_version", "1.1");
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "history", p->history);
    put_axes(nc, t);
    for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
        put_one(nc, points[i].name, PEL_NETCDF_FLOAT, all, 2, points[i].unit,
                points[i].standard, points[i].text, &points[i].value, 1);
    }
    int var = put_one(nc, "efth", PEL_NETCDF_FLOAT, all, 4, "m2 s rad-1",
                      "sea_surface_wave_directional_variance_spectral_density",
                      "sea surface wave directional variance spectral density",
                      t->density, (size_t)t->nf * (size_t)t->nd);
    pel_netcdf_number(nc, var, "scale_factor", 1);
    pel_netcdf_number(nc, var, "add_offset", 0);
    out->count = 1;
    snprintf(out->file[0].name, sizeof out->file[0].name, "pelagos_spec.nc");
    return pel_netcdf_end(nc, &out->file[0].data, &out->file[0].size, fault);
}

/* --- all of them ---------------------------------------------------------- */

void pel_spectrum_files_finish(struct pel_spectrum_files *files)
{
    for (int i = 0; i < PEL_SPECTRUM_FILES; i++) {
        free(files->file[i].data);
    }
    *files = (struct pel_spectrum_files){ 0 };
}

static enum pel_err check(const struct pel_spectrum_grid *g,
                          struct pel_fault *fault)
{
    if (g->frequencies < 3 || g->frequencies > PEL_MEASURED_MOST ||
        g->directions < 3 || g->directions > MOST_DIRECTIONS) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "a file has 3 to %d frequencies and at least 3 "
                             "directions",
                             PEL_MEASURED_MOST);
    }
    if (!(g->lowest_hz >= 0.005 && g->highest_hz <= 2 &&
          g->highest_hz >= 1.2 * g->lowest_hz)) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "a file's frequencies are 0.005 to 2 Hz (0.0314 "
                             "to 12.57 rad/s), the highest a fifth above the "
                             "lowest at least");
    }
    return PEL_OK;
}

enum pel_err pel_spectrum_write(const struct pel_directional *spectrum,
                                enum pel_spectrum_form form,
                                const struct pel_spectrum_grid *grid,
                                const struct pel_spectrum_place *place,
                                struct pel_spectrum_files *out,
                                struct pel_fault *fault)
{
    static const char *const types[] = { "text/plain; charset=utf-8",
                                         "text/plain; charset=utf-8",
                                         "application/x-tar",
                                         "application/netcdf" };
    static enum pel_err (*const write[])(
        const struct table *, struct pel_spectrum_files *,
        struct pel_fault *) = { write_ww3, write_swan, write_ndbc,
                                write_netcdf };
    enum pel_err err = check(grid, fault);
    if (err) {
        return err;
    }
    struct table *t = calloc(1, sizeof *t);
    time_t seconds = (time_t)floor(place->unix_s);
    *out = (struct pel_spectrum_files){ .type = types[form] };
    if (t) {
        t->nd = grid->directions;
        t->place = place;
        gmtime_r(&seconds, &t->at);
        set_frequencies(grid, form, t);
        t->density = calloc((size_t)t->nf * (size_t)t->nd, sizeof *t->density);
    }
    if (!t || !t->density) {
        free(t);
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int i = 0; i < t->nf; i++) {
        set_row(spectrum, t, i);
    }
    err = write[form](t, out, fault);
    free(t->density);
    free(t);
    if (err) {
        pel_spectrum_files_finish(out);
    }
    return err;
}
