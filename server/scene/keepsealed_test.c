/* The state file of a node of an exercise. */
#include <glib.h>
#include <glib/gstdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/led.h"
#include "scene/scene_testkit.h"

static char *folder, *path;

static int begin(void **state)
{
    (void)state;
    folder = g_dir_make_tmp("pelagos-sealed-XXXXXX", NULL);
    path = g_build_filename(folder, "state", NULL);
    return 0;
}

static int end(void **state)
{
    (void)state;
    GDir *dir = g_dir_open(folder, 0, NULL);
    const char *name;
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

static struct pel_scene *make(bool sealed)
{
    return make_scene((struct pel_scene_options){
        .state_path = path, .wave_count = 20, .sealed = sealed });
}

static void keep(struct pel_scene *scene)
{
    const Pelagos__State *s = pel_scene_state(scene);
    size_t size = pelagos__state__get_packed_size(s);
    g_autofree uint8_t *bytes = g_malloc(size);
    pelagos__state__pack(s, bytes);
    pel_scene_keep_sealed(scene, bytes, size, s->revision);
}

static bool has(const char *suffix, const char *text)
{
    g_autofree char *file = g_strconcat(path, suffix, NULL);
    g_autofree char *data = NULL;
    return g_file_get_contents(file, &data, NULL, NULL) &&
           (!text || strstr(data, text));
}

static void await(const char *text)
{
    gint64 end_us = g_get_monotonic_time() + 20000000;
    while (!has("", text)) {
        assert_true(g_get_monotonic_time() < end_us);
        g_main_context_iteration(NULL, FALSE);
        g_usleep(5000);
    }
}

static void wait_for(double seconds)
{
    gint64 end_us = g_get_monotonic_time() + (gint64)(seconds * 1e6);
    while (g_get_monotonic_time() < end_us) {
        g_main_context_iteration(NULL, FALSE);
        g_usleep(5000);
    }
}

/* Only what is said to be sealed comes into the file; and no journal. */
static void it_has_what_is_sealed(void **state)
{
    (void)state;
    struct pel_scene *scene = make(true);
    assert_false(has(".journal", NULL));
    assert_true(pel_scene_keeps_sealed(scene));
    must(scene, "{\"clock\":{\"mode\":\"STEPPED\"},\"sea\":{\"windSpeed\":9}}");
    keep(scene);
    must(scene, "{\"sea\":{\"windSpeed\":17}}"); /* never sealed */
    await("\"windSpeed\": 9,");
    wait_for(1.5);
    assert_true(has("", "\"windSpeed\": 9,"));
    assert_false(has(".journal", NULL));
    assert_true(pel_scene_destroy(scene));
    assert_true(has("", "\"windSpeed\": 9,"));
    scene = make(false);
    assert_false(pel_scene_keeps_sealed(scene));
    assert_true(pel_scene_state(scene)->sea->wind_speed == 9);
    assert_true(pel_scene_destroy(scene));
}

/* What was sealed since the last write is there at the end. */
static void the_end_writes(void **state)
{
    (void)state;
    struct pel_scene *scene = make(true);
    must(scene, "{\"sea\":{\"windSpeed\":11}}");
    keep(scene);
    must(scene, "{\"sea\":{\"windSpeed\":12}}");
    keep(scene);
    must(scene, "{\"sea\":{\"windSpeed\":13}}");
    assert_true(pel_scene_destroy(scene));
    assert_true(has("", "\"windSpeed\": 12,"));
}

/* A file of another time is kept beside, once; the journal of a daemon that was
 * killed is part of it. */
static void it_gives_way(void **state)
{
    (void)state;
    g_autofree char *killed = g_strconcat(path, ".journal", NULL);
    g_autofree char *saved = g_strconcat(path, ".saved", NULL);
    struct pel_scene *scene = make(false);
    must(scene, "{\"sea\":{\"windSpeed\":5}}");
    g_rename(killed, saved); /* its name is removed in the end */
    assert_true(pel_scene_destroy(scene));
    g_rename(saved, killed);
    scene = make(true);
    assert_true(pel_scene_state(scene)->sea->wind_speed == 5);
    assert_false(has(".journal", NULL));
    pel_scene_set_aside(scene);
    assert_true(has(".aside", "\"windSpeed\": 5,"));
    must(scene, "{\"sea\":{\"windSpeed\":6}}");
    keep(scene);
    await("\"windSpeed\": 6,");
    pel_scene_set_aside(scene);
    assert_true(has("", "\"windSpeed\": 6,"));
    assert_false(has(".aside.2", NULL));
    assert_true(pel_scene_destroy(scene));
}

/* Who begins the exercise with the file keeps it where it is. */
static void it_begins_the_exercise(void **state)
{
    (void)state;
    struct pel_scene *scene = make(false);
    must(scene, "{\"sea\":{\"windSpeed\":5}}");
    assert_true(pel_scene_destroy(scene));
    scene = make(true);
    keep(scene);
    pel_scene_set_aside(scene); /* it joins again later */
    assert_false(has(".aside", NULL));
    assert_true(pel_scene_destroy(scene));
    assert_true(has("", "\"windSpeed\": 5,"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(it_has_what_is_sealed, begin, end),
        cmocka_unit_test_setup_teardown(the_end_writes, begin, end),
        cmocka_unit_test_setup_teardown(it_gives_way, begin, end),
        cmocka_unit_test_setup_teardown(it_begins_the_exercise, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
