/* Answers to CIGI's requests, from the sea of one snapshot at one time: the
 * one that a frame of that time draws. One thread at a time. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "bounds.h"
#include "bridges/cigi_packet.h"
#include "bridges/cigi_world.h"
#include "scene/snapshot.h"

/* Beyond this distance from the origin nothing is answered. */
#define PEL_CIGI_REACH_M 1e6
#define PEL_CIGI_MAX_QUESTIONS PEL_BOUND_CIGI_QUESTIONS

struct pel_cigi_moment {
    const struct pel_snapshot *snapshot;
    const struct pel_cigi_world *world;
    double time_s;
    uint32_t host_frame;
    /* Set by pel_cigi_answer: */
    size_t sight_steps;
    const struct pel_object *objects;
    size_t object_count;
};

/* Gets each answer; false: no more room. */
typedef bool (*pel_cigi_emit)(void *user, const struct pel_cigi_packet *answer);

/* Whether a packet of this kind is a request. */
bool pel_cigi_is_question(enum pel_cigi_kind kind);

/* Answers `count` requests, at most PEL_CIGI_MAX_QUESTIONS, in order. Returns
 * the number of answers. HAT/HOT and maritime heights are pel_sea_query's, or
 * the former of what stands there. A
 * line of sight is followed where waves can be, in steps of 0.25 m, or of a
 * 1024th of that way if this is longer (with more than 8 sights at once an
 * 8192th times their number, a 64th at most), then to 0.1 mm. */
size_t pel_cigi_answer(const struct pel_cigi_moment *moment,
                       const struct pel_cigi_packet *const *questions,
                       size_t count, pel_cigi_emit emit, void *user);
