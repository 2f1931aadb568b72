/* Questions for the light that leaves the water: the reference's answers and
 * the Monte Carlo's, and every answer as a message. */
#include <stdlib.h>

#include "base/reserve.h"
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
    if (from->has_wavelength) {
        double last = from->has_wavelength_last ? from->wavelength_last
                                                : from->wavelength;
        to->first_nm = from->wavelength;
        to->step_nm = from->wavelength_step;
        /* A hair more, for steps that binary fractions do not meet. */
        to->count = 1 + (int)((last - to->first_nm) / to->step_nm + 1e-9);
    }
}

enum pel_err pel_optics_check_water(const Pelagos__OpticsQuery *query,
                                    struct pel_fault *fault)
{
    if (query->question_case != PELAGOS__OPTICS_QUERY__QUESTION_WATER) {
        return PEL_OK;
    }
    const Pelagos__WaterQuery *w = query->water;
    if (w->has_wavelength && query->from != PELAGOS__OPTICS_SOURCE__REFERENCE) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "water.wavelength: only REFERENCE answers at any "
                             "wavelength");
    }
    if (w->has_wavelength_last &&
        (!w->has_wavelength || w->wavelength_last < w->wavelength)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "water.wavelengthLast must not be less than "
                             "water.wavelength, which goes with it");
    }
    return PEL_OK;
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

static enum pel_err by_reference(struct pel_optics_query *query)
{
    struct pel_water_question *q = &query->water;
    const struct pel_snapshot *s = query->snapshot;
    int count = q->count ? q->count : N;
    q->reports = calloc((size_t)count, sizeof *q->reports);
    enum pel_err err = q->reports ? PEL_OK : PEL_ERR_NO_MEMORY;
    for (int i = 0; i < count && !err; i++) {
        double nm = q->count ? q->first_nm + i * q->step_nm
                             : pel_water_wavelength_nm[i];
        err = pel_water_report(&s->water_desc, &s->water, nm, &q->at,
                               query->environment.orders, &q->reports[i]);
    }
    return err;
}

enum pel_err pel_optics_water(struct pel_optics_query *query)
{
    if (!query->water.montecarlo) {
        return by_reference(query);
    }
    for (int i = 0; i < N; i++) {
        struct pel_medium m = pel_water_medium(&query->environment.water, i);
        by_montecarlo(&query->water, &m, i);
    }
    return PEL_OK;
}

/* A list of as many numbers, and where it is. */
static double *list(size_t *n, double **to, int count)
{
    *to = pel_sure_calloc((size_t)count, sizeof **to);
    *n = (size_t)count;
    return *to;
}

#define LIST(field) list(&out->n_##field, &out->field, count)

static void put_light(const struct pel_optics_query *q, int count,
                      Pelagos__WaterLight *out)
{
    const struct pel_water_question *w = &q->water;
    double *single = LIST(single), *second = LIST(second);
    double *higher = LIST(higher), *bottom = LIST(bottom);
    double *total = LIST(total), *direct = q->gpu ? NULL : LIST(bottom_direct);
    double *error = w->montecarlo ? LIST(total_error) : NULL;
    for (int i = 0; i < count; i++) {
        if (w->reports) {
            const struct pel_leaving *l = &w->reports[i].leaving;
            single[i] = l->single;
            second[i] = l->second;
            higher[i] = l->higher;
            bottom[i] = l->bottom_direct + l->bottom_scattered;
            total[i] = l->total + w->reports[i].raman;
            if (direct) { /* not of the device */
                direct[i] = l->bottom_direct;
            }
            continue;
        }
        single[i] = w->light.part[PEL_WATER_SINGLE][i];
        second[i] = w->light.part[PEL_WATER_SECOND][i];
        higher[i] = w->light.part[PEL_WATER_HIGHER][i];
        bottom[i] = w->light.part[PEL_WATER_BOTTOM][i];
        total[i] = q->gpu ? single[i] + second[i] + higher[i] + bottom[i]
                          : w->total[i];
        if (direct) {
            direct[i] = w->bottom_direct[i];
        }
        if (error) {
            error[i] = w->error[i];
        }
    }
}

/* What the water is, at each wavelength. */
static void put_properties(const struct pel_optics_query *q, int count,
                           Pelagos__WaterLight *out)
{
    const struct pel_snapshot *s = q->snapshot;
    double *nm = LIST(wavelength), *absorption = LIST(absorption);
    double *scattering = LIST(scattering), *asymmetry = LIST(asymmetry);
    double *albedo = LIST(albedo), *water = LIST(water_absorption);
    double *algae = LIST(phytoplankton_absorption);
    double *dissolved = LIST(dissolved_absorption);
    double *detritus = LIST(detritus_absorption);
    double *molecular = LIST(molecular_scattering);
    double *particles = LIST(particle_scattering);
    double *back = LIST(backscattering);
    for (int i = 0; i < count; i++) {
        nm[i] = q->water.count ? q->water.first_nm + i * q->water.step_nm
                               : pel_water_wavelength_nm[i];
        struct pel_iop iop = pel_water_iop(&s->water_desc, nm[i]);
        struct pel_medium m =
            pel_water_medium_at(&s->water_desc, &s->water, nm[i]);
        absorption[i] = m.absorption;
        scattering[i] = m.scattering;
        asymmetry[i] = pel_medium_mean_cosine(&m);
        albedo[i] = m.albedo;
        water[i] = iop.water;
        algae[i] = iop.phytoplankton;
        dissolved[i] = iop.dissolved;
        detritus[i] = iop.detritus;
        molecular[i] = iop.molecular;
        particles[i] = iop.particles;
        back[i] = m.scattering * (1.0 - pel_medium_forward(&m));
    }
}

Pelagos__WaterLight *pel_optics_water_message(const struct pel_optics_query *q)
{
    const struct pel_water_report *reports = q->water.reports;
    Pelagos__WaterLight *out = (Pelagos__WaterLight *)pel_message_new(
        &pelagos__water_light__descriptor);
    const int count = q->water.count ? q->water.count : N;
    put_light(q, count, out);
    put_properties(q, count, out);
    if (reports) {
        double *rrs = LIST(remote_sensing_reflectance);
        double *reflectance = LIST(irradiance_reflectance);
        double *attenuation = LIST(diffuse_attenuation);
        double *raman = LIST(raman);
        for (int i = 0; i < count; i++) {
            rrs[i] = reports[i].rrs;
            reflectance[i] = reports[i].reflectance;
            attenuation[i] = reports[i].attenuation;
            raman[i] = reports[i].raman;
        }
    }
    out->has_depth = true;
    out->depth = q->environment.water.depth_m;
    out->has_orders = true;
    out->orders = (Pelagos__WaterOrders)q->environment.orders;
    return out;
}
