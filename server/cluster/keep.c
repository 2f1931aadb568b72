/* What is sealed, to those on this node who record it and keep its state. */
#include "cluster/cluster_parts.h"

static Pelagos__State *unpacked(const struct pel_packed *packed)
{
    return pelagos__state__unpack(NULL, packed->size, packed->bytes);
}

static void keep_state(struct pel_cluster *c, uint64_t revision)
{
    pel_scene_keep_sealed(c->scene, c->packed.bytes, c->packed.size, revision);
}

void pel_cluster_keep(struct pel_cluster *c, Pelagos__LogEntry *const *entries,
                      size_t count, bool anew)
{
    if (!c->packed.bytes) {
        return;
    }
    keep_state(c, c->snapshot->revision);
    if (c->options.log) {
        const struct pel_sealedlog_frame frame = {
            .number = c->number,
            .entries = entries,
            .count = count,
            .time_s = c->time_s,
            .revision = c->snapshot->revision,
            .mode = c->snapshot->mode,
            .anew = anew ? unpacked(&c->packed) : NULL,
        };
        pel_sealedlog_add(c->options.log, &frame);
    }
}

void pel_cluster_keep_begin(struct pel_cluster *c)
{
    if (!c->packed.bytes) {
        return;
    }
    Pelagos__State *state = unpacked(&c->packed);
    keep_state(c, state->revision);
    if (c->options.log) {
        pel_sealedlog_begin(c->options.log, c->number, state);
    } else {
        pelagos__state__free_unpacked(state, NULL);
    }
}
