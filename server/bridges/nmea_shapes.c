#include "bridges/nmea_shapes.h"

#include <math.h>
#include <stddef.h>

#include "base/vec.h"
#include "scene/fleet.h"
#include "scene/geodesy.h"

/* The model of a type of ship (ITU-R M.1371-5, table 53): of its rows the one
 * with the greatest `least_m` that its length reaches; without a length the
 * first, as long as `assumed_m` (0: the model's own). Other types are type 0.
 */
static const struct row {
    uint8_t from, to;
    double least_m;
    const char *model;
    double assumed_m;
} rows[] = {
    { 0, 0, 40, "bulk-carrier", 90 },
    { 0, 0, 0, "pilot-launch", 0 },
    { 20, 29, 0, "pilot-launch", 0 }, /* wing in ground */
    { 30, 30, 0, "fishing-boat", 0 },
    { 31, 32, 0, "tug", 0 },
    { 33, 34, 0, "tug", 0 }, /* dredging, diving */
    { 33, 34, 60, "bulk-carrier", 0 },
    { 35, 35, 0, "patrol-boat", 0 }, /* military */
    { 36, 36, 0, "sailing-yacht", 0 },
    { 37, 37, 0, "pilot-launch", 12 }, /* pleasure craft */
    { 40, 49, 30, "ferry", 40 },       /* high speed */
    { 40, 49, 0, "patrol-boat", 0 },
    { 50, 51, 0, "pilot-launch", 0 }, /* pilot, search and rescue */
    { 52, 54, 0, "tug", 0 },          /* tug, port tender, against pollution */
    { 55, 55, 0, "patrol-boat", 0 },
    { 56, 58, 0, "pilot-launch", 0 },
    { 60, 69, 30, "ferry", 0 },
    { 60, 69, 250, "cruise-ship", 0 },
    { 60, 69, 0, "pilot-launch", 0 },
    { 70, 79, 30, "bulk-carrier", 0 },
    { 70, 79, 200, "container-ship", 0 },
    { 70, 79, 0, "pilot-launch", 0 },
    { 80, 89, 30, "tanker", 0 },
    { 80, 89, 0, "pilot-launch", 0 },
};
#define PLEASURE 37

/* Floating aids to navigation by their type (table 74), and beacons. Lights
 * stand on land as a rule and have none. [1]: IALA region B. */
#define ALIKE(name)                                                            \
    {                                                                          \
        name, name                                                             \
    }
static const char *const aids[32][2] = {
    [9] = ALIKE("beacon"),
    [10] = ALIKE("beacon"),
    [11] = ALIKE("beacon"),
    [12] = ALIKE("beacon"),
    [13] = ALIKE("beacon"),
    [14] = ALIKE("beacon"),
    [15] = ALIKE("beacon"),
    [16] = ALIKE("beacon"),
    [17] = ALIKE("beacon"),
    [18] = ALIKE("beacon"),
    [19] = ALIKE("beacon"),
    [20] = ALIKE("cardinal-north"),
    [21] = ALIKE("cardinal-east"),
    [22] = ALIKE("cardinal-south"),
    [23] = ALIKE("cardinal-west"),
    [24] = { "lateral-port-a", "lateral-port-b" },
    [25] = { "lateral-starboard-a", "lateral-starboard-b" },
    [28] = ALIKE("isolated-danger"),
    [29] = ALIKE("safe-water"),
    [30] = ALIKE("special-mark"),
    [31] = ALIKE("light-float"),
};

enum pel_nmea_station pel_nmea_station_of(int ais_type)
{
    switch (ais_type) {
    case 4:
    case 9:
        return PEL_NMEA_UNSHAPED;
    case 18:
    case 19:
        return PEL_NMEA_CLASS_B;
    case 21:
        return PEL_NMEA_AID;
    default:
        return PEL_NMEA_CLASS_A;
    }
}

/* By the country in an aid's MMSI, 99MIDxxxx: the Americas without Greenland,
 * Japan, Korea and the Philippines. */
static bool in_region_b(uint32_t mmsi)
{
    uint32_t mid = mmsi / 10000 % 1000;
    return (mid / 100 == 3 && mid != 331) || mid / 100 == 7 || mid == 431 ||
           mid == 432 || mid == 440 || mid == 441 || mid == 548;
}

static const struct row *row_of(int type, double length_m)
{
    const struct row *best = NULL;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct row *r = &rows[i];
        bool fits = length_m > 0 ? length_m >= r->least_m : !best;
        if (type >= r->from && type <= r->to && fits &&
            (!best || r->least_m > best->least_m)) {
            best = r;
        }
    }
    return best ? best : row_of(0, length_m);
}

static void set_sizes(const struct pel_ais_ship *ship, const struct row *row,
                      Pelagos__Model *out)
{
    double length = ship->bow_m + ship->stern_m;
    double beam = ship->port_m + ship->starboard_m;
    if (length > 0 && beam > length) { /* nonsense, or swapped */
        beam = 0;
    }
    out->has_length = length > 0 || row->assumed_m > 0;
    out->length = length > 0 ? length : row->assumed_m;
    out->has_beam = length > 0 && beam > 0;
    out->beam = beam;
    out->has_draught = length > 0 && ship->draught_m > 0;
    out->draught = ship->draught_m;
    pel_fleet_trim(out);
    if (length > 0 && !out->has_length) { /* the others would not go with it */
        out->has_beam = out->has_draught = 0;
    }
}

bool pel_nmea_shape_of(enum pel_nmea_station station, uint32_t number,
                       const struct pel_ais_ship *ship, Pelagos__Model *out)
{
    int type = ship->type;
    if (station == PEL_NMEA_UNSHAPED ||
        (station == PEL_NMEA_AID && ship->is_virtual)) {
        return false;
    }
    if (station == PEL_NMEA_AID) {
        out->name = (char *)aids[type & 31][in_region_b(number)];
        return out->name != NULL;
    }
    switch (station == PEL_NMEA_CLASS_A ? number / 1000000 : 0) {
    case 970: /* its transmitter of search and rescue */
        out->name = (char *)"life-raft";
        return true;
    case 972:
        out->name = (char *)"person";
        return true;
    default:
        break;
    }
    if (type == 0 && station == PEL_NMEA_CLASS_B) {
        type = PLEASURE;
    }
    const struct row *row = row_of(type, ship->bow_m + ship->stern_m);
    out->name = (char *)row->model;
    set_sizes(ship, row, out);
    return true;
}

void pel_nmea_to_middle(const struct pel_ais_ship *ship, double heading,
                        double *latitude, double *longitude)
{
    double ahead = (ship->bow_m - ship->stern_m) / 2;
    double right = (ship->starboard_m - ship->port_m) / 2;
    /* Where it does not say where the antenna is, length and beam are in stern
     * and starboard. */
    if (isnan(heading) || (ship->bow_m == 0 && ship->port_m == 0)) {
        return;
    }
    double s = sin(heading * PEL_DEG), c = cos(heading * PEL_DEG);
    pel_geo_from_local(*latitude, *longitude, ahead * s + right * c,
                       ahead * c - right * s, latitude, longitude);
}
