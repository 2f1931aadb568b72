#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/walk_testkit.h"
#include "cluster/places.h"

/* --- by hand -------------------------------------------------------------- */

#define THERE true, true
#define GONE false, false

static void settle(struct pel_place *places, size_t count,
                   const struct pel_place_node *nodes, size_t node_count,
                   size_t changed)
{
    assert_int_equal(pel_places_settle(places, count, nodes, node_count),
                     changed);
    /* Settled is settled. */
    assert_int_equal(pel_places_settle(places, count, nodes, node_count), 0);
}

static void a_spare_takes_all_of_a_node(void **state)
{
    (void)state;
    struct pel_place p[] = { { "left", "a", NULL },
                             { "centre", "b", NULL },
                             { "right", "a", NULL } };
    struct pel_place_node n[] = { { "a", THERE, false },
                                  { "b", THERE, false },
                                  { "s", THERE, true } };
    settle(p, 3, n, 3, 3);
    assert_string_equal(p[0].now, "a");
    assert_string_equal(p[1].now, "b");
    assert_string_equal(p[2].now, "a");
    n[0].there = n[0].steady = false;
    settle(p, 3, n, 3, 2);
    assert_string_equal(p[0].now, "s");
    assert_string_equal(p[1].now, "b");
    assert_string_equal(p[2].now, "s");
    /* It comes back: only when it is steady. */
    n[0].there = true;
    settle(p, 3, n, 3, 0);
    n[0].steady = true;
    settle(p, 3, n, 3, 2);
    assert_string_equal(p[0].now, "a");
    assert_string_equal(p[2].now, "a");
}

static void two_are_gone_and_there_is_one_spare(void **state)
{
    (void)state;
    struct pel_place p[] = { { "1", "a", "a" },
                             { "2", "a", "a" },
                             { "3", "b", "b" },
                             { "4", "c", "c" } };
    struct pel_place_node n[] = { { "a", THERE, false },
                                  { "b", GONE, false },
                                  { "c", THERE, false },
                                  { "s", THERE, true } };
    settle(p, 4, n, 4, 1);
    assert_string_equal(p[2].now, "s");
    n[0].there = n[0].steady = false;
    settle(p, 4, n, 4, 2);
    /* The spare has one already, as has c: one each, by name. */
    assert_string_equal(p[0].now, "c");
    assert_string_equal(p[1].now, "s");
    assert_string_equal(p[2].now, "s");
    assert_string_equal(p[3].now, "c");
    /* At once, the spare is the first's by name. */
    struct pel_place q[] = { { "3", "b", "b" }, { "1", "a", "a" } };
    settle(q, 2, n, 4, 2);
    assert_string_equal(q[1].now, "s");
    assert_string_equal(q[0].now, "c");
}

static void without_a_spare_the_least_loaded_takes(void **state)
{
    (void)state;
    struct pel_place p[] = { { "1", "a", "a" },
                             { "2", "a", "a" },
                             { "3", "b", "b" },
                             { "4", "d", NULL } };
    struct pel_place_node n[] = { { "c", THERE, false },
                                  { "b", THERE, false },
                                  { "a", GONE, false } };
    settle(p, 4, n, 3, 3);
    assert_string_equal(p[0].now, "c");
    assert_string_equal(p[1].now, "b");
    assert_string_equal(p[2].now, "b");
    /* Of a node that never was. */
    assert_string_equal(p[3].now, "c");
}

static void where_nobody_is_nothing_changes(void **state)
{
    (void)state;
    struct pel_place p[] = { { "1", "a", "s" }, { "2", "b", NULL } };
    struct pel_place_node n[] = { { "a", GONE, false }, { "s", GONE, true } };
    settle(p, 2, n, 2, 0);
    assert_string_equal(p[0].now, "s");
    assert_null(p[1].now);
    settle(p, 2, NULL, 0, 0);
    /* The node where it is placed comes first: nobody else is there. */
    n[0].there = true;
    settle(p, 2, n, 2, 2);
    assert_string_equal(p[0].now, "a");
    assert_string_equal(p[1].now, "a");
}

/* --- at random ------------------------------------------------------------ */

#define NODES 7
#define VIEWS 12

static const char *const names[NODES] = { "a", "b", "c", "d", "e", "s", "t" };
static const char *const views[VIEWS] = {
    "v0", "v1", "v2", "v3", "v4", "v5", "v6", "v7", "v8", "v9", "v10", "v11"
};

static struct pel_place_node nodes[NODES];
static struct pel_place places[VIEWS];
static size_t count;

static const struct pel_place_node *node_of(const char *name)
{
    for (size_t i = 0; name && i < NODES; i++) {
        if (strcmp(nodes[i].name, name) == 0) {
            return &nodes[i];
        }
    }
    return NULL;
}

static bool is_there(const char *name)
{
    const struct pel_place_node *node = node_of(name);
    return node && node->there;
}

static void one_step(void)
{
    unsigned node = below(NODES), view = below(VIEWS), at = VIEWS;
    for (unsigned i = 0; i < count; i++) {
        at = strcmp(places[i].view, views[view]) == 0 ? i : at;
    }
    switch (below(6)) {
    case 0:
        nodes[node].there = nodes[node].steady = false;
        break;
    case 1:
        nodes[node].there = true;
        break;
    case 2:
        nodes[node].steady = nodes[node].there;
        break;
    case 3:
        nodes[node].spare = !nodes[node].spare;
        break;
    case 4: /* one is placed, or placed elsewhere */
        at = at == VIEWS ? (unsigned)count++ : at;
        places[at] =
            (struct pel_place){ views[view],
                                below(9) == 0 ? "nobody" : names[node], NULL };
        break;
    default:
        if (at < VIEWS) {
            places[at] = places[--count];
        }
        break;
    }
}

/* What is said of a settlement, by itself: `before` is what there was. */
static void judge(const struct pel_place *before)
{
    bool anybody = false, idle_spare = false;
    size_t loads[NODES] = { 0 }, least = VIEWS;
    for (size_t i = 0; i < NODES; i++) {
        for (size_t k = 0; k < count; k++) {
            loads[i] +=
                places[k].now && strcmp(places[k].now, nodes[i].name) == 0;
        }
        anybody = anybody || nodes[i].there;
        if (nodes[i].there) {
            least = loads[i] < least ? loads[i] : least;
            idle_spare = idle_spare || (nodes[i].spare && loads[i] == 0);
        }
    }
    for (size_t i = 0; i < count; i++) {
        const struct pel_place *p = &places[i];
        const struct pel_place_node *home = node_of(p->node);
        const struct pel_place_node *now = node_of(p->now);
        const char *was = before[i].now;
        bool at_home = p->now && strcmp(p->now, p->node) == 0;
        if (!anybody) {
            assert_ptr_equal(p->now, was);
            continue;
        }
        assert_true(now && now->there);
        if (home && home->there && (home->steady || !is_there(was))) {
            assert_true(at_home);
        } else if (is_there(was)) {
            assert_string_equal(p->now, was); /* nothing else moves */
        } else {
            /* It had to go elsewhere: to a spare, as long as one is idle. */
            assert_true(now->spare || !idle_spare);
            /* A spare may be given more of one node, whatever it has. */
            assert_true(now->spare || loads[now - nodes] <= least + 1);
        }
    }
}

static void shuffle(struct pel_place *p, struct pel_place_node *n)
{
    for (unsigned i = (unsigned)count; i > 1; i--) {
        unsigned k = below(i);
        struct pel_place kept = p[k];
        p[k] = p[i - 1];
        p[i - 1] = kept;
    }
    for (unsigned i = NODES; i > 1; i--) {
        unsigned k = below(i);
        struct pel_place_node kept = n[k];
        n[k] = n[i - 1];
        n[i - 1] = kept;
    }
}

/* The same whatever the order of what it is given. */
static void judge_order(const struct pel_place *before)
{
    struct pel_place p[VIEWS];
    struct pel_place_node n[NODES];
    memcpy(p, before, sizeof p);
    memcpy(n, nodes, sizeof n);
    shuffle(p, n);
    (void)pel_places_settle(p, count, n, NODES);
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < count; k++) {
            if (strcmp(p[k].view, places[i].view) != 0) {
                continue;
            }
            assert_int_equal(p[k].now == NULL, places[i].now == NULL);
            if (p[k].now) {
                assert_string_equal(p[k].now, places[i].now);
            }
        }
    }
}

static void walks(void **state)
{
    (void)state;
    unsigned long steps = walk_steps(20000);
    size_t moved = 0;
    walk_seed();
    for (size_t i = 0; i < NODES; i++) {
        nodes[i] = (struct pel_place_node){ names[i], true, true, i >= 5 };
    }
    for (unsigned long i = 0; i < steps; i++) {
        struct pel_place before[VIEWS];
        one_step();
        memcpy(before, places, sizeof before);
        moved += pel_places_settle(places, count, nodes, NODES);
        judge(before);
        judge_order(before);
    }
    assert_true(moved > steps / 20); /* else it has seen little */
    printf("# %lu steps, %zu moves\n", steps, moved);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_spare_takes_all_of_a_node),
        cmocka_unit_test(two_are_gone_and_there_is_one_spare),
        cmocka_unit_test(without_a_spare_the_least_loaded_takes),
        cmocka_unit_test(where_nobody_is_nothing_changes),
        cmocka_unit_test(walks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
