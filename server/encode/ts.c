#include "encode/ts.h"

#include <stdlib.h>
#include <string.h>

#define PMT_PID 0x100
#define VIDEO_PID 0x101
#define PAYLOAD (PEL_TS_PACKET - 4)
#define PES_SIZE 14
#define DELAY_90K 9000
#define MAX_UNIT ((size_t)64 << 20)

static const uint8_t delimiter[] = { 0, 0, 0, 1, 9, 0xf0 };

/* ISO/IEC 13818-1, annex A. */
static uint32_t crc(const uint8_t *data, size_t size)
{
    uint32_t value = 0xffffffff;
    for (size_t i = 0; i < size; i++) {
        value ^= (uint32_t)data[i] << 24;
        for (int bit = 0; bit < 8; bit++) {
            value = value << 1 ^ (value & 0x80000000 ? 0x04c11db7 : 0);
        }
    }
    return value;
}

static void put_head(uint8_t *packet, unsigned pid, bool start, bool adaptation,
                     uint8_t *counter)
{
    packet[0] = 0x47;
    packet[1] = (uint8_t)((start ? 0x40 : 0) | pid >> 8);
    packet[2] = (uint8_t)pid;
    packet[3] = (uint8_t)((adaptation ? 0x30 : 0x10) | (*counter & 15));
    ++*counter;
}

/* A table in one packet; its section begins after the pointer field and gets
 * its checksum. */
static void put_table(uint8_t *packet, unsigned pid, const uint8_t *section,
                      size_t size, uint8_t *counter)
{
    memset(packet, 0xff, PEL_TS_PACKET);
    put_head(packet, pid, true, false, counter);
    packet[4] = 0;
    memcpy(packet + 5, section, size);
    uint32_t sum = crc(section, size);
    for (int i = 0; i < 4; i++) {
        packet[5 + size + (size_t)i] = (uint8_t)(sum >> (24 - 8 * i));
    }
}

static void put_tables(struct pel_ts *ts, uint8_t *packets)
{
    static const uint8_t pat[] = {
        0x00,
        0xb0,
        13,
        0,
        1,
        0xc1,
        0,
        0, /* table 0, 13 bytes follow */
        0,
        1,
        0xe0 | PMT_PID >> 8,
        PMT_PID & 0xff,
    };
    static const uint8_t pmt[] = {
        0x02,
        0xb0,
        18,
        0,
        1,
        0xc1,
        0,
        0, /* table 2, 18 bytes follow */
        0xe0 | VIDEO_PID >> 8,
        VIDEO_PID & 0xff,
        0xf0,
        0, /* clock; no text */
        0x1b,
        0xe0 | VIDEO_PID >> 8,
        VIDEO_PID & 0xff,
        0xf0,
        0, /* H.264 */
    };
    put_table(packets, 0, pat, sizeof pat, &ts->pat);
    put_table(packets + PEL_TS_PACKET, PMT_PID, pmt, sizeof pmt, &ts->pmt);
}

static void put_pes(uint8_t *out, uint64_t pts)
{
    const uint8_t head[PES_SIZE] = {
        0,
        0,
        1,
        0xe0,
        0,
        0, /* video, of any length */
        0x84,
        0x80,
        5, /* aligned; a PTS in 5 bytes */
        (uint8_t)(0x21 | (pts >> 29 & 0x0e)),
        (uint8_t)(pts >> 22),
        (uint8_t)(0x01 | (pts >> 14 & 0xfe)),
        (uint8_t)(pts >> 7),
        (uint8_t)(0x01 | (pts << 1 & 0xfe)),
    };
    memcpy(out, head, sizeof head);
}

static void put_pcr(uint8_t *out, uint64_t base)
{
    out[0] = (uint8_t)(base >> 25);
    out[1] = (uint8_t)(base >> 17);
    out[2] = (uint8_t)(base >> 9);
    out[3] = (uint8_t)(base >> 1);
    out[4] = (uint8_t)((base & 1) << 7 | 0x7e);
    out[5] = 0;
}

/* What an access unit is read from: PES header, delimiter, its own bytes. */
struct source {
    uint8_t front[PES_SIZE + sizeof delimiter];
    size_t front_size, at;
    const uint8_t *unit;
    size_t size;
};

static void take(struct source *s, uint8_t *out, size_t count)
{
    while (count > 0) {
        bool front = s->at < s->front_size;
        const uint8_t *from =
            front ? s->front + s->at : s->unit + (s->at - s->front_size);
        size_t n = front ? s->front_size - s->at : count;
        n = n < count ? n : count;
        memcpy(out, from, n);
        out += n;
        s->at += n;
        count -= n;
    }
}

/* The first packet has an adaptation field with the clock, the last one has
 * one that fills it. */
static void put_video(struct pel_ts *ts, uint8_t *packet, struct source *s,
                      bool first, bool key, uint64_t base)
{
    size_t left = s->front_size + s->size - s->at;
    size_t field = first ? 8 : 0; /* with its length byte */
    if (left + field < PAYLOAD) {
        field = PAYLOAD - left;
    }
    put_head(packet, VIDEO_PID, first, field > 0, &ts->video);
    if (field > 0) {
        memset(packet + 4, 0xff, field);
        packet[4] = (uint8_t)(field - 1);
    }
    if (field > 1) {
        packet[5] = (uint8_t)((first ? 0x10 : 0) | (first && key ? 0x40 : 0));
    }
    if (first) {
        put_pcr(packet + 6, base);
    }
    take(s, packet + 4 + field, PAYLOAD - field);
}

static bool has_delimiter(const uint8_t *unit, size_t size)
{
    return size > 5 && ((unit[2] == 1 && (unit[3] & 31) == 9) ||
                        (unit[3] == 1 && (unit[4] & 31) == 9));
}

enum pel_err pel_ts_write(struct pel_ts *ts, const uint8_t *unit, size_t size,
                          int64_t time_ns, bool key, struct pel_bytes *out)
{
    *out = (struct pel_bytes){ 0 };
    if (size == 0 || size > MAX_UNIT || time_ns < 0) {
        return PEL_ERR_INVALID;
    }
    uint64_t base = (uint64_t)(time_ns / 1000) * 9 / 100;
    struct source s = { .front_size = PES_SIZE, .unit = unit, .size = size };
    put_pes(s.front, base + DELAY_90K);
    if (!has_delimiter(unit, size)) {
        memcpy(s.front + PES_SIZE, delimiter, sizeof delimiter);
        s.front_size += sizeof delimiter;
    }
    size_t bytes = s.front_size + size + 8; /* 8: the clock */
    size_t packets = (bytes + PAYLOAD - 1) / PAYLOAD + (key ? 2 : 0);
    out->data = malloc(packets * PEL_TS_PACKET);
    if (!out->data) {
        return PEL_ERR_NO_MEMORY;
    }
    out->size = packets * PEL_TS_PACKET;
    size_t at = 0;
    if (key) {
        put_tables(ts, out->data);
        at = 2;
    }
    for (size_t first = at; at < packets; at++) {
        put_video(ts, out->data + at * PEL_TS_PACKET, &s, at == first, key,
                  base);
    }
    return PEL_OK;
}
