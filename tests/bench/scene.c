#include "tests/bench/scene.h"

const struct bench_scene bench_default = {
    .wind_mps = 8.0,
    .wind_from = 270.0,
    .sun_elevation = 30.0,
    .visibility_m = 40000.0,
    .chlorophyll = 0.2,
    .height_m = 6.0,
    .fov = 60.0,
    .width = 1024,
    .height = 768,
    .seed = 1,
    .waves = 60,
    .time_s = 10.0,
    .ev = 99.0,
    .glare = 0.01,
    .slick = 1.0,
};

static double wind_to(const struct bench_scene *s)
{
    return (90.0 - s->wind_from + 180.0) * PEL_DEG;
}

enum pel_err bench_sea(const struct bench_scene *s, struct pel_sea *out)
{
    struct pel_sea_desc desc = {
        .kind = (enum pel_spectrum_kind)s->kind,
        .wind_mps = s->wind_mps,
        .direction_rad = wind_to(s),
        .fetch_m = s->kind ? 2000000.0 : 200000.0,
        .gamma = 3.3,
        .seed = s->seed,
        .synthesiser = s->fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS,
        .wave_count = s->waves,
        .whitecaps = s->whitecaps,
        .rain_mm_h = s->rain_mm_h,
        .swell_count = s->swell_m > 0.0,
        .swell = { { s->swell_m, 12.0, wind_to(s) + 0.6, 0.15 } },
    };
    desc.area_count = s->slick != 1.0;
    desc.area[0] = (struct pel_area_desc){
        .north_m = 100.0, .radius_m = 60.0, .edge_m = 20.0, .factor = s->slick
    };
    return pel_sea_build(&desc, out);
}

struct pel_environment bench_environment(const struct bench_scene *s,
                                         const struct pel_sea *sea)
{
    double e = s->sun_elevation * PEL_DEG, a = s->sun_azimuth * PEL_DEG;
    struct pel_water_body water = pel_water_deep(s->chlorophyll);
    return (struct pel_environment){
        .time_s = s->time_s,
        .sea = sea,
        .lights = { { { cos(e) * sin(a), cos(e) * cos(a), sin(e) }, 1.0 } },
        .wind_mps = s->wind_mps,
        .wind_to_rad = wind_to(s),
        .visibility_m = s->visibility_m,
        .rain_mm_h = s->rain_mm_h,
        .snow_mm_h = s->snow_mm_h,
        .water = water,
    };
}

/* As server/scene/snapshot.c, which would bring GLib with it. */
struct pel_camera bench_camera(const struct bench_scene *s)
{
    double yaw = s->heading * PEL_DEG, pitch = s->pitch * PEL_DEG;
    double roll = s->roll * PEL_DEG;
    double tan_x = tan(0.5 * s->fov * PEL_DEG);
    double tan_y = tan_x * s->height / s->width;
    const struct pel_vec3 forward = { sin(yaw) * cos(pitch),
                                      cos(yaw) * cos(pitch), sin(pitch) };
    const struct pel_vec3 right = { cos(yaw), -sin(yaw), 0.0 };
    struct pel_vec3 up = pel_vec3_cross(right, forward);
    return (struct pel_camera){
        .east_m = s->east_m,
        .north_m = s->north_m,
        .altitude_m = s->height_m,
        .world_from_camera = { pel_vec3_add(pel_vec3_scale(right, cos(roll)),
                                            pel_vec3_scale(up, -sin(roll))),
                               pel_vec3_add(pel_vec3_scale(up, cos(roll)),
                                            pel_vec3_scale(right, sin(roll))),
                               pel_vec3_scale(forward, -1.0) },
        .tan_left = -tan_x,
        .tan_right = tan_x,
        .tan_top = tan_y,
        .tan_bottom = -tan_y,
        .width = s->width,
        .height = s->height,
        .auto_exposure = s->ev > 90.0,
        .exposure_ev = s->ev,
        .tone = s->linear ? PEL_TONE_LINEAR : PEL_TONE_FILMIC,
        .glare = s->glare,
        .vision = s->vision,
        .antialiasing = !s->aliased,
        .shutter_s = s->shutter_s,
        .wet_lens = s->wet_lens,
    };
}
