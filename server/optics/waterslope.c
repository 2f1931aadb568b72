#include "optics/waterslope.h"

#include <math.h>

#include "base/vec.h"

struct pel_slope_change pel_slope_change(const struct pel_medium *m,
                                         enum pel_water_orders orders,
                                         const struct pel_slope_place *p)
{
    if (orders != PEL_ORDERS_ALL) {
        return (struct pel_slope_change){ p->depth_m, p->depth_m, 1.0 };
    }
    double turned =
        m->scattering * (1.0 - pel_medium_mean_cosine(m)) * p->depth_m;
    double reach = PEL_SLOPE_ABSORBED * m->absorption * p->depth_m + turned;
    double under = 1.0 - p->under_m / p->depth_m;
    double steep = p->slope * p->slope / (1.0 + p->slope * p->slope);
    double volume = reach * (PEL_SLOPE_VOLUME_UNDER * under +
                             PEL_SLOPE_VOLUME_STEEP * steep);
    double bottom = reach * (PEL_SLOPE_BOTTOM_UNDER * under +
                             PEL_SLOPE_BOTTOM_STEEP * steep);
    return (struct pel_slope_change){
        p->depth_m * (1.0 - pel_clamp(volume, PEL_SLOPE_SHIFT_LEAST,
                                      PEL_SLOPE_SHIFT_MOST)),
        p->depth_m * (1.0 - pel_clamp(bottom, PEL_SLOPE_SHIFT_LEAST,
                                      PEL_SLOPE_SHIFT_MOST)),
        1.0 / (1.0 + turned),
    };
}

/* What a level's maps hold for a line of sight. */
static double look_up(const struct pel_water_kernel *k,
                      enum pel_kernel_part part, const struct pel_geometry *at,
                      const double beams[PEL_KERNEL_NODES],
                      const double views[PEL_KERNEL_NODES], int wavelength)
{
    double sum = 0.0;
    for (int m = 0; m < PEL_KERNEL_MODES; m++) {
        double mode = cos(m * at->azimuth_rad);
        for (int i = 0; i < PEL_KERNEL_NODES * PEL_KERNEL_NODES; i++) {
            int b = i / PEL_KERNEL_NODES, v = i % PEL_KERNEL_NODES;
            sum += mode * beams[b] * views[v] *
                   (double)k->response[part][m][b][v][wavelength];
        }
    }
    return fmax(sum, 0.0);
}

/* Level of a depth, and the pair of levels around it. */
static double level_of(const struct pel_water_depths *d, double depth_m)
{
    return (d->levels - 1) * log(depth_m / d->first_m) /
           log(d->last_m / d->first_m);
}

void pel_slope_light(const struct pel_water_body *body,
                     const struct pel_water_depths *depths,
                     const struct pel_water_kernel *levels,
                     const struct pel_geometry *at,
                     const struct pel_slope_place *place,
                     struct pel_slope_light *out)
{
    struct pel_interface f = pel_interface_at(at);
    double beams[PEL_KERNEL_NODES], views[PEL_KERNEL_NODES];
    pel_kernel_weights(sqrt(1.0 - f.sun_mu * f.sun_mu), beams);
    pel_kernel_weights(sqrt(1.0 - f.view_mu * f.view_mu), views);
    /* One pair of levels for all wavelengths, around the middle one's. */
    struct pel_medium green = pel_water_medium(body, 1);
    double middle =
        fmin(pel_slope_change(&green, PEL_ORDERS_ALL, place).bottom_m,
             depths->last_m);
    double level = pel_clamp(level_of(depths, middle), 0, depths->levels - 1);
    int below = (int)fmin(floor(level), depths->levels - 2);
    double z[2] = { pel_water_depth(depths, below),
                    pel_water_depth(depths, below + 1) };
    for (int c = 0; c < PEL_WATER_WAVELENGTHS; c++) {
        struct pel_medium m = pel_water_medium(body, c);
        struct pel_slope_change change =
            pel_slope_change(&m, PEL_ORDERS_ALL, place);
        double way =
            (m.absorption + m.scattering) * (1.0 / f.sun_mu + 1.0 / f.view_mu);
        double beam = m.albedo / PEL_PI * f.sun_mu * PEL_KERNEL_LEAVING;
        double volume[2], scattered[2];
        for (int k = 0; k < 2; k++) {
            const struct pel_water_kernel *at_level = &levels[below + k];
            m.depth_m = z[k];
            volume[k] =
                look_up(at_level, PEL_KERNEL_BEYOND, at, beams, views, c) +
                pel_transport_single(&m, at, PEL_EXTINCTION_FULL) *
                    PEL_KERNEL_LEAVING / (f.leaving * f.beam);
            scattered[k] =
                fmax(look_up(at_level, PEL_KERNEL_BOTTOM, at, beams, views, c),
                     1e-12);
        }
        /* A power of the depth times e^(−fall depth). */
        double fall =
            (m.absorption + m.scattering * (1.0 - pel_medium_mean_cosine(&m))) *
            (1.0 / f.sun_mu + 1.0 / f.view_mu);
        double at_m = fmin(change.bottom_m, depths->last_m);
        double part = pel_clamp(level_of(depths, at_m) - below, -1.0, 2.0);
        double low = log(scattered[0]) + fall * z[0];
        double high = log(scattered[1]) + fall * z[1];
        double around = exp(low + part * (high - low) - fall * at_m);
        around = fmin(around, beam / (1.0 - 0.5 * m.albedo));
        double direct = beam * exp(-way * fmin(place->depth_m, depths->last_m));
        double gain = place->gain * place->lit;
        double bottom =
            direct * gain + around * (1.0 + change.kept * (gain - 1.0));
        part = pel_clamp(
            level_of(depths, fmin(change.volume_m, depths->last_m)) - below,
            -1.0, 2.0);
        double scale = f.beam * f.leaving / PEL_KERNEL_LEAVING;
        out[c].volume =
            scale * fmax(volume[0] + part * (volume[1] - volume[0]), 0.0);
        out[c].bottom = scale * bottom;
    }
}
