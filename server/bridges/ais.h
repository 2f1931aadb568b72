/* AIS messages (ITU-R M.1371-5, annex 8) from the six-bit payloads of VDM and
 * VDO: the types of the table in ais.c, that is positions of ships (1, 2, 3,
 * 18, 19, 27), base stations (4), search and rescue aircraft (9) and aids to
 * navigation (21), names (5, 19, 21, 24 A), types and sizes (5, 19, 21, 24 B).
 * Pure functions and caller's memory; one thread at a time for an assembler.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/nmea_parse.h"

#define PEL_AIS_MAX_PAYLOAD 512
#define PEL_AIS_SLOTS 8
#define PEL_AIS_NAME 34 /* characters; 20 but for aids to navigation */

/* Of 5, 19, 21 and 24 B; 0: not said. Metres from the antenna. */
struct pel_ais_ship {
    uint8_t type;    /* of ship, or of aid to navigation */
    bool is_virtual; /* an aid that is not there */
    double bow_m, stern_m, port_m, starboard_m, draught_m;
};

/* NaN or "": not available. deg, m, m/s, deg/s; north and east positive. */
struct pel_ais {
    int type;
    uint32_t mmsi;
    bool has_position_report;
    int status;  /* of navigation, 0..15; -1: the type does not say it */
    bool coarse; /* the position is rounded to 0.1 minute (type 27) */
    double latitude, longitude, altitude, speed, course, heading, turn_rate;
    char name[PEL_AIS_NAME + 1];
    bool has_ship;
    struct pel_ais_ship ship;
};

/* False: another type, or a length that the type does not have. */
bool pel_ais_decode(const char *payload, size_t length, struct pel_ais *out);

/* Joins the parts of multi-sentence messages; zero it before first use. The
 * oldest unfinished message gives way. */
struct pel_ais_assembler {
    struct {
        int count, next, sequence; /* count 0: free */
        char channel;
        unsigned age;
        size_t length;
        char payload[PEL_AIS_MAX_PAYLOAD];
    } slots[PEL_AIS_SLOTS];
    unsigned clock;
};

enum pel_ais_part {
    PEL_AIS_WAIT,    /* more parts are to come */
    PEL_AIS_WHOLE,   /* *payload and *length are a message until next call */
    PEL_AIS_DROPPED, /* a part without its first ones, or too long */
};

enum pel_ais_part pel_ais_assemble(struct pel_ais_assembler *assembler,
                                   const struct pel_nmea_sentence *sentence,
                                   const char **payload, size_t *length);
