/* A log read by a window says what one that is whole in memory says. */
#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "message.h"
#include "pelog.h"
#include "scene/logentry.h"
#include "scene/logfile.h"
#include "wire.h"

#define MOST 64

static char path[64];

/* Entries of all sizes: of steps, and of patches with long names. */
static GByteArray *made(unsigned form, const size_t *sizes, size_t count)
{
    struct pel_log_writer writer;
    uint8_t begin[PEL_LOG_BEGIN_SIZE];
    GByteArray *out = g_byte_array_new();
    pel_log_begin(&writer, begin);
    g_byte_array_append(
        out, form == 1 ? (const uint8_t *)PEL_LOG_MAGIC_BEFORE : begin,
        form == 1 ? PEL_LOG_MAGIC_SIZE : PEL_LOG_BEGIN_SIZE);
    for (size_t i = 0; i < count + 1; i++) {
        size_t size, framed;
        Pelagos__LogHead head = PELAGOS__LOG_HEAD__INIT;
        Pelagos__Patch patch = PELAGOS__PATCH__INIT;
        g_autofree char *text = g_strnfill(i > 0 ? sizes[i - 1] : 0, 'x');
        char *remove[] = { text };
        patch.n_remove = 1;
        patch.remove = remove;
        head.has_version = true;
        head.version = PEL_LOG_VERSION;
        head.state =
            (Pelagos__State *)pel_message_new(&pelagos__state__descriptor);
        head.state->clock =
            (Pelagos__Clock *)pel_message_new(&pelagos__clock__descriptor);
        uint8_t *data = i == 0 ? pel_log_pack_head(&head, &size)
                        : *text
                            ? pel_log_pack_patch((double)i, i, &patch, &size)
                            : pel_log_pack_step((double)i, i, &size);
        uint8_t *frame =
            form == 1 ? NULL : pel_log_frame(&writer, data, size, &framed);
        g_byte_array_append(out, frame ? frame : data,
                            (guint)(frame ? framed : size));
        pelagos__state__free_unpacked(head.state, NULL);
        free(frame);
        free(data);
    }
    return out;
}

struct told {
    size_t count;
    double times[MOST];
    enum pel_err err;
    struct pel_fault fault;
};

static void keep(struct told *told, Pelagos__LogEntry *entry)
{
    assert_true(told->count < MOST);
    told->times[told->count++] = entry->time;
    pelagos__log_entry__free_unpacked(entry, NULL);
}

static struct told in_memory(const uint8_t *data, size_t size)
{
    struct told told = { 0 };
    struct pel_log_reader reader;
    Pelagos__LogEntry *entry = NULL;
    told.err = pel_log_open(&reader, data, size, &told.fault);
    while (!told.err &&
           !(told.err = pel_log_next(&reader, &entry, &told.fault)) && entry) {
        keep(&told, entry);
    }
    return told;
}

static struct told by_window(const uint8_t *data, size_t size)
{
    struct told told = { 0 };
    struct pel_logfile *log = NULL;
    Pelagos__LogEntry *entry = NULL;
    assert_true(
        g_file_set_contents(path, (const char *)data, (gssize)size, NULL));
    told.err = pel_logfile_open(path, &log, &told.fault);
    while (!told.err &&
           !(told.err = pel_logfile_next(log, &entry, &told.fault)) && entry) {
        keep(&told, entry);
    }
    pel_logfile_close(log);
    return told;
}

static void same(const uint8_t *data, size_t size)
{
    struct told a = in_memory(data, size), b = by_window(data, size);
    assert_int_equal(a.count, b.count);
    assert_memory_equal(a.times, b.times, sizeof a.times);
    assert_int_equal(a.err, b.err);
    assert_string_equal(a.fault.message, b.fault.message);
}

static const size_t SIZES[] = { 0,      10,     90000, 0, 300000,  262144 - 60,
                                262144, 70,     0,     5, 4194200, 12,
                                0,      600000, 31,    0, 131072,  1 };

static void begin(void)
{
    g_autofree char *name = g_strdup_printf("logfile-%d", (int)getpid());
    g_strlcpy(path, name, sizeof path);
}

/* Cut, flipped and zeroed in places of all kinds. */
static void test_the_same_words(void **state)
{
    (void)state;
    for (unsigned form = 1; form <= 2; form++) {
        GByteArray *log = made(form, SIZES, G_N_ELEMENTS(SIZES));
        same(log->data, log->len);
        for (size_t i = 0; i < 48; i++) {
            size_t at = (size_t)(i * 7919 * 131 + i) % log->len;
            same(log->data, at);
            log->data[at] ^= 0x10;
            same(log->data, log->len);
            log->data[at] ^= 0x10;
        }
        g_byte_array_unref(log);
    }
}

static void test_zeroes_behind(void **state)
{
    (void)state;
    GByteArray *log = made(2, SIZES, G_N_ELEMENTS(SIZES));
    guint end = log->len;
    static const guint behind[] = { 5, 300000, 11u << 20 };
    for (size_t i = 0; i < G_N_ELEMENTS(behind); i++) {
        double last = -1;
        struct pel_logfile *file;
        struct pel_fault fault;
        g_byte_array_set_size(log, end + behind[i]);
        memset(log->data + end, 0, behind[i]);
        same(log->data, log->len);
        assert_int_equal(pel_logfile_open(path, &file, &fault), PEL_OK);
        assert_int_equal(pel_logfile_last(file, &last, &fault), PEL_OK);
        assert_true(last == (double)G_N_ELEMENTS(SIZES));
        pel_logfile_close(file);
        log->data[log->len - 1] = 1; /* no zero: damage */
        same(log->data, log->len);
    }
    g_byte_array_unref(log);
}

/* From each place to each, and the end from anywhere. */
static void test_places(void **state)
{
    (void)state;
    for (unsigned form = 1; form <= 2; form++) {
        GByteArray *log = made(form, SIZES, G_N_ELEMENTS(SIZES));
        struct pel_logfile_place places[MOST];
        struct pel_logfile *file;
        struct pel_fault fault;
        Pelagos__LogEntry *entry;
        size_t count = 0;
        double last;
        assert_true(
            g_file_set_contents(path, (char *)log->data, log->len, NULL));
        assert_int_equal(pel_logfile_open(path, &file, &fault), PEL_OK);
        do {
            places[count++] = pel_logfile_place(file);
            assert_int_equal(pel_logfile_last(file, &last, &fault), PEL_OK);
            assert_true(last == (double)G_N_ELEMENTS(SIZES));
            assert_int_equal(pel_logfile_next(file, &entry, &fault), PEL_OK);
            if (entry) {
                assert_true(entry->time == (double)(count - 1));
                pelagos__log_entry__free_unpacked(entry, NULL);
            }
        } while (entry);
        assert_int_equal(count, G_N_ELEMENTS(SIZES) + 2);
        for (size_t i = 0; i < 200; i++) {
            size_t to = i * 31 % (G_N_ELEMENTS(SIZES) + 1);
            pel_logfile_go(file, places[to]);
            assert_int_equal(pel_logfile_next(file, &entry, &fault), PEL_OK);
            assert_true(entry && entry->time == (double)to);
            pelagos__log_entry__free_unpacked(entry, NULL);
        }
        pel_logfile_close(file);
        g_byte_array_unref(log);
    }
}

/* One that is cut while it is read is torn there. */
static void test_cut_meanwhile(void **state)
{
    (void)state;
    GByteArray *log = made(2, SIZES, G_N_ELEMENTS(SIZES));
    struct pel_logfile *file;
    struct pel_fault fault;
    Pelagos__LogEntry *entry;
    size_t count = 0;
    assert_true(g_file_set_contents(path, (char *)log->data, log->len, NULL));
    assert_int_equal(pel_logfile_open(path, &file, &fault), PEL_OK);
    assert_return_code(truncate(path, 500000), 0);
    while (!pel_logfile_next(file, &entry, &fault) && entry) {
        pelagos__log_entry__free_unpacked(entry, NULL);
        count++;
    }
    assert_int_equal(count, in_memory(log->data, 500000).count);
    pel_logfile_close(file);
    g_byte_array_unref(log);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_same_words),
        cmocka_unit_test(test_zeroes_behind),
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_cut_meanwhile),
    };
    begin();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(path);
    return failed;
}
