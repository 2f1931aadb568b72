/* What own ship's radar and AIS receiver would say of the other entities: TTM,
 * and VDM with messages 1, 5 and 21. Control thread. */
#pragma once

#include <stdbool.h>

#include "bridges/ais.h"
#include "bridges/nmea_write.h"
#include "scene/scene.h"

#define PEL_NMEA_RADAR_TARGETS 100 /* of two digits */

enum pel_nmea_traffic_kind {
    PEL_NMEA_TRAFFIC_NONE,
    PEL_NMEA_TRAFFIC_TTM,
    PEL_NMEA_TRAFFIC_AIS,
    PEL_NMEA_TRAFFIC_BOTH
};

/* Own ship's, or another's; deg, true, m/s, deg/s. */
struct pel_nmea_pose {
    double latitude, longitude, speed, course, heading, turn_rate;
};

/* The radar's target `number` from own ship at unix_s, range up to 99 nautical
 * miles; its closest point of approach if both go straight on. */
void pel_nmea_say_target(struct pel_nmea_writer *w, int number,
                         const char *name, const struct pel_nmea_pose *own,
                         const struct pel_nmea_pose *other, double unix_s);

/* Entities by the radar's numbers, + 1; 0: free. Zeroed at first. */
struct pel_nmea_radar {
    uint32_t entities[PEL_NMEA_RADAR_TARGETS];
};

/* Whom a report is for, when, the how manyth. */
struct pel_nmea_traffic {
    enum pel_nmea_traffic_kind kind;
    uint32_t entity; /* own ship */
    uint64_t report;
    double rate_hz;
};

/* Writes what is due of entities that have a model and stand within 24 nautical
 * miles (TTM) or anywhere (AIS), those that other receivers report (20000 and
 * up) left out; calls `flush` when the writer is full and at the end. Nothing
 * without own ship. */
void pel_nmea_traffic_say(const struct pel_nmea_traffic *traffic,
                          struct pel_scene *scene, struct pel_nmea_radar *radar,
                          struct pel_nmea_writer *w,
                          void (*flush)(void *user, struct pel_nmea_writer *w),
                          void *user);

/* MMSI of an entity: a ship's, of a country that is none, or an aid's. */
uint32_t pel_nmea_mmsi_of(uint32_t entity, bool aid);

/* Type of ship or of aid to navigation (ITU-R M.1371-5, tables 53 and 74) by
 * enum pel_model_class; false: it has no AIS. */
bool pel_nmea_ais_type(int model_class, bool *aid, uint8_t *type);
