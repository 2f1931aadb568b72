/* Bytes → exercise: what is accepted is written, read again as the same, and
 * its conditions are looked at. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "json.h"
#include "scene/exercise.h"
#include "scene/exercisewhen.h"
#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static struct pel_scene *scene(void)
{
    static struct pel_scene *made;
    const struct pel_scene_options options = { .wave_count = 20 };
    if (!made && pel_scene_create(&options, &made, NULL)) {
        abort();
    }
    return made;
}

static void look(const Pelagos__Exercise *exercise)
{
    static struct pel_exercise_moment moment;
    const struct pel_snapshot *s = pel_scene_snapshot(scene());
    pel_exercise_moment_init(&moment, exercise, pel_scene_state(scene()), s, 1,
                             1);
    for (size_t i = 0; i < exercise->n_events; i++) {
        (void)pel_exercise_holds(&moment, exercise->events[i]);
    }
    pel_snapshot_unref(s);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Pelagos__Exercise *exercise, *again;
    struct pel_fault fault;
    if (pel_exercise_read((const char *)data, size, &exercise, &fault)) {
        return 0;
    }
    char *text = pel_json_from_message(&exercise->base, true);
    if (pel_exercise_read(text, strlen(text), &again, &fault)) {
        abort(); /* what is good stays so */
    }
    char *twice = pel_json_from_message(&again->base, true);
    if (strcmp(text, twice) != 0) {
        abort();
    }
    look(exercise);
    pelagos__exercise__free_unpacked(exercise, NULL);
    pelagos__exercise__free_unpacked(again, NULL);
    free(text);
    free(twice);
    return 0;
}
