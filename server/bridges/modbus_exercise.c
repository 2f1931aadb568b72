#include "bridges/modbus_exercise.h"

#include <math.h>

#include <glib.h>

#include "base/log.h"
#include "fault.h"

#define LATEST_S 1e9 /* as the schema has it */

/* NaN, which reads as 65535, for none. */
static double number_of(const struct pel_modbus_exercise *e, const char *name)
{
    int number = e->all ? pel_exercises_number(e->all, name) : -1;
    return number < 0 ? NAN : number;
}

double pel_modbus_exercise_value(const struct pel_modbus_exercise *e,
                                 enum pel_register_source source)
{
    struct pel_exercise_glance glance = { 0 };
    if (e->all) {
        pel_exercises_glance(e->all, &glance);
    }
    switch (source) {
    case PEL_SOURCE_EXERCISE_TO:
        return e->to_s;
    case PEL_SOURCE_EXERCISE_CHOICE:
        return number_of(e, e->choice);
    case PEL_SOURCE_EXERCISE_ACTION:
        return e->done;
    case PEL_SOURCE_EXERCISE:
        return number_of(e, NULL);
    case PEL_SOURCE_EXERCISES:
        return e->all ? (double)pel_exercises_count(e->all) : 0;
    case PEL_SOURCE_EXERCISE_TIME:
        return glance.time_s;
    case PEL_SOURCE_EXERCISE_FIRED:
        return glance.fired;
    case PEL_SOURCE_EXERCISE_EVENTS:
        return glance.events;
    case PEL_SOURCE_EXERCISE_FACTS:
        return glance.facts;
    case PEL_SOURCE_EXERCISE_GROUNDINGS:
        return glance.groundings;
    case PEL_SOURCE_EXERCISE_COLLISIONS:
        return glance.collisions;
    default:
        return NAN;
    }
}

static enum pel_modbus_exception choose(struct pel_modbus_exercise *e,
                                        double number)
{
    g_autofree char *name =
        e->all ? pel_exercises_name(e->all, (size_t)number) : NULL;
    if (!name && number != UINT16_MAX) {
        return PEL_MODBUS_ILLEGAL_VALUE;
    }
    g_strlcpy(e->choice, name ? name : "", sizeof e->choice);
    return PEL_MODBUS_DONE;
}

enum pel_modbus_exception
pel_modbus_exercise_take(struct pel_modbus_exercise *e,
                         enum pel_register_source source, double value)
{
    switch (source) {
    case PEL_SOURCE_EXERCISE_TO:
        if (!(value >= 0 && value <= LATEST_S)) {
            return PEL_MODBUS_ILLEGAL_VALUE;
        }
        e->to_s = value;
        return PEL_MODBUS_DONE;
    case PEL_SOURCE_EXERCISE_CHOICE:
        return choose(e, value);
    case PEL_SOURCE_EXERCISE_ACTION:
        if (value < PELAGOS__EXERCISE_ACTION__LOAD ||
            value > PELAGOS__EXERCISE_ACTION__STOP) {
            return PEL_MODBUS_ILLEGAL_VALUE;
        }
        e->asked = (Pelagos__ExerciseAction)value;
        return PEL_MODBUS_DONE;
    default:
        return PEL_MODBUS_ILLEGAL_ADDRESS;
    }
}

static enum pel_err act(struct pel_modbus_exercise *e, struct pel_fault *fault)
{
    Pelagos__ExerciseCommand command = PELAGOS__EXERCISE_COMMAND__INIT;
    Pelagos__ExerciseStatus *status;
    command.has_action = true;
    command.action = e->asked;
    if (!e->all) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "there are no exercises here");
    }
    if (e->asked == PELAGOS__EXERCISE_ACTION__LOAD && !*e->choice) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "none is chosen: write its number first");
    }
    command.name = e->choice;
    command.has_time = e->asked == PELAGOS__EXERCISE_ACTION__REWIND;
    command.time = e->to_s;
    enum pel_err err = pel_exercises_command(e->all, &command, &status, fault);
    if (!err) {
        pelagos__exercise_status__free_unpacked(status, NULL);
    }
    return err;
}

enum pel_modbus_exception pel_modbus_exercise_act(struct pel_modbus_exercise *e)
{
    static struct pel_log_limit limit;
    struct pel_fault fault = { 0 };
    if (e->asked == PELAGOS__EXERCISE_ACTION__STATUS) {
        return PEL_MODBUS_DONE;
    }
    enum pel_err err = act(e, &fault);
    if (err) {
        pel_log_limited(&limit, PEL_LOG_WARNING, "MBS-012",
                        "a command of exercises by Modbus was refused: %s %s",
                        fault.path, fault.message);
        return err == PEL_ERR_INTERNAL || err == PEL_ERR_NO_MEMORY ||
                       err == PEL_ERR_IO || err == PEL_ERR_FULL
                   ? PEL_MODBUS_FAILURE
                   : PEL_MODBUS_ILLEGAL_VALUE;
    }
    e->done = e->asked;
    e->asked = PELAGOS__EXERCISE_ACTION__STATUS;
    return PEL_MODBUS_DONE;
}
