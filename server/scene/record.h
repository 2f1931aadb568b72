/* The recorder: every accepted command with its simulated time into a file,
 * in the form of proto/pelog.md. Control thread. */
#pragma once

#include "base/err.h"
#include "base/metrics.h"
#include "scene/scene.h"

struct pel_record;

struct pel_record_options {
    const char *path;
    double limit_mib;    /* the recording ends before the file is larger */
    const char *program; /* "pelagosd 0.1.0" */
    const char *device;
    int wave_count;
};

/* Opens the file, writes the head with the present state, and listens to the
 * scene. A file that is there is kept as PATH.1, or the next free number up to
 * 999. IO, CONFLICT (no number is free). */
PEL_CHECK enum pel_err pel_record_create(const struct pel_record_options *o,
                                         struct pel_scene *scene,
                                         struct pel_record **out,
                                         struct pel_fault *fault);

/* Writes the moment of the end and closes; NULL allowed. Before the scene. */
void pel_record_destroy(struct pel_record *record);

/* Metrics `pelagos_record_...`; user: the recorder. */
void pel_record_collect(void *user, struct pel_metrics_page *page);
