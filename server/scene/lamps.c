#include "scene/lamps.h"

#include <math.h>

#include "models/model.h"
#include "optics/falling.h"
#include "scene/lampplan.h"
#include "scene/place.h"

#define MAKES_WAY_MPS 0.25
#define CUTOFF_RAD (2 * PEL_DEG)   /* Annex I 9: within 1 to 3, and 5 */
#define SECTOR_RAD (0.5 * PEL_DEG) /* in which a mark's colours change */
#define SPREAD_RAD (5 * PEL_DEG)   /* Annex I 10 (a) */
#define SAIL_RAD (12.5 * PEL_DEG)  /* 10 (b): half at 25 degrees */
#define MARK_RAD (5 * PEL_DEG)
#define LANTERN_M 0.2
#define SIGNAL_NM 5.0     /* rule 34 (b) iii */
#define SIGNAL_CD 60000.0 /* IMO MSC.95(72) */
#define SIGNAL_RAD (3.5 * PEL_DEG)
#define FLOOD_CD 8000.0 /* a flood lamp of some 25,000 lm */
#define FLOOD_RAD (60 * PEL_DEG)
#define FLOOD_EVERY_M 25.0
#define RIDING_M 100.0 /* rule 30 (c) */

/* Chromaticities: the middles of the regions of Annex I 7; blue, which only
 * marks have, is Rec. 709's. */
static const double chromaticity[PEL_LAMP_COLOURS][2] = {
    [PEL_LAMP_WHITE] = { 0.4157, 0.3793 },
    [PEL_LAMP_RED] = { 0.6989, 0.2910 },
    [PEL_LAMP_GREEN] = { 0.1279, 0.5102 },
    [PEL_LAMP_YELLOW] = { 0.5912, 0.4022 },
    [PEL_LAMP_BLUE] = { 0.1500, 0.0600 },
};

void pel_lamp_colour_of(int colour, double out[3])
{
    static const double rgb_from_xyz[3][3] = {
        { 3.2409699419, -1.5373831776, -0.4986107603 },
        { -0.9692436363, 1.8759675015, 0.0415550574 },
        { 0.0556300797, -0.2039769589, 1.0569715142 },
    };
    double x = chromaticity[colour][0], y = chromaticity[colour][1];
    const double xyz[3] = { x / y, 1, (1 - x - y) / y };
    for (int i = 0; i < 3; i++) {
        out[i] = 0;
        for (int k = 0; k < 3; k++) {
            out[i] += rgb_from_xyz[i][k] * xyz[k];
        }
    }
}

/* The list as it grows. */
struct lamps {
    struct pel_lamp *out;
    size_t count;
};

/* A lamp of an object, at a place in its frame; all round it is. NULL: there is
 * no room. */
static struct pel_lamp *add(struct lamps *l, const struct pel_object *o,
                            struct pel_vec3 at, int colour, double cd)
{
    if (l->count == PEL_MAX_LAMPS) {
        return NULL;
    }
    struct pel_lamp *lamp = &l->out[l->count++];
    struct pel_vec3 arm = pel_mat3_apply(&o->world_from_model, at);
    *lamp = (struct pel_lamp){ .entity = o->id,
                               .east_m = o->east_m + arm.x,
                               .north_m = o->north_m + arm.y,
                               .altitude_m = o->altitude_m + arm.z,
                               .ahead = o->world_from_model.x,
                               .up = o->world_from_model.z,
                               .arc_rad = 2 * PEL_PI,
                               .spread_rad = SPREAD_RAD,
                               .size_m = LANTERN_M };
    pel_lamp_colour_of(colour, lamp->intensity_cd);
    for (int k = 0; k < 3; k++) {
        lamp->intensity_cd[k] *= cd;
    }
    return lamp;
}

/* --- vessels -------------------------------------------------------------- */

static void add_navigation(struct lamps *l, const struct pel_lamp_set *set,
                           const struct pel_object *o, double speed_mps)
{
    static const struct {
        double from_deg, arc_deg;
    } sectors[] = {
        [PEL_NAV_MASTHEAD] = { -112.5, 225 },
        [PEL_NAV_PORT] = { -112.5, 112.5 },
        [PEL_NAV_STARBOARD] = { 0, 112.5 },
        [PEL_NAV_STERN] = { 112.5, 135 },
        [PEL_NAV_ALL_ROUND] = { 0, 360 },
    };
    struct pel_nav_light lights[PEL_NAV_MOST];
    struct pel_vessel vessel = set->vessel;
    vessel.makes_way = speed_mps > MAKES_WAY_MPS;
    size_t count = pel_colregs_lights(&vessel, lights);
    for (size_t i = 0; i < count; i++) {
        const struct pel_nav_light *n = &lights[i];
        struct pel_lamp *lamp =
            add(l, o, n->at, (int)n->colour,
                pel_lamp_intensity(n->range_nm, 0.8)); /* Annex I 8 */
        if (lamp) {
            lamp->from_rad = sectors[n->kind].from_deg * PEL_DEG;
            lamp->arc_rad = sectors[n->kind].arc_deg * PEL_DEG;
            lamp->cutoff_rad = CUTOFF_RAD;
            lamp->spread_rad =
                vessel.status == PEL_NAV_SAILING ? SAIL_RAD : SPREAD_RAD;
        }
    }
}

static bool lights_decks(const struct pel_lamp_set *set, bool lit)
{
    enum pel_nav_status status = set->vessel.status;
    bool rides = status == PEL_NAV_ANCHOR || status == PEL_NAV_AGROUND;
    return set->is_vessel &&
           (set->deck || (lit && rides && set->vessel.length_m >= RIDING_M));
}

/* Flood lamps along the middle, which point down. */
static void add_deck(struct lamps *l, const struct pel_lamp_set *set,
                     const struct pel_object *o)
{
    const struct pel_vessel *v = &set->vessel;
    double deck = pel_colregs_deck(v);
    int count = (int)pel_clamp(round(v->length_m / FLOOD_EVERY_M), 1, 12);
    for (int i = 0; i < count; i++) {
        const struct pel_vec3 at = {
            v->length_m * (0.8 * (i + 0.5) / count - 0.4), 0,
            deck + fmin(10, 0.6 * (v->height_m - deck))
        };
        struct pel_lamp *lamp = add(l, o, at, PEL_LAMP_WHITE, FLOOD_CD);
        if (lamp) {
            lamp->ahead = pel_vec3_scale(o->world_from_model.z, -1);
            lamp->up = o->world_from_model.x;
            lamp->beam_rad = FLOOD_RAD;
            lamp->size_m = 0.4;
        }
    }
}

/* --- marks ---------------------------------------------------------------- */

static void add_light(struct lamps *l, const struct pel_mark_light *light,
                      const struct pel_object *o, double unix_s)
{
    const struct pel_rhythm *r = &light->rhythm;
    int shown = pel_rhythm_at(r, unix_s - light->phase_s);
    if (shown < 0) {
        return;
    }
    if (light->sector_count == 0) {
        struct pel_lamp *lamp =
            add(l, o, light->at, (int)r->colours[shown], light->intensity_cd);
        if (lamp) {
            lamp->spread_rad = MARK_RAD;
        }
        return;
    }
    for (int i = 0; i < light->sector_count; i++) {
        const struct pel_light_sector *s = &light->sectors[i];
        struct pel_lamp *lamp =
            add(l, o, light->at, (int)s->colour, s->intensity_cd);
        if (lamp) {
            bool round = s->arc_rad >= 2 * PEL_PI;
            lamp->ahead = (struct pel_vec3){ 0, 1, 0 };
            lamp->up = (struct pel_vec3){ 0, 0, 1 };
            lamp->from_rad = s->from_rad + SECTOR_RAD / 2;
            lamp->arc_rad =
                round ? s->arc_rad : fmax(0, s->arc_rad - SECTOR_RAD);
            lamp->cutoff_rad = SECTOR_RAD;
            lamp->spread_rad = MARK_RAD;
        }
    }
}

/* --- what points somewhere ------------------------------------------------ */

static void point(const struct pel_object *o, double bearing_rad,
                  double elevation_rad, struct pel_lamp *lamp)
{
    double cb = cos(bearing_rad), sb = sin(bearing_rad);
    double ce = cos(elevation_rad), se = sin(elevation_rad);
    const struct pel_vec3 ahead = { ce * cb, -ce * sb, se };
    const struct pel_vec3 up = { -se * cb, se * sb, ce };
    lamp->ahead = pel_mat3_apply(&o->world_from_model, ahead);
    lamp->up = pel_mat3_apply(&o->world_from_model, up);
}

static void add_search(struct lamps *l, const struct pel_beam_lamp *b,
                       const struct pel_object *o)
{
    struct pel_lamp *lamp = add(l, o, b->at, PEL_LAMP_WHITE, b->intensity_cd);
    if (lamp) {
        point(o, b->bearing_rad, b->elevation_rad, lamp);
        lamp->beam_rad = b->half_rad;
        lamp->size_m = 0.5;
    }
}

static void add_signal(struct lamps *l, const struct pel_morse_lamp *m,
                       const struct pel_object *o, double time_s)
{
    double units = (time_s - m->start_s) / m->unit_s;
    if (!m->text[0] || !pel_morse_lit(m->text, units)) {
        return;
    }
    struct pel_lamp *lamp =
        add(l, o, m->at, PEL_LAMP_WHITE,
            m->pointed ? SIGNAL_CD : pel_lamp_intensity(SIGNAL_NM, 0.8));
    if (lamp && m->pointed) {
        point(o, m->bearing_rad, 0, lamp);
        lamp->beam_rad = SIGNAL_RAD;
    }
}

/* --- all ------------------------------------------------------------------ */

/* Whether a switch on AUTO has them lit. */
static bool is_dark(const struct pel_snapshot *s, double time_s,
                    const struct pel_lamp_set *set)
{
    struct pel_entity_state e;
    struct pel_place there;
    pel_snapshot_entity_level(s, set->index, time_s, &e);
    pel_place_of(s, e.east_m, e.north_m, &there);
    struct pel_vec3 sun = pel_place_sun(s, time_s, &there);
    return sun.z < sin(PEL_LAMPS_SUNSET_DEG * PEL_DEG) ||
           s->visibility_m < PEL_LAMPS_VISIBILITY_M ||
           (s->panorama && s->panorama_dark);
}

/* Where the set's entity is; as an object without a model where it has none. */
static struct pel_object place(const struct pel_snapshot *s, double time_s,
                               const struct pel_place *from,
                               const struct pel_lamp_set *set,
                               const struct pel_object *objects, size_t count)
{
    uint32_t id = s->entities[set->index].id;
    for (size_t i = 0; i < count; i++) {
        if (objects[i].id == id) {
            return objects[i];
        }
    }
    struct pel_entity_state e;
    struct pel_object o;
    pel_snapshot_entity_seen(s, set->index, time_s, true, from, &e);
    pel_entity_object(&e, &o);
    return o;
}

size_t pel_snapshot_lamps(const struct pel_snapshot *s, double time_s,
                          const struct pel_place *from,
                          const struct pel_object *objects, size_t object_count,
                          struct pel_lamp out[PEL_MAX_LAMPS])
{
    struct lamps l = { .out = out };
    /* Before all: of a flash nothing is left out. */
    l.count = pel_lightning_lamps(&s->lightning, time_s, PEL_FALL_SHUTTER_S,
                                  out, PEL_MAX_LAMPS / 2);
    if (!s->lamps) {
        return l.count;
    }
    /* Deck lights come last: where there is no room for all, they are left
     * out. */
    for (int decks = 0; decks < 2; decks++) {
        for (size_t i = 0; i < s->lamps->count; i++) {
            const struct pel_lamp_set *set = &s->lamps->sets[i];
            bool lit =
                set->lights == PEL_LAMP_ON ||
                (set->lights == PEL_LAMP_AUTO && is_dark(s, time_s, set));
            struct pel_object o =
                place(s, time_s, from, set, objects, object_count);
            if (decks) {
                if (lights_decks(set, lit)) {
                    add_deck(&l, set, &o);
                }
                continue;
            }
            if (lit && set->is_vessel) {
                struct pel_entity_state e;
                pel_snapshot_entity_level(s, set->index, time_s, &e);
                add_navigation(&l, set, &o, e.speed_mps);
            }
            if (lit && set->has_light) {
                add_light(&l, &set->light, &o, s->epoch_unix_s + time_s);
            }
            if (set->search.on) {
                add_search(&l, &set->search, &o);
            }
            add_signal(&l, &set->signal, &o, time_s);
        }
    }
    return l.count;
}
