/* Series: one question asked at each combination of the values of some axes,
 * and the numbers of the answers as lists, CSV or NetCDF. The questions go the
 * way of all questions, a few at a time; what is made of the answers is made on
 * a thread of its own. Control thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "frames/frames.h"
#include "net/claims.h"
#include "pelagos.pb-c.h"
#include "scene/scene.h"

struct pel_series;     /* those under way */
struct pel_series_job; /* one of them */

/* claims: where questions are counted; NULL: nowhere. */
struct pel_series *pel_series_create(struct pel_scene *scene,
                                     struct pel_frames *frames,
                                     struct pel_claims *claims);

void pel_series_collect(const struct pel_series *all,
                        struct pel_metrics_page *page);

/* Whoever waits is told CONFLICT. NULL allowed. */
void pel_series_destroy(struct pel_series *all);

/* How the answer is wanted. */
struct pel_series_form {
    bool reply; /* a delimited Reply of the sessions; else a body for HTTP */
    bool has_id;
    uint64_t id;
    struct pel_who who; /* in whose share it counts, and its questions */
};

struct pel_series_answer {
    char *data; /* free(); who is told may take it and set NULL */
    size_t size;
    const char *type; /* MIME, static */
};

typedef void (*pel_series_done)(void *user, enum pel_err err,
                                const struct pel_fault *fault,
                                struct pel_series_answer *answer);

/* Begins. Faults of the query: at once, and then `done` is not called; else it
 * is called once, never from here. The first answer that is a fault ends the
 * series with it. NOT_FOUND, INVALID, OUT_OF_RANGE (axes, their number and
 * size), BUSY (PEL_BOUND_SERIES). */
PEL_CHECK enum pel_err pel_series_ask(struct pel_series *all,
                                      const Pelagos__SeriesQuery *query,
                                      const struct pel_series_form *form,
                                      pel_series_done done, void *user,
                                      struct pel_series_job **out,
                                      struct pel_fault *fault);

/* Nobody waits any more: no further questions are asked. `done` is called with
 * CONFLICT once those under way are answered. */
void pel_series_cancel(struct pel_series_job *job);

/* The format that a word of a request names (`csv`), or its Accept header
 * (NULL: none); LISTS where neither says one. False: the word is none. */
bool pel_series_format(const char *word, const char *accept,
                       Pelagos__SeriesFormat *out);
