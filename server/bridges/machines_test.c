/* Random walks through the small machines of docs/machines.md, by the code that
 * runs: after each step their invariants are looked at. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/walk_testkit.h"
#include "bridges/cigi_testkit.h"

/* --- edit, test, commit --------------------------------------------------- */

/* All of the state but the time, which runs; free(). */
static uint8_t *bytes_of(size_t *size)
{
    Pelagos__State state = *pel_scene_state(scene);
    Pelagos__Clock clock = *state.clock;
    clock.has_time = false;
    state.clock = &clock;
    *size = pelagos__state__get_packed_size(&state);
    uint8_t *out = malloc(*size + 1);
    pelagos__state__pack(&state, out);
    return out;
}

/* A patch that may or may not hold; `good`: the scene must take it. */
static void random_patch(char *out, size_t size, bool *good)
{
    const Pelagos__State *s = pel_scene_state(scene);
    unsigned id = 1 + below(6), name = below(400);
    bool there = id == 1, viewed = false, is_view = false;
    for (size_t i = 0; i < s->n_entities; i++) {
        there = there || s->entities[i]->id == id;
    }
    char view_name[16];
    snprintf(view_name, sizeof view_name, "v%u", name);
    for (size_t i = 0; i < s->n_views; i++) {
        viewed =
            viewed || (s->views[i]->has_entity && s->views[i]->entity == id);
        is_view = is_view || strcmp(s->views[i]->name, view_name) == 0;
    }
    double speed = below(260) - 30.0; /* 0 .. 200 */
    switch (below(6)) {
    case 0:
        *good = speed >= 0 && speed <= 200;
        snprintf(out, size, "{\"entities\":{\"%u\":{\"speed\":%g}}}", id,
                 speed);
        break;
    case 1:
        *good = there && !viewed && id != 1;
        snprintf(out, size, "{\"entities\":{\"%u\":null}}", id == 1 ? 99 : id);
        break;
    case 2:
        *good = there && (is_view || s->n_views < PEL_MAX_VIEWS);
        snprintf(out, size, "{\"views\":{\"v%u\":{\"entity\":%u}}}", name, id);
        break;
    case 3:
        *good = is_view;
        snprintf(out, size, "{\"views\":{\"v%u\":null}}", name);
        break;
    case 4: /* half of it would do */
        *good = speed >= 0 && speed <= 200;
        snprintf(out, size,
                 "{\"sky\":{\"visibility\":%u},\"entities\":{\"%u\":{"
                 "\"heading\":%u,\"speed\":%g}}}",
                 1000 + below(9000), id, below(360), speed);
        break;
    default:
        *good = false;
        snprintf(out, size,
                 "{\"sky\":{\"visibility\":%u},\"views\":{\"v%u\":{"
                 "\"entity\":%u}}}",
                 1000 + below(9000), name, 1000 + below(9));
        break;
    }
}

static void edit_test_commit(void **state)
{
    (void)state;
    walk_seed();
    unsigned long steps = walk_steps(20000);
    scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    unsigned long taken = 0, refused = 0;
    const struct pel_snapshot *kept = NULL;
    uint64_t kept_revision = 0;
    size_t size;
    uint8_t *before = bytes_of(&size);
    for (unsigned long i = 0; i < steps; i++) {
        char text[256];
        bool good = false;
        struct pel_fault fault;
        size_t after_size;
        uint64_t revision = pel_scene_state(scene)->revision;
        random_patch(text, sizeof text, &good);
        enum pel_err err = patch(scene, text, &fault);
        uint8_t *after = bytes_of(&after_size);
        const Pelagos__State *s = pel_scene_state(scene);
        if (good != (err == PEL_OK)) {
            fail_msg("%s: %s", text, err ? fault.message : "was taken");
        }
        if (err) { /* nothing of it is applied */
            assert_int_equal(s->revision, revision);
            assert_int_equal(size, after_size);
            assert_memory_equal(before, after, size);
            assert_true(*fault.message != '\0');
            refused++;
        } else {
            assert_int_equal(s->revision, revision + 1);
            taken++;
        }
        free(before);
        before = after;
        size = after_size;
        assert_true(s->n_views <= PEL_MAX_VIEWS);
        for (size_t k = 0; k < s->n_views; k++) {
            assert_true(!s->views[k]->has_entity ||
                        entity_of(scene, s->views[k]->entity));
        }
        /* A snapshot stays what it was. */
        if (!kept || below(50) == 0) {
            pel_snapshot_unref(kept);
            kept = pel_scene_snapshot(scene);
            kept_revision = kept->revision;
            assert_int_equal(kept_revision, s->revision);
        }
        assert_int_equal(kept->revision, kept_revision);
    }
    free(before);
    pel_snapshot_unref(kept);
    print_message("%lu patches taken, %lu refused\n", taken, refused);
    assert_true(taken > steps / 10 && refused > steps / 10);
    pel_scene_destroy(scene);
}

/* --- the clock's leader, the host's handshake ----------------------------- */

struct host {
    bool led;
    uint32_t newest;
    bool begins; /* a session, by the datagram at hand */
    uint64_t duplicate, late, lost, malformed;
    int64_t fed_ns;             /* when the last datagram was taken */
    int64_t told_ns;            /* its first Start of Frame since; 0: none */
    int loading;                /* the database as Start of Frame has it */
    enum pel_clock_mode before; /* whose the clock was */
    unsigned long applied, silences, led_away;
};

static const double silence_s = 2, restart_s = 0.5;

static double unheard_s(const struct host *h)
{
    return (double)(walk.now_ns - h->fed_ns) * 1e-9;
}

/* Who has heard nothing has nothing to answer. */
static bool is_silent(const struct host *h)
{
    return h->told_ns != 0 &&
           (double)(walk.now_ns - h->told_ns) * 1e-9 > silence_s;
}

static uint64_t malformed_of(const struct pel_cigi_counters *c)
{
    uint64_t all = 0;
    for (int i = 0; i < PEL_CIGI_ERROR_COUNT; i++) {
        all += c->malformed[i];
    }
    return all;
}

/* What the host may send: the next frame, an old one, one far back, nonsense.
 * True: it must be applied. */
static bool random_datagram(struct host *h)
{
    static const int jumps[] = { 1, 1,  1,  1,    2,     5,    0,
                                 0, -1, -7, -999, -1000, -5000 };
    int jump = jumps[below(sizeof jumps / sizeof *jumps)];
    begin_at(h->newest + (uint32_t)jump);
    place_ship(1, 50 + below(100) * 0.01, below(360));
    if (below(12) == 0) { /* cut off */
        used = below((unsigned)used);
        used -= used == 24; /* IG Control by itself is sound */
        h->malformed++;
        return false;
    }
    bool anew =
        !h->led || jump <= -1000 || (jump <= 0 && unheard_s(h) > restart_s);
    h->begins = anew;
    if (!anew) {
        h->duplicate += jump == 0;
        h->late += jump < 0;
        h->lost += jump > 1 ? (uint64_t)jump - 1 : 0;
    }
    if (anew || jump > 0) {
        h->newest += (uint32_t)jump;
        h->led = true;
        return true;
    }
    return false;
}

static enum pel_clock_mode mode_now(void)
{
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    enum pel_clock_mode mode = s->mode;
    pel_snapshot_unref(s);
    return mode;
}

/* An operator takes the clock. */
static enum pel_clock_mode take_clock(void)
{
    static const char *const modes[] = {
        "{\"clock\":{\"mode\":\"FREE\"}}",
        "{\"clock\":{\"mode\":\"STEPPED\"}}",
        "{\"clock\":{\"mode\":\"HOST\"}}",
    };
    static const enum pel_clock_mode means[] = { PEL_CLOCK_FREE,
                                                 PEL_CLOCK_STEPPED,
                                                 PEL_CLOCK_HOST };
    unsigned which = below(3);
    must(scene, modes[which]);
    return means[which];
}

/* The host sends; the mode that the clock must have now. */
static enum pel_clock_mode send_one(struct host *h, enum pel_clock_mode mode)
{
    uint64_t revision = pel_scene_state(scene)->revision;
    bool must_apply = random_datagram(h);
    frame = h->newest;
    pel_cigi_feed(cigi, bytes, used);
    if (!must_apply) { /* late, double or nonsense: changes nothing */
        assert_int_equal(pel_scene_state(scene)->revision, revision);
        return mode;
    }
    h->fed_ns = walk.now_ns;
    h->told_ns = 0;
    h->applied++;
    if (h->begins) {
        h->before = mode == PEL_CLOCK_HOST ? h->before : mode;
        return PEL_CLOCK_HOST;
    }
    return mode;
}

/* Time passes; a frame later who was silent is gone, and the clock is given
 * back. Who was told nothing meanwhile stays. */
static enum pel_clock_mode wait(struct host *h, enum pel_clock_mode mode)
{
    walk_wait(below(20) ? 0.001 * below(20) : below(10) ? 0.7 : 3);
    if (h->led && unheard_s(h) > silence_s) {
        const uint8_t *start;
        pel_cigi_frame(cigi, &start);
        last_ig++;
        if (!is_silent(h)) {
            h->told_ns = h->told_ns ? h->told_ns : walk.now_ns;
            return mode;
        }
        h->led = false;
        h->silences++;
        return mode == PEL_CLOCK_HOST ? h->before : mode;
    }
    return mode;
}

static void look_at_host(struct host *h)
{
    const struct pel_cigi_counters *c = pel_cigi_counters(cigi);
    struct pel_cigi_status status;
    assert_int_equal(c->duplicate, h->duplicate);
    assert_int_equal(c->late, h->late);
    assert_int_equal(c->lost, h->lost);
    assert_int_equal(malformed_of(c), h->malformed);
    pel_cigi_status(cigi, &status);
    assert_int_equal(status.connected, h->led && !is_silent(h));
    /* A loaded database was being loaded. */
    assert_true(status.database == 0 || status.database == 5 ||
                status.database == -5 || status.database == -128);
    assert_true(status.database != 5 || h->loading == -5 || h->loading == 5);
    h->loading = status.database;
}

static void host_and_clock(void **state)
{
    (void)state;
    walk_seed();
    walk_stop_clock();
    unsigned long steps = walk_steps(20000);
    struct host h = { .newest = 100000 };
    double time_s = pel_scene_time(scene);
    enum pel_clock_mode mode = mode_now();
    h.before = mode;
    for (unsigned long i = 0; i < steps; i++) {
        if (below(30) == 0) {
            mode = take_clock();
            h.led_away += mode != PEL_CLOCK_HOST;
        } else {
            mode = wait(&h, mode);
            mode = send_one(&h, mode);
        }
        look_at_host(&h);
        assert_int_equal(mode_now(), mode);
        /* Time never goes back, whoever leads. */
        assert_true(pel_scene_time(scene) >= time_s);
        time_s = pel_scene_time(scene);
        if (h.led && below(4) > 0) {
            take_frame(); /* it knows the newest frame, and counts its own */
            h.told_ns = h.told_ns ? h.told_ns : walk.now_ns;
        }
    }
    print_message("%lu host frames applied, %lu silences, the clock taken away "
                  "%lu times\n",
                  h.applied, h.silences, h.led_away);
    assert_true(h.applied > steps / 4 && h.silences > steps / 1000);
    walk_start_clock();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edit_test_commit),
        cmocka_unit_test_setup_teardown(host_and_clock, open_bridge,
                                        close_bridge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
