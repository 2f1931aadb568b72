/* What the lamps of a snapshot's entities are made of: between
 * scene/lampplan.c, which makes it of the state, and scene/lamps.c, which
 * lights them. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>

#include "scene/colregs.h"
#include "scene/rhythm.h"

#define PEL_LIGHT_SECTORS 12

enum pel_lamp_switch { PEL_LAMP_OFF, PEL_LAMP_AUTO, PEL_LAMP_ON };

struct pel_light_sector {
    enum pel_lamp_colour colour;
    double from_rad, arc_rad; /* in which it shines, clockwise of local north;
                                 2 π: all round */
    double intensity_cd;
};

struct pel_mark_light {
    struct pel_rhythm rhythm;
    double phase_s;
    double intensity_cd;
    struct pel_vec3 at; /* in the model's frame */
    int sector_count;   /* 0: all round */
    struct pel_light_sector sectors[PEL_LIGHT_SECTORS];
};

struct pel_beam_lamp {
    bool on;
    double bearing_rad, elevation_rad, half_rad, intensity_cd;
    struct pel_vec3 at;
};

struct pel_morse_lamp {
    char text[65]; /* "": none */
    double start_s, unit_s;
    bool pointed;
    double bearing_rad;
    struct pel_vec3 at;
};

/* One entity. */
struct pel_lamp_set {
    size_t index; /* into the snapshot's */
    enum pel_lamp_switch lights;
    bool is_vessel, has_light;
    struct pel_vessel vessel; /* but whether it makes way */
    struct pel_mark_light light;
    bool deck;
    struct pel_beam_lamp search;
    struct pel_morse_lamp signal;
};

struct pel_lamp_plan {
    atomic_uint refs;
    size_t count;
    struct pel_lamp_set sets[];
};
