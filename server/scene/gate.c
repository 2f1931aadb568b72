/* Answers that wait until what they are about is sealed. */
#include "scene/led.h"
#include "scene/scene_parts.h"

/* An accepted edit whose client waits. */
struct waiter {
    uint64_t number; /* of the frame that has it */
    const void *source;
    pel_scene_done done; /* NULL: nobody waits any more */
    void *user;
};

void pel_scene_gate(struct pel_scene *scene, uint64_t number)
{
    if (!scene->gate.waiting) {
        scene->gate.waiting = g_queue_new();
    }
    scene->gate.number = number;
}

bool pel_scene_gated(const struct pel_scene *scene)
{
    return scene->gate.waiting != NULL;
}

static bool add(struct pel_scene *scene, const void *source,
                pel_scene_done done, void *user)
{
    if (!scene->gate.waiting) {
        return false;
    }
    struct waiter *w = g_new(struct waiter, 1);
    *w = (struct waiter){ scene->gate.number, source, done, user };
    g_queue_push_tail(scene->gate.waiting, w);
    return true;
}

bool pel_scene_await(struct pel_scene *scene, const void *source,
                     pel_scene_done done, void *user)
{
    return add(scene, source, done, user);
}

bool pel_scene_answer(struct pel_scene *scene, const void *source,
                      pel_scene_done done, void *user, enum pel_err err,
                      const struct pel_fault *fault)
{
    /* What the scene itself does at its moments waits for nobody. */
    bool own = pel_scene_acts_by(scene, source);
    if (!done || (!err && !own && add(scene, source, done, user))) {
        return done != NULL;
    }
    done(user, err, fault);
    return false;
}

/* Answers the oldest; what is called may add others. */
static void answer_first(GQueue *waiting, enum pel_err err,
                         const struct pel_fault *fault)
{
    struct waiter *w = g_queue_pop_head(waiting);
    if (w->done) {
        w->done(w->user, err, fault);
    }
    g_free(w);
}

void pel_scene_sealed(struct pel_scene *scene, uint64_t number)
{
    static const struct pel_fault none;
    GQueue *waiting = scene->gate.waiting;
    while (waiting && !g_queue_is_empty(waiting) &&
           ((const struct waiter *)g_queue_peek_head(waiting))->number <=
               number) {
        answer_first(waiting, PEL_OK, &none);
    }
}

void pel_scene_ungate(struct pel_scene *scene, const struct pel_fault *fault)
{
    GQueue *waiting = scene->gate.waiting;
    scene->gate.waiting = NULL;
    while (waiting && !g_queue_is_empty(waiting)) {
        answer_first(waiting, fault->code, fault);
    }
    if (waiting) {
        g_queue_free(waiting);
    }
}

void pel_scene_gate_forget(struct pel_scene *scene, const void *source)
{
    for (GList *at = scene->gate.waiting ? scene->gate.waiting->head : NULL; at;
         at = at->next) {
        struct waiter *w = at->data;
        if (source && w->source == source) {
            w->done = NULL;
        }
    }
}
