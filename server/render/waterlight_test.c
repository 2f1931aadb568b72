/* The maps that colour the sea against the quadrature of optics/transport.c,
 * as the pixels look them up. */
#include "render/waterprobe.h"

#include <time.h>

#include "base/clock.h"
#include "base/near.h"
#include "optics/brdf.h"
#include "optics/ordinates.h"
#include "render/context.h"
#include "render/render_testkit.h"
#include "render/uniforms.h"

static struct pel_water_prober prober;

static void look(const struct pel_water_body *body,
                 enum pel_water_orders orders, double sun_zenith,
                 const double (*views)[2], int count,
                 struct pel_water_parts *out)
{
    const struct pel_water_depths depths = { 1, body->depth_m, body->depth_m };
    struct pel_fault fault;
    enum pel_err err =
        pel_water_prober_run(&prober, NULL, body, &depths, body->depth_m,
                             orders, sun_zenith, views, count, out, &fault);
    if (err) {
        fail_msg("%s", fault.message);
    }
}

/* Three media to a body, one a wavelength. */
static struct pel_water_body body_of(const double (*medium)[3], double depth_m,
                                     double albedo)
{
    struct pel_water_body body = { .depth_m = depth_m };
    for (int i = 0; i < 3; i++) {
        body.absorption[i] = medium[i][0];
        body.scattering[i] = medium[i][1];
        body.asymmetry[i] = medium[i][2];
        body.albedo[i] = albedo;
    }
    return body;
}

/* Clear, middling and turbid; those of the Monte Carlo (make validate). */
static const double media[3][3][3] = {
    { { 0.05, 0.1, 0.924 }, { 0.05, 0.4, 0.924 }, { 0.15, 1.7, 0.924 } },
    { { 0.05, 0.1, 0.75 }, { 0.05, 0.4, 0.75 }, { 0.4, 0.2, 0.75 } },
    { { 0.4, 0.2, 0.924 }, { 0.465, 0.07, 0.85 }, { 0.006, 0.003, 0.0 } },
};

#define ZENITHS 6
#define AZIMUTHS 4
#define VIEWS (ZENITHS * AZIMUTHS)

static void fill_views(double views[VIEWS][2])
{
    for (int i = 0; i < VIEWS; i++) {
        static const double zenith[ZENITHS] = { 0, 17, 40, 61, 78, 88 };
        static const double azimuth[AZIMUTHS] = { 0, 50, 123, 180 };
        views[i][0] = zenith[i / AZIMUTHS] * PEL_DEG;
        views[i][1] = azimuth[i % AZIMUTHS] * PEL_DEG;
    }
}

struct worst {
    double most, error;
};

static void compare(struct worst *w, double got, double want)
{
    w->most = fmax(w->most, want);
    w->error = fmax(w->error, fabs(got - want));
}

static double share(struct worst w, double *worst)
{
    double e = w.most > 0.0 ? w.error / w.most : 0.0;
    *worst = fmax(*worst, e);
    return e;
}

/* ≤ 1/1000 of the maximum over the views, where 1/255 shows in 8 bits: each
 * order by itself, and all together; Sun 90° to 2° high. */
static void maps_are_the_quadrature(void **state)
{
    (void)state;
    static const double suns[] = { 0, 33, 60, 80, 88 };
    static const double depths[] = { 1, 10, 1000 };
    double views[VIEWS][2], single = 0, second = 0, bottom = 0, all = 0;
    fill_views(views);
    for (int k = 0; k < 4 * 3; k++) {
        struct pel_water_body body =
            body_of(media[k % 4 % 3], depths[k / 4], k / 4 == 2 ? 0.0 : 0.3);
        for (int c = 0; c < 3 && k % 4 == 3; c++) {
            /* Of molecules and of Fournier and Forand's particles. */
            body.molecular[c] = (const double[]){ 0.05, 0.4, 0.002 }[c];
            body.back[c] = (const double[]){ 0.01, 0.005, 0.0183 }[c];
        }
        for (int s = 0; s < 5; s++) {
            struct pel_water_parts two[VIEWS], every[VIEWS];
            double zenith = suns[s] * PEL_DEG;
            look(&body, PEL_ORDERS_TWO, zenith, views, VIEWS, two);
            look(&body, PEL_ORDERS_ALL, zenith, views, VIEWS, every);
            for (int c = 0; c < 3; c++) {
                struct pel_medium m = pel_water_medium(&body, c);
                struct worst w[4] = { 0 };
                for (int v = 0; v < VIEWS; v++) {
                    struct pel_geometry at = { zenith, views[v][0],
                                               views[v][1] };
                    struct pel_leaving l;
                    assert_int_equal(
                        pel_transport_leaving(&m, &at, PEL_ORDERS_TWO, &l),
                        PEL_OK);
                    compare(&w[0], two[v].part[PEL_WATER_SINGLE][c], l.single);
                    compare(&w[1], two[v].part[PEL_WATER_SECOND][c], l.second);
                    compare(&w[2], two[v].part[PEL_WATER_BOTTOM][c],
                            l.bottom_direct);
                    double sum = 0.0;
                    for (int p = 0; p < PEL_WATER_PARTS; p++) {
                        sum += every[v].part[p][c];
                    }
                    if (v % 5 == 0) { /* 30 ms each */
                        assert_int_equal(
                            pel_transport_leaving(&m, &at, PEL_ORDERS_ALL, &l),
                            PEL_OK);
                        compare(&w[3], sum, l.total);
                    }
                }
                share(w[0], &single);
                share(w[1], &second);
                share(w[2], &bottom);
                share(w[3], &all);
            }
        }
    }
    print_message("of the maximum: single 1/%.0f, second 1/%.0f, bottom "
                  "1/%.0f, all orders 1/%.0f\n",
                  1 / single, 1 / second, 1 / bottom, 1 / all);
    assert_true(single <= 1e-3 && second <= 1e-3 && bottom <= 1e-3 &&
                all <= 1e-3);
}

/* The paper's form: its single scattering by the reduced extinction, the rest
 * as with two orders. */
static void paper_is_eq_5(void **state)
{
    (void)state;
    double views[VIEWS][2];
    struct pel_water_parts paper[VIEWS], two[VIEWS], single[VIEWS];
    struct pel_water_body body = body_of(media[0], 10.0, 0.3);
    fill_views(views);
    look(&body, PEL_ORDERS_PAPER, 0.7, views, VIEWS, paper);
    look(&body, PEL_ORDERS_TWO, 0.7, views, VIEWS, two);
    look(&body, PEL_ORDERS_SINGLE, 0.7, views, VIEWS, single);
    for (int v = 0; v < VIEWS; v++) {
        for (int c = 0; c < 3; c++) {
            struct pel_medium m = pel_water_medium(&body, c);
            struct pel_geometry at = { 0.7, views[v][0], views[v][1] };
            double want = pel_transport_single(&m, &at, PEL_EXTINCTION_REDUCED);
            assert_true(fabs(paper[v].part[PEL_WATER_SINGLE][c] - want) <=
                        1e-3 * want);
            assert_true(paper[v].part[PEL_WATER_SECOND][c] ==
                        two[v].part[PEL_WATER_SECOND][c]);
            assert_true(paper[v].part[PEL_WATER_HIGHER][c] == 0.0);
            assert_true(single[v].part[PEL_WATER_SINGLE][c] ==
                        paper[v].part[PEL_WATER_SINGLE][c]);
            assert_true(single[v].part[PEL_WATER_SECOND][c] == 0.0);
        }
    }
}

/* Any legal water at any Sun: no part negative, the whole at most what a white
 * Lambertian surface would send of the light that enters; finite. */
static void light_is_kept(void **state)
{
    (void)state;
    uint64_t random = 7;
    double views[VIEWS][2];
    fill_views(views);
    for (int k = 0; k < 60; k++) {
        struct pel_water_body body = {
            .depth_m = exp(
                test_random(&random, log(PEL_DEPTH_MIN), log(PEL_DEPTH_MAX))),
        };
        for (int i = 0; i < 3; i++) {
            bool corner = test_random(&random, 0, 1) < 0.25;
            body.absorption[i] =
                corner ? PEL_ABSORPTION_MIN
                       : exp(test_random(&random, log(PEL_ABSORPTION_MIN),
                                         log(PEL_COEFFICIENT_MAX)));
            body.scattering[i] =
                k % 9 == 0 ? 0.0
                           : exp(test_random(&random, log(1e-4),
                                             log(PEL_COEFFICIENT_MAX)));
            body.asymmetry[i] =
                corner ? PEL_ASYMMETRY_MAX
                       : test_random(&random, 0.0, PEL_ASYMMETRY_MAX);
            body.albedo[i] = corner ? 1.0 : test_random(&random, 0.0, 1.0);
        }
        double sun = test_random(&random, 0.0, 0.5 * PEL_PI);
        struct pel_water_parts got[VIEWS];
        look(&body, (enum pel_water_orders)(k % PEL_ORDERS_COUNT), sun, views,
             VIEWS, got);
        struct pel_geometry at = { .sun_zenith_rad = sun };
        struct pel_interface f = pel_interface_at(&at);
        for (int i = 0; i < VIEWS * 3; i++) {
            double sum = 0.0;
            for (int p = 0; p < PEL_WATER_PARTS; p++) {
                double value = got[i / 3].part[p][i % 3];
                assert_true(isfinite(value) && value >= 0.0);
                sum += value;
            }
            /* The paper counts forward scattering twice. */
            if (k % PEL_ORDERS_COUNT < PEL_ORDERS_PAPER) {
                assert_true(sum <= 1.06 * f.beam * f.sun_mu / PEL_PI + 1e-9);
            }
        }
    }
}

/* The maps are a function of their scene, whatever was drawn before: the same
 * bits after another water, another Sun, other orders. */
static void nothing_is_remembered(void **state)
{
    (void)state;
    double views[VIEWS][2];
    struct pel_water_parts first[VIEWS], other[VIEWS], again[VIEWS];
    struct pel_water_body a = body_of(media[0], 10.0, 0.3);
    struct pel_water_body b = body_of(media[2], 300.0, 0.1);
    fill_views(views);
    look(&a, PEL_ORDERS_ALL, 0.7, views, VIEWS, first);
    look(&b, PEL_ORDERS_PAPER, 1.1, views, VIEWS, other);
    look(&a, PEL_ORDERS_SINGLE, 0.2, views, VIEWS, other);
    look(&a, PEL_ORDERS_ALL, 0.7, views, VIEWS, again);
    assert_memory_equal(first, again, sizeof first);
    assert_memory_not_equal(first, other, sizeof first);
}

/* A set of depths finds at its levels what a flat sea of that depth has, and
 * in between something in between. */
static void depths_are_levels(void **state)
{
    (void)state;
    const double views[1][2] = { { 0.5, 1.0 } };
    struct pel_water_body body = body_of(media[1], 10.0, 0.4);
    const struct pel_water_depths depths = { 5, 2.0, 32.0 };
    struct pel_fault fault;
    for (int i = 0; i < 5; i++) {
        struct pel_water_parts level, flat, between;
        double at_m = pel_water_depth(&depths, i);
        assert_int_equal(pel_water_prober_run(&prober, NULL, &body, &depths,
                                              at_m, PEL_ORDERS_ALL, 0.6, views,
                                              1, &level, &fault),
                         PEL_OK);
        assert_int_equal(pel_water_prober_run(&prober, NULL, &body, &depths,
                                              at_m * sqrt(2.0), PEL_ORDERS_ALL,
                                              0.6, views, 1, &between, &fault),
                         PEL_OK);
        body.depth_m = at_m;
        look(&body, PEL_ORDERS_ALL, 0.6, views, 1, &flat);
        for (int c = 0; c < 3; c++) {
            double a = level.part[PEL_WATER_BOTTOM][c];
            double b = flat.part[PEL_WATER_BOTTOM][c];
            assert_true(fabs(a - b) <= 1e-5 * b + 1e-9);
            double m = between.part[PEL_WATER_BOTTOM][c];
            assert_true(i == 4 ? m == a : m < a);
        }
    }
}

/* An overcast sky (CIE: three times as bright above as at the horizon), more
 * of it on the Sun's side. */
static double overcast(double elevation, double azimuth)
{
    return (1.0 + 2.0 * sin(elevation)) / 3.0 *
           (1.0 + 0.8 * cos(azimuth) * cos(elevation));
}

/* As shaders/lib/sky.glsl: sky_uv. */
static GLuint overcast_table(void)
{
    enum { WIDTH = 96, HEIGHT = 128, ROWS = HEIGHT / 2 };
    static GLfloat texels[HEIGHT][WIDTH][4];
    for (int y = ROWS; y < HEIGHT; y++) {
        double x = (double)(y - ROWS) / (ROWS - 1), e = 0.5 * PEL_PI * x * x;
        for (int i = 0; i < WIDTH; i++) {
            double u = (double)i / (WIDTH - 1);
            GLfloat v = (GLfloat)overcast(e, PEL_PI * u * u);
            for (int c = 0; c < 3; c++) {
                texels[y][i][c] = v;
            }
        }
    }
    GLuint table = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &table);
    glTextureStorage3D(table, 1, GL_RGBA32F, WIDTH, HEIGHT, PEL_LIGHTS);
    glTextureParameteri(table, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(table, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(table, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTextureSubImage3D(table, 0, 0, 0, 0, WIDTH, HEIGHT, 1, GL_RGBA, GL_FLOAT,
                        texels);
    return table;
}

/* The solver's own answer to that sky, above the surface. */
static void solve_sky(const struct pel_medium *m, const double (*views)[2],
                      double want[VIEWS])
{
    enum { SOLVER = PEL_ORDINATES_REFERENCE };
    struct pel_ordinates *o = pel_ordinates_create(SOLVER, 1e-7);
    double modes[2][SOLVER], mu[VIEWS], series[2 * SOLVER * VIEWS];
    for (int i = 0; i < SOLVER; i++) {
        double e = 0.5 * PEL_PI - pel_ordinates_sky_node(o, i);
        modes[0][i] = (1.0 + 2.0 * sin(e)) / 3.0;
        modes[1][i] = 0.8 * cos(e) * modes[0][i];
    }
    for (int v = 0; v < VIEWS; v++) {
        double sine = sin(views[v][0]) / PEL_WATER_INDEX;
        mu[v] = sqrt(1.0 - sine * sine);
    }
    const struct pel_ordinates_light light = { .sky = modes[0],
                                               .sky_modes = 2 };
    int count = 0;
    pel_ordinates_solve(o, m, &light, mu, VIEWS, series, &count, NULL);
    for (int v = 0; v < VIEWS; v++) {
        struct pel_geometry at = { 0.0, views[v][0], 0.0 };
        want[v] = 0.0;
        for (int i = 0; i < count; i++) {
            want[v] += series[i * VIEWS + v] * cos(i * views[v][1]);
        }
        want[v] *= pel_interface_at(&at).leaving;
    }
    pel_ordinates_destroy(o);
}

/* The sky lights the water from where it is bright: ≤ 1/255 of the maximum
 * over the views (the 32 rows and columns it is summed over leave 1/500). */
static void sky_is_the_solvers(void **state)
{
    (void)state;
    double views[VIEWS][2], want[VIEWS], worst = 0.0;
    fill_views(views);
    GLuint unit = prober.unit, black = prober.black;
    const struct pel_block_light dark = { .incident = { 0 } };
    prober.black = overcast_table();
    glCreateBuffers(1, &prober.unit);
    glNamedBufferStorage(prober.unit, sizeof dark, &dark, 0);
    for (int k = 0; k < 6; k++) {
        struct pel_water_body body =
            body_of(media[k % 3], k < 3 ? 8.0 : 200.0, k < 3 ? 0.3 : 0.0);
        struct pel_water_parts got[VIEWS];
        look(&body, PEL_ORDERS_ALL, 1.2, views, VIEWS, got);
        for (int c = 0; c < 3; c++) {
            struct pel_medium m = pel_water_medium(&body, c);
            struct worst w = { 0 };
            solve_sky(&m, views, want);
            for (int v = 0; v < VIEWS; v++) {
                double sum = 0.0;
                for (int p = 0; p < PEL_WATER_PARTS; p++) {
                    sum += got[v].part[p][c];
                }
                compare(&w, sum, want[v]);
            }
            share(w, &worst);
        }
    }
    glDeleteTextures(1, &prober.black);
    glDeleteBuffers(1, &prober.unit);
    prober.unit = unit;
    prober.black = black;
    print_message("an overcast sky: 1/%.0f of the maximum\n", 1.0 / worst);
    assert_true(worst <= 1.0 / 255.0);
}

static enum pel_err no_memory(const struct pel_water_body *body,
                              const struct pel_water_depths *depths,
                              enum pel_water_orders orders,
                              struct pel_water_kernel *out)
{
    (void)body, (void)depths, (void)orders, (void)out;
    return PEL_ERR_NO_MEMORY;
}

/* Without memory for a new water pictures keep the last one, whole, and the new
 * one comes as soon as there is some: a failure is not kept as black water. */
static void a_failure_is_not_kept(void **state)
{
    (void)state;
    struct pel_water_light *w = &prober.light;
    struct pel_environment clear = { .water = body_of(media[0], 20.0, 0.3) };
    struct pel_environment murky = { .water = body_of(media[1], 4.0, 0.1) };
    struct pel_environment asked = murky;
    assert_int_equal(pel_water_light_update(w, &clear), PEL_OK);
    uint64_t version = w->version;
    w->build = no_memory;
    for (int i = 0; i < 3; i++) {
        asked = murky;
        assert_int_equal(pel_water_light_update(w, &asked), PEL_OK);
        assert_memory_equal(&asked.water, &clear.water, sizeof clear.water);
        assert_int_equal(asked.depths.levels, 1);
        assert_true(w->failed && w->version == version);
    }
    /* One depth is none for a height field. */
    asked = murky;
    asked.seabed = (const struct pel_seabed *)w;
    asked.depths = (struct pel_water_depths){ 4, 1.0, 8.0 };
    assert_int_equal(pel_water_light_update(w, &asked), PEL_ERR_NO_MEMORY);
    w->build = pel_water_kernel_build;
    asked = murky;
    assert_int_equal(pel_water_light_update(w, &asked), PEL_OK);
    assert_memory_equal(&asked.water, &murky.water, sizeof murky.water);
    assert_true(!w->failed && w->version == version + 1);
}

static int64_t cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static int builds;

static enum pel_err counted(const struct pel_water_body *body,
                            const struct pel_water_depths *depths,
                            enum pel_water_orders orders,
                            struct pel_water_kernel *out)
{
    builds++;
    return pel_water_kernel_build(body, depths, orders, out);
}

/* A new water is built once, a new light or the same water again not at all;
 * and what both cost is said. */
static void only_a_new_water_is_built(void **state)
{
    (void)state;
    enum { ROUNDS = 10 };
    struct pel_light lights[PEL_LIGHTS];
    struct pel_water_light *w = &prober.light;
    struct pel_environment env = { .water = body_of(media[1], 10.0, 0.4) };
    double water_ms = 0, sun_ms = 0, water_cpu = 0, sun_cpu = 0;
    w->build = counted;
    builds = 0;
    uint64_t before = w->version;
    for (int i = 0; i < ROUNDS; i++) {
        env.water.depth_m = 10.0 + i;
        glFinish();
        int64_t start = pel_now_ns(), cpu = cpu_ns();
        assert_int_equal(pel_water_light_update(w, &env), PEL_OK);
        glFinish();
        int64_t middle = pel_now_ns(), used = cpu_ns();
        const struct pel_vec3 to = { 0, 0, 0.5 + 0.01 * i };
        pel_lights_of_sun(to, lights);
        pel_water_light_map(w, lights, 1, NULL, prober.black, prober.unit);
        glFinish();
        water_ms += 1e-6 * (double)(middle - start) / ROUNDS;
        sun_ms += 1e-6 * (double)(pel_now_ns() - middle) / ROUNDS;
        water_cpu += 1e-6 * (double)(used - cpu) / ROUNDS;
        sun_cpu += 1e-6 * (double)(cpu_ns() - used) / ROUNDS;
        assert_int_equal(pel_water_light_update(w, &env), PEL_OK);
        assert_int_equal(builds, i + 1);
        assert_int_equal(w->version, before + (uint64_t)i + 1);
    }
    env.orders = PEL_ORDERS_TWO;
    assert_int_equal(pel_water_light_update(w, &env), PEL_OK);
    assert_int_equal(builds, ROUNDS + 1);
    w->build = pel_water_kernel_build;
    print_message("a new water %.1f ms (%.1f ms of processor), a new Sun %.2f "
                  "ms (%.2f)\n",
                  water_ms, water_cpu, sun_ms, sun_cpu);
}

enum { TEXELS = 64 * 64 };

static void read_map(const struct pel_water_waves *waves,
                     const struct pel_light *lights, float out[TEXELS][4])
{
    struct pel_water_light *w = &prober.light;
    glBindBufferBase(GL_UNIFORM_BUFFER, PEL_BLOCK_LIGHT, prober.unit);
    pel_water_light_map(w, lights, 1, waves, prober.black, prober.unit);
    glGetTextureSubImage(w->map, 0, 0, 0, 0, 64, 64, 1, GL_RGBA, GL_FLOAT,
                         (GLsizei)(sizeof **out * 4 * TEXELS), out);
}

/* A Sun 10° high: some 16 % more than through a level sea, from all over. */
static void waves_let_low_light_in(void **state)
{
    (void)state;
    static float level[TEXELS][4], rough[TEXELS][4];
    const struct pel_vec3 to = { cos(10 * PEL_DEG), 0, sin(10 * PEL_DEG) };
    const struct pel_water_waves waves = { 0.02, 0.02, 1.0 };
    struct pel_environment env = { .water = body_of(media[1], 10.0, 0.4) };
    struct pel_light lights[PEL_LIGHTS];
    assert_int_equal(pel_water_light_update(&prober.light, &env), PEL_OK);
    pel_lights_of_sun(to, lights);
    read_map(NULL, lights, level);
    double beam = prober.light.beams[PEL_LIGHT_SUN];
    read_map(&waves, lights, rough);
    double more = prober.light.beams[PEL_LIGHT_SUN] / beam;
    assert_near(more, 1.16, 0.02);
    double lit = 0.0;
    for (int i = 0; i < TEXELS; i++) {
        for (int c = 0; c < 3; c++) {
            double want = more * (double)level[i][c];
            assert_near(rough[i][c], want, 1e-5 * want);
            lit += want;
        }
    }
    assert_true(lit > 0.0);
}

int main(void)
{
    struct pel_context context;
    struct pel_fault fault;
    if (pel_context_init(&context, test_device(), true, &fault)) {
        fprintf(stderr, "%s\n", fault.message);
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_are_the_quadrature),
        cmocka_unit_test(paper_is_eq_5),
        cmocka_unit_test(light_is_kept),
        cmocka_unit_test(depths_are_levels),
        cmocka_unit_test(nothing_is_remembered),
        cmocka_unit_test(sky_is_the_solvers),
        cmocka_unit_test(a_failure_is_not_kept),
        cmocka_unit_test(only_a_new_water_is_built),
        cmocka_unit_test(waves_let_low_light_in),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    pel_water_prober_finish(&prober);
    pel_context_finish(&context);
    return failed;
}
