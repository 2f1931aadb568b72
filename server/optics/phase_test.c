#include "optics/phase.h"

#include "base/near.h"
#include "base/vec.h"
#include "optics/linear.h"

#define NODES 200

/* ∫ of p times (1, ν, P₂, P₂₀) over angles from `from` on, in ln θ. */
static void integrate(const struct pel_phase *p, double from, double out[4])
{
    double at[NODES], weight[NODES];
    pel_gauss_legendre(NODES, log(from), log(PEL_PI), at, weight);
    out[0] = out[1] = out[2] = out[3] = 0.0;
    for (int i = 0; i < NODES; i++) {
        double angle = exp(at[i]), x = cos(angle), before = 1.0, now = x;
        for (int l = 1; l < 20; l++) {
            double next = ((2 * l + 1) * x * now - l * before) / (l + 1);
            before = now;
            now = next;
        }
        double light =
            2.0 * PEL_PI * sin(angle) * angle * weight[i] * pel_phase_at(p, x);
        out[0] += light;
        out[1] += light * x;
        out[2] += light * (1.5 * x * x - 0.5);
        out[3] += light * now;
    }
}

static const struct {
    double molecular, asymmetry, back;
} kinds[] = {
    { 0.0, 0.0, 0.0 },   { 0.0, 0.924, 0.0 },  { 1.0, 0.0, 0.0 },
    { 0.0, 0.0, 0.002 }, { 0.0, 0.0, 0.0183 }, { 0.0, 0.0, 0.05 },
    { 0.3, 0.0, 0.01 },  { 0.05, 0.85, 0.0 },
};
enum { KINDS = sizeof kinds / sizeof *kinds };

static struct pel_phase kind(int i)
{
    return pel_phase_make(kinds[i].molecular, kinds[i].asymmetry,
                          kinds[i].back);
}

/* The function, its share within an angle and its moments are one. */
static void shares_and_moments(void **state)
{
    (void)state;
    for (int i = 0; i < KINDS; i++) {
        struct pel_phase p = kind(i);
        double sum[4], chi[21];
        integrate(&p, 1e-3, sum);
        pel_phase_moments(&p, 21, chi);
        double narrow = pel_phase_within(&p, 1e-3);
        assert_near(pel_phase_within(&p, PEL_PI), 1.0, 1e-12);
        assert_near(sum[0] + narrow, 1.0, 1e-6);
        assert_near(chi[0], 1.0, 1e-12);
        assert_near(sum[1] + narrow, chi[1], 3e-6);
        assert_near(sum[2] + narrow, chi[2], 3e-6);
        assert_near(sum[3] + narrow, chi[20], 1e-4); /* P₂₀ within 1e-3 */
        for (double angle = 0.25; angle < 3.0; angle += 0.5) {
            integrate(&p, angle, sum);
            assert_near(pel_phase_within(&p, angle), 1.0 - sum[0], 1e-6);
        }
        double back = 1.0 - pel_phase_within(&p, 0.5 * PEL_PI);
        if (kinds[i].back > 0.0) {
            assert_near(back,
                        0.5 * kinds[i].molecular +
                            (1.0 - kinds[i].molecular) * kinds[i].back,
                        1e-9);
        }
    }
}

/* Mobley, Sundman and Boss 2002: n = 1.10, μ = 3.5835 has 0.0183 and is
 * Petzold's average, whose table (Mobley 1994, table 3.10) it meets within
 * 30 % from 5° to 170°. */
static void it_is_petzolds(void **state)
{
    (void)state;
    static const double petzold[][2] = {
        { 5.012, 4.295 },  { 10, 1.153 },     { 20, 0.2444 },
        { 30, 0.08609 },   { 45, 0.03067 },   { 60, 0.01313 },
        { 90, 0.004292 },  { 110, 0.002912 }, { 120, 0.002686 },
        { 140, 0.002329 }, { 160, 0.002662 }, { 170, 0.003031 },
    };
    struct pel_phase p = pel_phase_make(0.0, 0.0, 0.0183);
    assert_near(3.0 - 2.0 * p.slope, 3.5835, 2e-4);
    for (size_t i = 0; i < sizeof petzold / sizeof *petzold; i++) {
        double mine = pel_phase_at(&p, cos(petzold[i][0] * PEL_DEG));
        assert_near(mine / petzold[i][1], 1.0, 0.3);
    }
}

/* Rayleigh's, as Zhang et al. 2009 give it: 90° to 0° as 1 to 1.925. */
static void molecules(void **state)
{
    (void)state;
    struct pel_phase p = pel_phase_make(1.0, 0.0, 0.0);
    assert_near(pel_phase_at(&p, 1.0) / pel_phase_at(&p, 0.0), 1.9249278, 1e-6);
    assert_near(pel_phase_at(&p, -1.0), pel_phase_at(&p, 1.0), 1e-15);
}

static void nothing_is_lost_by_the_split(void **state)
{
    (void)state;
    for (int i = 0; i < KINDS; i++) {
        struct pel_phase p = kind(i);
        struct pel_phase_split s = pel_phase_split(&p);
        double rest = 0.0, at[NODES], weight[NODES];
        pel_gauss_legendre(NODES, 0.0, PEL_PI, at, weight);
        for (int k = 0; k < NODES; k++) {
            rest += 2.0 * PEL_PI * sin(at[k]) * weight[k] *
                    pel_phase_rest(&s, cos(at[k]));
        }
        assert_near(rest + s.peak, 1.0, 1e-4);
        assert_true(kinds[i].back > 0.0 ? s.peak > 0.1 : s.peak == 0.0);
        for (double angle = 7.0; angle < 180.0; angle += 9.0) {
            double nu = cos(angle * PEL_DEG);
            assert_near(pel_phase_rest(&s, nu), pel_phase_at(&p, nu), 0.0);
        }
        /* It goes on from there without a step. */
        double inside = cos((PEL_PHASE_PEAK_DEG - 1e-3) * PEL_DEG);
        double value = pel_phase_at(&p, inside);
        assert_near(pel_phase_rest(&s, inside), value, 1e-4 * value);
    }
}

/* Directions drawn, weighed by value over density, are the function: 1 in the
 * mean, and its mean cosine. */
static void draws_are_the_function(void **state)
{
    (void)state;
    static struct pel_phase_table t;
    enum { DRAWS = 100000 };
    for (int i = 0; i < KINDS; i++) {
        struct pel_phase p = kind(i);
        double one = 0.0, cosine = 0.0, chi[2];
        pel_phase_tabulate(&p, &t);
        pel_phase_moments(&p, 2, chi);
        for (int k = 0; k < DRAWS; k++) {
            double nu = pel_phase_draw(&t, (k + 0.5) / DRAWS);
            one += pel_phase_look_up(&t, nu) / pel_phase_density(&t, nu);
            cosine += nu;
        }
        assert_near(one / DRAWS, 1.0, 2e-4);
        assert_near(cosine / DRAWS, chi[1], 1e-4);
        for (double angle = 0.6; angle < 180.0; angle *= 1.3) {
            double nu = cos(angle * PEL_DEG), v = pel_phase_at(&p, nu);
            assert_near(pel_phase_look_up(&t, nu), v, 1e-3 * v);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_and_moments),
        cmocka_unit_test(it_is_petzolds),
        cmocka_unit_test(molecules),
        cmocka_unit_test(nothing_is_lost_by_the_split),
        cmocka_unit_test(draws_are_the_function),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
