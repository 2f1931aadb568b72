/* What the sentences have said so far about own ship and the wind, with the age
 * of each value and the rank of its source. No scene, no clock of its own: the
 * caller gives CLOCK_MONOTONIC times. One thread at a time.
 *
 * A value is fresh for PEL_NMEA_FRESH_NS. Empty fields and void fixes leave
 * everything as it was; values outside the schema's ranges are dropped and
 * counted. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "bridges/ais.h"
#include "bridges/nmea_parse.h"

#define PEL_NMEA_FRESH_NS 10000000000LL

struct pel_nmea_value {
    double value;
    int64_t at_ns; /* 0: never came */
};

/* Best first. A position comes from one source at a time: two that give the
 * same fix at different moments would make the ship jump to and fro. */
enum {
    PEL_FIX_RMC,
    PEL_FIX_GGA,
    PEL_FIX_GNS,
    PEL_FIX_GLL,
    PEL_FIX_VDO,
    PEL_FIXES
};
enum {
    PEL_HEADING_HDT,
    PEL_HEADING_THS,
    PEL_HEADING_PASHR,
    PEL_HEADING_HDG,
    PEL_HEADING_HDM,
    PEL_HEADING_VHW,
    PEL_HEADING_VDO,
    PEL_HEADINGS
};
enum { PEL_MOTION_GNSS, PEL_MOTION_VDO, PEL_MOTION_VHW, PEL_MOTIONS };
enum { PEL_TURN_ROT, PEL_TURN_VDO, PEL_TURNS };
enum {
    PEL_WIND_MWD,
    PEL_WIND_MDA,
    PEL_WIND_MWV_TRUE,
    PEL_WIND_VWT,
    PEL_WIND_MWV_RELATIVE,
    PEL_WIND_VWR,
    PEL_WINDS
};

enum {
    PEL_NMEA_CHANGED_POSE = 1,
    PEL_NMEA_CHANGED_FIX = 2, /* with POSE: the position is new */
    PEL_NMEA_CHANGED_WIND = 4,
    PEL_NMEA_CHANGED_RUDDER = 8,
};

struct pel_nmea_values {
    double latitude, longitude;     /* deg */
    int64_t fix_at_ns;              /* of the position above; 0: none yet */
    int64_t fixes_at_ns[PEL_FIXES]; /* 0: never came */
    struct pel_nmea_value heading[PEL_HEADINGS];     /* deg true */
    struct pel_nmea_value course[PEL_MOTIONS];       /* deg true */
    struct pel_nmea_value speed[PEL_MOTIONS];        /* m/s */
    struct pel_nmea_value turn_rate[PEL_TURNS];      /* deg/s */
    struct pel_nmea_value roll, pitch;               /* deg */
    struct pel_nmea_value heave;                     /* m, up positive */
    struct pel_nmea_value wind_direction[PEL_WINDS]; /* deg true, from */
    struct pel_nmea_value wind_speed[PEL_WINDS];     /* m/s */
    struct pel_nmea_value variation, depth, rudder;  /* deg, m, deg */
    unsigned changed; /* PEL_NMEA_CHANGED_*; the caller clears it */
    uint64_t out_of_range, void_fixes;
};

void pel_nmea_values_take(struct pel_nmea_values *values,
                          const struct pel_nmea_sentence *sentence,
                          int64_t now_ns);

/* Own ship as its transponder gives it (VDO). */
void pel_nmea_values_take_ais(struct pel_nmea_values *values,
                              const struct pel_ais *ais, int64_t now_ns);

bool pel_nmea_fresh(const struct pel_nmea_value *value, int64_t now_ns);

/* The best fresh value, or when none is fresh the newest one; false: none came
 * yet. Heading falls back on the course above 0.5 m/s, course on the heading
 * where the speed is a log's. turn_rate is 0 unless fresh. */
bool pel_nmea_heading(const struct pel_nmea_values *values, int64_t now_ns,
                      double *deg);
bool pel_nmea_motion(const struct pel_nmea_values *values, int64_t now_ns,
                     double *course_deg, double *speed_mps);
double pel_nmea_turn_rate(const struct pel_nmea_values *values, int64_t now_ns);

/* Which of the values above came at now_ns itself: PEL_NMEA_NEW_*. The others
 * are older than what the scene reckons from them. */
enum {
    PEL_NMEA_NEW_HEADING = 1,
    PEL_NMEA_NEW_COURSE = 2,
    PEL_NMEA_NEW_SPEED = 4,
};
unsigned pel_nmea_news(const struct pel_nmea_values *values, int64_t now_ns);

bool pel_nmea_wind(const struct pel_nmea_values *values, int64_t now_ns,
                   double *direction_deg, double *speed_mps);
