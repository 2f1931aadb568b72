/* cluster: the nodes of an exercise on several machines. */
#include "pelagosctl/ctl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glib.h>

#include "json.h"

static const char *role_of(const Pelagos__ClusterNode *node)
{
    static const char *const words[] = { "joining", "follower", "master" };
    return node->silent                            ? "silent"
           : node->role < (int)G_N_ELEMENTS(words) ? words[node->role]
                                                   : "?";
}

static void print_node(const Pelagos__ClusterNode *n, uint64_t newest)
{
    char digest[17] = "-", clock[24] = "-";
    for (size_t i = 0; i < n->digest.len && i < 8; i++) {
        snprintf(digest + 2 * i, 3, "%02x", n->digest.data[i]);
    }
    if (n->has_clock) {
        snprintf(clock, sizeof clock, "%+.1f", n->clock);
    }
    ctl_print(stdout, "%-12s %-9s %10llu %6llu %-16s %8.1f %8s  %s", n->name,
              role_of(n), (unsigned long long)n->frame,
              (unsigned long long)(newest - n->frame), digest, n->delay, clock,
              n->address ? n->address : "");
    if (n->differences + n->gaps > 0) {
        ctl_print(stdout, "  %llu differences, %llu gaps",
                  (unsigned long long)n->differences,
                  (unsigned long long)n->gaps);
    }
    if (n->spare) {
        ctl_print(stdout, "  spare");
    }
    for (size_t i = 0; i < n->n_views; i++) {
        ctl_print(stdout, "%s%s", i ? ", " : "  draws ", n->views[i]);
    }
    ctl_print(stdout, "%s", n->alike ? "" : "  not bit-equal");
    ctl_print(stdout, "%s%s\n", n->lacks ? "  lacks " : "",
              n->lacks ? n->lacks : "");
}

static void print_place(const Pelagos__ClusterPlace *p)
{
    const char *why = g_strcmp0(p->drawn_by, p->node) == 0 ? ""
                      : p->there ? "  for some seconds more"
                                 : "  as the other is not there";
    ctl_print(stdout, "%-16s %-12s %-12s  %s%s\n", p->view, p->node,
              p->drawn_by ? p->drawn_by : "-", p->address ? p->address : "",
              why);
}

static void print_places(const Pelagos__Cluster *c)
{
    if (c->n_places > 0) {
        ctl_print(stdout, "\n%-16s %-12s %-12s  %s\n", "view", "placed at",
                  "drawn by", "address");
    }
    for (size_t i = 0; i < c->n_places; i++) {
        print_place(c->places[i]);
    }
}

static void print_nodes(const Pelagos__Cluster *c)
{
    uint64_t newest = c->frame;
    if (!c->name) {
        puts("the server shows no exercise with others (pelagosd --exercise)");
        return;
    }
    for (size_t i = 0; i < c->n_nodes; i++) {
        newest = MAX(newest, c->nodes[i]->frame);
    }
    ctl_print(stdout, "master %s, %s, term %llu", c->master ? c->master : "-",
              c->address ? c->address : "-", (unsigned long long)c->term);
    if (c->has_sealed_p99) {
        ctl_print(stdout, "; sealed within %.1f ms, 99 of 100 within %.1f ms",
                  c->sealed_median, c->sealed_p99);
    }
    ctl_print(stdout, "\n%-12s %-9s %10s %6s %-16s %8s %8s  %s\n", "node",
              "role", "frame", "behind", "digest", "delay ms", "clock ms",
              "address");
    for (size_t i = 0; i < c->n_nodes; i++) {
        print_node(c->nodes[i], newest);
    }
    print_places(c);
}

/* What the edit came to, and what is there to be known of it. */
static void print_edit(const Pelagos__Cluster *c,
                       const Pelagos__ClusterPlaceCommand *command)
{
    const Pelagos__ClusterPlace *now = NULL;
    for (size_t i = 0; i < c->n_places; i++) {
        now = g_strcmp0(c->places[i]->view, command->view) == 0 ? c->places[i]
                                                                : now;
    }
    if (!command->node) {
        ctl_print(stdout, "view %s is placed no more\n", command->view);
    } else {
        ctl_print(stdout, "view %s is placed at node %s%s\n", command->view,
                  command->node,
                  now && now->there ? "" : ", which is not there now");
    }
}

/* `place VIEW NODE` and `unplace VIEW`; USAGE after having said why. */
static enum ctl_exit read_edit(const struct ctl *ctl,
                               Pelagos__ClusterPlaceCommand *command)
{
    bool place = strcmp(ctl->args[0], "place") == 0;
    if (!place && strcmp(ctl->args[0], "unplace") != 0) {
        return ctl_say(CTL_USAGE,
                       "cluster does not know `%s`: place VIEW NODE, unplace "
                       "VIEW, or nothing",
                       ctl->args[0]);
    }
    if (ctl->arg_count != (place ? 3 : 2)) {
        return ctl_say(CTL_USAGE, "usage: pelagosctl cluster %s",
                       place ? "place VIEW NODE" : "unplace VIEW");
    }
    command->view = (char *)ctl->args[1];
    command->node = place ? (char *)ctl->args[2] : NULL;
    return CTL_DONE;
}

enum ctl_exit ctl_cluster(struct ctl *ctl)
{
    Pelagos__Cluster *cluster = NULL;
    Pelagos__ClusterPlaceCommand command = PELAGOS__CLUSTER_PLACE_COMMAND__INIT;
    struct pel_client_error error;
    bool edit = ctl->arg_count > 0;
    enum ctl_exit status = edit ? read_edit(ctl, &command) : CTL_DONE;
    if (status == CTL_DONE) {
        status = ctl_connect(ctl);
    }
    if (status != CTL_DONE) {
        return status;
    }
    if (edit ? pel_client_place(ctl->client, &command, &cluster, &error)
             : pel_client_cluster(ctl->client, &cluster, &error)) {
        return ctl_report(ctl, &error);
    }
    if (ctl_flag(ctl, "json")) {
        char *text = pel_json_from_message(&cluster->base, true);
        puts(text);
        free(text);
    } else if (edit) {
        print_edit(cluster, &command);
    } else {
        print_nodes(cluster);
    }
    pelagos__cluster__free_unpacked(cluster, NULL);
    return CTL_DONE;
}
