/* Seas, cameras and environments of the benchmark and of still pictures. */
#pragma once

#include "ocean/sea.h"
#include "render/renderer.h"

/* Angles in degrees, headings clockwise from north, wind where it blows from.
 */
struct bench_scene {
    double wind_mps, wind_from, swell_m;
    double sun_elevation, sun_azimuth, visibility_m, chlorophyll;
    double height_m, east_m, north_m, heading, pitch, roll, fov;
    uint32_t width, height, seed;
    int waves;
    int kind; /* enum pel_spectrum_kind */
    bool fft; /* the sea from FFT cascades instead of trochoids */
    double time_s;
    double ev; /* over 90: automatic */
    double glare;
    int vision; /* PEL_VISION_* */
    bool linear, aliased;
    double whitecaps;
    double rain_mm_h, snow_mm_h;
    double shutter_s, wet_lens;
    double slick; /* factor of an area 100 m ahead; 1: none */
};

/* The peers' scene: 60 waves, 6 m above the sea, level, 1024 × 768. */
extern const struct bench_scene bench_default;

PEL_CHECK enum pel_err bench_sea(const struct bench_scene *s,
                                 struct pel_sea *out);
struct pel_environment bench_environment(const struct bench_scene *s,
                                         const struct pel_sea *sea);
struct pel_camera bench_camera(const struct bench_scene *s);
