/* The layers that protocols name are those that the renderer has. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "frames/frames.h"
#include "render/renderer.h"

static void names_are_told_once(void **state)
{
    (void)state;
    char names[256] = "";
    for (int i = 0; i < PEL_LAYERS; i++) {
        strcat(names, i ? ", " : "");
        strcat(names, pel_layer_table[i].name);
        assert_true(pel_frames_layer_exists(pel_layer_table[i].name));
    }
    assert_string_equal(names, PEL_FRAMES_LAYERS);
    assert_false(pel_frames_layer_exists("color"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_told_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
