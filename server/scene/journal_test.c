/* A damaged journal: each loss is told in numbers, and what is whole is used.
 */
#include <glib.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/aside.h"
#include "base/log.h"
#include "json.h"
#include "message.h"
#include "pelog.h"
#include "scene/check.h"
#include "scene/edit.h"
#include "scene/journal.h"
#include "scene/logentry.h"

#define EDITS 24

static char *folder, *path, *journal;
static struct pel_worker *worker;
static Pelagos__State *base;
static uint8_t *whole;
static size_t whole_size;
static size_t ends[EDITS + 2]; /* of the head and of each edit */

static void nobody_wants(void *user)
{
    (void)user;
}

static const struct pel_journal_cares refuses = { false, nobody_wants, NULL };
static const struct pel_journal_cares goes_on = { true, nobody_wants, NULL };

static Pelagos__State *copy(void)
{
    return (Pelagos__State *)pel_message_copy(&base->base);
}

static Pelagos__Patch *edit(int i)
{
    Pelagos__Patch *patch = NULL;
    struct pel_fault fault;
    g_autofree char *text = g_strdup_printf(
        "{\"entities\":{\"%d\":{\"name\":\"ship %d\",\"latitude\":52.6,"
        "\"longitude\":5.2}}}",
        10 + i, i);
    assert_int_equal(pel_json_merge_patch(text, strlen(text), &patch, &fault),
                     PEL_OK);
    return patch;
}

/* Adds edit i as the scene does. */
static bool add(struct pel_journal *j, Pelagos__State **state, int i)
{
    Pelagos__State *next;
    struct pel_fault fault;
    Pelagos__Patch *patch = edit(i);
    assert_int_equal(pel_state_apply(*state, patch, &next, &fault), PEL_OK);
    next->revision = (*state)->revision + 1;
    bool kept = pel_journal_add(j, 0, patch, next);
    pelagos__patch__free_unpacked(patch, NULL);
    pelagos__state__free_unpacked(kept ? *state : next, NULL);
    *state = kept ? next : *state;
    return kept;
}

static struct pel_journal *create(const char *lineage,
                                  const struct pel_journal_cares *cares)
{
    return pel_journal_create(path, lineage, base, NULL, cares, worker);
}

static int begin(void **state)
{
    (void)state;
    folder = g_dir_make_tmp("journal-XXXXXX", NULL);
    path = g_build_filename(folder, "state", NULL);
    journal = g_strconcat(path, ".journal", NULL);
    worker = pel_worker_create("test");
    base = pel_state_default();
    pel_log_set_level(PEL_LOG_ERROR);
    signal(SIGXFSZ, SIG_IGN);
    Pelagos__State *now = copy();
    struct pel_journal *j = create("one", &refuses);
    size_t at = 0;
    for (int i = 0; i <= EDITS; i++) {
        char *bytes;
        gsize size;
        if (i > 0) {
            assert_true(add(j, &now, i));
        }
        assert_true(g_file_get_contents(journal, &bytes, &size, NULL));
        ends[at++] = size;
        g_free(bytes);
    }
    pelagos__state__free_unpacked(now, NULL);
    assert_true(pel_journal_close(j, false));
    gsize size;
    assert_true(g_file_get_contents(journal, (char **)&whole, &size, NULL));
    whole_size = size;
    return 0;
}

static int finish(void **state)
{
    (void)state;
    pel_worker_destroy(worker);
    unlink(journal);
    rmdir(folder);
    g_free(folder);
    g_free(path);
    g_free(journal);
    g_free(whole);
    pelagos__state__free_unpacked(base, NULL);
    return 0;
}

/* Without bringing it to the disk. */
static void put_file(const void *bytes, size_t size)
{
    FILE *file = fopen(journal, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* Loads a journal of these bytes onto the state file's state. */
static struct pel_journal_found load(const void *bytes, size_t size,
                                     unsigned *ships)
{
    struct pel_journal_found found;
    struct pel_fault fault;
    Pelagos__State *state = copy();
    put_file(bytes, size);
    assert_int_equal(pel_journal_load(path, "one", &state, &found, &fault),
                     PEL_OK);
    *ships = (unsigned)(state->n_entities - base->n_entities);
    pelagos__state__free_unpacked(state, NULL);
    assert_int_equal(found.damaged, found.kept != NULL);
    if (found.kept) {
        assert_int_equal(unlink(found.kept), 0);
        g_free(found.kept);
    }
    return found;
}

static void what_is_whole_is_all_used(void **state)
{
    (void)state;
    unsigned ships;
    struct pel_journal_found found = load(whole, whole_size, &ships);
    assert_false(found.damaged);
    assert_int_equal(found.edits, EDITS);
    assert_int_equal(ships, EDITS);
}

static void a_flipped_bit_costs_one_edit_at_most(void **state)
{
    (void)state;
    unsigned told = 0, lost = 0, ships, most = 0;
    for (size_t at = 0; at < whole_size; at++) {
        uint8_t was = whole[at];
        whole[at] ^= (uint8_t)(1u << (at % 8));
        struct pel_journal_found found = load(whole, whole_size, &ships);
        whole[at] = was;
        told += found.damaged;
        lost += EDITS - ships;
        most = MAX(most, EDITS - ships);
        if (!found.damaged || ships < EDITS - 1 ||
            (at >= ends[0] && found.lost != EDITS - ships)) {
            fail_msg("byte %zu: %u edits of %d, %u lost: %s", at, ships, EDITS,
                     found.lost, found.words);
        }
    }
    print_message("%zu places with a flipped bit: %u told, at most %u edit of "
                  "%d lost each, %u in all\n",
                  whole_size, told, most, EDITS, lost);
}

static void each_end_that_is_torn_is_told(void **state)
{
    (void)state;
    unsigned ships, told = 0;
    for (size_t size = 0; size < whole_size; size++) {
        unsigned entries = 0;
        while (entries <= EDITS && ends[entries] <= size) {
            entries++;
        }
        struct pel_journal_found found = load(whole, size, &ships);
        unsigned wanted = entries > 0 ? entries - 1 : 0;
        told += found.damaged;
        assert_true(found.damaged);
        assert_int_equal(ships, wanted);
        if (size >= ends[0]) {
            assert_int_equal(found.lost, EDITS - wanted);
        }
    }
    print_message("%zu lengths: %u told\n", whole_size, told);
}

/* A journal with `size` bytes at `at` replaced by others. */
static void damage(size_t at, const uint8_t *by, size_t size, bool insert)
{
    unsigned ships, left = 0;
    g_autofree uint8_t *bytes = g_malloc(whole_size + size);
    size_t behind = insert ? at : at + size;
    memcpy(bytes, whole, at);
    memcpy(bytes + at, by, size);
    memcpy(bytes + at + size, whole + behind, whole_size - behind);
    for (int i = 1; i <= EDITS; i++) {
        bool hit = insert ? ends[i - 1] < at && at < ends[i]
                          : ends[i - 1] < at + size && at < ends[i];
        left += !hit;
    }
    struct pel_journal_found found =
        load(bytes, at + size + whole_size - behind, &ships);
    bool same = !insert && memcmp(whole + at, by, size) == 0;
    if (found.damaged == same || ships < left || ships > EDITS) {
        fail_msg("block at %zu: %u edits, %u are whole: %s", at, ships, left,
                 found.words);
    }
}

static void blocks_that_are_zero_or_twice(void **state)
{
    (void)state;
    static const uint8_t zeroes[512];
    for (size_t at = 0; at + 512 <= whole_size; at += 128) {
        damage(at, zeroes, 512, false);
        damage(at, zeroes, 512, true);
        damage(at, whole + at, 512, true);
        if (at >= 512) {
            damage(at, whole + at - 512, 512, false);
        }
    }
}

/* A journal of the previous version, without checksums. */
static void an_older_journal(void **state)
{
    (void)state;
    unsigned ships;
    GByteArray *old = g_byte_array_new();
    struct pel_log_reader reader;
    const uint8_t *data;
    size_t size;
    g_byte_array_append(old, (const uint8_t *)PEL_LOG_MAGIC_BEFORE, 8);
    assert_int_equal(pel_log_open(&reader, whole, whole_size, NULL), PEL_OK);
    while (pel_log_skip(&reader, &data, &size)) {
        uint8_t prefix[2] = { (uint8_t)(size | 0x80), (uint8_t)(size >> 7) };
        g_byte_array_append(old, prefix, 2);
        g_byte_array_append(old, data, (guint)size);
    }
    struct pel_journal_found found = load(old->data, old->len, &ships);
    assert_false(found.damaged);
    assert_int_equal(ships, EDITS);
    found = load(old->data, old->len - 3, &ships);
    assert_true(found.damaged);
    assert_int_equal(ships, EDITS - 1);
    g_byte_array_unref(old);
}

static void the_journal_of_another_state_file(void **state)
{
    (void)state;
    struct pel_journal_found found;
    struct pel_fault fault;
    Pelagos__State *mine = copy();
    assert_true(g_file_set_contents(journal, (const char *)whole,
                                    (gssize)whole_size, NULL));
    assert_int_equal(pel_journal_load(path, "two", &mine, &found, &fault),
                     PEL_OK);
    assert_true(found.foreign && found.damaged);
    assert_int_equal(mine->n_entities, base->n_entities);
    assert_non_null(strstr(found.words, "of another state file"));
    assert_int_equal(unlink(found.kept), 0);
    g_free(found.kept);
    pelagos__state__free_unpacked(mine, NULL);
}

static void none_that_is_kept_is_overwritten(void **state)
{
    (void)state;
    char *first = NULL;
    for (int i = 1; i <= PEL_ASIDE_MOST + 1; i++) {
        g_autofree char *text = g_strdup_printf("%d", i);
        unlink(journal);
        put_file(text, strlen(text));
        g_autofree char *kept = pel_aside_keep(journal, ".bad");
        g_autofree char *again = pel_aside_keep(journal, ".bad");
        assert_int_equal(kept != NULL, i <= PEL_ASIDE_MOST);
        assert_string_equal(kept ? kept : "", again ? again : "");
    }
    for (int i = 1; i <= PEL_ASIDE_MOST; i++) {
        g_autofree char *name = i == 1
                                    ? g_strconcat(journal, ".bad", NULL)
                                    : g_strdup_printf("%s.bad.%d", journal, i);
        assert_true(g_file_get_contents(name, &first, NULL, NULL));
        assert_int_equal(atoi(first), i);
        g_free(first);
        unlink(name);
    }
}

/* A file may have so many bytes only: as a disk that is full. */
static void what_does_not_fit_is_refused(void **state)
{
    (void)state;
    struct rlimit before, now;
    unsigned kept = 0;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    now = before;
    now.rlim_cur = 32 << 10;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &now), 0);
    Pelagos__State *s = copy();
    struct pel_journal *j = create("one", &refuses);
    char why[400];
    assert_false(pel_journal_trouble(j, why, sizeof why));
    while (kept < 2000 && add(j, &s, (int)(kept % 40))) {
        kept++;
    }
    assert_in_range(kept, 100, 1000);
    assert_true(pel_journal_trouble(j, why, sizeof why));
    assert_non_null(strstr(why, "refused"));
    assert_false(pel_journal_lacks(j));
    /* It restarts from the state that has them all. */
    assert_true(pel_journal_is_full(j));
    pel_journal_turn(j, s);
    while (pel_worker_wait(worker)) {
    }
    assert_false(pel_journal_trouble(j, why, sizeof why));
    assert_true(add(j, &s, 201));
    assert_true(pel_journal_close(j, false));
    pelagos__state__free_unpacked(s, NULL);
    s = copy();
    struct pel_journal_found found;
    assert_int_equal(pel_journal_load(path, "one", &s, &found, NULL), PEL_OK);
    assert_false(found.damaged);
    assert_int_equal(s->revision, base->revision + kept + 1);
    pelagos__state__free_unpacked(s, NULL);
    /* Or it goes on, and says so. */
    s = copy();
    j = create("one", &goes_on);
    for (kept = 0; kept < 2000 && add(j, &s, (int)(kept % 40)); kept++) {
    }
    assert_true(pel_journal_lacks(j));
    assert_true(pel_journal_trouble(j, why, sizeof why));
    assert_non_null(strstr(why, "not kept"));
    assert_true(pel_journal_close(j, true));
    pelagos__state__free_unpacked(s, NULL);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
}

static void tries_again(void *user)
{
    struct pel_journal **j = user;
    assert_true(pel_journal_is_full(*j));
    *j = NULL;
}

/* However long a trial takes until it fails. */
static void after_each_that_failed_another_is_tried(void **state)
{
    (void)state;
    struct pel_journal *waited_for = NULL;
    const struct pel_journal_cares cares = { false, tries_again, &waited_for };
    struct rlimit before, now;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    now = before;
    now.rlim_cur = 32 << 10;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &now), 0);
    Pelagos__State *s = copy();
    struct pel_journal *j = waited_for = create("one", &cares);
    for (int i = 0; i < 2000 && add(j, &s, i % 40); i++) {
    }
    now.rlim_cur = 1;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &now), 0);
    assert_true(pel_journal_is_full(j));
    pel_journal_turn(j, s);
    g_usleep(50000);
    while (pel_worker_wait(worker)) {
    }
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_false(pel_journal_is_full(j));
    while (waited_for) {
        g_main_context_iteration(NULL, TRUE);
    }
    assert_true(pel_journal_close(j, true));
    pelagos__state__free_unpacked(s, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_whole_is_all_used),
        cmocka_unit_test(a_flipped_bit_costs_one_edit_at_most),
        cmocka_unit_test(each_end_that_is_torn_is_told),
        cmocka_unit_test(blocks_that_are_zero_or_twice),
        cmocka_unit_test(an_older_journal),
        cmocka_unit_test(the_journal_of_another_state_file),
        cmocka_unit_test(none_that_is_kept_is_overwritten),
        cmocka_unit_test(what_does_not_fit_is_refused),
        cmocka_unit_test(after_each_that_failed_another_is_tried),
    };
    return cmocka_run_group_tests(tests, begin, finish);
}
