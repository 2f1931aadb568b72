/* Tiles of the cascades do not come back: how like itself the sea is elsewhere,
 * as a picture from straight above sees it. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/near.h"
#include "ocean/cascade.h"
#include "ocean/fft.h"

#define N PEL_FFT_N
#define LANES PEL_FFT_LANES
#define NEAR_PX 24 /* waves themselves are alike over so much */
#define SHORTER 10 /* of waves shorter than 26 pixels */

static struct pel_sea sea;
static float re[N][N], im[N][N];

static void transform_rows(void)
{
    struct pel_fft_strip strip;
    for (int j = 0; j < N; j += LANES) {
        for (int i = 0; i < N; i++) {
            for (int l = 0; l < LANES; l++) {
                strip.re[i][l] = re[j + l][i];
                strip.im[i][l] = im[j + l][i];
            }
        }
        pel_fft_strip(&strip);
        for (int i = 0; i < N; i++) {
            for (int l = 0; l < LANES; l++) {
                re[j + l][i] = strip.re[i][l];
                im[j + l][i] = strip.im[i][l];
            }
        }
    }
}

static void turn_over(float a[N][N])
{
    for (int j = 0; j < N; j++) {
        for (int i = 0; i < j; i++) {
            float t = a[j][i];
            a[j][i] = a[i][j];
            a[i][j] = t;
        }
    }
}

static void transform(void)
{
    transform_rows();
    turn_over(re);
    turn_over(im);
    transform_rows();
}

/* Fades to the picture's edge. */
static double window(int at)
{
    return sin(PEL_PI * (at % N + 0.5) / N) * sin(PEL_PI * (at / N + 0.5) / N);
}

static int signed_of(int i)
{
    return i < N / 2 ? i : i - N;
}

/* Sum over all places of the field there times that a lag further, without
 * waves longer than N / `least` pixels. */
static void correlate(int least)
{
    transform();
    for (int i = 0; i < N * N; i++) {
        float *x = &re[i / N][i % N], *y = &im[i / N][i % N];
        int m = signed_of(i % N), n = signed_of(i / N);
        *x = m * m + n * n >= least * least ? *x * *x + *y * *y : 0;
        *y = 0;
    }
    transform();
}

/* The slopes as pixels of pixel_m see them, times the window. */
static void look(double pixel_m)
{
    static struct pel_vec2 at[N * N];
    static struct pel_filtered seen[N * N];
    const struct pel_filter filter = PEL_FILTER_DEFAULT;
    for (int i = 0; i < N * N; i++) {
        at[i] = (struct pel_vec2){ pixel_m * (i % N) - 3210,
                                   pixel_m * (i / N) + 777 };
    }
    assert_int_equal(
        pel_sea_filtered(&sea, &filter, pixel_m, at, N * N, 60, seen), PEL_OK);
    for (int i = 0; i < N * N; i++) {
        struct pel_vec3 n = seen[i].normal;
        re[i / N][i % N] = (float)(window(i) * n.x / n.z);
        im[i / N][i % N] = (float)(window(i) * n.y / n.z);
    }
}

/* Greatest autocorrelation NEAR_PX pixels away or more, to half the picture. */
static double likeness(double pixel_m)
{
    static float overlap[N][N];
    for (int i = 0; i < N * N; i++) {
        re[i / N][i % N] = (float)(window(i) * window(i));
        im[i / N][i % N] = 0;
    }
    correlate(0);
    memcpy(overlap, re, sizeof overlap);
    look(pixel_m);
    correlate(SHORTER);
    double best = 0;
    for (int i = 1; i < N * N; i++) {
        int x = signed_of(i % N), y = signed_of(i / N);
        bool counts = overlap[i / N][i % N] > 0.2f * overlap[0][0];
        if (counts && x * x + y * y >= NEAR_PX * NEAR_PX) {
            double all = (double)re[0][0] / (double)overlap[0][0];
            double here = (double)re[i / N][i % N];
            best = fmax(best, here / (double)overlap[i / N][i % N] / all);
        }
    }
    return best;
}

/* Pictures that span two to three of each tile. The few longest waves that a
 * picture shows are alike by chance, up to 0.25 (of the longest a light wind
 * raises too few to tell); tiles that came back made it 0.6 to 1.4. */
#define TILE_PX 97
#define MOST 0.3

static void test_no_tiling(void **state)
{
    (void)state;
    static const double winds[] = { 5, 10, 20 };
    for (int w = 0; w < 3; w++) {
        const struct pel_sea_desc d = {
            .synthesiser = PEL_SYNTHESISER_FFT,
            .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
            .wind_mps = winds[w],
            .direction_rad = 0.6,
            .fetch_m = 2e5,
            .gamma = 3.3,
            .seed = 1,
            .wave_count = 60,
        };
        assert_int_equal(pel_sea_build(&d, &sea), PEL_OK);
        for (int i = 0; i < PEL_CASCADES; i++) {
            double tile = sea.cascades->cascade[i].length_m;
            double got = likeness(tile / TILE_PX);
            print_message("wind %2.0f m/s, tiles of %7.2f m: %.3f\n", winds[w],
                          tile, got);
            assert_true(got < MOST || (i == 0 && winds[w] < 10));
        }
        pel_sea_finish(&sea);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_tiling),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
