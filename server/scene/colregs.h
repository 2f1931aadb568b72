/* The lights that a vessel shows by the International Regulations for
 * Preventing Collisions at Sea (COLREGS 1972, as amended): which by rules 21 to
 * 30, how far seen by rule 22, where by Annex I, sections 2 and 3. Pure
 * functions. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/vec.h"
#include "scene/rhythm.h"

/* What a vessel does: the schema's NavigationStatus, up to 15 the numbers of
 * AIS. */
enum pel_nav_status {
    PEL_NAV_ENGINE = 0,
    PEL_NAV_ANCHOR = 1,
    PEL_NAV_NOT_UNDER_COMMAND = 2,
    PEL_NAV_RESTRICTED = 3,
    PEL_NAV_CONSTRAINED = 4,
    PEL_NAV_MOORED = 5,
    PEL_NAV_AGROUND = 6,
    PEL_NAV_FISHING = 7,
    PEL_NAV_SAILING = 8,
    PEL_NAV_TOWING = 11,
    PEL_NAV_PUSHING = 12,
    PEL_NAV_UNDEFINED = 15,
    PEL_NAV_TRAWLING = 16,
    PEL_NAV_PILOT = 17,
    PEL_NAV_TOWED = 18,
    PEL_NAV_OARS = 19,
};

enum pel_nav_kind {
    PEL_NAV_MASTHEAD,  /* ahead over 225 degrees */
    PEL_NAV_PORT,      /* ahead to 22.5 degrees abaft the beam */
    PEL_NAV_STARBOARD, /* the same */
    PEL_NAV_STERN,     /* aft over 135 degrees */
    PEL_NAV_ALL_ROUND,
};

/* Where a model has its lights, in its frame. */
struct pel_nav_places {
    bool has_masthead, has_second, has_sides, has_stern;
    struct pel_vec3 masthead, second, side, stern;
};

struct pel_vessel {
    double length_m, breadth_m;
    double height_m; /* of its highest point above the waterline */
    enum pel_nav_status status;
    bool makes_way; /* through the water */
    bool anchored;  /* where the status does not say it */
    double tow_m;   /* from its stern to the tow's end */
    struct pel_nav_places described;
};

struct pel_nav_light {
    enum pel_nav_kind kind;
    enum pel_lamp_colour colour;
    double range_nm;
    struct pel_vec3 at; /* in the model's frame */
};

#define PEL_NAV_MOST 16

/* Its lights, from the highest rule down; their number. Not said, and so not
 * shown: gear of more than 150 m, dredgers' free sides, minesweepers, vessels
 * that fly. Moored alongside it shows none. */
size_t pel_colregs_lights(const struct pel_vessel *vessel,
                          struct pel_nav_light out[PEL_NAV_MOST]);

/* Height of the uppermost continuous deck above the waterline, where nobody
 * says it: from length and height. */
double pel_colregs_deck(const struct pel_vessel *vessel);
