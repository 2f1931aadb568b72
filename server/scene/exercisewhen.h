/* Conditions of an exercise's events: a function of the snapshot, the moment
 * and what has happened. Any thread. */
#pragma once

#include <stdbool.h>

#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

/* An entity as it is at the moment. */
struct pel_exercise_body {
    enum { PEL_BODY_UNASKED, PEL_BODY_GONE, PEL_BODY_THERE } known;
    double east_m, north_m, latitude, longitude; /* degrees */
    double heading_rad, course_rad, speed_mps, turn_rps;
    double length_m, beam_m, draught_m; /* of its model or its helm; else 0 */
};

/* A moment that is looked at; bodies are found as they are asked for. */
struct pel_exercise_moment {
    const Pelagos__Exercise *exercise;
    const Pelagos__State *state;
    const struct pel_snapshot *snapshot;
    double clock_s, time_s; /* simulated time, exercise time */
    struct pel_exercise_body bodies[PEL_MAX_ENTITIES];
};

void pel_exercise_moment_init(struct pel_exercise_moment *m,
                              const Pelagos__Exercise *exercise,
                              const Pelagos__State *state,
                              const struct pel_snapshot *snapshot,
                              double clock_s, double time_s);

/* Whether one of its conditions holds. */
bool pel_exercise_holds(struct pel_exercise_moment *m,
                        const Pelagos__ExerciseEvent *event);

/* The entity; NULL: it is not there. */
const struct pel_exercise_body *
pel_exercise_body_of(struct pel_exercise_moment *m, uint32_t id);

/* Closest point of approach of two bodies that keep course and speed, on the
 * plane: distance [m] and time to it [s], negative: it is over. At the same
 * velocity the distance of now, at 0 s. */
void pel_exercise_cpa(const struct pel_exercise_body *a,
                      const struct pel_exercise_body *b, double *cpa_m,
                      double *tcpa_s);
double pel_exercise_range(const struct pel_exercise_body *a,
                          const struct pel_exercise_body *b);

/* Water under its keel [m]; NaN: nothing is known of the bottom. */
double pel_exercise_under_keel(const struct pel_exercise_moment *m,
                               const struct pel_exercise_body *body);

/* Distance between the outlines of two hulls [m], 0 where they touch: a
 * rectangle of length and beam, of one three times as long as broad with a bow
 * that narrows over the foremost quarter. NaN: one has no size. */
double pel_exercise_hulls(const struct pel_exercise_body *a,
                          const struct pel_exercise_body *b);

/* Whether a place is in the area; NULL: everywhere. */
bool pel_exercise_in_area(const Pelagos__ExerciseArea *area, double latitude,
                          double longitude);

#define PEL_EXERCISE_CORNERS 16
/* Corners of ExerciseArea.corners as latitude and longitude; their number, -1:
 * it is none that the schema allows. */
int pel_exercise_corners(const char *text, double out[PEL_EXERCISE_CORNERS][2]);

/* What `run` says of the event; NULL: it has done nothing. */
const Pelagos__ExerciseDone *pel_exercise_done(const Pelagos__ExerciseRun *run,
                                               const char *event);
