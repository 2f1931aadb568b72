#include "scene/logentry.h"

#include "wire.h"

/* Steps that frames or a host make are written so often [simulated s]; those
 * of clients all are. */
#define STEP_INTERVAL_S 0.1

static void fill(Pelagos__LogEntry *entry, double time_s, uint64_t revision)
{
    pelagos__log_entry__init(entry);
    entry->has_time = entry->has_revision = true;
    entry->time = time_s;
    entry->revision = revision;
}

uint8_t *pel_log_pack_patch(double time_s, uint64_t revision,
                            const Pelagos__Patch *patch, size_t *size)
{
    Pelagos__LogEntry entry;
    fill(&entry, time_s, revision);
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_PATCH;
    entry.patch = (Pelagos__Patch *)patch;
    return pel_wire_pack(&entry.base, size);
}

uint8_t *pel_log_pack_step(double time_s, uint64_t revision, size_t *size)
{
    Pelagos__LogEntry entry;
    Pelagos__ClockStep step = PELAGOS__CLOCK_STEP__INIT;
    fill(&entry, time_s, revision);
    step.has_until = true;
    step.until = time_s;
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_STEP;
    entry.step = &step;
    return pel_wire_pack(&entry.base, size);
}

uint8_t *pel_log_pack_state(const Pelagos__State *state, uint64_t missed,
                            size_t *size)
{
    Pelagos__LogEntry entry;
    fill(&entry, state->clock->time, state->revision);
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_STATE;
    entry.state = (Pelagos__State *)state;
    entry.has_missed = missed > 0;
    entry.missed = missed;
    return pel_wire_pack(&entry.base, size);
}

uint8_t *pel_log_pack_head(const Pelagos__LogHead *head, size_t *size)
{
    Pelagos__LogEntry entry;
    fill(&entry, head->state->clock->time, head->state->revision);
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_HEAD;
    entry.head = (Pelagos__LogHead *)head;
    return pel_wire_pack(&entry.base, size);
}

bool pel_log_wants_step(bool each, double time_s, double last_s)
{
    return each || time_s - last_s >= STEP_INTERVAL_S || time_s < last_s;
}
