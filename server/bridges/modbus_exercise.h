/* The registers of the exercises: which one is chosen, and what is done with
 * it. They are not staged: a command is no edit. Control thread. */
#pragma once

#include "registers.h"
#include "scene/exercise.h"

/* Modbus exception codes. */
enum pel_modbus_exception {
    PEL_MODBUS_DONE = 0,
    PEL_MODBUS_ILLEGAL_FUNCTION = 1,
    PEL_MODBUS_ILLEGAL_ADDRESS = 2,
    PEL_MODBUS_ILLEGAL_VALUE = 3,
    PEL_MODBUS_FAILURE = 4,
    PEL_MODBUS_NO_TARGET = 11,
};

struct pel_modbus_exercise {
    struct pel_exercises *all; /* NULL: there are none */
    char choice[72];           /* its name, whose number may change */
    double to_s;
    Pelagos__ExerciseAction asked, done; /* STATUS: none */
};

double pel_modbus_exercise_value(const struct pel_modbus_exercise *e,
                                 enum pel_register_source source);
/* A register of one request. */
enum pel_modbus_exception
pel_modbus_exercise_take(struct pel_modbus_exercise *e,
                         enum pel_register_source source, double value);
/* Carries out the request's action, if it has one. */
enum pel_modbus_exception
pel_modbus_exercise_act(struct pel_modbus_exercise *e);
