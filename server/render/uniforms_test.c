/* The pixel lattice, the waves' phases and the table of slope variance. */
#include "render/uniforms.h"

#include "render/render_testkit.h"

static struct pel_sea sea;
static const struct pel_filter filter = PEL_FILTER_DEFAULT;

/* Cuts columns and rows out of a camera, edges in plain double arithmetic. */
static struct pel_camera cut(const struct pel_camera *whole, uint32_t x0,
                             uint32_t x1, uint32_t y0, uint32_t y1)
{
    double px = (whole->tan_right - whole->tan_left) / whole->width;
    double py = (whole->tan_top - whole->tan_bottom) / whole->height;
    struct pel_camera c = *whole;
    c.width = x1 - x0;
    c.height = y1 - y0;
    c.tan_left = whole->tan_left + px * x0;
    c.tan_right = whole->tan_left + px * x1;
    c.tan_top = whole->tan_top - py * y0;
    c.tan_bottom = whole->tan_top - py * y1;
    return c;
}

static double by_degrees(double tangent)
{
    return tan(atan(tangent) / PEL_DEG * PEL_DEG);
}

/* As a client sends them: half-angles in degrees. */
static struct pel_camera through_degrees(struct pel_camera c)
{
    c.tan_left = by_degrees(c.tan_left);
    c.tan_right = by_degrees(c.tan_right);
    c.tan_top = by_degrees(c.tan_top);
    c.tan_bottom = by_degrees(c.tan_bottom);
    return c;
}

static void tiles_share_the_lattice(void **state)
{
    (void)state;
    static const uint32_t widths[] = { 512, 640, 1024, 1920, 4096 };
    static const double fields[] = { 1.0, 20.0, 33.3, 60.0, 90.0, 150.0 };
    uint64_t random = 3;
    for (size_t w = 0; w < sizeof widths / sizeof *widths; w++) {
        for (size_t f = 0; f < sizeof fields / sizeof *fields; f++) {
            uint32_t width = widths[w], height = width / 2;
            struct pel_camera whole = test_camera((struct test_look){
                6.0, 0.0, 0.0, 0.0, fields[f], width, height });
            struct pel_block_view all;
            pel_fill_view(&whole, &filter, &all);
            for (int i = 0; i < 50; i++) {
                uint32_t x0 = (uint32_t)test_random(&random, 0, width - 64);
                uint32_t y0 = (uint32_t)test_random(&random, 0, height - 64);
                uint32_t x1 =
                    x0 + 64 +
                    (uint32_t)test_random(&random, 0, width - 64 - x0);
                uint32_t y1 =
                    y0 + 64 +
                    (uint32_t)test_random(&random, 0, height - 64 - y0);
                struct pel_camera part = cut(&whole, x0, x1, y0, y1);
                if (i % 2) {
                    part = through_degrees(part);
                }
                struct pel_block_view view;
                pel_fill_view(&part, &filter, &view);
                assert_memory_equal(&view.pixel.x, &all.pixel.x,
                                    2 * sizeof(float));
                assert_true(view.pixel.z == all.pixel.z + (float)x0);
                assert_true(view.pixel.w == all.pixel.w + (float)y0);
            }
        }
    }
}

/* The pitch may be off by a part in two millions: over the 4096 pixels of the
 * widest picture that moves an edge by a thousandth of a pixel. */
static void pitch_is_close(void **state)
{
    (void)state;
    for (double fov = 1.0; fov < 151.0; fov += 0.37) {
        double t = tan(0.5 * fov * PEL_DEG);
        double pitch = pel_pixel_pitch(-t, t, 4096);
        assert_true(fabs(pitch * 4096.0 / (2.0 * t) - 1.0) < 0x1p-20);
        assert_true((float)pitch == pitch);
    }
}

/* Variance of a unit cosine of wavelength λ averaged over boxes of length l,
 * by summing: what sinc² stands for. */
static double kept_by_box(double lambda, double l)
{
    enum { PLACES = 64, INSIDE = 64 };
    double sum = 0.0;
    for (int i = 0; i < PLACES; i++) {
        double mean = 0.0;
        for (int j = 0; j < INSIDE; j++) {
            double x = i * lambda / PLACES + l * ((j + 0.5) / INSIDE - 0.5);
            mean += cos(2.0 * PEL_PI * x / lambda) / INSIDE;
        }
        sum += mean * mean / PLACES;
    }
    return 2.0 * sum;
}

static double smooth(double x)
{
    x = pel_clamp((x - filter.n_min) / (filter.n_max - filter.n_min), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

static void variance_is_the_direct_sum(void **state)
{
    (void)state;
    static struct pel_variance table[PEL_VARIANCE_COUNT];
    test_sea(9.0, 2.0, 5, &sea);
    pel_fill_variance(&sea, &filter, table);
    double wx = cos(sea.desc.direction_rad), wy = sin(sea.desc.direction_rad);
    for (int i = 0; i < PEL_VARIANCE_COUNT; i += 5) {
        double l = exp2(PEL_VARIANCE_FIRST + i / PEL_VARIANCE_STEPS);
        double along = sea.slope_variance_along;
        double cross = sea.slope_variance_cross;
        for (int j = 0; j < sea.count; j++) {
            const struct pel_wave *w = &sea.waves[j];
            double k = hypot(w->kx, w->ky), lambda = 2.0 * PEL_PI / k;
            double weight = smooth(lambda / l);
            if (weight <= 0.0) {
                continue;
            }
            /* Appendix A: (1 − √(1 − c²k²h²)) / c². */
            double kh = k * w->amplitude;
            double var = w->chop > 1e-6
                             ? (1.0 - sqrt(1.0 - pow(w->chop * kh, 2))) /
                                   (w->chop * w->chop)
                             : 0.5 * kh * kh;
            double kept = weight * weight * var * kept_by_box(lambda, l);
            /* The mean of the wave vectors that it wanders over. */
            for (int n = 0; n < 64; n++) {
                double by = w->swing * ((n + 0.5) / 32.0 - 1.0);
                double kx = w->kx + by * w->wander_x;
                double ky = w->ky + by * w->wander_y;
                double u = (kx * wx + ky * wy) / k, v = (ky * wx - kx * wy) / k;
                along -= kept * u * u / 64.0;
                cross -= kept * v * v / 64.0;
            }
        }
        /* The box has 64 samples: cosines to 4e-4 of the total. */
        double eps = 5e-4 * sea.slope_variance_along;
        assert_float_equal(table[i].along, along, eps);
        assert_float_equal(table[i].cross, cross, eps);
    }
}

static void variance_grows_with_the_footprint(void **state)
{
    (void)state;
    static const double winds[] = { 1.0, 5.0, 10.0, 20.0, 30.0 };
    static struct pel_variance t[PEL_VARIANCE_COUNT];
    for (size_t i = 0; i < sizeof winds / sizeof *winds; i++) {
        test_sea(winds[i], 0.0, 1, &sea);
        pel_fill_variance(&sea, &filter, t);
        for (int j = 1; j < PEL_VARIANCE_COUNT; j++) {
            assert_true(t[j].along >= t[j - 1].along);
            assert_true(t[j].cross >= t[j - 1].cross);
        }
        /* A pixel of a millimetre resolves all: what it averages away of a
         * wave of 2 cm is (π/20)²/3 = 0.8 %. */
        assert_true(t[0].along <= 0.008 * sea.slope_variance_along);
        assert_true(t[0].cross <= 0.008 * sea.slope_variance_cross + 1e-9);
        const struct pel_variance *last = &t[PEL_VARIANCE_COUNT - 1];
        assert_true(last->along == (float)sea.slope_variance_along);
        assert_true(last->cross == (float)sea.slope_variance_cross);
    }
}

/* The block's waves, summed as the shader does but in double, give the sea's
 * own displacement, wherever the eye is and however late it is. */
static void waves_are_the_sea(void **state)
{
    (void)state;
    static struct pel_block_waves block;
    test_sea(12.0, 3.0, 9, &sea);
    struct pel_environment env = test_environment(&sea, 12345.6);
    uint64_t random = 4;
    for (int i = 0; i < 40; i++) {
        double east = test_random(&random, -5e4, 5e4);
        double north = test_random(&random, -5e4, 5e4);
        pel_fill_waves(&env, east, north, &block);
        double x = test_random(&random, -200.0, 200.0);
        double y = test_random(&random, -200.0, 200.0);
        struct pel_vec3 d = { 0 };
        for (int j = 0; j < sea.count; j++) {
            const struct pel_shader_wave *w = &block.waves[j];
            double r = w->wander.x * x + w->wander.y * y + (double)w->wander.z;
            r -= rint(r);
            double turns = w->phase.x * x + w->phase.y * y +
                           (double)w->phase.z +
                           0.5 * floor(w->wander.z) * (r - 2.0 * r * fabs(r));
            double s = sin(2.0 * PEL_PI * turns);
            double c = cos(2.0 * PEL_PI * turns);
            double h = w->wander.w / (2.0 * PEL_PI);
            double across =
                h * s * floor(w->phase.z) / PEL_CHOP_STEPS * w->phase.w;
            d = pel_vec3_add(d,
                             (struct pel_vec3){ -across * w->phase.x,
                                                -across * w->phase.y, h * c });
        }
        struct pel_vec3 truth =
            pel_sea_displace(&sea, east + x, north + y, env.time_s);
        /* A wavenumber in single precision turns by 200 m · k · 6e-8: 4 mrad
         * for the shortest waves, microns of their height. */
        assert_float_equal(d.x, truth.x, 1e-4);
        assert_float_equal(d.y, truth.y, 1e-4);
        assert_float_equal(d.z, truth.z, 1e-4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_share_the_lattice),
        cmocka_unit_test(pitch_is_close),
        cmocka_unit_test(variance_is_the_direct_sum),
        cmocka_unit_test(variance_grows_with_the_footprint),
        cmocka_unit_test(waves_are_the_sea),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
