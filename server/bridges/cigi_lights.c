/* Lights of entities: components of class 0 (proto/cigi.in.md). */
#include <math.h>

#include "base/vec.h"
#include "bridges/cigi_pose.h"
#include "bridges/cigi_world.h"

enum { LIGHTS = 1, STATUS, DECK_LIGHTS, SEARCHLIGHT, TOW };

/* A new one of this datagram goes before the entity's own. */
static Pelagos__Searchlight *searchlight(struct pel_cigi_edit *edit,
                                         Pelagos__Entity *e)
{
    if (!e->searchlight && edit->searchlight_count < PEL_CIGI_SENSORS) {
        e->searchlight = &edit->searchlights[edit->searchlight_count++];
        pelagos__searchlight__init(e->searchlight);
    }
    return e->searchlight;
}

/* Data that are 0 keep what was. */
static void set(double value, double least, double most,
                protobuf_c_boolean *has, double *to)
{
    if (value != 0) {
        *has = true;
        *to = pel_clamp(value, least, most);
    }
}

static bool point(struct pel_cigi_edit *edit, Pelagos__Entity *e,
                  const struct pel_cigi_component *c)
{
    Pelagos__Searchlight *s = searchlight(edit, e);
    if (!s) {
        return false;
    }
    s->has_on = s->has_bearing = s->has_elevation = true;
    s->on = c->state == 1;
    s->bearing = remainder(c->value[0], 360);
    s->elevation = pel_clamp(c->value[1], -90, 90);
    set(c->value[2], 0.5, 90, &s->has_width, &s->width);
    set(c->value[3], 1, 1e9, &s->has_intensity, &s->intensity);
    return true;
}

static bool is_status(unsigned state)
{
    return protobuf_c_enum_descriptor_get_value(
        &pelagos__navigation_status__descriptor, (int)state);
}

static bool take(struct pel_cigi_edit *edit, Pelagos__Entity *e,
                 const struct pel_cigi_component *c)
{
    bool known = true;
    if (c->id == LIGHTS && c->state <= PELAGOS__LAMP_SWITCH__ON) {
        e->has_lights = true;
        e->lights = (Pelagos__LampSwitch)c->state;
    } else if (c->id == STATUS && is_status(c->state)) {
        e->has_navigation_status = true;
        e->navigation_status = (Pelagos__NavigationStatus)c->state;
    } else if (c->id == DECK_LIGHTS && c->state <= 1) {
        e->has_deck_lights = true;
        e->deck_lights = c->state == 1;
    } else if (c->id == SEARCHLIGHT && c->state <= 1) {
        known = point(edit, e, c);
    } else if (c->id == TOW) {
        e->has_tow_length = true;
        e->tow_length = pel_clamp(c->value[0], 0, 5000);
    } else {
        known = false;
    }
    return known;
}

void pel_cigi_take_lights(struct pel_cigi_edit *edit,
                          const struct pel_cigi_component *c)
{
    for (size_t i = 0; i < c->count; i++) {
        edit->refused = edit->refused || (i != 4 && !isfinite(c->value[i]));
    }
    if (c->id < LIGHTS || c->id > TOW ||
        !pel_cigi_entity_will_be(edit, c->instance)) {
        edit->skipped++;
        return;
    }
    Pelagos__Entity *e =
        edit->refused ? NULL : pel_cigi_edit_entity(edit, c->instance);
    if (e && !take(edit, e, c)) {
        edit->skipped++;
    }
}
