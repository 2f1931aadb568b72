#include "bridges/cigi_pose.h"

#include "scene/geodesy.h"

struct pel_mat3 pel_cigi_axes(double heading_rad, double pitch_rad,
                              double roll_rad)
{
    double sh = sin(heading_rad), ch = cos(heading_rad);
    double sp = sin(pitch_rad), cp = cos(pitch_rad);
    double sr = sin(roll_rad), cr = cos(roll_rad);
    struct pel_vec3 forward = { sh * cp, ch * cp, sp };
    struct pel_vec3 level = { ch, -sh, 0 };
    struct pel_vec3 down = { sh * sp, ch * sp, -cp };
    return (struct pel_mat3){
        forward,
        pel_vec3_add(pel_vec3_scale(level, cr), pel_vec3_scale(down, sr)),
        pel_vec3_add(pel_vec3_scale(down, cr), pel_vec3_scale(level, -sr)),
    };
}

void pel_cigi_angles(const struct pel_mat3 *axes, double *heading_rad,
                     double *pitch_rad, double *roll_rad)
{
    struct pel_vec3 forward = axes->x;
    *heading_rad = atan2(forward.x, forward.y);
    *pitch_rad = asin(pel_clamp(forward.z, -1, 1));
    struct pel_mat3 unrolled = pel_cigi_axes(*heading_rad, *pitch_rad, 0);
    *roll_rad = atan2(pel_vec3_dot(axes->y, unrolled.z),
                      pel_vec3_dot(axes->y, unrolled.y));
}

int pel_cigi_find_entity(const struct pel_snapshot *s, uint32_t id)
{
    for (size_t i = 0; i < s->entity_count; i++) {
        if (s->entities[i].id == id) {
            return (int)i;
        }
    }
    return -1;
}

bool pel_cigi_entity_axes(const struct pel_snapshot *s, uint32_t id,
                          double time_s, struct pel_vec3 *at,
                          struct pel_mat3 *axes)
{
    int index = pel_cigi_find_entity(s, id);
    if (index < 0) {
        return false;
    }
    struct pel_entity_state e;
    pel_snapshot_entity_at(s, (size_t)index, time_s, &e);
    *at = (struct pel_vec3){ e.east_m, e.north_m, e.altitude_m };
    *axes = pel_cigi_axes(e.heading_rad, e.pitch_rad, e.roll_rad);
    return true;
}

bool pel_cigi_place(const struct pel_snapshot *s, double time_s, bool local,
                    uint32_t entity, const double abc[3], struct pel_vec3 *out)
{
    if (!local) {
        pel_geo_to_local(s->origin_latitude_rad / PEL_DEG,
                         s->origin_longitude_rad / PEL_DEG,
                         pel_clamp(abc[0], -90, 90), remainder(abc[1], 360),
                         &out->x, &out->y);
        out->z = abc[2];
        return true;
    }
    struct pel_mat3 axes;
    if (!pel_cigi_entity_axes(s, entity, time_s, out, &axes)) {
        return false;
    }
    struct pel_vec3 offset = { abc[0], abc[1], abc[2] };
    *out = pel_vec3_add(*out, pel_mat3_apply(&axes, offset));
    return true;
}

void pel_cigi_geodetic(const struct pel_snapshot *s, struct pel_vec3 at,
                       double *latitude, double *longitude)
{
    pel_geo_from_local(s->origin_latitude_rad / PEL_DEG,
                       s->origin_longitude_rad / PEL_DEG, at.x, at.y, latitude,
                       longitude);
}

double pel_cigi_true_deg(const struct pel_snapshot *s, struct pel_vec3 at,
                         double heading_rad)
{
    double latitude, longitude;
    pel_cigi_geodetic(s, at, &latitude, &longitude);
    double turned = pel_geo_convergence(s->origin_latitude_rad / PEL_DEG,
                                        s->origin_longitude_rad / PEL_DEG,
                                        latitude, longitude);
    return pel_cigi_wrap((heading_rad - turned) / PEL_DEG);
}

double pel_cigi_wrap(double degrees)
{
    double turned = fmod(degrees, 360.0);
    turned = turned < 0 ? turned + 360.0 : turned;
    return turned < 360.0 ? turned : 0;
}
