/* Exercises by Component Control of class 13 (system), as proto/cigi.in.md has
 * them. A host may repeat its packets with each frame, so one that says the
 * same again does nothing. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "bridges/cigi_world.h"
#include "scene/exercise.h"

#define PEL_CIGI_SYSTEM 13   /* component class */
#define PEL_CIGI_EXERCISE 1u /* component id */

struct pel_cigi_exercise {
    struct pel_exercises *all; /* NULL: there are none */
    bool heard;                /* this session */
    unsigned instance, state;  /* of the last packet */
    uint32_t word;
};

/* Carries out what a component says, of any class. NOT_FOUND: it has no such
 * exercise, or no such state; else as pel_exercises_command. */
PEL_CHECK enum pel_err
pel_cigi_exercise_take(struct pel_cigi_exercise *e,
                       const struct pel_cigi_component *c,
                       struct pel_fault *fault);
