#include "optics/waterreport.h"

#include <math.h>

#include "optics/ordinates.h"

static void attenuate(struct pel_ordinates *o, double sun_zenith_rad,
                      struct pel_water_report *r)
{
    const struct pel_medium *m = &r->medium;
    struct pel_field at[2] = { { 0 } };
    /* Twice is enough: K_d hardly changes with depth. */
    double k = m->absorption + (1.0 - pel_medium_forward(m)) * m->scattering;
    for (int i = 0; i < 3; i++) {
        double depths[2] = { 0.0, fmin(1.0 / k, m->depth_m) };
        pel_ordinates_field(o, m, sun_zenith_rad, depths, 2, at);
        if (!(at[1].down > 0.0)) {
            return; /* no light */
        }
        k = log(at[0].down / at[1].down) / depths[1];
    }
    r->attenuation = k;
    r->reflectance = at[0].up / at[0].down;
}

enum pel_err pel_water_report(const struct pel_water_desc *desc,
                              const struct pel_water_body *body, double nm,
                              const struct pel_geometry *geometry,
                              enum pel_water_orders orders,
                              struct pel_water_report *out)
{
    *out = (struct pel_water_report){
        .nm = nm,
        .iop = pel_water_iop(desc, nm),
        .medium = pel_water_medium_at(desc, body, nm),
    };
    out->mean_cosine = pel_medium_mean_cosine(&out->medium);
    struct pel_ordinates *o = pel_ordinates_create(16, 1e-6);
    if (!o) {
        return PEL_ERR_NO_MEMORY;
    }
    attenuate(o, geometry->sun_zenith_rad, out);
    pel_ordinates_destroy(o);
    enum pel_err err =
        pel_transport_leaving(&out->medium, geometry, orders, &out->leaving);
    double above = cos(geometry->sun_zenith_rad);
    out->rrs = above > 1e-9 ? out->leaving.total / above : 0.0;
    return err;
}
