/* The sea that the state describes, and which of two states have the same. */
#include <glib.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "base/reserve.h"
#include "fault.h"
#include "ocean/directional.h"
#include "ocean/ndbc.h"
#include "ocean/seastate.h"
#include "ocean/spectrumfile.h"
#include "scene/build.h"
#include "scene/check.h"
#include "scene/ground.h"
#include "scene/metarset.h"
#include "scene/sharedsea.h"
#include "scene/spectra.h"
#include "scene/sun.h"

double pel_goes_to(double from_deg)
{
    return remainder(90.0 - (from_deg + 180.0), 360.0) * PEL_DEG;
}

static void place_area(const Pelagos__Area *from, struct pel_area_desc *to)
{
    double course = from->course * PEL_DEG;
    *to = (struct pel_area_desc){
        .east_m = from->east,
        .north_m = from->north,
        .radius_m = from->radius,
        .velocity_east_mps = from->speed * sin(course),
        .velocity_north_mps = from->speed * cos(course),
        .time_s = from->time,
        .edge_m = from->edge,
        .factor = from->factor,
    };
    int corners =
        from->corners ? pel_corners_parse(from->corners, to->corner) : 0;
    to->corner_count = corners > 0 ? corners : 0; /* which check.c refused */
}

void pel_sea_describe(const Pelagos__State *state, int wave_count,
                      struct pel_sea_desc *out)
{
    const Pelagos__Sea *sea = state->sea;
    *out = (struct pel_sea_desc){ 0 };
    out->synthesiser = (enum pel_synthesiser)sea->synthesiser;
    out->kind = (enum pel_spectrum_kind)sea->spectrum; /* SAME, below */
    out->depth_m = sea->has_depth ? sea->depth : 0;
    out->direction_rad = pel_goes_to(sea->wind_direction);
#define PEL_SPECTRUM_NUMBER(ID, member, field, ...) out->member = sea->field;
#include "ocean/spectra.def"
    out->seed = sea->seed;
    out->whitecaps = sea->whitecaps;
    out->rain_mm_h = state->sky->rain;
    out->wave_count = wave_count;
    out->steady = sea->field && sea->field->file && *sea->field->file;
    out->swell_count = (int)sea->n_swell;
    for (size_t i = 0; i < sea->n_swell; i++) {
        out->swell[i].height_m = sea->swell[i]->height;
        out->swell[i].period_s = sea->swell[i]->period;
        out->swell[i].direction_rad = pel_goes_to(sea->swell[i]->direction);
        out->swell[i].spread_rad = sea->swell[i]->spread * PEL_DEG;
    }
    out->single_count = (int)sea->n_wave;
    for (size_t i = 0; i < sea->n_wave; i++) {
        out->single[i].height_m = sea->wave[i]->height;
        out->single[i].period_s = sea->wave[i]->period;
        out->single[i].direction_rad = pel_goes_to(sea->wave[i]->direction);
        out->single[i].phase_rad = sea->wave[i]->phase * PEL_DEG;
    }
    out->area_count = (int)sea->n_areas;
    for (size_t i = 0; i < sea->n_areas; i++) {
        place_area(sea->areas[i], &out->area[i]);
    }
}

/* Which record the state means; NULL: its spectrum is not measured. */
static char *record_of(const Pelagos__State *state)
{
    const Pelagos__Sea *sea = state->sea;
    return pel_spectrum_reads(sea->spectrum, "sea.measured")
               ? g_strdup_printf("%s %s", sea->measured ? sea->measured : "",
                                 sea->measured_time ? sea->measured_time : "")
               : NULL;
}

/* Splits FILE#STATION, where FILE may have a # of its own: it is the shortest
 * that there is, or what stands before the first #. */
static char *station_of(const char *spectra, char *name)
{
    char *first = strchr(name, '#'), *mark = first;
    while (mark) {
        *mark = '\0';
        if (pel_helper_find(spectra, name, NULL) == PEL_OK) {
            return mark + 1;
        }
        *mark = '#';
        mark = strchr(mark + 1, '#');
    }
    if (!first || pel_helper_find(spectra, name, NULL) == PEL_OK) {
        return name + strlen(name);
    }
    *first = '\0';
    return first + 1;
}

static enum pel_err read_record(const Pelagos__Sea *sea, const char *spectra,
                                struct pel_measured *out,
                                struct pel_fault *fault)
{
    double unix_s = NAN;
    enum pel_err err = PEL_OK;
    if (!spectra) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "sea.spectrum MEASURED needs pelagosd --spectra");
    }
    if (sea->measured_time && *sea->measured_time) {
        err = pel_utc_parse(sea->measured_time, &unix_s);
        if (err) {
            pel_fault_set(fault, err,
                          "sea.measuredTime must be ISO 8601 with its zone, "
                          "like 2026-06-21T12:00:00Z");
            pel_fault_at(fault, "sea.measuredTime", sea->measured_time);
            return err;
        }
    }
    const char *name = sea->measured ? sea->measured : "";
    if (strchr(name, '.')) { /* a buoy's name has no dot */
        g_autofree char *file = g_strdup(name);
        char *station = station_of(spectra, file);
        err = pel_spectrum_file_read(spectra, file, station, unix_s, out, NULL,
                                     fault);
    } else {
        err = pel_ndbc_read(spectra, name, unix_s, out, NULL, fault);
    }
    if (err) {
        pel_fault_at(fault, "sea.measured", sea->measured);
    }
    return err;
}

static bool same_swell(const struct pel_swell_desc *a,
                       const struct pel_swell_desc *b)
{
    return a->height_m == b->height_m && a->period_s == b->period_s &&
           a->direction_rad == b->direction_rad &&
           a->spread_rad == b->spread_rad;
}

static bool same_single(const struct pel_single_desc *a,
                        const struct pel_single_desc *b)
{
    return a->height_m == b->height_m && a->period_s == b->period_s &&
           a->direction_rad == b->direction_rad && a->phase_rad == b->phase_rad;
}

static bool same_area(const struct pel_area_desc *a,
                      const struct pel_area_desc *b)
{
    bool same = a->east_m == b->east_m && a->north_m == b->north_m &&
                a->radius_m == b->radius_m && a->edge_m == b->edge_m &&
                a->velocity_east_mps == b->velocity_east_mps &&
                a->velocity_north_mps == b->velocity_north_mps &&
                a->time_s == b->time_s && a->factor == b->factor &&
                a->corner_count == b->corner_count;
    for (int i = 0; same && i < a->corner_count; i++) {
        same = a->corner[i].x == b->corner[i].x &&
               a->corner[i].y == b->corner[i].y;
    }
    return same;
}

static bool same_sea(const struct pel_sea_desc *a, const struct pel_sea_desc *b)
{
    bool same = a->synthesiser == b->synthesiser && a->kind == b->kind &&
                a->depth_m == b->depth_m && a->whitecaps == b->whitecaps &&
                a->rain_mm_h == b->rain_mm_h && a->steady == b->steady &&
                a->direction_rad == b->direction_rad && a->seed == b->seed &&
                a->wave_count == b->wave_count &&
                a->swell_count == b->swell_count;
#define PEL_SPECTRUM_NUMBER(ID, member, ...)                                   \
    same = same && a->member == b->member;
#include "ocean/spectra.def"
    for (int i = 0; same && i < a->swell_count; i++) {
        same = same_swell(&a->swell[i], &b->swell[i]);
    }
    same = same && a->single_count == b->single_count;
    for (int i = 0; same && i < a->single_count; i++) {
        same = same_single(&a->single[i], &b->single[i]);
    }
    same = same && a->area_count == b->area_count;
    for (int i = 0; same && i < a->area_count; i++) {
        same = same_area(&a->area[i], &b->area[i]);
    }
    return same;
}

/* Of what its waves feel; no reference. */
static struct pel_laid laid_over(const Pelagos__State *state,
                                 const struct pel_ground *ground)
{
    bool feels = ground && ground->bed && state->seabed->waves;
    return feels ? (struct pel_laid){ ground->bed, state->sea->level,
                                      state->water->depth }
                 : (struct pel_laid){ 0 };
}

static bool same_laid(const struct pel_laid *a, const struct pel_laid *b)
{
    return a->bed == b->bed && a->level_m == b->level_m &&
           a->beyond_m == b->beyond_m;
}

static enum pel_err new_sea(const struct pel_sea_desc *desc,
                            const struct pel_laid *laid, const char *record,
                            struct pel_shared_sea **out,
                            struct pel_fault *fault)
{
    struct pel_shared_sea *sea = calloc(1, sizeof *sea);
    enum pel_err err = !sea                     ? PEL_ERR_NO_MEMORY
                       : !pel_sea_desc_ok(desc) ? PEL_ERR_OUT_OF_RANGE
                                                : PEL_OK;
    if (err) {
        free(sea);
        pel_fault_set(fault, err, "no sea can be made of sea.*: %s",
                      pel_err_name(err));
        pel_fault_at(fault, "sea", NULL);
        return err;
    }
    sea->desc = *desc;
    sea->laid = *laid;
    sea->laid.bed = pel_seabed_ref(laid->bed);
    sea->record = record ? pel_sure_strdup(record) : NULL;
    atomic_init(&sea->refs, 1);
    atomic_init(&sea->built, false);
    pthread_mutex_init(&sea->lock, NULL);
    *out = sea;
    return PEL_OK;
}

enum pel_err pel_shared_sea_get(const Pelagos__State *state,
                                const struct pel_sea_means *means,
                                const struct pel_ground *ground,
                                struct pel_shared_sea *present,
                                struct pel_shared_sea **out,
                                struct pel_fault *fault)
{
    struct pel_sea_desc desc;
    const struct pel_laid laid = laid_over(state, ground);
    pel_sea_describe(state, means->wave_count, &desc);
    char *record = record_of(state);
    bool same_record = present && g_strcmp0(record, present->record) == 0;
    enum pel_err err = PEL_OK;
    if (same_record) {
        desc.measured = present->desc.measured;
    } else if (record) {
        err = read_record(state->sea, means->spectra, &desc.measured, fault);
    }
    if (!err && same_record && same_sea(&desc, &present->desc) &&
        (!ground || same_laid(&laid, &present->laid))) {
        *out = pel_shared_sea_ref(present);
        g_free(record);
        return PEL_OK;
    }
    if (!err) {
        err = new_sea(&desc, &laid, record, out, fault);
    }
    g_free(record);
    return err;
}

bool pel_shared_sea_same_record(const struct pel_shared_sea *sea,
                                const Pelagos__State *state)
{
    g_autofree char *record = record_of(state);
    return g_strcmp0(record, sea->record) == 0;
}

bool pel_shared_sea_is(const struct pel_shared_sea *sea,
                       const Pelagos__State *state,
                       const struct pel_sea_means *means,
                       const struct pel_ground *ground)
{
    const struct pel_laid laid = laid_over(state, ground);
    struct pel_sea_desc desc;
    pel_sea_describe(state, means->wave_count, &desc);
    desc.measured = sea->desc.measured;
    return pel_shared_sea_same_record(sea, state) &&
           same_sea(&desc, &sea->desc) && same_laid(&laid, &sea->laid);
}

enum pel_err pel_sea_settle(Pelagos__State *state, struct pel_fault *fault)
{
    Pelagos__Sea *sea = state->sea;
    enum pel_err err = pel_metar_settle(state, fault);
    if (err) {
        return err;
    }
    if (sea->has_beaufort && sea->has_douglas) {
        pel_fault_set(fault, PEL_ERR_CONFLICT,
                      "sea.beaufort and sea.douglas both set the wind; give "
                      "one");
        pel_fault_at(fault, "sea.douglas", NULL);
        return PEL_ERR_CONFLICT;
    }
    if (sea->has_beaufort) {
        sea->wind_speed = pel_beaufort_wind(sea->beaufort);
    }
    if (sea->has_douglas) {
        struct pel_sea_desc desc;
        pel_sea_describe(state, 60, &desc);
        sea->wind_speed =
            pel_wind_for_height(&desc, pel_douglas_height(sea->douglas));
    }
    sea->has_beaufort = sea->has_douglas = false;
    return PEL_OK;
}
