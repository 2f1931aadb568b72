/* Pictures of low-light and thermal sensors: counts of photons, temperatures,
 * the same bits in bands and in any order. */

#include "optics/colour.h"
#include "optics/lowlight.h"
#include "optics/thermal.h"
#include "render/render_testkit.h"

static struct pel_sensor thermal(double span_k)
{
    return (struct pel_sensor){ .kind = PEL_SENSOR_ON,
                                .scale = 1,
                                .sense = PEL_SENSE_THERMAL,
                                .seed = 77,
                                .low_k = 288.15 - 0.5 * span_k,
                                .span_k = span_k,
                                .sea_k = 288.15,
                                .air_k = 288.15,
                                .humidity = 0.75 };
}

static double mean_kelvin(const struct pel_picture *p,
                          const struct pel_sensor *s)
{
    double sum = 0;
    for (size_t i = 0; i < (size_t)p->width * p->height; i++) {
        sum += p->rgba[4 * i];
    }
    return s->low_k + s->span_k * sum / (255.0 * p->width * p->height);
}

static const struct test_look down = { 20, 0, -90, 0, 10, 64, 64 };

/* Under a sky as warm as the sea, it sends what a black body does. Eight bits
 * of 20 K are 0.08 K. */
static void sea_has_its_temperature(void **state)
{
    (void)state;
    struct pel_sea sea;
    test_sea(5, 0, 3, &sea);
    struct pel_environment env = test_environment(&sea, 4);
    struct pel_camera c = test_camera(down);
    c.sensor = thermal(20);
    c.sensor.cloud = 1;
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    assert_true(fabs(mean_kelvin(p, &c.sensor) - 288.15) < 0.3);
    pel_picture_release(p);
    /* Under a clear one, less by what it mirrors of its coldness. */
    c.sensor.cloud = 0;
    p = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    struct pel_thermal_air air = pel_thermal_air(288.15, 0.75, 40000, 0);
    double e = pel_thermal_emissivity(1);
    double want = pel_thermal_temperature(e * pel_thermal_radiance(288.15) +
                                          (1 - e) * pel_thermal_sky(&air, 1));
    double got = mean_kelvin(p, &c.sensor);
    if (fabs(got - want) > 0.1) {
        fail_msg("%.2f K, not %.2f", got, want);
    }
    pel_picture_release(p);
}

/* What is shown of exposed light, decoded. */
static double linear(uint8_t byte)
{
    double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

/* 49152 pixels: their variance is known to 0.7 %. */
static void photons_are_poissons(void **state)
{
    (void)state;
    struct pel_sea sea;
    test_sea(5, 0, 3, &sea);
    struct pel_environment env = test_environment(&sea, 4);
    struct pel_camera c =
        test_camera((struct test_look){ 20, 180, 20, 0, 20, 256, 192 });
    c.glare = 0;
    c.tone = PEL_TONE_LINEAR;
    c.auto_exposure = false;
    for (int kind = 0; kind < 2; kind++) {
        const double wanted = kind ? 24 : 6, white = kind ? 50 : 20;
        double n[3], unit[3], m[9], mean = 0, sum = 0, square = 0;
        c.sensor = (struct pel_sensor){ 0 };
        struct pel_picture *p =
            test_draw(renderer, &env, &c, PEL_LAYER_RADIANCE);
        const float *light = p->radiance;
        size_t count = (size_t)p->width * p->height;
        pel_lowlight_photons(1, 1.4, unit);
        for (size_t i = 0; i < count; i++) {
            for (int k = 0; k < 3; k++) {
                mean +=
                    unit[k] * (double)light[4 * i + (size_t)k] / (double)count;
            }
        }
        c.sensor = (struct pel_sensor){ .kind = PEL_SENSOR_ON,
                                        .scale = 1,
                                        .sense = PEL_SENSE_LOW_LIGHT,
                                        .seed = 99 + (uint32_t)kind,
                                        .exposure_s = wanted / mean,
                                        .f_number = 1.4 };
        pel_lowlight_photons(c.sensor.exposure_s, 1.4, n);
        pel_colour_matrix(1.0, m);
        double grey = 0.2126 * (m[0] + m[1] + m[2]) +
                      0.7152 * (m[3] + m[4] + m[5]) +
                      0.0722 * (m[6] + m[7] + m[8]);
        /* So many photons are white. */
        c.exposure_ev = log2(white * grey / (n[0] + n[1] + n[2]) *
                             PEL_TONE_MIDDLE / PEL_METER_MIDDLE);
        struct pel_picture *q = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
        mean = 0;
        for (size_t i = 0; i < count; i++) {
            double want = 0;
            for (size_t k = 0; k < 3; k++) {
                want += n[k] * (double)light[4 * i + k];
            }
            double got = round(linear(q->rgba[4 * i]) * white);
            mean += want;
            sum += got;
            square += (got - want) * (got - want);
        }
        if (fabs(sum / mean - 1) > 0.01 || fabs(square / mean - 1) > 0.03) {
            fail_msg("mean %.4f, variance %.4f of %.2f photons", sum / mean,
                     square / mean, mean / (double)count);
        }
        pel_picture_release(p);
        pel_picture_release(q);
    }
}

static uint8_t *copy(struct pel_picture *p)
{
    size_t bytes = (size_t)p->width * p->height * 4;
    uint8_t *out = malloc(bytes);
    memcpy(out, p->rgba, bytes);
    pel_picture_release(p);
    return out;
}

static void bits_are_of_the_moment(void **state)
{
    (void)state;
    struct pel_sea sea;
    test_sea(8, 0, 3, &sea);
    struct pel_environment env = test_environment(&sea, 4);
    struct test_look look = { 12, 30, -3, 2, 60, 160, 192 };
    for (int sense = 1; sense <= 2; sense++) {
        struct pel_camera c = test_camera(look);
        c.antialiasing = true;
        c.sensor = thermal(20);
        c.sensor.sense = (enum pel_sense)sense;
        c.sensor.netd_k = 0.2;
        c.sensor.exposure_s = 1e-5;
        c.sensor.f_number = 16;
        uint8_t *first = copy(test_draw(renderer, &env, &c, PEL_LAYER_COLOR));
        struct pel_camera other = test_camera(down);
        free(copy(test_draw(renderer, &env, &other, PEL_LAYER_COLOR)));
        /* With layers besides, in bands. */
        struct pel_draw band = { .camera = c,
                                 .layers = PEL_LAYER_COLOR | PEL_LAYER_DEPTH };
        for (uint32_t row = 0; row < 192; row += 64) {
            band.first_row = row;
            band.rows = 64;
            assert_int_equal(pel_renderer_submit(renderer, &env, &band, 1),
                             PEL_OK);
        }
        struct pel_picture *p = pel_renderer_collect(renderer, 60000000000);
        assert_non_null(p);
        uint8_t *again = copy(p);
        assert_memory_equal(first, again, (size_t)160 * 192 * 4);
        free(first);
        free(again);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sea_has_its_temperature),
        cmocka_unit_test(photons_are_poissons),
        cmocka_unit_test(bits_are_of_the_moment),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
