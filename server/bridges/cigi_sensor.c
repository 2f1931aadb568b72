#include "bridges/cigi_sensor.h"

#include <math.h>

#include "base/vec.h"
#include "bridges/cigi_pose.h"

#define TRACK_TARGET 3
#define TRACK_SHIP 4
#define EDGE 0.9 /* of the half picture; beyond it the lock may break */
#define TARGET_M 100.0
#define LEAST_GATE_PX 8.0

/* --- from the host -------------------------------------------------------- */

static struct pel_cigi_sensor *sensor_of(struct pel_cigi_world *world,
                                         unsigned view, unsigned id)
{
    struct pel_cigi_sensor *spare = NULL;
    for (size_t i = 0; i < PEL_CIGI_SENSORS; i++) {
        struct pel_cigi_sensor *s = &world->sensors[i];
        if (s->used && s->view == view && s->id == id) {
            return s;
        }
        spare = !s->used && !spare ? s : spare;
    }
    if (spare) {
        *spare =
            (struct pel_cigi_sensor){ .used = true, .view = view, .id = id };
    }
    return spare;
}

static void follow(struct pel_cigi_sensor *s, const struct pel_cigi_packet *p)
{
    unsigned track = (unsigned)pel_cigi_get(p, PEL_CIGI_SENSOR_TRACK);
    s->on = pel_cigi_get(p, PEL_CIGI_SENSOR_ON) != 0;
    s->extended = pel_cigi_get(p, PEL_CIGI_SENSOR_REPLY) != 0;
    if (track != s->track || !s->on) {
        s->has_target = false;
        s->lock = PEL_CIGI_SEARCHING;
    }
    s->track = track;
}

/* Of the ids that mean one; others show what the state says. */
static bool kind_of(unsigned id, Pelagos__SensorKind *kind)
{
    *kind = id == 2   ? PELAGOS__SENSOR_KIND__LOW_LIGHT
            : id == 3 ? PELAGOS__SENSOR_KIND__THERMAL
                      : PELAGOS__SENSOR_KIND__VISIBLE;
    return id >= 1 && id <= 3;
}

static void show(struct pel_cigi_edit *edit, Pelagos__View *view,
                 const struct pel_cigi_packet *p)
{
    Pelagos__Sensor *to = &edit->sensors[view - edit->views];
    pelagos__sensor__init(to);
    to->has_on = to->has_black_hot = to->has_auto_gain = true;
    to->has_gain = to->has_level = to->has_noise = to->has_dropout = true;
    to->on = true;
    to->has_kind =
        kind_of((unsigned)pel_cigi_get(p, PEL_CIGI_SENSOR_SENSOR), &to->kind);
    to->black_hot = pel_cigi_get(p, PEL_CIGI_SENSOR_POLARITY) != 0;
    to->auto_gain = pel_cigi_get(p, PEL_CIGI_SENSOR_AUTO_GAIN) != 0;
    to->dropout = pel_cigi_get(p, PEL_CIGI_SENSOR_DROPOUT) != 0;
    to->gain = pel_clamp(pel_cigi_get(p, PEL_CIGI_SENSOR_GAIN), 0, 1);
    to->level = pel_clamp(pel_cigi_get(p, PEL_CIGI_SENSOR_LEVEL), 0, 1);
    to->noise = pel_clamp(pel_cigi_get(p, PEL_CIGI_SENSOR_NOISE), 0, 1);
    view->sensor = to;
}

static void darken(struct pel_cigi_edit *edit, Pelagos__View *view)
{
    Pelagos__Sensor *to = &edit->sensors[view - edit->views];
    if (!view->sensor) {
        pelagos__sensor__init(to);
    }
    to->has_on = true;
    to->on = false;
    view->sensor = to;
}

/* The view shows the sensor that was switched on last; when that one is
 * switched off, nothing. */
void pel_cigi_take_sensor(struct pel_cigi_edit *edit,
                          const struct pel_cigi_packet *p)
{
    unsigned view_id = (unsigned)pel_cigi_get(p, PEL_CIGI_SENSOR_VIEW);
    unsigned id = (unsigned)pel_cigi_get(p, PEL_CIGI_SENSOR_SENSOR);
    struct pel_cigi_sensor *sensor = sensor_of(edit->world, view_id, id);
    struct pel_cigi_view_memo *memo =
        sensor ? pel_cigi_edit_memo(edit, view_id) : NULL;
    Pelagos__View *view = memo ? pel_cigi_edit_view(edit, view_id) : NULL;
    if (!view) {
        edit->skipped++;
        return;
    }
    follow(sensor, p);
    if (sensor->on) {
        memo->has_sensor = true;
        memo->sensor = id;
        show(edit, view, p);
    } else if (!memo->has_sensor || memo->sensor == id) {
        memo->has_sensor = true;
        memo->sensor = id;
        darken(edit, view);
    }
}

unsigned pel_cigi_sensors_on(const struct pel_cigi_world *world)
{
    unsigned on = 0;
    for (size_t i = 0; i < PEL_CIGI_SENSORS; i++) {
        on += world->sensors[i].used && world->sensors[i].on;
    }
    return on;
}

/* --- to the host ---------------------------------------------------------- */

/* Where an entity stands in a picture: right and up of the axis. */
struct sight {
    double x_rad, y_rad, range_m;
    double edge; /* 1: at the picture's edge */
    struct pel_vec3 at;
};

/* False: behind the camera, or outside the picture. */
static bool see(const struct pel_snapshot *s, const struct pel_camera *c,
                size_t index, double time_s, struct sight *out)
{
    struct pel_entity_state e;
    pel_snapshot_entity_at(s, index, time_s, &e);
    out->at = (struct pel_vec3){ e.east_m, e.north_m, e.altitude_m };
    struct pel_vec3 eye = { c->east_m, c->north_m, c->altitude_m };
    struct pel_vec3 to = pel_vec3_add(out->at, pel_vec3_scale(eye, -1));
    double ahead = -pel_vec3_dot(to, c->world_from_camera.z);
    if (ahead < 1) {
        return false;
    }
    double x = pel_vec3_dot(to, c->world_from_camera.x) / ahead;
    double y = pel_vec3_dot(to, c->world_from_camera.y) / ahead;
    /* From the middle of the picture to its edge, off-axis ones too. */
    double across =
        (2 * x - c->tan_left - c->tan_right) / (c->tan_right - c->tan_left);
    double upward =
        (2 * y - c->tan_bottom - c->tan_top) / (c->tan_top - c->tan_bottom);
    out->x_rad = atan(x);
    out->y_rad = atan(y);
    out->range_m = sqrt(pel_vec3_dot(to, to));
    out->edge = fmax(fabs(across), fabs(upward));
    return out->edge <= 1;
}

static void search(struct pel_cigi_sensor *sensor, const struct pel_snapshot *s,
                   const struct pel_camera *c, int carrier, double time_s)
{
    double nearest = INFINITY;
    for (size_t i = 0; i < s->entity_count; i++) {
        struct sight sight;
        if ((int)i == carrier || !see(s, c, i, time_s, &sight)) {
            continue;
        }
        double off = hypot(sight.x_rad, sight.y_rad);
        if (off < nearest) {
            nearest = off;
            sensor->has_target = true;
            sensor->target = s->entities[i].id;
        }
    }
}

static void track(struct pel_cigi_sensor *sensor, const struct pel_snapshot *s,
                  const struct pel_camera *c, int carrier, double time_s,
                  struct sight *out)
{
    bool targets = sensor->track == TRACK_TARGET || sensor->track == TRACK_SHIP;
    if (targets && !sensor->has_target) {
        search(sensor, s, c, carrier, time_s);
    }
    int index =
        sensor->has_target ? pel_cigi_find_entity(s, sensor->target) : -1;
    if (!sensor->has_target) {
        sensor->lock = PEL_CIGI_SEARCHING;
    } else if (sensor->lock == PEL_CIGI_LOST || index < 0 ||
               !see(s, c, (size_t)index, time_s, out)) {
        sensor->lock = PEL_CIGI_LOST; /* until it is switched anew */
    } else {
        sensor->lock = out->edge > EDGE ? PEL_CIGI_LOSING : PEL_CIGI_TRACKING;
    }
}

static double gate_px(double tan_low, double tan_high, double pixels,
                      double range_m)
{
    double size = TARGET_M / range_m / (tan_high - tan_low) * pixels;
    return round(pel_clamp(size, LEAST_GATE_PX, pixels));
}

/* Both packets, which share the fields up to the host frame. */
static struct pel_cigi_packet respond(const struct pel_cigi_sensor *sensor,
                                      const struct pel_snapshot *s,
                                      const struct pel_camera *c,
                                      const struct sight *sight,
                                      uint32_t host_frame)
{
    bool locked =
        sensor->lock == PEL_CIGI_TRACKING || sensor->lock == PEL_CIGI_LOSING;
    struct pel_cigi_packet p =
        pel_cigi_packet_of(sensor->extended ? PEL_CIGI_KIND_SENSOR_EXTENDED
                                            : PEL_CIGI_KIND_SENSOR_RESPONSE);
    double gate[4] = { 0 };
    if (locked) {
        gate[0] = gate_px(c->tan_left, c->tan_right, c->width, sight->range_m);
        gate[1] = gate_px(c->tan_bottom, c->tan_top, c->height, sight->range_m);
        gate[2] = sight->x_rad / PEL_DEG;
        gate[3] = sight->y_rad / PEL_DEG;
    }
    if (!sensor->extended) {
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_VIEW, sensor->view);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_SENSOR, sensor->id);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_STATUS, sensor->lock);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_GATE_WIDTH, gate[0]);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_GATE_HEIGHT, gate[1]);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_GATE_X, gate[2]);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_GATE_Y, gate[3]);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_RESPONSE_HOST_FRAME, host_frame);
        return p;
    }
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_VIEW, sensor->view);
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_SENSOR, sensor->id);
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_STATUS, sensor->lock);
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_GATE_WIDTH, gate[0]);
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_GATE_HEIGHT, gate[1]);
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_GATE_X, gate[2]);
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_GATE_Y, gate[3]);
    pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_HOST_FRAME, host_frame);
    if (locked) {
        double latitude, longitude;
        pel_cigi_geodetic(s, sight->at, &latitude, &longitude);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_ENTITY_VALID, 1);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_ENTITY, sensor->target);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_LATITUDE, latitude);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_LONGITUDE, longitude);
        pel_cigi_set(&p, PEL_CIGI_SENSOR_EXTENDED_ALTITUDE, sight->at.z);
    }
    return p;
}

size_t pel_cigi_sensor_answers(struct pel_cigi_world *world,
                               const struct pel_snapshot *s, double time_s,
                               uint32_t host_frame, pel_cigi_emit emit,
                               void *user)
{
    size_t answers = 0;
    for (size_t i = 0; i < PEL_CIGI_SENSORS; i++) {
        struct pel_cigi_sensor *sensor = &world->sensors[i];
        char name[PEL_NAME_SIZE];
        if (!sensor->used || !sensor->on || sensor->track == 0) {
            continue;
        }
        pel_cigi_view_name(s, sensor->view, name);
        int view = pel_snapshot_find_view(s, name);
        if (view < 0) {
            continue;
        }
        struct pel_camera camera;
        struct sight sight = { 0 };
        pel_snapshot_camera(s, (size_t)view, time_s, 0, 0, &camera);
        track(sensor, s, &camera, s->views[view].entity, time_s, &sight);
        struct pel_cigi_packet p =
            respond(sensor, s, &camera, &sight, host_frame);
        answers += emit(user, &p);
    }
    return answers;
}
