/* Other ships, stations and aids to navigation as AIS (VDM) and radar (TTM,
 * TLL) report them: entities 20000 and up of the scene. Control thread only.
 *
 * The table holds PEL_NMEA_TARGETS of them. When it is full a newcomer takes
 * the place of one unheard for 6 minutes (the longest first), else of the
 * farthest from own ship if it is nearer itself; without own ship, of the one
 * unheard longest. Names that come before a position wait in a list of their
 * own, with types and sizes, PEL_NMEA_NAMES long, whose oldest gives way: a
 * report without a position never takes a target's place. An AIS target unheard
 * for 10 minutes and a radar target unheard for 60 s is removed.
 *
 * With a fleet (nmea_fleet.h) all that AIS tells of is kept there, and the
 * table has the nearest of them. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/ais.h"
#include "bridges/nmea_parse.h"
#include "bridges/nmea_shapes.h"
#include "scene/scene.h"

#define PEL_NMEA_TARGETS PEL_BOUND_NMEA_TARGETS
#define PEL_NMEA_NAMES 256
#define PEL_NMEA_TARGET_ID 20000

/* What one report says; NaN: does not say. deg, m, m/s, deg/s. */
struct pel_nmea_target_report {
    bool radar;      /* else AIS */
    uint32_t number; /* MMSI, or the radar's number, 0..999 */
    bool polar;      /* range and bearing from own ship, not a position */
    bool bearing_true;
    bool coarse; /* to 0.1 minute */
    bool lost;   /* the radar lost it */
    enum pel_nmea_station station;
    double latitude, longitude, altitude;
    double range_m, bearing;
    double speed, course, heading, turn_rate;
    int status; /* of navigation, by AIS; -1: does not say */
};

struct pel_nmea_target {
    uint64_t key; /* radar << 32 | number, + 1; 0: free */
    int64_t heard_ns;
    int64_t fine_ns;  /* the last position that was not coarse, 0: none */
    int64_t tll_ns;   /* the last position of a radar target, not polar */
    int64_t drawn_ns; /* since when */
    double latitude, longitude;
    double heading; /* the last that was known, NaN: none */
    enum pel_nmea_station station;
    struct pel_ais_ship ship;
    bool renamed;  /* its name is not in the scene yet */
    bool reshaped; /* nor its model */
    char name[40];
};

struct pel_nmea_name {
    uint64_t key; /* 0: free */
    uint64_t used;
    char name[PEL_AIS_NAME + 1]; /* "": none yet */
    struct pel_ais_ship ship;
};

#define PEL_NMEA_REPORTS_AN_EDIT 16

struct pel_nmea_target_counters {
    uint64_t evicted; /* gave way to a newcomer */
    uint64_t refused; /* newcomers farther than all, with all places taken */
    uint64_t ignored; /* reports without a usable position */
    uint64_t edits, refused_edits;
};

struct pel_nmea_fleet;

/* Zero it, then set scene, own_ship (an entity's id), fleet and counters. */
struct pel_nmea_targets {
    struct pel_scene *scene;
    uint32_t own_ship;
    struct pel_nmea_fleet *fleet; /* of AIS, of whom the table has those that
                                   * are drawn; NULL: the table is all */
    int64_t chosen_ns;            /* of them, the last time */
    struct pel_nmea_target targets[PEL_NMEA_TARGETS];
    struct pel_nmea_name names[PEL_NMEA_NAMES];
    uint64_t name_clock;
    struct pel_nmea_target_report pending[PEL_NMEA_REPORTS_AN_EDIT];
    size_t pending_count;
    bool renamed, reshaped; /* one of the targets is */
    bool shaping;           /* models of shaped[] are being made */
    bool plain; /* for now of their kinds' own sizes, as many have none */
    bool shaped[PEL_NMEA_TARGETS];
    struct pel_nmea_target_counters *counters;
};

/* Take a message of another ship, or a TTM or TLL. The scene is edited when
 * PEL_NMEA_REPORTS_AN_EDIT reports wait, and by pel_nmea_targets_commit. */
void pel_nmea_targets_take_ais(struct pel_nmea_targets *targets,
                               const struct pel_ais *ais, int64_t now_ns);
void pel_nmea_targets_take_radar(struct pel_nmea_targets *targets,
                                 const struct pel_nmea_sentence *sentence,
                                 int64_t now_ns);

/* The waiting reports become one edit of the scene, and new shapes another,
 * which takes effect when a thread has made them. */
void pel_nmea_targets_commit(struct pel_nmea_targets *targets, int64_t now_ns);

/* Removes what has been silent too long. */
void pel_nmea_targets_expire(struct pel_nmea_targets *targets, int64_t now_ns);

/* Before *targets goes, or its scene. */
void pel_nmea_targets_finish(struct pel_nmea_targets *targets);

size_t pel_nmea_targets_count(const struct pel_nmea_targets *targets);
/* With those of the fleet that are not drawn. */
size_t pel_nmea_targets_known(const struct pel_nmea_targets *targets);
