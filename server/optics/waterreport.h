/* What ocean optics asks of a water, at any wavelength from 400 to 700 nm: its
 * inherent properties by constituent and the apparent ones that follow, for a
 * Sun and no sky over a level surface. Any thread. */
#pragma once

#include "base/err.h"
#include "optics/waterbody.h"

struct pel_water_report {
    double nm;
    struct pel_iop iop;
    struct pel_medium medium;
    double mean_cosine;         /* of the scattering */
    struct pel_leaving leaving; /* radiance, for a beam of irradiance 1 */
    double raman;       /* besides: what came of light of a shorter wave (whose
                           Sun is as bright as above the air); with
                           PEL_ORDERS_ALL and the description's `raman` */
    double rrs;         /* both over the irradiance above the surface, 1/sr */
    double reflectance; /* irradiance up over down, just below the surface */
    double attenuation; /* K_d, the mean down to 1/K_d or the bottom, 1/m */
};

/* About 30 ms. `desc` is one that pel_water_resolve takes, `body` what that
 * makes of it. NO_MEMORY. With a Sun at the horizon rrs is 0. */
PEL_CHECK enum pel_err pel_water_report(const struct pel_water_desc *desc,
                                        const struct pel_water_body *body,
                                        double nm,
                                        const struct pel_geometry *geometry,
                                        enum pel_water_orders orders,
                                        struct pel_water_report *out);
