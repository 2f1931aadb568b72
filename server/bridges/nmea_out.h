/* NMEA 0183 out: own ship's position, motion, attitude, wind, depth and rudder
 * as sentences over UDP, so that chart programs and consoles follow; and others
 * as radar and AIS have them (nmea_traffic.h). Control
 * thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "bridges/nmea_traffic.h"
#include "scene/scene.h"

/* Every sentence of one report fits. */
#define PEL_NMEA_OUT_SIZE 1400

/* The values of one report. Angles deg, true; NaN: not known, its sentence is
 * left out. */
struct pel_nmea_report {
    double unix_s; /* UTC */
    double latitude, longitude, altitude_m;
    double heading, course, turn_rate; /* turn rate deg/s to starboard */
    double speed_mps;
    double roll, pitch; /* starboard down, bow up */
    double wind_from, wind_mps;
    double depth_m;
    double rudder; /* starboard positive */
};

/* Writes the report's sentences, each with its checksum and CR LF, at most 82
 * characters: RMC, GGA, VTG, ZDA (talker GP), HDT, ROT (HE), MWD, MWV relative
 * (WI), DPT (SD), XDR PITCH and ROLL (YX), RSA (AG). Returns the bytes written
 * (no final 0 counted), *count the sentences. */
size_t pel_nmea_out_write(const struct pel_nmea_report *report,
                          char out[PEL_NMEA_OUT_SIZE], size_t *count);

/* Reads own ship from the scene; false: the entity is not there. */
bool pel_nmea_out_report_of(struct pel_scene *scene, uint32_t entity,
                            struct pel_nmea_report *out);

struct pel_nmea_out_options {
    const char *to; /* "127.0.0.1:10111,7@vm.example:10112": at most 8 ships,
                       each with its ENTITY@ or of `entity`; a broadcast address
                       is allowed */
    double rate_hz; /* reports a second, 0.1..50 */
    uint32_t entity;
    enum pel_nmea_traffic_kind others; /* what is said of other entities */
    struct pel_metrics *metrics;       /* may be NULL */
};

/* INVALID: the address. A report without a receiver, or whose host's name is
 * not resolved, is no error. */
struct pel_nmea_out;
PEL_CHECK enum pel_err
pel_nmea_out_create(const struct pel_nmea_out_options *options,
                    struct pel_scene *scene, struct pel_nmea_out **out,
                    struct pel_fault *fault);
void pel_nmea_out_destroy(struct pel_nmea_out *out); /* NULL allowed */
