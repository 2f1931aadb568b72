#include "bridges/modbus_map.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "fields.h"
#include "path.h"
#include "scene/helm.h"
#include "scene/scene.h"

#define FIRST_ENTITY "entities.1." /* of the table */
#define OWN_SHIP "ownShip."

enum pel_err pel_modbus_map_init(struct pel_modbus_map *map,
                                 struct pel_scene *scene,
                                 const struct pel_modbus_unit *unit,
                                 struct pel_fault *fault)
{
    static const unsigned limits[] = { PEL_HOLDING_COUNT, PEL_INPUT_COUNT,
                                       PEL_DISCRETE_COUNT, PEL_COIL_COUNT };
    *map = (struct pel_modbus_map){ .scene = scene, .unit = *unit };
    if (pel_register_count > PEL_MODBUS_MAX_ROWS) {
        return pel_fault_set(fault, PEL_ERR_INTERNAL, "registers.def: %zu rows",
                             pel_register_count);
    }
    for (size_t i = 0; i < pel_register_count; i++) {
        const struct pel_register *reg = &pel_registers[i];
        struct pel_path_info info;
        char path[96];
        int view;
        if (reg->address + pel_register_words(reg->type) > limits[reg->space]) {
            return pel_fault_set(fault, PEL_ERR_INTERNAL,
                                 "registers.def: address %u is outside",
                                 reg->address);
        }
        if (reg->path &&
            (pel_register_path(reg, "x", path, sizeof path, &view) != PEL_OK ||
             pel_path_find(path, &info, fault) != PEL_OK)) {
            return pel_fault_set(fault, PEL_ERR_INTERNAL,
                                 "registers.def: %s is not in the schema",
                                 reg->path);
        }
    }
    return PEL_OK;
}

/* Path of a field's row in the present state; NULL: that view is not there. */
static const char *row_path(struct pel_modbus_map *map,
                            const struct pel_register *reg, char *out,
                            size_t size)
{
    const Pelagos__State *state = pel_scene_state(map->scene);
    const char *name = "x";
    int view;
    if (pel_register_path(reg, name, out, size, &view) != PEL_OK) {
        return NULL;
    }
    if (strncmp(out, FIRST_ENTITY, strlen(FIRST_ENTITY)) == 0) {
        snprintf(out, size, "entities.%u.%s", map->unit.entity,
                 reg->path + strlen(FIRST_ENTITY));
        return out;
    }
    if (map->unit.has_entity && strncmp(out, OWN_SHIP, strlen(OWN_SHIP)) == 0) {
        char helm[PEL_HELM_PATH];
        snprintf(out, size, "%s.%s",
                 pel_helm_path(state, map->unit.entity, helm),
                 reg->path + strlen(OWN_SHIP));
        return out;
    }
    if (view < 0) {
        return out;
    }
    size_t index = map->unit.first_view + (size_t)view;
    if (index >= state->n_views) {
        return NULL;
    }
    name = state->views[index]->name;
    return pel_register_path(reg, name, out, size, &view) == PEL_OK ? out
                                                                    : NULL;
}

static void sun_now(struct pel_modbus_map *map, double *azimuth,
                    double *elevation)
{
    const struct pel_snapshot *s = pel_scene_snapshot(map->scene);
    struct pel_vec3 sun = pel_snapshot_sun(s, pel_scene_time(map->scene));
    pel_snapshot_unref(s);
    *azimuth = pel_bearing_deg(atan2(sun.x, sun.y) / PEL_DEG, 3);
    *elevation = asin(pel_clamp(sun.z, -1, 1)) / PEL_DEG;
}

/* --- reading ------------------------------------------------------------ */

static double field_value(struct pel_modbus_map *map,
                          const struct pel_register *reg)
{
    char path[96], text[64];
    struct pel_path_info info;
    double azimuth, elevation;
    if (!row_path(map, reg, path, sizeof path) ||
        pel_path_find(path, &info, NULL) != PEL_OK ||
        pel_path_get(pel_scene_state(map->scene), path, text, sizeof text,
                     NULL) != PEL_OK) {
        return NAN;
    }
    if (!*text && strncmp(path, "sky.sun", 7) == 0) {
        sun_now(map, &azimuth, &elevation);
        return strcmp(path, "sky.sunAzimuth") == 0 ? azimuth : elevation;
    }
    if (info.field->type == PROTOBUF_C_TYPE_ENUM) {
        const ProtobufCEnumValue *value =
            pel_enum_by_name(info.field->descriptor, text, strlen(text));
        return value ? value->value : NAN;
    }
    return *text ? strtod(text, NULL) : NAN;
}

/* Own ship as the scene reckons it for now. */
static double ship_value(struct pel_modbus_map *map,
                         enum pel_register_source source)
{
    const struct pel_snapshot *s = pel_scene_snapshot(map->scene);
    double latitude, longitude, value = NAN;
    for (size_t i = 0; i < s->entity_count; i++) {
        struct pel_entity_state e;
        if (s->entities[i].id != map->unit.entity) {
            continue;
        }
        pel_snapshot_entity_at(s, i, pel_scene_time(map->scene), &e);
        pel_geo_from_local(s->origin_latitude_rad / PEL_DEG,
                           s->origin_longitude_rad / PEL_DEG, e.east_m,
                           e.north_m, &latitude, &longitude);
        value = source == PEL_SOURCE_SHIP_LATITUDE ? latitude * 1e7
                : source == PEL_SOURCE_SHIP_LONGITUDE
                    ? longitude * 1e7
                    : pel_bearing_deg(e.heading_rad / PEL_DEG, 3);
    }
    pel_snapshot_unref(s);
    return value;
}

static double sun_value(struct pel_modbus_map *map,
                        enum pel_register_source source)
{
    double azimuth, elevation;
    sun_now(map, &azimuth, &elevation);
    return source == PEL_SOURCE_SUN_AZIMUTH ? azimuth : elevation;
}

static size_t staged_count(const struct pel_modbus_map *map)
{
    size_t count = 0;
    for (size_t i = 0; i < pel_register_count; i++) {
        count += map->staged[i].set;
    }
    return count;
}

static bool sun_from_clock(struct pel_modbus_map *map)
{
    const Pelagos__State *state = pel_scene_state(map->scene);
    return !state->sky || !state->sky->has_sun_azimuth ||
           !state->sky->has_sun_elevation;
}

/* Counters wrap as 32-bit registers do. */
static double wrap32(uint64_t count)
{
    return (double)(uint32_t)count;
}

static double source_value(struct pel_modbus_map *map,
                           const struct pel_register *reg)
{
    const struct pel_modbus_inputs *in = &map->inputs;
    const Pelagos__Sources *others = pel_scene_state(map->scene)->sources;
    bool alarm_source =
        in->source == PEL_MODBUS_STALE || in->source == PEL_MODBUS_HELD;
    switch (reg->source) {
    case PEL_SOURCE_PATH:
        return field_value(map, reg) / reg->scale;
    case PEL_SOURCE_PROBE_U32:
        return PEL_PROBE_U32;
    case PEL_SOURCE_PROBE_F32:
        return PEL_PROBE_F32;
    case PEL_SOURCE_HEARTBEAT:
        return map->heartbeat;
    case PEL_SOURCE_COMMIT:
    case PEL_SOURCE_STAGED:
        return (double)staged_count(map);
    case PEL_SOURCE_SUN_FROM_CLOCK:
        return sun_from_clock(map);
    case PEL_SOURCE_REVISION:
        return wrap32(pel_scene_state(map->scene)->revision);
    case PEL_SOURCE_FRAME:
        return wrap32(in->status.frame_number);
    case PEL_SOURCE_TIME:
        return pel_scene_time(map->scene);
    case PEL_SOURCE_FPS:
        return in->status.frames_per_s;
    case PEL_SOURCE_RENDER_MS:
        return in->status.render_ms;
    case PEL_SOURCE_SOURCE:
        return in->source;
    case PEL_SOURCE_CLIENTS:
        return (double)in->clients;
    case PEL_SOURCE_HEARTBEAT_AGE:
        return in->heartbeat_age_s;
    case PEL_SOURCE_COMMITS:
        return wrap32(in->commits);
    case PEL_SOURCE_REFUSED:
        return wrap32(in->refused);
    case PEL_SOURCE_MALFORMED:
        return wrap32(in->malformed);
    case PEL_SOURCE_NMEA_SENTENCES:
        return wrap32(in->status.nmea_sentences);
    case PEL_SOURCE_NMEA_ERRORS:
        return wrap32(in->status.nmea_errors);
    case PEL_SOURCE_SHIP_LATITUDE:
    case PEL_SOURCE_SHIP_LONGITUDE:
    case PEL_SOURCE_SHIP_HEADING:
        return ship_value(map, reg->source);
    case PEL_SOURCE_SUN_AZIMUTH:
    case PEL_SOURCE_SUN_ELEVATION:
        return sun_value(map, reg->source);
    case PEL_SOURCE_ALARM:
        return alarm_source || in->status.nmea_stale ||
               in->status.frames_stalled || others->cigi_stale ||
               others->console_stale;
    case PEL_SOURCE_ALARM_CIGI:
        return others->cigi_stale;
    case PEL_SOURCE_ALARM_CONSOLE:
        return others->console_stale;
    case PEL_SOURCE_ALARM_SOURCE:
        return alarm_source;
    case PEL_SOURCE_ALARM_NMEA:
        return in->status.nmea_stale;
    case PEL_SOURCE_ALARM_FRAMES:
        return in->status.frames_stalled;
    default:
        return pel_modbus_exercise_value(&map->exercise, reg->source);
    }
}

/* The row whose stage a register shows: a coil shares its register's, which
 * is the first row of that source as holding registers come first. */
static size_t stage_of(const struct pel_register *reg)
{
    if (reg->source == PEL_SOURCE_SUN_FROM_CLOCK) {
        for (reg = pel_registers; reg->source != PEL_SOURCE_SUN_FROM_CLOCK;) {
            reg++;
        }
    }
    return (size_t)(reg - pel_registers);
}

void pel_modbus_map_read(struct pel_modbus_map *map,
                         enum pel_register_space space, unsigned address,
                         size_t count, uint16_t *words)
{
    unsigned end = address + (unsigned)count;
    memset(words, 0, count * sizeof *words);
    for (size_t i = 0; i < pel_register_count; i++) {
        const struct pel_register *reg = &pel_registers[i];
        unsigned reg_end =
            reg->address + (unsigned)pel_register_words(reg->type);
        if (reg->space != space || reg_end <= address || reg->address >= end) {
            continue;
        }
        size_t stage = stage_of(reg);
        double value = map->staged[stage].set
                           ? map->staged[stage].value / reg->scale
                           : source_value(map, reg);
        uint16_t encoded[4];
        pel_register_encode(reg->type, map->unit.order, value, encoded);
        for (unsigned k = reg->address; k < reg_end; k++) {
            if (k >= address && k < end) {
                words[k - address] = encoded[k - reg->address];
            }
        }
    }
}

/* --- writing ------------------------------------------------------------ */

/* A limit that a single-precision register cannot hold exactly (0.01) is met
 * by its nearest number: that counts as the limit. */
static bool in_range(const struct pel_register *reg,
                     const struct pel_field *field, double *value)
{
    double low = field->minimum, high = field->maximum;
    if (reg->type == PEL_TYPE_F32) {
        low = (float)low;
        high = (float)high;
    }
    if (!(*value >= low && *value <= high)) {
        return false;
    }
    *value = pel_clamp(*value, field->minimum, field->maximum);
    return true;
}

/* What a field without a default reads as while it is absent (the register's
 * not-a-number) takes it away again when it is written. */
static bool removes(const struct pel_register *reg,
                    const ProtobufCFieldDescriptor *field, double value)
{
    return !field->default_value && strncmp(reg->path, "water.", 6) == 0 &&
           (reg->type == PEL_TYPE_F32 ? isnan(value) != 0
                                      : value == (double)UINT16_MAX);
}

static enum pel_modbus_exception check_field(struct pel_modbus_map *map,
                                             const struct pel_register *reg,
                                             double *value)
{
    char path[96];
    struct pel_path_info info;
    if (!row_path(map, reg, path, sizeof path) ||
        pel_path_find(path, &info, NULL) != PEL_OK) {
        return PEL_MODBUS_ILLEGAL_ADDRESS;
    }
    if (removes(reg, info.field, *value)) {
        *value = NAN;
        return PEL_MODBUS_DONE;
    }
    bool legal = isfinite(*value);
    if (info.field->type == PROTOBUF_C_TYPE_ENUM) {
        legal = protobuf_c_enum_descriptor_get_value(info.field->descriptor,
                                                     (int)*value) != NULL;
    } else if (info.field->type == PROTOBUF_C_TYPE_BOOL) {
        legal = *value == 0 || *value == 1;
    } else if (info.info && info.info->ranged) {
        legal = in_range(reg, info.info, value);
    }
    return legal ? PEL_MODBUS_DONE : PEL_MODBUS_ILLEGAL_VALUE;
}

/* Stages one value; *commit is set by a commit register. */
static enum pel_modbus_exception stage(struct pel_modbus_map *map,
                                       const struct pel_register *reg,
                                       double value, bool *commit)
{
    enum pel_modbus_exception code;
    size_t i = stage_of(reg);
    switch (reg->source) {
    case PEL_SOURCE_PATH:
        value *= reg->scale;
        code = check_field(map, reg, &value);
        if (code) {
            return code;
        }
        map->staged[i].set = true;
        map->staged[i].value = value;
        return PEL_MODBUS_DONE;
    case PEL_SOURCE_SUN_FROM_CLOCK:
        if (value != 0 && value != 1) {
            return PEL_MODBUS_ILLEGAL_VALUE;
        }
        map->staged[i].set = true;
        map->staged[i].value = value;
        return PEL_MODBUS_DONE;
    case PEL_SOURCE_HEARTBEAT:
        map->heartbeat = (uint16_t)value;
        map->heard = true;
        return PEL_MODBUS_DONE;
    case PEL_SOURCE_COMMIT:
        if (value != 0 && value != 1) {
            return PEL_MODBUS_ILLEGAL_VALUE;
        }
        *commit = *commit || value == 1;
        if (value == 0 && reg->space == PEL_SPACE_HOLDING) {
            memset(map->staged, 0, sizeof map->staged);
        }
        return PEL_MODBUS_DONE;
    default:
        return pel_modbus_exercise_take(&map->exercise, reg->source, value);
    }
}

static enum pel_err set_sun(struct pel_modbus_map *map, Pelagos__Patch *patch,
                            bool from_clock, struct pel_fault *fault)
{
    static const char *const paths[] = { "sky.sunAzimuth", "sky.sunElevation" };
    double sun[2];
    sun_now(map, &sun[0], &sun[1]);
    for (int i = 0; i < 2; i++) {
        enum pel_err err =
            from_clock
                ? pel_path_set(patch, NULL, paths[i], NULL, fault)
                : pel_path_set_number(patch, NULL, paths[i], sun[i], fault);
        if (err) {
            return err;
        }
    }
    return PEL_OK;
}

static enum pel_err build_patch(struct pel_modbus_map *map,
                                Pelagos__Patch *patch, struct pel_fault *fault)
{
    /* The Sun's switch first, so that angles staged with it win. */
    size_t sun = stage_of(pel_register_at(PEL_SPACE_COIL, 0));
    enum pel_err err = PEL_OK;
    if (map->staged[sun].set) {
        err = set_sun(map, patch, map->staged[sun].value != 0, fault);
    }
    for (size_t i = 0; i < pel_register_count && !err; i++) {
        char path[96];
        if (!map->staged[i].set || i == sun) {
            continue;
        }
        if (!row_path(map, &pel_registers[i], path, sizeof path)) {
            return pel_fault_set(fault, PEL_ERR_NOT_FOUND, "%s: no such view",
                                 pel_registers[i].path);
        }
        double value = map->staged[i].value;
        const Pelagos__State *now = pel_scene_state(map->scene);
        err = isnan(value)
                  ? pel_path_set(patch, now, path, NULL, fault)
                  : pel_path_set_number(patch, now, path, value, fault);
    }
    return err;
}

static void count_commit(struct pel_modbus_map *map, enum pel_err err,
                         const struct pel_fault *fault)
{
    static struct pel_log_limit limit;
    if (err) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "MBS-002",
                        "a commit by Modbus was refused: %s %s", fault->path,
                        fault->message);
        map->refused_commits++;
    } else {
        map->commits++;
    }
}

static void on_committed(void *user, enum pel_err err,
                         const struct pel_fault *fault)
{
    struct pel_modbus_map *map = user;
    count_commit(map, err, fault);
    map->ended = err;
    map->waiting--;
    map->settled(map->user);
}

/* Tested now, in effect when its sea is built; or all at once. */
static enum pel_err commit(struct pel_modbus_map *map,
                           const Pelagos__Patch *patch, struct pel_fault *fault)
{
    const struct pel_scene_wish wish = { .patch = patch, .source = map };
    /* Who is answered before a sea is built is told now of a full disk. */
    enum pel_err err = map->settled ? pel_scene_keeps(map->scene, fault)
                                    : pel_scene_patch(map->scene, patch, fault);
    if (!err && map->settled) {
        err = pel_scene_test(map->scene, patch, fault);
    }
    if (!err && map->settled) {
        map->waiting++;
        map->ended = PEL_OK;
        /* A disk that is full refuses what the test let through. */
        if (!pel_scene_submit(map->scene, &wish, on_committed, map)) {
            return map->ended;
        }
    } else if (!err) {
        count_commit(map, PEL_OK, fault);
    }
    return err;
}

static enum pel_modbus_exception commit_staged(struct pel_modbus_map *map)
{
    struct pel_fault fault;
    if (staged_count(map) == 0) {
        return PEL_MODBUS_DONE;
    }
    Pelagos__Patch *patch = pel_patch_new();
    bool steers = false;
    enum pel_err err = build_patch(map, patch, &fault);
    if (!err) {
        steers = patch->state &&
                 (patch->state->n_entities > 0 || patch->state->own_ship);
        err = commit(map, patch, &fault);
    }
    pelagos__patch__free_unpacked(patch, NULL);
    if (err) {
        if (!map->ended) {
            count_commit(map, err, &fault);
        }
        map->ended = PEL_OK;
        return err == PEL_ERR_INTERNAL || err == PEL_ERR_NO_MEMORY ||
                       err == PEL_ERR_FULL
                   ? PEL_MODBUS_FAILURE
                   : PEL_MODBUS_ILLEGAL_VALUE;
    }
    memset(map->staged, 0, sizeof map->staged);
    map->steers = map->steers || steers;
    return PEL_MODBUS_DONE;
}

enum pel_modbus_exception pel_modbus_map_write(struct pel_modbus_map *map,
                                               enum pel_register_space space,
                                               unsigned address, size_t count,
                                               const uint16_t *words)
{
    const struct pel_modbus_map before = *map;
    enum pel_modbus_exception code = PEL_MODBUS_DONE;
    bool commit = false;
    for (size_t i = 0; i < count && !code;) {
        const struct pel_register *reg =
            pel_register_at(space, address + (unsigned)i);
        size_t width = reg ? pel_register_words(reg->type) : 0;
        if (!reg || !pel_register_writable(reg) ||
            reg->address != address + i || width > count - i) {
            code = PEL_MODBUS_ILLEGAL_ADDRESS;
            break;
        }
        double value =
            pel_register_decode(reg->type, map->unit.order, words + i);
        code = stage(map, reg, value, &commit);
        i += width;
    }
    if (!code && commit) {
        code = commit_staged(map);
    }
    if (!code) { /* in the table no commit is next to it */
        code = pel_modbus_exercise_act(&map->exercise);
    }
    if (code) {
        uint64_t refused = map->refused_commits;
        *map = before;
        map->refused_commits = refused;
    }
    return code;
}

void pel_modbus_map_stop_ship(struct pel_modbus_map *map)
{
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    Pelagos__State state = PELAGOS__STATE__INIT;
    Pelagos__Entity entity = PELAGOS__ENTITY__INIT;
    Pelagos__Entity *list = &entity;
    struct pel_fault fault;
    Pelagos__OwnShip orders = PELAGOS__OWN_SHIP__INIT;
    const Pelagos__State *now = pel_scene_state(map->scene);
    const Pelagos__OwnShip *helm = pel_helm_of(now, map->unit.entity);
    entity.has_id = 1;
    entity.id = map->unit.entity;
    orders.has_throttle = orders.has_rudder = 1; /* to zero; it drifts */
    patch.state = &state;
    state.entities = &list;
    state.n_entities = 1;
    if (helm && helm == now->own_ship) {
        state.own_ship = &orders;
        state.n_entities = 0;
    } else if (helm) {
        entity.helm = &orders;
    } else {
        entity.has_speed = entity.has_turn_rate = 1;
    }
    if (pel_scene_patch(map->scene, &patch, &fault) != PEL_OK) {
        pel_warn("MBS-003", "own ship could not be stopped: %s", fault.message);
    }
}
