#include "scene/lampplan.h"

#include <glib.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "fault.h"
#include "models/model.h"
#include "optics/lamp.h"
#include "scene/geodesy.h"
#include "scene/lamps.h"

#define MILE_M 1852.0
#define PER_MILE 0.74   /* air of nominal ranges: IALA E-200-2 */
#define MARK_NM 5.0     /* where nobody says it */
#define NO_MODEL_M 10.0 /* height of a lamp on nothing */
#define RAFT_CD 4.3     /* LSA code 4.1.3.3 */
#define PERSON_CD 0.75  /* LSA code 2.2.3.1 */
#define SPREAD_OF_PHASES 0.6180339887498949
#define PARIS_UNITS 50.0

/* What a class of marks shows where nobody says it: IALA R1001, region A; the
 * model says which region's colour it is. */
static const char *const characters[PEL_MODEL_CLASSES] = {
    [PEL_MODEL_LATERAL_PORT] = "Fl R 4s",
    [PEL_MODEL_LATERAL_STARBOARD] = "Fl G 4s",
    [PEL_MODEL_CARDINAL_NORTH] = "Q",
    [PEL_MODEL_CARDINAL_EAST] = "Q(3) 10s",
    [PEL_MODEL_CARDINAL_SOUTH] = "Q(6)+LFl 15s",
    [PEL_MODEL_CARDINAL_WEST] = "Q(9) 15s",
    [PEL_MODEL_SAFE_WATER] = "LFl 10s",
    [PEL_MODEL_SPECIAL_MARK] = "Fl Y 5s",
    [PEL_MODEL_ISOLATED_DANGER] = "Fl(2) 5s",
    [PEL_MODEL_BEACON] = "Fl 5s",
    [PEL_MODEL_LIGHT_FLOAT] = "Fl(3) 10s",
    [PEL_MODEL_LIFE_RAFT] = "F",
    [PEL_MODEL_LIFEBOAT] = "F",
    [PEL_MODEL_PERSON] = "Q",
};

/* --- checks --------------------------------------------------------------- */

static bool has_colour(const struct pel_rhythm *r, int colour)
{
    bool has = false;
    for (int i = 0; i < r->colour_count; i++) {
        has = has || (int)r->colours[i] == colour;
    }
    return has;
}

static enum pel_err check_sectors(const Pelagos__Light *l,
                                  const struct pel_rhythm *r, const char *path,
                                  struct pel_fault *fault)
{
    if (l->n_sectors > PEL_LIGHT_SECTORS) {
        return pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, path, NULL,
                                "would have more than 12 sectors", fault);
    }
    if (r->alternates && l->n_sectors > 0) {
        return pel_fault_refuse(PEL_ERR_CONFLICT, path, NULL,
                                "are of a light that alternates (Al), which "
                                "shows its colours all round",
                                fault);
    }
    for (int i = 0; i < r->colour_count && !r->alternates; i++) {
        bool shown = r->colour_count == 1;
        for (size_t k = 0; k < l->n_sectors; k++) {
            shown = shown || (int)l->sectors[k]->colour == (int)r->colours[i];
        }
        if (!shown) {
            return pel_fault_refuse(PEL_ERR_INVALID, path, NULL,
                                    "must say where each colour of the "
                                    "character is seen: a sector for each, "
                                    "with colour, begin and end",
                                    fault);
        }
    }
    for (size_t k = 0; k < l->n_sectors; k++) {
        if (l->character && !has_colour(r, (int)l->sectors[k]->colour)) {
            return pel_fault_refuse(PEL_ERR_CONFLICT, path, NULL,
                                    "has a sector of a colour that the "
                                    "character lacks",
                                    fault);
        }
    }
    return PEL_OK;
}

static enum pel_err check_light(const Pelagos__Entity *e,
                                struct pel_fault *fault)
{
    struct pel_rhythm rhythm;
    char path[64], why[PEL_RHYTHM_WHY];
    const char *text = e->light->character;
    g_snprintf(path, sizeof path, "entities.%u.light.character", e->id);
    if (pel_rhythm_parse(text ? text : "F", &rhythm, why)) {
        return pel_fault_refuse(PEL_ERR_INVALID, path, text, why, fault);
    }
    g_snprintf(path, sizeof path, "entities.%u.light.sectors", e->id);
    return check_sectors(e->light, &rhythm, path, fault);
}

enum pel_err pel_lamps_check(const Pelagos__Entity *e, struct pel_fault *fault)
{
    const Pelagos__SignalLamp *signal = e->signal;
    if (signal && signal->text && pel_morse_units(signal->text) < 0) {
        char path[64];
        g_snprintf(path, sizeof path, "entities.%u.signal.text", e->id);
        return pel_fault_refuse(PEL_ERR_INVALID, path, signal->text,
                                "has a sign without Morse code: write A to Z, "
                                "0 to 9, spaces and . , ? ' / : = + -",
                                fault);
    }
    return e->light ? check_light(e, fault) : PEL_OK;
}

/* --- what the state says -------------------------------------------------- */

static bool is_named(const struct pel_model_light *light, const char *name)
{
    return strcmp(light->name, name) == 0;
}

/* Places of lights that have their names of docs/models.md. */
static void describe(const struct pel_model *m, struct pel_nav_places *out)
{
    for (size_t i = 0; i < m->light_count; i++) {
        const struct pel_model_light *light = &m->lights[i];
        if (is_named(light, "masthead") || is_named(light, "steaming")) {
            out->has_masthead = true;
            out->masthead = light->at;
        } else if (is_named(light, "masthead 2")) {
            out->has_second = true;
            out->second = light->at;
        } else if (is_named(light, "port")) {
            out->has_sides = true;
            out->side = light->at;
        } else if (is_named(light, "stern")) {
            out->has_stern = true;
            out->stern = light->at;
        }
    }
}

static enum pel_nav_status status_of(const Pelagos__Entity *e,
                                     const struct pel_model *m)
{
    if (e->navigation_status != PELAGOS__NAVIGATION_STATUS__UNDEFINED) {
        return (enum pel_nav_status)e->navigation_status; /* SAME, below */
    }
    return e->mooring > 0                        ? PEL_NAV_ANCHOR
           : m->class == PEL_MODEL_SAILING_YACHT ? PEL_NAV_SAILING
           : m->class == PEL_MODEL_PILOT_LAUNCH  ? PEL_NAV_PILOT
           : m->class == PEL_MODEL_ROWING_BOAT   ? PEL_NAV_OARS
                                                 : PEL_NAV_ENGINE;
}

static void read_vessel(const Pelagos__Entity *e, const struct pel_model *m,
                        struct pel_lamp_set *out)
{
    out->is_vessel = true;
    out->vessel = (struct pel_vessel){ .length_m = m->length_m,
                                       .breadth_m = m->beam_m,
                                       .height_m = m->height_m,
                                       .status = status_of(e, m),
                                       .anchored = e->mooring > 0,
                                       .tow_m = e->tow_length };
    describe(m, &out->vessel.described);
}

static double range_of(const Pelagos__Light *l, const struct pel_model *m)
{
    return l && l->has_range ? l->range
           : m && m->light_count > 0 && m->lights[0].range_m > 0
               ? m->lights[0].range_m / MILE_M
               : MARK_NM;
}

static struct pel_vec3 place_of(const Pelagos__Light *l,
                                const struct pel_model *m)
{
    struct pel_vec3 at = { 0, 0, m ? m->height_m : NO_MODEL_M };
    if (m && m->light_count > 0) {
        at = m->lights[0].at;
    }
    if (l && l->has_height) {
        at = (struct pel_vec3){ 0, 0, l->height };
    }
    return at;
}

static void read_sector(const Pelagos__LightSector *from, double range_nm,
                        double turned_rad, struct pel_light_sector *to)
{
    double arc = fmod(from->end - from->begin + 360, 360) * PEL_DEG;
    *to = (struct pel_light_sector){
        .colour = (enum pel_lamp_colour)from->colour, /* SAME, below */
        .from_rad = from->begin * PEL_DEG + PEL_PI + turned_rad,
        .arc_rad = arc > 0 ? arc : 2 * PEL_PI,
        .intensity_cd = pel_lamp_intensity(
            from->has_range ? from->range : range_nm, PER_MILE),
    };
}

static void read_light(const Pelagos__State *state, const Pelagos__Entity *e,
                       const struct pel_model *m, struct pel_lamp_set *out)
{
    const Pelagos__Light *l = e->light;
    struct pel_mark_light *to = &out->light;
    const char *usual = m ? characters[m->class] : NULL;
    char why[PEL_RHYTHM_WHY];
    bool own = l && l->character;
    if (!l && !usual) {
        return;
    }
    out->has_light = !pel_rhythm_parse(own     ? l->character
                                       : usual ? usual
                                               : "F",
                                       &to->rhythm, why);
    bool lateral = m && m->light_count > 0 &&
                   (m->class == PEL_MODEL_LATERAL_PORT ||
                    m->class == PEL_MODEL_LATERAL_STARBOARD);
    if (lateral && !own) {
        const float *shown = m->lights[0].colour;
        to->rhythm.colours[0] =
            shown[0] > shown[1] ? PEL_LAMP_RED : PEL_LAMP_GREEN;
    }
    double range_nm = range_of(l, m), whole;
    bool ours = !(l && l->has_range) && m;
    to->intensity_cd = ours && m->class == PEL_MODEL_PERSON ? PERSON_CD
                       : ours && (m->class == PEL_MODEL_LIFE_RAFT ||
                                  m->class == PEL_MODEL_LIFEBOAT)
                           ? RAFT_CD
                           : pel_lamp_intensity(range_nm, PER_MILE);
    to->at = place_of(l, m);
    to->phase_s = l && l->has_phase ? l->phase
                                    : modf(e->id * SPREAD_OF_PHASES, &whole) *
                                          to->rhythm.period_s;
    double turned =
        pel_geo_convergence(state->origin->latitude, state->origin->longitude,
                            e->latitude, e->longitude);
    for (size_t i = 0; l && i < l->n_sectors; i++) {
        read_sector(l->sectors[i], range_nm, turned,
                    &to->sectors[to->sector_count++]);
    }
}

/* Above the first eye, which is the bridge's; on nothing where its light is. */
static struct pel_vec3 lamp_place(const Pelagos__Entity *e,
                                  const struct pel_model *m)
{
    struct pel_vec3 at = { 0, 0, m ? 0.8 * m->height_m : NO_MODEL_M };
    if (!m && e->light && e->light->has_height) {
        at.z = e->light->height;
    }
    if (m && m->eye_count > 0) {
        at = m->eyes[0].at;
        at.z += 0.5 + 0.01 * m->length_m;
    }
    return at;
}

static void read_beams(const Pelagos__Entity *e, const struct pel_model *m,
                       struct pel_lamp_set *out)
{
    const Pelagos__Searchlight *search = e->searchlight;
    const Pelagos__SignalLamp *signal = e->signal;
    if (search && search->on) {
        out->search =
            (struct pel_beam_lamp){ .on = true,
                                    .bearing_rad = search->bearing * PEL_DEG,
                                    .elevation_rad =
                                        search->elevation * PEL_DEG,
                                    .half_rad = search->width * PEL_DEG / 2,
                                    .intensity_cd = search->intensity,
                                    .at = lamp_place(e, m) };
    }
    if (signal && signal->text && *signal->text) {
        out->signal = (struct pel_morse_lamp){
            .start_s = signal->start,
            .unit_s = 60 / (PARIS_UNITS * signal->speed),
            .pointed = signal->has_bearing,
            .bearing_rad = signal->bearing * PEL_DEG,
            .at = lamp_place(e, m),
        };
        if (!signal->has_bearing && m) {
            out->signal.at =
                (struct pel_vec3){ out->signal.at.x, 0, m->height_m + 0.5 };
        }
        g_strlcpy(out->signal.text, signal->text, sizeof out->signal.text);
    }
}

/* False: it has no lamps. */
static bool read_entity(const Pelagos__State *state, const Pelagos__Entity *e,
                        const struct pel_entity_state *at,
                        struct pel_lamp_set *out)
{
    const struct pel_model *m = at->model;
    *out = (struct pel_lamp_set){
        .lights = (enum pel_lamp_switch)e->lights, /* SAME, below */
        .deck = e->deck_lights && m,
    };
    if (out->lights != PEL_LAMP_OFF) {
        read_light(state, e, m, out);
    }
    bool mark = m && characters[m->class];
    if (m && !mark && (out->lights != PEL_LAMP_OFF || out->deck)) {
        read_vessel(e, m, out);
    }
    out->deck = out->deck && out->is_vessel;
    read_beams(e, m, out);
    return out->has_light || out->is_vessel || out->search.on ||
           out->signal.text[0];
}

struct pel_lamp_plan *pel_lamps_of(const Pelagos__State *state,
                                   const struct pel_snapshot *s)
{
    struct pel_lamp_plan *plan = NULL;
    struct pel_lamp_set set;
    for (size_t i = 0; i < s->entity_count; i++) {
        if (!read_entity(state, state->entities[i], &s->entities[i], &set)) {
            continue;
        }
        size_t room = sizeof *plan + s->entity_count * sizeof set;
        plan = plan ? plan : pel_sure_calloc(1, room);
        set.index = i;
        plan->sets[plan->count++] = set;
    }
    if (plan) {
        atomic_init(&plan->refs, 1);
    }
    return plan;
}

struct pel_lamp_plan *pel_lamps_ref(struct pel_lamp_plan *plan)
{
    if (plan) {
        atomic_fetch_add(&plan->refs, 1);
    }
    return plan;
}

void pel_lamps_unref(struct pel_lamp_plan *plan)
{
    if (plan && atomic_fetch_sub(&plan->refs, 1) == 1) {
        free(plan);
    }
}

#define SAME(ours, theirs)                                                     \
    _Static_assert((int)(ours) == (int)(theirs), "the schema's numbers")
SAME(PEL_LAMP_OFF, PELAGOS__LAMP_SWITCH__OFF);
SAME(PEL_LAMP_AUTO, PELAGOS__LAMP_SWITCH__AUTO);
SAME(PEL_LAMP_ON, PELAGOS__LAMP_SWITCH__ON);
SAME(PEL_LAMP_WHITE, PELAGOS__LIGHT_COLOUR__LIGHT_WHITE);
SAME(PEL_LAMP_RED, PELAGOS__LIGHT_COLOUR__LIGHT_RED);
SAME(PEL_LAMP_GREEN, PELAGOS__LIGHT_COLOUR__LIGHT_GREEN);
SAME(PEL_LAMP_YELLOW, PELAGOS__LIGHT_COLOUR__LIGHT_YELLOW);
SAME(PEL_LAMP_BLUE, PELAGOS__LIGHT_COLOUR__LIGHT_BLUE);
SAME(PEL_NAV_ENGINE, PELAGOS__NAVIGATION_STATUS__UNDER_WAY);
SAME(PEL_NAV_ANCHOR, PELAGOS__NAVIGATION_STATUS__AT_ANCHOR);
SAME(PEL_NAV_NOT_UNDER_COMMAND, PELAGOS__NAVIGATION_STATUS__NOT_UNDER_COMMAND);
SAME(PEL_NAV_RESTRICTED, PELAGOS__NAVIGATION_STATUS__RESTRICTED);
SAME(PEL_NAV_CONSTRAINED, PELAGOS__NAVIGATION_STATUS__CONSTRAINED);
SAME(PEL_NAV_MOORED, PELAGOS__NAVIGATION_STATUS__MOORED);
SAME(PEL_NAV_AGROUND, PELAGOS__NAVIGATION_STATUS__AGROUND);
SAME(PEL_NAV_FISHING, PELAGOS__NAVIGATION_STATUS__FISHING);
SAME(PEL_NAV_SAILING, PELAGOS__NAVIGATION_STATUS__SAILING);
SAME(PEL_NAV_TOWING, PELAGOS__NAVIGATION_STATUS__TOWING);
SAME(PEL_NAV_PUSHING, PELAGOS__NAVIGATION_STATUS__PUSHING);
SAME(PEL_NAV_UNDEFINED, PELAGOS__NAVIGATION_STATUS__UNDEFINED);
SAME(PEL_NAV_TRAWLING, PELAGOS__NAVIGATION_STATUS__TRAWLING);
SAME(PEL_NAV_PILOT, PELAGOS__NAVIGATION_STATUS__PILOTING);
SAME(PEL_NAV_TOWED, PELAGOS__NAVIGATION_STATUS__TOWED);
SAME(PEL_NAV_OARS, PELAGOS__NAVIGATION_STATUS__ROWING);
