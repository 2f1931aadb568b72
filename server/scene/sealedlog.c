#include "scene/sealedlog.h"

#include <glib.h>
#include <stdbool.h>
#include <stdlib.h>

#include "scene/logentry.h"
#include "wire.h"

struct pel_sealedlog {
    struct pel_sealedlog_listener listener; /* `entries` NULL: none */
    Pelagos__State *head;                   /* NULL: not joined */
    uint64_t number;                        /* of the last frame */
    GByteArray *since;                      /* entries since the head */
    unsigned count;                         /* of them */
    double time_s;                          /* of the last frame */
    double entry_s;                         /* of the last entry */
    uint64_t revision;
};

struct pel_sealedlog *pel_sealedlog_create(void)
{
    struct pel_sealedlog *log = g_new0(struct pel_sealedlog, 1);
    log->since = g_byte_array_new();
    return log;
}

void pel_sealedlog_destroy(struct pel_sealedlog *log)
{
    if (log) {
        if (log->head) {
            pelagos__state__free_unpacked(log->head, NULL);
        }
        g_byte_array_unref(log->since);
        g_free(log);
    }
}

static void go_on_with(struct pel_sealedlog *log, uint64_t number,
                       Pelagos__State *state, uint64_t missed)
{
    if (log->head) {
        pelagos__state__free_unpacked(log->head, NULL);
    }
    log->head = state;
    log->number = number;
    log->time_s = log->entry_s = state->clock->time;
    log->revision = state->revision;
    g_byte_array_set_size(log->since, 0);
    log->count = 0;
    if (log->listener.anew) {
        log->listener.anew(log->listener.user, missed);
    }
}

void pel_sealedlog_begin(struct pel_sealedlog *log, uint64_t number,
                         Pelagos__State *state)
{
    if (log->head && number <= log->number) {
        pelagos__state__free_unpacked(state, NULL);
        return;
    }
    go_on_with(log, number, state, log->head ? number - log->number : 0);
}

static void append(struct pel_sealedlog *log, double time_s, uint8_t *data,
                   size_t size)
{
    g_byte_array_append(log->since, data, (guint)size);
    log->count++;
    log->entry_s = time_s;
    free(data);
}

void pel_sealedlog_add(struct pel_sealedlog *log,
                       const struct pel_sealedlog_frame *frame)
{
    guint from = log->since->len;
    unsigned before = log->count;
    size_t size;
    if (!log->head || frame->number <= log->number) {
        if (frame->anew) {
            pelagos__state__free_unpacked(frame->anew, NULL);
        }
        return;
    }
    for (size_t i = 0; i < frame->count; i++) {
        const Pelagos__LogEntry *entry = frame->entries[i];
        if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH) {
            uint8_t *data = pel_log_pack_patch(entry->time, entry->revision,
                                               entry->patch, &size);
            append(log, entry->time, data, size);
        }
    }
    bool each = frame->mode == PEL_CLOCK_STEPPED;
    if (!frame->anew && frame->time_s != log->entry_s &&
        pel_log_wants_step(each, frame->time_s, log->entry_s)) {
        uint8_t *data =
            pel_log_pack_step(frame->time_s, frame->revision, &size);
        append(log, frame->time_s, data, size);
    }
    log->number = frame->number;
    log->time_s = frame->time_s;
    log->revision = frame->revision;
    if (log->count > before && log->listener.entries) {
        log->listener.entries(log->listener.user, log->since->data + from,
                              log->since->len - from, log->count - before);
    }
    if (frame->anew) {
        go_on_with(log, frame->number, frame->anew, 0);
    }
}

void pel_sealedlog_listen(struct pel_sealedlog *log,
                          const struct pel_sealedlog_listener *listener)
{
    log->listener = listener ? *listener : (struct pel_sealedlog_listener){ 0 };
}

const Pelagos__State *pel_sealedlog_head(const struct pel_sealedlog *log)
{
    return log->head;
}

const uint8_t *pel_sealedlog_since(const struct pel_sealedlog *log,
                                   size_t *size, unsigned *count)
{
    *size = log->since->len;
    *count = log->count;
    return log->since->data;
}

double pel_sealedlog_time(const struct pel_sealedlog *log, uint64_t *revision)
{
    *revision = log->revision;
    return log->time_s;
}
