/* What is sealed of an exercise on several daemons (server/cluster), for those
 * who record it: the last whole state with which all nodes began their ships'
 * steps anew, and the entries since, in the form of proto/pelog.md. A recording
 * that is begun in between begins with that state, so that a replay has the
 * same motion. Control thread. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

struct pel_sealedlog;

struct pel_sealedlog *pel_sealedlog_create(void);
void pel_sealedlog_destroy(struct pel_sealedlog *log); /* NULL allowed */

/* A node begins with this state, after frame `number`; taken over. What is
 * known of that frame already is passed over. */
void pel_sealedlog_begin(struct pel_sealedlog *log, uint64_t number,
                         Pelagos__State *state);

struct pel_sealedlog_frame {
    uint64_t number;
    Pelagos__LogEntry *const *entries; /* only its patches count */
    size_t count;
    double time_s;     /* simulated, of the seal */
    uint64_t revision; /* of the state then */
    enum pel_clock_mode mode;
    Pelagos__State *anew; /* the state then, taken over, where the steps of the
                           * ships begin anew with it; else NULL */
};

/* A frame was sealed; one that is known already is passed over. */
void pel_sealedlog_add(struct pel_sealedlog *log,
                       const struct pel_sealedlog_frame *frame);

/* Who is told of what comes. */
struct pel_sealedlog_listener {
    /* `count` whole entries. */
    void (*entries)(void *user, const uint8_t *bytes, size_t size,
                    unsigned count);
    /* Everything goes on with the state that pel_sealedlog_head gives now;
     * missed: so many frames before it are not known. */
    void (*anew)(void *user, uint64_t missed);
    void *user;
};
/* One at a time; NULL: none. */
void pel_sealedlog_listen(struct pel_sealedlog *log,
                          const struct pel_sealedlog_listener *listener);

/* The last whole state; NULL: the node has not joined yet. And the entries
 * since. The log's, until the next frame. */
const Pelagos__State *pel_sealedlog_head(const struct pel_sealedlog *log);
const uint8_t *pel_sealedlog_since(const struct pel_sealedlog *log,
                                   size_t *size, unsigned *count);

/* Simulated time of the last frame, and the revision of its state. */
double pel_sealedlog_time(const struct pel_sealedlog *log, uint64_t *revision);
