#include "pelog.h"

#include <math.h>
#include <string.h>

#include "wire.h"

#define MAX_TIME_S 1e9

bool pel_log_is(const void *data, size_t size)
{
    return size >= PEL_LOG_MAGIC_SIZE &&
           memcmp(data, PEL_LOG_MAGIC, PEL_LOG_MAGIC_SIZE) == 0;
}

/* By the digit in the first bytes; 0: no log of any version. */
static unsigned version_of(const char *data, size_t size)
{
    return size >= PEL_LOG_MAGIC_SIZE && memcmp(data, "PELOG", 5) == 0 &&
                   data[5] >= '0' && data[5] <= '9' &&
                   memcmp(data + 6, "\r\n", 2) == 0
               ? (unsigned)(data[5] - '0')
               : 0;
}

static enum pel_err newer(unsigned version, unsigned known,
                          struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_CONFLICT,
                         "it is of version %u, which a newer program wrote, "
                         "and this one reads version %u",
                         version, known);
}

enum pel_err pel_log_open(struct pel_log_reader *reader, const void *data,
                          size_t size, struct pel_fault *fault)
{
    *reader = (struct pel_log_reader){ .data = data, .size = size };
    unsigned version = version_of(data, size);
    if (version > PEL_LOG_VERSION) {
        return newer(version, PEL_LOG_VERSION, fault);
    }
    if (!pel_log_is(data, size)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "not a command log of version %d",
                             PEL_LOG_VERSION);
    }
    reader->at = PEL_LOG_MAGIC_SIZE;
    return PEL_OK;
}

static enum pel_err malformed(const struct pel_log_reader *reader,
                              const char *why, struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_MALFORMED, "entry %zu, at byte %zu, %s",
                         reader->entries + 1, reader->at, why);
}

static bool goes_back(const struct pel_log_reader *reader,
                      const Pelagos__LogEntry *entry)
{
    bool leaps = entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_STATE &&
                 entry->missed > 0;
    return entry->time < reader->time_s && !leaps;
}

/* What is wrong with an entry at its place; NULL: nothing. */
static const char *flaw(const struct pel_log_reader *reader,
                        const Pelagos__LogEntry *entry)
{
    const Pelagos__LogHead *head =
        entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD ? entry->head
                                                                : NULL;
    if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND__NOT_SET) {
        return "has no command";
    }
    if (!head != (reader->entries > 0)) {
        return head ? "is a second head" : "is not the head";
    }
    if (head && (!head->has_version || head->version < PEL_LOG_VERSION)) {
        return "is of another version";
    }
    if (head && (!head->state || !head->state->clock)) {
        return "has no state to begin with";
    }
    if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_STATE &&
        !entry->state->clock) {
        return "has no state to go on with";
    }
    if (!entry->has_time || !isfinite(entry->time) || entry->time < 0 ||
        entry->time > MAX_TIME_S) {
        return "has no time within 0 .. 1e9 s";
    }
    if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_STEP &&
        !(entry->step->has_until && entry->step->until == entry->time)) {
        return "steps to another time than its own";
    }
    if (goes_back(reader, entry)) {
        return "goes back in time";
    }
    return NULL;
}

/* Simulated time after the entry: a patch may set the clock. */
static double time_after(const Pelagos__LogEntry *entry)
{
    if (entry->command_case != PELAGOS__LOG_ENTRY__COMMAND_PATCH) {
        return entry->time;
    }
    const Pelagos__Patch *patch = entry->patch;
    double time_s = entry->time;
    for (size_t i = 0; i < patch->n_remove; i++) {
        if (strcmp(patch->remove[i], "clock") == 0 ||
            strcmp(patch->remove[i], "clock.time") == 0) {
            time_s = 0;
        }
    }
    if (patch->state && patch->state->clock && patch->state->clock->has_time) {
        time_s = patch->state->clock->time;
    }
    return time_s;
}

static unsigned head_version(const Pelagos__LogEntry *entry)
{
    return entry && entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD &&
                   entry->head->has_version
               ? entry->head->version
               : 0;
}

enum pel_err pel_log_next(struct pel_log_reader *reader,
                          Pelagos__LogEntry **out, struct pel_fault *fault)
{
    size_t offset, length;
    *out = NULL;
    switch (pel_wire_next(reader->data + reader->at, reader->size - reader->at,
                          PEL_LOG_MAX_ENTRY, &offset, &length)) {
    case PEL_WIRE_MORE:
        reader->torn = reader->at < reader->size;
        reader->size = reader->at;
        return reader->entries > 0 ? PEL_OK
                                   : malformed(reader, "is not whole", fault);
    case PEL_WIRE_MESSAGE:
        break;
    case PEL_WIRE_MALFORMED:
    case PEL_WIRE_TOO_LONG:
        return malformed(reader, "has no length that can be", fault);
    }
    Pelagos__LogEntry *entry = pelagos__log_entry__unpack(
        NULL, length, reader->data + reader->at + offset);
    unsigned version = reader->entries == 0 ? head_version(entry) : 0;
    if (version > PEL_LOG_VERSION_STATES) {
        pelagos__log_entry__free_unpacked(entry, NULL);
        return newer(version, PEL_LOG_VERSION_STATES, fault);
    }
    const char *why = entry ? flaw(reader, entry) : "is no LogEntry";
    if (why) {
        if (entry) {
            pelagos__log_entry__free_unpacked(entry, NULL);
        }
        return malformed(reader, why, fault);
    }
    reader->time_s = time_after(entry);
    reader->at += offset + length;
    reader->entries++;
    *out = entry;
    return PEL_OK;
}
