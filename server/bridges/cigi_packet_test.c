#include "bridges/cigi_packet.h"

#include <stdlib.h>
#include <string.h>

#include "base/near.h"

static size_t last_row(enum pel_cigi_kind kind)
{
    size_t f = pel_cigi_packets[kind].first;
    while (f + 1 < PEL_CIGI_FIELD_COUNT &&
           pel_cigi_rows[f + 1].type != PEL_CIGI_HEAD) {
        f++;
    }
    return f;
}

static size_t bytes_of(const struct pel_cigi_row *row)
{
    static const size_t sizes[] = {
        [PEL_CIGI_U8] = 1,   [PEL_CIGI_I8] = 1,  [PEL_CIGI_U16] = 2,
        [PEL_CIGI_U32] = 4,  [PEL_CIGI_F32] = 4, [PEL_CIGI_F64] = 8,
        [PEL_CIGI_BITS] = 1, [PEL_CIGI_HEAD] = 0
    };
    return sizes[row->type];
}

/* Fields lie inside their packets, aligned, and no bit is used twice. */
static void table_is_sound(void **state)
{
    (void)state;
    bool ids[256] = { false };
    for (int k = 0; k < PEL_CIGI_KIND_COUNT; k++) {
        const struct pel_cigi_info *info = &pel_cigi_packets[k];
        uint8_t used[256] = { 0xff, 0xff };
        assert_false(ids[info->id]);
        ids[info->id] = true;
        assert_int_equal(info->size % 8, 0);
        assert_int_equal(pel_cigi_rows[info->first].type, PEL_CIGI_HEAD);
        size_t last = last_row((enum pel_cigi_kind)k);
        assert_true(last - info->first < PEL_CIGI_MAX_FIELDS);
        for (size_t f = info->first + 1u; f <= last; f++) {
            const struct pel_cigi_row *row = &pel_cigi_rows[f];
            size_t size = bytes_of(row);
            unsigned mask = row->type == PEL_CIGI_BITS
                                ? ((1u << row->bits) - 1) << row->shift
                                : 0xffu;
            assert_true(size > 0 && row->offset + size <= info->size);
            assert_int_equal(row->offset % size, 0);
            assert_true(mask <= 0xff);
            for (size_t i = 0; i < size; i++) {
                assert_int_equal(used[row->offset + i] & mask, 0);
                used[row->offset + i] |= (uint8_t)mask;
            }
        }
    }
}

static const uint8_t control_big[24] = { 1, 24, 3, 0xfb, 0x35, 0,    0x80, 0,
                                         0, 0,  1, 2,    0xff, 0xff, 0xff, 0xff,
                                         0, 0,  0, 9,    0,    0,    0,    0 };
static const uint8_t control_little[24] = { 1,    24,   3,    0xfb, 0x25, 0,
                                            0,    0x80, 2,    1,    0,    0,
                                            0xff, 0xff, 0xff, 0xff, 9,    0,
                                            0,    0,    0,    0,    0,    0 };

static void bytes_are_those_of_the_standard(void **state)
{
    (void)state;
    const uint8_t *both[] = { control_big, control_little };
    for (int i = 0; i < 2; i++) {
        struct pel_cigi_reader reader;
        struct pel_cigi_packet p;
        uint8_t again[24];
        assert_int_equal(
            pel_cigi_open(both[i], 24, PEL_CIGI_KIND_IG_CONTROL, &reader),
            PEL_CIGI_GOOD);
        assert_int_equal(reader.little, i);
        assert_true(pel_cigi_next(&reader, &p));
        assert_int_equal(p.kind, PEL_CIGI_KIND_IG_CONTROL);
        assert_near(pel_cigi_get(&p, PEL_CIGI_IG_CONTROL_DATABASE), -5, 0);
        assert_near(pel_cigi_get(&p, PEL_CIGI_IG_CONTROL_MODE), 1, 0);
        assert_near(pel_cigi_get(&p, PEL_CIGI_IG_CONTROL_STAMPED), 1, 0);
        assert_near(pel_cigi_get(&p, PEL_CIGI_IG_CONTROL_MINOR), 3 - i, 0);
        assert_near(pel_cigi_get(&p, PEL_CIGI_IG_CONTROL_FRAME), 258, 0);
        assert_near(pel_cigi_get(&p, PEL_CIGI_IG_CONTROL_TIMESTAMP),
                    4294967295.0, 0);
        assert_near(pel_cigi_get(&p, PEL_CIGI_IG_CONTROL_LAST_IG_FRAME), 9, 0);
        assert_false(pel_cigi_next(&reader, &p));
        assert_int_equal(pel_cigi_put(&p, reader.little, again, 24), 24);
        assert_memory_equal(again, both[i], 24);
    }
}

static double some_value(const struct pel_cigi_row *row)
{
    switch (row->type) {
    case PEL_CIGI_U8:
        return rand() % 256;
    case PEL_CIGI_I8:
        return rand() % 256 - 128;
    case PEL_CIGI_U16:
        return rand() % 65536;
    case PEL_CIGI_U32:
        return (double)(uint32_t)rand() * 2 + 1;
    case PEL_CIGI_F32:
        return (float)(rand() - RAND_MAX / 2) * 1e-3f;
    case PEL_CIGI_F64:
        return (rand() - RAND_MAX / 2) * 1.2345e-7;
    case PEL_CIGI_BITS:
        return rand() % (1 << row->bits);
    case PEL_CIGI_HEAD:
        break;
    }
    return 0;
}

/* A datagram with one packet of every kind the host sends, and `values`. */
static size_t every_packet(bool little, uint8_t *out, size_t room,
                           struct pel_cigi_packet *packets)
{
    size_t used = 0;
    for (int k = 0; k < PEL_CIGI_KIND_COUNT; k++) {
        if (!pel_cigi_packets[k].from_host) {
            continue;
        }
        struct pel_cigi_packet p = pel_cigi_packet_of((enum pel_cigi_kind)k);
        for (size_t f = pel_cigi_packets[k].first + 1u; f <= last_row(p.kind);
             f++) {
            pel_cigi_set(&p, (enum pel_cigi_field)f,
                         some_value(&pel_cigi_rows[f]));
        }
        if (k == PEL_CIGI_KIND_IG_CONTROL) {
            pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MAJOR, 3);
            pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MINOR, 3);
            pel_cigi_set(&p, PEL_CIGI_IG_CONTROL_MAGIC, 0x8000);
        }
        packets[k] = p;
        used += pel_cigi_put(&p, little, out + used, room - used);
    }
    return used;
}

static void every_field_goes_there_and_back(void **state)
{
    (void)state;
    srand(1);
    for (int round = 0; round < 50; round++) {
        static uint8_t bytes[4096];
        static struct pel_cigi_packet sent[PEL_CIGI_KIND_COUNT];
        struct pel_cigi_packet p;
        struct pel_cigi_reader reader;
        size_t size = every_packet(round % 2, bytes, sizeof bytes, sent);
        assert_int_equal(
            pel_cigi_open(bytes, size, PEL_CIGI_KIND_IG_CONTROL, &reader),
            PEL_CIGI_GOOD);
        for (int k = 0; pel_cigi_packets[k].from_host; k++) {
            assert_true(pel_cigi_next(&reader, &p));
            assert_int_equal(p.kind, k);
            for (size_t f = pel_cigi_packets[k].first + 1u;
                 f <= last_row(p.kind); f++) {
                assert_near(pel_cigi_get(&p, (enum pel_cigi_field)f),
                            pel_cigi_get(&sent[k], (enum pel_cigi_field)f), 0);
            }
        }
        assert_false(pel_cigi_next(&reader, &p));
    }
}

/* Cut anywhere but between packets, a datagram is refused whole. */
static void truncated_datagrams_are_refused(void **state)
{
    (void)state;
    static uint8_t bytes[4096];
    static struct pel_cigi_packet sent[PEL_CIGI_KIND_COUNT];
    size_t size = every_packet(false, bytes, sizeof bytes, sent);
    size_t boundary = 0;
    for (size_t cut = 0; cut < size; cut++) {
        uint8_t *exact = malloc(cut ? cut : 1); /* so that ASan sees the end */
        struct pel_cigi_reader reader;
        struct pel_cigi_packet p;
        memcpy(exact, bytes, cut);
        while (boundary < cut) {
            boundary += bytes[boundary + 1];
        }
        enum pel_cigi_error error =
            pel_cigi_open(exact, cut, PEL_CIGI_KIND_IG_CONTROL, &reader);
        if (boundary == cut && cut >= 24) {
            assert_int_equal(error, PEL_CIGI_GOOD);
            while (pel_cigi_next(&reader, &p)) {
            }
        } else {
            assert_int_equal(error, cut < 24 ? PEL_CIGI_SHORT : PEL_CIGI_SIZE);
            assert_false(pel_cigi_next(&reader, &p));
        }
        free(exact);
    }
}

static enum pel_cigi_error open_with(size_t at, uint8_t value, size_t size)
{
    uint8_t bytes[72] = { 0 };
    struct pel_cigi_reader reader;
    memcpy(bytes, control_big, 24);
    bytes[24] = 2; /* Entity Control */
    bytes[25] = 48;
    bytes[at] = value;
    return pel_cigi_open(bytes, size, PEL_CIGI_KIND_IG_CONTROL, &reader);
}

static void wrong_datagrams_say_why(void **state)
{
    (void)state;
    assert_int_equal(open_with(0, 1, 72), PEL_CIGI_GOOD);
    assert_int_equal(open_with(0, 101, 72), PEL_CIGI_FIRST);
    assert_int_equal(open_with(24, 1, 72), PEL_CIGI_FIRST); /* twice */
    assert_int_equal(open_with(2, 4, 72), PEL_CIGI_VERSION);
    assert_int_equal(open_with(4, 0x15, 72), PEL_CIGI_VERSION);
    assert_int_equal(open_with(4, 0x25, 72), PEL_CIGI_GOOD);
    assert_int_equal(open_with(6, 0x81, 72), PEL_CIGI_ORDER);
    assert_int_equal(open_with(25, 0, 72), PEL_CIGI_SIZE);
    assert_int_equal(open_with(25, 40, 72), PEL_CIGI_SIZE);
    assert_int_equal(open_with(25, 52, 72), PEL_CIGI_SIZE);
    assert_int_equal(open_with(25, 56, 72), PEL_CIGI_SIZE);
    assert_int_equal(open_with(1, 16, 72), PEL_CIGI_SIZE);
    /* The exponent of a float whose fraction is not 0: NaN. */
    uint8_t nan[72] = { 0 };
    struct pel_cigi_reader reader;
    memcpy(nan, control_big, 24);
    nan[24] = 2;
    nan[25] = 48;
    nan[24 + 24] = 0x7f;
    nan[24 + 25] = 0xf8;
    assert_int_equal(pel_cigi_open(nan, 72, PEL_CIGI_KIND_IG_CONTROL, &reader),
                     PEL_CIGI_NUMBER);
    nan[24 + 25] = 0xf0; /* infinity */
    assert_int_equal(pel_cigi_open(nan, 72, PEL_CIGI_KIND_IG_CONTROL, &reader),
                     PEL_CIGI_NUMBER);
}

static void unknown_and_longer_packets_are_passed_over(void **state)
{
    (void)state;
    uint8_t bytes[24 + 8 + 56] = { 0 };
    struct pel_cigi_reader reader;
    struct pel_cigi_packet p;
    memcpy(bytes, control_little, 24);
    bytes[24] = 236; /* of a user */
    bytes[25] = 8;
    bytes[32] = 2;
    bytes[33] = 56; /* longer than known */
    bytes[34] = 77;
    assert_int_equal(
        pel_cigi_open(bytes, sizeof bytes, PEL_CIGI_KIND_IG_CONTROL, &reader),
        PEL_CIGI_GOOD);
    assert_true(pel_cigi_next(&reader, &p));
    assert_true(pel_cigi_next(&reader, &p));
    assert_int_equal(p.kind, PEL_CIGI_KIND_COUNT);
    assert_int_equal(p.id, 236);
    assert_true(pel_cigi_next(&reader, &p));
    assert_int_equal(p.kind, PEL_CIGI_KIND_ENTITY_CONTROL);
    assert_near(pel_cigi_get(&p, PEL_CIGI_ENTITY_CONTROL_ID), 77, 0);
    assert_false(pel_cigi_next(&reader, &p));
}

static void values_are_kept_to_their_type(void **state)
{
    (void)state;
    struct pel_cigi_packet p = pel_cigi_packet_of(PEL_CIGI_KIND_START_OF_FRAME);
    uint8_t out[24];
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_DATABASE, -1000);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_MODE, 99);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_FRAME, 1e300);
    pel_cigi_set(&p, PEL_CIGI_START_OF_FRAME_TIMESTAMP, NAN);
    assert_int_equal(pel_cigi_put(&p, false, out, 23), 0);
    assert_int_equal(pel_cigi_put(&p, false, out, 24), 24);
    assert_int_equal(out[3], 0x80);
    assert_int_equal(out[5], 3);
    assert_memory_equal(out + 8, "\xff\xff\xff\xff\0\0\0\0", 8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_is_sound),
        cmocka_unit_test(bytes_are_those_of_the_standard),
        cmocka_unit_test(every_field_goes_there_and_back),
        cmocka_unit_test(truncated_datagrams_are_refused),
        cmocka_unit_test(wrong_datagrams_say_why),
        cmocka_unit_test(unknown_and_longer_packets_are_passed_over),
        cmocka_unit_test(values_are_kept_to_their_type),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
