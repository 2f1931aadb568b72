/* Bytes → exercise: what is accepted is written, read again as the same, and
 * looked at in the scene as it begins: its conditions at several moments, how
 * far its entities are apart. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "json.h"
#include "scene/build.h"
#include "scene/check.h"
#include "scene/edit.h"
#include "scene/exercise.h"
#include "scene/exercise_parts.h"
#include "scene/exercisewhen.h"
#include "scene/fleet.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

/* One of trochoids for all: bodies and depths need no other waves, and helms
 * are stepped through them. */
static struct pel_shared_sea *sea(void)
{
    static struct pel_shared_sea *made;
    static const struct pel_sea_means means = { 20, NULL };
    if (!made) {
        Pelagos__State *state = pel_state_default();
        state->sea->synthesiser = PELAGOS__SYNTHESISER__TROCHOIDS;
        demand(!pel_shared_sea_get(state, &means, NULL, NULL, &made, NULL));
        pelagos__state__free_unpacked(state, NULL);
    }
    return made;
}

/* The state in which it begins, where every second event has happened. */
static Pelagos__State *begin(const Pelagos__Exercise *exercise)
{
    struct pel_exercise_beginning beginning;
    struct pel_fault fault;
    Pelagos__State *from = pel_state_default(), *state = NULL;
    pel_exercise_begin(exercise, from, &beginning);
    demand(!pel_state_apply(from, &beginning.patch, &state, &fault));
    pel_exercise_beginning_finish(&beginning);
    pelagos__state__free_unpacked(from, NULL);
    demand(!pel_state_check(state, &fault) && !pel_sea_settle(state, &fault));
    return state;
}

/* Of one shape, made once: light about it takes a sanitizer a minute. */
static struct pel_fleet fleet_of(const Pelagos__State *state)
{
    static struct pel_fleet last;
    struct pel_fleet fleet = { 0 };
    bool known = true, any = false;
    for (size_t i = 0; i < state->n_entities; i++) {
        const Pelagos__Model *m = state->entities[i]->model;
        any = any || m;
        known = known && (!m || (m->name && !m->length && !m->beam &&
                                 strcmp(m->name, "patrol-boat") == 0));
    }
    if (any && known) {
        demand(!pel_fleet_get(state, NULL, true, &last, &fleet, NULL));
        pel_fleet_finish(&last);
        last = pel_fleet_ref(&fleet);
    }
    return fleet;
}

static void look(struct pel_exercise_moment *m)
{
    for (size_t i = 0; i < m->exercise->n_events; i++) {
        (void)pel_exercise_holds(m, m->exercise->events[i]);
    }
    for (size_t i = 0; i + 1 < m->snapshot->entity_count; i++) {
        const struct pel_entity_state *e = m->snapshot->entities;
        const struct pel_exercise_body *a = pel_exercise_body_of(m, e[i].id);
        const struct pel_exercise_body *b =
            pel_exercise_body_of(m, e[i + 1].id);
        double cpa, tcpa, hulls = pel_exercise_hulls(a, b);
        pel_exercise_cpa(a, b, &cpa, &tcpa);
        demand(!(hulls < 0) && isfinite(cpa) && isfinite(tcpa));
        /* Hulls are no further apart than the middles, by which they touch. */
        demand(!(hulls > pel_exercise_range(a, b) + 1e-6));
        (void)pel_exercise_under_keel(m, a);
    }
}

static void look_on(const Pelagos__Exercise *exercise)
{
    static const double times[] = { 0, 20, 300 };
    static struct pel_exercise_moment moment;
    Pelagos__State *state = begin(exercise);
    Pelagos__ExerciseDone done[PEL_BOUND_EXERCISE_EVENTS];
    Pelagos__ExerciseDone *list[PEL_BOUND_EXERCISE_EVENTS];
    Pelagos__ExerciseRun run = PELAGOS__EXERCISE_RUN__INIT;
    Pelagos__ExerciseRun *own = state->exercise;
    for (size_t i = 0; i < exercise->n_events; i += 2) {
        Pelagos__ExerciseDone *d = &done[run.n_events];
        pelagos__exercise_done__init(d);
        d->event = exercise->events[i]->name;
        d->count = i % 4 == 0;
        list[run.n_events++] = d;
    }
    run.events = list;
    state->exercise = &run;
    struct pel_fleet fleet = fleet_of(state);
    const struct pel_snapshot *s =
        pel_snapshot_build_going(state, sea(), NULL, NULL, &fleet, NULL, NULL);
    pel_fleet_finish(&fleet);
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        pel_exercise_moment_init(&moment, exercise, state, s, times[i],
                                 times[i]);
        look(&moment);
    }
    pel_snapshot_unref(s);
    state->exercise = own;
    pelagos__state__free_unpacked(state, NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Pelagos__Exercise *exercise, *again;
    struct pel_fault fault = { 0 };
    pel_log_set_level(PEL_LOG_ERROR);
    if (pel_exercise_read((const char *)data, size, &exercise, &fault)) {
        demand(fault.message[0] != '\0');
        return 0;
    }
    char *text = pel_json_from_message(&exercise->base, true);
    demand(!pel_exercise_read(text, strlen(text), &again, &fault));
    char *twice = pel_json_from_message(&again->base, true);
    demand(strcmp(text, twice) == 0); /* what is good stays so */
    look_on(exercise);
    pelagos__exercise__free_unpacked(exercise, NULL);
    pelagos__exercise__free_unpacked(again, NULL);
    free(text);
    free(twice);
    return 0;
}
