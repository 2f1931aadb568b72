#include "bridges/cigi_exercise.h"

#include <glib.h>

#include "fault.h"

/* Whether it says what the last one said. */
static bool repeats(struct pel_cigi_exercise *e,
                    const struct pel_cigi_component *c)
{
    bool same = e->heard && e->instance == c->instance &&
                e->state == c->state && e->word == c->word[0];
    e->heard = true;
    e->instance = c->instance;
    e->state = c->state;
    e->word = c->word[0];
    return same;
}

static enum pel_err command(struct pel_cigi_exercise *e,
                            Pelagos__ExerciseAction action, char *name,
                            double time_s, struct pel_fault *fault)
{
    Pelagos__ExerciseCommand c = PELAGOS__EXERCISE_COMMAND__INIT;
    Pelagos__ExerciseStatus *status;
    c.has_action = true;
    c.action = action;
    c.name = name;
    c.has_time = action == PELAGOS__EXERCISE_ACTION__REWIND;
    c.time = time_s;
    enum pel_err err = pel_exercises_command(e->all, &c, &status, fault);
    if (!err) {
        pelagos__exercise_status__free_unpacked(status, NULL);
    }
    return err;
}

/* Of the exercise that is loaded; a start loads another first. */
static enum pel_err act(struct pel_cigi_exercise *e,
                        const struct pel_cigi_component *c, char *name,
                        struct pel_fault *fault)
{
    struct pel_exercise_glance glance;
    Pelagos__ExerciseAction action = (Pelagos__ExerciseAction)c->state;
    pel_exercises_glance(e->all, &glance);
    bool loaded = glance.phase != PELAGOS__EXERCISE_PHASE__IDLE &&
                  pel_exercises_number(e->all, NULL) == (int)c->instance;
    bool over = glance.phase == PELAGOS__EXERCISE_PHASE__ENDED;
    enum pel_err err = PEL_OK;
    if (action == PELAGOS__EXERCISE_ACTION__START && (!loaded || over)) {
        err = command(e, PELAGOS__EXERCISE_ACTION__LOAD, name, 0, fault);
    } else if (action != PELAGOS__EXERCISE_ACTION__LOAD && !loaded) {
        err = pel_fault_set(fault, PEL_ERR_CONFLICT,
                            "exercise %u (%s) is not the one that is loaded",
                            c->instance, name);
    }
    return err ? err : command(e, action, name, c->value[0], fault);
}

enum pel_err pel_cigi_exercise_take(struct pel_cigi_exercise *e,
                                    const struct pel_cigi_component *c,
                                    struct pel_fault *fault)
{
    if (c->class != PEL_CIGI_SYSTEM || c->id != PEL_CIGI_EXERCISE ||
        repeats(e, c) || c->state == 0) {
        return PEL_OK;
    }
    g_autofree char *name =
        e->all ? pel_exercises_name(e->all, c->instance) : NULL;
    if (!name || c->state < PELAGOS__EXERCISE_ACTION__LOAD ||
        c->state > PELAGOS__EXERCISE_ACTION__STOP) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "there is no exercise %u, or no state %u of it",
                             c->instance, c->state);
    }
    return act(e, c, name, fault);
}
