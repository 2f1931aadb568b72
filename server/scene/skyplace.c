#include "scene/skyplace.h"

#include <math.h>

#include "optics/colour.h"
#include "optics/rain.h"
#include "scene/geodesy.h"

void pel_sky_place(const Pelagos__Sky *sky, struct pel_snapshot *out)
{
    out->sun_azimuth_fixed = sky->has_sun_azimuth;
    out->sun_elevation_fixed = sky->has_sun_elevation;
    out->sun_azimuth_rad = sky->sun_azimuth * PEL_DEG;
    out->sun_elevation_rad = sky->sun_elevation * PEL_DEG;
    out->moon_azimuth_fixed = sky->has_moon_azimuth;
    out->moon_elevation_fixed = sky->has_moon_elevation;
    out->moon_phase_fixed = sky->has_moon_phase;
    out->moon_azimuth_rad = sky->moon_azimuth * PEL_DEG;
    out->moon_elevation_rad = sky->moon_elevation * PEL_DEG;
    out->moon_lit = sky->moon_phase;
    out->stars = sky->stars;
    out->rain_mm_h = sky->rain;
    out->snow_mm_h = sky->snow;
    out->visibility_m =
        pel_visibility_in_rain(sky->visibility, sky->rain, sky->snow);
    out->panorama_scale = sky->file_scale;
    out->panorama_azimuth_rad = sky->file_azimuth * PEL_DEG;
    out->panorama_sun = sky->file_sun == PELAGOS__PICTURE_SUN__IN_THE_PICTURE;
    out->panorama_dark = sky->file_sun == PELAGOS__PICTURE_SUN__NONE_SEEN;
}

/* Of the Sun's own, so that what comes through the air is the picture's. */
static double strength(const struct pel_snapshot *s, double sine)
{
    const struct pel_panorama *p = s->panorama;
    const struct pel_atmosphere_desc desc = { s->visibility_m };
    struct pel_atmosphere air;
    pel_atmosphere_init(&desc, &air);
    struct pel_rgb through = pel_atmosphere_transmittance(&air, 0.0, sine);
    struct pel_rgb e = pel_light_bodies[PEL_LIGHT_SUN].irradiance;
    e = (struct pel_rgb){ e.r * through.r, e.g * through.g, e.b * through.b };
    double shown =
        (0.2126 * p->sun[0] + 0.7152 * p->sun[1] + 0.0722 * p->sun[2]) *
        s->panorama_scale;
    return fmin(shown / fmax(pel_colour_illuminance(e, sine), 1e-3), 100.0);
}

void pel_panorama_lights(const struct pel_snapshot *s,
                         struct pel_light lights[PEL_LIGHTS])
{
    const struct pel_panorama *p = s->panorama;
    struct pel_light *sun = &lights[PEL_LIGHT_SUN];
    lights[PEL_LIGHT_MOON].strength = 0.0;
    if (s->panorama_dark || (s->panorama_sun && !p->has_sun)) {
        sun->strength = 0.0;
    } else if (s->panorama_sun) {
        double azimuth = s->panorama_azimuth_rad + p->sun_azimuth_rad;
        double sine = sin(p->sun_elevation_rad), cosine = sqrt(1 - sine * sine);
        sun->direction = (struct pel_vec3){ cosine * sin(azimuth),
                                            cosine * cos(azimuth), sine };
        sun->strength = strength(s, sine);
    }
}

#define SAME(ID)                                                               \
    _Static_assert((int)PEL_CLOUD_##ID == (int)PELAGOS__CLOUD_GENUS__##ID,     \
                   "the schema's CloudGenus is clouds.def")
#define PEL_CLOUD(ID, ...) SAME(ID);
#include "optics/clouds.def"

void pel_clouds_place(const Pelagos__Sky *sky, double wind_mps,
                      double wind_to_rad, struct pel_clouds *out)
{
    const double faster = 1.5; /* the wind there than at 10 m */
    enum pel_cloud_genus genus = (enum pel_cloud_genus)sky->cloud_genus;
    const struct pel_cloud_kind *kind = pel_cloud_kind(genus);
    double speed = sky->has_cloud_speed ? sky->cloud_speed : faster * wind_mps;
    double to = sky->has_cloud_direction
                    ? (270.0 - sky->cloud_direction) * PEL_DEG
                    : wind_to_rad;
    *out = (struct pel_clouds){
        .cover = sky->cloud_cover / 8,
        .genus = genus,
        .base_m = sky->has_cloud_base ? sky->cloud_base : kind->base_m,
        .thickness_m =
            sky->has_cloud_thickness ? sky->cloud_thickness : kind->thickness_m,
        .east_mps = speed * cos(to),
        .north_mps = speed * sin(to),
        .seed = sky->cloud_seed,
    };
}

static struct pel_fog fog_of(const Pelagos__State *state, const Pelagos__Fog *f,
                             const struct pel_snapshot *s)
{
    struct pel_fog fog = { .extinction = pel_fog_extinction(f->visibility),
                           .base_m = f->bottom,
                           .top_m = f->top,
                           .soft_m = f->edge };
    if (f->has_radius) {
        const Pelagos__Origin *o = state->origin;
        double speed = f->has_speed ? f->speed : s->wind_mps;
        double to = f->has_direction ? (270.0 - f->direction) * PEL_DEG
                                     : s->wind_to_rad;
        fog.radius_m = f->radius;
        pel_geo_to_local(o->latitude, o->longitude,
                         f->has_latitude ? f->latitude : o->latitude,
                         f->has_longitude ? f->longitude : o->longitude,
                         &fog.east_m, &fog.north_m);
        fog.east_mps = speed * cos(to);
        fog.north_mps = speed * sin(to);
        fog.east_m -= f->time * fog.east_mps;
        fog.north_m -= f->time * fog.north_mps;
    }
    return fog;
}

/* From the clouds' base, where there are some. */
static struct pel_lightning lightning_of(const Pelagos__State *state)
{
    const Pelagos__Sky *sky = state->sky;
    const Pelagos__Origin *o = state->origin;
    bool clouds = sky->cloud_cover > 0;
    const struct pel_cloud_kind *kind =
        pel_cloud_kind(clouds ? (enum pel_cloud_genus)sky->cloud_genus
                              : PEL_CLOUD_CUMULONIMBUS);
    struct pel_lightning l = {
        .per_minute = sky->lightning,
        .radius_m = sky->lightning_radius,
        .base_m = sky->has_cloud_base ? sky->cloud_base : kind->base_m,
        .thickness_m = !clouds                    ? 0
                       : sky->has_cloud_thickness ? sky->cloud_thickness
                                                  : kind->thickness_m,
        .turned_m = 1 / ((1 - PEL_CLOUD_ASYMMETRY) * kind->extinction),
        .seed = sky->cloud_seed,
    };
    pel_geo_to_local(
        o->latitude, o->longitude,
        sky->has_lightning_latitude ? sky->lightning_latitude : o->latitude,
        sky->has_lightning_longitude ? sky->lightning_longitude : o->longitude,
        &l.east_m, &l.north_m);
    return l;
}

void pel_fog_place(const Pelagos__State *state, struct pel_snapshot *out)
{
    out->lightning = lightning_of(state);
    out->fog_count = (int)state->sky->n_fog;
    for (int i = 0; i < out->fog_count; i++) {
        out->fog[i] = fog_of(state, state->sky->fog[i], out);
    }
}
