/* All the ships, stations and aids that AIS tells of, more than are drawn: a
 * table of up to 2000 beside the scene's entities, and which of them the places
 * that there are go to. Pure but for its memory; control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/nmea_targets.h"

#define PEL_NMEA_FLEET 2000
#define PEL_NMEA_SWAPS 8 /* that one choice makes at most */

struct pel_nmea_known {
    uint64_t key; /* 0: free */
    int64_t heard_ns;
    double far; /* the less, the sooner it is drawn; of the last choice */
    bool drawn; /* likewise */
    struct pel_nmea_target_report report; /* the last of each value */
    bool has_ship;
    struct pel_ais_ship ship;
    char name[PEL_AIS_NAME + 1]; /* "": not told */
};

struct pel_nmea_fleet;
struct pel_nmea_report;

/* capacity: 1 .. PEL_NMEA_FLEET. */
struct pel_nmea_fleet *pel_nmea_fleet_create(size_t capacity);
void pel_nmea_fleet_destroy(struct pel_nmea_fleet *fleet); /* NULL allowed */

/* A report with a position. When all places are taken the newcomer has that of
 * one unheard for 6 minutes, else of the farthest, if that is farther and not
 * drawn; NULL: there is none, and it is forgotten. */
struct pel_nmea_known *
pel_nmea_fleet_take(struct pel_nmea_fleet *fleet, uint64_t key,
                    const struct pel_nmea_target_report *report,
                    int64_t now_ns);

/* NULL: not known. */
struct pel_nmea_known *pel_nmea_fleet_find(struct pel_nmea_fleet *fleet,
                                           uint64_t key);

/* Forgets what was not heard for life_ns. */
void pel_nmea_fleet_expire(struct pel_nmea_fleet *fleet, int64_t life_ns,
                           int64_t now_ns);
size_t pel_nmea_fleet_count(const struct pel_nmea_fleet *fleet);

/* A target that is drawn, and since when. */
struct pel_nmea_drawn {
    uint64_t key;
    int64_t since_ns;
};

struct pel_nmea_choice {
    size_t leave_count, enter_count;
    uint64_t leave[PEL_NMEA_SWAPS];
    struct pel_nmea_known *enter[PEL_NMEA_SWAPS];
};

/* Chooses the targets to draw: the nearest to own ship, of those heard within 6
 * minutes; without own ship (NULL) those heard last. So that nobody comes and
 * goes where two are about as far, one that is drawn stays for 10 s at least
 * and until another is nearer by a tenth (without own ship: was heard 30 s
 * later). `room`: places that are free. The same table and times: the same
 * choice. */
void pel_nmea_fleet_choose(struct pel_nmea_fleet *fleet,
                           const struct pel_nmea_report *own,
                           const struct pel_nmea_drawn *drawn,
                           size_t drawn_count, size_t room, int64_t now_ns,
                           struct pel_nmea_choice *out);

/* The last report as it would be now, on by speed and course. */
struct pel_nmea_target_report
pel_nmea_fleet_reckon(const struct pel_nmea_known *known, int64_t now_ns);
