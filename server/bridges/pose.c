#include "bridges/pose.h"

#include "scene/scene.h"

bool pel_bridge_reckon(struct pel_scene *scene, uint32_t id,
                       Pelagos__Entity *out)
{
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    bool found = false;
    out->has_pose_time = 1;
    out->pose_time = pel_scene_time(scene);
    for (size_t i = 0; i < s->entity_count && !found; i++) {
        if (s->entities[i].id != id) {
            continue;
        }
        struct pel_entity_state e;
        pel_snapshot_entity_at(s, i, out->pose_time, &e);
        pel_geo_from_local(s->origin_latitude_rad / PEL_DEG,
                           s->origin_longitude_rad / PEL_DEG, e.east_m,
                           e.north_m, &out->latitude, &out->longitude);
        double deg = fmod(e.heading_rad / PEL_DEG, 360);
        out->heading = deg < 0 ? deg + 360 : deg;
        out->has_latitude = out->has_longitude = out->has_heading = 1;
        found = true;
    }
    pel_snapshot_unref(s);
    return found;
}
