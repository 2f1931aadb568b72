/* The shaders' filtered surface against the double-precision one. */
#include "ocean/filter.h"

#include <epoxy/gl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "ocean/cascade.h"
#include "render/context.h"
#include "render/render_testkit.h"
#include "render/shader.h"
#include "render/sky.h"
#include "render/texels.h"
#include "render/uniforms.h"
#include "render/wavefield.h"

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

static const struct pel_filter filter = PEL_FILTER_DEFAULT;
static struct pel_context context;
static struct pel_wavefield field;
static struct pel_sea sea;

#define POINTS 2048
#define EAST_M 12345.0
#define NORTH_M (-6789.0)
#define TIME_S 4321.0

struct probe {
    float place[4];
};
struct answer {
    float shift[4], normal[4], left[4];
};
static struct probe probes[POINTS];
static struct answer answers[POINTS];

static GLuint bound(GLenum target, GLuint index, const void *data, size_t size)
{
    GLuint buffer;
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, (GLsizeiptr)size, data, 0);
    glBindBufferBase(target, index, buffer);
    return buffer;
}

static void ask_the_shader(void)
{
    static struct pel_block_waves waves;
    struct pel_block_frame frame = { 0 };
    struct pel_block_view view = { 0 };
    struct pel_block_cascades places;
    const struct pel_environment env = { .time_s = TIME_S, .sea = &sea };
    const struct pel_camera camera = { .tan_left = -1,
                                       .tan_right = 1,
                                       .tan_top = 1,
                                       .tan_bottom = -1,
                                       .width = 8,
                                       .height = 8 };
    frame.wind.x = (float)cos(sea.desc.direction_rad);
    frame.wind.y = (float)sin(sea.desc.direction_rad);
    pel_fill_view(&camera, &filter, &view);
    static struct pel_variance table[PEL_VARIANCE_COUNT];
    static struct pel_variance pairs[PEL_VARIANCE_COUNT - 1][2];
    struct pel_texels wave_texels = { 0 }, variance_texels;
    pel_fill_variance(&sea, &filter, table);
    pel_pair_variance(table, pairs);
    pel_texels_init(&variance_texels, "variance", pairs, sizeof pairs);
    glBindTextureUnit(PEL_UNIT_VARIANCE, variance_texels.texture);
    GLuint program;
    struct pel_fault fault;
    char defines[128];
    snprintf(defines, sizeof defines, "%s%s",
             sea.cascades ? "#define PEL_FFT\n" : "",
             pel_hardware_defines(context.software));
    if (pel_program_create(NULL, "filtered.comp", NULL, defines, &program,
                           &fault)) {
        fail_msg("%s", fault.message);
    }
    GLuint buffers[7] = {
        bound(GL_UNIFORM_BUFFER, 0, &frame, sizeof frame),
        bound(GL_UNIFORM_BUFFER, 2, &view, sizeof view),
    };
    if (sea.cascades) {
        pel_fill_cascades(sea.cascades, EAST_M, NORTH_M, &places);
        assert_int_equal(
            run_waves(&field, &sea.desc, sea.cascades, TIME_S, &fault), PEL_OK);
        buffers[3] = bound(GL_UNIFORM_BUFFER, 5, &places, sizeof places);
    } else {
        pel_fill_waves(&env, EAST_M, NORTH_M, &waves);
        pel_texels_init(&wave_texels, "waves", &waves, sizeof waves);
        glBindTextureUnit(PEL_UNIT_WAVES, wave_texels.texture);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_WAVES,
                         wave_texels.buffer);
    }
    buffers[4] = bound(GL_SHADER_STORAGE_BUFFER, 0, probes, sizeof probes);
    buffers[5] = bound(GL_SHADER_STORAGE_BUFFER, 1, NULL, sizeof answers);
    pel_program_use(program);
    glDispatchCompute(POINTS / 64, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffers[5], 0, sizeof answers, answers);
    glDeleteBuffers(6, buffers);
    pel_texels_finish(&wave_texels);
    pel_texels_finish(&variance_texels);
    pel_program_delete(program);
}

struct worst {
    double shift_m, normal, left; /* `left`: of the total */
};

static struct worst compare(double footprint_m)
{
    static struct pel_vec2 rest[POINTS];
    static struct pel_filtered want[POINTS];
    for (int i = 0; i < POINTS; i++) {
        float x = 400.0f * (float)sin(i * 1.1),
              y = 400.0f * (float)cos(i * 2.3);
        rest[i] = (struct pel_vec2){ EAST_M + (double)x, NORTH_M + (double)y };
        probes[i] = (struct probe){ { x, y, (float)footprint_m, 0 } };
    }
    assert_int_equal(pel_sea_filtered(&sea, &filter, footprint_m, rest, POINTS,
                                      TIME_S, want),
                     PEL_OK);
    ask_the_shader();
    struct worst w = { 0 };
    for (int i = 0; i < POINTS; i++) {
        const float *d = answers[i].shift, *n = answers[i].normal;
        const struct pel_filtered *f = &want[i];
        w.shift_m = fmax(w.shift_m, fabs(d[0] - f->shift.x));
        w.shift_m = fmax(w.shift_m, fabs(d[1] - f->shift.y));
        w.shift_m = fmax(w.shift_m, fabs(d[2] - f->shift.z));
        w.normal = fmax(w.normal, fabs(n[0] - f->normal.x));
        w.normal = fmax(w.normal, fabs(n[1] - f->normal.y));
        double all = sea.slope_variance_along + sea.slope_variance_cross;
        const float *l = answers[i].left;
        w.left = fmax(w.left, fabs(l[0] - f->left.along) / all);
        w.left = fmax(w.left, fabs(l[1] - f->left.cross) / all);
    }
    return w;
}

/* The published bounds. Positions: the sines of the trochoids are good to 7e-5
 * each and single precision turns a wave of 2 cm by a hundredth of a radian at
 * 400 m (microns of it, but its slope of 0.04 then by 4e-4), and the shears of
 * the cascades, 0.1 mm off there, by a few of those; slopes
 * blend with 8 bits of fraction in hardware, a 256th of the difference of two
 * texels. The tables of variance are read between entries. */
#define BOUND_M 3e-4
#define BOUND_NORMAL 8e-3
#define BOUND_LEFT 0.003

static void shaders_are_the_reference(void **state)
{
    (void)state;
    static const double footprints[] = { 0.004, 0.05, 0.2, 0.7, 2, 9, 40, 150 };
    for (int fft = 0; fft < 2; fft++) {
        struct pel_sea_desc desc = {
            .synthesiser =
                fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS,
            .kind = PEL_SPECTRUM_ELFOUHAILY,
            .wind_mps = 11,
            .direction_rad = 0.9,
            .fetch_m = 2e5,
            .seed = 4,
            .wave_count = 256,
        };
        assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
        for (size_t i = 0; i < sizeof footprints / sizeof *footprints; i++) {
            struct worst w = compare(footprints[i]);
            print_message("%s %7.3f m: position %.4f mm, normal "
                          "%.1e, variance %.2f %%\n",
                          fft ? "FFT      " : "trochoids", footprints[i],
                          1e3 * w.shift_m, w.normal, 100 * w.left);
            assert_true(w.shift_m < BOUND_M);
            assert_true(w.normal < BOUND_NORMAL);
            assert_true(w.left < BOUND_LEFT);
        }
        pel_sea_finish(&sea);
    }
}

static int set_up(void **state)
{
    (void)state;
    struct pel_fault fault = { 0 };
    if (pel_context_init(&context, test_device(), true, &fault)) {
        fail_msg("%s", fault.message);
    }
    return 0;
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
        cmocka_unit_test(shaders_are_the_reference),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
