#include "scene/led.h"

#include <glib.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "scene/scene_testkit.h"

static struct pel_scene *scene, *led;
static GPtrArray *entries; /* that the scene accepted since the last frame */

static void heard(void *user, double time_s, const Pelagos__Patch *from)
{
    (void)user;
    if (from) {
        Pelagos__LogEntry *e = (Pelagos__LogEntry *)pel_message_new(
            &pelagos__log_entry__descriptor);
        e->has_time = true;
        e->time = time_s;
        e->command_case = PELAGOS__LOG_ENTRY__COMMAND_PATCH;
        e->patch = (Pelagos__Patch *)pel_message_copy(&from->base);
        g_ptr_array_add(entries, e);
    }
}

static int begin(void **state)
{
    (void)state;
    const struct pel_scene_options options = { .wave_count = 20 };
    entries = g_ptr_array_new();
    scene = make_scene(options);
    led = make_scene(options);
    return 0;
}

static int end(void **state)
{
    (void)state;
    assert_true(pel_scene_destroy(scene));
    assert_true(pel_scene_destroy(led));
    g_ptr_array_free(entries, TRUE);
    return 0;
}

static void begin_led(void)
{
    struct pel_fault fault;
    double time_s = pel_scene_moment(scene);
    pel_scene_anew(scene, time_s);
    pel_scene_listen(scene, heard, NULL);
    pel_scene_lead(led, "node b is led by a");
    Pelagos__State *head = (Pelagos__State *)pel_message_copy(
        &pel_scene_state_at(scene, time_s)->base);
    assert_int_equal(pel_scene_begin_anew(led, head, &fault), PEL_OK);
}

/* What the scene accepted and the moment it has come to, by the led one. */
static void frame(void)
{
    struct pel_fault fault;
    double time_s = pel_scene_moment(scene);
    for (guint i = 0; i < entries->len; i++) {
        Pelagos__LogEntry *e = g_ptr_array_index(entries, i);
        if (pel_scene_play(led, e, &fault)) {
            fail_msg("%s %s", fault.path, fault.message);
        }
        pelagos__log_entry__free_unpacked(e, NULL);
    }
    g_ptr_array_set_size(entries, 0);
    assert_int_equal(pel_scene_play_to(led, time_s, &fault), PEL_OK);
    const Pelagos__State *ours = pel_scene_state_at(scene, time_s);
    const Pelagos__State *theirs = pel_scene_state_at(led, time_s);
    if (!pel_message_same(&ours->base, &theirs->base)) {
        fail_msg("%s\n%s", pel_json_from_message(&ours->base, true),
                 pel_json_from_message(&theirs->base, true));
    }
    assert_true(ours->revision == theirs->revision);
}

/* Every bit, clock.mode and revision too, while time runs freely here and is
 * led there; ships that sail, a clock that is set, stopped and stepped. */
static void the_led_scene_is_the_same(void **state)
{
    (void)state;
    static const char *const edits[] = {
        "{\"ownShip\":{\"on\":true,\"throttle\":0.8,\"rudder\":12}}",
        "{\"sea\":{\"windSpeed\":13}}",
        "{\"clock\":{\"rate\":20}}",
        "{\"entities\":{\"7\":{\"speed\":6,\"course\":90}}}",
        "{\"clock\":{\"time\":5}}",
        "{\"views\":{\"wing\":{\"entity\":7,\"width\":64,\"height\":36}}}",
        "{\"clock\":{\"rate\":0}}",
        "{\"clock\":{\"mode\":\"STEPPED\",\"rate\":1}}",
        "{\"ownShip\":{\"rudder\":-20}}",
        "{\"clock\":{\"mode\":\"FREE\"}}",
    };
    begin_led();
    for (size_t i = 0; i < G_N_ELEMENTS(edits); i++) {
        frame();
        must(scene, edits[i]);
        if (strstr(edits[i], "STEPPED")) {
            assert_int_equal(pel_scene_step(scene, 2.5, NULL), PEL_OK);
        }
        g_usleep(30000);
        must(scene, "{\"entities\":{\"1\":{\"pitch\":1}}}");
        frame();
    }
    assert_int_equal(pel_scene_state(led)->clock->mode,
                     PELAGOS__CLOCK_MODE__FREE);
}

static int ends[16], end_count;

static void ended(void *user, enum pel_err err, const struct pel_fault *fault)
{
    assert_int_equal(err, fault->code);
    ends[end_count++] = err ? -(int)err : (int)(intptr_t)user;
}

static bool submit(struct pel_scene *to, const void *source, int number,
                   const char *json)
{
    Pelagos__Patch *read = read_patch(json);
    const struct pel_scene_wish wish = { .patch = read, .source = source };
    bool waits = pel_scene_submit(to, &wish, ended, (void *)(intptr_t)number);
    pelagos__patch__free_unpacked(read, NULL);
    return waits;
}

static void others_are_refused(void **state)
{
    (void)state;
    struct pel_fault fault;
    begin_led();
    uint64_t before = pel_scene_state(led)->revision;
    end_count = 0;
    assert_int_equal(patch(led, "{\"sea\":{\"windSpeed\":1}}", &fault),
                     PEL_ERR_CONFLICT);
    assert_string_equal(fault.message, "node b is led by a");
    assert_false(submit(led, NULL, 1, "{\"sea\":{\"windSpeed\":2}}"));
    assert_int_equal(ends[0], -(int)PEL_ERR_CONFLICT);
    assert_int_equal(pel_scene_step(led, 1, &fault), PEL_ERR_CONFLICT);
    assert_string_equal(fault.message, "node b is led by a");
    pel_scene_set_stale(led, PEL_STALE_NMEA, true);
    assert_true(pel_scene_state(led)->revision == before);
    double stood = pel_scene_time(led);
    g_usleep(20000);
    assert_true(pel_scene_time(led) == stood);
    assert_int_equal(pel_scene_play_to(led, stood - 1e-6, &fault),
                     PEL_ERR_CONFLICT);
    pel_scene_unlead(led);
    g_usleep(20000);
    double now = pel_scene_time(led);
    assert_true(now > stood && now < stood + 30);
    must(led, "{\"sea\":{\"windSpeed\":1}}");
}

/* Answers come with the seal of their frame, refusals at once, and what is not
 * sealed is refused. */
static void answers_wait_for_their_seal(void **state)
{
    (void)state;
    int one = 0;
    struct pel_fault lost = { 0 };
    end_count = 0;
    assert_false(
        submit(scene, NULL, 1, "{\"entities\":{\"1\":{\"heading\":1}}}"));
    assert_int_equal(ends[0], 1); /* no gate yet */
    pel_scene_gate(scene, 5);
    assert_true(
        submit(scene, NULL, 2, "{\"entities\":{\"1\":{\"heading\":2}}}"));
    assert_int_equal(entity_of(scene, 1)->heading, 2);
    assert_false(
        submit(scene, NULL, 3, "{\"entities\":{\"1\":{\"heading\":999}}}"));
    assert_int_equal(end_count, 2);
    assert_int_equal(ends[1], -(int)PEL_ERR_OUT_OF_RANGE);
    pel_scene_gate(scene, 6);
    assert_true(
        submit(scene, &one, 4, "{\"entities\":{\"1\":{\"heading\":4}}}"));
    assert_true(pel_scene_await(scene, NULL, ended, (void *)(intptr_t)6));
    pel_scene_sealed(scene, 4);
    assert_int_equal(end_count, 2);
    pel_scene_sealed(scene, 5);
    assert_int_equal(end_count, 3);
    assert_int_equal(ends[2], 2);
    pel_scene_forget(scene, &one); /* its client is gone */
    pel_scene_sealed(scene, 6);
    assert_int_equal(end_count, 4);
    assert_int_equal(ends[3], 6);
    pel_scene_gate(scene, 7);
    assert_true(
        submit(scene, NULL, 5, "{\"entities\":{\"1\":{\"heading\":5}}}"));
    pel_fault_set(&lost, PEL_ERR_CONFLICT, "it was not sealed");
    pel_scene_ungate(scene, &lost);
    assert_int_equal(ends[4], -(int)PEL_ERR_CONFLICT);
    assert_false(pel_scene_await(scene, NULL, ended, NULL));
    assert_false(
        submit(scene, NULL, 8, "{\"entities\":{\"1\":{\"heading\":8}}}"));
    assert_int_equal(ends[5], 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_led_scene_is_the_same, begin, end),
        cmocka_unit_test_setup_teardown(others_are_refused, begin, end),
        cmocka_unit_test_setup_teardown(answers_wait_for_their_seal, begin,
                                        end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
