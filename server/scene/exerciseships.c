/* The own ships of an exercise, ownShip first, and the facts of all of them: a
 * sheet each (exercisefacts.c). */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "scene/exercise_parts.h"

/* --- which there are ------------------------------------------------------ */

size_t pel_exercise_ship_count(const Pelagos__Exercise *exercise)
{
    return 1 + MIN(exercise->n_ships, PEL_EXERCISE_SHIPS - 1);
}

uint32_t pel_exercise_ship(const Pelagos__Exercise *exercise, size_t index)
{
    return index == 0 ? exercise->own_ship : exercise->ships[index - 1]->id;
}

int pel_exercise_ship_index(const Pelagos__Exercise *exercise, uint32_t id)
{
    for (size_t i = 0; i < pel_exercise_ship_count(exercise); i++) {
        if (pel_exercise_ship(exercise, i) == id) {
            return (int)i;
        }
    }
    return -1;
}

double pel_exercise_draught(const Pelagos__Exercise *exercise, uint32_t id)
{
    int index = pel_exercise_ship_index(exercise, id);
    if (index == 0) {
        return exercise->has_draught ? exercise->draught : NAN;
    }
    return index > 0 && exercise->ships[index - 1]->has_draught
               ? exercise->ships[index - 1]->draught
               : NAN;
}

/* --- their facts ---------------------------------------------------------- */

struct pel_exercise_facts {
    size_t count;
    struct pel_exercise_sheet *sheets[PEL_EXERCISE_SHIPS];
};

/* Of `FOLDER/STATE.exercise.csv` for ship 7 `FOLDER/STATE.exercise.7.csv`; NULL
 * of NULL. */
static char *path_of(const Pelagos__Exercise *exercise, size_t index,
                     const char *path)
{
    if (!path || index == 0) {
        return g_strdup(path);
    }
    int stem = (int)(strlen(path) - strlen(".csv"));
    return g_strdup_printf("%.*s.%u.csv", stem, path,
                           pel_exercise_ship(exercise, index));
}

void pel_exercise_facts_remove(const Pelagos__Exercise *exercise,
                               const char *path)
{
    for (size_t i = 1; i < pel_exercise_ship_count(exercise); i++) {
        g_autofree char *own = path_of(exercise, i, path);
        unlink(own);
    }
}

struct pel_exercise_facts *
pel_exercise_facts_create(const Pelagos__Exercise *exercise, const char *path,
                          double since_s)
{
    struct pel_exercise_facts *f = g_new0(struct pel_exercise_facts, 1);
    f->count = pel_exercise_ship_count(exercise);
    for (size_t i = 0; i < f->count; i++) {
        g_autofree char *own = path_of(exercise, i, path);
        f->sheets[i] = pel_exercise_sheet_create(exercise, i, own, since_s);
    }
    return f;
}

void pel_exercise_facts_destroy(struct pel_exercise_facts *f)
{
    for (size_t i = 0; f && i < f->count; i++) {
        pel_exercise_sheet_destroy(f->sheets[i]);
    }
    g_free(f);
}

void pel_exercise_facts_add(struct pel_exercise_facts *f,
                            struct pel_exercise_moment *m)
{
    for (size_t i = 0; i < f->count; i++) {
        pel_exercise_sheet_add(f->sheets[i], m);
    }
}

void pel_exercise_facts_cut(struct pel_exercise_facts *f, double time_s)
{
    for (size_t i = 0; i < f->count; i++) {
        pel_exercise_sheet_cut(f->sheets[i], time_s);
    }
}

const struct pel_exercise_sheet *
pel_exercise_facts_of(const struct pel_exercise_facts *f, size_t index)
{
    return f->sheets[index];
}

size_t pel_exercise_facts_bytes(const struct pel_exercise_facts *f)
{
    size_t bytes = 0;
    for (size_t i = 0; i < f->count; i++) {
        bytes += pel_exercise_sheet_bytes(f->sheets[i]);
    }
    return bytes;
}
