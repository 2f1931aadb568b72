#include "pelog.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "base/checksum.h"
#include "base/reserve.h"
#include "wire.h"

#define MAX_TIME_S 1e9

#define HEADER_SIZE 16 /* magic, tag, checksum of both */
#define TAG_FIRST 0xf5 /* in no text that is UTF-8 */

static uint32_t get32(const uint8_t *from)
{
    return from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 |
           (uint32_t)from[3] << 24;
}

static void put32(uint8_t *to, uint32_t value)
{
    for (int i = 0; i < 4; i++) {
        to[i] = (uint8_t)(value >> (8 * i));
    }
}

/* --- the first bytes ------------------------------------------------------ */

/* By the digit in the first bytes; 0: no log of any version. */
static unsigned version_of(const char *data, size_t size)
{
    return size >= PEL_LOG_MAGIC_SIZE && memcmp(data, "PELOG", 5) == 0 &&
                   data[5] >= '0' && data[5] <= '9' &&
                   memcmp(data + 6, "\r\n", 2) == 0
               ? (unsigned)(data[5] - '0')
               : 0;
}

bool pel_log_is(const void *data, size_t size)
{
    unsigned version = version_of(data, size);
    return version > 0 && version <= PEL_LOG_FORM;
}

static bool good_header(const uint8_t *data, size_t size)
{
    return size >= PEL_LOG_BEGIN_SIZE &&
           get32(data + 12) == pel_crc32c(0, data, 12);
}

size_t pel_log_head_bytes(const void *data, size_t size)
{
    const uint8_t *bytes = data;
    size_t offset, length;
    size_t frame = PEL_LOG_BEGIN_SIZE + PEL_LOG_FRAME_SIZE;
    if (!pel_log_is(data, size)) {
        return 0;
    }
    if (version_of(data, size) < PEL_LOG_FORM) {
        (void)pel_wire_next(bytes + PEL_LOG_MAGIC_SIZE,
                            size - PEL_LOG_MAGIC_SIZE, PEL_LOG_MAX_ENTRY,
                            &offset, &length);
        return length > PEL_LOG_MAX_ENTRY
                   ? 0
                   : PEL_LOG_MAGIC_SIZE + PEL_WIRE_MAX_PREFIX + length;
    }
    length = size >= frame ? get32(bytes + PEL_LOG_BEGIN_SIZE + 8) : 0;
    return length > PEL_LOG_MAX_ENTRY ? 0 : frame + length;
}

static enum pel_err newer(unsigned version, unsigned known,
                          struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_CONFLICT,
                         "it is of version %u, which a newer program wrote, "
                         "and this one reads version %u",
                         version, known);
}

/* The number of entries by the journal's head; 0: the head has none. */
static uint32_t counted(const uint8_t *data)
{
    const uint8_t *at = data + PEL_LOG_COUNT_AT;
    return get32(at + 12) == pel_crc32c(pel_crc32c(0, data + 8, 4), at, 12)
               ? get32(at)
               : 0;
}

static bool is_entry(const struct pel_log_reader *reader, size_t at);

/* Where the first bytes are damaged, the tag is that of the first entry that
 * is whole. */
static bool find_tag(struct pel_log_reader *reader)
{
    for (size_t at = PEL_LOG_MAGIC_SIZE;
         at + PEL_LOG_FRAME_SIZE <= reader->size; at++) {
        if (reader->data[at] == TAG_FIRST) {
            memcpy(reader->tag, reader->data + at, sizeof reader->tag);
            if (is_entry(reader, at)) {
                return true;
            }
        }
    }
    return false;
}

static void note(struct pel_log_reader *reader, size_t at, size_t bytes,
                 const char *reason)
{
    struct pel_log_damage *d = &reader->damage;
    if (d->places == 0) {
        d->at = at;
        snprintf(d->reason, sizeof d->reason, "%s", reason);
    }
    d->places++;
    d->bytes += bytes;
}

enum pel_err pel_log_open(struct pel_log_reader *reader, const void *data,
                          size_t size, struct pel_fault *fault)
{
    *reader = (struct pel_log_reader){ .data = data, .size = size };
    unsigned version = version_of(data, size);
    if (version > PEL_LOG_FORM) {
        return newer(version, PEL_LOG_FORM, fault);
    }
    if (!pel_log_is(data, size)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "not a command log of version %d", PEL_LOG_FORM);
    }
    reader->form = version;
    reader->at = PEL_LOG_MAGIC_SIZE;
    if (version == PEL_LOG_FORM) {
        if (!good_header(reader->data, size)) {
            return pel_fault_set(fault, PEL_ERR_MALFORMED,
                                 "the first %d bytes are damaged", HEADER_SIZE);
        }
        memcpy(reader->tag, reader->data + 8, sizeof reader->tag);
        reader->counted = counted(reader->data);
        reader->at = PEL_LOG_BEGIN_SIZE;
    }
    return PEL_OK;
}

enum pel_err pel_log_mend(struct pel_log_reader *reader, const void *data,
                          size_t size, struct pel_fault *fault)
{
    enum pel_err err = pel_log_open(reader, data, size, fault);
    if (err) {
        /* A newer program's log has its own checksum there. */
        bool newer_whole =
            err == PEL_ERR_CONFLICT && good_header(reader->data, size);
        if (newer_whole || !find_tag(reader)) {
            return err;
        }
        reader->form = PEL_LOG_FORM;
        reader->at = size < PEL_LOG_BEGIN_SIZE ? size : PEL_LOG_BEGIN_SIZE;
        note(reader, 0, HEADER_SIZE, "the first bytes are damaged");
    } else if (reader->form == PEL_LOG_FORM && reader->counted == 0 &&
               get32(reader->data + PEL_LOG_COUNT_AT + 12) != 0) {
        note(reader, PEL_LOG_COUNT_AT, PEL_LOG_COUNT_SIZE,
             "the count of entries is damaged");
    }
    reader->mends = true;
    return PEL_OK;
}

/* --- entries -------------------------------------------------------------- */

static enum pel_err malformed(const struct pel_log_reader *reader,
                              const char *why, struct pel_fault *fault)
{
    return pel_fault_set(fault, PEL_ERR_MALFORMED,
                         "entry %zu, at byte %llu, %s", reader->entries + 1,
                         (unsigned long long)reader->base + reader->at, why);
}

/* Whether a whole entry with this file's tag lies there. */
static bool is_entry(const struct pel_log_reader *reader, size_t at)
{
    if (reader->size < PEL_LOG_FRAME_SIZE ||
        at > reader->size - PEL_LOG_FRAME_SIZE) {
        return false;
    }
    const uint8_t *frame = reader->data + at;
    size_t length = get32(frame + 8);
    size_t left = reader->size - at - PEL_LOG_FRAME_SIZE;
    return memcmp(frame, reader->tag, sizeof reader->tag) == 0 && length > 0 &&
           length <= PEL_LOG_MAX_ENTRY && length <= left &&
           get32(frame + 12) == pel_crc32c(pel_crc32c(0, frame, 12),
                                           frame + PEL_LOG_FRAME_SIZE, length);
}

/* The next place from `at` on where one does; the end of the file: nowhere. */
static size_t find_entry(const struct pel_log_reader *reader, size_t at)
{
    while (at < reader->size) {
        const uint8_t *next =
            memchr(reader->data + at, TAG_FIRST, reader->size - at);
        if (!next) {
            break;
        }
        at = (size_t)(next - reader->data);
        if (is_entry(reader, at)) {
            return at;
        }
        at++;
    }
    return reader->size;
}

static bool zeroes(const struct pel_log_reader *reader, size_t at)
{
    while (at < reader->size && reader->data[at] == 0) {
        at++;
    }
    return at == reader->size;
}

/* The kind of the bytes at the reader's place. */
enum place { ENTRY, END, TORN, NO_LENGTH, DAMAGED };

static enum place place_before(const struct pel_log_reader *reader,
                               size_t *offset, size_t *length)
{
    switch (pel_wire_next(reader->data + reader->at, reader->size - reader->at,
                          PEL_LOG_MAX_ENTRY, offset, length)) {
    case PEL_WIRE_MESSAGE:
        return ENTRY;
    case PEL_WIRE_MORE:
        return reader->at == reader->size ? END : TORN;
    default:
        return NO_LENGTH;
    }
}

static enum place place_of(const struct pel_log_reader *reader, size_t *offset,
                           size_t *length)
{
    size_t left = reader->size - reader->at;
    size_t tag = left < sizeof reader->tag ? left : sizeof reader->tag;
    *offset = *length = 0;
    if (reader->form < PEL_LOG_FORM) {
        return place_before(reader, offset, length);
    }
    if (is_entry(reader, reader->at)) {
        *offset = PEL_LOG_FRAME_SIZE;
        *length = get32(reader->data + reader->at + 8);
        return ENTRY;
    }
    if (zeroes(reader, reader->at)) {
        return END;
    }
    bool begun = memcmp(reader->data + reader->at, reader->tag, tag) == 0;
    bool cut = left < PEL_LOG_FRAME_SIZE ||
               get32(reader->data + reader->at + 8) > left - PEL_LOG_FRAME_SIZE;
    return begun && cut && find_entry(reader, reader->at + 1) == reader->size
               ? TORN
               : DAMAGED;
}

bool pel_log_skip(struct pel_log_reader *reader, const uint8_t **data,
                  size_t *size)
{
    size_t offset, length;
    if (place_of(reader, &offset, &length) != ENTRY) {
        return false;
    }
    *data = reader->data + reader->at + offset;
    *size = length;
    reader->at += offset + length;
    return true;
}

size_t pel_log_entry_bytes(const struct pel_log_reader *reader)
{
    size_t offset, length, left = reader->size - reader->at;
    const uint8_t *at = reader->data + reader->at;
    if (reader->form < PEL_LOG_FORM) {
        enum pel_wire next =
            pel_wire_next(at, left, PEL_LOG_MAX_ENTRY, &offset, &length);
        return offset > 0 && (next == PEL_WIRE_MESSAGE || next == PEL_WIRE_MORE)
                   ? offset + length
                   : 0;
    }
    length = left < PEL_LOG_FRAME_SIZE ||
                     memcmp(at, reader->tag, sizeof reader->tag) != 0
                 ? 0
                 : get32(at + 8);
    return length == 0 || length > PEL_LOG_MAX_ENTRY
               ? 0
               : PEL_LOG_FRAME_SIZE + length;
}

bool pel_log_last(const struct pel_log_reader *reader, size_t within,
                  const uint8_t **data, size_t *size)
{
    for (size_t at = within < reader->size ? within : reader->size; at > 0;
         at--) {
        if (reader->data[at - 1] == TAG_FIRST && is_entry(reader, at - 1)) {
            *data = reader->data + at - 1 + PEL_LOG_FRAME_SIZE;
            *size = get32(reader->data + at - 1 + 8);
            return true;
        }
    }
    return false;
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
    if (!reader->mends && !head != (reader->entries > 0)) {
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
    if (!reader->mends && goes_back(reader, entry)) {
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

/* Its entry, if there is nothing against it. */
static enum pel_err unpack(struct pel_log_reader *reader, const uint8_t *data,
                           size_t length, Pelagos__LogEntry **out,
                           struct pel_fault *fault)
{
    Pelagos__LogEntry *entry = pelagos__log_entry__unpack(NULL, length, data);
    unsigned version = head_version(entry);
    const char *why = entry ? flaw(reader, entry) : "is no LogEntry";
    enum pel_err err = version > PEL_LOG_VERSION_STATES
                           ? newer(version, PEL_LOG_VERSION_STATES, fault)
                       : why ? malformed(reader, why, fault)
                             : PEL_OK;
    if (err && entry) {
        pelagos__log_entry__free_unpacked(entry, NULL);
        entry = NULL;
    }
    *out = entry;
    return err;
}

/* The end of one that mends. */
static void end(struct pel_log_reader *reader)
{
    if (reader->number < reader->counted) {
        reader->damage.lost += reader->counted - reader->number;
        if (reader->damage.places == 0) {
            note(reader, reader->at, 0, "it was cut off");
        }
        reader->number = reader->counted;
    }
    reader->damage.more = reader->torn && reader->counted == 0;
    reader->size = reader->at;
}

/* Goes on where the next entry is, or ends. */
static void pass_over(struct pel_log_reader *reader, enum place place)
{
    bool mendable = reader->form == PEL_LOG_FORM;
    size_t next = mendable ? find_entry(reader, reader->at + 1) : reader->size;
    size_t end_at = next;
    while (end_at > reader->at && next == reader->size &&
           reader->data[end_at - 1] == 0 && mendable) {
        end_at--; /* room that was never written */
    }
    note(reader, reader->at, end_at - reader->at,
         place == TORN        ? "ends inside an entry"
         : place == NO_LENGTH ? "has no length that can be"
                              : "is damaged: its checksum does not fit");
    reader->torn = next == reader->size;
    reader->at = next;
}

/* Whether the entry at the place is to be given, by its number. */
static bool is_due(struct pel_log_reader *reader)
{
    if (reader->form < PEL_LOG_FORM) {
        return true;
    }
    uint32_t number = get32(reader->data + reader->at + 4);
    if (number < reader->number) {
        reader->damage.twice++;
        return false;
    }
    reader->damage.lost += number - reader->number;
    reader->number = number + 1;
    return true;
}

static enum pel_err next_mended(struct pel_log_reader *reader,
                                Pelagos__LogEntry **out,
                                struct pel_fault *fault)
{
    size_t offset, length;
    enum place place;
    while ((place = place_of(reader, &offset, &length)) != END) {
        size_t at = reader->at;
        if (place != ENTRY) {
            pass_over(reader, place);
            continue;
        }
        if (!is_due(reader)) {
            note(reader, at, offset + length, "is there twice");
            reader->at += offset + length;
            continue;
        }
        enum pel_err err =
            unpack(reader, reader->data + at + offset, length, out, fault);
        if (err == PEL_ERR_MALFORMED) {
            reader->damage.lost++;
            pass_over(reader, DAMAGED);
            continue;
        }
        reader->at += offset + length;
        reader->entries += !err;
        return err;
    }
    end(reader);
    return PEL_OK;
}

static const char *words(enum place place)
{
    return place == NO_LENGTH ? "has no length that can be"
                              : "is damaged: its checksum does not fit";
}

enum pel_err pel_log_next(struct pel_log_reader *reader,
                          Pelagos__LogEntry **out, struct pel_fault *fault)
{
    size_t offset, length;
    *out = NULL;
    if (reader->mends) {
        return next_mended(reader, out, fault);
    }
    enum place place = place_of(reader, &offset, &length);
    if (place == END || place == TORN) {
        reader->torn = reader->at < reader->size;
        reader->size = reader->at;
        return reader->entries > 0 ? PEL_OK
                                   : malformed(reader, "is not whole", fault);
    }
    if (place != ENTRY) {
        return malformed(reader, words(place), fault);
    }
    if (reader->form == PEL_LOG_FORM &&
        get32(reader->data + reader->at + 4) != reader->entries) {
        return malformed(reader, "has the number of another", fault);
    }
    enum pel_err err =
        unpack(reader, reader->data + reader->at + offset, length, out, fault);
    if (!err) {
        reader->time_s = time_after(*out);
        reader->at += offset + length;
        reader->entries++;
    }
    return err;
}

/* --- writing -------------------------------------------------------------- */

void pel_log_begin(struct pel_log_writer *writer,
                   uint8_t out[PEL_LOG_BEGIN_SIZE])
{
    *writer = (struct pel_log_writer){ 0 };
    (void)!getrandom(writer->tag, sizeof writer->tag, GRND_NONBLOCK);
    writer->tag[0] = TAG_FIRST;
    memset(out, 0, PEL_LOG_BEGIN_SIZE);
    memcpy(out, PEL_LOG_MAGIC, PEL_LOG_MAGIC_SIZE);
    memcpy(out + 8, writer->tag, sizeof writer->tag);
    put32(out + 12, pel_crc32c(0, out, 12));
}

static void frame(struct pel_log_writer *writer, const uint8_t *message,
                  size_t length, uint8_t *out)
{
    memcpy(out, writer->tag, sizeof writer->tag);
    put32(out + 4, writer->count++);
    put32(out + 8, (uint32_t)length);
    memcpy(out + PEL_LOG_FRAME_SIZE, message, length);
    put32(out + 12,
          pel_crc32c(pel_crc32c(0, out, 12), out + PEL_LOG_FRAME_SIZE, length));
}

uint8_t *pel_log_frame(struct pel_log_writer *writer, const uint8_t *messages,
                       size_t size, size_t *out_size)
{
    size_t offset, length, room = 0, at = 0, used = 0;
    while (pel_wire_next(messages + at, size - at, size, &offset, &length) ==
           PEL_WIRE_MESSAGE) {
        at += offset + length;
        room += PEL_LOG_FRAME_SIZE + length;
    }
    uint8_t *out = pel_sure_malloc(room + 1);
    at = 0;
    while (pel_wire_next(messages + at, size - at, size, &offset, &length) ==
           PEL_WIRE_MESSAGE) {
        frame(writer, messages + at + offset, length, out + used);
        at += offset + length;
        used += PEL_LOG_FRAME_SIZE + length;
    }
    *out_size = used;
    return out;
}

void pel_log_count(const struct pel_log_writer *writer,
                   uint8_t out[PEL_LOG_COUNT_SIZE])
{
    memset(out, 0, PEL_LOG_COUNT_SIZE);
    put32(out, writer->count);
    put32(out + 12, pel_crc32c(pel_crc32c(0, writer->tag, 4), out, 12));
}
