/* The moments kept: the same bits however they came about. */
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/clock.h"
#include "ocean/fields.h"
#include "ocean/sea.h"

#define POINTS 60

static struct pel_sea_desc desc_of(uint32_t seed)
{
    return (struct pel_sea_desc){
        .synthesiser = PEL_SYNTHESISER_FFT,
        .kind = PEL_SPECTRUM_PIERSON_MOSKOWITZ,
        .wind_mps = 9,
        .seed = seed,
        .wave_count = 60,
    };
}

static void build(struct pel_sea *sea)
{
    struct pel_sea_desc desc = desc_of(7);
    assert_int_equal(pel_sea_build(&desc, sea), PEL_OK);
}

struct answers {
    struct pel_surface_sample sample[POINTS];
};

static void ask(const struct pel_sea *sea, double time_s, bool moving,
                struct answers *out)
{
    struct pel_vec2 points[POINTS];
    for (int i = 0; i < POINTS; i++) {
        points[i] = (struct pel_vec2){ 3.7 * i - 900, 1.3 * i * i };
    }
    memset(out, 0, sizeof *out);
    if (moving) {
        pel_sea_query_moving(sea, points, POINTS, time_s, out->sample);
    } else {
        pel_sea_query(sea, points, POINTS, time_s, out->sample);
    }
}

/* But for the accelerations, which only one of them may have. */
static void assert_same(const struct answers *a, const struct answers *b,
                        bool moving)
{
    for (int i = 0; i < POINTS; i++) {
        struct pel_surface_sample x = a->sample[i], y = b->sample[i];
        if (!moving) {
            x.acceleration_mps2 = y.acceleration_mps2 = (struct pel_vec3){ 0 };
        }
        assert_memory_equal(&x, &y, sizeof x);
    }
}

static bool always(void *user)
{
    (void)user;
    return true;
}

static bool twice(void *user)
{
    int *left = user;
    return (*left)-- > 0;
}

static void any_way_to_a_moment_gives_its_bits(void **state)
{
    (void)state;
    struct pel_sea sea, fresh;
    struct answers want, got;
    build(&fresh);
    ask(&fresh, 12.5, true, &want);
    build(&sea);
    /* deeper step by step */
    pel_sea_displace(&sea, 1, 2, 12.5);
    ask(&sea, 12.5, false, &got);
    assert_same(&got, &want, false);
    ask(&sea, 12.5, true, &got);
    assert_same(&got, &want, true);
    ask(&sea, 12.5, false, &got); /* of a moment that is kept whole */
    assert_same(&got, &want, false);
    /* prepared, in part and wholly; in places that other moments had */
    for (int i = 0; i < 5; i++) {
        int left = i < 4 ? i : 100;
        ask(&sea, 50 + i, true, &got);
        ask(&sea, 60 + i, true, &got);
        ask(&sea, 70 + i, true, &got);
        assert_int_equal(pel_fields_prepare(sea.cascades, 12.5,
                                            PEL_FIELDS_VELOCITY, twice, &left),
                         i == 4);
        ask(&sea, 12.5, i % 2, &got);
        assert_same(&got, &want, i % 2);
    }
    assert_true(
        pel_fields_prepare(sea.cascades, 12.5, PEL_FIELDS_SURGE, always, NULL));
    ask(&sea, 12.5, true, &got);
    assert_same(&got, &want, true);
    /* given back, but what is in use */
    struct pel_kept_fields *kept = NULL;
    assert_int_equal(
        pel_fields_take(sea.cascades, 12.5, PEL_FIELDS_REST, &kept), PEL_OK);
    pel_fields_forget(pel_now_ns());
    assert_true(pel_fields_of(kept)->time_s == 12.5);
    pel_fields_give(sea.cascades, kept);
    pel_fields_forget(pel_now_ns());
    ask(&sea, 12.5, true, &got);
    assert_same(&got, &want, true);
    pel_sea_finish(&sea);
    pel_sea_finish(&fresh);
}

static bool never(void *user)
{
    (void)user;
    return false;
}

static bool is_there(const struct pel_sea *sea, double time_s)
{
    return pel_fields_prepare(sea->cascades, time_s, PEL_FIELDS_VELOCITY, never,
                              NULL);
}

static void what_is_held_stays(void **state)
{
    (void)state;
    struct pel_sea sea, fresh;
    struct answers want, got;
    double held_s[PEL_SEA_HELD];
    build(&sea);
    build(&fresh);
    for (int round = 0; round < 6; round++) { /* a window that goes on */
        for (int i = 0; i < PEL_SEA_HELD; i++) {
            held_s[i] = 0.2 * (round + i);
        }
        pel_sea_hold(&sea, held_s);
        for (int i = 0; i < PEL_SEA_HELD; i++) {
            assert_int_equal(is_there(&sea, held_s[i]),
                             round > 0 && i < PEL_SEA_HELD - 1);
            assert_true(pel_sea_prepare(&sea, held_s[i], false, always, NULL));
        }
        for (int i = 0; i < 9; i++) {
            ask(&sea, 50 + 10 * round + i, true, &got);
        }
        for (int i = 0; i < PEL_SEA_HELD; i++) {
            assert_true(is_there(&sea, held_s[i]));
        }
        assert_true(is_there(&sea, 58 + 10 * round));
        assert_false(is_there(&sea, 50 + 10 * round));
    }
    ask(&fresh, held_s[1], false, &want);
    ask(&sea, held_s[1], false, &got);
    assert_same(&got, &want, false);
    pel_fields_forget(pel_now_ns());
    assert_false(is_there(&sea, held_s[1])); /* nobody asked */
    pel_sea_finish(&sea);
    pel_sea_finish(&fresh);
}

struct asker {
    const struct pel_sea *sea;
    struct answers answers[8];
};

static void *ask_many(void *argument)
{
    struct asker *asker = argument;
    for (int i = 0; i < 8; i++) {
        ask(asker->sea, i, i % 3 == 0, &asker->answers[i]);
    }
    return NULL;
}

static void threads_share_the_work(void **state)
{
    (void)state;
    static struct asker askers[4];
    struct pel_sea sea, fresh;
    struct answers want;
    pthread_t threads[4];
    build(&sea);
    build(&fresh);
    for (int i = 0; i < 4; i++) {
        askers[i].sea = &sea;
        assert_int_equal(
            pthread_create(&threads[i], NULL, ask_many, &askers[i]), 0);
    }
    for (int i = 0; i < 4; i++) {
        pthread_join(threads[i], NULL);
    }
    for (int i = 0; i < 8; i++) {
        ask(&fresh, i, true, &want);
        for (int k = 0; k < 4; k++) {
            assert_same(&askers[k].answers[i], &want, i % 3 == 0);
        }
    }
    pel_sea_finish(&sea);
    pel_sea_finish(&fresh);
}

/* Velocity and acceleration are the derivatives of the displacement. */
static void fields_are_derivatives(void **state)
{
    (void)state;
    const double step = 1e-3;
    struct pel_sea_desc desc = desc_of(3);
    struct pel_cascades *c;
    struct pel_cascade_fields *f[3];
    assert_int_equal(pel_cascades_create(&desc, &c), PEL_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(
            pel_cascade_fields_create(c, 5 + (i - 1) * step, &f[i]), PEL_OK);
    }
    /* Floats of a metre differ by 1e-7, over 2e-3 s: 1e-4 m/s; velocities of
     * some m/s by 5e-7: 5e-4 m/s². What the difference itself leaves out is
     * (ω step)² / 6 < 1e-3 of the shortest waves' share. */
    for (int k = 0; k < PEL_CASCADES; k++) {
        for (int at = 0; at < PEL_CASCADE_MODES; at += 37) {
            for (int axis = 0; axis < 3; axis++) {
                double v = ((double)f[2]->displacement[k][at][axis] -
                            (double)f[0]->displacement[k][at][axis]) /
                           (2 * step);
                double a = ((double)f[2]->velocity[k][at][axis] -
                            (double)f[0]->velocity[k][at][axis]) /
                           (2 * step);
                double acceleration = axis < 2 ? f[1]->surge[k][at][axis]
                                               : f[1]->velocity[k][at][3];
                double scale = 1 + fabs(a);
                assert_true(fabs(v - f[1]->velocity[k][at][axis]) < 1e-3);
                assert_true(fabs(a - acceleration) < 3e-3 * scale);
            }
        }
    }
    for (int i = 0; i < 3; i++) {
        pel_cascade_fields_destroy(f[i]);
    }
    pel_cascades_destroy(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_way_to_a_moment_gives_its_bits),
        cmocka_unit_test(what_is_held_stays),
        cmocka_unit_test(threads_share_the_work),
        cmocka_unit_test(fields_are_derivatives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
