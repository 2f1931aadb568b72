#include "scene/sealedlog.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "pelog.h"
#include "scene/led.h"
#include "scene/record.h"
#include "scene/replay.h"
#include "scene/scene_testkit.h"

#define MARKS 64

static char *folder, *path;
static struct pel_scene *scene; /* the master's */
static struct pel_sealedlog *sealed;
static GPtrArray *entries; /* that the scene accepted since the last frame */
static uint64_t number;    /* of the last frame */

static void heard(void *user, double time_s, const Pelagos__Patch *from)
{
    (void)user;
    if (from) {
        Pelagos__LogEntry *e = (Pelagos__LogEntry *)pel_message_new(
            &pelagos__log_entry__descriptor);
        e->has_time = e->has_revision = true;
        e->time = time_s;
        e->revision = pel_scene_state(scene)->revision;
        e->command_case = PELAGOS__LOG_ENTRY__COMMAND_PATCH;
        e->patch = (Pelagos__Patch *)pel_message_copy(&from->base);
        g_ptr_array_add(entries, e);
    }
}

static void free_entry(void *entry)
{
    pelagos__log_entry__free_unpacked(entry, NULL);
}

static int begin(void **state)
{
    (void)state;
    folder = g_dir_make_tmp("pelagos-sealed-XXXXXX", NULL);
    path = g_build_filename(folder, "log.pelog", NULL);
    scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\",\"time\":100},\"ownShip\":{"
                "\"on\":true,\"throttle\":0.8,\"rudder\":12}}");
    sealed = pel_sealedlog_create();
    entries = g_ptr_array_new_with_free_func(free_entry);
    number = 0;
    pel_scene_listen(scene, heard, NULL);
    return 0;
}

static int end(void **state)
{
    (void)state;
    GDir *dir = g_dir_open(folder, 0, NULL);
    const char *name;
    pel_sealedlog_destroy(sealed);
    assert_true(pel_scene_destroy(scene));
    g_ptr_array_free(entries, TRUE);
    while ((name = g_dir_read_name(dir))) {
        g_autofree char *file = g_build_filename(folder, name, NULL);
        g_unlink(file);
    }
    g_dir_close(dir);
    g_rmdir(folder);
    g_free(folder);
    g_free(path);
    return 0;
}

static Pelagos__State *whole(void)
{
    return (Pelagos__State *)pel_message_copy(&pel_scene_state(scene)->base);
}

/* A node joins with the scene's state, of this frame. */
static void join(uint64_t at)
{
    pel_scene_anew(scene, pel_scene_time(scene));
    number = at;
    pel_sealedlog_begin(sealed, number, whole());
}

/* What the scene accepted since the last frame, sealed at this time. */
static void seal(double time_s, bool anew)
{
    struct pel_fault fault;
    if (pel_scene_step_to(scene, time_s, &fault)) {
        fail_msg("%s", fault.message);
    }
    const struct pel_sealedlog_frame frame = {
        .number = ++number,
        .entries = (Pelagos__LogEntry **)entries->pdata,
        .count = entries->len,
        .time_s = time_s,
        .revision = pel_scene_state(scene)->revision,
        .mode = PEL_CLOCK_STEPPED,
        .anew = anew ? whole() : NULL,
    };
    if (anew) {
        pel_scene_anew(scene, time_s);
    }
    pel_sealedlog_add(sealed, &frame);
    g_ptr_array_set_size(entries, 0);
}

static struct pel_record *record(double segment_mib)
{
    struct pel_fault fault;
    struct pel_record *out;
    const struct pel_record_options options = {
        path, segment_mib, 20, 1000, "test 1", "a device", 20, sealed, 0,
    };
    if (pel_record_create(&options, scene, &out, &fault)) {
        fail_msg("%s", fault.message);
    }
    return out;
}

/* The log in letters: h head, p patch, s step, w whole state, m one after
 * frames that are missing; 2 before a head: its segment. */
static char *letters(const char *file)
{
    struct pel_log_reader reader;
    struct pel_fault fault;
    Pelagos__LogEntry *e;
    g_autofree char *data = NULL;
    gsize size;
    GString *out = g_string_new(NULL);
    assert_true(g_file_get_contents(file, &data, &size, NULL));
    assert_int_equal(pel_log_open(&reader, data, size, &fault), PEL_OK);
    while (pel_log_next(&reader, &e, &fault) == PEL_OK && e) {
        if (e->head && e->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD) {
            assert_int_equal(e->head->version, PEL_LOG_VERSION_STATES);
            g_string_append_printf(out, "%u", e->head->segment);
        }
        const char *kinds[] = { "?", "?", "?", "h", "p", "s", "w" };
        g_string_append(out, e->missed ? "m" : kinds[e->command_case]);
        pelagos__log_entry__free_unpacked(e, NULL);
    }
    return g_string_free(out, FALSE);
}

static void looks(const char *file, const char *wanted)
{
    g_autofree char *is = letters(file);
    assert_string_equal(is, wanted);
}

/* It waits for the node to join, and has what is sealed from there on; what
 * the scene accepts beyond is not in it. */
static void it_begins_with_the_exercise(void **state)
{
    (void)state;
    struct pel_record *r = record(1);
    assert_false(g_file_test(path, G_FILE_TEST_EXISTS));
    join(0);
    looks(path, "1h");
    must(scene, "{\"sea\":{\"windSpeed\":9}}");
    looks(path, "1h");
    seal(101, false);
    looks(path, "1hps");
    seal(101, false); /* time stands */
    seal(102, true);
    must(scene, "{\"sea\":{\"windSpeed\":3}}"); /* not sealed any more */
    looks(path, "1hpsw");
    pel_record_destroy(r);
    looks(path, "1hpsws");
}

/* Begun in between it has all since the last whole state. */
static void it_begins_with_the_last_state(void **state)
{
    (void)state;
    g_autofree char *other = g_strconcat(path, ".000001", NULL);
    join(7);
    seal(101, false);
    seal(102, true);
    must(scene, "{\"sea\":{\"windSpeed\":9}}");
    seal(103, false);
    struct pel_record *r = record(1);
    looks(path, "1hps");
    seal(104, false);
    looks(path, "1hpss");
    pel_record_destroy(r);
    r = record(1);
    pel_record_destroy(r);
    looks(other, "1hpsss");
    looks(path, "1hpsss");
}

/* A node that begins again with a state from before has the frames already; one
 * that begins with a later one says how many are missing. */
static void frames_that_are_known_and_missing(void **state)
{
    (void)state;
    struct pel_record *r = record(1);
    join(0);
    seal(101, false);
    seal(102, false);
    looks(path, "1hss");
    pel_sealedlog_begin(sealed, 1, whole());
    number = 1;
    seal(102, false);
    looks(path, "1hss");
    seal(103, false);
    looks(path, "1hsss");
    join(20);
    looks(path, "1hsssm");
    struct pel_log_reader reader;
    struct pel_fault fault;
    Pelagos__LogEntry *e;
    g_autofree char *data = NULL;
    gsize size;
    assert_true(g_file_get_contents(path, &data, &size, NULL));
    assert_int_equal(pel_log_open(&reader, data, size, &fault), PEL_OK);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(pel_log_next(&reader, &e, &fault), PEL_OK);
        assert_int_equal(e->missed, i < 4 ? 0 : 17);
        pelagos__log_entry__free_unpacked(e, NULL);
    }
    pel_record_destroy(r);
}

/* A segment that is full ends where a whole state is. */
static void segments_begin_with_a_whole_state(void **state)
{
    (void)state;
    g_autofree char *first = g_strconcat(path, ".000001", NULL);
    join(0);
    struct pel_record *r = record(0.002);
    for (int i = 0; i < 40; i++) {
        seal(100.1 + i, false);
    }
    must(scene, "{\"presets\":{\"x\":{\"patch\":\"{}\"}}}");
    while (!g_file_test(first, G_FILE_TEST_EXISTS) && number < 4000) {
        for (int i = 0; i < 20; i++) {
            seal(pel_scene_time(scene) + 1, false);
        }
        seal(pel_scene_time(scene) + 1, true);
    }
    g_autofree char *before = letters(first);
    assert_null(strchr(before + 2, 'h'));
    assert_int_equal(before[strlen(before) - 1], 's');
    looks(path, "2h");
    pel_record_destroy(r);
}

struct mark {
    struct pel_replay_moment at;
    Pelagos__State *state;
};

static struct mark marks[MARKS];
static size_t mark_count;

static void mark(unsigned stretch)
{
    marks[mark_count++] = (struct mark){
        { stretch, pel_scene_time(scene) },
        whole(),
    };
}

static void is_as_marked(struct pel_replay *replay, const struct mark *m)
{
    struct pel_fault fault;
    struct pel_still still;
    if (pel_replay_go(replay, m->at, &fault)) {
        fail_msg("%s", fault.message);
    }
    pel_replay_still(replay, &still);
    still.state->revision = m->state->revision;
    if (!pel_message_same(&still.state->base, &m->state->base)) {
        g_printerr("%s\n%s\n", pel_json_from_message(&still.state->base, true),
                   pel_json_from_message(&m->state->base, true));
        fail_msg("%u %.17g", m->at.stretch, m->at.time_s);
    }
    pel_still_finish(&still);
}

/* Ships that begin anew on the way, states that leap on and back: a replay has
 * each moment to the bit, in any order. */
static void a_replay_is_the_same(void **state)
{
    (void)state;
    struct pel_fault fault;
    struct pel_replay *replay;
    mark_count = 0;
    join(0);
    struct pel_record *r = record(1);
    for (int i = 1; i <= 20; i++) {
        if (i % 3 == 0) { /* later than the seal before */
            (void)!pel_scene_step(scene, 0.2, NULL);
            must(scene, i % 2 ? "{\"ownShip\":{\"rudder\":-20}}"
                              : "{\"sea\":{\"windSpeed\":11}}");
        }
        seal(100 + 0.73 * i, i % 7 == 0);
        mark(0);
    }
    /* Frames that this node was not told of. */
    must(scene, "{\"sky\":{\"sunElevation\":33}}");
    assert_int_equal(pel_scene_step_to(scene, 118.3, &fault), PEL_OK);
    g_ptr_array_set_size(entries, 0);
    join(number + 5);
    mark(0);
    seal(119.7, false);
    mark(0);
    must(scene, "{\"clock\":{\"time\":50}}");
    g_ptr_array_set_size(entries, 0);
    join(number + 3);
    mark(1);
    for (int i = 1; i <= 5; i++) {
        seal(50 + 1.37 * i, i == 3);
        mark(1);
    }
    pel_record_destroy(r);
    atomic_bool stop = false;
    const struct pel_replay_options options = {
        .directory = folder,
        .name = "log",
        .stop = &stop,
    };
    if (pel_replay_open(&options, &replay, &fault)) {
        fail_msg("%s", fault.message);
    }
    for (size_t i = 0; i < mark_count; i++) {
        is_as_marked(replay, &marks[i]);
    }
    for (size_t i = 0; i < mark_count; i++) {
        is_as_marked(replay, &marks[i * 11 % mark_count]);
    }
    pel_replay_close(replay);
    for (size_t i = 0; i < mark_count; i++) {
        pelagos__state__free_unpacked(marks[i].state, NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(it_begins_with_the_exercise, begin,
                                        end),
        cmocka_unit_test_setup_teardown(it_begins_with_the_last_state, begin,
                                        end),
        cmocka_unit_test_setup_teardown(frames_that_are_known_and_missing,
                                        begin, end),
        cmocka_unit_test_setup_teardown(segments_begin_with_a_whole_state,
                                        begin, end),
        cmocka_unit_test_setup_teardown(a_replay_is_the_same, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
