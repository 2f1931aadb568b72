/* The registers on the scene: staging, range checks, commits. Knows nothing of
 * sockets or ADUs. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bridges/modbus.h"
#include "bridges/modbus_exercise.h"
#include "bridges/modbus_units.h"

#define PEL_MODBUS_MAX_ROWS 192

/* What input registers and alarms show besides the scene; modbus.c keeps it
 * up to date before a read. */
struct pel_modbus_inputs {
    struct pel_modbus_status status;
    enum pel_modbus_source source;
    size_t clients;
    double heartbeat_age_s; /* NaN: none yet */
    uint64_t commits, refused, malformed;
};

struct pel_modbus_map {
    struct pel_scene *scene;
    struct pel_modbus_unit unit;
    struct pel_modbus_inputs inputs;
    struct {
        bool set;
        double value; /* of the field, in the schema's unit */
    } staged[PEL_MODBUS_MAX_ROWS];
    uint16_t heartbeat; /* last value written */
    bool heard;         /* a heartbeat was written; modbus.c clears it */
    bool steers;        /* own ship was committed by a register once */
    uint64_t commits, refused_commits;
    /* NULL: a commit has taken effect when it is answered. Else it may wait for
     * its sea, and this is called when one no longer does. */
    void (*settled)(void *user);
    void *user;
    unsigned waiting;   /* commits that do */
    enum pel_err ended; /* how a commit did that waited for nothing */
    struct pel_modbus_exercise exercise;
};

/* Tests the table against the schema; INTERNAL names the row at fault. */
PEL_CHECK enum pel_err pel_modbus_map_init(struct pel_modbus_map *map,
                                           struct pel_scene *scene,
                                           const struct pel_modbus_unit *unit,
                                           struct pel_fault *fault);

/* Writes `count` registers (or coils, 0 or 1 each) of one request: all of
 * them, with the commit among them if there is one, or none. */
enum pel_modbus_exception pel_modbus_map_write(struct pel_modbus_map *map,
                                               enum pel_register_space space,
                                               unsigned address, size_t count,
                                               const uint16_t *words);

/* Reads registers or bits (one a word); reserved ones read as 0. The range
 * must lie within the space. */
void pel_modbus_map_read(struct pel_modbus_map *map,
                         enum pel_register_space space, unsigned address,
                         size_t count, uint16_t *words);

/* The unit's ship stops where it is reckoned to be now. */
void pel_modbus_map_stop_ship(struct pel_modbus_map *map);
