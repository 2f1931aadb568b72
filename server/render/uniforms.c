#include "render/uniforms.h"

#include <math.h>

#include "optics/atmosphere.h"
#include "optics/brdf.h"
#include "optics/colour.h"
#include "optics/water.h"

static struct pel_vec4 vec4(double x, double y, double z, double w)
{
    return (struct pel_vec4){ (float)x, (float)y, (float)z, (float)w };
}

static struct pel_vec4 rgb4(struct pel_rgb c, double w)
{
    return vec4(c.r, c.g, c.b, w);
}

void pel_fill_frame(const struct pel_environment *env,
                    struct pel_block_frame *out)
{
    struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { env->visibility_m };
    pel_atmosphere_init(&desc, &air);
    double r0 = (PEL_WATER_INDEX - 1.0) / (PEL_WATER_INDEX + 1.0);
    const struct pel_rgb unit = { 1.0, 1.0, 1.0 };
    double m[9];
    pel_colour_matrix(m);
    *out = (struct pel_block_frame){
        .sun = vec4(env->sun.x, env->sun.y, env->sun.z, PEL_SUN_ANGULAR_RADIUS),
        .solar = rgb4(air.solar_irradiance, PEL_SUN_SOLID_ANGLE),
        .wind = vec4(cos(env->wind_to_rad), sin(env->wind_to_rad),
                     env->sea->slope_variance_along,
                     env->sea->slope_variance_cross),
        .rayleigh = rgb4(air.rayleigh, air.rayleigh_height_m),
        .mie = vec4(air.mie_extinction, air.mie_scattering, air.mie_height_m,
                    air.mie_g),
        .ozone = rgb4(air.ozone, air.ozone_center_m),
        .planet = vec4(PEL_EARTH_RADIUS, PEL_ATMOSPHERE_RADIUS,
                       air.ozone_width_m, r0 * r0),
        .water = rgb4(pel_water_radiance(env->chlorophyll_mg_m3, unit), 0.0),
        .red = vec4(m[0], m[1], m[2], 0.0),
        .green = vec4(m[3], m[4], m[5], 0.0),
        .blue = vec4(m[6], m[7], m[8], 0.0),
    };
}

void pel_fill_eye(double height_m, double table_height_m,
                  const struct pel_mesh *mesh, struct pel_block_eye *out)
{
    double dip = acos(PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + height_m));
    *out = (struct pel_block_eye){
        .eye = vec4(height_m, dip, mesh ? mesh->column_rad : 0.0,
                    mesh ? mesh->columns_around : 1.0),
        .lut = vec4(table_height_m, 0.0, 0.0, 0.0),
    };
}

void pel_fill_waves(const struct pel_environment *env, double east_m,
                    double north_m, struct pel_block_waves *out)
{
    *out = (struct pel_block_waves){ 0 };
    double wind_x = cos(env->wind_to_rad), wind_y = sin(env->wind_to_rad);
    for (int i = 0; i < env->sea->count && i < PEL_WAVE_LIMIT; i++) {
        const struct pel_wave *w = &env->sea->waves[i];
        double k = hypot(w->kx, w->ky);
        double ux = w->kx / k, uy = w->ky / k;
        double h = w->amplitude;
        double phase = (w->kx * east_m + w->ky * north_m -
                        w->omega * env->time_s + w->phase) /
                       (2.0 * PEL_PI);
        double kh = k * h;
        double variance = kh * kh / (1.0 + sqrt(1.0 - w->chop * w->chop * kh * kh));
        double along = ux * wind_x + uy * wind_y;
        double fold = w->chop * kh;
        out->wave_phase[i] =
            vec4(w->kx / (2.0 * PEL_PI), w->ky / (2.0 * PEL_PI),
                 phase - floor(phase), 2.0 * PEL_PI / k);
        out->wave_fold[i] =
            vec4(fold * ux * ux, fold * ux * uy, fold * uy * uy, k * k / 12.0);
        out->wave_slope[i] = vec4(h * w->kx, h * w->ky, variance * along * along,
                                  variance * (1.0 - along * along));
        out->wave_shift[i] = vec4(w->chop * h * ux, w->chop * h * uy, h, 0.0);
    }
}

double pel_pixel_pitch(double tan_low, double tan_high, uint32_t pixels)
{
    int exponent;
    double mantissa = frexp((tan_high - tan_low) / pixels, &exponent);
    return ldexp(round(ldexp(mantissa, 20)), exponent - 20);
}

/* Place of an edge on the lattice: whole when it is meant to be, else in
 * 1/256 of a pixel, the rasteriser's own step. */
static double lattice_place(double tangent, double pitch)
{
    double place = tangent / pitch;
    double whole = round(place);
    return fabs(place - whole) < 1e-2 ? whole : round(place * 256.0) / 256.0;
}

void pel_fill_view(const struct pel_camera *camera, struct pel_block_view *out)
{
    double px =
        pel_pixel_pitch(camera->tan_left, camera->tan_right, camera->width);
    double py =
        pel_pixel_pitch(camera->tan_bottom, camera->tan_top, camera->height);
    const struct pel_mat3 *m = &camera->world_from_camera;
    *out = (struct pel_block_view){
        .right = vec4(m->x.x, m->x.y, m->x.z, PEL_N_MIN),
        .up = vec4(m->y.x, m->y.y, m->y.z, 1.0 / (PEL_N_MAX - PEL_N_MIN)),
        .back = vec4(m->z.x, m->z.y, m->z.z, 1.0),
        .pixel = vec4(px, py, lattice_place(camera->tan_left, px),
                      lattice_place(-camera->tan_top, py)),
        .size = vec4(camera->width, camera->height, camera->exposure_ev,
                     camera->auto_exposure ? 1.0 : 0.0),
    };
}
