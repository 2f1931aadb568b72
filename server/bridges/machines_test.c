/* Random walks through the small machines of docs/machines.md, by the code that
 * runs: after each step their invariants are looked at. PELAGOS_STEPS (20000)
 * and PELAGOS_SEED (1) make them longer and others. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/clock.h"
#include "bridges/cigi_testkit.h"

static unsigned long steps(void)
{
    const char *text = getenv("PELAGOS_STEPS");
    return text ? strtoul(text, NULL, 10) : 20000;
}

static void seed(void)
{
    const char *text = getenv("PELAGOS_SEED");
    srand(text ? (unsigned)strtoul(text, NULL, 10) : 1);
}

static unsigned below(unsigned n)
{
    return (unsigned)rand() % n;
}

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
    seed();
    scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    unsigned long taken = 0, refused = 0;
    const struct pel_snapshot *kept = NULL;
    uint64_t kept_revision = 0;
    for (unsigned long i = 0; i < steps(); i++) {
        char text[256];
        bool good = false;
        struct pel_fault fault;
        size_t size, after_size;
        uint64_t revision = pel_scene_state(scene)->revision;
        random_patch(text, sizeof text, &good);
        uint8_t *before = bytes_of(&size);
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
        free(after);
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
    pel_snapshot_unref(kept);
    print_message("%lu patches taken, %lu refused\n", taken, refused);
    assert_true(taken > steps() / 10 && refused > steps() / 10);
    pel_scene_destroy(scene);
}

/* --- the clock's leader, the host's handshake ----------------------------- */

struct host {
    bool led;
    uint32_t newest;
    uint64_t duplicate, late, lost, malformed;
    int64_t fed_ns; /* before the last datagram that was taken */
    int loading;    /* the database as Start of Frame has it */
};

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
    bool anew = !h->led || jump <= -1000;
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

static void host_and_clock(void **state)
{
    (void)state;
    seed();
    struct host h = { .newest = 100000 };
    unsigned long applied = 0, led_away = 0;
    double time_s = pel_scene_time(scene);
    enum pel_clock_mode wanted = PEL_CLOCK_FREE;
    for (unsigned long i = 0; i < steps(); i++) {
        const struct pel_cigi_counters *c = pel_cigi_counters(cigi);
        uint64_t revision = pel_scene_state(scene)->revision;
        if (below(30) == 0) { /* an operator takes the clock */
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
            wanted = means[which];
            led_away += wanted != PEL_CLOCK_HOST;
        } else {
            bool was_led = h.led;
            uint32_t was = h.newest;
            int64_t since_ns = h.fed_ns, now_ns = pel_now_ns();
            bool must_apply = random_datagram(&h);
            bool begins = !was_led || (int32_t)(h.newest - was) <= -1000;
            if (was_led && now_ns - since_ns > 400000000) {
                /* Half a second of silence makes an old frame a new host:
                 * this machine was busy. */
                h.newest = was;
                begin_at(++h.newest);
                place_ship(1, 51, 1);
                must_apply = true;
                begins = false;
                h.lost = c->lost;
                h.late = c->late;
                h.duplicate = c->duplicate;
                h.malformed = malformed_of(c);
            }
            frame = h.newest;
            pel_cigi_feed(cigi, bytes, used);
            if (must_apply) {
                h.fed_ns = pel_now_ns();
                applied++;
                wanted = begins ? PEL_CLOCK_HOST : wanted;
            } else { /* what is late, double or nonsense changes nothing */
                assert_int_equal(pel_scene_state(scene)->revision, revision);
            }
        }
        assert_int_equal(c->duplicate, h.duplicate);
        assert_int_equal(c->late, h.late);
        assert_int_equal(c->lost, h.lost);
        assert_int_equal(malformed_of(c), h.malformed);
        /* Time never goes back, whoever leads. */
        assert_true(pel_scene_time(scene) >= time_s);
        time_s = pel_scene_time(scene);
        const struct pel_snapshot *s = pel_scene_snapshot(scene);
        if (h.led) {
            assert_int_equal(s->mode, wanted);
        }
        pel_snapshot_unref(s);
        if (h.led && below(4) == 0) {
            take_frame(); /* it knows the newest frame, and counts its own */
        }
        /* A loaded database was being loaded. */
        struct pel_cigi_status status;
        pel_cigi_status(cigi, &status);
        assert_true(status.database == 0 || status.database == 5 ||
                    status.database == -5 || status.database == -128);
        assert_true(status.database != 5 || h.loading == -5 || h.loading == 5);
        h.loading = status.database;
    }
    print_message("%lu host frames applied, the clock taken away %lu times\n",
                  applied, led_away);
    assert_true(applied > steps() / 4);
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
