#include "optics/waterreport.h"

#include <math.h>

#include "base/vec.h"
#include "optics/linear.h"
#include "optics/ordinates.h"

/* `up` [W]: irradiance going up besides. */
static void attenuate(struct pel_ordinates *o, double sun_zenith_rad, double up,
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
    r->reflectance = (at[0].up + up) / at[0].down;
}

/* Radiance that leaves, and the irradiance that goes up below the surface,
 * from the mode 0 of views at Gauss nodes. */
static enum pel_err add_raman(struct pel_ordinates *o,
                              const struct pel_raman *raman,
                              const struct pel_geometry *geometry,
                              struct pel_water_report *r, double *up)
{
    enum { VIEWS = 12 };
    struct pel_interface face = pel_interface_at(geometry);
    double node[VIEWS], weight[VIEWS], found[PEL_RAMAN_MODES * VIEWS];
    double seen[PEL_RAMAN_MODES], depth = r->medium.depth_m;
    *up = 0.0;
    if (raman->strength == 0.0) {
        return PEL_OK;
    }
    pel_gauss_legendre(VIEWS, 0.0, 1.0, node, weight);
    enum pel_err err = pel_raman_respond(o, &r->medium, raman, &depth, 1,
                                         &face.sun_mu, 1, node, VIEWS, found);
    if (!err) {
        err = pel_raman_respond(o, &r->medium, raman, &depth, 1, &face.sun_mu,
                                1, &face.view_mu, 1, seen);
    }
    for (int i = 0; i < VIEWS && !err; i++) {
        *up += 2.0 * PEL_PI * weight[i] * node[i] * face.beam * found[i];
    }
    for (int m = 0; m < PEL_RAMAN_MODES && !err; m++) {
        r->raman +=
            face.leaving * face.beam * seen[m] * cos(m * geometry->azimuth_rad);
    }
    return err;
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
    struct pel_raman raman = { 0 };
    double up = 0.0;
    if (orders == PEL_ORDERS_ALL) {
        raman = pel_water_raman_at(desc, body, nm);
    }
    enum pel_err err = add_raman(o, &raman, geometry, out, &up);
    attenuate(o, geometry->sun_zenith_rad, up, out);
    pel_ordinates_destroy(o);
    if (!err) {
        err = pel_transport_leaving(&out->medium, geometry, orders,
                                    &out->leaving);
    }
    double above = cos(geometry->sun_zenith_rad);
    out->rrs = above > 1e-9 ? (out->leaving.total + out->raman) / above : 0.0;
    return err;
}
