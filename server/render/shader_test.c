/* Shaders of a folder are put together as the embedded ones are. */
#include "render/shader.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void folder_is_what_is_embedded(void **state)
{
    (void)state;
    int count = 0;
    for (const struct pel_shader_source *s = pel_shader_sources; s->name; s++) {
        if (strncmp(s->name, "lib/", 4) == 0) {
            continue;
        }
        char *text = pel_shader_read("shaders", s->name);
        assert_non_null(text);
        if (strcmp(text, s->text) != 0) {
            fail_msg("%s is another text", s->name);
        }
        free(text);
        count++;
    }
    assert_true(count > 50);
}

static void what_is_missing_is_refused(void **state)
{
    (void)state;
    assert_null(pel_shader_read("shaders", "no.frag"));
    assert_null(pel_shader_read("/nowhere", "sky.frag"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(folder_is_what_is_embedded),
        cmocka_unit_test(what_is_missing_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
