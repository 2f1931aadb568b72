/* What is drawn against what queries answer: at each pixel's place, from where
 * the waves of the peak are eight pixels long in the picture to the nearest.
 * The test has a small table; with --all the whole of docs/validation.md. */
#include <stdbool.h>

#include "optics/atmosphere.h"
#include "render/render_testkit.h"
#include "render/uniforms.h"

#define TIME_S 77.7
/* Lengths of the wave in the picture on level water: pixels count from the
 * first on, and each range must keep the bounds. */
static const double lengths_px[] = { 8.0, 24.0, 1e9 };
#define RANGES (sizeof lengths_px / sizeof *lengths_px - 1)
/* The bounds: a pixel is its distance times its angle. Half of the pixels: a
 * twentieth of one is what the filter of positions leaves out, a millimetre the
 * rounding of distances. 99 of 100: at the outlines of crests neighbouring
 * pixels see different waves, and a centre's place is good to one. */
#define MEDIAN_M 1e-3
#define MEDIAN_PX 0.05
#define P99_PX 1.0
/* What is drawn must be what is seen: of HIDDEN_ASKED pixels so many may show a
 * place that a nearer wave hides by half a pixel. */
#define HIDDEN_PX 0.5
#define HIDDEN_ASKED 600
#define HIDDEN_MOST 0.01

static struct pel_sea sea;

struct kind {
    const char *name;
    double wind_mps, swell_m;
};
static const struct kind kinds[] = {
    { "swell 3 m, 12 s", 0.0, 3.0 }, { "PM 5 m/s", 5.0, 0.0 },
    { "PM 10 m/s", 10.0, 0.0 },      { "PM 15 m/s", 15.0, 0.0 },
    { "PM 20 m/s", 20.0, 0.0 },
};
#define KINDS (sizeof kinds / sizeof *kinds)
#define TO_RAD (0.5 * PEL_PI) /* north: along the sight of heading 0 */

/* The length of the spectrum's peak: ω = (0.8 · 0.74)^¼ g/V20, B eq. 1. */
static double peak_m(const struct kind *k)
{
    double omega = k->swell_m > 0.0 ? 2.0 * PEL_PI / 12.0
                                    : pow(0.8 * 0.74, 0.25) * PEL_GRAVITY /
                                          (1.0625 * k->wind_mps);
    return 2.0 * PEL_PI * PEL_GRAVITY / (omega * omega);
}

static void make_sea(const struct kind *k, bool fft)
{
    struct pel_sea_desc desc = test_wind(k->wind_mps, 5);
    desc.direction_rad = TO_RAD;
    desc.synthesiser = fft ? PEL_SYNTHESISER_FFT : PEL_SYNTHESISER_TROCHOIDS;
    desc.swell_count = k->swell_m > 0.0;
    desc.swell[0] = (struct pel_swell_desc){ k->swell_m, 12.0, TO_RAD, 0.2 };
    assert_int_equal(pel_sea_build(&desc, &sea), PEL_OK);
}

static int by_size(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double quantile(float *v, size_t n, double q)
{
    qsort(v, n, sizeof *v, by_size);
    return (double)v[(size_t)(q * (double)(n - 1))];
}

struct result {
    size_t count;
    double median_m, beyond_m; /* of the error; of it less MEDIAN_PX */
    double median_px, p99_px, worst_m, worst_at_m;
    size_t outliers; /* within 200 m, 0.3 m and over */
    double hidden;   /* share of pixels whose place a nearer wave hides */
};

struct errors {
    size_t count;
    float *m, *px, *less;
};

static void take(struct errors *e, double error_m, double pixel_m)
{
    e->m[e->count] = (float)error_m;
    e->px[e->count] = (float)(error_m / pixel_m);
    e->less[e->count++] = (float)(error_m - MEDIAN_PX * pixel_m);
}

static void sum_up(struct errors *e, struct result *r)
{
    r->count = e->count;
    if (e->count) {
        r->median_m = quantile(e->m, e->count, 0.5);
        r->median_px = quantile(e->px, e->count, 0.5);
        r->beyond_m = quantile(e->less, e->count, 0.5);
        r->p99_px = quantile(e->px, e->count, 0.99);
    }
}

/* A place in the east where the eye is clear of the water, or the best. */
static double dry_place(double eye_m)
{
    double best = 0.0, least = INFINITY;
    for (double east = 0.0; east < 4000.0; east += 10.0) {
        struct pel_surface_sample s;
        pel_sea_sample(&sea, east, 0.0, TIME_S, &s);
        if (s.height_m < eye_m - 1.5) {
            return east;
        }
        if (s.height_m < least) {
            least = s.height_m;
            best = east;
        }
    }
    return best;
}

/* Whether the queried surface stands HIDDEN_PX and more above the sight from
 * the camera to a place, by steps that grow with the distance. */
static bool is_hidden(const struct pel_camera *c, struct pel_vec3 to,
                      double pixel)
{
    enum { STEPS = 400 };
    static struct pel_vec2 at[STEPS];
    static struct pel_surface_sample s[STEPS];
    double dx = to.x - c->east_m, dy = to.y - c->north_m, arc = hypot(dx, dy);
    double f[STEPS];
    for (int i = 0; i < STEPS; i++) {
        f[i] = pow(2.0 / fmax(arc, 4.0), 1.0 - (i + 0.5) / STEPS);
        at[i] =
            (struct pel_vec2){ c->east_m + f[i] * dx, c->north_m + f[i] * dy };
    }
    pel_sea_query(&sea, at, STEPS, TIME_S, s);
    for (int i = 0; i < STEPS; i++) {
        /* The Earth falls away: a straight sight stands lower over it. */
        double bow = f[i] * (1.0 - f[i]) * arc * arc / (2.0 * PEL_EARTH_RADIUS);
        double sight = c->altitude_m + f[i] * (to.z - c->altitude_m) - bow;
        if (s[i].height_m - sight > HIDDEN_PX * f[i] * arc * pixel) {
            return true;
        }
    }
    return false;
}

/* Every `step`th pixel; by range of lengths. */
static void compare(const struct kind *k, struct test_look look, uint32_t step,
                    struct result out[RANGES])
{
    struct pel_environment env = test_environment(&sea, TIME_S);
    struct pel_camera c = test_camera(look);
    c.east_m = dry_place(look.height_m);
    struct pel_picture *p = test_draw(renderer, &env, &c, PEL_LAYER_POSITION);
    size_t n = (size_t)c.width * c.height, count[RANGES] = { 0 };
    float *xyz = malloc(3 * n * sizeof *xyz);
    struct errors e = { 0, malloc(n * sizeof *xyz), malloc(n * sizeof *xyz),
                        malloc(n * sizeof *xyz) };
    struct pel_vec2 *at = malloc(n * sizeof *at);
    struct pel_surface_sample *s = malloc(n * sizeof *s);
    size_t *which = malloc(RANGES * n * sizeof *which);
    assert_true(xyz && e.m && e.px && e.less && at && s && which);
    pel_picture_position(p, &c, &env, xyz);
    double pixel = pel_pixel_pitch(c.tan_left, c.tan_right, c.width);
    for (size_t i = 0; i < n; i += step) {
        double range = (double)p->depth[i];
        double length =
            peak_m(k) * look.height_m / (range * range * pixel); /* 0: sky */
        size_t j = length < lengths_px[1] ? 0 : 1;
        if (length >= lengths_px[0]) {
            which[j * n + count[j]++] = i;
        }
    }
    for (size_t j = 0; j < RANGES; j++) {
        struct result *r = &out[j];
        *r = (struct result){ 0 };
        e.count = 0;
        for (size_t i = 0; i < count[j]; i++) {
            const float *place = &xyz[3 * which[j * n + i]];
            at[i] = (struct pel_vec2){ (double)place[0], (double)place[1] };
        }
        pel_sea_query(&sea, at, count[j], TIME_S, s);
        for (size_t i = 0; i < count[j]; i++) {
            size_t from = which[j * n + i];
            double range = (double)p->depth[from];
            double error = fabs((double)xyz[3 * from + 2] - s[i].height_m);
            take(&e, error, range * pixel);
            r->outliers += range < 200.0 && error > 0.3;
            if (error > r->worst_m) {
                r->worst_m = error;
                r->worst_at_m = range;
            }
        }
        sum_up(&e, r);
        size_t hidden = 0, asked = 0;
        for (size_t i = 0; i < count[j]; i += 1 + count[j] / HIDDEN_ASKED) {
            const float *place = &xyz[3 * which[j * n + i]];
            const struct pel_vec3 to = { (double)place[0], (double)place[1],
                                         (double)place[2] };
            hidden += is_hidden(&c, to, pixel);
            asked++;
        }
        r->hidden = asked ? (double)hidden / (double)asked : 0.0;
    }
    free(xyz);
    free(e.m);
    free(e.px);
    free(e.less);
    free(at);
    free(s);
    free(which);
    pel_picture_release(p);
}

static bool passes(const struct result *r)
{
    return r->count == 0 || (r->beyond_m <= MEDIAN_M && r->p99_px <= P99_PX &&
                             r->hidden <= HIDDEN_MOST);
}

static void print_head(void)
{
    printf("| sea | by | eye, m | heading | a wave, pixels | pixels | median, "
           "mm | median, pixel | p99, pixel | worst, m | at, m | 0.3 m and "
           "over within 200 m | hidden | |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

/* How many ranges fail. */
static int print_rows(const struct kind *k, bool fft, struct test_look look,
                      const struct result results[RANGES])
{
    int failed = 0;
    for (size_t i = 0; i < RANGES; i++) {
        const struct result *r = &results[i];
        printf("| %s | %s | %g | %g° | %g and over | %zu | %.2f | %.4f | %.2f "
               "| %.2f | %.0f | %zu | %.2f %% | %s |\n",
               k->name, fft ? "FFT" : "trochoids", look.height_m, look.heading,
               lengths_px[i], r->count, 1e3 * r->median_m, r->median_px,
               r->p99_px, r->worst_m, r->worst_at_m, r->outliers,
               100.0 * r->hidden, passes(r) ? "pass" : "fail");
        failed += !passes(r);
    }
    fflush(stdout);
    return failed;
}

static void drawn_is_queried(void **state)
{
    (void)state;
    static const double eyes[] = { 2.0, 6.0, 15.0, 100.0 };
    int failed = 0;
    print_head();
    for (size_t i = 0; i < 2 * KINDS; i++) {
        const struct kind *k = &kinds[i % KINDS];
        bool fft = i >= KINDS;
        make_sea(k, fft);
        for (size_t e = 0; e < sizeof eyes / sizeof *eyes; e++) {
            /* Trochoids from half the eyes, cascades from the others. */
            if ((i + e) % 2) {
                continue;
            }
            struct test_look look = { eyes[e], 0.0, -6.0, 0.0, 40.0, 512, 384 };
            struct result r[RANGES];
            compare(k, look, 3, r);
            failed += print_rows(k, fft, look, r);
        }
        pel_sea_finish(&sea);
    }
    assert_int_equal(failed, 0);
}

static int whole_table(void)
{
    static const double eyes[] = { 2.0, 6.0, 15.0, 30.0, 100.0 };
    int failed = 0, rows = 0;
    begin_renderer(NULL);
    print_head();
    for (size_t i = 0; i < 2 * KINDS; i++) {
        const struct kind *k = &kinds[i % KINDS];
        bool fft = i >= KINDS;
        make_sea(k, fft);
        for (size_t e = 0; e < 2 * (sizeof eyes / sizeof *eyes); e++) {
            struct test_look look = {
                eyes[e / 2], e % 2 ? 70.0 : 0.0, -6.0, 0.0, 60.0, 1024, 768
            };
            struct result r[RANGES];
            compare(k, look, 3, r);
            failed += print_rows(k, fft, look, r);
            rows += RANGES;
        }
        pel_sea_finish(&sea);
    }
    end_renderer(NULL);
    printf("\n%d of %d rows fail.\n", failed, rows);
    return failed > 0;
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--all") == 0) {
        return whole_table();
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drawn_is_queried),
    };
    return cmocka_run_group_tests(tests, begin_renderer, end_renderer);
}
