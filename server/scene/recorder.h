/* The daemon's recording: begun by --record or by a client, one at a time.
 * Control thread. */
#pragma once

#include "scene/record.h"
#include "scene/worker.h"

struct pel_recorder;

struct pel_recorder_options {
    struct pel_record_options record; /* path NULL: nothing is recorded yet */
    const char *directory;            /* of recordings; NULL: none */
};

/* Faults as of pel_record_create; NOT_FOUND: the directory. */
PEL_CHECK enum pel_err
pel_recorder_create(const struct pel_recorder_options *options,
                    struct pel_scene *scene, struct pel_recorder **out,
                    struct pel_fault *fault);
void pel_recorder_destroy(struct pel_recorder *recorder); /* NULL allowed */

/* Begins NAME.pelog in the directory; NULL or "": the name is UTC of now.
 * CONFLICT: it is recording already, there is no directory, or such a file, or
 * the node has not joined its exercise;
 * INVALID: the name, of 1 to 64 of A-Z a-z 0-9 . _ - and neither . nor -
 * first. */
PEL_CHECK enum pel_err pel_recorder_start(struct pel_recorder *recorder,
                                          const char *name,
                                          struct pel_fault *fault);
/* CONFLICT: nothing is recorded. Its last entries are brought to the disk by a
 * thread. */
PEL_CHECK enum pel_err pel_recorder_stop(struct pel_recorder *recorder,
                                         struct pel_fault *fault);

/* The file that is written, without its path; NULL: none. */
const char *pel_recorder_name(const struct pel_recorder *recorder);
/* NULL: none. */
const char *pel_recorder_directory(const struct pel_recorder *recorder);

void pel_recorder_collect(void *user, struct pel_metrics_page *page);
