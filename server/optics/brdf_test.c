#include "optics/brdf.h"

#include "base/near.h"

static struct pel_vec3 direction(double theta, double phi)
{
    return (struct pel_vec3){ sin(theta) * cos(phi), sin(theta) * sin(phi),
                              cos(theta) };
}

/* Variances of seas: calm, moderate, rough, and two with the wind across. */
static const double seas[][2] = {
    { 0.001, 0.0007 }, { 0.02, 0.012 }, { 0.06, 0.03 },
    { 0.005, 0.02 },   { 0.2, 0.01 },
};
#define SEAS (sizeof seas / sizeof seas[0])
#define N 1.3413 /* of sea water, 550 nm */

/* What a reflection of exact Fresnel has in place of Schlick's. */
static double mended(struct pel_vec3 v, struct pel_vec3 l)
{
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(v, l));
    double vh = pel_vec3_dot(v, h);
    return pel_fresnel_exact(vh, N) / pel_fresnel_schlick(vh, PEL_WATER_INDEX);
}

static void test_fresnel(void **state)
{
    (void)state;
    /* Textbook values for glass, n = 1.5 (Hecht, Optics, fig. 4.41). */
    assert_near(pel_fresnel_exact(1, 1.5), 0.04, 1e-12);
    assert_near(pel_fresnel_exact(cos(45 * PEL_DEG), 1.5), 0.0502, 5e-5);
    assert_near(pel_fresnel_exact(0, 1.5), 1, 1e-12);
    /* At Brewster's angle only s remains: ½ ((1 − n²) / (1 + n²))². */
    double n = PEL_WATER_INDEX;
    double s = (1 - n * n) / (1 + n * n);
    assert_near(pel_fresnel_exact(cos(atan(n)), n), 0.5 * s * s, 1e-12);
    assert_near(pel_fresnel_exact(1, n), 0.34 * 0.34 / (2.34 * 2.34), 1e-12);
}

static void test_schlick(void **state)
{
    (void)state;
    double worst = 0;
    for (double t = 0; t <= 90; t += 0.5) {
        double c = cos(t * PEL_DEG);
        double e = pel_fresnel_schlick(c, PEL_WATER_INDEX) -
                   pel_fresnel_exact(c, PEL_WATER_INDEX);
        worst = fmax(worst, fabs(e));
    }
    print_message("Schlick against Fresnel: at most %.4f\n", worst);
    assert_true(worst < 0.06); /* exponent 5 for water, worst near 85 deg */
    assert_near(pel_fresnel_schlick(0, PEL_WATER_INDEX), 1, 1e-12);
    assert_near(pel_fresnel_schlick(1, PEL_WATER_INDEX),
                pel_fresnel_exact(1, PEL_WATER_INDEX), 1e-12);
}

/* eq. 7: normalised, with the variances it names. */
static void test_slope_density(void **state)
{
    (void)state;
    const int n = 400;
    double sum = 0, xx = 0, yy = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double x = 2 * ((i + 0.5) / n - 0.5), y = 2 * ((j + 0.5) / n - 0.5);
            double p = pel_ross_slope_density(x, y, 0.01, 0.02) * 4 / n / n;
            sum += p;
            xx += p * x * x;
            yy += p * y * y;
        }
    }
    assert_near(sum, 1, 1e-9);
    assert_near(xx, 0.01, 1e-9);
    assert_near(yy, 0.02, 1e-9);
}

/* eq. 8 for a = 1, from erfc(1) = 0.157299207050285. */
static void test_lambda(void **state)
{
    (void)state;
    double expected =
        (exp(-1) - sqrt(PEL_PI) * 0.157299207050285) / (2 * sqrt(PEL_PI));
    assert_near(pel_ross_lambda(1), expected, 1e-13);
    assert_true(pel_ross_lambda(INFINITY) == 0);
    assert_true(pel_ross_lambda(5.9) >= 0 && pel_ross_lambda(5.9) < 1e-16);
    /* Small a: 1 / (2 a √π) − ½. */
    assert_near(pel_ross_lambda(1e-6) * 2e-6 * sqrt(PEL_PI), 1, 2e-6);
}

static void test_a(void **state)
{
    (void)state;
    double theta = 1.1, phi = 0.4, vx = 0.03, vy = 0.01;
    double s2 = vx * cos(phi) * cos(phi) + vy * sin(phi) * sin(phi);
    assert_near(pel_ross_a(direction(theta, phi), vx, vy),
                1 / (sqrt(2 * s2) * tan(theta)), 1e-12);
    assert_true(isinf(pel_ross_a(direction(0, 0), vx, vy)));
}

/* ∫ f p over slopes in units of σ, midpoint rule over ±8. */
static double over_slopes(struct pel_vec3 v, double vx, double vy,
                          double (*f)(struct pel_vec3 v, double zx, double zy))
{
    const int n = 400;
    double sx = sqrt(vx), sy = sqrt(vy), sum = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double zx = sx * 16 * ((i + 0.5) / n - 0.5);
            double zy = sy * 16 * ((j + 0.5) / n - 0.5);
            sum += pel_ross_visible_density(zx, zy, v, vx, vy) * f(v, zx, zy);
        }
    }
    return sum * sx * sy * 256 / n / n;
}

static double one(struct pel_vec3 v, double zx, double zy)
{
    (void)v;
    (void)zx;
    (void)zy;
    return 1;
}

/* eq. 11. The edge of max(v·f, 0) costs the midpoint rule about n⁻². */
static void test_visible_density(void **state)
{
    (void)state;
    const double thetas[] = { 0, 0.5, 1, 1.2, 1.35, 1.45 };
    double worst = 0;
    for (size_t s = 0; s < SEAS; s++) {
        for (int t = 0; t < 6; t++) {
            struct pel_vec3 v = direction(thetas[t], 0.7 * t);
            double e = over_slopes(v, seas[s][0], seas[s][1], one) - 1;
            worst = fmax(worst, fabs(e));
        }
    }
    print_message("eq. 11 holds within %.1e\n", worst);
    assert_true(worst < 1e-4);
}

static double schlick_facet(struct pel_vec3 v, double zx, double zy)
{
    double vh = (v.z - v.x * zx - v.y * zy) / sqrt(1 + zx * zx + zy * zy);
    return pel_fresnel_schlick(vh, PEL_WATER_INDEX);
}

/* The fit of eq. 26 against eq. 24, over σ_v up to 0.45 as in fig. 7. The
 * tolerance is that of the fit itself, as the paper's figure shows it: a few
 * hundredths, the most at grazing views of rough seas. */
static void test_mean_fresnel(void **state)
{
    (void)state;
    double worst = 0, square = 0;
    int count = 0;
    for (size_t s = 0; s < SEAS; s++) {
        for (double theta = 0; theta < 1.5; theta += 0.29) {
            struct pel_vec3 v = direction(theta, 0.5);
            double fit = pel_ross_mean_fresnel(v, seas[s][0], seas[s][1]);
            double e =
                fit - over_slopes(v, seas[s][0], seas[s][1], schlick_facet);
            worst = fmax(worst, fabs(e));
            square += e * e;
            count++;
        }
    }
    print_message("eq. 26 against eq. 24: rms %.4f, at most %.4f\n",
                  sqrt(square / count), worst);
    assert_true(worst < 0.05);
    assert_true(sqrt(square / count) < 0.02);
    /* eq. 26 written out, the wind across the view. */
    double sigma = sqrt(0.012), r = 0.34 * 0.34 / (2.34 * 2.34);
    assert_near(
        pel_ross_mean_fresnel(direction(1.2, 0.5 * PEL_PI), 0.02, 0.012),
        r + (1 - r) * pow(1 - cos(1.2), 5 * exp(-2.69 * sigma)) /
                (1 + 22.7 * sigma * sqrt(sigma)),
        1e-12);
    /* σ → 0 gives Schlick back; along the normal φ does not matter. */
    struct pel_vec3 v = direction(1.3, 0.2);
    assert_near(pel_ross_mean_fresnel(v, 1e-12, 1e-12),
                pel_fresnel_schlick(v.z, PEL_WATER_INDEX), 1e-5);
    assert_true(isfinite(pel_ross_mean_fresnel(direction(0, 0), 0.02, 0.01)));
}

static double exact_facet(struct pel_vec3 v, double zx, double zy)
{
    double vh = (v.z - v.x * zx - v.y * zy) / sqrt(1 + zx * zx + zy * zy);
    return pel_fresnel_exact(vh, N);
}

/* eq. 24 with Fresnel's equations, against a grid that is six times finer. */
static void test_effective_reflectance(void **state)
{
    (void)state;
    double worst = 0;
    for (size_t s = 0; s < SEAS; s++) {
        for (double theta = 0; theta < 1.56; theta += 0.17) {
            struct pel_vec3 v = direction(theta, 0.5);
            double got = pel_mean_fresnel(v, seas[s][0], seas[s][1], N);
            double want = over_slopes(v, seas[s][0], seas[s][1], exact_facet);
            worst = fmax(worst, fabs(got / want - 1));
        }
    }
    print_message("eq. 24 with Fresnel's equations: within %.1e\n", worst);
    assert_true(worst < 1e-3);
}

static void test_reciprocity(void **state)
{
    (void)state;
    for (size_t s = 0; s < SEAS; s++) {
        for (int i = 0; i < 8; i++) {
            struct pel_vec3 v = direction(0.2 * i, 0.9 * i);
            struct pel_vec3 l = direction(1.5 - 0.15 * i, 2.1 * i);
            double a = pel_ross_brdf(v, l, seas[s][0], seas[s][1]);
            double b = pel_ross_brdf(l, v, seas[s][0], seas[s][1]);
            assert_near(a, b, 1e-12 * a + 1e-300);
        }
    }
}

/* eq. 13 from its parts, with eq. 5 written out. */
static void test_brdf(void **state)
{
    (void)state;
    double vx = 0.03, vy = 0.015;
    struct pel_vec3 v = direction(1.0, 0.3), l = direction(0.7, 2.8);
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(v, l));
    double vh = pel_vec3_dot(v, h);
    double lv = pel_ross_lambda(pel_ross_a(v, vx, vy));
    double ll = pel_ross_lambda(pel_ross_a(l, vx, vy));
    double q = pel_ross_slope_density(-h.x / h.z, -h.y / h.z, vx, vy) * vh /
               ((1 + lv + ll) * h.z * v.z);
    double expected = q * pel_fresnel_schlick(vh, PEL_WATER_INDEX) /
                      (4 * h.z * h.z * h.z * l.z * vh);
    assert_near(pel_ross_brdf(v, l, vx, vy), expected, 1e-12 * expected);
    /* eq. 15 is eq. 13 times cos θ_l, with clamped variances. */
    assert_near(pel_ross_sun(v, l, vx, vy, 0.02),
                pel_ross_brdf(v, l, vx, 0.02) * l.z, 1e-12);
    assert_true(pel_ross_brdf(v, direction(1.6, 0), vx, vy) == 0);
    assert_true(pel_ross_brdf(direction(1.6, 0), l, vx, vy) == 0);
}

/* Part of the light that facets seen from low mirror meets other waves, more
 * of what leaves low, and none that leaves high. */
static void test_escape(void **state)
{
    (void)state;
    assert_true(pel_escape(-0.1, 1) == 0);
    assert_near(pel_escape(6, 0), 1, 1e-6);
    double odds = 7.5 / (1.93 * 1.93) * pel_ross_lambda(0.5 / sqrt(2));
    assert_near(pel_escape(0.5, 1), 1 / (1 + odds), 1e-12);
    assert_true(pel_escape(0.5, 0.2) < pel_escape(0.5, 1));
}

/* As it is drawn: eq. 15 of a facet that is steeper and less scattered by the
 * fit, whose light escapes, and no different straight down; a disc widens the
 * density alone. */
static void test_glitter(void **state)
{
    (void)state;
    double vx = 0.03, vy = 0.015, disc = 1e-3;
    struct pel_vec3 v = direction(1.45, 0.0), l = direction(1.3, PEL_PI);
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(v, l));
    double s = sqrt(vx), mu = v.z / (v.x * s);
    double steeper = 0.21 / (1 + 1.78 * mu * mu);
    double narrower = 0.05 / (1 + mu * mu / 4);
    double z = h.x / h.z / s;
    /* (μ + y) p(y) √(1 + narrower) in place of (μ + z) p(z). */
    double y = z - steeper;
    double ratio = (mu + y) / (mu + z) * (1 + 0.5 * narrower) *
                   exp(-0.5 * (y * y * (1 + narrower) - z * z));
    double lv = pel_ross_lambda(pel_ross_a(v, vx, vy));
    double ll = pel_ross_lambda(pel_ross_a(l, vx, vy));
    ratio *= (1 + lv + ll) / (1 + lv) *
             pel_escape(sqrt(2) * pel_ross_a(l, vx, vy), mu);
    assert_true(fabs(ratio - 1) > 0.02);
    double want = ratio * mended(v, l) * pel_ross_sun(v, l, vx, vy, 0);
    assert_near(pel_glitter(v, l, vx, vy, 0, N, 0), want, 1e-9 * want);
    struct pel_vec3 down = { 0, 0, 1 }, high = direction(0.3, 1.0);
    want = mended(down, high) * pel_ross_sun(down, high, vx, vy, 0);
    assert_near(pel_glitter(down, high, vx, vy, 0, N, 0), want, 1e-9 * want);
    h = pel_vec3_normalize(pel_vec3_add(down, high));
    ratio =
        pel_ross_slope_density(-h.x / h.z, -h.y / h.z, vx + disc, vy + disc) /
        pel_ross_slope_density(-h.x / h.z, -h.y / h.z, vx, vy);
    assert_near(pel_glitter(down, high, vx, vy, disc, N, 0), ratio * want,
                1e-9 * want);
    assert_true(pel_glitter(v, direction(1.6, 0), vx, vy, disc, N, 0) == 0);
}

/* E[|J|² p0(own + ∇D whole)] by quadrature over the three derivatives of D,
 * against the closed form: |J| by its mean leaves 0.2 %. */
static double choppy(struct pel_vec2 own, struct pel_vec2 whole, double v,
                     double fold)
{
    enum { STEPS = 60 };
    const double reach = 6.0, step = 2.0 * reach / STEPS;
    double m = 4.0 / 3.0 * fold * 2.0 * v, sum = 0.0;
    for (int i = 0; i < STEPS * STEPS * STEPS; i++) {
        double a = (i % STEPS + 0.5) * step - reach;
        double b = (i / STEPS % STEPS + 0.5) * step - reach;
        double c = (i / STEPS / STEPS + 0.5) * step - reach;
        /* Variances 3/8, covariance 1/8 of the two, 1/8 of the mixed. */
        double xx = 1.0 + sqrt(m * 3.0 / 8.0) * a;
        double yy = 1.0 + sqrt(m * 3.0 / 8.0) * (a / 3.0 + sqrt(8.0) / 3.0 * b);
        double xy = sqrt(m / 8.0) * c;
        double area = xx * yy - xy * xy;
        double x = own.x + (xx - 1) * whole.x + xy * whole.y;
        double y = own.y + xy * whole.x + (yy - 1) * whole.y;
        sum += exp(-0.5 * (a * a + b * b + c * c)) * area * area *
               pel_ross_slope_density(x, y, v, v);
    }
    return sum * pow(step / sqrt(2.0 * PEL_PI), 3);
}

static void test_sharpened(void **state)
{
    (void)state;
    for (int i = 0; i < 15; i++) {
        double v = 0.004 * (i % 3 + 1), fold = i % 2 ? 0.75 : 0.4;
        double z = sqrt(v) * (i / 3);
        struct pel_vec2 s = { 0.6 * z, 0.8 * z };
        double normal = pel_ross_slope_density(z, 0, v, v);
        double want = choppy(s, s, v, fold) / normal;
        double seen = pel_sharpened(s, s, v, v, 0, fold);
        print_message("%d sigma, variance %.3f: %.3f, by quadrature %.3f\n",
                      i / 3, v, seen, want);
        assert_near(seen, want, 0.004 * want);
    }
    struct pel_vec2 steep = { 0.3, 0.0 }, aside = { 0.3, 0.1 };
    assert_true(fabs(pel_sharpened(steep, steep, 0.008, 0.008, 0, 0.75) - 1) >
                0.1);
    assert_near(pel_sharpened(aside, aside, 0, 0, 1e-6, 0.75), 1, 1e-12);
}

/* The same of waves on top of others, whose slopes they press too: the facet is
 * up to four times as steep as they are, and turned from them by 0, 30, 60
 * degrees. A facet turned by 60 degrees has no mean J that is exact. */
static void test_sharpened_beside_others(void **state)
{
    (void)state;
    for (int i = 0; i < 18; i++) {
        double v = 0.006, z = sqrt(v) * (i % 3 + 0.5),
               turn = i / 6 * PEL_PI / 6;
        double steep = i % 6 < 3 ? 0.3 : 0.5;
        struct pel_vec2 own = { z * cos(turn), z * sin(turn) };
        struct pel_vec2 whole = { steep, 0 };
        double normal = pel_ross_slope_density(z, 0, v, v);
        double want = choppy(own, whole, v, 0.6) / normal;
        double seen = pel_sharpened(own, whole, v, v, 0, 0.6);
        print_message("%.1f sigma of %.1f, turned by %.0f: %.3f, by "
                      "quadrature %.3f\n",
                      i % 3 + 0.5, steep, turn * 180 / PEL_PI, seen, want);
        assert_near(seen, want, 0.008 * want);
    }
}

/* BRDF over F, times cos θ_l, over the light: on a grid of the facets' slopes,
 * dω = 4 h_z³ v·h d²ζ, so that narrow lobes are met. */
static double furnace(struct pel_vec3 v, double vx, double vy)
{
    const int n = 400;
    double sx = sqrt(vx), sy = sqrt(vy), sum = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double zx = sx * 16 * ((i + 0.5) / n - 0.5);
            double zy = sy * 16 * ((j + 0.5) / n - 0.5);
            struct pel_vec3 h =
                pel_vec3_normalize((struct pel_vec3){ -zx, -zy, 1 });
            double vh = pel_vec3_dot(v, h);
            struct pel_vec3 l =
                pel_vec3_add(pel_vec3_scale(h, 2 * vh), pel_vec3_scale(v, -1));
            if (vh > 0 && l.z > 0) {
                sum += pel_ross_brdf(v, l, vx, vy) * l.z * 4 * h.z * h.z * h.z *
                       vh / pel_fresnel_schlick(vh, PEL_WATER_INDEX);
            }
        }
    }
    return sum * sx * sy * 256 / n / n;
}

/* With F = 1 no more comes back than arrives, and nearly all of it where few
 * facets are hidden (1 % in the roughest): this is what 4 h_z³ in eq. 13
 * gives; h_z² is 4 % too much for the variances 0.06 and 0.03. */
static void test_white_furnace(void **state)
{
    (void)state;
    double most = 0;
    for (size_t s = 0; s < SEAS; s++) {
        for (double theta = 0; theta < 1.5; theta += 0.35) {
            double sum = furnace(direction(theta, 1.0), seas[s][0], seas[s][1]);
            most = fmax(most, sum);
            if (theta < 0.4 && s < 4) {
                assert_near(sum, 1, s < 2 ? 2e-3 : 2e-2);
            }
        }
    }
    print_message("white furnace: at most %.6f comes back\n", most);
    assert_true(most <= 1 + 1e-9);
}

/* Slopes of two groups of waves at rest, both of whose waves press the first's
 * water: the second's are found again from the facet and the first's normal. */
static struct pel_vec2 seen_of(const struct pel_patch *patch,
                               struct pel_vec2 resolved, struct pel_vec2 own)
{
    const double *j = patch->pressed;
    double det = j[0] * j[3] - j[1] * j[2];
    double x = resolved.x + own.x, y = resolved.y + own.y;
    struct pel_vec3 f = { (j[3] * x - j[1] * y) / det,
                          (j[0] * y - j[2] * x) / det, 1 };
    double toward = pel_vec3_dot(f, patch->normal);
    return (struct pel_vec2){ pel_vec3_dot(f, patch->along) / toward,
                              pel_vec3_dot(f, patch->across) / toward };
}

static void test_own_slope(void **state)
{
    (void)state;
    for (int i = 0; i < 12; i++) {
        struct pel_vec2 resolved = { 0.3 * cos(i), 0.2 * sin(2 * i) };
        struct pel_vec2 own = { 0.4 * sin(3 * i), 0.5 * cos(5 * i) };
        struct pel_patch patch = { .along = { 1, 0, 0 },
                                   .normal = { 0, 0, 1 },
                                   .pressed = { 1 - 0.2 * sin(i), 0.1, 0.1,
                                                1 + 0.3 * cos(7 * i) } };
        patch.across = (struct pel_vec3){ 0, 1, 0 };
        struct pel_vec2 level =
            seen_of(&patch, resolved, (struct pel_vec2){ 0, 0 });
        patch.normal =
            pel_vec3_normalize((struct pel_vec3){ level.x, level.y, 1 });
        double n = patch.normal.x;
        patch.along = pel_vec3_normalize((struct pel_vec3){
            1 - n * n, -n * patch.normal.y, -n * patch.normal.z });
        patch.across = pel_vec3_cross(patch.normal, patch.along);
        struct pel_vec2 s = seen_of(&patch, resolved, own), found, x, y;
        double stretch = pel_own_slope(&patch, s, &found);
        assert_near(found.x, own.x, 1e-12);
        assert_near(found.y, own.y, 1e-12);
        const double step = 1e-6;
        pel_own_slope(&patch, (struct pel_vec2){ s.x + step, s.y }, &x);
        pel_own_slope(&patch, (struct pel_vec2){ s.x, s.y + step }, &y);
        double area = (x.x - found.x) * (y.y - found.y) -
                      (x.y - found.y) * (y.x - found.x);
        assert_near(stretch, area / (step * step), 1e-4 * stretch);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fresnel),
        cmocka_unit_test(test_schlick),
        cmocka_unit_test(test_slope_density),
        cmocka_unit_test(test_lambda),
        cmocka_unit_test(test_a),
        cmocka_unit_test(test_visible_density),
        cmocka_unit_test(test_mean_fresnel),
        cmocka_unit_test(test_effective_reflectance),
        cmocka_unit_test(test_reciprocity),
        cmocka_unit_test(test_brdf),
        cmocka_unit_test(test_escape),
        cmocka_unit_test(test_glitter),
        cmocka_unit_test(test_sharpened),
        cmocka_unit_test(test_sharpened_beside_others),
        cmocka_unit_test(test_own_slope),
        cmocka_unit_test(test_white_furnace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
