/* Ship waves as the scene has them. */
#include "scene/wakes.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "scene/scene_testkit.h"

/* A ship of 100 m that goes north at 12 knots from 1200 m south of the origin,
 * over a calm sea. */
static const char ship[] =
    "{\"clock\":{\"mode\":\"STEPPED\",\"time\":0,\"reckoning\":3600},"
    "\"sea\":{\"windSpeed\":0,\"whitecaps\":0,\"synthesiser\":\"TROCHOIDS\"},"
    "\"entities\":{"
    "\"5\":{\"latitude\":-0.0108,\"speed\":6.17,\"wake\":true,"
    "\"model\":{\"name\":\"tanker\",\"length\":100}}}}";

static struct pel_scene *begin(void)
{
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 40 });
    must(scene, "{\"origin\":{\"latitude\":0,\"longitude\":0}}");
    must(scene, ship);
    return scene;
}

/* What takes milliseconds is left to threads, as with an FFT sea. */
static void control_leaves_it_to_others(void **state)
{
    (void)state;
    struct pel_scene *scene = begin();
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_non_null(s->wakes);
    assert_true(pel_snapshot_transforms(s));
    pel_snapshot_unref(s);
    must(scene, "{\"entities\":{\"5\":{\"wake\":false}}}");
    s = pel_scene_snapshot(scene);
    assert_null(s->wakes);
    assert_false(pel_snapshot_transforms(s));
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(control_leaves_it_to_others),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
