#include "bridges/cigi_periodic.h"

#include <string.h>

/* Where a request says how often and which one it is; false: once. */
static bool is_periodic(const struct pel_cigi_packet *p, unsigned *period,
                        double *id)
{
    switch (p->kind) {
    case PEL_CIGI_KIND_HAT_REQUEST:
        *period = (unsigned)pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_PERIOD);
        *id = pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_ID);
        return true;
    case PEL_CIGI_KIND_LOS_SEGMENT:
        *period = (unsigned)pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_PERIOD);
        *id = pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_ID);
        return true;
    case PEL_CIGI_KIND_LOS_VECTOR:
        *period = (unsigned)pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_PERIOD);
        *id = pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_ID);
        return true;
    case PEL_CIGI_KIND_POSITION_REQUEST:
        *period =
            (unsigned)pel_cigi_get(p, PEL_CIGI_POSITION_REQUEST_CONTINUOUS);
        *id = pel_cigi_get(p, PEL_CIGI_POSITION_REQUEST_ID) +
              65536 * pel_cigi_get(p, PEL_CIGI_POSITION_REQUEST_CLASS);
        return true;
    default:
        return false;
    }
}

enum pel_cigi_turn pel_cigi_periodic_take(struct pel_cigi_periodic *periodic,
                                          const struct pel_cigi_packet *p,
                                          uint32_t ig_frame)
{
    unsigned period, old_period;
    double id, old_id;
    size_t at = PEL_CIGI_MAX_PERIODIC, spare = PEL_CIGI_MAX_PERIODIC;
    if (!is_periodic(p, &period, &id)) {
        return PEL_CIGI_NOW;
    }
    for (size_t i = PEL_CIGI_MAX_PERIODIC; i-- > 0;) {
        const struct pel_cigi_packet *kept = &periodic->list[i].question;
        if (!periodic->list[i].used) {
            spare = i;
        } else if (kept->kind == p->kind &&
                   is_periodic(kept, &old_period, &old_id) && old_id == id) {
            at = i;
        }
    }
    if (period == 0) {
        if (at < PEL_CIGI_MAX_PERIODIC) {
            periodic->list[at].used = false;
        }
        return PEL_CIGI_NOW;
    }
    at = at < PEL_CIGI_MAX_PERIODIC ? at : spare;
    if (at == PEL_CIGI_MAX_PERIODIC) {
        return PEL_CIGI_NEVER;
    }
    periodic->list[at].used = true;
    periodic->list[at].period = period;
    periodic->list[at].first_frame = ig_frame + 1;
    periodic->list[at].question = *p;
    return PEL_CIGI_LATER;
}

size_t pel_cigi_periodic_due(const struct pel_cigi_periodic *periodic,
                             uint32_t ig_frame,
                             const struct pel_cigi_packet **due)
{
    size_t count = 0;
    for (size_t i = 0; i < PEL_CIGI_MAX_PERIODIC; i++) {
        uint32_t since = ig_frame - periodic->list[i].first_frame;
        if (periodic->list[i].used && since % periodic->list[i].period == 0) {
            due[count++] = &periodic->list[i].question;
        }
    }
    return count;
}

void pel_cigi_periodic_clear(struct pel_cigi_periodic *periodic)
{
    memset(periodic, 0, sizeof *periodic);
}
