/* The maps of what the sea reflects: the sky, and what waves show of it and of
 * the water where they reflect each other (Bruneton et al. 2010, section 6). */
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
static float second[PEL_SECOND_SIZE][PEL_SECOND_SIZE][4];
static struct pel_environment env;
static float light[sizeof(struct pel_block_light) / 16]
                  [4]; /* of the block `light` */

static void bind_eye(void *user, double height_m)
{
    struct pel_block_eye eye;
    (void)user;
    pel_fill_eye(height_m, height_m, NULL, &eye);
    glNamedBufferSubData(eye_buffer, 0, sizeof eye, &eye);
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_EYE, eye_buffer);
}

static void make_map(double sun_elevation)
{
    env = test_environment(&sea, 0.0);
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
    glGetTextureImage(sky.second, 0, GL_RGBA, GL_FLOAT, sizeof second, second);
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

/* What a ray towards the azimuth (x, y) at a tangent of eta standard deviations
 * s of slopes sees: facets in proportion to (z − η)⁺ p(z), which mirror the sky
 * or show the water, by fine steps. */
static double other_waves(double x, double y, double eta, int channel)
{
    const struct pel_water_body *water = &env.water;
    double along = x * cos(env.wind_to_rad) + y * sin(env.wind_to_rad);
    double s2 = sea.slope_variance_along * along * along +
                sea.slope_variance_cross * (1 - along * along);
    double s = sqrt(s2);
    double across2 = sea.slope_variance_along * sea.slope_variance_cross / s2;
    double sum = 0.0, mass = 0.0;
    for (double z = eta + 0.01; z < 6.0; z += 0.02) {
        double w = (z - eta) * exp(-0.5 * z * z);
        double cosine = (z - eta) * s /
                        sqrt((1 + s2 * z * z + across2) * (1 + s2 * eta * eta));
        double f = pel_fresnel_exact(cosine, water->index[channel]);
        double e = fmax(atan(s * (2 * z - eta)), 0.01);
        double rho = cos(e) / (1 + sin(e));
        sum += w * (f * at(rho * x, rho * y, channel) +
                    (1 - f) * light[1][channel]);
        mass += w;
    }
    return sum / mass;
}

/* Within 1 % in the mean, 10 % at worst: the sky is read between pixels of its
 * map, and steep about a Sun at the horizon. */
static void waves_reflect_waves(void **state)
{
    (void)state;
    static const double elevations[] = { 5.0, 30.0, 60.0 };
    test_sea(9.0, 0.0, 2, &sea);
    for (size_t n = 0; n < sizeof elevations / sizeof *elevations; n++) {
        make_map(elevations[n]);
        double worst = 0.0, total = 0.0;
        int checked = 0;
        for (int j = 0; j < PEL_SECOND_SIZE; j += 3) {
            for (int i = 0; i < PEL_SECOND_SIZE; i += 3) {
                double u = (i + 0.5) / PEL_SECOND_SIZE * 2 - 1;
                double v = (j + 0.5) / PEL_SECOND_SIZE * 2 - 1;
                double rho = hypot(u, v);
                double place = (rho - PEL_SECOND_INNER) /
                               (1 - 1.0 / PEL_SECOND_SIZE - PEL_SECOND_INNER);
                if (place < 0 || place > 1) {
                    continue;
                }
                double eta = PEL_SECOND_FIRST + PEL_SECOND_SPAN * place;
                for (int c = 0; c < 3; c++) {
                    double want = other_waves(u / rho, v / rho, eta, c);
                    double off = fabs(second[j][i][c] / want - 1);
                    total += off / 3;
                    worst = fmax(worst, off);
                }
                checked++;
            }
        }
        print_message("Sun at %g: %d directions towards waves within %.2f %%, "
                      "in the mean %.2f %%\n",
                      elevations[n], checked, 100 * worst,
                      100 * total / checked);
        assert_true(checked > 200 && worst < 0.1 && total < 0.01 * checked);
    }
}

/* Below the horizon there is what is at it, so that a footprint that reaches
 * over it has what escapes. */
static void no_edge_at_the_horizon(void **state)
{
    (void)state;
    make_map(30.0);
    for (int a = 0; a < 36; a++) {
        double c = cos(a * PEL_PI / 18), d = sin(a * PEL_PI / 18);
        double above = at(0.985 * c, 0.985 * d, 1);
        double below = at(1.3 * c, 1.3 * d, 1);
        assert_true(below < 1.1 * above && below > 0.8 * above);
    }
}

static int set_up(void **state)
{
    (void)state;
    struct pel_fault fault = { 0 };
    if (pel_context_init(&context, test_device(), true, &fault) ||
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
