#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/vec.h"
#include "bridges/cigi_exercise.h"
#include "bridges/cigi_pose.h"
#include "bridges/cigi_world.h"
#include "scene/ephemeris.h"
#include "scene/geodesy.h"
#include "scene/spectra.h"
#include "scene/sun.h"

#define MAX_WIND_MPS 30.0
#define MIN_VISIBILITY_M 200.0
#define MAX_VISIBILITY_M 300000.0
#define SURFACE_LAYER_M 10.0
#define ENTITY 0
#define REGIONAL_SEA 4
#define GLOBAL_SEA 7
#define FIRST_TRAIN 16 /* component id of a region's swell train 0 */
#define CLOCK_SLACK_S 2.0

double pel_cigi_chlorophyll(double clarity)
{
    return 30.0 * pow(10.0, -3.0 * pel_clamp(clarity, 0, 100) / 100.0);
}

double pel_cigi_clarity(double chlorophyll_mg_m3)
{
    return pel_clamp(100.0 / 3.0 * log10(30.0 / chlorophyll_mg_m3), 0, 100);
}

/* --- whose conditions ---------------------------------------------------- */

static struct pel_cigi_region *region_of(struct pel_cigi_edit *edit,
                                         unsigned id, bool make)
{
    struct pel_cigi_region *spare = NULL;
    for (size_t i = 0; i < PEL_CIGI_REGIONS; i++) {
        struct pel_cigi_region *r = &edit->world->regions[i];
        if (r->used && r->id == id) {
            return r;
        }
        spare = !r->used && !spare ? r : spare;
    }
    if (!make || !spare) {
        return NULL;
    }
    *spare = (struct pel_cigi_region){ .used = true, .id = id };
    return spare;
}

/* Conditions of the scope 0 (global) or 1 (regional); NULL: counted. */
static struct pel_cigi_conditions *conditions_of(struct pel_cigi_edit *edit,
                                                 double scope, double region)
{
    struct pel_cigi_region *r =
        scope == 1 ? region_of(edit, (unsigned)region, true) : NULL;
    if (scope == 0) {
        return &edit->world->global;
    }
    edit->skipped += !r;
    return r ? &r->conditions : NULL;
}

static void take_region(struct pel_cigi_edit *edit,
                        const struct pel_cigi_packet *p)
{
    double state = pel_cigi_get(p, PEL_CIGI_REGION_STATE);
    unsigned id = (unsigned)pel_cigi_get(p, PEL_CIGI_REGION_ID);
    struct pel_cigi_region *r = region_of(edit, id, state < 2);
    if (!r) {
        edit->skipped += state < 2;
        return;
    }
    r->used = state < 2;
    r->active = state == 1;
    r->latitude = pel_cigi_get(p, PEL_CIGI_REGION_LATITUDE);
    r->longitude = pel_cigi_get(p, PEL_CIGI_REGION_LONGITUDE);
    r->x_m = pel_cigi_get(p, PEL_CIGI_REGION_X);
    r->y_m = pel_cigi_get(p, PEL_CIGI_REGION_Y);
    r->radius_m = pel_cigi_get(p, PEL_CIGI_REGION_RADIUS);
    r->rotation_deg = pel_cigi_get(p, PEL_CIGI_REGION_ROTATION);
    r->transition_m = fmax(pel_cigi_get(p, PEL_CIGI_REGION_TRANSITION), 0);
}

/* --- packets ------------------------------------------------------------- */

static void set_wind(struct pel_cigi_conditions *c, double mps, double deg)
{
    c->has_wind = true;
    c->wind_mps = pel_clamp(mps, 0, MAX_WIND_MPS);
    c->wind_deg = pel_cigi_wrap(deg);
}

static double visibility(double metres)
{
    return pel_clamp(metres, MIN_VISIBILITY_M, MAX_VISIBILITY_M);
}

static void take_atmosphere(struct pel_cigi_edit *edit,
                            const struct pel_cigi_packet *p)
{
    struct pel_cigi_world *w = edit->world;
    w->global.has_visibility = true;
    w->global.visibility_m =
        visibility(pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_VISIBILITY));
    set_wind(&w->global, pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_WIND),
             pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_WIND_DIRECTION));
    w->humidity = pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_HUMIDITY);
    w->air_temperature = pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_TEMPERATURE);
    w->pressure = pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_PRESSURE);
    w->vertical_wind_mps = pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_VERTICAL_WIND);
}

/* The layer that began it ends it. */
static void take_lightning(struct pel_cigi_edit *edit,
                           const struct pel_cigi_packet *p)
{
    struct pel_cigi_world *w = edit->world;
    unsigned layer = 1 + (unsigned)pel_cigi_get(p, PEL_CIGI_WEATHER_LAYER);
    bool on = pel_cigi_get(p, PEL_CIGI_WEATHER_ENABLE) != 0 &&
              pel_cigi_get(p, PEL_CIGI_WEATHER_LIGHTNING) != 0;
    double rate = on ? 2 * (1 + pel_cigi_get(p, PEL_CIGI_WEATHER_SEVERITY)) : 0;
    if (pel_cigi_get(p, PEL_CIGI_WEATHER_SCOPE) != 0 ||
        (!on && w->lightning_layer != layer)) {
        return;
    }
    w->lightning_layer = on ? layer : 0;
    if (edit->scene->sky->lightning != rate) {
        edit->sky.has_lightning = true;
        edit->sky.lightning = rate;
        edit->state.sky = &edit->sky;
    }
}

static void take_weather(struct pel_cigi_edit *edit,
                         const struct pel_cigi_packet *p)
{
    take_lightning(edit, p);
    struct pel_cigi_conditions *c =
        conditions_of(edit, pel_cigi_get(p, PEL_CIGI_WEATHER_SCOPE),
                      pel_cigi_get(p, PEL_CIGI_WEATHER_REGION));
    bool seen = c && pel_cigi_take_layer(edit, p);
    bool low = pel_cigi_get(p, PEL_CIGI_WEATHER_LAYER) == 0 ||
               pel_cigi_get(p, PEL_CIGI_WEATHER_BASE) <= SURFACE_LAYER_M;
    if (!c || !low) {
        return;
    }
    bool on = pel_cigi_get(p, PEL_CIGI_WEATHER_ENABLE) != 0;
    c->has_layer_visibility = on && !seen;
    c->has_layer_wind = on;
    c->layer_visibility_m =
        visibility(pel_cigi_get(p, PEL_CIGI_WEATHER_VISIBILITY));
    c->layer_wind_mps =
        pel_clamp(pel_cigi_get(p, PEL_CIGI_WEATHER_WIND), 0, MAX_WIND_MPS);
    c->layer_wind_deg =
        pel_cigi_wrap(pel_cigi_get(p, PEL_CIGI_WEATHER_WIND_DIRECTION));
}

/* "Disabled" says that a region is as the whole sea is; CIGI 3.3, 4.1.13
 * has it ignored for the whole sea itself. */
static void take_maritime(struct pel_cigi_edit *edit,
                          const struct pel_cigi_packet *p)
{
    double scope = pel_cigi_get(p, PEL_CIGI_MARITIME_SCOPE);
    struct pel_cigi_conditions *c =
        conditions_of(edit, scope, pel_cigi_get(p, PEL_CIGI_MARITIME_REGION));
    if (!c) {
        return;
    }
    c->has_chlorophyll =
        scope == 0 || pel_cigi_get(p, PEL_CIGI_MARITIME_ENABLE) != 0;
    c->chlorophyll_mg_m3 =
        pel_cigi_chlorophyll(pel_cigi_get(p, PEL_CIGI_MARITIME_CLARITY));
    c->has_level = c->has_chlorophyll;
    c->level_m = pel_cigi_get(p, PEL_CIGI_MARITIME_HEIGHT);
    c->has_whitecaps = c->has_chlorophyll;
    c->whitecaps = pel_cigi_get(p, PEL_CIGI_MARITIME_WHITECAPS);
    if (c->has_chlorophyll) {
        edit->world->water_temperature =
            pel_cigi_get(p, PEL_CIGI_MARITIME_TEMPERATURE);
    }
}

/* Puts one of a list of trains in the place of its key, or in a free one. */
static void set_train(struct pel_cigi_edit *edit, struct pel_cigi_train *list,
                      const struct pel_cigi_train *with)
{
    struct pel_cigi_train *spare = NULL, *at = NULL;
    for (size_t i = 0; i < PEL_CIGI_TRAINS && !at; i++) {
        at = list[i].used && list[i].key == with->key ? &list[i] : NULL;
        spare = !list[i].used && !spare ? &list[i] : spare;
    }
    at = at ? at : spare;
    if (!at && with->used) {
        edit->skipped++;
    } else if (at) {
        *at = *with;
    }
}

static void take_wave(struct pel_cigi_edit *edit,
                      const struct pel_cigi_packet *p)
{
    struct pel_cigi_conditions *c =
        conditions_of(edit, pel_cigi_get(p, PEL_CIGI_WAVE_SCOPE),
                      pel_cigi_get(p, PEL_CIGI_WAVE_REGION));
    if (!c) {
        return;
    }
    double length_m = pel_cigi_get(p, PEL_CIGI_WAVE_LENGTH);
    double period_s = pel_cigi_get(p, PEL_CIGI_WAVE_PERIOD);
    if (period_s <= 0) {
        period_s = sqrt(2 * PEL_PI * fmax(length_m, 0) / PEL_GRAVITY);
    }
    struct pel_cigi_train wave = {
        .used = pel_cigi_get(p, PEL_CIGI_WAVE_ENABLE) != 0,
        .key = (unsigned)pel_cigi_get(p, PEL_CIGI_WAVE_ID),
        .height_m = pel_cigi_get(p, PEL_CIGI_WAVE_HEIGHT),
        .period_s = pel_clamp(period_s, 1, 30),
        .from_deg =
            pel_cigi_wrap(pel_cigi_get(p, PEL_CIGI_WAVE_DIRECTION) + 180),
        .phase_deg = pel_cigi_wrap(pel_cigi_get(p, PEL_CIGI_WAVE_PHASE)),
    };
    c->has_waves = true;
    set_train(edit, c->waves, &wave);
}

/* Sun and Moon of a moment, which stay whatever the clock does. */
static void stop_sun(struct pel_cigi_edit *edit, double unix_s)
{
    double azimuth, elevation;
    pel_sun_position(unix_s, edit->snapshot->origin_latitude_rad,
                     edit->snapshot->origin_longitude_rad, &azimuth,
                     &elevation);
    edit->sky.has_sun_azimuth = edit->sky.has_sun_elevation = true;
    edit->sky.sun_azimuth = pel_cigi_wrap(azimuth / PEL_DEG);
    edit->sky.sun_elevation = pel_clamp(elevation / PEL_DEG, -90, 90);
    struct pel_moon_place moon;
    pel_ephemeris_moon(unix_s, edit->snapshot->origin_latitude_rad,
                       edit->snapshot->origin_longitude_rad, &moon);
    struct pel_vec3 to = moon.direction;
    edit->sky.has_moon_azimuth = edit->sky.has_moon_elevation =
        edit->sky.has_moon_phase = true;
    edit->sky.moon_azimuth = pel_cigi_wrap(atan2(to.x, to.y) / PEL_DEG);
    edit->sky.moon_elevation = asin(pel_clamp(to.z, -1, 1)) / PEL_DEG;
    edit->sky.moon_phase = pel_clamp(moon.lit, 0, 1);
    edit->state.sky = &edit->sky;
}

/* They follow the clock again. */
static void free_sun(struct pel_cigi_edit *edit)
{
    edit->sky.has_sun_azimuth = edit->sky.has_sun_elevation = false;
    if (edit->scene->sky->has_sun_azimuth) {
        pel_cigi_edit_remove(edit, "sky.sunAzimuth");
    }
    if (edit->scene->sky->has_sun_elevation) {
        pel_cigi_edit_remove(edit, "sky.sunElevation");
    }
    edit->sky.has_moon_azimuth = edit->sky.has_moon_elevation =
        edit->sky.has_moon_phase = false;
    if (edit->scene->sky->has_moon_azimuth) {
        pel_cigi_edit_remove(edit, "sky.moonAzimuth");
    }
    if (edit->scene->sky->has_moon_elevation) {
        pel_cigi_edit_remove(edit, "sky.moonElevation");
    }
    if (edit->scene->sky->has_moon_phase) {
        pel_cigi_edit_remove(edit, "sky.moonPhase");
    }
}

static void take_celestial(struct pel_cigi_edit *edit,
                           const struct pel_cigi_packet *p)
{
    struct pel_cigi_world *w = edit->world;
    bool stars = pel_cigi_get(p, PEL_CIGI_CELESTIAL_STARS) != 0;
    if (stars != edit->scene->sky->stars) {
        edit->sky.has_stars = true;
        edit->sky.stars = stars;
        edit->state.sky = &edit->sky;
    }
    double hour = pel_cigi_get(p, PEL_CIGI_CELESTIAL_HOUR);
    double minute = pel_cigi_get(p, PEL_CIGI_CELESTIAL_MINUTE);
    double date = pel_cigi_get(p, PEL_CIGI_CELESTIAL_DATE);
    bool stands = pel_cigi_get(p, PEL_CIGI_CELESTIAL_EPHEMERIS) == 0;
    if (pel_cigi_get(p, PEL_CIGI_CELESTIAL_VALID) == 0) {
        /* The Sun stands where it is now, or goes on from the clock. */
        if (stands && !w->sun_stands) {
            stop_sun(edit, edit->snapshot->epoch_unix_s + edit->time_s);
        } else if (!stands && w->sun_stands) {
            free_sun(edit);
        }
        w->dated = w->dated && w->sun_stands == stands;
        w->sun_stands = stands;
        return;
    }
    if ((w->dated && w->sun_stands == stands && w->hour == hour &&
         w->minute == minute && w->date == date)) {
        return;
    }
    unsigned mmddyyyy = (unsigned)date;
    struct tm when = { .tm_min = (int)minute,
                       .tm_hour = (int)hour,
                       .tm_mday = (int)(mmddyyyy / 10000 % 100),
                       .tm_mon = (int)(mmddyyyy / 1000000) - 1,
                       .tm_year = (int)(mmddyyyy % 10000) - 1900 };
    struct tm kept = when;
    time_t wanted = timegm(&when);
    if (hour > 23 || minute > 59 || when.tm_mday != kept.tm_mday ||
        when.tm_mon != kept.tm_mon || when.tm_year != kept.tm_year ||
        when.tm_year < 0 || when.tm_year > 200) {
        edit->refused = true;
        return;
    }
    w->dated = true;
    w->hour = hour;
    w->minute = minute;
    w->date = date;
    w->sun_stands = stands;
    if (stands) {
        stop_sun(edit, (double)wanted);
        return;
    }
    free_sun(edit);
    double ahead = edit->snapshot->epoch_unix_s + edit->time_s - (double)wanted;
    if (ahead > -CLOCK_SLACK_S && ahead < 60 + CLOCK_SLACK_S) {
        return; /* the scene has this minute already */
    }
    double epoch = floor(((double)wanted - edit->time_s) * 1e6 + 0.5) * 1e-6;
    time_t whole = (time_t)floor(epoch);
    unsigned micro =
        (unsigned)fmin((epoch - (double)whole) * 1e6 + 0.5, 999999);
    struct tm utc;
    char text[24];
    gmtime_r(&whole, &utc);
    strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
    snprintf(edit->utc, sizeof edit->utc, "%s.%06uZ", text, micro);
    edit->clock.utc = edit->utc;
    edit->state.clock = &edit->clock;
}

/* --- whole sea states ---------------------------------------------------- */

void pel_cigi_read_component(const struct pel_cigi_packet *p,
                             struct pel_cigi_component *out)
{
    bool whole = p->kind == PEL_CIGI_KIND_COMPONENT;
    enum pel_cigi_field first = pel_cigi_packets[p->kind].first;
    /* Both packets have id, instance, class, state, data in this order. */
    *out = (struct pel_cigi_component){
        .class =
            (unsigned)p->values[PEL_CIGI_COMPONENT_CLASS - PEL_CIGI_COMPONENT],
        .id = (unsigned)p->values[PEL_CIGI_COMPONENT_ID - PEL_CIGI_COMPONENT],
        .instance =
            (unsigned)
                p->values[PEL_CIGI_COMPONENT_INSTANCE - PEL_CIGI_COMPONENT],
        .state =
            (unsigned)p->values[PEL_CIGI_COMPONENT_STATE - PEL_CIGI_COMPONENT],
        .count = whole ? 6 : 2,
    };
    enum pel_cigi_field data =
        whole ? PEL_CIGI_COMPONENT_DATA1 : PEL_CIGI_SHORT_COMPONENT_DATA1;
    for (size_t i = 0; i < out->count; i++) {
        out->word[i] = (uint32_t)p->values[data - first + i];
        float f;
        memcpy(&f, &out->word[i], sizeof f);
        out->value[i] = f;
    }
}

/* The whole sea's: a region has no spectrum of its own. */
static void shape_sea(struct pel_cigi_edit *edit,
                      const struct pel_cigi_component *c)
{
    edit->state.sea = &edit->sea;
    edit->sea.has_spectrum = true;
    edit->sea.spectrum = (Pelagos__SpectrumKind)c->state;
    if (c->value[2] != 0) {
        edit->sea.has_fetch = true;
        edit->sea.fetch = c->value[2];
    }
    if (c->value[3] != 0) {
        edit->sea.has_gamma = true;
        edit->sea.gamma = c->value[3];
    }
    if (c->word[4] != 0) {
        edit->sea.has_seed = true;
        edit->sea.seed = c->word[4];
    }
    if (c->value[5] != 0) {
        edit->sea.has_depth = true;
        edit->sea.depth = c->value[5];
    }
}

/* Component Control numbers them as the schema does (proto/cigi.in.md). A
 * buoy's record is for who can name it. */
static bool is_spectrum(unsigned state)
{
    return protobuf_c_enum_descriptor_get_value(
               &pelagos__spectrum_kind__descriptor, (int)state) &&
           !pel_spectrum_reads((Pelagos__SpectrumKind)state, "sea.measured");
}

static bool is_synthesiser(unsigned state)
{
    return protobuf_c_enum_descriptor_get_value(
        &pelagos__synthesiser__descriptor, (int)state);
}

static void take_component(struct pel_cigi_edit *edit,
                           const struct pel_cigi_packet *p)
{
    struct pel_cigi_component c;
    pel_cigi_read_component(p, &c);
    bool regional = c.class == REGIONAL_SEA;
    if (c.class == ENTITY) {
        pel_cigi_take_lights(edit, &c);
        return;
    }
    if (c.class == PEL_CIGI_SYSTEM && c.id == PEL_CIGI_EXERCISE) {
        edit->refused = edit->refused || !isfinite(c.value[0]);
        return; /* no edit: cigi.c carries it out */
    }
    if (c.class != GLOBAL_SEA && !regional) {
        edit->skipped++;
        return;
    }
    struct pel_cigi_conditions *to = conditions_of(edit, regional, c.instance);
    if (!to) {
        return;
    }
    if (regional && c.id >= FIRST_TRAIN) {
        c.instance = c.id - FIRST_TRAIN;
        c.id = 3;
    } else if (regional) {
        c.instance = 0;
    }
    /* The fifth word is an integer. */
    for (size_t i = 0; i < c.count; i++) {
        edit->refused = edit->refused || (i != 4 && !isfinite(c.value[i]));
    }
    if (edit->refused) {
        return;
    }
    if (c.id == 1 && is_spectrum(c.state)) {
        set_wind(to, c.value[0], c.value[1]);
        if (!regional) {
            shape_sea(edit, &c);
        }
    } else if (c.id == 2 && c.state <= 12) {
        /* WMO: v = 0.836 B^1.5 m/s */
        set_wind(to, 0.836 * pow(c.state, 1.5), c.value[0]);
    } else if (c.id == 3 && c.instance < PEL_CIGI_TRAINS && c.state <= 1) {
        struct pel_cigi_train s = {
            .used = c.state == 1,
            .key = c.instance,
            .height_m = c.value[0],
            .period_s = c.value[1],
            .from_deg = p->kind == PEL_CIGI_KIND_COMPONENT
                            ? pel_cigi_wrap(c.value[2])
                            : edit->scene->sea->wind_direction,
            .spread_deg = c.value[3] > 0 ? c.value[3] : 10,
        };
        to->has_swell = true;
        set_train(edit, to->swell, &s);
    } else if (c.id == 4) {
        to->has_chlorophyll = true;
        to->chlorophyll_mg_m3 = c.value[0];
    } else if (c.id == 5 && !regional && is_synthesiser(c.state)) {
        edit->state.sea = &edit->sea;
        edit->sea.has_synthesiser = true;
        edit->sea.synthesiser = (Pelagos__Synthesiser)c.state;
    } else {
        edit->skipped++;
    }
}

void pel_cigi_take_environment(struct pel_cigi_edit *edit,
                               const struct pel_cigi_packet *p)
{
    switch (p->kind) {
    case PEL_CIGI_KIND_CELESTIAL:
        take_celestial(edit, p);
        break;
    case PEL_CIGI_KIND_ATMOSPHERE:
        take_atmosphere(edit, p);
        break;
    case PEL_CIGI_KIND_REGION:
        take_region(edit, p);
        break;
    case PEL_CIGI_KIND_WEATHER:
        take_weather(edit, p);
        break;
    case PEL_CIGI_KIND_MARITIME:
        take_maritime(edit, p);
        break;
    case PEL_CIGI_KIND_WAVE:
        take_wave(edit, p);
        break;
    case PEL_CIGI_KIND_COMPONENT:
    case PEL_CIGI_KIND_SHORT_COMPONENT:
        take_component(edit, p);
        break;
    default:
        break; /* requests, and what is not for the scene */
    }
}
