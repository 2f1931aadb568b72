/* What a target of AIS or radar looks like: a built-in model by its type, with
 * the size that it reports. Pure functions, any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "bridges/ais.h"
#include "pelagos.pb-c.h"

/* Who sent the position. */
enum pel_nmea_station {
    PEL_NMEA_UNSHAPED, /* base stations, aircraft */
    PEL_NMEA_RADAR,
    PEL_NMEA_CLASS_A,
    PEL_NMEA_CLASS_B,
    PEL_NMEA_AID,
};

/* By the type of a message with a position. */
enum pel_nmea_station pel_nmea_station_of(int ais_type);

/* Fills *out, initialised by the caller; its name is static. Dimensions that
 * the model cannot have, and those that are not known, are left out. False: it
 * has no model. `number`: MMSI, or the radar's. */
bool pel_nmea_shape_of(enum pel_nmea_station station, uint32_t number,
                       const struct pel_ais_ship *ship, Pelagos__Model *out);

/* Moves a position from the antenna to the ship's middle. heading [deg] NaN:
 * not known, nothing is moved. */
void pel_nmea_to_middle(const struct pel_ais_ship *ship, double heading,
                        double *latitude, double *longitude);
