#include "scene/record.h"

#include <glib.h>
#include <glib/gstdio.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "pelog.h"
#include "scene/scene_testkit.h"
#include "wire.h"

struct fixture {
    char folder[64], path[128];
    struct pel_scene *scene;
    struct pel_record *record;
};

static double again_s = 1000;

static enum pel_err record(struct fixture *f, double segment_mib, unsigned keep)
{
    struct pel_fault fault;
    struct pel_record_options options = {
        f->path, segment_mib, keep, again_s, "test 1", "a device", 20, NULL, 0,
    };
    return pel_record_create(&options, f->scene, &f->record, &fault);
}

static void start_small(struct fixture *f, double segment_mib, unsigned keep)
{
    strcpy(f->folder, "/tmp/pelagos-record-XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    snprintf(f->path, sizeof f->path, "%s/log", f->folder);
    f->scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    assert_int_equal(
        patch(f->scene, "{\"clock\":{\"mode\":\"STEPPED\"}}", NULL), PEL_OK);
    assert_int_equal(record(f, segment_mib, keep), PEL_OK);
}

static void start(struct fixture *f)
{
    start_small(f, 1, 2);
}

static void stop(struct fixture *f)
{
    pel_record_destroy(f->record);
    pel_scene_destroy(f->scene);
    GDir *dir = g_dir_open(f->folder, 0, NULL);
    const char *name;
    while ((name = g_dir_read_name(dir))) {
        g_autofree char *path = g_build_filename(f->folder, name, NULL);
        g_unlink(path);
    }
    g_dir_close(dir);
    assert_int_equal(g_rmdir(f->folder), 0);
}

/* Reads it all: how many entries; the last one's time. */
static size_t count(const char *path, struct pel_log_reader *reader,
                    enum pel_err wanted)
{
    struct pel_fault fault;
    Pelagos__LogEntry *entry;
    g_autofree char *data = NULL;
    gsize size;
    assert_true(g_file_get_contents(path, &data, &size, NULL));
    enum pel_err err = pel_log_open(reader, data, size, &fault);
    while (!err && (err = pel_log_next(reader, &entry, &fault)) == PEL_OK &&
           entry) {
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
    assert_int_equal(err, wanted);
    return reader->entries;
}

static double metric(struct fixture *f, const char *name)
{
    struct pel_metrics *metrics = pel_metrics_create();
    pel_metrics_add(metrics, pel_record_collect, f->record);
    g_autofree char *text = pel_metrics_text(metrics, NULL);
    g_autofree char *line = g_strdup_printf("\n%s ", name);
    const char *found = strstr(text, line);
    assert_non_null(found);
    double value = strtod(found + strlen(line), NULL);
    pel_metrics_remove(metrics, pel_record_collect, f->record);
    pel_metrics_destroy(metrics);
    return value;
}

static void accepted_commands_are_there_at_once(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_log_reader reader;
    start(&f);
    assert_int_equal(pel_scene_step(f.scene, 1.0 / 3, NULL), PEL_OK);
    assert_int_equal(patch(f.scene, "{\"sea\":{\"windSpeed\":12}}", NULL),
                     PEL_OK);
    assert_int_equal(patch(f.scene, "{\"sea\":{\"windSpeed\":99}}", NULL),
                     PEL_ERR_OUT_OF_RANGE);
    assert_int_equal(pel_scene_step_to(f.scene, 7.1, NULL), PEL_OK);
    /* not closed: as a killed process would leave it */
    assert_int_equal(count(f.path, &reader, PEL_OK), 4);
    assert_true(reader.time_s == 7.1); /* bit for bit */
    assert_false(reader.torn);
    stop(&f);
}

/* Plays one log onto the scene, as pelagosctl does. */
static void play(struct pel_scene *scene, const char *path)
{
    struct pel_log_reader reader;
    struct pel_fault fault;
    Pelagos__LogEntry *entry;
    Pelagos__Patch all = PELAGOS__PATCH__INIT;
    char *parts[] = { "own_ship", "clock",  "origin",   "sea",   "water",
                      "sky",      "seabed", "entities", "views", "sources" };
    g_autofree char *data = NULL;
    gsize size;
    all.n_remove = G_N_ELEMENTS(parts);
    all.remove = parts;
    assert_true(g_file_get_contents(path, &data, &size, NULL));
    assert_int_equal(pel_log_open(&reader, data, size, &fault), PEL_OK);
    while (pel_log_next(&reader, &entry, &fault) == PEL_OK && entry) {
        Pelagos__Patch *patch = &all;
        if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD) {
            /* so that own ship's steps begin anew */
            assert_int_equal(entry->head->waves, 20);
            assert_string_equal(entry->head->program, "test 1");
            assert_string_equal(entry->head->device, "a device");
            all.n_remove = 1;
            all.state = NULL;
            assert_int_equal(pel_scene_patch(scene, &all, &fault), PEL_OK);
            all.n_remove = G_N_ELEMENTS(parts);
            all.state = entry->head->state;
            all.state->has_revision = false;
        } else {
            assert_int_equal(pel_scene_step_to(scene, entry->time, &fault),
                             PEL_OK);
            patch = entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH
                        ? entry->patch
                        : NULL;
        }
        if (patch && pel_scene_patch(scene, patch, &fault) != PEL_OK) {
            fail_msg("%s", fault.message);
        }
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
}

static struct pel_scene *another_scene(void)
{
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 20 });
    assert_int_equal(patch(scene, "{\"clock\":{\"mode\":\"STEPPED\"}}", NULL),
                     PEL_OK);
    return scene;
}

/* The state as text, but for its revision, which a replay does not keep. */
static char *text_of(struct pel_scene *scene)
{
    Pelagos__State state = *pel_scene_state(scene);
    state.has_revision = false;
    return pel_json_from_message(&state.base, false);
}

static void replaying_gives_the_same_state(void **state)
{
    (void)state;
    static const char *const edits[] = {
        "{\"entities\":{\"1\":{\"speed\":7.3,\"course\":33,\"turnRate\":1}}}",
        "{\"entities\":{\"1\":{\"heading\":77}}}",
        "{\"clock\":{\"time\":1234.5},\"sky\":{\"sunElevation\":5}}",
        "{\"sky\":{\"sunElevation\":null},\"clock\":{\"rate\":2}}",
        "{\"entities\":{\"1\":{\"roll\":3}}}",
    };
    struct fixture f;
    start(&f);
    for (size_t i = 0; i < G_N_ELEMENTS(edits); i++) {
        assert_int_equal(patch(f.scene, edits[i], NULL), PEL_OK);
        assert_int_equal(pel_scene_step(f.scene, 0.1 + 0.7 * (double)i, NULL),
                         PEL_OK);
    }
    struct pel_scene *scene = another_scene();
    play(scene, f.path);
    char *wanted = text_of(f.scene), *got = text_of(scene);
    assert_string_equal(got, wanted);
    free(got);
    free(wanted);
    pel_scene_destroy(scene);
    stop(&f);
}

static void paced_steps_are_thinned(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_log_reader reader;
    start(&f);
    assert_int_equal(patch(f.scene, "{\"clock\":{\"mode\":\"PACED\"}}", NULL),
                     PEL_OK);
    for (int i = 0; i < 600; i++) { /* ten seconds at 60 Hz */
        assert_int_equal(pel_scene_step(f.scene, 1.0 / 60, NULL), PEL_OK);
    }
    size_t entries = count(f.path, &reader, PEL_OK);
    /* head, patch, and one for a tenth of a second, which is 6 or 7 steps */
    assert_in_range(entries, 85, 102);
    stop(&f);
}

static void cut_and_changed_logs(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_log_reader reader;
    start(&f);
    assert_int_equal(patch(f.scene, "{\"sea\":{\"windSpeed\":12}}", NULL),
                     PEL_OK);
    g_autofree char *data = NULL;
    gsize size;
    assert_true(g_file_get_contents(f.path, &data, &size, NULL));
    for (gsize cut = 1; cut < 5; cut++) {
        g_file_set_contents(f.path, data, (gssize)(size - cut), NULL);
        assert_int_equal(count(f.path, &reader, PEL_OK), 1);
        assert_true(reader.torn);
    }
    g_file_set_contents(f.path, data, 12, NULL);
    count(f.path, &reader, PEL_ERR_MALFORMED);
    data[3] = 'X';
    g_file_set_contents(f.path, data, (gssize)size, NULL);
    count(f.path, &reader, PEL_ERR_MALFORMED);
    data[3] = 'O';
    g_autofree char *more = g_malloc0(size + 8);
    memcpy(more, data, size);
    memset(more + size, 0xff, 8); /* no length */
    g_file_set_contents(f.path, more, (gssize)size + 8, NULL);
    count(f.path, &reader, PEL_ERR_MALFORMED);
    assert_int_equal(reader.entries, 2);
    memcpy(more + size, "\3abc", 4); /* no LogEntry */
    g_file_set_contents(f.path, more, (gssize)size + 4, NULL);
    count(f.path, &reader, PEL_ERR_MALFORMED);
    stop(&f);
}

/* One entry behind a good head. */
static enum pel_err second(Pelagos__LogEntry *entry)
{
    Pelagos__LogEntry first = PELAGOS__LOG_ENTRY__INIT;
    Pelagos__LogHead head = PELAGOS__LOG_HEAD__INIT;
    Pelagos__State whole = PELAGOS__STATE__INIT;
    Pelagos__Clock clock = PELAGOS__CLOCK__INIT;
    struct pel_log_reader reader;
    struct pel_fault fault;
    whole.clock = &clock;
    head.has_version = first.has_time = true;
    head.version = 1;
    head.state = &whole;
    first.time = 5;
    first.command_case = PELAGOS__LOG_ENTRY__COMMAND_HEAD;
    first.head = &head;
    size_t a, b;
    uint8_t *one = pel_wire_pack(&first.base, &a);
    uint8_t *two = pel_wire_pack(&entry->base, &b);
    uint8_t *all = malloc(8 + a + b);
    memcpy(all, PEL_LOG_MAGIC_BEFORE, 8);
    memcpy(all + 8, one, a);
    memcpy(all + 8 + a, two, b);
    Pelagos__LogEntry *read;
    assert_int_equal(pel_log_open(&reader, all, 8 + a + b, &fault), PEL_OK);
    assert_int_equal(pel_log_next(&reader, &read, &fault), PEL_OK);
    pelagos__log_entry__free_unpacked(read, NULL);
    enum pel_err err = pel_log_next(&reader, &read, &fault);
    if (read) {
        pelagos__log_entry__free_unpacked(read, NULL);
    }
    free(one);
    free(two);
    free(all);
    return err;
}

static void entries_that_cannot_be(void **state)
{
    (void)state;
    Pelagos__ClockStep step = PELAGOS__CLOCK_STEP__INIT;
    Pelagos__LogHead head = PELAGOS__LOG_HEAD__INIT;
    Pelagos__LogEntry entry = PELAGOS__LOG_ENTRY__INIT;
    entry.has_time = true;
    entry.time = 6;
    assert_int_equal(second(&entry), PEL_ERR_MALFORMED); /* no command */
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_STEP;
    entry.step = &step;
    step.has_until = true;
    step.until = 6;
    assert_int_equal(second(&entry), PEL_OK);
    const double bad[] = { 4.999, -1, 1.1e9, NAN, INFINITY };
    for (size_t i = 0; i < G_N_ELEMENTS(bad); i++) {
        entry.time = step.until = bad[i];
        assert_int_equal(second(&entry), PEL_ERR_MALFORMED);
    }
    entry.time = 6;
    step.until = 6.1;
    assert_int_equal(second(&entry), PEL_ERR_MALFORMED);
    step.until = 6;
    entry.has_time = false;
    assert_int_equal(second(&entry), PEL_ERR_MALFORMED);
    entry.has_time = true;
    entry.command_case = PELAGOS__LOG_ENTRY__COMMAND_HEAD;
    entry.head = &head;
    assert_int_equal(second(&entry), PEL_ERR_MALFORMED); /* a second head */
}

/* Numbers of PATH.NNNNNN that are there, as text. */
static char *closed_segments(const struct fixture *f)
{
    GString *text = g_string_new("");
    for (int i = 0; i < 200; i++) {
        g_autofree char *name = g_strdup_printf("%s.%06d", f->path, i);
        if (g_file_test(name, G_FILE_TEST_EXISTS)) {
            g_string_append_printf(text, "%s%d", text->len ? " " : "", i);
        }
    }
    return g_string_free(text, FALSE);
}

static void an_earlier_log_is_kept(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_log_reader reader;
    start_small(&f, 1, 3);
    for (int i = 0; i < 4; i++) {
        pel_record_destroy(f.record);
        assert_int_equal(record(&f, 1, 3), PEL_OK);
    }
    /* what is not ours stays, and does not count */
    g_autofree char *other = g_strconcat(f.path, ".bak", NULL);
    g_autofree char *short_one = g_strconcat(f.path, ".77", NULL);
    g_file_set_contents(other, "x", 1, NULL);
    g_file_set_contents(short_one, "x", 1, NULL);
    pel_record_destroy(f.record);
    assert_int_equal(record(&f, 1, 3), PEL_OK);
    g_autofree char *numbers = closed_segments(&f);
    assert_string_equal(numbers, "1 2 3 4 5"); /* of seconds each */
    g_autofree char *kept = g_strconcat(f.path, ".000005", NULL);
    assert_int_equal(count(kept, &reader, PEL_OK), 2); /* head and end */
    assert_int_equal(count(f.path, &reader, PEL_OK), 1);
    assert_true(g_file_test(other, G_FILE_TEST_EXISTS));
    assert_true(g_file_test(short_one, G_FILE_TEST_EXISTS));
    stop(&f);
}

/* Starts of a daemon that crashes make no long segment go; long ones do, and
 * age. */
static void short_segments_make_none_go(void **state)
{
    (void)state;
    struct fixture f;
    static const char *const wanted[] = { "2 3", "3 4" };
    start_small(&f, 0.0625, 3);
    pel_record_destroy(f.record);
    for (unsigned i = 1; i <= 2; i++) {
        g_autofree char *name = g_strdup_printf("%s.%06u", f.path, i);
        g_autofree char *full = g_malloc0(70000);
        assert_true(g_file_set_contents(name, full, 70000, NULL));
    }
    for (int i = 0; i < 40; i++) {
        assert_int_equal(record(&f, 0.0625, 3), PEL_OK);
        pel_record_destroy(f.record);
    }
    g_autofree char *all = closed_segments(&f);
    assert_int_equal(strncmp(all, "1 2 3 4 5 ", 10), 0);
    for (int i = 0; i < 50; i++) {
        g_autofree char *name = g_strdup_printf("%s.%06d", f.path, i);
        g_unlink(name);
    }
    g_unlink(f.path);
    for (unsigned i = 0; i < 2; i++) {
        for (unsigned n = 1; n <= 3 + i; n++) {
            g_autofree char *name = g_strdup_printf("%s.%06u", f.path, n);
            g_autofree char *full = g_malloc0(70000);
            assert_true(g_file_set_contents(name, full, 70000, NULL));
        }
        assert_int_equal(record(&f, 0.0625, 3), PEL_OK);
        pel_record_destroy(f.record);
        g_unlink(f.path);
        g_autofree char *left = closed_segments(&f);
        assert_string_equal(left, wanted[i]);
    }
    f.record = NULL;
    stop(&f);
}

/* A directory, somebody's file, a log that is being written: each stays. */
static void what_is_no_log_stays(void **state)
{
    (void)state;
    struct fixture f, other;
    start(&f);
    other = f;
    assert_int_equal(record(&other, 1, 2), PEL_ERR_CONFLICT);
    snprintf(other.path, sizeof other.path, "%s/notes", f.folder);
    assert_true(g_file_set_contents(other.path, "notes", -1, NULL));
    assert_int_equal(record(&other, 1, 2), PEL_ERR_INVALID);
    g_autofree char *text = NULL;
    assert_true(g_file_get_contents(other.path, &text, NULL, NULL));
    assert_string_equal(text, "notes");
    assert_int_equal(g_unlink(other.path), 0);
    assert_int_equal(g_mkdir(other.path, 0700), 0);
    assert_int_equal(record(&other, 1, 2), PEL_ERR_INVALID);
    assert_int_equal(g_rmdir(other.path), 0);
    stop(&f);
}

/* Each edit says its number, so that what is missing would be seen: the
 * heading is a hundredth of it. Own ship is left alone. */
static void edit_number(struct fixture *f, int i)
{
    char text[160];
    snprintf(text, sizeof text,
             "{\"entities\":{\"2\":{\"heading\":%.2f,\"speed\":%.2f}}}",
             0.01 * (i % 36000), 0.001 * i);
    assert_int_equal(patch(f->scene, text, NULL), PEL_OK);
    assert_int_equal(pel_scene_step(f->scene, 0.0137, NULL), PEL_OK);
}

/* The entries of a segment follow the last one's without a gap: revisions of
 * patches are those of its head and up. Returns the last revision. */
static uint64_t follow(const char *path, uint32_t segment, uint64_t revision)
{
    struct pel_log_reader reader;
    struct pel_fault fault;
    Pelagos__LogEntry *entry;
    g_autofree char *data = NULL;
    gsize size;
    assert_true(g_file_get_contents(path, &data, &size, NULL));
    assert_int_equal(pel_log_open(&reader, data, size, &fault), PEL_OK);
    while (pel_log_next(&reader, &entry, &fault) == PEL_OK && entry) {
        if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_HEAD) {
            assert_int_equal(entry->head->segment, segment);
        } else if (entry->command_case == PELAGOS__LOG_ENTRY__COMMAND_PATCH) {
            revision++;
        }
        assert_int_equal(entry->revision, revision);
        pelagos__log_entry__free_unpacked(entry, NULL);
    }
    return revision;
}

static void nothing_is_lost_at_a_turn(void **state)
{
    (void)state;
    struct fixture f;
    start_small(&f, 0.02, 100);
    /* own ship too: its steps begin anew where a segment does */
    assert_int_equal(patch(f.scene,
                           "{\"ownShip\":{\"on\":true,\"rudder\":5,"
                           "\"throttle\":0.5}}",
                           NULL),
                     PEL_OK);
    for (int i = 0; i < 1500; i++) {
        edit_number(&f, i);
    }
    double begun = metric(&f, "pelagos_record_segments_total");
    assert_in_range((int)begun, 4, 30);
    assert_true(metric(&f, "pelagos_record_lost_total") == 0);
    uint64_t revision = 1; /* of the first head: see start_small() */
    struct pel_scene *run = another_scene();
    char *wanted = text_of(f.scene);
    for (int i = 1; i <= (int)begun; i++) {
        g_autofree char *name = i < (int)begun
                                    ? g_strdup_printf("%s.%06d", f.path, i)
                                    : g_strdup(f.path);
        gsize size;
        g_autofree char *data = NULL;
        assert_true(g_file_get_contents(name, &data, &size, NULL));
        /* up to one entry more */
        assert_in_range(size, 200, 0.02 * 1048576 + 200);
        revision = follow(name, (uint32_t)i, revision);
        play(run, name);
        if (i == (int)begun) {
            struct pel_scene *alone = another_scene();
            play(alone, name);
            char *got = text_of(alone);
            assert_string_equal(got, wanted);
            free(got);
            pel_scene_destroy(alone);
        }
    }
    assert_int_equal(revision, pel_scene_state(f.scene)->revision);
    char *got = text_of(run);
    assert_string_equal(got, wanted);
    free(got);
    free(wanted);
    pel_scene_destroy(run);
    stop(&f);
}

static void a_bounded_number_is_kept(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_log_reader reader;
    start_small(&f, 0.01, 3);
    for (int i = 0; i < 2000; i++) {
        edit_number(&f, i);
    }
    int begun = (int)metric(&f, "pelagos_record_segments_total");
    assert_in_range(begun, 10, 100);
    g_autofree char *numbers = closed_segments(&f);
    g_autofree char *wanted = g_strdup_printf("%d %d", begun - 2, begun - 1);
    assert_string_equal(numbers, wanted);
    assert_true(metric(&f, "pelagos_record_removed_total") == begun - 3);
    count(f.path, &reader, PEL_OK);
    assert_false(reader.torn);
    stop(&f);
}

/* A segment cannot be begun for a while: this one goes on to twice its size,
 * and nothing is written behind that, until it can: in the segment after the
 * next number.
 */
static void without_a_new_segment(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_log_reader reader;
    again_s = 0.05;
    start_small(&f, 0.01, 3);
    again_s = 1000;
    g_autofree char *block = g_strconcat(f.path, ".new", NULL);
    g_autofree char *inside = g_build_filename(block, "inside", NULL);
    g_mkdir(block, 0777);
    g_file_set_contents(inside, "x", 1, NULL);
    for (int i = 0; i < 2000; i++) {
        edit_number(&f, i);
    }
    count(f.path, &reader, PEL_OK);
    assert_true(reader.entries > 100);
    g_autofree char *numbers = closed_segments(&f);
    assert_string_equal(numbers, "");
    assert_true(metric(&f, "pelagos_record_segments_total") == 1);
    assert_true(metric(&f, "pelagos_record_active") == 0);
    assert_in_range((int)metric(&f, "pelagos_record_bytes"), 2 * 0.01 * 1048576,
                    2 * 0.01 * 1048576 + 200);
    double lost = metric(&f, "pelagos_record_lost_total");
    assert_true(lost > 0);
    g_unlink(inside);
    g_rmdir(block);
    g_usleep(60000); /* again_s has gone by */
    edit_number(&f, 1);
    assert_true(metric(&f, "pelagos_record_active") == 1);
    assert_true(metric(&f, "pelagos_record_lost_total") == lost + 1);
    uint64_t revision = pel_scene_state(f.scene)->revision;
    assert_int_equal(follow(f.path, 3, revision), revision);
    stop(&f);
}

/* A full disk, as far as one process can have it: the file may not grow. */
static void a_failed_write_leaves_a_whole_log(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_log_reader reader;
    struct rlimit before, small;
    signal(SIGXFSZ, SIG_IGN);
    start(&f);
    double began_s = pel_scene_time(f.scene);
    getrlimit(RLIMIT_FSIZE, &before);
    small = before;
    small.rlim_cur = 2000;
    setrlimit(RLIMIT_FSIZE, &small);
    for (int i = 0; i < 500; i++) {
        assert_int_equal(pel_scene_step(f.scene, 0.01, NULL), PEL_OK);
    }
    setrlimit(RLIMIT_FSIZE, &before);
    count(f.path, &reader, PEL_OK);
    assert_false(reader.torn);
    assert_true(metric(&f, "pelagos_record_active") == 0);
    /* the scene went on; 500 roundings of 1e-15 */
    assert_near(pel_scene_time(f.scene), began_s + 5, 1e-12);
    stop(&f);
}

static void steps_to_a_moment(void **state)
{
    (void)state;
    struct fixture f;
    struct pel_fault fault;
    start(&f);
    assert_int_equal(pel_scene_step_to(f.scene, 0.1 + 0.2, &fault), PEL_OK);
    assert_true(pel_scene_time(f.scene) == 0.1 + 0.2);
    const double bad[] = { 0.3, -1, NAN, INFINITY, 1e9 + 1 };
    for (size_t i = 0; i < G_N_ELEMENTS(bad); i++) {
        assert_int_equal(pel_scene_step_to(f.scene, bad[i], &fault),
                         PEL_ERR_OUT_OF_RANGE);
        assert_string_equal(fault.path, "step.until");
    }
    assert_int_equal(patch(f.scene, "{\"clock\":{\"mode\":\"FREE\"}}", NULL),
                     PEL_OK);
    assert_int_equal(pel_scene_step_to(f.scene, 1e6, &fault), PEL_ERR_CONFLICT);
    stop(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accepted_commands_are_there_at_once),
        cmocka_unit_test(replaying_gives_the_same_state),
        cmocka_unit_test(paced_steps_are_thinned),
        cmocka_unit_test(cut_and_changed_logs),
        cmocka_unit_test(entries_that_cannot_be),
        cmocka_unit_test(an_earlier_log_is_kept),
        cmocka_unit_test(short_segments_make_none_go),
        cmocka_unit_test(what_is_no_log_stays),
        cmocka_unit_test(nothing_is_lost_at_a_turn),
        cmocka_unit_test(a_bounded_number_is_kept),
        cmocka_unit_test(without_a_new_segment),
        cmocka_unit_test(a_failed_write_leaves_a_whole_log),
        cmocka_unit_test(steps_to_a_moment),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
