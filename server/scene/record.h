/* The recorder: every accepted command with its simulated time into files, in
 * the form of proto/pelog.md. Control thread. */
#pragma once

#include "base/err.h"
#include "base/metrics.h"
#include "scene/scene.h"
#include "scene/sealedlog.h"

struct pel_record;

struct pel_record_options {
    const char *path;    /* of the segment that is written */
    double segment_mib;  /* a segment ends with the entry that reaches this */
    unsigned keep;       /* full segments, or as many bytes of shorter ones, on
                          * the disk, with the one written; 2.. */
    double again_s;      /* from a failure to the next attempt */
    const char *program; /* "pelagosd 0.2.0" */
    const char *device;
    int wave_count;
    /* Of a daemon in an exercise: what is sealed is recorded; NULL: what the
     * scene accepts. */
    struct pel_sealedlog *sealed;
    double keep_days; /* segments that ended before go; 0: none does */
};

/* Begins a recording with its first segment, whose head is the present state,
 * and listens to the scene; or with what is sealed, and then with the last
 * whole state there, or as soon as there is one. What is at `path` becomes
 * PATH.NNNNNN, numbered on from the highest that is there, and of these the
 * oldest beyond `keep` and `keep_days` are removed, likewise at the start of
 * each further segment: of what is sealed one begins with a whole state there
 * only. A new segment of the scene restarts own ship's steps
 * (pel_scene_listen), so that a replay of that segment alone has the same
 * motion. IO; INVALID: what is there is no log; CONFLICT: another daemon is
 * writing it. */
PEL_CHECK enum pel_err pel_record_create(const struct pel_record_options *o,
                                         struct pel_scene *scene,
                                         struct pel_record **out,
                                         struct pel_fault *fault);

/* Writes the moment of the end, and gives the file, which is not on the disk
 * yet; −1: nothing was being written. The recorder is gone. */
int pel_record_end(struct pel_record *record);

/* The same, brings it to the disk and closes; NULL allowed. Before the scene.
 */
void pel_record_destroy(struct pel_record *record);

/* Metrics `pelagos_record_...`; user: the recorder. */
void pel_record_collect(void *user, struct pel_metrics_page *page);
