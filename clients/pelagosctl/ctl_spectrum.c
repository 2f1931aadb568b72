/* The command that prints the numbers of a sea. */
#include "pelagosctl/ctl.h"

#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "json.h"
#include "path.h"

static void print_moments(const char *name, const Pelagos__SeaMoments *m)
{
    printf("%-24s %9.4f %12.6f %12.6f %12.6f\n", name, m->significant_height,
           m->slope_along, m->slope_cross, m->slope_along + m->slope_cross);
}

static void print_rows(const Pelagos__Spectrum *s)
{
    size_t directions = s->n_rows > 0 ? s->rows[0]->n_directional : 0;
    if (s->n_rows > 0) {
        printf("\n%9s %9s %9s %13s %9s %9s\n", "rad/s", "Hz", "period s",
               "S m2s/rad", "from deg", "spread");
    }
    for (size_t i = 0; i < s->n_rows; i++) {
        const Pelagos__SpectrumRow *r = s->rows[i];
        printf("%9.4f %9.4f %9.3f %13.6g", r->omega, r->omega / 2.0 / G_PI,
               2.0 * G_PI / r->omega, r->density);
        if (r->has_direction) {
            printf(" %9.1f %9.1f", r->direction, r->spread);
        }
        putchar('\n');
    }
    if (directions > 0) {
        printf("\nS(omega, theta), m2 s/rad2, waves from\n%9s", "rad/s");
        for (size_t i = 0; i < directions; i++) {
            printf(" %8.0f deg", 360.0 * (double)i / (double)directions);
        }
        putchar('\n');
    }
    for (size_t i = 0; i < s->n_rows && directions > 0; i++) {
        const Pelagos__SpectrumRow *r = s->rows[i];
        printf("%9.4f", r->omega);
        for (size_t k = 0; k < r->n_directional; k++) {
            printf(" %12.4e", r->directional[k]);
        }
        putchar('\n');
    }
}

static void print_spectrum(const Pelagos__Spectrum *s)
{
    printf("%-24s %9s %12s %12s %12s\n", "", "Hs m", "slope along", "across",
           "total");
    print_moments("spectrum", s->spectrum);
    print_moments("drawn", s->drawn);
    if (s->spectrum_below && s->drawn_below) {
        char name[48];
        g_snprintf(name, sizeof name, "spectrum below %g m", s->wavelength);
        print_moments(name, s->spectrum_below);
        g_snprintf(name, sizeof name, "drawn below %g m", s->wavelength);
        print_moments(name, s->drawn_below);
    }
    if (s->whitecaps > 0) {
        printf("whitecaps %.2f %%\n", 100.0 * s->whitecaps);
    }
    if (s->has_peak_period) {
        printf("peak period %.3f s, ", s->peak_period);
    }
    if (s->has_mean_direction) {
        printf("waves from %.1f deg\n", s->mean_direction);
    } else {
        puts("no waves");
    }
    print_rows(s);
}

static enum ctl_exit read_options(struct ctl *ctl,
                                  Pelagos__SpectrumQuery *query)
{
    /* A table for people has rows, a series the numbers of the whole sea. */
    double frequencies = ctl_flag(ctl, "sweep") ? 0 : 12, directions = 0;
    enum ctl_exit status =
        ctl_number(ctl, "wavelength", 0.001, 1e5, &query->wavelength);
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "frequencies", 0, 200, &frequencies);
    }
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "directions", 0, 72, &directions);
    }
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "lowest", 0.05, 100, &query->lowest);
    }
    if (status == CTL_DONE) {
        status = ctl_number(ctl, "highest", 0.05, 100, &query->highest);
    }
    query->has_wavelength = ctl_flag(ctl, "wavelength");
    query->has_frequencies = query->has_directions = true;
    query->has_lowest = ctl_flag(ctl, "lowest");
    query->has_highest = ctl_flag(ctl, "highest");
    query->frequencies = (uint32_t)frequencies;
    query->directions = (uint32_t)directions;
    return status;
}

/* --format without --sweep: a file for wave models. */
static enum ctl_exit read_form(const struct ctl *ctl,
                               Pelagos__SpectrumQuery *query)
{
    static const char *const forms[] = { "ww3", "swan", "ndbc", "netcdf" };
    const char *word = ctl_value(ctl, "format");
    if (ctl_flag(ctl, "sweep") || (!word && !ctl_flag(ctl, "output"))) {
        return CTL_DONE;
    }
    for (size_t i = 0; word && i < G_N_ELEMENTS(forms); i++) {
        if (g_ascii_strcasecmp(word, forms[i]) == 0) {
            query->has_format = true;
            query->format = (Pelagos__SpectrumForm)(i + 1);
        }
    }
    if (!query->has_format) {
        return ctl_say(CTL_USAGE,
                       "--format %s: one of ww3, swan, ndbc, netcdf is wanted; "
                       "csv and json of --sweep",
                       word ? word : "");
    }
    bool named = query->format == PELAGOS__SPECTRUM_FORM__NDBC ||
                 query->format == PELAGOS__SPECTRUM_FORM__WW3_NETCDF;
    if (named && !ctl_flag(ctl, "output")) {
        return ctl_say(CTL_USAGE,
                       query->format == PELAGOS__SPECTRUM_FORM__NDBC
                           ? "ndbc is five files: --output PATH/STATION says "
                             "where"
                           : "NetCDF is not for terminals: give --output FILE");
    }
    /* The file's own numbers, where none are asked for. */
    query->has_frequencies = ctl_flag(ctl, "frequencies");
    query->has_directions = ctl_flag(ctl, "directions");
    query->frequencies = query->has_frequencies ? query->frequencies : 0;
    return CTL_DONE;
}

/* One file to --output or standard output, several beside --output. */
static enum ctl_exit put_files(const struct ctl *ctl,
                               const Pelagos__Spectrum *spectrum)
{
    const char *to = ctl_value(ctl, "output");
    enum ctl_exit status = CTL_DONE;
    if (spectrum->n_files == 0) {
        return ctl_say(CTL_UNREACHABLE, "the answer lacks its file");
    }
    for (size_t i = 0; i < spectrum->n_files && status == CTL_DONE; i++) {
        const Pelagos__SpectrumFile *file = spectrum->files[i];
        const char *ending = strrchr(file->name, '.');
        g_autofree char *path =
            spectrum->n_files > 1
                ? g_strconcat(to, ending ? ending : file->name, NULL)
                : g_strdup(to);
        status = ctl_put(path, file->content.data, file->content.len);
    }
    return status;
}

enum ctl_exit ctl_spectrum(struct ctl *ctl)
{
    Pelagos__SpectrumQuery query = PELAGOS__SPECTRUM_QUERY__INIT;
    Pelagos__State *now = NULL;
    enum ctl_exit status = read_options(ctl, &query);
    if (status == CTL_DONE) {
        status = read_form(ctl, &query);
    }
    if (status == CTL_DONE) {
        status = ctl_fetch(ctl, &now);
    }
    if (status != CTL_DONE) {
        return status;
    }
    query.patch = pel_patch_new();
    for (size_t i = 0; i < ctl->arg_count && status == CTL_DONE; i++) {
        g_autofree char *path = NULL;
        status = ctl_assign(ctl, query.patch, now, ctl->args[i], &path);
    }
    Pelagos__Spectrum *spectrum = NULL;
    struct pel_client_error error;
    bool sweeps = ctl_flag(ctl, "sweep");
    if (status == CTL_DONE && sweeps) {
        Pelagos__SeriesQuery series = PELAGOS__SERIES_QUERY__INIT;
        series.question_case = PELAGOS__SERIES_QUERY__QUESTION_SPECTRUM;
        series.spectrum = &query;
        status = ctl_series(ctl, &series);
    } else if (status == CTL_DONE &&
               pel_client_spectrum(ctl->client, &query, &spectrum, &error)) {
        status = ctl_report(ctl, &error);
    }
    if (status != CTL_DONE || sweeps) {
        /* said already */
    } else if (!spectrum->spectrum || !spectrum->drawn) {
        status = ctl_say(CTL_UNREACHABLE, "the answer lacks its sums");
    } else if (query.format != PELAGOS__SPECTRUM_FORM__NUMBERS) {
        status = put_files(ctl, spectrum);
    } else if (ctl_flag(ctl, "json")) {
        char *text = pel_json_from_message(&spectrum->base, true);
        puts(text);
        free(text);
    } else {
        print_spectrum(spectrum);
    }
    if (spectrum) {
        pelagos__spectrum__free_unpacked(spectrum, NULL);
    }
    pelagos__patch__free_unpacked(query.patch, NULL);
    pelagos__state__free_unpacked(now, NULL);
    return status;
}
