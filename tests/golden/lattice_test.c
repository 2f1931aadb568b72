/* The glitter is no lattice: how like itself it is some waves away, in
 * pictures of the Sun's layer near the eye, where a pixel shows the shortest
 * waves that sixty trochoids have, against that of cascades of the same
 * spectrum. */
#include "ocean/fft.h"
#include "render/render_testkit.h"

#define N PEL_FFT_N
#define LANES PEL_FFT_LANES
#define PICTURES 6
#define NEAR_PX 20 /* waves themselves are alike over so much */
#define SHORTER 8  /* of patterns shorter than 32 pixels */

/* Seen: cascades 0.05 to 0.07, which is chance; trochoids 0.10 to 0.14; a
 * lattice, the same trochoids without wander, 0.20 and 0.22, at 5 m/s, where
 * more is left to the facets, 0.13. */
#define MOST_CASCADES 0.09
#define MOST 0.16
#define LEAST 0.04

static float re[N][N], im[N][N];

static void transform_rows(void)
{
    struct pel_fft_strip strip;
    for (int j = 0; j < N; j += LANES) {
        for (int i = 0; i < N * LANES; i++) {
            strip.re[i / LANES][i % LANES] = re[j + i % LANES][i / LANES];
            strip.im[i / LANES][i % LANES] = im[j + i % LANES][i / LANES];
        }
        pel_fft_strip(&strip);
        for (int i = 0; i < N * LANES; i++) {
            re[j + i % LANES][i / LANES] = strip.re[i / LANES][i % LANES];
            im[j + i % LANES][i / LANES] = strip.im[i / LANES][i % LANES];
        }
    }
}

static void turn_over(float a[N][N])
{
    for (int i = 0; i < N * N; i++) {
        int x = i % N, y = i / N;
        if (x < y) {
            float t = a[y][x];
            a[y][x] = a[x][y];
            a[x][y] = t;
        }
    }
}

static void transform(void)
{
    transform_rows();
    turn_over(re);
    turn_over(im);
    transform_rows();
    turn_over(re);
    turn_over(im);
}

static int signed_of(int i)
{
    return i < N / 2 ? i : i - N;
}

/* Level of the green glitter, between none and white; the mean would be that
 * of the few brightest. */
static void look(const struct pel_sea *sea, double time_s, double heading)
{
    struct pel_environment env = test_environment(sea, time_s);
    env.lights[PEL_LIGHT_SUN].direction = test_sun(35.0, 20.0);
    struct pel_camera c = test_camera(
        (struct test_look){ 15.0, 20.0 + heading, -35.0, 0.0, 12.0, N, N });
    c.east_m = 300.0 * time_s;
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_SUN);
    float most = 0;
    for (int i = 0; i < N * N; i++) {
        most = fmaxf(most, p->sun[4 * i + 1]);
    }
    double mean = 0, weight = 0;
    for (int i = 0; i < N * N; i++) {
        double w = sin(PEL_PI * (i % N + 0.5) / N) *
                   sin(PEL_PI * ((double)(i / N) + 0.5) / N);
        double v = (double)p->sun[4 * i + 1] / (double)most;
        re[i / N][i % N] = (float)(v / (v + 0.1));
        mean += w * (double)re[i / N][i % N];
        weight += w;
    }
    mean /= weight;
    for (int i = 0; i < N * N; i++) {
        double w = sin(PEL_PI * (i % N + 0.5) / N) *
                   sin(PEL_PI * ((double)(i / N) + 0.5) / N);
        float *x = &re[i / N][i % N];
        *x = (float)(w * ((double)*x - mean));
        im[i / N][i % N] = 0;
    }
    pel_picture_release(p);
}

/* Greatest autocorrelation from NEAR_PX away to a quarter of the picture, of
 * the patterns that SHORTER leaves. */
static double likeness(void)
{
    transform();
    for (int i = 0; i < N * N; i++) {
        float *x = &re[i / N][i % N], *y = &im[i / N][i % N];
        int m = signed_of(i % N), n = signed_of(i / N);
        *x = m * m + n * n >= SHORTER * SHORTER ? *x * *x + *y * *y : 0;
        *y = 0;
    }
    transform();
    double best = 0;
    for (int i = 1; i < N * N; i++) {
        int x = signed_of(i % N), y = signed_of(i / N), r2 = x * x + y * y;
        if (r2 >= NEAR_PX * NEAR_PX && r2 <= N * N / 16) {
            best = fmax(best, (double)(re[i / N][i % N] / re[0][0]));
        }
    }
    return best;
}

static double mean_likeness(const struct pel_sea *sea)
{
    double sum = 0;
    for (int i = 0; i < PICTURES; i++) {
        look(sea, 10.0 + 7.0 * i, 10.0 * (i % 3 - 1));
        sum += likeness() / PICTURES;
    }
    return sum;
}

static void build(double wind, bool fft, struct pel_sea *out)
{
    struct pel_sea_desc d = test_wind(wind, 1);
    d.kind = PEL_SPECTRUM_ELFOUHAILY;
    d.fetch_m = 2e6;
    d.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    assert_int_equal(pel_sea_build(&d, out), PEL_OK);
}

static void glitter_does_not_come_back(void **state)
{
    (void)state;
    static struct pel_sea sea;
    static const double winds[] = { 5, 10, 18 };
    for (int w = 0; w < 3; w++) {
        build(winds[w], true, &sea);
        double cascades = mean_likeness(&sea);
        pel_sea_finish(&sea);
        build(winds[w], false, &sea);
        double wandering = mean_likeness(&sea);
        for (int i = 0; i < sea.count; i++) {
            sea.waves[i].swing = 0;
        }
        double straight = mean_likeness(&sea);
        pel_sea_finish(&sea);
        printf("%2.0f m/s: FFT %.3f, trochoids %.3f, without wander %.3f\n",
               winds[w], cascades, wandering, straight);
        assert_true(cascades < MOST_CASCADES);
        assert_true(wandering < MOST);
        assert_true(straight > wandering + (winds[w] < 8 ? 0.0 : LEAST));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(glitter_does_not_come_back),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
