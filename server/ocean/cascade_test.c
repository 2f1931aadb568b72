#include "ocean/cascade.h"

#include <stdlib.h>
#include <string.h>

#include "base/near.h"
#include "ocean/directional.h"

#define N PEL_CASCADE_N

static struct pel_sea sea;
static struct pel_directional *spectrum;

static const struct pel_sea_desc base = {
    .synthesiser = PEL_SYNTHESISER_FFT,
    .kind = PEL_SPECTRUM_JONSWAP,
    .wind_mps = 10,
    .direction_rad = 0.6,
    .fetch_m = 2e5,
    .gamma = 3.3,
    .seed = 1,
    .wave_count = 60,
};

static struct pel_sea_desc windy(enum pel_spectrum_kind kind, double wind)
{
    struct pel_sea_desc d = base;
    d.kind = kind;
    d.wind_mps = wind;
    return d;
}

/* Calm and storm, narrow swell, shallow water. */
#define SEAS 6
static struct pel_sea_desc legal_sea(int i)
{
    struct pel_sea_desc d = windy(PEL_SPECTRUM_ELFOUHAILY, 4);
    switch (i) {
    case 1:
        return windy(PEL_SPECTRUM_PIERSON_MOSKOWITZ, 10);
    case 2:
        return windy(PEL_SPECTRUM_ELFOUHAILY, 30);
    case 3:
        d = windy(PEL_SPECTRUM_TMA, 15);
        d.depth_m = 8;
        return d;
    case 4:
        d = windy(PEL_SPECTRUM_OMEGA2, 12);
        d.swell_count = 2;
        d.swell[0] = (struct pel_swell_desc){ 3, 14, 2, 1 * PEL_DEG };
        d.swell[1] = (struct pel_swell_desc){ 1, 4, -1, 5 * PEL_DEG };
        return d;
    case 5:
        d = windy(PEL_SPECTRUM_JONSWAP, 20);
        d.fetch_m = 1e4;
        d.gamma = 7;
        return d;
    default:
        return d;
    }
}

static void build(const struct pel_sea_desc *d)
{
    pel_sea_finish(&sea);
    pel_directional_destroy(spectrum);
    assert_int_equal(pel_sea_build(d, &sea), PEL_OK);
    assert_int_equal(pel_directional_create(d, &spectrum), PEL_OK);
}

static int teardown(void **state)
{
    (void)state;
    pel_sea_finish(&sea);
    pel_directional_destroy(spectrum);
    return 0;
}

static double uniform(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

static int number(int i)
{
    return i < N / 2 ? i : i - N;
}

/* The contract of cascade.h, term by term, in double precision: eight fields
 * at one texel. */
static void direct(const struct pel_cascades *all, int index, int x, int y,
                   double t, double out[8])
{
    const struct pel_cascade *c = &all->cascade[index];
    memset(out, 0, 8 * sizeof *out);
    for (int at = 0; at < PEL_CASCADE_MODES; at++) {
        int i = at % N, j = at / N;
        if (!(c->mode[at][0] > 0)) {
            continue;
        }
        double turns = c->mode[at][0] * t;
        double phi = 2 * PEL_PI * (turns - floor(turns));
        double place = 2 * PEL_PI * ((i * x + j * y) % N) / N;
        double s = 2 * PEL_PI / c->length_m;
        double kx = s * (number(i) * c->turn_cos - number(j) * c->turn_sin);
        double ky = s * (number(i) * c->turn_sin + number(j) * c->turn_cos);
        double k = hypot(kx, ky), chop = c->mode[at][1];
        const float *h = c->h0[at];
        /* h̃ e^{i place}, real and imaginary part */
        double re = h[0] * cos(place - phi) - h[1] * sin(place - phi) +
                    h[2] * cos(place + phi) - h[3] * sin(place + phi);
        double im = h[0] * sin(place - phi) + h[1] * cos(place - phi) +
                    h[2] * sin(place + phi) + h[3] * cos(place + phi);
        double gd =
            (double)all->displacement_gain[i] * all->displacement_gain[j];
        double gs = (double)all->slope_gain[i] * all->slope_gain[j];
        out[0] -= gd * chop * kx / k * im;
        out[1] -= gd * chop * ky / k * im;
        out[2] += gd * re;
        out[3] -= gs * kx * im;
        out[4] -= gs * ky * im;
        out[5] -= gs * chop * kx * kx / k * re;
        out[6] -= gs * chop * ky * ky / k * re;
        out[7] -= gs * chop * kx * ky / k * re;
    }
}

/* Single precision against double: 1e-5 of the field's size, because two
 * fields share a transform and one may be fifty times the other; the phase of
 * a long time adds nothing. */
static void test_contract(void **state)
{
    (void)state;
    struct pel_sea_desc d = legal_sea(1);
    build(&d);
    const double times[] = { 0, 12.34, 9.87654321e8 };
    uint64_t rng = 3;
    for (int n = 0; n < 3; n++) {
        struct pel_cascade_fields *f;
        assert_int_equal(pel_cascade_fields_create(sea.cascades, times[n], &f),
                         PEL_OK);
        for (int c = 0; c < PEL_CASCADES; c++) {
            const struct pel_cascade *cascade = &sea.cascades->cascade[c];
            double height = 1e-5 * sqrt(cascade->m0);
            double slope = 1e-5 * sqrt(pel_cascade_kept(cascade, 0).along);
            for (int i = 0; i < 4; i++) {
                int x = (int)(N * uniform(&rng)), y = (int)(N * uniform(&rng));
                double want[8];
                direct(sea.cascades, c, x, y, times[n], want);
                const float *got = f->displacement[c][y * N + x];
                for (int j = 0; j < 3; j++) {
                    assert_near(got[j], want[j], height);
                }
                const float *s = f->slopes[c][y * N + x];
                for (int j = 0; j < 4; j++) {
                    assert_near(s[j], want[3 + j], slope);
                }
                assert_near(f->fold[c][y * N + x], want[7], slope);
            }
        }
        pel_cascade_fields_destroy(f);
    }
}

/* The drawn modes carry the spectrum's energy: by rings, so nearly exactly. */
static void test_energy(void **state)
{
    (void)state;
    for (int i = 0; i < SEAS; i++) {
        struct pel_sea_desc d = legal_sea(i);
        build(&d);
        struct pel_band_moments all;
        pel_directional_moments(spectrum, 0, INFINITY, &all);
        print_message("sea %d: Hs %.4f m, spectrum %.4f m\n", i,
                      4 * sqrt(sea.m0), 4 * sqrt(all.m0));
        assert_near(sqrt(sea.m0), sqrt(all.m0), 0.02 * sqrt(all.m0));
    }
}

/* Below any wavelength: heights, and slopes along and across the wind, within
 * 2 % of the spectrum's integral. */
static void test_below(void **state)
{
    (void)state;
    double worst[3] = { 0 };
    for (int i = 0; i < SEAS; i++) {
        struct pel_sea_desc d = legal_sea(i);
        build(&d);
        for (double l = 0.025; l < 1000; l *= 1.5) {
            struct pel_band_moments want, drawn;
            pel_directional_moments(spectrum, 2 * PEL_PI / l, INFINITY, &want);
            pel_directional_moments(spectrum, 2 * PEL_PI / l,
                                    2 * PEL_PI / PEL_SEA_SHORTEST_M, &drawn);
            struct pel_cascade_beyond got = pel_cascades_below(sea.cascades, l);
            struct pel_slopes s = pel_sea_slopes_below(&sea, l);
            double sum = want.along + want.cross;
            worst[0] = fmax(worst[0], fabs(got.m0 / drawn.m0 - 1));
            worst[1] = fmax(worst[1], fabs(s.along - want.along) / sum);
            worst[2] = fmax(worst[2], fabs(s.cross - want.cross) / sum);
            assert_near(pel_sea_rms_below(&sea, l), sqrt(got.m0), 1e-12);
        }
    }
    print_message("below a wavelength: height variance %.2f %%, slopes along "
                  "%.2f %%, across %.2f %% from the integral\n",
                  100 * worst[0], 100 * worst[1], 100 * worst[2]);
    assert_true(worst[0] < 0.02 && worst[1] < 0.02 && worst[2] < 0.02);
}

static void test_droppable(void **state)
{
    (void)state;
    struct pel_sea_desc d = legal_sea(1);
    build(&d);
    for (double l = 0.05; l < 100; l *= 2) {
        double rms = pel_sea_rms_below(&sea, l);
        assert_near(pel_sea_droppable(&sea, rms), l, 1e-6 * l);
    }
    assert_true(pel_sea_droppable(&sea, 100) > 1e300);
}

/* The variance of the textures' levels, as sampled, is the table's: means over
 * 6 moments of the mean over the tile. */
static double sampled(const float *level, int n, double u, double v)
{
    u = u * n - 0.5;
    v = v * n - 0.5;
    double i = floor(u), j = floor(v), f = u - i, g = v - j;
    int i0 = ((int)i + n) % n, i1 = (i0 + 1) % n;
    int j0 = ((int)j + n) % n, j1 = (j0 + 1) % n;
    return (1 - g) * ((1 - f) * level[j0 * n + i0] + f * level[j0 * n + i1]) +
           g * ((1 - f) * level[j1 * n + i0] + f * level[j1 * n + i1]);
}

static void test_levels(void **state)
{
    (void)state;
    struct pel_sea_desc d = legal_sea(1);
    d.direction_rad = 0; /* so that `along` is ∂h/∂x */
    build(&d);
    enum { MOMENTS = 6, POINTS = 20000 };
    static float levels[PEL_CASCADE_LEVELS][PEL_CASCADE_MODES];
    double seen[PEL_CASCADES][5] = { { 0 } };
    const double lods[5] = { 0, 0.5, 1, 2.25, 3 };
    uint64_t rng = 5;
    for (int m = 0; m < MOMENTS; m++) {
        struct pel_cascade_fields *f;
        assert_int_equal(pel_cascade_fields_create(sea.cascades, 1e4 * m, &f),
                         PEL_OK);
        for (int c = 0; c < PEL_CASCADES; c++) {
            for (int i = 0; i < PEL_CASCADE_MODES; i++) {
                levels[0][i] = f->slopes[c][i][0];
            }
            for (int l = 1, n = N / 2; l < 5; l++, n /= 2) {
                const float *from = levels[l - 1];
                for (int i = 0; i < n * n; i++) {
                    int at = (i / n) * 4 * n + (i % n) * 2;
                    levels[l][i] =
                        0.25f * (from[at] + from[at + 1] + from[at + 2 * n] +
                                 from[at + 2 * n + 1]);
                }
            }
            for (int p = 0; p < POINTS; p++) {
                double u = uniform(&rng), v = uniform(&rng);
                for (int q = 0; q < 5; q++) {
                    int l = (int)lods[q];
                    double w = lods[q] - l;
                    double s = (1 - w) * sampled(levels[l], N >> l, u, v);
                    s += w > 0 ? w * sampled(levels[l + 1], N >> (l + 1), u, v)
                               : 0;
                    seen[c][q] += s * s / (MOMENTS * POINTS);
                }
            }
        }
        pel_cascade_fields_destroy(f);
    }
    for (int c = 0; c < PEL_CASCADES; c++) {
        const struct pel_cascade *cascade = &sea.cascades->cascade[c];
        for (int q = 0; q < 5; q++) {
            double want = pel_cascade_kept(cascade, lods[q]).along;
            print_message("cascade %d level %.2f: %.3e, table %.3e\n", c,
                          lods[q], seen[c][q], want);
            /* 120,000 samples of a few hundred independent waves in the first
             * tile, tens of thousands in the others. */
            assert_near(seen[c][q], want, (c == 0 ? 0.08 : 0.04) * want + 1e-9);
        }
    }
    struct pel_slopes all = pel_cascades_left(sea.cascades, 1e9, 0);
    assert_near(all.along, sea.slope_variance_along, 1e-6 * all.along);
    struct pel_slopes none = pel_cascades_left(sea.cascades, 1e-9, 0);
    assert_near(none.along, 0, 1e-6 * all.along);
}

/* 4 std of the interpolated height over places and moments, and variance of
 * its slopes. 60,000 samples of 30 moments; the longest waves count some
 * hundred independent ones. */
static void test_surface_statistics(void **state)
{
    (void)state;
    struct pel_sea_desc d = legal_sea(1);
    build(&d);
    enum { MOMENTS = 30, POINTS = 2000 };
    static struct pel_vec2 points[POINTS];
    static struct pel_surface_sample out[POINTS];
    uint64_t rng = 11;
    double sum = 0, squares = 0, slopes = 0;
    for (int m = 0; m < MOMENTS; m++) {
        for (int i = 0; i < POINTS; i++) {
            points[i].x = 1e5 * uniform(&rng);
            points[i].y = 1e5 * uniform(&rng);
        }
        pel_sea_query(&sea, points, POINTS, 977.0 * m, out);
        for (int i = 0; i < POINTS; i++) {
            const struct pel_surface_sample *s = &out[i];
            sum += s->height_m / (MOMENTS * POINTS);
            squares += s->height_m * s->height_m / (MOMENTS * POINTS);
            double zz = s->normal.z * s->normal.z;
            slopes += (1 - zz) / zz / (MOMENTS * POINTS);
        }
    }
    double hs = 4 * sqrt(squares - sum * sum);
    double want = 4 * sqrt(sea.spectrum_m0);
    print_message("Hs %.3f m, spectrum %.3f m; slope variance %.4f, spectrum "
                  "%.4f\n",
                  hs, want, slopes,
                  sea.slope_variance_along + sea.slope_variance_cross);
    assert_near(hs, want, 0.02 * want);
    /* Choppy crests are steeper than the linear sum says. */
    assert_near(slopes, sea.slope_variance_along + sea.slope_variance_cross,
                0.12 * slopes);
}

/* Every sample lies on the surface: displacing the rest position found by
 * other means comes back to the place within 0.1 mm, at any legal sea. */
static void test_inverse(void **state)
{
    (void)state;
    for (int s = 0; s < SEAS; s++) {
        struct pel_sea_desc d = legal_sea(s);
        build(&d);
        uint64_t rng = 17;
        for (int i = 0; i < 500; i++) {
            double x = 2e4 * uniform(&rng), y = 2e4 * uniform(&rng);
            struct pel_vec3 at = pel_sea_displace(&sea, x, y, 55.5);
            struct pel_surface_sample p;
            pel_sea_sample(&sea, x + at.x, y + at.y, 55.5, &p);
            assert_near(p.height_m, at.z, 1e-4);
        }
    }
}

/* Least eigenvalue of the derivative of x → x + D(x) over places and moments:
 * the surface folds where it is not positive. */
static void test_no_folding(void **state)
{
    (void)state;
    for (int s = 0; s < SEAS; s++) {
        struct pel_sea_desc d = legal_sea(s);
        build(&d);
        uint64_t rng = 23;
        double least = 1;
        for (int m = 0; m < 3; m++) {
            struct pel_cascade_fields *f;
            assert_int_equal(
                pel_cascade_fields_create(sea.cascades, 1e3 * m, &f), PEL_OK);
            for (int i = 0; i < 200000; i++) {
                double a = 1, b = 0, e = 1;
                for (int c = 0; c < PEL_CASCADES; c++) {
                    int at = (int)(PEL_CASCADE_MODES * uniform(&rng));
                    a += f->slopes[c][at][2];
                    e += f->slopes[c][at][3];
                    b += f->fold[c][at];
                }
                double half = 0.5 * (a + e);
                least =
                    fmin(least, half - sqrt(0.25 * (a - e) * (a - e) + b * b));
            }
            pel_cascade_fields_destroy(f);
        }
        print_message("sea %d: least stretch %.3f\n", s, least);
        assert_true(least > 0);
    }
}

/* The normal answered is that of the surface answered: root mean square of the
 * angle to the gradient of queried heights, by differences over 0.4 mm, which
 * leave 0.02° of the shortest waves' curvature and of single precision. What
 * is allowed is what a last step of 0.1 mm in the search turns ripples by. */
#define ALLOWED_NORMAL_DEG 0.1
static void test_normal(void **state)
{
    (void)state;
    const double e = 2e-4;
    for (int s = 0; s < SEAS; s++) {
        struct pel_sea_desc d = legal_sea(s);
        build(&d);
        enum { POINTS = 1000 };
        uint64_t rng = 37;
        double squares = 0, worst = 0;
        for (int i = 0; i < POINTS; i++) {
            double x = 1e3 * uniform(&rng), y = 1e3 * uniform(&rng);
            const struct pel_vec2 at[5] = {
                { x, y }, { x - e, y }, { x + e, y }, { x, y - e }, { x, y + e }
            };
            struct pel_surface_sample p[5];
            pel_sea_query(&sea, at, 5, 33, p);
            struct pel_vec3 want = pel_vec3_normalize((struct pel_vec3){
                (p[1].height_m - p[2].height_m) / (2 * e),
                (p[3].height_m - p[4].height_m) / (2 * e), 1 });
            struct pel_vec3 cross = pel_vec3_cross(p[0].normal, want);
            double angle = asin(sqrt(pel_vec3_dot(cross, cross))) / PEL_DEG;
            squares += angle * angle / POINTS;
            worst = fmax(worst, angle);
        }
        print_message("sea %d: normals off the gradient by %.3f deg rms, "
                      "worst %.3f\n",
                      s, sqrt(squares), worst);
        assert_true(sqrt(squares) < ALLOWED_NORMAL_DEG);
    }
}

/* Velocity is that of the particle: by differences in time at a rest place. */
static void test_velocity(void **state)
{
    (void)state;
    struct pel_sea_desc d = legal_sea(4);
    build(&d);
    const double e = 2e-3;
    uint64_t rng = 29;
    for (int i = 0; i < 20; i++) {
        double x = 1e3 * uniform(&rng), y = 1e3 * uniform(&rng), t = 50;
        struct pel_vec3 at = pel_sea_displace(&sea, x, y, t);
        struct pel_vec3 before = pel_sea_displace(&sea, x, y, t - e);
        struct pel_vec3 after = pel_sea_displace(&sea, x, y, t + e);
        struct pel_surface_sample p;
        pel_sea_sample(&sea, x + at.x, y + at.y, t, &p);
        /* Single precision of metres over 4 ms, and ripples of 12 Hz. */
        assert_near(p.velocity_mps.x, (after.x - before.x) / (2 * e), 5e-3);
        assert_near(p.velocity_mps.y, (after.y - before.y) / (2 * e), 5e-3);
        assert_near(p.velocity_mps.z, (after.z - before.z) / (2 * e), 5e-3);
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
    struct pel_sea_desc d = legal_sea(4);
    build(&d);
    const double e = 2e-3;
    uint64_t rng = 31;
    double sum = 0;
    for (int i = 0; i < 20; i++) {
        double x = 1e3 * uniform(&rng), y = 1e3 * uniform(&rng), t = 50;
        struct pel_vec3 at = pel_sea_displace(&sea, x, y, t);
        struct pel_vec3 before = velocity_of(x, y, t - e);
        struct pel_vec3 after = velocity_of(x, y, t + e);
        struct pel_vec2 place = { x + at.x, y + at.y };
        struct pel_surface_sample p;
        pel_sea_query_moving(&sea, &place, 1, t, &p);
        /* Single precision of velocities over 4 ms, and ripples of 12 Hz. */
        assert_near(p.acceleration_mps2.x, (after.x - before.x) / (2 * e),
                    2e-2);
        assert_near(p.acceleration_mps2.y, (after.y - before.y) / (2 * e),
                    2e-2);
        assert_near(p.acceleration_mps2.z, (after.z - before.z) / (2 * e),
                    2e-2);
        sum += fabs(p.acceleration_mps2.z);
    }
    assert_true(sum > 20 * 0.2); /* so that the tolerance says something */
}

static void test_same_bits(void **state)
{
    (void)state;
    struct pel_sea_desc d = legal_sea(4);
    build(&d);
    struct pel_cascades *again;
    assert_int_equal(pel_cascades_create(&d, &again), PEL_OK);
    for (int c = 0; c < PEL_CASCADES; c++) {
        assert_memory_equal(sea.cascades->cascade[c].h0, again->cascade[c].h0,
                            PEL_CASCADE_MODES * sizeof *again->cascade[c].h0);
        assert_memory_equal(sea.cascades->cascade[c].mode,
                            again->cascade[c].mode,
                            PEL_CASCADE_MODES * sizeof *again->cascade[c].mode);
    }
    pel_cascades_destroy(again);
    /* The order of questions changes no answer. */
    struct pel_surface_sample a, b, other;
    pel_sea_sample(&sea, 3, 4, 10, &a);
    pel_sea_sample(&sea, 3, 4, 11, &other);
    pel_sea_sample(&sea, 3, 4, 12, &other);
    pel_sea_sample(&sea, 3, 4, 10, &b);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(other.height_m != a.height_m);
}

/* A single wave on the grids: of the nearest mode, a crest at the origin at
 * time 0, and its energy in the sums, alone and on a wind sea. */
static void test_single(void **state)
{
    (void)state;
    for (double wind = 0; wind <= 10; wind += 10) {
        struct pel_sea_desc d = windy(PEL_SPECTRUM_JONSWAP, wind);
        d.single_count = 2;
        d.single[0] = (struct pel_single_desc){ 1.2, 7, 0.5, 0 };
        d.single[1] = (struct pel_single_desc){ 0.3, 2.5, -2, 0 };
        build(&d);
        double waves = (1.2 * 1.2 + 0.3 * 0.3) / 8;
        struct pel_band_moments all, wind_sea;
        pel_directional_moments(spectrum, 0, INFINITY, &all);
        pel_directional_continuous(spectrum, 0, INFINITY, &wind_sea);
        assert_near(all.m0 - wind_sea.m0, waves, 1e-9);
        assert_near(sea.m0, all.m0, 0.04 * all.m0); /* they interfere */
        if (wind == 0) {
            struct pel_surface_sample s;
            pel_sea_sample(&sea, 0, 0, 0, &s);
            /* Interpolation of a wave of 59 m by texels of 17 m. */
            assert_near(s.height_m, 0.75, 0.03);
            assert_near(sea.m0, waves, 1e-6);
        }
    }
}

/* It goes the way that was asked for, as long as was asked for, up to half a
 * mode of the largest grid: crests lie across its way, troughs half a wave on.
 */
static void test_way_of_a_single(void **state)
{
    (void)state;
    static const double ways[] = { 0, 0.5, 1.9, -2, -1.1 };
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        const double period = 9, height = 2;
        struct pel_sea_desc d = windy(PEL_SPECTRUM_JONSWAP, 0);
        d.single_count = 1;
        d.single[0] = (struct pel_single_desc){ height, period, ways[i], 0 };
        build(&d);
        double c = cos(ways[i]), s = sin(ways[i]);
        double k = pel_dispersion_k(2 * PEL_PI / period, 0);
        for (double along = -1; along <= 1; along += 0.25) {
            for (double across = -0.5; across <= 0.5; across += 0.5) {
                double x = along * PEL_PI / k, y = across * PEL_PI / k;
                struct pel_surface_sample p;
                pel_sea_sample(&sea, x * c - y * s, x * s + y * c, 0, &p);
                /* A mode is 2π / length; over half a wave it turns the phase
                 * by `off`, and half of one does by half of that in each
                 * direction. The chop sharpens crests by the steepness,
                 * k a = 0.05. */
                double off =
                    2 * PEL_PI / sea.cascades->cascade[0].length_m * PEL_PI / k;
                double crest = 0.5 * height;
                assert_near(p.height_m, crest * cos(k * x),
                            crest * (off + 0.06));
            }
        }
        /* A quarter of a period later its crest is a quarter of a wave on. */
        struct pel_surface_sample p;
        pel_sea_sample(&sea, 0.5 * PEL_PI / k * c, 0.5 * PEL_PI / k * s,
                       0.25 * period, &p);
        assert_near(p.height_m, 0.5 * height, 0.1 * height);
    }
}

static void test_flat(void **state)
{
    (void)state;
    struct pel_sea_desc d = windy(PEL_SPECTRUM_PIERSON_MOSKOWITZ, 0);
    build(&d);
    struct pel_surface_sample s;
    pel_sea_sample(&sea, 12, -7, 100, &s);
    assert_true(s.height_m == 0 && s.normal.z == 1);
    assert_true(pel_sea_rms_below(&sea, 10) == 0);
    assert_true(sea.slope_variance_along == 0);
}

/* A batch answers as one by one, at its own time, whatever was asked before. */
static void test_query(void **state)
{
    (void)state;
    struct pel_sea_desc d = legal_sea(1);
    build(&d);
    enum { POINTS = 500 };
    static struct pel_vec2 points[POINTS];
    static struct pel_surface_sample out[POINTS];
    for (int i = 0; i < POINTS; i++) {
        points[i] = (struct pel_vec2){ 0.37 * i, -11.1 * i };
    }
    for (int moment = 0; moment < 3; moment++) {
        static const double times[] = { 4, 4.25, 4 };
        struct pel_surface_sample one;
        pel_sea_query(&sea, points, POINTS, times[moment], out);
        pel_sea_sample(&sea, 0, 0, 1000, &one);
        for (int i = 0; i < POINTS; i++) {
            pel_sea_sample(&sea, points[i].x, points[i].y, times[moment], &one);
            assert_memory_equal(&one, &out[i], sizeof one);
        }
    }
    pel_sea_query(&sea, points, 0, 4, out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_contract),
        cmocka_unit_test(test_energy),
        cmocka_unit_test(test_below),
        cmocka_unit_test(test_droppable),
        cmocka_unit_test(test_levels),
        cmocka_unit_test(test_surface_statistics),
        cmocka_unit_test(test_inverse),
        cmocka_unit_test(test_no_folding),
        cmocka_unit_test(test_normal),
        cmocka_unit_test(test_velocity),
        cmocka_unit_test(test_acceleration),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_single),
        cmocka_unit_test(test_way_of_a_single),
        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_query),
    };
    return cmocka_run_group_tests(tests, NULL, teardown);
}
