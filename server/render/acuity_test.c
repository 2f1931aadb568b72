/* What an eye loses of detail by little light: gratings, points and their
 * energy through the filter itself, against the formula by arithmetic of this
 * file; and pictures: lamps and layers of light stay as they are, bands,
 * windows and both wrappers agree. */
#include "render/acuity.h"

#include "optics/colour.h"
#include "optics/vision.h"
#include "render/context.h"
#include "render/render_testkit.h"
#include "render/uniforms.h"

/* --- the formula ---------------------------------------------------------- */

/* Cycles a degree: Ward, Rushmeier and Piatko 1997. */
static double finest(double adapted)
{
    return 17.25 * atan(1.4 * log10(adapted) + 0.35) + 25.72;
}

/* A grating's contrast by a Gaussian that halves that of another. */
static double kept(double cycles, double halved)
{
    return pow(0.5, pow(cycles / halved, 2.0));
}

static void the_formula(void **state)
{
    (void)state;
    for (double l = 1e-4; l < 200.0; l *= 1.7) {
        assert_true(fabs(pel_vision_acuity(l) / finest(l) - 1.0) < 1e-4);
    }
    /* Shlaer's data: some 50 by day, 2 by starlight. */
    assert_true(fabs(pel_vision_acuity(300.0) - 49.0) < 2.0);
    assert_true(fabs(pel_vision_acuity(1e-4) - 2.0) < 0.3);
    assert_true(pel_vision_acuity(1e-9) == pel_vision_acuity(0.0));
    assert_true(pel_vision_blur(11.0) == 0.0);
    assert_true(pel_vision_blur(1e-3) > pel_vision_blur(1e-2));
}

/* --- the filter ----------------------------------------------------------- */

enum { SIDE = 192, MIDDLE = SIDE / 2 };

static struct pel_acuity acuity;
static struct pel_targets targets;
static float texels[SIDE * SIDE][4];

static void bind(GLuint binding, const void *block, size_t bytes)
{
    static GLuint buffers[16];
    if (!buffers[binding]) {
        glCreateBuffers(1, &buffers[binding]);
    }
    glNamedBufferData(buffers[binding], (GLsizeiptr)bytes, block,
                      GL_STREAM_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, binding, buffers[binding]);
}

/* A picture about tangents (x, y), so many pixels a radian there. */
static struct pel_camera about(double x, double y, double pixels)
{
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 0.0, 0.0, 0.0, 60.0, SIDE, SIDE });
    double half = 0.5 * SIDE / pixels;
    c.tan_left = x - half;
    c.tan_right = x + half;
    c.tan_bottom = y - half;
    c.tan_top = y + half;
    c.vision = PEL_VISION_EYE;
    return c;
}

/* Replaces the texels by what an eye adapted so sees of them. */
static void filter(const struct pel_camera *c, double adapted)
{
    static const struct pel_filter bounds = { 2.0, 8.0 };
    struct pel_block_frame frame;
    struct pel_block_exposure exposure;
    struct pel_block_view view;
    memset(&frame, 0, sizeof frame);
    memset(&exposure, 0, sizeof exposure);
    frame.red.x = frame.green.y = frame.blue.z = 1.0f;
    exposure.exposure.y = (float)log2(adapted);
    pel_fill_view(c, &bounds, &view);
    bind(PEL_BLOCK_FRAME, &frame, sizeof frame);
    bind(PEL_BLOCK_VIEW, &view, sizeof view);
    bind(PEL_BLOCK_EXPOSURE, &exposure, sizeof exposure);
    glTextureSubImage2D(targets.planes[PEL_AT_RADIANCE], 0, 0, 0, SIDE, SIDE,
                        GL_RGBA, GL_FLOAT, texels);
    GLuint seen = pel_acuity_run(&acuity, &targets, SIDE, SIDE, 0);
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    glGetTextureImage(seen, 0, GL_RGBA, GL_FLOAT, sizeof texels, texels);
}

/* Contrast that is left in the middle of a grating of so many cycles a degree,
 * its lines turned; tangents as seen. */
static double through(double adapted, double cycles, double turned, double x,
                      double y)
{
    /* 1.5 to 4 pixels of deviation. */
    double pixels = 10.0 * finest(adapted) * 180.0 / PEL_PI;
    struct pel_camera c = about(x, y, pixels);
    struct pel_vec3 to = pel_vec3_normalize((struct pel_vec3){ x, y, -1.0 });
    struct pel_vec3 side = { cos(turned), sin(turned), 0.0 };
    side = pel_vec3_normalize(
        pel_vec3_add(side, pel_vec3_scale(to, -pel_vec3_dot(side, to))));
    for (int i = 0; i < SIDE * SIDE; i++) {
        struct pel_vec3 dir = pel_vec3_normalize(
            (struct pel_vec3){ c.tan_left + (i % SIDE + 0.5) / pixels,
                               c.tan_top - (i / SIDE + 0.5) / pixels, -1.0 });
        double angle = asin(pel_vec3_dot(dir, side)) / PEL_DEG;
        double wave = cos(2.0 * PEL_PI * cycles * angle);
        for (int k = 0; k < 3; k++) {
            texels[i][k] = (float)(adapted * (1.0 + wave));
        }
    }
    filter(&c, adapted);
    /* The middle lies between four pixels, half a pixel's phase from each. */
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        int i = (MIDDLE - 1 + k / 2) * SIDE + MIDDLE - 1 + k % 2;
        struct pel_vec3 dir = pel_vec3_normalize(
            (struct pel_vec3){ c.tan_left + (i % SIDE + 0.5) / pixels,
                               c.tan_top - (i / SIDE + 0.5) / pixels, -1.0 });
        double angle = asin(pel_vec3_dot(dir, side)) / PEL_DEG;
        sum += ((double)texels[i][1] / adapted - 1.0) /
               cos(2.0 * PEL_PI * cycles * angle);
    }
    return sum / 4.0;
}

/* With the day's eye, that of 10 cd/m², before it, half of the contrast is left
 * within a tenth of the formula's grating. */
static void gratings(void **state)
{
    (void)state;
    static const double places[][2] = { { 0, 0 },       { 0.5, 0.3 },
                                        { -0.7, 0.5 },  { 0.2, -0.9 },
                                        { -0.6, -0.6 }, { 1.2, 0.1 } };
    double most = 0.0;
    for (double adapted = 1e-4; adapted < 0.2; adapted *= 10.0) {
        for (int p = 0; p < 6; p++) {
            for (int t = 0; t < 4; t++) {
                double low = 0.5, high = 1.5;
                for (int i = 0; i < 8; i++) {
                    double at = 0.5 * (low + high);
                    double cycles = at * finest(adapted);
                    double left = through(adapted, cycles, t * 45 * PEL_DEG,
                                          places[p][0], places[p][1]) *
                                  kept(cycles, finest(10.0));
                    *(left > 0.5 ? &low : &high) = at;
                }
                most = fmax(most, fabs(low - 1.0));
                if (p < 2 && t < 2) {
                    printf("%g cd/m², (%g, %g), %d°: half of %.2f cycles a "
                           "degree, formula %.2f\n",
                           adapted, places[p][0], places[p][1], 45 * t,
                           low * finest(adapted), finest(adapted));
                }
            }
        }
    }
    printf("at most %.1f %% off\n", 100.0 * most);
    assert_true(most < 0.1);
}

/* A point's light is all there, spread as a Gaussian where it is not far
 * brighter than what the eye is adapted to, and else stays. */
static void points(void **state)
{
    (void)state;
    const double adapted = 1e-3;
    double pixels = 0.0,
           angle = sqrt(0.5 * log(2.0)) / PEL_PI * PEL_DEG *
                   sqrt(pow(finest(adapted), -2.0) - pow(finest(10.0), -2.0));
    pixels = 5.0 / angle;
    for (int bright = 0; bright < 2; bright++) {
        struct pel_camera c = about(0.0, 0.0, pixels);
        double light = adapted * (bright ? 1e5 : 5.0), sum = 0.0, moment = 0.0;
        memset(texels, 0, sizeof texels);
        float *at = texels[MIDDLE * SIDE + MIDDLE];
        at[0] = at[1] = at[2] = (float)light;
        filter(&c, adapted);
        for (int i = 0; i < SIDE * SIDE; i++) {
            double v = (double)texels[i][1];
            sum += v;
            moment += v * pow(i % SIDE - MIDDLE, 2.0);
        }
        double peak = (double)at[1];
        printf("point of %g: %.6f of it there, deviation %.2f pixels of 5, "
               "peak %.4f\n",
               light, sum / light, sqrt(moment / sum), peak / light);
        /* Three degrees off the axis pixels are 0.4 % smaller. */
        assert_true(fabs(sum / light - 1.0) < (bright ? 1e-4 : 4e-3));
        assert_true(bright ? peak > 0.999 * light
                           : fabs(sqrt(moment / sum) / 5.0 - 1.0) < 0.05);
        assert_true(bright || fabs(peak / light * 50.0 * PEL_PI - 1.0) < 0.05);
    }
}

/* --- pictures ------------------------------------------------------------- */

static struct pel_sea sea;

static struct pel_environment night(void)
{
    struct pel_environment env = test_environment(&sea, 10.0);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(-11.0, 20.0);
    return env;
}

/* Eight degrees, 32 pixels each. */
static struct pel_camera spyglass(void)
{
    struct pel_camera c =
        test_camera((struct test_look){ 6.0, 0.0, -1.0, 2.0, 8.0, 256, 192 });
    c.vision = PEL_VISION_EYE;
    c.sight_count = 1;
    c.sights[0] = (struct pel_sight){
        c.world_from_camera, c.altitude_m, -0.5, 0.5, 0.4, -0.4
    };
    return c;
}

static void only_in_the_dark(void **state)
{
    (void)state;
    struct pel_environment env = night();
    struct pel_camera c = spyglass();
    assert_true(pel_acuity_border(&env, &c, PEL_LAYER_COLOR) > 8);
    assert_int_equal(pel_acuity_border(&env, &c, PEL_LAYER_RADIANCE), 0);
    c.vision = PEL_VISION_CAMERA;
    assert_int_equal(pel_acuity_border(&env, &c, PEL_LAYER_COLOR), 0);
    c.vision = PEL_VISION_EYE;
    env.lights[PEL_LIGHT_SUN].direction = test_sun(-1.0, 0.0);
    assert_int_equal(pel_acuity_border(&env, &c, PEL_LAYER_COLOR), 0);
    c.tan_right = 20.0; /* wide */
    env.lights[PEL_LIGHT_SUN].direction = test_sun(-9.0, 0.0);
    assert_in_range(pel_acuity_border(&env, &c, PEL_LAYER_COLOR), 1,
                    PEL_ACUITY_BORDER);
}

static double roughness(const struct pel_picture *p)
{
    double sum = 0.0;
    for (uint32_t i = p->width * p->height * 3 / 4;
         i + 1 < p->width * p->height; i++) {
        sum += fabs((double)p->rgba[4 * i + 5] - p->rgba[4 * i + 1]);
    }
    return sum / (p->width * p->height / 4.0);
}

/* Layers of light are not spread; a lamp is as bright as without. */
static void light_stays(void **state)
{
    (void)state;
    struct pel_environment env = night();
    struct pel_camera c = spyglass();
    const struct pel_lamp lamp = { .entity = PEL_NO_ENTITY,
                                   .north_m = 3000.0,
                                   .altitude_m = 4.0,
                                   .intensity_cd = { 40.0, 40.0, 40.0 },
                                   .ahead = { 0, -1, 0 },
                                   .up = { 0, 0, 1 },
                                   .arc_rad = 2.0 * PEL_PI,
                                   .spread_rad = PEL_PI / 2,
                                   .size_m = 0.2 };
    env.lamps = &lamp;
    env.lamp_count = 1;
    c.exposure_ev = 1.0;
    c.auto_exposure = false;
    struct pel_picture *eye =
        test_draw(renderer, &env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    c.vision = PEL_VISION_CAMERA;
    struct pel_picture *camera =
        test_draw(renderer, &env, &c, PEL_LAYER_COLOR | PEL_LAYER_RADIANCE);
    assert_memory_equal(eye->radiance, camera->radiance,
                        sizeof(float) * 4 * c.width * c.height);
    uint32_t peak = 0;
    for (uint32_t i = 0; i < c.width * c.height; i++) {
        peak =
            eye->radiance[4 * i + 1] > eye->radiance[4 * peak + 1] ? i : peak;
    }
    printf("lamp: code %d, %d to a camera; neighbours' difference %.2f codes, "
           "%.2f to a camera\n",
           eye->rgba[4 * peak + 1], camera->rgba[4 * peak + 1], roughness(eye),
           roughness(camera));
    assert_true(abs(eye->rgba[4 * peak + 1] - camera->rgba[4 * peak + 1]) <= 3);
    assert_true(roughness(eye) < 0.8 * roughness(camera));
    pel_picture_release(eye);
    pel_picture_release(camera);
}

static int differing(const struct pel_picture *a, uint32_t x,
                     const struct pel_picture *b)
{
    int count = 0;
    for (uint32_t row = 0; row < b->height; row++) {
        count += memcmp(a->rgba + 4 * ((size_t)row * a->width + x),
                        b->rgba + 4 * (size_t)row * b->width,
                        4 * (size_t)b->width) != 0;
    }
    return count;
}

/* To the bit. */
static void bands_windows_wrappers(void **state)
{
    (void)state;
    struct pel_environment env = night();
    struct pel_camera c = spyglass();
    struct pel_picture *whole = test_draw(renderer, &env, &c, PEL_LAYER_COLOR);
    struct pel_draw draw = { .camera = c,
                             .layers = PEL_LAYER_COLOR,
                             .rows = PEL_BAND_ROWS };
    for (; draw.first_row < c.height; draw.first_row += PEL_BAND_ROWS) {
        assert_int_equal(pel_renderer_submit(renderer, &env, &draw, 1), PEL_OK);
        while (!pel_renderer_band_done(renderer, 1000000000)) {
        }
    }
    struct pel_picture *p = pel_renderer_collect(renderer, 60000000000);
    assert_int_equal(differing(whole, 0, p), 0);
    pel_picture_release(p);
    for (int half = 0; half < 2; half++) {
        struct pel_camera part = c;
        part.width /= 2;
        *(half ? &part.tan_left : &part.tan_right) = 0.0;
        p = test_draw(renderer, &env, &part, PEL_LAYER_COLOR);
        assert_int_equal(differing(whole, half ? c.width / 2 : 0, p), 0);
        pel_picture_release(p);
    }
    struct pel_renderer *other = test_renderer("compute");
    p = test_draw(other, &env, &c, PEL_LAYER_COLOR);
    assert_int_equal(differing(whole, 0, p), 0);
    pel_picture_release(p);
    pel_renderer_destroy(other);
    pel_picture_release(whole);
}

/* --- life ----------------------------------------------------------------- */

static struct pel_context context;

static int begin_filter(void **state)
{
    (void)state;
    struct pel_fault fault = { 0 };
    GLuint vao;
    if (pel_context_init(&context, test_device(), true, &fault) ||
        pel_acuity_need(&acuity, NULL, &fault)) {
        fail_msg("%s", fault.message);
    }
    glCreateVertexArrays(1, &vao);
    glBindVertexArray(vao);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    pel_targets_fit(&targets, SIDE, SIDE, PEL_LAYER_RADIANCE);
    return 0;
}

static int end_filter(void **state)
{
    (void)state;
    pel_acuity_finish(&acuity);
    pel_targets_finish(&targets);
    pel_context_finish(&context);
    return 0;
}

static int begin_pictures(void **state)
{
    test_sea(7.0, 0.0, 1, &sea);
    return begin_renderer(state);
}

int main(void)
{
    const struct CMUnitTest filters[] = {
        cmocka_unit_test(the_formula),
        cmocka_unit_test(gratings),
        cmocka_unit_test(points),
    };
    const struct CMUnitTest pictures[] = {
        cmocka_unit_test(only_in_the_dark),
        cmocka_unit_test(light_stays),
        cmocka_unit_test(bands_windows_wrappers),
    };
    int failed = cmocka_run_group_tests(filters, begin_filter, end_filter);
    failed += cmocka_run_group_tests(pictures, begin_pictures, end_renderer);
    return failed;
}
