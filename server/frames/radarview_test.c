/* Views that are a radar's, served like any other. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/vec.h"
#include "frames/frames_testkit.h"
#include "frames/radarview.h"

static struct answer picture(Pelagos__FrameFormat format, double time_s)
{
    struct answer answer = { 0 };
    Pelagos__FrameRequest request = small(format);
    request.view = (char *)"radar";
    request.has_time = true;
    request.time = time_s;
    ask(&request, &answer);
    run_until(&answer.calls, 1);
    assert_int_equal(answer.err, PEL_OK);
    return answer;
}

/* Beside pictures of GL, in any order, the same bytes. */
static void served_in_any_order(void **state)
{
    (void)state;
    struct answer first = picture(PELAGOS__FRAME_FORMAT__PNG, 31.7);
    struct answer other = picture(PELAGOS__FRAME_FORMAT__JPEG, 700.2);
    struct answer eye = { 0 }, together = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__PNG);
    request.has_time = true;
    request.time = 31.7;
    ask(&request, &eye);
    request.view = (char *)"radar";
    ask(&request, &together);
    run_until(&eye.calls, 1);
    run_until(&together.calls, 1);
    assert_int_equal(first.frame->size, together.frame->size);
    assert_memory_equal(first.frame->data, together.frame->data,
                        first.frame->size);
    assert_int_equal(other.frame->width, 200);
    drop(&first);
    drop(&other);
    drop(&eye);
    drop(&together);
}

/* A picture larger than a band, between others. */
static void large_ones_too(void **state)
{
    (void)state;
    struct answer large = { 0 };
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__JPEG);
    request.view = (char *)"radar";
    request.has_width = request.has_height = true;
    request.width = request.height = 2000;
    ask(&request, &large);
    run_until(&large.calls, 1);
    assert_int_equal(large.err, PEL_OK);
    assert_int_equal(large.frame->height, 2000);
    drop(&large);
}

static void layers_are_refused(void **state)
{
    (void)state;
    struct answer answer = { 0 };
    struct pel_fault fault;
    Pelagos__FrameRequest request = small(PELAGOS__FRAME_FORMAT__EXR);
    request.view = (char *)"radar";
    assert_int_equal(
        pel_frames_request(frames, &request, take, &answer, NULL, &fault),
        PEL_ERR_INVALID);
    assert_string_equal(fault.path, "format");
}

/* A boat that crosses: the brightest echo beyond the clutter and what is within
 * 12 pixels are where she was when the antenna passed, within half a beam and a
 * pulse; in one turn of six she may fade into the clutter (Swerling). */
static void ships_are_where_they_were(void **state)
{
    (void)state;
    enum { SIDE = 600, TURNS = 12, NEAR = 12 };
    static uint8_t rgba[SIDE * SIDE * 4];
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    int view = pel_snapshot_find_view(s, "radar"), found = 0;
    size_t boat = 0;
    while (s->entities[boat].id != 3) {
        boat++;
    }
    for (int k = 0; k < TURNS; k++) {
        double time = 20 + 3.1 * k, x = 0, y = 0, sum = 0;
        int top = 0;
        assert_int_equal(
            pel_radar_view_show(s, (size_t)view, time, SIDE, SIDE, NULL, rgba),
            PEL_OK);
        for (int i = 0; i < SIDE * SIDE; i++) {
            top = rgba[4 * i] > rgba[4 * top] &&
                          hypot(i % SIDE - 300, 300 - i / SIDE) > 150
                      ? i
                      : top;
        }
        for (int i = 0; i < SIDE * SIDE; i++) {
            if (hypot(i % SIDE - top % SIDE, i / SIDE - top / SIDE) < NEAR) {
                double v = fmax(rgba[4 * i] - 10.0, 0);
                x += v * (i % SIDE - 0.5 * SIDE + 0.5);
                y += v * (0.5 * SIDE - i / SIDE - 0.5);
                sum += v;
            }
        }
        double scale = 3 * 1852 / (0.47 * SIDE);
        double bearing = atan2(x, y), range = hypot(x, y) / sum * scale;
        double share = bearing / (2 * PEL_PI);
        share -= floor(share);
        struct pel_entity_state e;
        pel_snapshot_entity_level(
            s, boat, (floor(time / 2.5 - share) + share) * 2.5, &e);
        double off =
            remainder(bearing - atan2(e.east_m, e.north_m), 2 * PEL_PI);
        double late = range - hypot(e.east_m, e.north_m);
        found += fabs(off) < 0.6 * PEL_DEG && fabs(late) < 45;
    }
    if (found < TURNS - TURNS / 6) {
        fail_msg("found in %d turns of %d", found, TURNS);
    }
    pel_snapshot_unref(s);
}

static int begin(void **state)
{
    set_up(state);
    must(scene,
         "{\"views\":{\"radar\":{\"width\":200,\"height\":200,\"up\":25,"
         "\"radar\":{\"range\":3,\"rings\":false,\"gain\":0.35,\"stc\":0.5}}},"
         "\"sea\":{\"windSpeed\":4},\"entities\":{\"3\":{"
         "\"model\":{\"name\":\"pilot-launch\"},\"latitude\":52.6225,"
         "\"longitude\":5.2369,\"speed\":15,\"course\":300,"
         "\"heading\":300}}}");
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(served_in_any_order),
        cmocka_unit_test(large_ones_too),
        cmocka_unit_test(layers_are_refused),
        cmocka_unit_test(ships_are_where_they_were),
    };
    return cmocka_run_group_tests(tests, begin, tear_down);
}
