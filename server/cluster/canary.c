/* A picture that every node draws at its start, to see whether its device gives
 * the bits of the others. */
#include <string.h>

#include "base/log.h"
#include "base/watch.h"
#include "cluster/cluster_parts.h"
#include "message.h"
#include "scene/scene.h"

static gboolean on_settled(gpointer user)
{
    PEL_WATCH("cluster");
    struct pel_cluster *c = user;
    c->settled = 0;
    pel_cluster_show(c, true, 0);
    pel_cluster_join(c);
    return G_SOURCE_REMOVE;
}

static void drawn(void *user, enum pel_err err, const struct pel_fault *fault,
                  struct pel_frame *frame)
{
    struct pel_cluster *c = user;
    c->canary_id = 0;
    if (err) {
        pel_warn("CLU-015",
                 "node %s cannot draw the picture by which nodes are compared: "
                 "%s",
                 c->name, fault->message);
    } else {
        gsize length = PEL_DIGEST_SIZE;
        GChecksum *sum = g_checksum_new(G_CHECKSUM_SHA256);
        g_checksum_update(sum, frame->data, (gssize)frame->size);
        g_checksum_get_digest(sum, c->canary, &length);
        g_checksum_free(sum);
    }
    /* Not from within the frames' own call. */
    c->settled = g_idle_add(on_settled, c);
}

/* The scene that there is without a state file, at time 0. */
static const struct pel_snapshot *canary_snapshot(const struct pel_cluster *c)
{
    const struct pel_scene_options options = {
        .wave_count = c->options.wave_count,
        .apart = true,
    };
    struct pel_scene *scene;
    struct pel_fault fault;
    if (pel_scene_create(&options, &scene, &fault)) {
        return NULL;
    }
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    (void)pel_scene_destroy(scene);
    return s;
}

void pel_cluster_draw_canary(struct pel_cluster *c)
{
    Pelagos__FrameRequest request = PELAGOS__FRAME_REQUEST__INIT;
    struct pel_sealed sealed = { .snapshot = canary_snapshot(c),
                                 .coasts = true };
    struct pel_fault fault;
    char view[] = "bridge";
    request.view = view;
    request.has_width = request.has_height = request.has_time = true;
    request.width = 64;
    request.height = 36;
    request.has_format = true;
    request.format = PELAGOS__FRAME_FORMAT__PNG;
    if (sealed.snapshot) {
        pel_frames_show(c->frames, &sealed);
        pel_snapshot_unref(sealed.snapshot);
    }
    if (!sealed.snapshot || pel_frames_request(c->frames, &request, drawn, c,
                                               &c->canary_id, &fault)) {
        pel_warn("CLU-016", "node %s is not compared with others", c->name);
        c->settled = g_idle_add(on_settled, c);
    }
}
