/* The sea from 2 m to 10,000 km: no step where its form changes, rows that move
 * little from octave to octave, a day that ends at the terminator, nothing at
 * poles and date line. */
#include "render/render_testkit.h"

#include "continents/continents.h"
#include "optics/airlight.h"
#include "optics/atmosphere.h"
#include "render/spacegeometry.h"

#define WIDTH 96
#define HEIGHT 72

static struct pel_sea sea;

static struct pel_environment day(double elevation, double azimuth)
{
    struct pel_environment env = test_environment(&sea, 20.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(elevation, azimuth);
    env.sparkle = false;
    return env;
}

static struct pel_picture *draw(const struct pel_environment *env,
                                double height_m, double heading, double pitch,
                                double fov)
{
    struct pel_camera c = test_camera((struct test_look){
        height_m, heading, pitch, 0.0, fov, WIDTH, HEIGHT });
    return test_draw(renderer, env, &c, PEL_LAYER_RADIANCE);
}

static double mean_of(const struct pel_picture *p, int y, int channel)
{
    double sum = 0;
    for (int x = 0; x < WIDTH; x++) {
        sum += p->radiance[4 * (y * WIDTH + x) + channel] / WIDTH;
    }
    return sum;
}

/* The same scene by both forms: rows' means; of them those within a row of the
 * horizon, where both have the twilight's rim from tables as coarse as a row.
 */
static void step_at(double height_m, double elevation, double azimuth,
                    double pitch)
{
    struct pel_environment env = day(elevation, azimuth);
    env.high = -1;
    struct pel_picture *low = draw(&env, height_m, 40.0, pitch, 50.0);
    env.high = 1;
    struct pel_picture *high = draw(&env, height_m, 40.0, pitch, 50.0);
    double worst = 0, rim = 0;
    double dip = acos(PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + height_m));
    for (int y = 0; y < HEIGHT; y++) {
        double t = tan(25 * PEL_DEG) * (HEIGHT - 1 - 2 * y) / WIDTH;
        double off = fabs(pitch * PEL_DEG + atan(t) + dip);
        for (int k = 0; k < 3; k++) {
            double by = fabs(mean_of(high, y, k) / mean_of(low, y, k) - 1);
            *(off < 4 * PEL_DEG && elevation < 0 ? &rim : &worst) =
                fmax(off < 4 * PEL_DEG && elevation < 0 ? rim : worst, by);
        }
    }
    pel_picture_release(low);
    pel_picture_release(high);
    print_message("%.0f m, Sun %g from %g, pitch %g: rows by %.2f %%, in the "
                  "rim %.2f\n",
                  height_m, elevation, azimuth, pitch, 100 * worst, 100 * rim);
    assert_true(worst < 0.01 && rim < 0.1);
}

static void no_step(void **state)
{
    (void)state;
    for (int fft = 0; fft < 2; fft++) {
        if (fft) {
            test_fft_sea(8.0, 3, &sea);
        } else {
            test_sea(8.0, 0.0, 3, &sea);
        }
        step_at(10000, 30, 220, -20);
        step_at(10000, 30, 40, -20);
        step_at(10000, 60, 130, -60);
        step_at(10000, 5, 130, -15);
        step_at(10000, -4, 60, -10);
        pel_sea_finish(&sea);
    }
}

/* The sea itself, without the air before it, straight below: its mean is that
 * of its facets from every height. Near the water a view shows a few waves, so
 * it is the mean over places. */
static double mean_from(double height_m)
{
    struct pel_environment env = day(30, 220);
    int places = height_m < 30 ? 400 : height_m < 3000 ? 100 : 4;
    double sum = 0;
    env.no_air = true;
    for (int i = 0; i < places; i++) {
        struct pel_camera c = test_camera(
            (struct test_look){ height_m, 40.0, -90.0, 0.0, 10.0, 16, 12 });
        c.east_m = 5003.0 * i;
        c.north_m = 3001.0 * (i * 7 % 13);
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        for (int k = 0; k < 16 * 12; k++) {
            sum += p->radiance[4 * k + 1] / (16.0 * 12.0 * places);
        }
        pel_picture_release(p);
    }
    return sum;
}

static void octaves(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 3, &sea);
    double before = 0, worst = 0;
    for (double h = 2; h < 5e5; h *= 2) {
        double now = mean_from(h);
        if (before > 0) {
            worst = fmax(worst, fabs(now / before - 1));
        }
        print_message("%8.0f m: %.6f (%+.2f %%)\n", h, now,
                      before > 0 ? 100 * (now / before - 1) : 0.0);
        before = now;
    }
    assert_true(worst < 0.01);
    pel_sea_finish(&sea);
}

/* Straight below from 10,000 km, the Sun on the horizon of the nadir. */
static void terminator(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 3, &sea);
    struct pel_environment env = day(0, 0);
    struct pel_picture *p = draw(&env, 1e7, 0.0, -90.0, 60.0);
    int x = WIDTH / 2;
    double before = 0, day_light = 0, night = 1e9;
    int dusk = 0;
    for (int y = 0; y < HEIGHT; y++) {
        double now = p->radiance[4 * (y * WIDTH + x) + 1];
        assert_true(isfinite(now) && now >= 0);
        day_light = fmax(day_light, now);
        if (y > HEIGHT / 2 - 2 && y < HEIGHT / 2 + 12) {
            assert_true(now <= before); /* it only grows darker */
            dusk += now < 0.3 * day_light && now > 1e-5 * day_light;
        }
        night = y > HEIGHT / 2 + 16 ? fmin(night, now) : night;
        before = now;
    }
    print_message("day %.4f, night %.2g, dusk in %d rows of 1.2 deg\n",
                  day_light, night, dusk);
    /* Twilight is 18 deg wide, most of its light in the first 8. */
    assert_true(dusk >= 4 && dusk <= 14);
    assert_true(night < 1e-6 * day_light);
    pel_picture_release(p);
    pel_sea_finish(&sea);
}

/* From where a row's middle meets the sea and the next one above does not. */
static void horizon_is_drawn(void **state)
{
    (void)state;
    test_sea(8.0, 0.0, 3, &sea);
    const double heights[] = { 1e4, 2e4, 1e5, 4e5, 1e7 };
    for (int i = 0; i < 5; i++) {
        for (int latitude = 0; latitude <= 90; latitude += 45) {
            struct pel_environment env = day(30, 220);
            env.origin_latitude_rad = latitude * PEL_DEG;
            const struct pel_space_geometry g =
                pel_space_geometry_of(heights[i], latitude * PEL_DEG, 0, 0);
            double low = 0, high = 1.5, distance;
            for (int k = 0; k < 60; k++) {
                double middle = 0.5 * (low + high);
                const struct pel_vec3 d = { cos(middle), 0, -sin(middle) };
                struct pel_vec3 normal;
                *(pel_space_meets(&g, d, &distance, &normal) ? &high : &low) =
                    middle;
            }
            struct pel_camera c = test_camera((struct test_look){
                heights[i], 90, -high / PEL_DEG, 0, 0.2, 16, 200 });
            struct pel_picture *p = test_draw(
                renderer, &env, &c, PEL_LAYER_DEPTH | PEL_LAYER_RADIANCE);
            int row = 0;
            while (row < 200 && isinf(p->depth[row * 16 + 8])) {
                row++;
            }
            double off = (100 - row) * 0.2 / 16;
            print_message(
                "%.0f m, latitude %d: dip %.4f, drawn %+.4f deg off\n",
                heights[i], latitude, high / PEL_DEG, off);
            assert_true(fabs(off) < 0.0126); /* a row */
            pel_picture_release(p);
        }
    }
    pel_sea_finish(&sea);
}

/* Light scattered into a sight of the sphere's frame, by a plain sum of short
 * steps through the double-precision air. */
static void scattered(const struct pel_atmosphere *a, double h,
                      struct pel_vec3 dir, struct pel_vec3 sun, double out[3])
{
    enum { STEPS = 3000 };
    const double ground = PEL_EARTH_RADIUS, top = PEL_ATMOSPHERE_RADIUS;
    double r = ground + h, nu = pel_vec3_dot(dir, sun);
    double middle = -r * dir.z, off2 = r * r - middle * middle;
    double in = fmax(middle - sqrt(fmax(top * top - off2, 0)), 0),
           end = middle + sqrt(fmax(top * top - off2, 0));
    if (off2 < ground * ground && middle > 0) {
        end = middle - sqrt(ground * ground - off2);
    }
    double depth[3] = { 0 };
    const double e0[3] = PEL_SUN_IRRADIANCE;
    const double beta[3] = { a->rayleigh.r, a->rayleigh.g, a->rayleigh.b },
                 ozone[3] = { a->ozone.r, a->ozone.g, a->ozone.b };
    out[0] = out[1] = out[2] = 0;
    if (off2 > top * top || end < in) {
        return;
    }
    double dt = (end - in) / STEPS;
    for (int i = 0; i < STEPS; i++) {
        double t = in + (i + 0.5) * dt;
        double there = sqrt(r * r + t * t + 2 * r * t * dir.z),
               height = fmax(there - ground, 0);
        double sun_mu = pel_clamp((r * sun.z + t * nu) / there, -1, 1),
               mu = pel_clamp((r * dir.z + t) / there, -1, 1);
        double sines = sqrt(fmax((1 - mu * mu) * (1 - sun_mu * sun_mu), 1e-12));
        double azimuth = pel_clamp((nu - mu * sun_mu) / sines, -1, 1);
        double dr = exp(-height / a->rayleigh_height_m),
               dm = exp(-height / a->mie_height_m),
               doz = fmax(0, 1 - fabs(height - a->ozone_center_m) /
                                     a->ozone_width_m);
        const struct pel_rgb direct = pel_atmosphere_sun_irradiance(
                                 a, height, (struct pel_vec3){ 0, 0, sun_mu }),
                             before =
                                 pel_airlight_at(a->airlight, a, height, sun_mu,
                                                 acos(mu), azimuth);
        const double beam[3] = { direct.r, direct.g, direct.b },
                     again[3] = { before.r, before.g, before.b };
        for (int k = 0; k < 3; k++) {
            double molecules = beta[k] * dr, dust = a->mie_scattering * dm;
            double sigma = molecules + a->mie_extinction * dm + ozone[k] * doz;
            double source = beam[k] * (molecules * pel_phase_rayleigh(nu) +
                                       dust * pel_phase_mie(nu, a->mie_g)) +
                            e0[k] * again[k] * (molecules + dust);
            out[k] += source * exp(-depth[k] - 0.5 * sigma * dt) * dt;
            depth[k] += sigma * dt;
        }
    }
}

/* The air before the sea, and beyond it. */
static void air_is_the_references(void **state)
{
    (void)state;
    static struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { 40000.0 };
    pel_atmosphere_init(&desc, &air);
    assert_int_equal(pel_atmosphere_tabulate(&air, NULL, NULL), PEL_OK);
    test_sea(8.0, 0.0, 3, &sea);
    static const struct {
        double height_m, heading, pitch, fov, sun, azimuth;
    } views[] = {
        { 1e4, 60, -5, 40, 30, 100 },   { 2e4, 60, -20, 60, 10, 40 },
        { 5e4, 200, -10, 20, 40, 220 }, { 1e5, 20, -12, 20, 5, 100 },
        { 4e5, 60, -22, 20, 40, 240 },  { 4e5, 60, -60, 60, 20, 100 },
        { 4e5, 60, -20.5, 3, -5, 80 },  { 1e7, 0, -90, 50, 30, 100 },
    };
    for (size_t i = 0; i < sizeof views / sizeof *views; i++) {
        struct pel_environment env = day(views[i].sun, views[i].azimuth);
        struct pel_camera c = test_camera((struct test_look){
            views[i].height_m, views[i].heading, views[i].pitch, 0,
            views[i].fov, WIDTH, HEIGHT });
        const struct pel_space_geometry g =
            pel_space_geometry_of(views[i].height_m, 0, 0, 0);
        const struct pel_vec3 to = pel_vec3_normalize(
            pel_mat3_apply(&g.from, env.lights[PEL_LIGHT_SUN].direction));
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_AIR | PEL_LAYER_SKY);
        double worst = 0, sum = 0, brightest = 0;
        int count = 0;
        for (int pass = 0; pass < 2; pass++) {
            for (int k = 3; k < WIDTH * HEIGHT; k += 101) {
                struct pel_vec3 ray =
                    test_ray(&c, k % WIDTH + 0.5, k / WIDTH + 0.5);
                ray = pel_vec3_normalize(pel_mat3_apply(&g.from, ray));
                double is[3];
                scattered(&air, g.height_m, ray, to, is);
                /* Above a hundredth of the brightest: of the top's last
                 * kilometres the table has one cell. */
                if (pass == 0) {
                    brightest = fmax(brightest, is[1]);
                } else if (is[1] > 1e-2 * brightest) {
                    const float *drawn =
                        p->air[4 * k] > 0 ? &p->air[4 * k] : &p->sky[4 * k];
                    double off = fmax(fabs(drawn[0] / is[0] - 1),
                                      fmax(fabs(drawn[1] / is[1] - 1),
                                           fabs(drawn[2] / is[2] - 1)));
                    worst = fmax(worst, off);
                    sum += off;
                    count++;
                }
            }
        }
        print_message("air from %.0f km, Sun %g: off by %.2f %% on average, "
                      "%.1f at most\n",
                      views[i].height_m / 1e3, views[i].sun, 100 * sum / count,
                      100 * worst);
        assert_true(sum / count < 0.005 && worst < 0.03);
        pel_picture_release(p);
    }
    pel_atmosphere_finish(&air);
    pel_sea_finish(&sea);
}

/* Latitude and longitude [rad] where a sight from an eye meets WGS 84, by axes
 * of the Earth; false: nowhere. */
static bool ground_of(double latitude, double longitude, double height_m,
                      struct pel_vec3 ray, double *lat, double *lon)
{
    const double a = 6378137.0, e2 = 0.00669437999014, b2 = 1 - e2;
    double s = sin(latitude), c = cos(latitude);
    double sl = sin(longitude), cl = cos(longitude);
    double n = a / sqrt(1 - e2 * s * s);
    const struct pel_vec3 eye = { (n + height_m) * c * cl,
                                  (n + height_m) * c * sl,
                                  (n * b2 + height_m) * s };
    const struct pel_vec3 d = { -sl * ray.x - s * cl * ray.y + c * cl * ray.z,
                                cl * ray.x - s * sl * ray.y + c * sl * ray.z,
                                c * ray.y + s * ray.z };
    double dd = d.x * d.x + d.y * d.y + d.z * d.z / b2,
           de = d.x * eye.x + d.y * eye.y + d.z * eye.z / b2,
           ee = eye.x * eye.x + eye.y * eye.y + eye.z * eye.z / b2 - a * a;
    double disc = de * de - dd * ee;
    if (disc < 0) {
        return false;
    }
    double t = (-de - sqrt(disc)) / dd;
    const struct pel_vec3 p = { eye.x + t * d.x, eye.y + t * d.y,
                                eye.z + t * d.z };
    *lat = atan2(p.z, b2 * hypot(p.x, p.y));
    *lon = atan2(p.y, p.x);
    return true;
}

/* Land is drawn where it is, at poles and date line as anywhere. */
static void continents(void **state)
{
    (void)state;
    const struct pel_continents *c = pel_continents_get();
    if (!c) {
        print_message("no coastlines: install gmt-gshhg-low\n");
        skip();
        return;
    }
    test_sea(8.0, 0.0, 3, &sea);
    static const struct {
        double latitude, longitude, height_m, heading, pitch;
    } eyes[] = {
        { -89.9, 20, 4e5, 30, -60 }, { 89.9, -60, 1e7, 0, -90 },
        { 66, 179.99, 4e5, 0, -90 }, { 66, -179.99, 4e5, 0, -90 },
        { 45, 10, 5e4, 200, -30 },   { -40, 175, 1e7, 50, -70 },
        { 20, -100, 2e6, 300, -60 },
    };
    for (size_t i = 0; i < sizeof eyes / sizeof *eyes; i++) {
        struct pel_environment env = day(60, 220);
        env.origin_latitude_rad = eyes[i].latitude * PEL_DEG;
        env.origin_longitude_rad = eyes[i].longitude * PEL_DEG;
        env.continents = true;
        struct pel_camera camera = test_camera(
            (struct test_look){ eyes[i].height_m, eyes[i].heading,
                                eyes[i].pitch, 0, 50, WIDTH, HEIGHT });
        struct pel_picture *p =
            test_draw(renderer, &env, &camera, PEL_LAYER_ALBEDO);
        int land = 0, water = 0, wrong = 0;
        for (int k = 0; k < WIDTH * HEIGHT; k++) {
            double lat, lon;
            struct pel_vec3 ray =
                test_ray(&camera, k % WIDTH + 0.5, k / WIDTH + 0.5);
            bool drawn = p->albedo[4 * k + 1] > 0;
            if (!ground_of(env.origin_latitude_rad, env.origin_longitude_rad,
                           eyes[i].height_m, ray, &lat, &lon)) {
                wrong += drawn;
                continue;
            }
            int x = (int)((lon / PEL_PI + 1) / 2 * PEL_CONTINENT_COLUMNS),
                y = (int)((lat / PEL_PI + 0.5) * PEL_CONTINENT_ROWS);
            int share = c->share[(size_t)y * PEL_CONTINENT_COLUMNS + x];
            land += share > 127;
            water += share <= 127;
            wrong += drawn != (share > 127);
        }
        print_message("from %g %g, %.0f km: %d pixels of land, %d of water, "
                      "%d otherwise\n",
                      eyes[i].latitude, eyes[i].longitude,
                      eyes[i].height_m / 1e3, land, water, wrong);
        /* Pixels on coasts, the more the larger they are. */
        assert_true(wrong < 0.04 * (land + water));
        pel_picture_release(p);
    }
    pel_sea_finish(&sea);
}

/* Pictures from low and from high up do not depend on each other. */
#define HEIGHTS 7
static uint8_t colours[HEIGHTS][4 * WIDTH * HEIGHT];
static float lights[HEIGHTS][4 * WIDTH * HEIGHT];

static double draw_heights(int i)
{
    const double heights[HEIGHTS] = { 5, 4e5, 5, 1e7, 4e5, 15000, 5 };
    struct pel_environment env = day(12, 30);
    struct pel_camera c = test_camera((struct test_look){
        heights[i], 40, heights[i] > 1e6 ? -80 : -25, 0, 50, WIDTH, HEIGHT });
    struct pel_picture *p =
        test_draw(renderer, &env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    memcpy(colours[i], p->rgba, sizeof colours[i]);
    memcpy(lights[i], p->radiance, sizeof lights[i]);
    pel_picture_release(p);
    return heights[i];
}

static void nothing_is_remembered(void **state)
{
    (void)state;
    double heights[HEIGHTS];
    test_fft_sea(8.0, 3, &sea);
    for (int i = 0; i < HEIGHTS; i++) {
        heights[i] = draw_heights(i);
        for (int k = 0; k < i; k++) {
            if (heights[k] == heights[i]) {
                assert_memory_equal(lights[k], lights[i], sizeof lights[i]);
                assert_memory_equal(colours[k], colours[i], sizeof colours[i]);
            }
        }
    }
    pel_sea_finish(&sea);
}

/* Nor on how pixels are shaded that are. */
static void compute_is_the_same(void **state)
{
    (void)state;
    static uint8_t before[4 * WIDTH * HEIGHT];
    test_fft_sea(8.0, 3, &sea);
    for (int i = 1; i < HEIGHTS; i += 2) {
        memcpy(before, colours[i], sizeof before);
        draw_heights(i);
        assert_memory_equal(before, colours[i], sizeof before);
    }
    pel_sea_finish(&sea);
}

static int begin_compute(void **state)
{
    (void)state;
    renderer = test_renderer("compute");
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_step),
        cmocka_unit_test(octaves),
        cmocka_unit_test(terminator),
        cmocka_unit_test(horizon_is_drawn),
        cmocka_unit_test(air_is_the_references),
        cmocka_unit_test(continents),
        cmocka_unit_test(nothing_is_remembered),
    };
    const struct CMUnitTest compute[] = {
        cmocka_unit_test(compute_is_the_same),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer) +
           cmocka_run_group_tests(compute, begin_compute, end_renderer);
}
