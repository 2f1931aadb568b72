/* The debrief: a second scene that is led through a recording, and the frames
 * of its views, beside the live one, which it does not touch. There is one, for
 * all clients. A thread reads the log and makes the states; the second renderer
 * is there only while it is open. Control thread. */
#pragma once

#include "frames/frames.h"
#include "scene/recorder.h"

struct pel_debrief;

struct pel_debrief_options {
    struct pel_frames_options frames; /* strings outlive it */
    struct pel_scene_options scene;   /* where files are; likewise */
};

struct pel_debrief *
pel_debrief_create(const struct pel_debrief_options *options,
                   struct pel_recorder *recorder);
/* After the net. False: a thread hangs (pel_frames_destroy). NULL allowed. */
bool pel_debrief_destroy(struct pel_debrief *debrief);

/* What of it a client asks, tested. Opening, going somewhere and closing take
 * their time: pel_debrief_status says how far it is. CONFLICT: nothing is open,
 * or there is no directory; BUSY: it is being closed. */
PEL_CHECK enum pel_err pel_debrief_do(struct pel_debrief *debrief,
                                      const Pelagos__DebriefCommand *command,
                                      struct pel_fault *fault);
/* Borrowed until the next call. */
const Pelagos__Debrief *pel_debrief_status(struct pel_debrief *debrief);

/* Its scene and its frames while it is open, else NULL. Only views may be asked
 * of them. */
struct pel_scene *pel_debrief_scene(const struct pel_debrief *debrief);
struct pel_frames *pel_debrief_frames(const struct pel_debrief *debrief);

/* The recordings there are; borrowed for the call, NULL with an error. At most
 * 16 wait: BUSY. */
typedef void (*pel_recordings_done)(void *user, enum pel_err err,
                                    const struct pel_fault *fault,
                                    const Pelagos__Recordings *answer);
PEL_CHECK enum pel_err pel_debrief_ask_recordings(struct pel_debrief *debrief,
                                                  pel_recordings_done done,
                                                  void *user,
                                                  struct pel_fault *fault);
/* Begins or ends a recording. */
PEL_CHECK enum pel_err
pel_debrief_record(struct pel_debrief *debrief,
                   const Pelagos__RecordingCommand *command,
                   struct pel_fault *fault);

void pel_debrief_collect(void *user, struct pel_metrics_page *page);
