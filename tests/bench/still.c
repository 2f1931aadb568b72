/* Draws one picture of a sea straight from the renderer and times it:
 *   still OUT.png [name=value …]
 * (moon: its elevation, lit: its share; night: UTC of its stars, seconds from
 * 1970, seen from 0° E and `lat`; kind: of the spectrum, enum
 * pel_spectrum_kind; bed: 1 a beach ahead, 2 deep everywhere; paper: 1 its sky
 * and glitter as they stand; ship: a built-in model by its number, `away`
 * metres ahead; rain, snow: mm/h; wash: its speed, m/s, and `push` the screw's;
 * it passed on a straight course, `washes` ships side by side; fleet: enum
 * bench_fleet; wakes: of so many ships, the first `away` ahead; motes:
 * particles/m3; sense: 1 low light, 2 thermal; lat, lon: the origin, land:
 * continents there; high: the form of what is seen from high up, 1 always, -1
 * never) for looking at one thing at a time while developing shaders. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/clock.h"
#include "encode/encode.h"
#include "models/builtin.h"
#include "models/waterline.h"
#include "ocean/wash.h"
#include "optics/moon.h"
#include "optics/rain.h"
#include "render/renderer.h"
#include "scene/ephemeris.h"
#include "tests/bench/fleet.h"
#include "tests/bench/scene.h"

struct setting {
    const char *name;
    double value;
};

static struct setting settings[] = {
    { "wind", 8 },
    { "winddir", 270 },
    { "sun", 30 },
    { "sunaz", 0 },
    { "height", 6 },
    { "pitch", -4 },
    { "yaw", 0 },
    { "fov", 60 },
    { "width", 1024 },
    { "height_px", 768 },
    { "time", 10 },
    { "vis", 40000 },
    { "ev", 99 },
    { "frames", 1 },
    { "seed", 1 },
    { "waves", 60 },
    { "fft", 0 },
    { "stages", 0 },
    { "planes", 0 },
    { "piped", 0 },
    { "chl", 0.2 },
    { "hardware", 0 },
    { "roll", 0 },
    { "swell", 0 },
    { "compute", -1 },
    { "layers", 0 },
    { "nmin", 0 },
    { "nmax", 0 },
    { "cell", 0 },
    { "paper", 0 },
    { "x", 0 },
    { "y", 0 },
    { "bed", 0 },
    { "caustics", 1 },
    { "glare", 0.01 },
    { "linear", 0 },
    { "sparkle", 1 },
    { "ship", 0 },
    { "away", 220 },
    { "aa", 1 },
    { "bearing", 0 },
    { "turned", 60 },
    { "foam", 1 },
    { "kind", 0 },
    { "slick", 1 },
    { "fleet", 0 },
    { "wash", 0 },
    { "push", 99 },
    { "moon", -90 },
    { "moonaz", 0 },
    { "lit", 1 },
    { "night", 0 },
    { "lat", 30 },
    { "sense", 0 },
    { "span", 0 },
    { "phosphor", 0 },
    { "air", 15 },
    { "gain", 1 },
    { "wakes", 0 },
    { "lit", 1 },
    { "okta", 0 },
    { "genus", 0 },
    { "eye", 0 },
    { "fog", 0 },
    { "fogbase", 0 },
    { "fogtop", 80 },
    { "fogsoft", 20 },
    { "bank", 0 },
    { "bankaway", 1500 },
    { "banktop", 60 },
    { "bankradius", 800 },
    { "bankbearing", 0 },
    { "rain", 0 },
    { "snow", 0 },
    { "bare", 0 },
    { "kind_only", 0 },
    { "dry", 0 },
    { "shutter", 0 },
    { "wet", 0 },
    { "lamps", 0 },
    { "motes", 0 },
    { "washes", 1 },
    { "lon", 0 },
    { "land", 0 },
    { "high", 0 },
};

static double get(const char *name)
{
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        if (strcmp(settings[i].name, name) == 0) {
            return settings[i].value;
        }
    }
    fprintf(stderr, "no setting %s\n", name);
    exit(2);
}

static void parse(int argc, char **argv)
{
    for (int a = 2; a < argc; a++) {
        char *equal = strchr(argv[a], '=');
        size_t i = 0, n = sizeof settings / sizeof *settings;
        while (equal && i < n &&
               (strncmp(argv[a], settings[i].name, (size_t)(equal - argv[a])) ||
                settings[i].name[equal - argv[a]])) {
            i++;
        }
        if (!equal || i == n) {
            fprintf(stderr, "unknown setting %s\n", argv[a]);
            exit(2);
        }
        settings[i].value = atof(equal + 1);
    }
}

static struct bench_scene scene(void)
{
    return (struct bench_scene){
        .wind_mps = get("wind"),
        .wind_from = get("winddir"),
        .swell_m = get("swell"),
        .sun_elevation = get("sun"),
        .sun_azimuth = get("sunaz"),
        .visibility_m =
            pel_visibility_in_rain(get("vis"), get("rain"), get("snow")),
        .chlorophyll = get("chl"),
        .height_m = get("height"),
        .east_m = get("x"),
        .north_m = get("y"),
        .heading = get("yaw"),
        .pitch = get("pitch"),
        .roll = get("roll"),
        .fov = get("fov"),
        .width = (uint32_t)get("width"),
        .height = (uint32_t)get("height_px"),
        .seed = (uint32_t)get("seed"),
        .waves = (int)get("waves"),
        .fft = get("fft") > 0,
        .kind = (int)get("kind"),
        .time_s = get("time"),
        .ev = get("ev"),
        .glare = get("glare"),
        .vision = (int)get("eye"),
        .linear = get("linear") > 0,
        .aliased = get("aa") <= 0,
        .whitecaps = get("foam"),
        .rain_mm_h = get("rain"),
        .snow_mm_h = get("snow"),
        .shutter_s = get("shutter"),
        .wet_lens = get("wet"),
        .slick = get("slick"),
    };
}

/* Ships' lights and marks about a roadstead: as many from 150 m to 6 km ahead,
 * white, red, green. */
static size_t roadstead(int count, struct pel_lamp *out)
{
    static const double colours[3][3] = { { 1.0, 1.0, 0.9 },
                                          { 4.4, 0.05, 0.02 },
                                          { 0.05, 1.35, 0.3 } };
    for (int i = 0; i < count; i++) {
        double part = (i + 0.5) / count;
        double away = 150 * pow(40, part), turn = remainder(i * 0.618034, 1);
        double height = 3 + 22 * fmod(i * 0.7548777, 1);
        out[i] = (struct pel_lamp){
            .entity = PEL_NO_ENTITY,
            .east_m = away * sin(turn),
            .north_m = away * cos(turn),
            .altitude_m = height,
            .ahead = { 0, -1, 0 },
            .up = { 0, 0, 1 },
            .arc_rad = 7,
            .spread_rad = 0.13,
            .size_m = 0.2,
        };
        for (int k = 0; k < 3; k++) {
            out[i].intensity_cd[k] =
                (i % 3 ? 12 : 94) * colours[i % 3 ? 1 + i % 2 : 0][k];
        }
    }
    return (size_t)count;
}

/* bed=1: a beach 100 m ahead in the north; bed=2: 400 m everywhere. */
static const struct pel_seabed *bottom(void)
{
    enum { SIDE = 512 };
    static float heights[SIDE * SIDE];
    const double spacing = 2, first = -0.5 * SIDE * spacing;
    const struct pel_seabed *bed = NULL;
    for (int i = 0; i < SIDE * SIDE; i++) {
        double north = first + spacing * (i / SIDE);
        double beach = fmin(fmax(0.05 * (north - 100), -40), 6);
        heights[i] = (float)(get("bed") > 1 ? -400 : beach);
    }
    if (get("bed") <= 0 || pel_seabed_create(SIDE, SIDE, first, first, spacing,
                                             heights, &bed, NULL)) {
        return NULL;
    }
    return bed;
}

/* The ship-th of the built-in models, so far away, heading `turned`. */
static struct pel_object ship(const struct bench_scene *shown,
                              const struct pel_sea *sea, double time_s)
{
    size_t count, which = (size_t)get("ship") - 1;
    const struct pel_builtin_kind *kinds = pel_builtin_kinds(&count);
    const struct pel_builtin what = {
        .name = kinds[which < count ? which : count - 1].name
    };
    double b = get("bearing") * PEL_DEG, h = get("turned") * PEL_DEG;
    struct pel_object o = {
        .id = 1,
        .east_m = shown->east_m + get("away") * sin(b),
        .north_m = shown->north_m + get("away") * cos(b),
        .world_from_model = { { sin(h), cos(h), 0 },
                              { -cos(h), sin(h), 0 },
                              { 0, 0, 1 } },
    };
    struct pel_surface_sample at;
    pel_sea_sample(sea, o.east_m, o.north_m, time_s, &at);
    struct pel_fault fault;
    if (pel_builtin_make(&what, &o.model, &fault) != PEL_OK ||
        pel_model_shade(o.model, &fault) != PEL_OK) {
        fprintf(stderr, "%s\n", fault.message);
    } else if (o.model->length_m < 30) {
        o.altitude_m = at.height_m; /* a long one lies across the waves */
    }
    return o;
}

/* Of the ship there, which came straight for ten minutes. */
static struct pel_wash *wash_of(const struct pel_object *o, double time_s)
{
    const struct pel_model *m = o->model;
    double h = get("turned") * PEL_DEG, u = get("wash");
    double push = get("push") < 90 ? get("push") : NAN;
    struct pel_wash_ship s = { m->length_m, m->beam_m, m->draught_m,
                               .count = 2 };
    struct pel_model_waterline line;
    pel_wash_waterline(&s);
    if (pel_model_waterline(m, &line)) {
        s.stem_m = line.stem_m;
        s.stern_m = line.stern_m;
        memcpy(s.half_m, line.half_m, sizeof s.half_m);
    }
    for (int i = 0; i < 2; i++) {
        double ago = 900.0 * (1 - i);
        s.point[i] =
            (struct pel_wash_point){ time_s - ago, o->east_m - ago * u * sin(h),
                                     o->north_m - ago * u * cos(h), h, push };
    }
    struct pel_wash *w;
    if (pel_wash_create(&w)) {
        abort();
    }
    for (int n = 0; n < (int)get("washes"); n++) {
        if (pel_wash_add(w, &s, time_s)) {
            abort();
        }
        for (int i = 0; i < 2; i++) { /* the next, abeam of it */
            s.point[i].x_m += 1.5 * m->length_m * cos(h);
            s.point[i].y_m -= 1.5 * m->length_m * sin(h);
        }
    }
    if (pel_wash_index(w)) {
        abort();
    }
    return w;
}

/* fog: the visibility in a layer, bank: in a bank ahead. */
static void fogs(struct pel_environment *env)
{
    if (get("fog") > 0) {
        env->fog[env->fog_count++] =
            (struct pel_fog){ pel_fog_extinction(get("fog")), get("fogbase"),
                              get("fogtop"), get("fogsoft"), .radius_m = 0 };
    }
    if (get("bank") > 0) {
        double b = get("bankbearing") * PEL_DEG;
        env->fog[env->fog_count++] =
            (struct pel_fog){ pel_fog_extinction(get("bank")),
                              0,
                              get("banktop"),
                              0,
                              get("bankradius"),
                              get("bankaway") * sin(b),
                              get("bankaway") * cos(b),
                              0,
                              0 };
    }
}

static double processor_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

/* As many more frames with two others under way: the time that each takes. */
static bool piped(struct pel_renderer *r, struct pel_environment *env,
                  const struct pel_draw *draw)
{
    const int frames = (int)get("piped");
    int64_t start = 0;
    for (int i = -10; i < frames; i++) {
        if (i == 0) {
            start = pel_now_ns();
        }
        env->time_s = get("time") + i / 30.0;
        if (pel_renderer_submit(r, env, draw, 1) != PEL_OK) {
            return false;
        }
        if (i >= -8) {
            pel_picture_release(pel_renderer_collect(r, 10000000000));
        }
    }
    printf("piped: %.4f ms a frame\n",
           (double)(pel_now_ns() - start) * 1e-6 / frames);
    while (pel_renderer_in_flight(r) > 0) {
        pel_picture_release(pel_renderer_collect(r, 10000000000));
    }
    return true;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        fprintf(stderr, "usage: still OUT.png [name=value …]\n");
        return 2;
    }
    parse(argc, argv);
    struct pel_fault fault = { 0 };
    struct pel_renderer *r;
    const struct pel_renderer_options options = {
        .device = get("hardware") > 0 ? "auto" : "software",
        .debug = true,
        .shader_dir = getenv("PELAGOS_SHADER_DIR"),
        .filtering = { .n_min = get("nmin"),
                       .n_max = get("nmax"),
                       .cell_px = get("cell"),
                       .paper = get("paper") > 0 },
        .shading = get("compute") < 0   ? "auto"
                   : get("compute") > 0 ? "compute"
                                        : "fragment"
    };
    if (pel_renderer_create(&options, &r, &fault) != PEL_OK) {
        fprintf(stderr, "%s\n", fault.message);
        return 1;
    }
    printf("%s device: %s\n",
           pel_renderer_is_software(r) ? "software" : "hardware",
           pel_renderer_description(r));
    static struct pel_sea sea;
    const struct bench_scene shown = scene();
    if (bench_sea(&shown, &sea) != PEL_OK) {
        return 1;
    }
    struct pel_environment env = bench_environment(&shown, &sea);
    env.seabed = bottom();
    env.caustics = get("caustics") > 0;
    env.motes = (struct pel_mote_water){ get("motes"), 4.0, 8e-3 };
    env.sparkle = get("sparkle") > 0;
    env.origin_latitude_rad = get("lat") * PEL_DEG;
    env.origin_longitude_rad = get("lon") * PEL_DEG;
    env.continents = get("land") > 0;
    env.high = (int)get("high");
    if (get("bed") > 0) {
        const struct pel_water_desc water = { .kind = PEL_WATER_NAMED,
                                              .name = PEL_WATER_TROPICAL,
                                              .depth_m = 400,
                                              .bottom = PEL_BOTTOM_SAND };
        if (pel_water_resolve(&water, &env.water, &fault)) {
            return 1;
        }
    }
    if (get("okta") > 0) {
        if (!(get("genus") >= 0 && get("genus") < PEL_CLOUD_GENERA)) {
            fprintf(stderr, "genus: 0 .. %d, as in clouds.def\n",
                    PEL_CLOUD_GENERA - 1);
            return 2;
        }
        enum pel_cloud_genus genus = (enum pel_cloud_genus)get("genus");
        const struct pel_cloud_kind *kind = pel_cloud_kind(genus);
        env.clouds = (struct pel_clouds){ .cover = get("okta") / 8,
                                          .genus = genus,
                                          .base_m = kind->base_m,
                                          .thickness_m = kind->thickness_m,
                                          .east_mps = 10,
                                          .seed = (uint32_t)get("seed") };
    }
    fogs(&env);
    env.fall_bare = get("bare") > 0;
    env.fall_only = (int)get("kind_only");
    if (get("dry") > 0) {
        env.rain_mm_h = env.snow_mm_h = 0;
    }
    if (get("moon") > -90) {
        double e = get("moon") * PEL_DEG, a = get("moonaz") * PEL_DEG;
        env.lights[PEL_LIGHT_MOON] = pel_light_moon(
            (struct pel_vec3){ cos(e) * sin(a), cos(e) * cos(a), sin(e) },
            env.lights[PEL_LIGHT_SUN].direction, get("lit"), PEL_MOON_DISTANCE);
    }
    if (get("night") != 0) {
        pel_ephemeris_night(get("night"), get("lat") * PEL_DEG, 0.0,
                            &env.night);
        env.night.on = true;
        env.night.stars = 1.0;
    }
    struct pel_object object;
    if (get("ship") > 0) {
        object = ship(&shown, &sea, env.time_s);
        env.objects = &object;
        env.object_count = object.model != NULL;
        if (object.model && (get("wash") != 0 || get("push") < 90)) {
            env.wash = wash_of(&object, env.time_s);
        }
    }
    if (get("fleet") > 0 &&
        !bench_fleet_set((enum bench_fleet)get("fleet"), &env)) {
        return 1;
    }
    if (get("wakes") > 0 &&
        !bench_fleet_wakes((int)get("wakes"), get("away"), &env)) {
        return 1;
    }
    static struct pel_lamp lamps[PEL_MAX_LAMPS];
    env.lamps = lamps;
    env.lamp_count = roadstead((int)fmin(get("lamps"), PEL_MAX_LAMPS), lamps);
    struct pel_draw draw = { .camera = bench_camera(&shown),
                             .layers = get("layers") > 0
                                           ? PEL_LAYER_COLOR | PEL_LAYER_DEPTH |
                                                 PEL_LAYER_NORMAL
                                           : PEL_LAYER_COLOR };
    draw.ycbcr = get("planes") > 0 ? PEL_YCBCR_JPEG : PEL_YCBCR_NONE;
    if (get("sense") > 0) {
        draw.camera.sensor = (struct pel_sensor){
            .kind = PEL_SENSOR_ON,
            .scale = get("gain"),
            .sense = (enum pel_sense)get("sense"),
            .seed = 0x12345678,
            .exposure_s = 0.033,
            .f_number = 1.4,
            .phosphor = (int)get("phosphor"),
            .span_k = get("span"),
            .low_k = 288.15 - 0.5 * get("span"),
            .netd_k = 0.05,
            .sea_k = 288.15,
            .air_k = 273.15 + get("air"),
            .humidity = 0.75,
        };
    }
    if (get("piped") > 0 && !piped(r, &env, &draw)) {
        return 1;
    }
    pel_renderer_measure(r, get("stages") > 0);
    for (int i = 0; i < (int)get("frames"); i++) {
        int64_t start = pel_now_ns();
        double worked = processor_ms();
        env.time_s = get("time") + i / 30.0;
        if (pel_renderer_submit(r, &env, &draw, 1) != PEL_OK) {
            return 1;
        }
        struct pel_picture *p = pel_renderer_collect(r, 10000000000);
        if (!p) {
            return 1;
        }
        printf("frame %d: %.1f ms, %.1f ms of processor, EV %.2f;", i,
               (double)(pel_now_ns() - start) * 1e-6, processor_ms() - worked,
               p->exposure_ev);
        double ms[PEL_STAGE_COUNT];
        pel_renderer_stage_ms(r, ms);
        for (int s = 0; s < PEL_STAGE_COUNT && get("stages") > 0; s++) {
            printf(" %s %.3f", pel_stage_name(s), ms[s]);
        }
        printf("\n");
        const struct pel_encode_input in = { .rgba = p->rgba,
                                             .width = p->width,
                                             .height = p->height };
        struct pel_bytes png;
        if (i == (int)get("frames") - 1 && p->rgba &&
            pel_png_encode(&in, &png) == PEL_OK) {
            FILE *f = fopen(argv[1], "wb");
            fwrite(png.data, 1, png.size, f);
            fclose(f);
            pel_bytes_finish(&png);
        }
        pel_picture_release(p);
    }
    pel_renderer_destroy(r);
    return 0;
}
