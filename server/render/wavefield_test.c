/* The fields that the shaders transform against those of the reference: one
 * sea on CPU and GPU. */
#include "render/wavefield.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "render/context.h"
#include "render/render_testkit.h"

#define N PEL_CASCADE_N
#define TEXELS (PEL_CASCADES * PEL_CASCADE_MODES)

static enum pel_err run_waves(struct pel_wavefield *field,
                              const struct pel_sea_desc *desc,
                              const struct pel_cascades *cascades,
                              double time_s, struct pel_fault *fault)
{
    enum pel_err err = pel_wavefield_need(field, NULL, desc, fault);
    if (err == PEL_OK) {
        pel_wavefield_run(field, desc, cascades, time_s);
    }
    return err;
}

static struct pel_context context;
static struct pel_wavefield field;

static float *texture(GLuint name, int level, GLenum format, int channels)
{
    int n = N >> level;
    size_t size = sizeof(float) * PEL_CASCADES * (size_t)(n * n * channels);
    float *out = malloc(size);
    assert_non_null(out);
    glGetTextureImage(name, level, format, GL_FLOAT, (GLsizei)size, out);
    return out;
}

/* Greatest difference of `channels` floats a texel, `stride` apart. */
static double difference(const float *gpu, const float *cpu, int channels,
                         int stride)
{
    double worst = 0;
    for (int i = 0; i < PEL_CASCADE_MODES; i++) {
        for (int j = 0; j < channels; j++) {
            worst = fmax(
                worst, fabs((double)gpu[i * stride + j] - cpu[i * stride + j]));
        }
    }
    return worst;
}

/* Both round in single precision: displacement within 1e-6 of Hs, 0.01 mm of a
 * sea of 10 m; the phase is exact on both sides, however long the time. */
static void fields_are_the_reference(void **state)
{
    (void)state;
    const double times[] = { 0, 1234.5, 8.7654321e8 };
    const struct pel_sea_desc descs[] = {
        { .kind = PEL_SPECTRUM_ELFOUHAILY,
          .wind_mps = 6,
          .direction_rad = 1,
          .fetch_m = 1e5,
          .seed = 1,
          .wave_count = 60 },
        { .kind = PEL_SPECTRUM_JONSWAP,
          .wind_mps = 25,
          .direction_rad = -2,
          .fetch_m = 5e5,
          .gamma = 3.3,
          .seed = 2,
          .wave_count = 60,
          .depth_m = 40 },
    };
    for (int s = 0; s < 2; s++) {
        struct pel_cascades *cascades;
        assert_int_equal(pel_cascades_create(&descs[s], &cascades), PEL_OK);
        double hs = 4 * sqrt(cascades->m0);
        for (int t = 0; t < 3; t++) {
            struct pel_cascade_fields *want;
            struct pel_fault fault;
            assert_int_equal(
                pel_cascade_fields_create(cascades, times[t], &want), PEL_OK);
            if (run_waves(&field, &descs[s], cascades, times[t], &fault)) {
                fail_msg("%s", fault.message);
            }
            float *d =
                texture(field.sets[field.current].displacement, 0, GL_RGBA, 4);
            float *h = texture(field.sets[field.current].slopes, 0, GL_RGBA, 4);
            float *x = texture(field.sets[field.current].fold, 0, GL_RED, 1);
            double shift = 0, slope = 0, fold = 0;
            for (int c = 0; c < PEL_CASCADES; c++) {
                size_t at = (size_t)c * PEL_CASCADE_MODES;
                shift = fmax(shift, difference(d + 4 * at,
                                               want->displacement[c][0], 3, 4));
                slope = fmax(slope,
                             difference(h + 4 * at, want->slopes[c][0], 4, 4));
                fold = fmax(fold, difference(x + at, want->fold[c], 1, 1));
            }
            printf("Hs %.2f m, %.9g s: displacement within %.4f mm, slopes "
                   "%.1e, fold %.1e\n",
                   hs, times[t], 1e3 * shift, slope, fold);
            /* A GPU's sines are less exact: 1.04e-6 on an NVIDIA H200. */
            assert_true(shift < (context.software ? 1e-6 : 2e-6) * hs);
            assert_true(slope < 2e-6 && fold < 2e-5);
            free(d);
            free(h);
            free(x);
            pel_cascade_fields_destroy(want);
        }
        pel_cascades_destroy(cascades);
    }
}

/* Each level is the mean of 2 × 2 texels of the one before, as the table of
 * kept slope variance supposes. */
static void levels_are_means(void **state)
{
    (void)state;
    struct pel_sea_desc desc = { .wind_mps = 12, .seed = 1, .wave_count = 60 };
    struct pel_cascades *cascades;
    struct pel_fault fault;
    assert_int_equal(pel_cascades_create(&desc, &cascades), PEL_OK);
    assert_int_equal(run_waves(&field, &desc, cascades, 3, &fault), PEL_OK);
    for (int level = 1; level < PEL_CASCADE_LEVELS; level++) {
        int n = N >> level;
        float *fine =
            texture(field.sets[field.current].slopes, level - 1, GL_RGBA, 4);
        float *coarse =
            texture(field.sets[field.current].slopes, level, GL_RGBA, 4);
        for (int i = 0; i < PEL_CASCADES * n * n * 4; i++) {
            int channel = i % 4, x = i / 4 % n, y = i / 4 / n % n;
            int c = i / 4 / n / n;
            const float *from =
                fine + 4 * ((size_t)c * 4 * n * n + (size_t)4 * y * n + 2 * x) +
                channel;
            double mean = 0.25 * ((double)from[0] + from[4] + from[8 * n] +
                                  from[8 * n + 4]);
            assert_true(fabs(mean - coarse[i]) < 1e-6);
        }
        free(fine);
        free(coarse);
    }
    pel_cascades_destroy(cascades);
}

/* The processor's textures hold the fields that queries read, bit for bit,
 * whatever the number of its threads; levels of both ways are the same means.
 */
static void processor_uploads_the_fields(void **state)
{
    (void)state;
    const struct pel_sea_desc desc = { .wind_mps = 12,
                                       .seed = 1,
                                       .wave_count = 60 };
    struct pel_cascades *cascades;
    struct pel_cascade_fields *want;
    struct pel_fault fault;
    assert_int_equal(pel_cascades_create(&desc, &cascades), PEL_OK);
    assert_int_equal(pel_cascade_fields_create(cascades, 77, &want), PEL_OK);
    float *last[PEL_CASCADE_LEVELS] = { NULL };
    for (int threads = 1; threads <= 4; threads++) {
        struct pel_wavefield own = { .on_processor = true, .threads = threads };
        for (int i = 0; i < 3; i++) { /* both sets, the first one twice */
            assert_int_equal(
                run_waves(&own, &desc, cascades, i < 2 ? 5 + i : 77, &fault),
                PEL_OK);
        }
        const struct pel_wavefield_textures *set = &own.sets[own.current];
        float *d = texture(set->displacement, 0, GL_RGBA, 4);
        float *h = texture(set->slopes, 0, GL_RGBA, 4);
        float *x = texture(set->fold, 0, GL_RED, 1);
        for (size_t c = 0; c < PEL_CASCADES; c++) {
            size_t at = c * PEL_CASCADE_MODES, n = PEL_CASCADE_MODES;
            assert_memory_equal(d + 4 * at, want->displacement[c], 16 * n);
            assert_memory_equal(h + 4 * at, want->slopes[c], 16 * n);
            assert_memory_equal(x + at, want->fold[c], 4 * n);
        }
        free(d);
        free(h);
        free(x);
        for (int level = 1; level < PEL_CASCADE_LEVELS; level++) {
            size_t n = (size_t)(N >> level) * (size_t)(N >> level);
            float *now = texture(set->slopes, level, GL_RGBA, 4);
            if (last[level]) {
                assert_memory_equal(now, last[level], 16 * n * PEL_CASCADES);
            }
            free(last[level]);
            last[level] = now;
        }
        pel_wavefield_finish(&own);
    }
    assert_int_equal(run_waves(&field, &desc, cascades, 77, &fault), PEL_OK);
    for (int level = 1; level < PEL_CASCADE_LEVELS; level++) {
        size_t n = (size_t)(N >> level) * (size_t)(N >> level);
        float *shaders =
            texture(field.sets[field.current].slopes, level, GL_RGBA, 4);
        for (size_t i = 0; i < 4 * n * PEL_CASCADES; i++) {
            assert_true(fabs((double)shaders[i] - last[level][i]) < 2e-6);
        }
        free(shaders);
        free(last[level]);
    }
    pel_cascade_fields_destroy(want);
    pel_cascades_destroy(cascades);
}

static int set_up(void **state)
{
    (void)state;
    struct pel_fault fault;
    return pel_context_init(&context, test_device(), true, &fault);
}

static int tear_down(void **state)
{
    (void)state;
    pel_wavefield_finish(&field);
    pel_context_finish(&context);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_are_the_reference),
        cmocka_unit_test(levels_are_means),
        cmocka_unit_test(processor_uploads_the_fields),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
