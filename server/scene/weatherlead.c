#include "scene/weatherlead.h"

#include <glib.h>
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "base/watch.h"
#include "fault.h"
#include "message.h"
#include "scene/geodesy.h"
#include "scene/scene_parts.h"
#include "scene/weatherfile.h"
#include "scene/weathersea.h"

#define TICK_S 1.0
#define TIMER_MS 100
#define SKIP_S 10.0 /* a clock that leapt farther leaves moments out */

struct pel_weather_lead {
    struct pel_scene *scene;
    double looked_s; /* moments up to it have been looked at */
    double floor_s;  /* of the last edit or step: no patch comes before it */
    bool asked;      /* a patch of ours waits for its sea */
    bool edited;     /* somebody else has edited; look again */
    bool complained;
    guint timer; /* 0: none */
    struct pel_growth_law law;
};

/* --- what is led ---------------------------------------------------------- */

static bool leads(const struct pel_weather_lead *lead)
{
    const struct pel_scene *scene = lead->scene;
    return scene->has.weather.field && scene->state->sea->field->leads;
}

static bool is_the_fields(const Pelagos__Patch *patch)
{
    const Pelagos__State *to = patch->state;
    return to && to->sea && to->sea->field && to->sea->field->has_time;
}

static bool same_swells(const Pelagos__Sea *a, const Pelagos__Sea *b)
{
    bool same = a->n_swell == b->n_swell;
    for (size_t i = 0; same && i < a->n_swell; i++) {
        same = pel_message_same(&a->swell[i]->base, &b->swell[i]->base);
    }
    return same;
}

enum pel_err pel_weather_lead_check(const Pelagos__State *from,
                                    const Pelagos__State *to,
                                    const Pelagos__Patch *patch,
                                    struct pel_fault *fault)
{
    const Pelagos__Sea *a = from->sea, *b = to->sea;
    if (!pel_weather_is_named(from) || !pel_weather_is_named(to) ||
        strcmp(a->field->file, b->field->file) != 0 || !a->field->leads ||
        !b->field->leads || is_the_fields(patch)) {
        return PEL_OK;
    }
    bool waves = a->field->has_height;
    const char *path = a->wind_speed != b->wind_speed ? "sea.windSpeed"
                       : a->wind_direction != b->wind_direction
                           ? "sea.windDirection"
                       : waves && a->fetch != b->fetch ? "sea.fetch"
                       : waves && !same_swells(a, b)   ? "sea.swell"
                                                       : NULL;
    return path ? pel_fault_refuse(PEL_ERR_CONFLICT, path, NULL,
                                   "follows the weather of sea.field.file; "
                                   "remove sea.field to set it",
                                   fault)
                : PEL_OK;
}

/* --- asking --------------------------------------------------------------- */

struct question {
    double latitude, longitude, turn_rad;
    struct pel_weather_now now;
    struct pel_weather_sea sea;
};

static const struct pel_growth_law *law_of(struct pel_weather_lead *lead)
{
    const Pelagos__Sea *sea = lead->scene->state->sea;
    enum pel_spectrum_kind kind = (enum pel_spectrum_kind)sea->spectrum;
    if (lead->law.kind != kind || lead->law.gamma != sea->gamma) {
        pel_growth_of(kind, sea->gamma, &lead->law);
    }
    return &lead->law;
}

/* Own ship at time_s, or the origin. */
static void find_place(const struct pel_scene *scene, double time_s,
                       struct question *q)
{
    const Pelagos__State *state = scene->state;
    const Pelagos__Origin *o = state->origin;
    q->latitude = o->latitude;
    q->longitude = o->longitude;
    for (size_t i = 0; i < state->n_entities; i++) {
        if (state->entities[i]->id == state->own_ship->entity) {
            struct pel_entity_state e;
            pel_snapshot_entity_level(scene->snapshot, i, time_s, &e);
            pel_geo_from_local(o->latitude, o->longitude, e.east_m, e.north_m,
                               &q->latitude, &q->longitude);
            q->turn_rad = pel_geo_convergence(o->latitude, o->longitude,
                                              q->latitude, q->longitude);
            return;
        }
    }
}

static void ask(struct pel_weather_lead *lead, double time_s,
                struct question *out)
{
    const struct pel_snapshot *s = lead->scene->snapshot;
    *out = (struct question){ 0 };
    find_place(lead->scene, time_s, out);
    pel_weather_at(s->weather, out->latitude * PEL_DEG,
                   out->longitude * PEL_DEG,
                   s->epoch_unix_s + time_s + s->weather_shift_s, &out->now);
    pel_weather_sea_of(&out->now, law_of(lead), out->turn_rad, &out->sea);
}

static bool is_known(const struct pel_weather_now *now)
{
    return now->wind_known && (now->height_m < 0 || now->waves_known);
}

/* UTC, to the second. */
static char *utc_text(double unix_s)
{
    g_autoptr(GDateTime) when = g_date_time_new_from_unix_utc((gint64)unix_s);
    return when ? g_date_time_format(when, "%Y-%m-%dT%H:%M:%SZ") : g_strdup("");
}

static bool same_span(const Pelagos__WeatherField *f,
                      const struct pel_weather *field)
{
    g_autofree char *first = utc_text(field->unix_s[0]);
    g_autofree char *last = utc_text(field->unix_s[field->times - 1]);
    return g_strcmp0(f->first, first) == 0 && g_strcmp0(f->last, last) == 0;
}

/* Whether the sea of the state is another than the field's. */
static bool differs(struct pel_weather_lead *lead, const struct question *q)
{
    const struct pel_scene *scene = lead->scene;
    const Pelagos__Sea *sea = scene->state->sea;
    const Pelagos__WeatherField *f = sea->field;
    bool waves = q->now.height_m >= 0;
    if (!f->has_time || f->has_height != waves ||
        (int)f->place != (int)q->now.place || f->known != is_known(&q->now) ||
        (waves && sea->n_swell != 1) ||
        !same_span(f, scene->has.weather.field)) {
        return true;
    }
    double a = sea->wind_direction * PEL_DEG,
           b = q->sea.wind_from_deg * PEL_DEG;
    double wind = hypot(sea->wind_speed * sin(a) - q->sea.wind_mps * sin(b),
                        sea->wind_speed * cos(a) - q->sea.wind_mps * cos(b));
    if (wind >= PEL_WEATHER_WIND_MPS) {
        return true;
    }
    if (!waves) {
        return false;
    }
    const struct pel_weather_sea now = {
        .wind_mps = sea->wind_speed,
        .wind_from_deg = sea->wind_direction,
        .fetch_m = sea->fetch,
        .swell_height_m = sea->swell[0]->height,
        .swell_period_s = sea->swell[0]->period,
        .swell_from_deg = sea->swell[0]->direction,
        .swell_spread_deg = sea->swell[0]->spread,
    };
    return pel_weather_sea_moves(&now, &q->sea, law_of(lead)) >=
           PEL_WEATHER_MOVES_M;
}

/* --- the patch ------------------------------------------------------------ */

static double compass(double to_rad)
{
    double d = fmod(270 - to_rad / PEL_DEG, 360);
    return d < 0 ? d + 360 : d;
}

static void say_field(const struct question *q, double time_s,
                      const struct pel_weather *field,
                      Pelagos__WeatherField *to)
{
    to->has_time = to->has_latitude = to->has_longitude = true;
    to->time = time_s;
    to->latitude = q->latitude;
    to->longitude = q->longitude;
    to->has_place = to->has_known = true;
    to->place = (Pelagos__WeatherPlace)q->now.place;
    to->known = is_known(&q->now);
    if (q->now.height_m >= 0) {
        to->has_height = to->has_period = to->has_direction = true;
        to->height = q->now.height_m;
        to->period = q->now.period_s;
        to->direction = compass(q->now.direction_rad);
    }
    to->first = utc_text(field->unix_s[0]);
    to->last = utc_text(field->unix_s[field->times - 1]);
}

static void say_sea(const struct question *q, Pelagos__Sea *to,
                    Pelagos__Swell *swell)
{
    to->has_wind_speed = to->has_wind_direction = true;
    to->wind_speed = q->sea.wind_mps;
    to->wind_direction = q->sea.wind_from_deg;
    if (q->now.height_m >= 0) {
        to->has_fetch = true;
        to->fetch = q->sea.fetch_m;
        swell->has_height = swell->has_period = true;
        swell->has_direction = swell->has_spread = true;
        swell->height = q->sea.swell_height_m;
        swell->period = q->sea.swell_period_s;
        swell->direction = q->sea.swell_from_deg;
        swell->spread = q->sea.swell_spread_deg;
        to->n_swell = 1;
    }
}

static void patched(void *user, enum pel_err err, const struct pel_fault *fault)
{
    struct pel_weather_lead *lead = user;
    lead->asked = false;
    if (err && !lead->complained) {
        pel_warn("SCN-032", "the sea does not follow sea.field.file: %s %s",
                 fault->path, fault->message);
    }
    lead->complained = err;
}

static void lead_to(struct pel_weather_lead *lead, const struct question *q,
                    double time_s)
{
    char *waves[] = { (char[]){ "sea.field.height" },
                      (char[]){ "sea.field.period" },
                      (char[]){ "sea.field.direction" } };
    Pelagos__WeatherField field = PELAGOS__WEATHER_FIELD__INIT;
    Pelagos__Swell swell = PELAGOS__SWELL__INIT, *swells = &swell;
    Pelagos__Sea sea = PELAGOS__SEA__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    const Pelagos__WeatherField *now = lead->scene->state->sea->field;
    say_field(q, time_s, lead->scene->has.weather.field, &field);
    sea.swell = &swells;
    say_sea(q, &sea, &swell);
    sea.field = &field;
    state.sea = &sea;
    patch.state = &state;
    if (now->has_height && q->now.height_m < 0) {
        patch.remove = waves;
        patch.n_remove = 3;
    }
    lead->asked = true;
    (void)pel_scene_act_patch(lead->scene, &patch, time_s, false, patched,
                              lead);
    g_free(field.first);
    g_free(field.last);
}

static void look(struct pel_weather_lead *lead, double time_s)
{
    struct question q;
    ask(lead, time_s, &q);
    if (differs(lead, &q)) {
        lead_to(lead, &q, fmax(time_s, lead->floor_s));
    }
}

/* --- moments -------------------------------------------------------------- */

static double next_moment(void *user, double until_s)
{
    const struct pel_weather_lead *lead = user;
    if (!leads(lead) || lead->asked) {
        return INFINITY;
    }
    double at = (floor(lead->looked_s / TICK_S) + 1) * TICK_S;
    bool skips =
        lead->scene->clock.mode == PEL_CLOCK_FREE && until_s - at > SKIP_S;
    return skips ? floor(until_s / TICK_S) * TICK_S : at;
}

static void on_moment(void *user, double time_s)
{
    struct pel_weather_lead *lead = user;
    lead->looked_s = time_s;
    look(lead, time_s);
}

static bool waits(void *user)
{
    const struct pel_weather_lead *lead = user;
    return lead->asked;
}

static void on_edit(void *user, double clock_s, const Pelagos__Patch *patch)
{
    struct pel_weather_lead *lead = user;
    lead->floor_s = clock_s;
    if (patch && patch->state && patch->state->clock &&
        patch->state->clock->has_time) { /* what waits is of another time */
        pel_scene_withdraw(lead->scene, lead);
        lead->asked = false;
    }
    if (patch) {
        lead->looked_s = lead->floor_s = lead->scene->state->clock->time;
        lead->edited = lead->edited || !is_the_fields(patch);
    }
}

static gboolean on_timer(gpointer user)
{
    PEL_WATCH("weather");
    struct pel_weather_lead *lead = user;
    if (!leads(lead)) {
        lead->timer = 0;
        return G_SOURCE_REMOVE;
    }
    pel_scene_catch_up(lead->scene);
    return G_SOURCE_CONTINUE;
}

static void begin_timer(struct pel_weather_lead *lead)
{
    if (leads(lead) && lead->timer == 0) {
        lead->timer = g_timeout_add(TIMER_MS, on_timer, lead);
    }
}

static void on_commit(void *user)
{
    struct pel_weather_lead *lead = user;
    begin_timer(lead);
    if (lead->scene->led.on) {
        lead->edited = false; /* a log leads, which has what is to be */
        return;
    }
    if (lead->edited && leads(lead) && !lead->asked &&
        !pel_scene_repeats(lead->scene)) {
        lead->edited = false;
        look(lead, lead->scene->state->clock->time);
    }
}

struct pel_weather_lead *pel_weather_lead_create(struct pel_scene *scene)
{
    struct pel_weather_lead *lead = g_new0(struct pel_weather_lead, 1);
    const struct pel_scene_acts acts = { next_moment, on_moment, waits,
                                         on_edit,     lead,      NULL };
    lead->scene = scene;
    lead->looked_s = lead->floor_s = pel_scene_time(scene);
    pel_scene_add_acts(scene, &acts);
    pel_scene_on_commit(scene, on_commit, lead);
    begin_timer(lead);
    return lead;
}

void pel_weather_lead_destroy(struct pel_weather_lead *lead)
{
    if (!lead) {
        return;
    }
    pel_scene_withdraw(lead->scene, lead);
    pel_scene_remove_acts(lead->scene, lead);
    if (lead->timer) {
        g_source_remove(lead->timer);
    }
    g_free(lead);
}
