#include "cluster/places.h"

#include <string.h>

static const struct pel_place_node *find(const struct pel_place_node *nodes,
                                         size_t count, const char *name)
{
    for (size_t i = 0; name && i < count; i++) {
        if (nodes[i].there && strcmp(nodes[i].name, name) == 0) {
            return &nodes[i];
        }
    }
    return NULL;
}

/* Placed views that a node draws. */
static size_t load_of(const struct pel_place *places, size_t count,
                      const char *node)
{
    size_t load = 0;
    for (size_t i = 0; i < count; i++) {
        load += places[i].now && strcmp(places[i].now, node) == 0;
    }
    return load;
}

static bool draws_for(const struct pel_place *places, size_t count,
                      const char *node, const char *placed_at)
{
    for (size_t i = 0; i < count; i++) {
        if (places[i].now && strcmp(places[i].now, node) == 0 &&
            strcmp(places[i].node, placed_at) == 0) {
            return true;
        }
    }
    return false;
}

/* Who takes a view that nobody draws: the least of these. */
struct claim {
    int kind; /* 0: draws others of that node; 1: a free spare; 2: any */
    size_t load;
    const char *name;
};

static bool is_less(const struct claim *a, const struct claim *b)
{
    return a->kind != b->kind   ? a->kind < b->kind
           : a->load != b->load ? a->load < b->load
                                : strcmp(a->name, b->name) < 0;
}

static const char *taker(const struct pel_place *places, size_t count,
                         const struct pel_place_node *nodes, size_t node_count,
                         const struct pel_place *place)
{
    struct claim best = { .kind = 3 };
    for (size_t i = 0; i < node_count; i++) {
        if (!nodes[i].there) {
            continue;
        }
        struct claim claim = { 2, load_of(places, count, nodes[i].name),
                               nodes[i].name };
        if (nodes[i].spare) {
            claim.kind = draws_for(places, count, claim.name, place->node) ? 0
                         : claim.load == 0                                 ? 1
                                                                           : 2;
        }
        if (best.kind == 3 || is_less(&claim, &best)) {
            best = claim;
        }
    }
    return best.name;
}

/* Those without anybody, in the order of their nodes and views. */
static struct pel_place *next_orphan(struct pel_place *places, size_t count,
                                     const struct pel_place_node *nodes,
                                     size_t node_count)
{
    struct pel_place *first = NULL;
    for (size_t i = 0; i < count; i++) {
        struct pel_place *place = &places[i];
        if (find(nodes, node_count, place->now)) {
            continue;
        }
        int order = first ? strcmp(place->node, first->node) : -1;
        if (order < 0 || (order == 0 && strcmp(place->view, first->view) < 0)) {
            first = place;
        }
    }
    return first;
}

size_t pel_places_settle(struct pel_place *places, size_t count,
                         const struct pel_place_node *nodes, size_t node_count)
{
    size_t changed = 0;
    for (size_t i = 0; i < count; i++) {
        struct pel_place *place = &places[i];
        const struct pel_place_node *home =
            find(nodes, node_count, place->node);
        bool drawn = find(nodes, node_count, place->now) != NULL;
        if (home && (!drawn || home->steady) &&
            (!place->now || strcmp(place->now, place->node) != 0)) {
            place->now = home->name;
            changed++;
        }
    }
    struct pel_place *orphan;
    while ((orphan = next_orphan(places, count, nodes, node_count))) {
        const char *name = taker(places, count, nodes, node_count, orphan);
        if (!name) {
            break; /* nobody is there */
        }
        orphan->now = name;
        changed++;
    }
    return changed;
}
