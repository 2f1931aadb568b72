/* Questions for the light that leaves the water: the reference's answers and
 * the Monte Carlo's, and every answer as a message. */
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "frames/core.h"
#include "message.h"
#include "optics/watermontecarlo.h"

#define N PEL_WATER_WAVELENGTHS

void pel_optics_read_water(const Pelagos__WaterQuery *from,
                           struct pel_water_question *to)
{
    to->at = (struct pel_geometry){ from->sun_zenith * PEL_DEG,
                                    from->view_zenith * PEL_DEG,
                                    from->azimuth * PEL_DEG };
    to->paths = from->paths;
    to->seed = from->seed;
}

static void by_montecarlo(struct pel_water_question *q,
                          const struct pel_medium *m, int i)
{
    const struct pel_montecarlo_sun sun = { q->at.sun_zenith_rad,
                                            q->at.azimuth_rad };
    struct pel_montecarlo_result r;
    pel_montecarlo_leaving(m, NULL, q->at.view_zenith_rad, &sun, 1, q->paths,
                           (uint64_t)q->seed + (uint64_t)i, &r, NULL);
    q->light.part[PEL_WATER_SINGLE][i] = r.single.mean;
    q->light.part[PEL_WATER_SECOND][i] = r.second.mean;
    q->light.part[PEL_WATER_HIGHER][i] = r.higher.mean;
    q->light.part[PEL_WATER_BOTTOM][i] =
        r.bottom_direct.mean + r.bottom_scattered.mean;
    q->bottom_direct[i] = r.bottom_direct.mean;
    q->total[i] = r.total.mean;
    q->error[i] = r.total.error;
}

enum pel_err pel_optics_water(struct pel_optics_query *query)
{
    struct pel_water_question *q = &query->water;
    for (int i = 0; i < N; i++) {
        struct pel_medium m = pel_water_medium(&query->environment.water, i);
        if (q->montecarlo) {
            by_montecarlo(q, &m, i);
            continue;
        }
        struct pel_leaving l;
        enum pel_err err =
            pel_transport_leaving(&m, &q->at, query->environment.orders, &l);
        if (err) {
            return err;
        }
        q->light.part[PEL_WATER_SINGLE][i] = l.single;
        q->light.part[PEL_WATER_SECOND][i] = l.second;
        q->light.part[PEL_WATER_HIGHER][i] = l.higher;
        q->light.part[PEL_WATER_BOTTOM][i] =
            l.bottom_direct + l.bottom_scattered;
        q->bottom_direct[i] = l.bottom_direct;
        q->total[i] = l.total;
    }
    return PEL_OK;
}

static void list(size_t *n, double **to, const double from[N])
{
    *to = malloc(N * sizeof **to);
    if (!*to) {
        abort();
    }
    memcpy(*to, from, N * sizeof **to);
    *n = N;
}

Pelagos__WaterLight *pel_optics_water_message(const struct pel_optics_query *q)
{
    const struct pel_water_question *w = &q->water;
    const struct pel_water_body *body = &q->environment.water;
    Pelagos__WaterLight *out = (Pelagos__WaterLight *)pel_message_new(
        &pelagos__water_light__descriptor);
    double total[N];
    for (int i = 0; i < N; i++) {
        total[i] = w->total[i];
        for (int p = 0; q->gpu && p < PEL_WATER_PARTS; p++) {
            total[i] += w->light.part[p][i];
        }
    }
#define LIST(field, values) list(&out->n_##field, &out->field, values)
    LIST(single, w->light.part[PEL_WATER_SINGLE]);
    LIST(second, w->light.part[PEL_WATER_SECOND]);
    LIST(higher, w->light.part[PEL_WATER_HIGHER]);
    LIST(bottom, w->light.part[PEL_WATER_BOTTOM]);
    LIST(total, total);
    if (!q->gpu) {
        LIST(bottom_direct, w->bottom_direct);
    }
    if (!q->gpu && w->montecarlo) {
        LIST(total_error, w->error);
    }
    LIST(absorption, body->absorption);
    LIST(scattering, body->scattering);
    LIST(asymmetry, body->asymmetry);
    LIST(albedo, body->albedo);
#undef LIST
    out->has_depth = true;
    out->depth = body->depth_m;
    out->has_orders = true;
    out->orders = (Pelagos__WaterOrders)q->environment.orders;
    return out;
}
