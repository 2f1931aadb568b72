#include "scene/metarset.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "message.h"
#include "ocean/ringwaves.h"
#include "optics/rain.h"
#include "path.h"
#include "scene/metar.h"

/* Limits of the schema. */
#define MOST_WIND_MPS 30.0
#define LEAST_VISIBILITY_M 200.0
#define LEAST_FOG_M 20.0
#define LEAST_BASE_M 30.0
/* Of what a report does not say. */
#define FAR_M 20000.0     /* "10 km or more" */
#define WET_FAR_M 10000.0 /* the same where it rains */
#define OVER_FOG_M 10000.0
#define FOG_TOP_M 120.0
#define SHALLOW_M 400.0 /* visibility */
#define PATCH_M 300.0
#define MIDDLE_M 2000.0 /* where middle and high clouds begin */
#define HIGH_M 6000.0
#define THUNDER_PER_MINUTE 3.0 /* an ordinary storm */

static const ProtobufCFieldDescriptor *field(const char *name)
{
    return pel_field_by_name(&pelagos__sky__descriptor, name, strlen(name));
}

static Pelagos__Fog *add_fog(Pelagos__Sky *sky, double visibility_m,
                             double top_m)
{
    Pelagos__Fog *f =
        (Pelagos__Fog *)pel_message_append(&sky->base, field("fog"));
    for (unsigned i = 0; i < f->base.descriptor->n_fields; i++) {
        pel_message_default(&f->base, &f->base.descriptor->fields[i]);
    }
    f->visibility = fmax(visibility_m, LEAST_FOG_M);
    f->top = top_m;
    f->edge = fmin(0.4 * top_m, 30);
    return f;
}

/* Three, about the origin, as they would stand where the report is from. */
static void add_banks(const Pelagos__State *state)
{
    static const double places[][3] = { { 700, 30, 450 },
                                        { 1300, 160, 700 },
                                        { 1700, 275, 900 } };
    const Pelagos__Origin *o = state->origin;
    const double metre = 1 / 111200.0; /* of latitude */
    for (int i = 0; i < 3; i++) {
        Pelagos__Fog *f = add_fog(state->sky, PATCH_M, 30 + 10 * i);
        double bearing = places[i][1] * PEL_DEG;
        f->has_radius = f->has_latitude = f->has_longitude = true;
        f->radius = places[i][2];
        f->latitude = pel_clamp(
            o->latitude + places[i][0] * cos(bearing) * metre, -90, 90);
        double east =
            places[i][0] * sin(bearing) * metre / cos(o->latitude * PEL_DEG);
        f->longitude = remainder(o->longitude + east, 360);
        f->has_time = true;
        f->time = state->clock->time;
    }
}

static void set_seeing(const Pelagos__State *state, const struct pel_metar *m)
{
    Pelagos__Sky *sky = state->sky;
    double v = m->ten_km ? FAR_M : m->visibility_m;
    bool fog = m->fog == PEL_METAR_FOG;
    pel_message_clear(&sky->base, field("fog"));
    if (m->has_visibility) {
        sky->visibility = fog ? OVER_FOG_M : fmax(v, LEAST_VISIBILITY_M);
        sky->has_visibility = true;
    }
    if (fog) {
        double top = m->octas == 8 && m->base_m > 0 ? m->base_m : FOG_TOP_M;
        add_fog(sky, m->has_visibility ? v : 500,
                pel_clamp(top, 30, FOG_TOP_M));
    } else if (m->fog == PEL_METAR_SHALLOW) {
        add_fog(sky, SHALLOW_M, 3);
    } else if (m->fog == PEL_METAR_PATCHES) {
        add_banks(state);
    }
}

/* The visibility reported is with what falls. */
static void set_falling(Pelagos__Sky *sky, const struct pel_metar *m)
{
    sky->rain = fmin(m->rain_mm_h, PEL_RAIN_MOST_MM_H);
    sky->snow = fmin(m->snow_mm_h, PEL_SNOW_MOST_MM_H);
    sky->has_rain = sky->has_snow = true;
    sky->lightning = m->thunder ? THUNDER_PER_MINUTE : 0;
    sky->has_lightning = true;
    if (m->has_visibility) {
        bool wet = m->ten_km && (sky->rain > 0 || sky->snow > 0);
        sky->visibility = wet ? WET_FAR_M : sky->visibility;
        sky->visibility =
            pel_visibility_besides(sky->visibility, &sky->rain, &sky->snow);
    }
}

static Pelagos__CloudGenus genus_of(const struct pel_metar *m)
{
    bool falls = m->rain_mm_h > 0.9 || m->snow_mm_h > 0.9;
    return m->thunderclouds || m->thunder ? PELAGOS__CLOUD_GENUS__CUMULONIMBUS
           : m->towering                  ? PELAGOS__CLOUD_GENUS__CUMULUS
           : m->base_m >= HIGH_M          ? PELAGOS__CLOUD_GENUS__CIRRUS
           : m->octas == 8 && falls       ? PELAGOS__CLOUD_GENUS__NIMBOSTRATUS
           : m->base_m >= MIDDLE_M && m->octas == 8
               ? PELAGOS__CLOUD_GENUS__ALTOSTRATUS
           : m->base_m >= MIDDLE_M ? PELAGOS__CLOUD_GENUS__ALTOCUMULUS
           : m->octas == 8         ? PELAGOS__CLOUD_GENUS__STRATUS
           : m->octas > 4          ? PELAGOS__CLOUD_GENUS__STRATOCUMULUS
                                   : PELAGOS__CLOUD_GENUS__CUMULUS;
}

static void set_clouds(Pelagos__Sky *sky, const struct pel_metar *m)
{
    static const char *const absent[] = { "cloud_thickness", "cloud_speed",
                                          "cloud_direction", "cloud_base" };
    if (!m->has_clouds) {
        return;
    }
    for (int i = 0; i < 4; i++) {
        pel_message_clear(&sky->base, field(absent[i]));
    }
    /* Of fog that hides the sky nobody saw a cloud. */
    sky->cloud_cover = m->fog == PEL_METAR_FOG && m->octas == 8 ? 0 : m->octas;
    sky->has_cloud_cover = true;
    if (sky->cloud_cover > 0) {
        sky->has_cloud_base = sky->has_cloud_genus = true;
        sky->cloud_base = pel_clamp(m->base_m, LEAST_BASE_M, 12000);
        sky->cloud_genus = genus_of(m);
    }
}

enum pel_err pel_metar_settle(Pelagos__State *state, struct pel_fault *fault)
{
    struct pel_metar m;
    if (!state->sky || !state->sky->metar) {
        return PEL_OK;
    }
    enum pel_err err = pel_metar_parse(state->sky->metar, &m, fault);
    if (err) {
        return err;
    }
    if (m.has_wind) {
        state->sea->wind_speed = fmin(m.wind_mps, MOST_WIND_MPS);
        state->sea->has_wind_speed = true;
    }
    if (m.has_direction) {
        state->sea->wind_direction = m.direction_deg;
        state->sea->has_wind_direction = true;
    }
    set_seeing(state, &m);
    set_falling(state->sky, &m);
    set_clouds(state->sky, &m);
    pel_message_clear(&state->sky->base, field("metar"));
    return PEL_OK;
}
