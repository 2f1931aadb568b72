/* Which node draws each placed view: a function of where the views are placed,
 * who drew them until now, and who is there. It depends on neither the order of
 * its arguments nor time. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

struct pel_place_node {
    const char *name;
    bool there;  /* it shows the exercise */
    bool steady; /* and has for some time */
    bool spare;  /* it is there for those that are gone */
};

struct pel_place {
    const char *view; /* each once */
    const char *node; /* where it is placed; need not be among the nodes */
    const char *now;  /* who draws it; NULL: nobody yet */
};

/* Sets `now` of each place to a node that is there, if any is, else leaves it;
 * how many it changed. A view stays where it is drawn as long as that node is
 * there, unless the node where it is placed is there and steady: then it goes
 * back. Else the first of these takes it:
 * - the node where it is placed, if it is there;
 * - the spare that draws others of that node;
 * - a spare that draws no placed view, the first by name;
 * - of all nodes the one that draws the fewest, the first by name. */
size_t pel_places_settle(struct pel_place *places, size_t count,
                         const struct pel_place_node *nodes, size_t node_count);
