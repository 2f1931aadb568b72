#include "scene/numbers.h"

#include <math.h>
#include <stdlib.h>

#include "base/reserve.h"
#include "fields.h"
#include "json.h"
#include "message.h"
#include "ocean/directional.h"
#include "ocean/foam.h"
#include "ocean/report.h"
#include "ocean/seastate.h"
#include "ocean/spectrumwrite.h"
#include "scene/scene_parts.h"
#include "scene/sun.h"

#define MAX_WAITING 128

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
        out->directional =
            pel_sure_calloc(directions, sizeof *out->directional);
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
    out->rows = pel_sure_calloc(n, sizeof(Pelagos__SpectrumRow *));
    out->n_rows = n;
    for (unsigned i = 0; i < n; i++) {
        double omega = n > 1 ? lo * pow(hi / lo, (double)i / (n - 1)) : lo;
        out->rows[i] =
            row(spectrum, omega, query->has_directions ? query->directions : 0);
    }
}

/* How people call it. */
static void add_words(const struct pel_sea_desc *desc, double m0,
                      const struct pel_sea_parts *parts, Pelagos__Spectrum *out)
{
    out->has_wind_sea_height = out->has_swell_height = true;
    out->wind_sea_height = 4.0 * sqrt(parts->wind_sea_m0);
    out->swell_height = 4.0 * sqrt(parts->swell_m0);
    out->has_beaufort = out->has_douglas = true;
    out->beaufort = pel_beaufort_of(desc->wind_mps);
    out->douglas = pel_douglas_of(4.0 * sqrt(m0));
    out->has_wave_age = parts->wave_age > 0;
    out->wave_age = parts->wave_age;
}

static Pelagos__Spectrum *answer(const struct pel_sea *sea,
                                 const struct pel_directional *spectrum,
                                 const struct pel_sea_parts *parts,
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
    out->has_whitecaps = true;
    out->whitecaps = sea->foam ? sea->foam->coverage : 0;
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
    add_words(&sea->desc, report.spectrum.m0, parts, out);
    add_rows(spectrum, query, out);
    return out;
}

/* Of where, when and what the files are. */
static void describe(const Pelagos__State *state,
                     struct pel_spectrum_place *out)
{
    const Pelagos__Sea *sea = state->sea;
    double epoch = 0;
    if (pel_utc_parse(state->clock->utc, &epoch)) {
        epoch = 0; /* the state was tested */
    }
    *out = (struct pel_spectrum_place){
        .station = "pelagos",
        .latitude = state->origin->latitude,
        .longitude = state->origin->longitude,
        .depth_m = sea->has_depth ? sea->depth : 0,
        .wind_mps = sea->wind_speed,
        .wind_from_deg = sea->wind_direction,
        .unix_s = epoch + state->clock->time,
    };
}

static enum pel_err add_files(const struct pel_directional *spectrum,
                              const Pelagos__State *state,
                              const Pelagos__SpectrumQuery *query,
                              Pelagos__Spectrum *out, struct pel_fault *fault)
{
    struct pel_spectrum_place place;
    struct pel_spectrum_files files;
    const struct pel_spectrum_grid grid = {
        .frequencies = query->frequencies ? (int)query->frequencies : 60,
        .lowest_hz = query->lowest / (2.0 * PEL_PI),
        .highest_hz = query->highest / (2.0 * PEL_PI),
        .directions = query->directions ? (int)query->directions : 36,
    };
    describe(state, &place);
    char *question = pel_json_from_message(&query->base, false);
    char *sea = pel_json_from_message(&state->sea->base, false);
    g_autofree char *history = g_strdup_printf("pelagosd %s: %s of the sea %s",
                                               PEL_VERSION, question, sea);
    free(question);
    free(sea);
    place.history = history;
    enum pel_err err = pel_spectrum_write(
        spectrum, (enum pel_spectrum_form)(query->format - 1), &grid, &place,
        &files, fault);
    for (int i = 0; i < files.count && !err; i++) {
        Pelagos__SpectrumFile *file =
            (Pelagos__SpectrumFile *)pel_message_append(
                &out->base,
                pel_field_by_name(out->base.descriptor, "files", 5));
        file->name = pel_sure_strdup(files.file[i].name);
        file->type = pel_sure_strdup(files.type);
        file->has_content = true;
        file->content =
            (ProtobufCBinaryData){ files.file[i].size, files.file[i].data };
        files.file[i].data = NULL; /* the message's */
    }
    if (!err) {
        pel_spectrum_files_finish(&files);
    }
    return err;
}

/* --- on a thread ---------------------------------------------------------- */

struct asked {
    struct pel_task task;
    Pelagos__State *state; /* with the query's patch */
    const struct pel_sea_means *means;
    struct pel_shared_sea *present;
    Pelagos__SpectrumQuery query; /* its numbers alone */
    enum pel_err err;
    struct pel_fault fault;
    Pelagos__Spectrum *answer;
    pel_spectrum_done done;
    void *user;
};

static void work(struct pel_task *task)
{
    struct asked *a = (struct asked *)task;
    struct pel_shared_sea *shared = NULL;
    struct pel_directional *spectrum = NULL;
    a->err = pel_shared_sea_get(a->state, a->means, NULL, a->present, &shared,
                                &a->fault);
    if (a->err) {
        return;
    }
    const struct pel_sea *sea = pel_shared_sea_value(shared);
    struct pel_sea_parts parts;
    a->err = pel_directional_create(&sea->desc, &spectrum);
    if (!a->err) {
        a->err = pel_sea_parts(&sea->desc, &parts);
    }
    if (a->err) {
        pel_fault_set(&a->fault, a->err, "the spectrum: %s",
                      pel_err_name(a->err));
    } else {
        a->answer = answer(sea, spectrum, &parts, &a->query);
        if (a->query.format != PELAGOS__SPECTRUM_FORM__NUMBERS) {
            a->err =
                add_files(spectrum, a->state, &a->query, a->answer, &a->fault);
        }
    }
    pel_directional_destroy(spectrum);
    pel_shared_sea_unref(shared);
}

static void tell(struct pel_task *task, bool dropped)
{
    struct asked *a = (struct asked *)task;
    if (dropped) {
        a->err = pel_fault_set(&a->fault, PEL_ERR_CONFLICT,
                               "the daemon is stopping");
    }
    a->done(a->user, a->err, &a->fault, a->err ? NULL : a->answer);
    if (a->answer) {
        pelagos__spectrum__free_unpacked(a->answer, NULL);
    }
    pel_shared_sea_unref(a->present);
    pelagos__state__free_unpacked(a->state, NULL);
    g_free(a);
}

enum pel_err pel_scene_ask_spectrum(struct pel_scene *scene,
                                    const Pelagos__SpectrumQuery *query,
                                    pel_spectrum_done done, void *user,
                                    struct pel_fault *fault)
{
    Pelagos__State *state = NULL;
    if (pel_worker_count(scene->numbers) >= MAX_WAITING) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d spectra are asked for already", MAX_WAITING);
    }
    if (query->patch) {
        enum pel_err err = pel_scene_edited(
            scene, query->patch, pel_scene_time(scene), &state, fault);
        if (err) {
            return err;
        }
    } else {
        state = (Pelagos__State *)pel_message_copy(&scene->state->base);
        state->clock->time = pel_scene_time(scene);
    }
    struct asked *a = g_new0(struct asked, 1);
    a->task = (struct pel_task){ .work = work, .done = tell };
    a->state = state;
    a->means = &scene->means;
    a->present = pel_shared_sea_ref(scene->has.sea);
    a->query = *query;
    a->query.patch = NULL;
    a->done = done;
    a->user = user;
    pel_worker_push(scene->numbers, &a->task);
    return PEL_OK;
}

struct kept {
    enum pel_err err;
    struct pel_fault *fault;
    Pelagos__Spectrum **answer;
};

static void keep(void *user, enum pel_err err, const struct pel_fault *fault,
                 const Pelagos__Spectrum *answer)
{
    struct kept *kept = user;
    kept->err = err;
    if (err && kept->fault) {
        *kept->fault = *fault;
    } else if (!err) {
        *kept->answer = (Pelagos__Spectrum *)pel_message_copy(&answer->base);
    }
}

enum pel_err pel_scene_spectrum(struct pel_scene *scene,
                                const Pelagos__SpectrumQuery *query,
                                Pelagos__Spectrum **out,
                                struct pel_fault *fault)
{
    struct kept kept = { PEL_OK, fault, out };
    *out = NULL;
    enum pel_err err = pel_scene_ask_spectrum(scene, query, keep, &kept, fault);
    while (!err && pel_worker_wait(scene->numbers)) {
    }
    return err ? err : kept.err;
}
