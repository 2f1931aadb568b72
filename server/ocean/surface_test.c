#include <string.h>

#include "base/near.h"
#include "ocean/wander.h"

static struct pel_sea sea;

static double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static struct pel_sea_desc windy(double wind_mps, uint32_t seed)
{
    return (struct pel_sea_desc){
        .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
        .wind_mps = wind_mps,
        .direction_rad = -2.5,
        .fetch_m = 2e5,
        .gamma = 3.3,
        .seed = seed,
        .wave_count = 60,
    };
}

/* Calm to hurricane, a young steep sea, and swell no ocean has seen. */
static struct pel_sea_desc legal_sea(int i)
{
    static const double winds[] = { 3, 12, 30, 30, 0, 0, 15, 30 };
    struct pel_sea_desc d = windy(winds[i], (uint32_t)i);
    switch (i) {
    case 3:
        d.kind = PEL_SPECTRUM_JONSWAP;
        d.fetch_m = 1000;
        d.gamma = 7;
        break;
    case 4:
        d.swell_count = 1;
        d.swell[0] = (struct pel_swell_desc){ 4, 10, 0, 0.2 };
        break;
    case 5:
    case 6:
        d.swell_count = 1;
        d.swell[0] = (struct pel_swell_desc){ 15, 3, 0, 0.02 };
        break;
    case 7:
        d.swell_count = PEL_SEA_MAX_SWELLS;
        for (int j = 0; j < PEL_SEA_MAX_SWELLS; j++) {
            d.swell[j] = (struct pel_swell_desc){ 15, 3 + j, j, 1 };
        }
        break;
    default:
        break;
    }
    return d;
}
#define LEGAL_SEAS 8

static void build(struct pel_sea_desc d)
{
    assert_int_equal(pel_sea_build(&d, &sea), PEL_OK);
}

/* eq. 2 with one wave: the particle of rest position 0 at its crest, and a
 * quarter period later in front of it, h forward and at rest height. */
static void test_one_trochoid(void **state)
{
    (void)state;
    memset(&sea, 0, sizeof sea);
    double k = 0.4, h = 0.9, omega = sqrt(PEL_GRAVITY * k);
    sea.count = 1;
    sea.waves[0] =
        (struct pel_wave){ .ky = k, .amplitude = h, .omega = omega, .chop = 1 };
    struct pel_vec3 d = pel_sea_displace(&sea, 5, 0, 0);
    assert_near(d.y, 0, 1e-12);
    assert_near(d.z, h, 1e-12);
    d = pel_sea_displace(&sea, 5, 0, 0.5 * PEL_PI / omega);
    assert_near(d.y, h, 1e-12);
    assert_near(d.z, 0, 1e-12);

    /* Gerstner's wave travels unchanged at ω/k. */
    struct pel_surface_sample a, b;
    for (double y = 0; y < 15; y += 0.7) {
        pel_sea_sample(&sea, 0, y, 3, &a);
        pel_sea_sample(&sea, 0, y + omega / k * 2.5, 5.5, &b);
        assert_near(a.height_m, b.height_m, 1e-6);
        assert_near(a.normal.y, b.normal.y, 1e-5);
        assert_near(a.velocity_mps.y, b.velocity_mps.y, 1e-5);
    }
}

/* The surface above where a particle went has that particle's height: the
 * inverse is met to 1 µm, so with slopes below 30 the height is to 0.1 mm. */
static void test_inverse(void **state)
{
    (void)state;
    for (int s = 0; s < LEGAL_SEAS; s++) {
        build(legal_sea(s));
        uint64_t rng = (uint64_t)s;
        double worst = 0;
        for (int i = 0; i < 3000; i++) {
            double x = 2e4 * (uniform(&rng) - 0.5);
            double y = 2e4 * (uniform(&rng) - 0.5), t = 1e4 * uniform(&rng);
            struct pel_vec3 d = pel_sea_displace(&sea, x, y, t);
            struct pel_surface_sample p;
            pel_sea_sample(&sea, x + d.x, y + d.y, t, &p);
            worst = fmax(worst, fabs(p.height_m - d.z));
        }
        print_message("sea %d: height met within %.1e m\n", s, worst);
        assert_true(worst < 1e-4);
    }
}

/* The lanes' sines against the C library's: waves that shift nothing, so that
 * heights compare exactly. Far away the phase itself is rounded, to
 * 4.4e8 · 2^-53 = 5e-8 rad. */
static void test_sines(void **state)
{
    (void)state;
    build(windy(10, 4));
    for (int i = 0; i < sea.count; i++) {
        sea.waves[i].chop = 0;
    }
    uint64_t rng = 8;
    double near = 0, far = 0;
    for (int i = 0; i < 20000; i++) {
        double reach = i % 2 ? 1e6 : 100;
        double x = reach * (2 * uniform(&rng) - 1);
        double y = reach * (2 * uniform(&rng) - 1);
        struct pel_surface_sample p;
        pel_sea_sample(&sea, x, y, 10, &p);
        double e = fabs(p.height_m - pel_sea_displace(&sea, x, y, 10).z);
        near = i % 2 ? near : fmax(near, e);
        far = i % 2 ? fmax(far, e) : far;
    }
    print_message("heights: %.1e m near, %.1e m at 1000 km\n", near, far);
    assert_true(near < 1e-11);
    assert_true(far < 5e-8 * sea.max_height_m);
}

static void test_far_away(void **state)
{
    (void)state;
    build(windy(20, 9));
    double x = 1e6, y = -1e6, t = 1e9; /* the schema's bounds */
    struct pel_vec3 d = pel_sea_displace(&sea, x, y, t);
    struct pel_surface_sample p;
    pel_sea_sample(&sea, x + d.x, y + d.y, t, &p);
    assert_near(p.height_m, d.z, 1e-4);
}

static void test_normal(void **state)
{
    (void)state;
    const double e = 3e-4; /* metres: 1 % of a radian of the shortest wave */
    for (int s = 0; s < 3; s++) {
        build(legal_sea(s));
        uint64_t rng = 5;
        for (int i = 0; i < 300; i++) {
            double x = 1e3 * uniform(&rng), y = 1e3 * uniform(&rng);
            struct pel_surface_sample p, q[4];
            pel_sea_sample(&sea, x, y, 7, &p);
            pel_sea_sample(&sea, x - e, y, 7, &q[0]);
            pel_sea_sample(&sea, x + e, y, 7, &q[1]);
            pel_sea_sample(&sea, x, y - e, 7, &q[2]);
            pel_sea_sample(&sea, x, y + e, 7, &q[3]);
            double zx = (q[1].height_m - q[0].height_m) / (2 * e);
            double zy = (q[3].height_m - q[2].height_m) / (2 * e);
            double length = sqrt(1 + zx * zx + zy * zy);
            assert_near(p.normal.x, -zx / length, 2e-3);
            assert_near(p.normal.y, -zy / length, 2e-3);
            assert_near(p.normal.z, 1 / length, 2e-3);
        }
    }
}

/* Velocity at a place is that of the particle now there. */
static void test_velocity(void **state)
{
    (void)state;
    const double e = 1e-4;
    for (int s = 0; s < LEGAL_SEAS; s++) {
        build(legal_sea(s));
        uint64_t rng = 5;
        for (int i = 0; i < 300; i++) {
            double x = 1e3 * uniform(&rng), y = 1e3 * uniform(&rng);
            struct pel_vec3 d = pel_sea_displace(&sea, x, y, 7);
            struct pel_vec3 before = pel_sea_displace(&sea, x, y, 7 - e);
            struct pel_vec3 after = pel_sea_displace(&sea, x, y, 7 + e);
            struct pel_surface_sample p;
            pel_sea_sample(&sea, x + d.x, y + d.y, 7, &p);
            double tolerance = 1e-3 + 1e-4 * sea.max_height_m;
            assert_near(p.velocity_mps.x, (after.x - before.x) / (2 * e),
                        tolerance);
            assert_near(p.velocity_mps.y, (after.y - before.y) / (2 * e),
                        tolerance);
            assert_near(p.velocity_mps.z, (after.z - before.z) / (2 * e),
                        tolerance);
        }
    }
}

/* Velocity of the particle that rests at (x, y). */
static struct pel_vec3 velocity_of(double x, double y, double t)
{
    struct pel_vec3 d = pel_sea_displace(&sea, x, y, t);
    struct pel_surface_sample p;
    pel_sea_sample(&sea, x + d.x, y + d.y, t, &p);
    return p.velocity_mps;
}

static void test_acceleration(void **state)
{
    (void)state;
    const double e = 1e-3;
    for (int s = 0; s < LEGAL_SEAS; s++) {
        build(legal_sea(s));
        uint64_t rng = 5;
        for (int i = 0; i < 100; i++) {
            double x = 1e3 * uniform(&rng), y = 1e3 * uniform(&rng);
            struct pel_vec3 d = pel_sea_displace(&sea, x, y, 7);
            struct pel_vec3 before = velocity_of(x, y, 7 - e);
            struct pel_vec3 after = velocity_of(x, y, 7 + e);
            struct pel_vec2 place = { x + d.x, y + d.y };
            struct pel_surface_sample p, plain;
            pel_sea_query_moving(&sea, &place, 1, 7, &p);
            pel_sea_sample(&sea, place.x, place.y, 7, &plain);
            assert_true(isnan(plain.acceleration_mps2.x));
            assert_near(p.height_m, plain.height_m, 0);
            /* The third derivative of ripples over e², and 1e-7 m of the place
             * where waves are steep. */
            double tolerance = 1e-2 + 1e-3 * sea.max_height_m;
            assert_near(p.acceleration_mps2.x, (after.x - before.x) / (2 * e),
                        tolerance);
            assert_near(p.acceleration_mps2.y, (after.y - before.y) / (2 * e),
                        tolerance);
            assert_near(p.acceleration_mps2.z, (after.z - before.z) / (2 * e),
                        tolerance);
        }
    }
}

/* Least stretch of any direction by x → x + D(x), the least eigenvalue of the
 * symmetric part of its derivative: the surface folds nowhere if it is
 * positive everywhere. */
static double least_stretch(double x, double y, double t)
{
    double a = 1, b = 0, c = 0, d = 1;
    for (int i = 0; i < sea.count; i++) {
        const struct pel_wave *w = &sea.waves[i];
        struct pel_wave_phase p = pel_wave_at(w, x, y, t);
        double f = w->chop * w->amplitude * cos(p.phase) / hypot(w->kx, w->ky);
        a -= f * w->kx * p.kx;
        b -= f * w->kx * p.ky;
        c -= f * w->ky * p.kx;
        d -= f * w->ky * p.ky;
    }
    return 0.5 * (a + d) - sqrt(0.25 * ((a - d) * (a - d) + (b + c) * (b + c)));
}

static void test_no_self_intersection(void **state)
{
    (void)state;
    for (int s = 0; s < LEGAL_SEAS; s++) {
        build(legal_sea(s));
        uint64_t rng = (uint64_t)s;
        double least = 1;
        for (int i = 0; i < 200000; i++) {
            double x = 1e5 * uniform(&rng), y = 1e5 * uniform(&rng);
            least = fmin(least, least_stretch(x, y, 1e5 * uniform(&rng)));
        }
        double chop = 1;
        for (int i = 0; i < sea.count; i++) {
            chop = fmin(chop, sea.waves[i].chop);
        }
        print_message("sea %d: least stretch %.3f, least chop %.3f\n", s, least,
                      chop);
        assert_true(least > 0);
        assert_near(sea.waves[0].chop, 1, s < 5 ? 1e-12 : 1);
    }
}

/* Appendix A, with the chop: numeric mean of squared slope of one wave. */
static void test_trochoid_slope_variance(void **state)
{
    (void)state;
    const double chops[] = { 1, 0.6, 0.05 };
    for (int i = 0; i < 3; i++) {
        double kh = 0.7, c = chops[i], sum = 0;
        const int n = 1000; /* spectrally exact on a period */
        for (int j = 0; j < n; j++) {
            double p = 2 * PEL_PI * (j + 0.5) / n;
            sum += kh * kh * sin(p) * sin(p) / (1 - c * kh * cos(p)) / n;
        }
        double formula = kh * kh / (1 + sqrt(1 - c * c * kh * kh));
        assert_near(sum, formula, 1e-12);
        if (i == 0) {
            assert_near(sum, 1 - sqrt(1 - kh * kh), 1e-12);
        }
    }
}

/* eq. 4's totals, and what the surface itself shows. The sum of trochoids
 * sharpens the crests of short waves on long ones, which eq. 4 leaves out:
 * 10 % is allowed for that and for 40,000 samples (1 %). */
static void test_slope_variance(void **state)
{
    (void)state;
    for (double wind = 5; wind <= 20; wind += 5) {
        build(windy(wind, 2));
        double c = cos(sea.desc.direction_rad), s = sin(sea.desc.direction_rad);
        double along = 0, cross = 0, covariance = 0;
        for (int i = 0; i < sea.count; i++) {
            const struct pel_wave *w = &sea.waves[i];
            double k = hypot(w->kx, w->ky), ck = w->chop * k * w->amplitude;
            double v =
                ck > 0 ? (1 - sqrt(1 - ck * ck)) / (w->chop * w->chop) : 0;
            /* Simpson's rule over what it wanders over. */
            for (int n = -1; n <= 1; n++) {
                double kx = w->kx + n * w->swing * w->wander_x;
                double ky = w->ky + n * w->swing * w->wander_y;
                double u = (kx * c + ky * s) / k;
                double q = (ky * c - kx * s) / k;
                double weight = (n == 0 ? 4.0 : 1.0) / 6.0 * v;
                along += u * u * weight;
                cross += q * q * weight;
                covariance += u * q * weight;
            }
        }
        assert_near(sea.slope_variance_along, along, 1e-9);
        assert_near(sea.slope_variance_cross, cross, 1e-9);
        assert_near(sea.slope_covariance, covariance, 1e-9);

        uint64_t rng = 3;
        double seen_along = 0, seen_cross = 0;
        const int n = 40000;
        for (int i = 0; i < n; i++) {
            struct pel_surface_sample p;
            pel_sea_sample(&sea, 1e5 * uniform(&rng), 1e5 * uniform(&rng),
                           1e5 * uniform(&rng), &p);
            double zx = -p.normal.x / p.normal.z, zy = -p.normal.y / p.normal.z;
            seen_along += (zx * c + zy * s) * (zx * c + zy * s) / n;
            seen_cross += (zy * c - zx * s) * (zy * c - zx * s) / n;
        }
        print_message("wind %2.0f: slope variance along %.4f (seen %.4f), "
                      "cross %.4f (%.4f); Cox-Munk %.4f, %.4f\n",
                      wind, along, seen_along, cross, seen_cross,
                      0.00316 * wind, 0.003 + 0.00192 * wind);
        assert_near(seen_along, along, 0.1 * along);
        assert_near(seen_cross, cross, 0.1 * cross);
        assert_true(along > 1.2 * cross && along < 2 * cross);
        assert_true(fabs(covariance) < 0.1 * cross);
    }
}

static void test_query(void **state)
{
    (void)state;
    build(windy(11, 2));
    enum { N = 7 };
    struct pel_vec2 points[N];
    struct pel_surface_sample many[N], one;
    for (int i = 0; i < N; i++) {
        points[i] = (struct pel_vec2){ 13.7 * i, -5.1 * i * i };
    }
    pel_sea_query(&sea, points, N, 4.5, many);
    for (int i = 0; i < N; i++) {
        pel_sea_sample(&sea, points[i].x, points[i].y, 4.5, &one);
        assert_memory_equal(&one, &many[i], sizeof one);
    }
    pel_sea_query(&sea, points, 0, 4.5, many);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_trochoid),
        cmocka_unit_test(test_inverse),
        cmocka_unit_test(test_sines),
        cmocka_unit_test(test_far_away),
        cmocka_unit_test(test_normal),
        cmocka_unit_test(test_velocity),
        cmocka_unit_test(test_acceleration),
        cmocka_unit_test(test_no_self_intersection),
        cmocka_unit_test(test_trochoid_slope_variance),
        cmocka_unit_test(test_slope_variance),
        cmocka_unit_test(test_query),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
