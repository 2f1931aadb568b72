/* The cameras of a snapshot's views. */
#include <math.h>
#include <string.h>

#include "scene/place.h"
#include "scene/snapshot.h"

static void size_camera(const struct pel_view_state *view, uint32_t width,
                        uint32_t height, struct pel_camera *out)
{
    out->width = width > 0 ? width : view->width;
    out->height = height > 0 ? height : view->height;
    double stretch = ((double)out->height * view->width) /
                     ((double)out->width * view->height);
    out->tan_left = view->tan_left;
    out->tan_right = view->tan_right;
    out->tan_top = view->tan_top * stretch;
    out->tan_bottom = view->tan_bottom * stretch;
}

static void place_camera(const struct pel_snapshot *s, size_t index,
                         double time_s, bool in_wakes, struct pel_camera *out)
{
    const struct pel_view_state *view = &s->views[index];
    struct pel_stance at;
    pel_view_stance(s, index, time_s, in_wakes, &at);
    struct pel_mat3 from_view =
        pel_attitude(view->yaw_rad, view->pitch_rad, view->roll_rad);
    out->east_m = at.east_m;
    out->north_m = at.north_m;
    out->altitude_m = at.altitude_m;
    out->velocity_mps = at.velocity_mps;
    struct pel_vec3 forward = pel_mat3_apply(&at.axes, from_view.y);
    out->world_from_camera = (struct pel_mat3){
        pel_mat3_apply(&at.axes, from_view.x),
        pel_mat3_apply(&at.axes, from_view.z),
        pel_vec3_scale(forward, -1),
    };
}

struct pel_place pel_snapshot_view_square(const struct pel_snapshot *s,
                                          size_t index, double time_s,
                                          const struct pel_camera *camera)
{
    const struct pel_view_state *view = &s->views[index];
    double east = camera->east_m, north = camera->north_m;
    if (view->place.stand == PEL_STAND_CARRIED &&
        hypot(view->forward_m, view->right_m) <= PEL_PLACE_ARM_M) {
        struct pel_entity_state e = { 0 };
        if (view->entity >= 0) {
            pel_snapshot_entity_level(s, (size_t)view->entity, time_s, &e);
        }
        east = e.east_m;
        north = e.north_m;
    }
    return pel_place_square(east, north);
}

/* The windows of a view's meter that have its light, which is another where
 * they stand in another place; none where it has none. */
static void place_sights(const struct pel_snapshot *s, size_t index,
                         double time_s, bool in_wakes, struct pel_camera *out)
{
    const char *meter = s->views[index].meter;
    out->sight_count = 0;
    if (!meter[0]) {
        return;
    }
    struct pel_place place = pel_snapshot_view_square(s, index, time_s, out);
    for (size_t i = 0; i < s->view_count; i++) {
        struct pel_camera c;
        if (out->sight_count == PEL_METER_SIGHTS ||
            strcmp(s->views[i].meter, meter) != 0) {
            continue;
        }
        c.lens = s->views[i].lens;
        place_camera(s, i, time_s, in_wakes, &c);
        struct pel_place other = pel_snapshot_view_square(s, i, time_s, &c);
        if (pel_place_same(&place, &other)) {
            out->sights[out->sight_count++] =
                (struct pel_sight){ c.world_from_camera, c.altitude_m,
                                    c.tan_left,          c.tan_right,
                                    c.tan_top,           c.tan_bottom };
        }
    }
}

void pel_snapshot_camera(const struct pel_snapshot *s, size_t index,
                         double time_s, uint32_t width, uint32_t height,
                         struct pel_camera *out)
{
    const struct pel_view_state *view = &s->views[index];
    out->lens = view->lens;
    place_camera(s, index, time_s, false, out);
    size_camera(view, width, height, out);
    place_sights(s, index, time_s, false, out);
    uint64_t bits;
    memcpy(&bits, &time_s, sizeof bits);
    bits *= UINT64_C(0x9e3779b97f4a7c15); /* 2^64 / golden ratio: spreads */
    out->sensor.seed = (uint32_t)(bits >> 32);
}

void pel_snapshot_camera_in_wakes(const struct pel_snapshot *s, size_t index,
                                  double time_s, struct pel_camera *camera)
{
    if (s->wakes) {
        place_camera(s, index, time_s, true, camera);
        place_sights(s, index, time_s, true, camera);
    }
}
