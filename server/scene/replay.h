/* A recording played without a daemon: the state of any of its moments, bit
 * for bit as it was. One thread at a time, and not the control thread: it
 * reads files and builds seas. Its memory is bounded: a window of the log
 * (scene/logfile.h), and PEL_REPLAY_STILLS states on the way, from which it
 * goes on when it is led back. */
#pragma once

#include <stdatomic.h>

#include "base/err.h"
#include "scene/recordings.h"
#include "scene/scene.h"
#include "scene/still.h"

#define PEL_REPLAY_STILLS 64

struct pel_replay;

struct pel_replay_options {
    const char *directory, *name;   /* as pel_recording_find */
    struct pel_scene_options scene; /* where files are; the recording says how
                                     * many waves */
    atomic_bool *stop;    /* set by another thread: what is under way ends with
                           * CONFLICT */
    _Atomic double *part; /* how far it is with that, 0 to 1; NULL allowed */
};

/* Reads all of it once. Faults as of pel_recording_find; MALFORMED and
 * CONFLICT (another version) as of pel_log_next, with the file's name. It is
 * at the beginning. */
PEL_CHECK enum pel_err pel_replay_open(const struct pel_replay_options *options,
                                       struct pel_replay **out,
                                       struct pel_fault *fault);
void pel_replay_close(struct pel_replay *replay); /* NULL allowed */

/* A moment: simulated time, and how often the clock had been set before, so
 * that moments are in order. */
struct pel_replay_moment {
    unsigned stretch;
    double time_s;
};

/* Brings it to the moment, after all commands with times up to then, or to the
 * end if that is earlier. On a fault (a command that this program refuses, a
 * file that is not there) it is as far as it came, and says which entry. */
PEL_CHECK enum pel_err pel_replay_go(struct pel_replay *replay,
                                     struct pel_replay_moment to,
                                     struct pel_fault *fault);
struct pel_replay_moment pel_replay_at(const struct pel_replay *replay);
/* The state and the pictures of it. */
void pel_replay_still(struct pel_replay *replay, struct pel_still *out);

const struct pel_recording *pel_replay_recording(const struct pel_replay *r);
size_t pel_replay_commands(const struct pel_replay *replay); /* in all of it */

/* Seconds from the beginning, however the clock was set; and back. Within the
 * recording. */
double pel_replay_length(const struct pel_replay *replay);
double pel_replay_position(const struct pel_replay *replay,
                           struct pel_replay_moment moment);
struct pel_replay_moment pel_replay_at_position(const struct pel_replay *replay,
                                                double position_s);
/* The last moment of this simulated time, or the nearest there is. */
struct pel_replay_moment pel_replay_at_time(const struct pel_replay *replay,
                                            double time_s);
