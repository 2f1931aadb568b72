/* AIS messages (ITU-R M.1371-5, annex 8) written: what bridges/ais.h reads.
 * Pure functions on the caller's memory. */
#pragma once

#include "bridges/ais.h"
#include "bridges/nmea_write.h"

/* The position and status of a ship of class A, message 1; `second` of UTC,
 * 0..59. NaN: not available. */
void pel_ais_say_position(struct pel_nmea_writer *w, const struct pel_ais *a,
                          int second);

/* Its name, type, size and draught, message 5, in two sentences of the sequence
 * 0..9. */
void pel_ais_say_ship(struct pel_nmea_writer *w, const struct pel_ais *a,
                      int sequence);

/* An aid to navigation, message 21. */
void pel_ais_say_aid(struct pel_nmea_writer *w, const struct pel_ais *a,
                     int second);
