#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/vec.h"
#include "bridges/cigi_pose.h"
#include "bridges/cigi_world.h"
#include "scene/geodesy.h"

#define MAX_WIND_MPS 30.0
#define MIN_VISIBILITY_M 200.0
#define MAX_VISIBILITY_M 300000.0
#define SURFACE_LAYER_M 10.0
#define GRAVITY 9.80665
#define COMPONENT_KEY 256u /* swell of Component Control, beyond wave ids */
#define GLOBAL_SEA 7
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
}

/* A rectangle of sides x and y about the centre, its corners rounded off
 * outside: the corner radius goes around it. */
static bool inside(const struct pel_cigi_edit *edit,
                   const struct pel_cigi_region *r, struct pel_vec2 eye)
{
    double place[3] = { r->latitude, r->longitude, 0 };
    struct pel_vec3 centre;
    if (!pel_cigi_place(edit->snapshot, edit->time_s, false, 0, place,
                        &centre)) {
        return false;
    }
    double dx = eye.x - centre.x, dy = eye.y - centre.y;
    double turn = r->rotation_deg * PEL_DEG;
    double along = fabs(dx * sin(turn) + dy * cos(turn));
    double across = fabs(dx * cos(turn) - dy * sin(turn));
    double out_x = fmax(along - 0.5 * r->x_m, 0);
    double out_y = fmax(across - 0.5 * r->y_m, 0);
    return hypot(out_x, out_y) <= fmax(r->radius_m, 0);
}

static void overlay(struct pel_cigi_conditions *on,
                    const struct pel_cigi_conditions *with)
{
    if (with->has_visibility) {
        on->has_visibility = true;
        on->visibility_m = with->visibility_m;
    }
    if (with->has_layer_visibility) {
        on->has_layer_visibility = true;
        on->layer_visibility_m = with->layer_visibility_m;
    }
    if (with->has_wind) {
        on->has_wind = true;
        on->wind_mps = with->wind_mps;
        on->wind_deg = with->wind_deg;
    }
    if (with->has_layer_wind) {
        on->has_layer_wind = true;
        on->layer_wind_mps = with->layer_wind_mps;
        on->layer_wind_deg = with->layer_wind_deg;
    }
    if (with->has_chlorophyll) {
        on->has_chlorophyll = true;
        on->chlorophyll_mg_m3 = with->chlorophyll_mg_m3;
    }
    if (with->has_swell) {
        on->has_swell = true;
        memcpy(on->swell, with->swell, sizeof on->swell);
    }
}

/* The world's, overlaid by those of the regions the first view is in. */
static struct pel_cigi_conditions effective(const struct pel_cigi_edit *edit)
{
    struct pel_cigi_conditions all = edit->world->global;
    struct pel_vec2 eye = { 0, 0 };
    if (edit->snapshot->view_count > 0) {
        struct pel_camera camera;
        pel_snapshot_camera(edit->snapshot, 0, edit->time_s, 0, 0, &camera);
        eye = (struct pel_vec2){ camera.east_m, camera.north_m };
    }
    bool done[PEL_CIGI_REGIONS] = { false };
    for (size_t n = 0; n < PEL_CIGI_REGIONS; n++) {
        const struct pel_cigi_region *next = NULL;
        for (size_t i = 0; i < PEL_CIGI_REGIONS; i++) {
            const struct pel_cigi_region *r = &edit->world->regions[i];
            if (r->used && r->active && !done[i] &&
                (!next || r->id < next->id)) {
                next = r;
            }
        }
        if (!next) {
            break;
        }
        done[next - edit->world->regions] = true;
        if (inside(edit, next, eye)) {
            overlay(&all, &next->conditions);
        }
    }
    return all;
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
    if (pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_ENABLE) == 0) {
        return;
    }
    w->global.has_visibility = true;
    w->global.visibility_m =
        visibility(pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_VISIBILITY));
    set_wind(&w->global, pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_WIND),
             pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_WIND_DIRECTION));
    w->humidity = pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_HUMIDITY);
    w->air_temperature = pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_TEMPERATURE);
    w->pressure = pel_cigi_get(p, PEL_CIGI_ATMOSPHERE_PRESSURE);
}

static void take_weather(struct pel_cigi_edit *edit,
                         const struct pel_cigi_packet *p)
{
    struct pel_cigi_conditions *c =
        conditions_of(edit, pel_cigi_get(p, PEL_CIGI_WEATHER_SCOPE),
                      pel_cigi_get(p, PEL_CIGI_WEATHER_REGION));
    bool low = pel_cigi_get(p, PEL_CIGI_WEATHER_LAYER) == 0 ||
               pel_cigi_get(p, PEL_CIGI_WEATHER_BASE) <= SURFACE_LAYER_M;
    if (!c || !low) {
        return;
    }
    bool on = pel_cigi_get(p, PEL_CIGI_WEATHER_ENABLE) != 0;
    c->has_layer_visibility = c->has_layer_wind = on;
    c->layer_visibility_m =
        visibility(pel_cigi_get(p, PEL_CIGI_WEATHER_VISIBILITY));
    c->layer_wind_mps =
        pel_clamp(pel_cigi_get(p, PEL_CIGI_WEATHER_WIND), 0, MAX_WIND_MPS);
    c->layer_wind_deg =
        pel_cigi_wrap(pel_cigi_get(p, PEL_CIGI_WEATHER_WIND_DIRECTION));
}

static void take_maritime(struct pel_cigi_edit *edit,
                          const struct pel_cigi_packet *p)
{
    struct pel_cigi_conditions *c =
        conditions_of(edit, pel_cigi_get(p, PEL_CIGI_MARITIME_SCOPE),
                      pel_cigi_get(p, PEL_CIGI_MARITIME_REGION));
    if (!c) {
        return;
    }
    c->has_chlorophyll = pel_cigi_get(p, PEL_CIGI_MARITIME_ENABLE) != 0;
    c->chlorophyll_mg_m3 =
        pel_cigi_chlorophyll(pel_cigi_get(p, PEL_CIGI_MARITIME_CLARITY));
    if (c->has_chlorophyll) {
        edit->world->water_temperature =
            pel_cigi_get(p, PEL_CIGI_MARITIME_TEMPERATURE);
    }
}

static void set_swell(struct pel_cigi_edit *edit, struct pel_cigi_conditions *c,
                      const struct pel_cigi_swell *with)
{
    struct pel_cigi_swell *spare = NULL, *at = NULL;
    for (size_t i = 0; i < PEL_SEA_MAX_SWELLS && !at; i++) {
        struct pel_cigi_swell *s = &c->swell[i];
        at = s->used && s->key == with->key ? s : NULL;
        spare = !s->used && !spare ? s : spare;
    }
    at = at ? at : spare;
    if (!at && with->used) {
        edit->skipped++;
    } else if (at) {
        *at = *with;
    }
    c->has_swell = true;
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
        period_s = sqrt(2 * PEL_PI * fmax(length_m, 0) / GRAVITY);
    }
    struct pel_cigi_swell s = {
        .used = pel_cigi_get(p, PEL_CIGI_WAVE_ENABLE) != 0,
        .key = (unsigned)pel_cigi_get(p, PEL_CIGI_WAVE_ID),
        .height_m = sqrt(2) * pel_cigi_get(p, PEL_CIGI_WAVE_HEIGHT),
        .period_s = pel_clamp(period_s, 3, 30),
        .from_deg =
            pel_cigi_wrap(pel_cigi_get(p, PEL_CIGI_WAVE_DIRECTION) + 180),
        .spread_deg = 1, /* the narrowest that the schema has */
    };
    set_swell(edit, c, &s);
}

static void take_celestial(struct pel_cigi_edit *edit,
                           const struct pel_cigi_packet *p)
{
    struct pel_cigi_world *w = edit->world;
    double hour = pel_cigi_get(p, PEL_CIGI_CELESTIAL_HOUR);
    double minute = pel_cigi_get(p, PEL_CIGI_CELESTIAL_MINUTE);
    double date = pel_cigi_get(p, PEL_CIGI_CELESTIAL_DATE);
    if (pel_cigi_get(p, PEL_CIGI_CELESTIAL_VALID) == 0 ||
        (w->dated && w->hour == hour && w->minute == minute &&
         w->date == date)) {
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
    if (edit->scene->sky->has_sun_azimuth) {
        pel_cigi_edit_remove(edit, "sky.sunAzimuth");
    }
    if (edit->scene->sky->has_sun_elevation) {
        pel_cigi_edit_remove(edit, "sky.sunElevation");
    }
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

struct component {
    unsigned id, instance, state;
    size_t count;     /* data words */
    uint32_t word[6]; /* absent ones 0 */
    double value[6];  /* as floats */
};

static bool read_component(const struct pel_cigi_packet *p,
                           struct component *out)
{
    bool whole = p->kind == PEL_CIGI_KIND_COMPONENT;
    enum pel_cigi_field first = pel_cigi_packets[p->kind].first;
    /* Both packets have id, instance, class, state, data in this order. */
    *out = (struct component){
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
    double class = p->values[PEL_CIGI_COMPONENT_CLASS - PEL_CIGI_COMPONENT];
    return class == GLOBAL_SEA;
}

static void wind_sea(struct pel_cigi_edit *edit, const struct component *c)
{
    set_wind(&edit->world->global, c->value[0], c->value[1]);
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

static void take_component(struct pel_cigi_edit *edit,
                           const struct pel_cigi_packet *p)
{
    struct component c;
    struct pel_cigi_conditions *global = &edit->world->global;
    if (!read_component(p, &c)) {
        edit->skipped++;
        return;
    }
    /* The fifth word is an integer. */
    for (size_t i = 0; i < c.count; i++) {
        edit->refused = edit->refused || (i != 4 && !isfinite(c.value[i]));
    }
    if (edit->refused) {
        return;
    }
    if (c.id == 1 && c.state <= PELAGOS__SPECTRUM_KIND__OMEGA2) {
        wind_sea(edit, &c);
    } else if (c.id == 2 && c.state <= 12) {
        /* WMO: v = 0.836 B^1.5 m/s */
        set_wind(global, 0.836 * pow(c.state, 1.5), c.value[0]);
    } else if (c.id == 3 && c.instance < PEL_SEA_MAX_SWELLS && c.state <= 1) {
        struct pel_cigi_swell s = {
            .used = c.state == 1,
            .key = COMPONENT_KEY + c.instance,
            .height_m = c.value[0],
            .period_s = c.value[1],
            .from_deg = p->kind == PEL_CIGI_KIND_COMPONENT
                            ? pel_cigi_wrap(c.value[2])
                            : edit->scene->sea->wind_direction,
            .spread_deg = c.value[3] > 0 ? c.value[3] : 10,
        };
        set_swell(edit, global, &s);
    } else if (c.id == 4) {
        global->has_chlorophyll = true;
        global->chlorophyll_mg_m3 = c.value[0];
    } else if (c.id == 5 && c.state <= PELAGOS__SYNTHESISER__FFT) {
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

/* --- into the patch ------------------------------------------------------ */

static void apply_wind(struct pel_cigi_edit *edit,
                       const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    bool layer = now->has_layer_wind;
    double mps = layer ? now->layer_wind_mps : now->wind_mps;
    double deg = layer ? now->layer_wind_deg : now->wind_deg;
    if ((!layer && !now->has_wind) ||
        (was->has_wind && was->wind_mps == mps && was->wind_deg == deg)) {
        return;
    }
    was->has_wind = true;
    was->wind_mps = mps;
    was->wind_deg = deg;
    edit->state.sea = &edit->sea;
    edit->sea.has_wind_speed = edit->sea.has_wind_direction = true;
    edit->sea.wind_speed = mps;
    edit->sea.wind_direction = deg;
}

static void apply_visibility(struct pel_cigi_edit *edit,
                             const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    bool layer = now->has_layer_visibility;
    double metres = layer ? now->layer_visibility_m : now->visibility_m;
    if ((!layer && !now->has_visibility) ||
        (was->has_visibility && was->visibility_m == metres)) {
        return;
    }
    was->has_visibility = true;
    was->visibility_m = metres;
    edit->state.sky = &edit->sky;
    edit->sky.has_visibility = true;
    edit->sky.visibility = metres;
}

static bool same_swell(const struct pel_cigi_swell *a,
                       const struct pel_cigi_swell *b)
{
    return a->used == b->used &&
           (!a->used ||
            (a->height_m == b->height_m && a->period_s == b->period_s &&
             a->from_deg == b->from_deg && a->spread_deg == b->spread_deg));
}

static void apply_swell(struct pel_cigi_edit *edit,
                        const struct pel_cigi_conditions *now)
{
    struct pel_cigi_conditions *was = &edit->world->applied;
    bool same = was->has_swell;
    for (size_t i = 0; i < PEL_SEA_MAX_SWELLS; i++) {
        same = same && same_swell(&now->swell[i], &was->swell[i]);
    }
    if (!now->has_swell || same) {
        return;
    }
    was->has_swell = true;
    memcpy(was->swell, now->swell, sizeof was->swell);
    for (size_t i = 0; i < PEL_SEA_MAX_SWELLS; i++) {
        const struct pel_cigi_swell *s = &now->swell[i];
        if (!s->used) {
            continue;
        }
        Pelagos__Swell *to = &edit->swell[edit->sea.n_swell];
        pelagos__swell__init(to);
        to->has_height = to->has_period = true;
        to->has_direction = to->has_spread = true;
        to->height = s->height_m;
        to->period = s->period_s;
        to->direction = s->from_deg;
        to->spread = s->spread_deg;
        edit->swell_list[edit->sea.n_swell++] = to;
    }
    if (edit->sea.n_swell > 0) {
        edit->state.sea = &edit->sea;
    } else {
        pel_cigi_edit_remove(edit, "sea.swell");
    }
}

void pel_cigi_apply_conditions(struct pel_cigi_edit *edit)
{
    struct pel_cigi_conditions now = effective(edit);
    struct pel_cigi_conditions *was = &edit->world->applied;
    apply_wind(edit, &now);
    apply_visibility(edit, &now);
    apply_swell(edit, &now);
    if (now.has_chlorophyll &&
        !(was->has_chlorophyll &&
          was->chlorophyll_mg_m3 == now.chlorophyll_mg_m3)) {
        was->has_chlorophyll = true;
        was->chlorophyll_mg_m3 = now.chlorophyll_mg_m3;
        edit->state.water = &edit->water;
        edit->water.has_chlorophyll = true;
        edit->water.chlorophyll = now.chlorophyll_mg_m3;
    }
}
