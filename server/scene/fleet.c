#include "scene/fleet.h"

#include <glib.h>
#include <math.h>
#include <string.h>

#include "base/log.h"
#include "fault.h"
#include "message.h"
#include "models/builtin.h"
#include "models/modelload.h"

#define MOST_BYTES ((size_t)1 << 30) /* of all models together */

struct pel_fleet_member {
    uint32_t entity;
    Pelagos__Model *wish;
    const struct pel_model *model; /* NULL: it could not be had */
};

static bool same_number(protobuf_c_boolean has_a, double a,
                        protobuf_c_boolean has_b, double b)
{
    return (has_a != 0) == (has_b != 0) && (!has_a || a == b);
}

static bool same(const Pelagos__Model *a, const Pelagos__Model *b)
{
    return g_strcmp0(a->name, b->name) == 0 &&
           same_number(a->has_length, a->length, b->has_length, b->length) &&
           same_number(a->has_beam, a->beam, b->has_beam, b->beam) &&
           same_number(a->has_draught, a->draught, b->has_draught,
                       b->draught) &&
           same_number(a->has_height, a->height, b->has_height, b->height) &&
           same_number(a->has_colour, a->colour, b->has_colour, b->colour);
}

/* The member that looks so; from `guess` on, then from the first. */
static const struct pel_fleet_member *
find(const struct pel_fleet *fleet, const Pelagos__Model *wish, size_t guess)
{
    for (size_t k = 0; k < fleet->count; k++) {
        size_t i = (guess + k) % fleet->count;
        if (same(fleet->members[i].wish, wish)) {
            return &fleet->members[i];
        }
    }
    return NULL;
}

static struct pel_builtin builtin_of(const Pelagos__Model *wish)
{
    return (struct pel_builtin){
        .name = wish->name,
        .length_m = wish->has_length ? wish->length : 0,
        .beam_m = wish->has_beam ? wish->beam : 0,
        .draught_m = wish->has_draught ? wish->draught : 0,
        .height_m = wish->has_height ? wish->height : 0,
        .coloured = wish->has_colour,
        .colour = wish->colour,
    };
}

enum pel_err pel_fleet_try(const Pelagos__Model *wish, struct pel_fault *fault)
{
    if (pel_builtin_find(wish->name)) {
        const struct pel_builtin what = builtin_of(wish);
        return pel_builtin_check(&what, fault);
    }
    return pel_model_is_file(wish->name)
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                               "%.64s is neither a built-in model nor a file "
                               "of a model; pelagosctl models lists both",
                               wish->name);
}

enum pel_err pel_fleet_make(const Pelagos__Model *wish, const char *directory,
                            const struct pel_model **out, char notes[],
                            struct pel_fault *fault)
{
    notes[0] = '\0';
    *out = NULL;
    const struct pel_builtin what = builtin_of(wish);
    const struct pel_model_source source = {
        .directory = directory,
        .file = wish->name,
        .length_m = wish->has_length ? wish->length : 0,
        .beam_m = wish->has_beam ? wish->beam : 0,
    };
    enum pel_err err = pel_builtin_find(wish->name)
                           ? pel_builtin_make(&what, out, fault)
                           : pel_model_load(&source, out, notes, fault);
    if (err == PEL_OK) {
        err = pel_model_shade(*out, fault);
    }
    if (err != PEL_OK) {
        pel_model_unref(*out);
        *out = NULL;
    }
    return err;
}

static bool can_have(double asked, double typical, double most)
{
    return asked >= typical / PEL_BUILTIN_FACTOR &&
           asked <= fmin(typical * PEL_BUILTIN_FACTOR, most);
}

void pel_fleet_trim(Pelagos__Model *wish)
{
    const struct pel_builtin_kind *kind = pel_builtin_find(wish->name);
    const double most_m = PEL_MODEL_MOST_SIZE_M;
    if (!kind) {
        return;
    }
    wish->has_length =
        wish->has_length && can_have(wish->length, kind->length_m, most_m);
    wish->has_beam =
        wish->has_beam && can_have(wish->beam, kind->beam_m, most_m);
    wish->has_draught = wish->has_draught &&
                        can_have(wish->draught, kind->draught_m, most_m / 10);
    wish->has_height =
        wish->has_height && can_have(wish->height, kind->height_m, most_m);
}

/* --- built-in models that were made last ------------------------------------
 *
 * Scenes that come and go, as a data set's do, ask for the same few again, and
 * finding what a form hides of its surroundings takes a tenth of a second.
 * Files may change meanwhile, and are read anew. */

#define SHELF 32
#define SHELF_BYTES ((size_t)64 << 20)

static struct {
    GMutex lock; /* of the rest */
    struct pel_fleet_member items[SHELF];
    size_t count; /* the one that was wanted last is the last */
    size_t bytes;
} shelf;

static const struct pel_model *from_shelf(const Pelagos__Model *wish)
{
    const struct pel_model *found = NULL;
    g_mutex_lock(&shelf.lock);
    for (size_t i = 0; i < shelf.count && !found; i++) {
        if (same(shelf.items[i].wish, wish)) {
            struct pel_fleet_member item = shelf.items[i];
            memmove(&shelf.items[i], &shelf.items[i + 1],
                    (shelf.count - i - 1) * sizeof item);
            shelf.items[shelf.count - 1] = item;
            found = pel_model_ref(item.model);
        }
    }
    g_mutex_unlock(&shelf.lock);
    return found;
}

static void take_off_first(void)
{
    shelf.bytes -= shelf.items[0].model->bytes;
    pel_model_unref(shelf.items[0].model);
    pelagos__model__free_unpacked(shelf.items[0].wish, NULL);
    memmove(&shelf.items[0], &shelf.items[1],
            --shelf.count * sizeof shelf.items[0]);
}

static void put_on_shelf(const Pelagos__Model *wish,
                         const struct pel_model *model)
{
    if (!pel_builtin_find(wish->name) || model->bytes > SHELF_BYTES) {
        return;
    }
    g_mutex_lock(&shelf.lock);
    while (shelf.count == SHELF ||
           (shelf.count > 0 && shelf.bytes + model->bytes > SHELF_BYTES)) {
        take_off_first();
    }
    shelf.items[shelf.count++] = (struct pel_fleet_member){
        .wish = (Pelagos__Model *)pel_message_copy(&wish->base),
        .model = pel_model_ref(model),
    };
    shelf.bytes += model->bytes;
    g_mutex_unlock(&shelf.lock);
}

/* --- the fleet ------------------------------------------------------------ */

/* The path of the field at fault: the model's own, or its name. */
static void set_path(struct pel_fault *fault, uint32_t entity,
                     const Pelagos__Model *wish)
{
    static const char *const sizes[] = { "length", "beam", "draught",
                                         "height" };
    const char *field = "name";
    char path[64];
    for (int i = 0; fault && i < 4; i++) {
        field =
            strcmp(fault->path, sizes[i]) == 0 && pel_builtin_find(wish->name)
                ? sizes[i]
                : field;
    }
    g_snprintf(path, sizeof path, "entities.%u.model.%s", entity, field);
    pel_fault_at(fault, path, wish->name);
}

static size_t bytes_of(const struct pel_fleet *fleet)
{
    size_t sum = 0;
    for (size_t i = 0; i < fleet->count; i++) {
        const struct pel_model *m = fleet->members[i].model;
        bool first = m != NULL;
        for (size_t k = 0; k < i && first; k++) {
            first = fleet->members[k].model != m;
        }
        sum += first ? m->bytes : 0;
    }
    return sum;
}

static enum pel_err add(const Pelagos__Entity *entity, const char *directory,
                        bool forgiving, const struct pel_fleet *present,
                        struct pel_fleet *out, struct pel_fault *fault)
{
    struct pel_fleet_member *m = &out->members[out->count];
    const struct pel_fleet_member *old =
        find(present, entity->model, out->count);
    const struct pel_fleet_member *twin =
        old ? NULL : find(out, entity->model, 0);
    char notes[PEL_MODEL_NOTES];
    struct pel_fault why = { 0 };
    enum pel_err err = PEL_OK;
    *m = (struct pel_fleet_member){ .entity = entity->id };
    if (old || twin) {
        m->model = pel_model_ref(old ? old->model : twin->model);
    } else if (!(m->model = from_shelf(entity->model))) {
        err = pel_fleet_make(entity->model, directory, &m->model, notes, &why);
        if (!err) {
            put_on_shelf(entity->model, m->model);
        }
    }
    if (err && forgiving) {
        pel_error("SCN-011",
                  "entity %u has no shape, and the state keeps its model: %s",
                  entity->id, why.message);
        err = PEL_OK;
    }
    if (err) {
        set_path(&why, entity->id, entity->model);
        if (fault) {
            *fault = why;
        }
        return err;
    }
    m->wish = (Pelagos__Model *)pel_message_copy(&entity->model->base);
    out->count++;
    if (!old && !twin && bytes_of(out) > MOST_BYTES) {
        err = pel_fault_set(fault, PEL_ERR_BUSY,
                            "the models of all entities would take more than "
                            "1 GiB; give some of them simpler ones");
        set_path(fault, entity->id, entity->model);
    }
    return err;
}

/* Whether each entity that has a model has the same as before. */
static bool is_fleet_of(const struct pel_fleet *fleet,
                        const Pelagos__State *state, size_t count)
{
    size_t seen = 0;
    bool is = fleet->count == count;
    for (size_t i = 0; i < state->n_entities && is; i++) {
        const Pelagos__Entity *e = state->entities[i];
        if (e->model) {
            const struct pel_fleet_member *m = &fleet->members[seen++];
            is = m->entity == e->id && same(m->wish, e->model);
        }
    }
    return is;
}

enum pel_err pel_fleet_get(const Pelagos__State *state, const char *directory,
                           bool forgiving, const struct pel_fleet *present,
                           struct pel_fleet *out, struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    size_t count = 0;
    *out = (struct pel_fleet){ 0 };
    for (size_t i = 0; i < state->n_entities; i++) {
        count += state->entities[i]->model != NULL;
    }
    if (count == 0) {
        return PEL_OK;
    }
    if (is_fleet_of(present, state, count)) {
        *out = pel_fleet_ref(present);
        return PEL_OK;
    }
    out->members =
        g_atomic_rc_box_alloc0(count * sizeof(struct pel_fleet_member));
    for (size_t i = 0; i < state->n_entities && !err; i++) {
        if (state->entities[i]->model) {
            err = add(state->entities[i], directory, forgiving, present, out,
                      fault);
        }
    }
    if (err) {
        pel_fleet_finish(out);
    }
    return err;
}

bool pel_fleet_has(const struct pel_fleet *fleet, const Pelagos__State *state)
{
    size_t seen = 0;
    for (size_t i = 0; i < state->n_entities; i++) {
        const Pelagos__Model *wish = state->entities[i]->model;
        if (wish && !find(fleet, wish, seen++)) {
            return false;
        }
    }
    return true;
}

const struct pel_model *pel_fleet_of(const struct pel_fleet *fleet,
                                     const Pelagos__Entity *entity,
                                     size_t *next)
{
    for (size_t k = 0; entity->model && k < fleet->count; k++) {
        size_t i = (*next + k) % fleet->count;
        if (fleet->members[i].entity == entity->id) {
            *next = i + 1;
            return fleet->members[i].model;
        }
    }
    return NULL;
}

struct pel_fleet pel_fleet_ref(const struct pel_fleet *fleet)
{
    if (fleet->members) {
        g_atomic_rc_box_acquire(fleet->members);
    }
    return *fleet;
}

static void clear(gpointer data)
{
    struct pel_fleet_member *members = data;
    size_t count = g_atomic_rc_box_get_size(data) / sizeof *members;
    for (size_t i = 0; i < count; i++) {
        pel_model_unref(members[i].model);
        if (members[i].wish) {
            pelagos__model__free_unpacked(members[i].wish, NULL);
        }
    }
}

void pel_fleet_finish(struct pel_fleet *fleet)
{
    if (fleet->members) {
        g_atomic_rc_box_release_full(fleet->members, clear);
    }
    *fleet = (struct pel_fleet){ 0 };
}
