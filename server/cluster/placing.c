/* Where views are placed and who draws them: as the store has it, edits of it
 * from any node, and the master's word on who draws what (places.h). All of it
 * is one value, put on the condition that it is the one that was read. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "cluster/cluster_parts.h"
#include "cluster/places.h"
#include "message.h"

#define MOST_PLACES PEL_MAX_VIEWS
#define MOST_EDITS 16 /* known by their numbers, and waiting */
#define GIVE_UP_NS 2000000000LL
#define NAMED "1 to 64 of a-z A-Z 0-9 . _ -"

struct edit {
    char *view, *node; /* NULL: placed no more */
    uint64_t number;
    int64_t begun_ns;
    pel_cluster_done done;
    void *user;
};

/* --- lists of places ------------------------------------------------------ */

static Pelagos__ClusterPlace *find(const Pelagos__ClusterPlaces *places,
                                   const char *view)
{
    for (size_t i = 0; places && i < places->n_places; i++) {
        if (strcmp(places->places[i]->view, view) == 0) {
            return places->places[i];
        }
    }
    return NULL;
}

static Pelagos__ClusterPlaces *new_places(void)
{
    return (Pelagos__ClusterPlaces *)pel_message_new(
        &pelagos__cluster_places__descriptor);
}

static void free_places(Pelagos__ClusterPlaces *places)
{
    if (places) {
        pelagos__cluster_places__free_unpacked(places, NULL);
    }
}

static void add(Pelagos__ClusterPlaces *to, const Pelagos__ClusterPlace *place)
{
    to->places = realloc(to->places, (to->n_places + 1) * sizeof *to->places);
    to->places[to->n_places++] =
        (Pelagos__ClusterPlace *)pel_message_copy(&place->base);
}

static void set(char **text, const char *to)
{
    free(*text);
    *text = to ? strdup(to) : NULL;
}

/* What a daemon could have put: others may write into the store. */
static Pelagos__ClusterPlaces *sound(const Pelagos__ClusterPlaces *said)
{
    Pelagos__ClusterPlaces *out = new_places();
    for (size_t i = 0; said && i < said->n_places; i++) {
        const Pelagos__ClusterPlace *p = said->places[i];
        bool fine = p->view && p->node && pel_cluster_is_name(p->view) &&
                    pel_cluster_is_name(p->node) &&
                    (!p->drawn_by || pel_cluster_is_name(p->drawn_by));
        if (fine && out->n_places < MOST_PLACES && !find(out, p->view)) {
            add(out, p);
        }
    }
    size_t edits = said ? MIN(said->n_edits, MOST_EDITS) : 0;
    out->edits = calloc(edits + 1, sizeof *out->edits);
    for (size_t i = 0; i < edits; i++) {
        out->edits[out->n_edits++] = said->edits[said->n_edits - edits + i];
    }
    return out;
}

static bool has_edit(const Pelagos__ClusterPlaces *places, uint64_t number)
{
    for (size_t i = 0; i < places->n_edits; i++) {
        if (places->edits[i] == number) {
            return true;
        }
    }
    return false;
}

size_t pel_cluster_place_count(const struct pel_cluster *c, size_t *elsewhere)
{
    const Pelagos__ClusterPlaces *known = c->placing.known;
    for (size_t i = 0; elsewhere && known && i < known->n_places; i++) {
        const Pelagos__ClusterPlace *p = known->places[i];
        *elsewhere += g_strcmp0(p->drawn_by, p->node) != 0;
    }
    return known ? known->n_places : 0;
}

/* --- what the store has --------------------------------------------------- */

/* Of the log of the one who decides. */
static void tell(const struct pel_cluster *c, const Pelagos__ClusterPlace *p)
{
    if (c->role != PELAGOS__CLUSTER_ROLE__MASTER) {
        return;
    }
    if (strcmp(p->drawn_by, p->node) == 0) {
        pel_info("CLU-017", "view %s is drawn by node %s, where it is placed",
                 p->view, p->node);
    } else {
        pel_warn("CLU-018",
                 "view %s is drawn by node %s: node %s, where it is placed, "
                 "is not there",
                 p->view, p->drawn_by, p->node);
    }
}

static void know(struct pel_cluster *c, const struct pel_seals_places *what)
{
    Pelagos__ClusterPlaces *before = c->placing.known;
    if (before && what->revision <= c->placing.revision) {
        return;
    }
    c->placing.known = sound(what->places);
    c->placing.version = what->version;
    c->placing.revision = what->revision;
    for (size_t i = 0; i < c->placing.known->n_places; i++) {
        const Pelagos__ClusterPlace *p = c->placing.known->places[i];
        const Pelagos__ClusterPlace *was = find(before, p->view);
        if (before && p->drawn_by &&
            g_strcmp0(was ? was->drawn_by : NULL, p->drawn_by) != 0) {
            c->placing.moves += was && was->drawn_by;
            tell(c, p);
        }
    }
    bool first = !before || before->n_places == 0;
    free_places(before);
    if (first && c->role != PELAGOS__CLUSTER_ROLE__JOINING) {
        pel_cluster_say(c, false); /* how often we do from now on */
    }
}

void pel_cluster_on_places(void *user, const struct pel_seals_places *what)
{
    struct pel_cluster *c = user;
    pel_cluster_hear(c);
    know(c, what);
    pel_cluster_place_on(c);
}

/* --- edits ---------------------------------------------------------------- */

static void edit_end(struct pel_cluster *c, struct edit *edit, enum pel_err err,
                     const struct pel_fault *fault)
{
    g_queue_remove(&c->placing.edits, edit);
    edit->done(edit->user, err, fault);
    g_free(edit->view);
    g_free(edit->node);
    g_free(edit);
}

/* `a, b`, or `none`; g_free(). */
static char *listed(const Pelagos__ClusterPlaces *places)
{
    GString *out = g_string_new(places->n_places ? NULL : "none");
    for (size_t i = 0; i < places->n_places; i++) {
        g_string_append_printf(out, "%s%s", i ? ", " : "",
                               places->places[i]->view);
    }
    return g_string_free(out, FALSE);
}

/* Makes the edit in `places`. */
static enum pel_err apply(Pelagos__ClusterPlaces *places,
                          const struct edit *edit, struct pel_fault *fault)
{
    Pelagos__ClusterPlace *place = find(places, edit->view);
    if (!place && !edit->node) {
        g_autofree char *those = listed(places);
        enum pel_err err = pel_fault_set(
            fault, PEL_ERR_NOT_FOUND,
            "view %s is not placed; those that are: %s", edit->view, those);
        g_strlcpy(fault->path, "view", sizeof fault->path);
        return err;
    }
    if (!place && places->n_places == MOST_PLACES) {
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d views are placed, and no more can be",
                             MOST_PLACES);
    }
    if (!place) {
        Pelagos__ClusterPlace new = PELAGOS__CLUSTER_PLACE__INIT;
        new.view = edit->view;
        add(places, &new);
        place = places->places[places->n_places - 1];
    }
    if (!edit->node) {
        for (size_t i = 0; i < places->n_places; i++) {
            if (places->places[i] == place) {
                places->places[i] = places->places[--places->n_places];
            }
        }
        pelagos__cluster_place__free_unpacked(place, NULL);
    } else if (g_strcmp0(place->node, edit->node) != 0) {
        set(&place->node, edit->node);
        set(&place->drawn_by, NULL); /* the master says so at once */
    }
    if (places->n_edits == MOST_EDITS) {
        memmove(places->edits, places->edits + 1,
                --places->n_edits * sizeof *places->edits);
    }
    places->edits =
        realloc(places->edits, (places->n_edits + 1) * sizeof *places->edits);
    places->edits[places->n_edits++] = edit->number;
    return PEL_OK;
}

static void put_done(void *user, bool yes, const struct pel_seals_places *now)
{
    struct pel_cluster *c = user;
    struct edit *edit = g_queue_peek_head(&c->placing.edits);
    c->placing.putting = false;
    know(c, now);
    /* Also where the answer to the first attempt was lost. What was refused
     * because another was quicker is made again, of what there is now. */
    if (edit && has_edit(c->placing.known, edit->number)) {
        pel_info("CLU-019", "view %s is placed %s%s", edit->view,
                 edit->node ? "at node " : "no more",
                 edit->node ? edit->node : "");
        edit_end(c, edit, PEL_OK, NULL);
    }
    if (yes) {
        pel_cluster_place_on(c);
    }
}

static void put(struct pel_cluster *c, const Pelagos__ClusterMaster *master,
                const Pelagos__ClusterPlaces *places)
{
    c->placing.putting = true;
    c->placing.put_ns = pel_now_ns();
    pel_seals_places(c->seals, master, c->placing.version, places, put_done, c);
}

enum pel_err pel_cluster_place(struct pel_cluster *c,
                               const Pelagos__ClusterPlaceCommand *command,
                               pel_cluster_done done, void *user,
                               struct pel_fault *fault)
{
    if (!c) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "this server shows no exercise with others, in "
                             "which views are placed: pelagosd --exercise");
    }
    const Pelagos__State *state = pel_scene_state(c->scene);
    const char *view = command->view ? command->view : "";
    g_autoptr(GString) views = g_string_new(NULL);
    bool is_view = false;
    for (size_t i = 0; i < state->n_views; i++) {
        is_view = is_view || strcmp(state->views[i]->name, view) == 0;
        g_string_append_printf(views, "%s%s", i ? ", " : "",
                               state->views[i]->name);
    }
    enum pel_err err = PEL_OK;
    if (command->node && !pel_cluster_is_name(command->node)) {
        err = pel_fault_set(fault, PEL_ERR_INVALID,
                            "node: `%.70s` is no name of a node, " NAMED,
                            command->node);
        g_strlcpy(fault->path, "node", sizeof fault->path);
        g_strlcpy(fault->value, command->node, sizeof fault->value);
    } else if (command->node ? !is_view : !pel_cluster_is_name(view)) {
        err = pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                            "there is no view called `%.64s`; those that there "
                            "are: %s",
                            view, state->n_views ? views->str : "none");
        g_strlcpy(fault->path, "view", sizeof fault->path);
        g_strlcpy(fault->value, view, sizeof fault->value);
    } else if (c->role == PELAGOS__CLUSTER_ROLE__JOINING || !c->placing.known) {
        err = pel_fault_set(fault, PEL_ERR_CONFLICT,
                            "node %s is joining the exercise and places no "
                            "views; a little later",
                            c->name);
    } else if (g_queue_get_length(&c->placing.edits) == MOST_EDITS) {
        err =
            pel_fault_set(fault, PEL_ERR_BUSY,
                          "%d edits of places wait for the store", MOST_EDITS);
    }
    if (err) {
        return err;
    }
    struct edit *edit = g_new0(struct edit, 1);
    edit->view = g_strdup(view);
    edit->node = g_strdup(command->node);
    edit->number = (uint64_t)g_random_int() << 32 | g_random_int();
    edit->begun_ns = pel_now_ns();
    edit->done = done;
    edit->user = user;
    g_queue_push_tail(&c->placing.edits, edit);
    return PEL_OK;
}

/* --- who draws what ------------------------------------------------------- */

/* The master says, where that is not what the store has. */
static void settle(struct pel_cluster *c)
{
    struct pel_place places[MOST_PLACES];
    Pelagos__ClusterPlaces *known = c->placing.known;
    g_autofree struct pel_place_node *nodes =
        g_new0(struct pel_place_node, c->nodes->len + 1);
    for (guint i = 0; i < c->nodes->len; i++) {
        const struct pel_cluster_node *node = g_ptr_array_index(c->nodes, i);
        nodes[i] = (struct pel_place_node){
            .name = node->said->name,
            .there = pel_cluster_is_there(c, node),
            .steady = pel_cluster_is_steady(c, node),
            .spare = node->said->spare,
        };
    }
    for (size_t i = 0; i < known->n_places; i++) {
        const Pelagos__ClusterPlace *p = known->places[i];
        places[i] = (struct pel_place){ p->view, p->node, p->drawn_by };
    }
    if (pel_places_settle(places, known->n_places, nodes, c->nodes->len) == 0) {
        return;
    }
    Pelagos__ClusterPlaces *next = sound(known);
    for (size_t i = 0; i < next->n_places; i++) {
        set(&next->places[i]->drawn_by, places[i].now);
    }
    put(c, c->master, next);
    free_places(next);
}

static void give_up(struct pel_cluster *c, struct edit *edit)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_BUSY,
                  "the store (etcd) does not answer within %lld s: look "
                  "whether view %s is placed %s%s, and send it again if not",
                  GIVE_UP_NS / 1000000000LL, edit->view,
                  edit->node ? "at node " : "no more",
                  edit->node ? edit->node : "");
    edit_end(c, edit, PEL_ERR_BUSY, &fault);
}

void pel_cluster_place_on(struct pel_cluster *c)
{
    int64_t now_ns = pel_now_ns();
    struct edit *edit;
    if (c->placing.putting && now_ns - c->placing.put_ns > GIVE_UP_NS) {
        pel_seals_places_drop(c->seals);
        c->placing.putting = false;
    }
    while ((edit = g_queue_peek_head(&c->placing.edits)) &&
           now_ns - edit->begun_ns > GIVE_UP_NS) {
        give_up(c, edit);
    }
    while (!c->placing.putting &&
           (edit = g_queue_peek_head(&c->placing.edits))) {
        struct pel_fault fault = { .minimum = 1 };
        Pelagos__ClusterPlaces *next = sound(c->placing.known);
        enum pel_err err = apply(next, edit, &fault);
        if (err) {
            edit_end(c, edit, err, &fault);
        } else {
            put(c, NULL, next);
        }
        free_places(next);
    }
    if (!c->placing.putting && c->role == PELAGOS__CLUSTER_ROLE__MASTER &&
        pel_cluster_place_count(c, NULL) > 0) {
        settle(c);
    }
}

void pel_cluster_places_free(struct pel_cluster *c)
{
    struct pel_fault fault;
    struct edit *edit;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "the server stops");
    while ((edit = g_queue_peek_head(&c->placing.edits))) {
        edit_end(c, edit, PEL_ERR_CONFLICT, &fault);
    }
    free_places(c->placing.known);
}

/* --- for others ----------------------------------------------------------- */

Pelagos__ClusterPlace *pel_cluster_place_copy(const struct pel_cluster *c,
                                              const Pelagos__ClusterPlace *p)
{
    Pelagos__ClusterPlace *out =
        (Pelagos__ClusterPlace *)pel_message_copy(&p->base);
    const struct pel_cluster_node *node = pel_cluster_find(c, p->node);
    const struct pel_cluster_node *now =
        p->drawn_by ? pel_cluster_find(c, p->drawn_by) : NULL;
    out->has_there = true;
    out->there = node && pel_cluster_is_there(c, node);
    set(&out->address, now ? now->said->address : NULL);
    return out;
}

const Pelagos__ClusterPlace *pel_cluster_place_of(const struct pel_cluster *c,
                                                  const char *view)
{
    return find(c->placing.known, view);
}

Pelagos__ClusterPlace *pel_cluster_placed(struct pel_cluster *c,
                                          const char *view, bool *here)
{
    const Pelagos__ClusterPlace *place =
        c ? find(c->placing.known, view) : NULL;
    Pelagos__ClusterPlace only = PELAGOS__CLUSTER_PLACE__INIT;
    only.view = (char *)view;
    *here = !c || (pel_cluster_is_current(c) &&
                   (!place || g_strcmp0(place->drawn_by, c->name) == 0));
    return place ? pel_cluster_place_copy(c, place)
                 : (Pelagos__ClusterPlace *)pel_message_copy(&only.base);
}
