/* Edits that the state file does not hold yet: appended to PATH.journal before
 * they take effect and are answered, so that a process that is killed loses
 * none. A file in the form of proto/pelog.md: the state that it begins with,
 * then patches and steps, each with its checksum. A thread brings it to the
 * disk every PEL_JOURNAL_SYNC_MS, and restarts it from the present state
 * when it is full, so the control thread writes a few hundred bytes an edit and
 * waits for no disk. Room for a whole journal is reserved at its beginning: a
 * disk that fills up later stops no edit from being kept until that is used up.
 * Control thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/err.h"
#include "base/metrics.h"
#include "pelagos.pb-c.h"
#include "pelog.h"
#include "scene/worker.h"

#define PEL_JOURNAL_SYNC_MS 100
#define PEL_JOURNAL_BYTES (1 << 20)        /* then it restarts */
#define PEL_JOURNAL_MOST_BYTES (8 << 20)   /* where it cannot */
#define PEL_JOURNAL_LEAST_BYTES (16 << 10) /* without them it is not begun */

struct pel_journal;

/* The contents of a journal that is read at a start. */
struct pel_journal_found {
    unsigned edits; /* that were used */
    unsigned lost;  /* that are not there, as far as that is known */
    unsigned unfit; /* that are there and do not apply */
    bool foreign;   /* it is of another state file, and not used */
    bool damaged;   /* any of this, told by `words` */
    char reason[160], words[480];
    char *kept;     /* where the damaged file is kept, g_free; NULL: nowhere */
    bool may_go_on; /* it is whole; its end: */
    size_t size;
    struct pel_log_writer writer;
};

/* Brings `state`, that of the state file, to what the journal says, as live
 * edits would have; the journal's own state where *state is NULL or older than
 * it. What cannot be read is passed over, and what follows is used: an edit
 * says what it sets, so those behind a lost one lead to the state without it.
 * Such a file is kept as PATH.journal.bad (base/aside.h). lineage: of the state
 * file, NULL: not known. No journal is no fault. CONFLICT: it is of a newer
 * version. IO, OUT_OF_RANGE: it cannot be read at all. */
PEL_CHECK enum pel_err pel_journal_load(const char *path, const char *lineage,
                                        Pelagos__State **state,
                                        struct pel_journal_found *found,
                                        struct pel_fault *fault);

/* The wishes of a journal's owner. */
struct pel_journal_cares {
    bool goes_on;              /* edits that it cannot keep take effect */
    void (*wants)(void *user); /* it may be restarted: pel_journal_is_full */
    void *user;
};

/* Begins PATH.journal with `state`; what was there is gone. Where that fails,
 * the journal that was found (NULL: none) is gone on with; it is logged
 * (SCN-012) and tried again every 5 s. `worker`: brings it to the disk; it ends
 * before the journal is closed. */
struct pel_journal *pel_journal_create(const char *path, const char *lineage,
                                       const Pelagos__State *state,
                                       const struct pel_journal_found *found,
                                       const struct pel_journal_cares *cares,
                                       struct pel_worker *worker);

/* A patch that takes effect at simulated time time_s and leads to `state`, or
 * (NULL) a step to that time: of a clock that is stepped each, of others one in
 * a tenth of a second. False: it could not be kept; with `goes_on` the journal
 * lacks it from now on, else the patch must not take effect. */
PEL_CHECK bool pel_journal_add(struct pel_journal *journal, double time_s,
                               const Pelagos__Patch *patch,
                               const Pelagos__State *state);

/* Whether it refused the last edit, for which it has no room yet; NULL
 * allowed. */
bool pel_journal_refuses(const struct pel_journal *journal);

/* Whether an edit that took effect is in no file yet; NULL allowed. */
bool pel_journal_lacks(const struct pel_journal *journal);

/* The fault and its cure in a sentence; false: there is none. NULL allowed. */
bool pel_journal_trouble(const struct pel_journal *journal, char *out,
                         size_t size);

/* Whether it should restart; with the state as the state file keeps it. */
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
