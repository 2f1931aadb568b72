/* The map of what the sea reflects: the sky above the horizon, and below it
 * what waves show of it and of the water (Bruneton et al. 2010, section 6). */
#include "render/sky.h"

#include "optics/brdf.h"
#include "render/context.h"
#include "render/render_testkit.h"
#include "render/uniforms.h"

#define SIZE PEL_SKY_MAP_SIZE

static struct pel_context context;
static struct pel_sky sky;
static struct pel_sea sea;
static GLuint eye_buffer;
static float map[SIZE][SIZE][4];
static float light[sizeof(struct pel_block_light) / 16]
                  [4]; /* of the block `light` */

static void bind_eye(void *user, double height_m)
{
    struct pel_block_eye eye;
    (void)user;
    pel_fill_eye(height_m, height_m, false, NULL, &eye);
    glNamedBufferSubData(eye_buffer, 0, sizeof eye, &eye);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, eye_buffer);
}

static void make_map(double sun_elevation)
{
    struct pel_environment env = test_environment(&sea, 0.0);
    struct pel_block_frame frame;
    GLuint buffer;
    env.lights[PEL_LIGHT_SUN].direction =
        pel_sky_quantize(test_sun(sun_elevation, 40.0));
    assert_int_equal(pel_water_light_update(&sky.water, &env), PEL_OK);
    pel_fill_frame(&env, &frame);
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, sizeof frame, &frame, 0);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_FRAME, buffer);
    pel_sky_update(&sky, &env, bind_eye, NULL);
    glGetTextureImage(sky.reflection, 0, GL_RGBA, GL_FLOAT, sizeof map, map);
    glGetNamedBufferSubData(sky.light, 0, sizeof light, light);
    glDeleteBuffers(1, &buffer);
}

/* The map at u, linear between its pixels. */
static double at(double u, double v, int channel)
{
    double x = (u / PEL_REFLECTION_HALF_WIDTH * 0.5 + 0.5) * SIZE - 0.5;
    double y = (v / PEL_REFLECTION_HALF_WIDTH * 0.5 + 0.5) * SIZE - 0.5;
    int i = (int)floor(x), j = (int)floor(y);
    double f = x - i, g = y - j;
    return (1 - g) *
               ((1 - f) * map[j][i][channel] + f * map[j][i + 1][channel]) +
           g * ((1 - f) * map[j + 1][i][channel] +
                f * map[j + 1][i + 1][channel]);
}

/* F̄ of the waves, round, seen at this cosine. */
static double mean_fresnel(double cosine)
{
    double variance =
        0.5 * (sea.slope_variance_along + sea.slope_variance_cross);
    const struct pel_vec3 view = { sqrt(1 - cosine * cosine), 0, cosine };
    return pel_ross_mean_fresnel(view, variance, variance);
}

/* Mirrored at the horizon, weighted by the effective reflectance; the rest is
 * the water's. Within 2 %: the sky is read between pixels of the map. */
static void waves_reflect_waves(void **state)
{
    (void)state;
    static const double elevations[] = { 5.0, 30.0, 60.0 };
    test_sea(9.0, 0.0, 2, &sea);
    for (size_t n = 0; n < sizeof elevations / sizeof *elevations; n++) {
        make_map(elevations[n]);
        double worst = 0.0;
        int checked = 0;
        for (int j = 1; j < SIZE - 1; j++) {
            for (int i = 1; i < SIZE - 1; i++) {
                double u =
                    ((i + 0.5) / SIZE * 2 - 1) * PEL_REFLECTION_HALF_WIDTH;
                double v =
                    ((j + 0.5) / SIZE * 2 - 1) * PEL_REFLECTION_HALF_WIDTH;
                double rho2 = u * u + v * v;
                double down = (rho2 - 1) / (rho2 + 1); /* −z */
                if (down < 0.08 || rho2 > 1.9) {
                    continue; /* the sky's gradient at the horizon is steep */
                }
                double f = mean_fresnel(down);
                for (int c = 0; c < 3; c++) {
                    double mirrored = at(u / rho2, v / rho2, c);
                    double want = f * mirrored + (1 - f) * light[1][c];
                    worst = fmax(worst, fabs(map[j][i][c] / want - 1));
                    assert_true(map[j][i][c] > 0.0f);
                }
                checked++;
            }
        }
        print_message("Sun at %g: %d directions below the horizon within "
                      "%.2f %%\n",
                      elevations[n], checked, 100 * worst);
        assert_true(checked > 2000 && worst < 0.02);
    }
}

/* No step at the horizon: there the reflectance of the waves is whole but for
 * what their slopes let through. */
static void no_edge_at_the_horizon(void **state)
{
    (void)state;
    make_map(30.0);
    double whole = mean_fresnel(1e-6);
    for (int a = 0; a < 36; a++) {
        double c = cos(a * PEL_PI / 18), d = sin(a * PEL_PI / 18);
        double above = at(0.97 * c, 0.97 * d, 1);
        double below = at(1.03 * c, 1.03 * d, 1);
        assert_true(below < 1.05 * above);
        assert_true(below > 0.5 * whole * above);
    }
}

static int set_up(void **state)
{
    (void)state;
    struct pel_fault fault = { 0 };
    if (pel_context_init(&context, "software", true, &fault) ||
        pel_sky_init(&sky, NULL, &fault)) {
        fail_msg("%s", fault.message);
    }
    GLuint vao;
    glCreateVertexArrays(1, &vao);
    glBindVertexArray(vao);
    glCreateBuffers(1, &eye_buffer);
    glNamedBufferStorage(eye_buffer, sizeof(struct pel_block_eye), NULL,
                         GL_DYNAMIC_STORAGE_BIT);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    pel_sky_finish(&sky);
    pel_context_finish(&context);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(waves_reflect_waves),
        cmocka_unit_test(no_edge_at_the_horizon),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
