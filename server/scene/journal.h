/* Edits that the state file does not hold yet: appended to PATH.journal as they
 * take effect, before they are answered, so that a process that is killed
 * loses none. A file in the form of proto/pelog.md: the state that it begins
 * with, then patches and steps. A thread brings it to the disk every
 * PEL_JOURNAL_SYNC_MS, and begins it anew from the present state when it is
 * full, so the control thread writes a few hundred bytes an edit and waits for
 * no disk. Room for a whole journal is reserved at its beginning: a disk that
 * fills up later stops no edit from being kept. Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "pelagos.pb-c.h"
#include "scene/worker.h"

#define PEL_JOURNAL_SYNC_MS 100
#define PEL_JOURNAL_BYTES (1 << 20)      /* then it begins anew */
#define PEL_JOURNAL_MOST_BYTES (8 << 20) /* where it cannot */

struct pel_journal;

/* Brings `state`, that of the state file, to what the journal says, as live
 * edits would have; the journal's own state where *state is NULL or older than
 * it. *edits: how many there were. No journal is no fault. A journal that
 * breaks off is used to there. MALFORMED: it is none, or an edit does not
 * apply; *state is as far as it went. CONFLICT: it is of a newer version. */
PEL_CHECK enum pel_err pel_journal_load(const char *path,
                                        Pelagos__State **state, unsigned *edits,
                                        struct pel_fault *fault);

/* Begins PATH.journal with `state`; what was there is gone. Where that fails,
 * it is logged (SCN-012) and tried again every 5 s. `worker`: brings it to the
 * disk; it ends before the journal is closed. */
struct pel_journal *pel_journal_create(const char *path,
                                       const Pelagos__State *state,
                                       struct pel_worker *worker);

/* A patch that took effect at simulated time time_s and led to `state`, or
 * (NULL) a step to that time: of a clock that is stepped each, of others one in
 * a tenth of a second. */
void pel_journal_add(struct pel_journal *journal, double time_s,
                     const Pelagos__Patch *patch, const Pelagos__State *state);

/* Whether it should begin anew; with the state as the state file keeps it. */
bool pel_journal_is_full(const struct pel_journal *journal);
void pel_journal_turn(struct pel_journal *journal, const Pelagos__State *state);

/* Removes PATH.journal: the state file holds everything. */
void pel_journal_remove(const char *path);

/* saved: the state file holds everything, and the journal is removed; else it
 * is brought to the disk and stays. False: it holds not everything. NULL
 * allowed. */
bool pel_journal_close(struct pel_journal *journal, bool saved);

void pel_journal_collect(const struct pel_journal *journal,
                         struct pel_metrics_page *page);
