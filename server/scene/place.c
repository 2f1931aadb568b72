#include "scene/place.h"

#include <math.h>

#include "optics/moon.h"
#include "scene/geodesy.h"
#include "scene/snapshot.h"

#define SUN_DISTANCE_M 149597870700.0

static double origin_lat(const struct pel_snapshot *s)
{
    return s->origin_latitude_rad / PEL_DEG;
}

static double origin_lon(const struct pel_snapshot *s)
{
    return s->origin_longitude_rad / PEL_DEG;
}

/* A vector of the Earth's axes in these. */
static struct pel_vec3 within(const struct pel_mat3 *axes, struct pel_vec3 v)
{
    return (struct pel_vec3){ pel_vec3_dot(axes->x, v),
                              pel_vec3_dot(axes->y, v),
                              pel_vec3_dot(axes->z, v) };
}

struct pel_place pel_place_square(double east_m, double north_m)
{
    struct pel_place place = {
        .far = hypot(east_m, north_m) > PEL_PLACE_MAP_M,
        .east_m = PEL_PLACE_SIDE_M * round(east_m / PEL_PLACE_SIDE_M),
        .north_m = PEL_PLACE_SIDE_M * round(north_m / PEL_PLACE_SIDE_M),
    };
    if (place.far) {
        place.east_m = east_m;
        place.north_m = north_m;
    }
    place.origin = place.east_m == 0 && place.north_m == 0;
    return place;
}

void pel_place_settle(const struct pel_snapshot *s, struct pel_place *place)
{
    double lat0 = origin_lat(s), lon0 = origin_lon(s);
    if (place->origin) {
        return;
    }
    pel_geo_from_local(lat0, lon0, place->east_m, place->north_m,
                       &place->latitude, &place->longitude);
    place->turned_rad =
        pel_geo_turn(lat0, lon0, place->latitude, place->longitude);
    const struct pel_mat3 there =
        pel_geo_local_axes(lat0, lon0, place->latitude, place->longitude);
    const struct pel_mat3 here = pel_geo_axes(lat0, lon0);
    place->turned =
        (struct pel_mat3){ within(&there, here.x), within(&there, here.y),
                           within(&there, here.z) };
    struct pel_vec3 from = pel_geo_earth(place->latitude, place->longitude, 0);
    struct pel_vec3 origin = pel_geo_earth(lat0, lon0, 0);
    place->from_m =
        within(&there, pel_vec3_add(origin, pel_vec3_scale(from, -1)));
}

void pel_place_of(const struct pel_snapshot *s, double east_m, double north_m,
                  struct pel_place *out)
{
    *out = pel_place_square(east_m, north_m);
    pel_place_settle(s, out);
}

static struct pel_vec3 body_from(const struct pel_place *place,
                                 struct pel_vec3 direction, double distance_m)
{
    return pel_vec3_add(
        pel_mat3_apply(&place->turned, pel_vec3_scale(direction, distance_m)),
        place->from_m);
}

struct pel_vec3 pel_place_sun(const struct pel_snapshot *s, double time_s,
                              const struct pel_place *place)
{
    struct pel_vec3 sun = pel_snapshot_sun(s, time_s);
    return place->origin
               ? sun
               : pel_vec3_normalize(body_from(place, sun, SUN_DISTANCE_M));
}

void pel_place_lights(const struct pel_snapshot *s, double time_s,
                      const struct pel_place *place,
                      struct pel_light out[PEL_LIGHTS])
{
    pel_snapshot_lights(s, time_s, out);
    if (place->origin) {
        return;
    }
    struct pel_light *sun = &out[PEL_LIGHT_SUN], *moon = &out[PEL_LIGHT_MOON];
    sun->direction =
        pel_vec3_normalize(body_from(place, sun->direction, SUN_DISTANCE_M));
    if (moon->strength > 0) { /* else there is none, wherever one stands */
        double before = PEL_MOON_RADIUS / sin(moon->radius_rad);
        struct pel_vec3 to = body_from(place, moon->direction, before);
        double distance = sqrt(pel_vec3_dot(to, to));
        moon->direction = pel_vec3_scale(to, 1 / distance);
        moon->strength *= (before / distance) * (before / distance);
        moon->radius_rad = asin(PEL_MOON_RADIUS / distance);
        moon->source = pel_mat3_apply(&place->turned, moon->source);
    }
}

static struct pel_mat3 turned(const struct pel_place *place,
                              const struct pel_mat3 *m)
{
    return (struct pel_mat3){ pel_mat3_apply(&place->turned, m->x),
                              pel_mat3_apply(&place->turned, m->y),
                              pel_mat3_apply(&place->turned, m->z) };
}

void pel_place_night(const struct pel_snapshot *s, double time_s,
                     const struct pel_place *place, struct pel_vec3 sun,
                     struct pel_night_sky *out)
{
    pel_snapshot_night(s, time_s, sun, out);
    if (out->on && !place->origin) {
        out->local = turned(place, &out->local);
        out->local_minute = turned(place, &out->local_minute);
    }
}

void pel_place_carry(const struct pel_snapshot *s,
                     const struct pel_place *place, struct pel_entity_state *e)
{
    double lat0 = origin_lat(s), lon0 = origin_lon(s);
    double lat, lon, east, north;
    pel_geo_from_local(lat0, lon0, e->east_m, e->north_m, &lat, &lon);
    pel_geo_to_local(place->latitude, place->longitude, lat, lon, &east,
                     &north);
    double sine = sin(place->turned_rad), cosine = cos(place->turned_rad);
    e->east_m = place->east_m + east * cosine + north * sine;
    e->north_m = place->north_m + north * cosine - east * sine;
    double turn =
        pel_geo_convergence(place->latitude, place->longitude, lat, lon) +
        place->turned_rad - pel_geo_convergence(lat0, lon0, lat, lon);
    e->heading_rad += turn;
    e->course_rad += turn;
}
