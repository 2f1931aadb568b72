/* Programs take seconds to compile on some devices: they are made before the
 * first client of a view comes, by a small picture of it. */
#include <string.h>

#include "base/log.h"
#include "base/watch.h"
#include "cluster/cluster_parts.h"

static void drawn(void *user, enum pel_err err, const struct pel_fault *fault,
                  struct pel_frame *frame)
{
    struct pel_cluster *c = user;
    (void)frame;
    c->warm_id = 0;
    if (err) {
        pel_warn("CLU-020",
                 "node %s cannot draw a view that it may have to: %s", c->name,
                 fault->message);
    }
}

/* This node has it, or may be given it. */
static bool may_draw(const struct pel_cluster *c,
                     const Pelagos__ClusterPlace *place)
{
    return c->options.spare || strcmp(place->node, c->name) == 0 ||
           g_strcmp0(place->drawn_by, c->name) == 0;
}

static bool ask(struct pel_cluster *c, char *view)
{
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    struct pel_fault fault;
    request.view = view;
    request.has_width = request.has_height = request.has_format = true;
    request.width = 64;
    request.height = 36;
    request.format = PELAGOS__FRAME_FORMAT__JPEG; /* as live views have it */
    return !pel_frames_request(c->frames, &request, drawn, c, &c->warm_id,
                               &fault);
}

static gboolean is_placed_no_more(gpointer view, gpointer value, gpointer user)
{
    (void)value;
    return !pel_cluster_place_of(user, view);
}

void pel_cluster_warm(struct pel_cluster *c)
{
    size_t count = pel_cluster_place_count(c, NULL);
    if (!pel_cluster_is_current(c)) {
        return;
    }
    g_hash_table_foreach_remove(c->warmed, is_placed_no_more, c);
    for (size_t i = 0; i < count && !c->warm_id; i++) {
        const Pelagos__ClusterPlace *place = c->placing.known->places[i];
        if (may_draw(c, place) &&
            !g_hash_table_contains(c->warmed, place->view) &&
            ask(c, place->view)) {
            g_hash_table_add(c->warmed, g_strdup(place->view));
        }
    }
}

void pel_cluster_warm_free(struct pel_cluster *c)
{
    if (c->warm_id) {
        pel_frames_cancel(c->frames, c->warm_id);
    }
    g_hash_table_destroy(c->warmed);
}
