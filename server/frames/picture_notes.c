#include "frames/picture_notes.h"

#include <math.h>

void pel_camera_attitude(const struct pel_job *job, size_t draw,
                         double *heading_deg, double *pitch_deg,
                         double *roll_deg)
{
    const struct pel_camera *camera = &job->draws[draw].camera;
    struct pel_vec3 ahead = pel_vec3_scale(camera->world_from_camera.z, -1);
    struct pel_vec3 right = camera->world_from_camera.x;
    double heading = atan2(ahead.x, ahead.y);
    double level = hypot(ahead.x, ahead.y);
    if (level < 1e-9) { /* straight up or down: what is right decides */
        heading = atan2(-right.y, right.x);
    }
    double c = cos(heading), s = sin(heading);
    struct pel_vec3 level_right = { c, -s, 0 };
    struct pel_vec3 level_up = { -s * ahead.z, -c * ahead.z, level };
    *heading_deg =
        pel_bearing_deg((heading - pel_job_turned(job, draw)) / PEL_DEG, 2);
    *pitch_deg = atan2(ahead.z, level) / PEL_DEG;
    *roll_deg = atan2(-pel_vec3_dot(right, level_up),
                      pel_vec3_dot(right, level_right)) /
                PEL_DEG;
}

bool pel_camera_in_ground(const struct pel_job *job, size_t draw)
{
    const struct pel_camera *c = &job->draws[draw].camera;
    const struct pel_seabed *bed = job->snapshot->seabed;
    double height_m;
    return bed && pel_seabed_height(bed, c->east_m, c->north_m, &height_m) &&
           c->altitude_m < height_m;
}

double pel_camera_field(double tan_low, double tan_high)
{
    return (atan(tan_high) - atan(tan_low)) / PEL_DEG;
}

void pel_picture_photo(const struct pel_output *output, struct pel_photo *out)
{
    const struct pel_job *job = output->job;
    const struct pel_job_draw *part = &job->parts[output->draw];
    const struct pel_camera *c = &job->draws[output->draw].camera;
    const struct pel_snapshot *s = job->snapshot;
    *out = (struct pel_photo){
        .software = "pelagosd " PEL_VERSION,
        .view = s->views[part->view].name,
        .unix_s = s->epoch_unix_s + job->environment.time_s,
        .time_s = job->environment.time_s,
        .altitude_m = c->altitude_m,
        .horizontal_fov_deg = pel_camera_field(c->tan_left, c->tan_right),
        .vertical_fov_deg = pel_camera_field(c->tan_bottom, c->tan_top),
        .exposure_ev = part->picture->exposure_ev,
        .in_ground = pel_camera_in_ground(job, output->draw),
        .width = part->width,
        .height = part->height,
    };
    pel_geo_from_local(s->origin_latitude_rad / PEL_DEG,
                       s->origin_longitude_rad / PEL_DEG, c->east_m, c->north_m,
                       &out->latitude_deg, &out->longitude_deg);
    pel_camera_attitude(job, output->draw, &out->heading_deg, &out->pitch_deg,
                        &out->roll_deg);
}
