#include "scene/numbers.h"

#include <math.h>
#include <stdlib.h>

#include "message.h"
#include "ocean/directional.h"
#include "ocean/report.h"
#include "scene/build.h"

/* Compass direction it comes from of a mathematical one it goes to. */
static double comes_from(double to_rad)
{
    double turned = fmod(270.0 - to_rad / PEL_DEG, 360.0);
    return turned < 0 ? turned + 360.0 : turned;
}

static Pelagos__SeaMoments *moments(const struct pel_sea_moments *m)
{
    Pelagos__SeaMoments *out = (Pelagos__SeaMoments *)pel_message_new(
        &pelagos__sea_moments__descriptor);
    out->has_significant_height = out->has_slope_along = true;
    out->has_slope_cross = out->has_slope_mixed = true;
    out->significant_height = 4.0 * sqrt(m->m0);
    out->slope_along = m->slopes.along;
    out->slope_cross = m->slopes.cross;
    out->slope_mixed = m->slopes.mixed;
    return out;
}

static Pelagos__SpectrumRow *row(const struct pel_directional *spectrum,
                                 double omega, unsigned directions)
{
    Pelagos__SpectrumRow *out = (Pelagos__SpectrumRow *)pel_message_new(
        &pelagos__spectrum_row__descriptor);
    struct pel_spectrum_row at;
    pel_spectrum_row(spectrum, omega, &at);
    out->has_omega = out->has_density = true;
    out->omega = omega;
    out->density = at.density;
    if (at.density > 0) {
        out->has_direction = out->has_spread = true;
        out->direction = comes_from(at.mean_to_rad);
        out->spread = sqrt(fmax(2.0 - 2.0 * at.r1, 0.0)) / PEL_DEG;
    }
    if (directions > 0) {
        out->n_directional = directions;
        out->directional = calloc(directions, sizeof *out->directional);
        if (!out->directional) {
            abort();
        }
    }
    for (unsigned i = 0; i < directions; i++) {
        double to_deg = 270.0 - 360.0 * i / directions;
        out->directional[i] =
            pel_directional_at(spectrum, omega, to_deg * PEL_DEG);
    }
    return out;
}

static void add_rows(const struct pel_directional *spectrum,
                     const Pelagos__SpectrumQuery *query,
                     Pelagos__Spectrum *out)
{
    unsigned n = query->has_frequencies ? query->frequencies : 0;
    double lo = query->lowest, hi = query->highest;
    if (n == 0) {
        return;
    }
    out->rows = calloc(n, sizeof(Pelagos__SpectrumRow *));
    if (!out->rows) {
        abort();
    }
    out->n_rows = n;
    for (unsigned i = 0; i < n; i++) {
        double omega = n > 1 ? lo * pow(hi / lo, (double)i / (n - 1)) : lo;
        out->rows[i] =
            row(spectrum, omega, query->has_directions ? query->directions : 0);
    }
}

static Pelagos__Spectrum *answer(const struct pel_sea *sea,
                                 const struct pel_directional *spectrum,
                                 const Pelagos__SpectrumQuery *query)
{
    Pelagos__Spectrum *out =
        (Pelagos__Spectrum *)pel_message_new(&pelagos__spectrum__descriptor);
    struct pel_sea_report report;
    double wavelength = query->has_wavelength ? query->wavelength : 0;
    pel_sea_report(sea, spectrum, wavelength, &report);
    out->spectrum = moments(&report.spectrum);
    out->drawn = moments(&report.drawn);
    if (report.peak_omega > 0) {
        out->has_peak_period = true;
        out->peak_period = 2.0 * PEL_PI / report.peak_omega;
    }
    if (report.spectrum.m0 > 0) {
        out->has_mean_direction = true;
        out->mean_direction = comes_from(report.mean_to_rad);
    }
    if (query->has_wavelength) {
        out->has_wavelength = true;
        out->wavelength = wavelength;
        out->spectrum_below = moments(&report.spectrum_below);
        out->drawn_below = moments(&report.drawn_below);
    }
    add_rows(spectrum, query, out);
    return out;
}

enum pel_err pel_scene_spectrum(struct pel_scene *scene,
                                const Pelagos__SpectrumQuery *query,
                                Pelagos__Spectrum **out,
                                struct pel_fault *fault)
{
    struct pel_shared_sea *shared = NULL;
    struct pel_directional *spectrum = NULL;
    *out = NULL;
    enum pel_err err = pel_scene_try(scene, query->patch, &shared, fault);
    if (err) {
        return err;
    }
    const struct pel_sea *sea = pel_shared_sea_value(shared);
    err = pel_directional_create(&sea->desc, &spectrum);
    if (err) {
        pel_fault_set(fault, err, "the spectrum: %s", pel_err_name(err));
    } else {
        *out = answer(sea, spectrum, query);
    }
    pel_directional_destroy(spectrum);
    pel_shared_sea_unref(shared);
    return err;
}
