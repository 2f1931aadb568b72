#include "bridges/cigi_query.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "bridges/cigi_pose.h"
#include "scene/globe.h"
#include "scene/objectray.h"

#define SEA_WATER 1 /* material codes */
#define LAND 2
#define THING 3
#define NOBODY (-1)
#define SLOPE_M 1.0 /* over which land slopes */
#define STEP_M 0.25
#define MAX_STEPS 1024
#define MIN_STEPS 64
#define ALL_STEPS 8192 /* of 128 sights or fewer at once */
#define AT_ONCE 64
#define MET_M 1e-3
#define HALVINGS 40

bool pel_cigi_is_question(enum pel_cigi_kind kind)
{
    return kind == PEL_CIGI_KIND_HAT_REQUEST ||
           kind == PEL_CIGI_KIND_LOS_SEGMENT ||
           kind == PEL_CIGI_KIND_LOS_VECTOR ||
           kind == PEL_CIGI_KIND_POSITION_REQUEST ||
           kind == PEL_CIGI_KIND_ENVIRONMENT_REQUEST;
}

static bool is_sight(enum pel_cigi_kind kind)
{
    return kind == PEL_CIGI_KIND_LOS_SEGMENT ||
           kind == PEL_CIGI_KIND_LOS_VECTOR;
}

static bool in_reach(struct pel_vec3 at)
{
    return fabs(at.x) <= PEL_CIGI_REACH_M && fabs(at.y) <= PEL_CIGI_REACH_M;
}

/* A place given by three fields in a row. */
static bool place(const struct pel_cigi_moment *m,
                  const struct pel_cigi_packet *p, bool local, uint32_t entity,
                  enum pel_cigi_field first, struct pel_vec3 *out)
{
    double abc[3];
    for (unsigned i = 0; i < 3; i++) {
        abc[i] = pel_cigi_get(p, (enum pel_cigi_field)(first + i));
    }
    return pel_cigi_place(m->snapshot, m->time_s, local, entity, abc, out) &&
           in_reach(*out);
}

static void direction(const struct pel_cigi_moment *m, struct pel_vec3 at,
                      struct pel_vec3 n, double *azimuth, double *elevation)
{
    *azimuth =
        remainder(pel_cigi_true_deg(m->snapshot, at, atan2(n.x, n.y)), 360);
    *elevation = asin(pel_clamp(n.z, -1, 1)) / PEL_DEG;
}

/* What is on top at a place: the sea, or land that stands out of it, or a
 * thing. */
struct top {
    double height_m;
    struct pel_vec3 normal;
    unsigned material;
    uint32_t entity; /* of a thing */
};

static double top_m(const struct pel_surface_sample *s)
{
    /* no depth where the height field has no data: the sea */
    return -s->depth_m > s->height_m ? -s->depth_m : s->height_m;
}

static struct top top_of(const struct pel_cigi_moment *m, double x, double y,
                         const struct pel_surface_sample *s)
{
    if (top_m(s) == s->height_m) {
        return (struct top){ s->height_m, s->normal, SEA_WATER, 0 };
    }
    const struct pel_snapshot *at = m->snapshot;
    double east = pel_snapshot_depth(at, x + 0.5 * SLOPE_M, y) -
                  pel_snapshot_depth(at, x - 0.5 * SLOPE_M, y);
    double north = pel_snapshot_depth(at, x, y + 0.5 * SLOPE_M) -
                   pel_snapshot_depth(at, x, y - 0.5 * SLOPE_M);
    struct pel_vec3 n = { east / SLOPE_M, north / SLOPE_M, 1 };
    double length = sqrt(pel_vec3_dot(n, n));
    n = isfinite(length) ? pel_vec3_scale(n, 1 / length)
                         : (struct pel_vec3){ 0, 0, 1 };
    return (struct top){ -s->depth_m, n, LAND, 0 };
}

/* The same, or what stands above it. */
static struct top top_with_things(const struct pel_cigi_moment *m, double x,
                                  double y, const struct pel_surface_sample *s,
                                  long but)
{
    struct top top = top_of(m, x, y, s);
    const struct pel_vec3 above = { x, y, PEL_HIGHEST_M }, down = { 0, 0, -1 };
    struct pel_object_hit hit;
    if (pel_objects_cast(m->objects, m->object_count, but, above, down, 0,
                         PEL_HIGHEST_M - top.height_m, &hit)) {
        top = (struct top){ PEL_HIGHEST_M - hit.range_m, hit.normal, THING,
                            hit.id };
    }
    return top;
}

/* The entity in whose axes a request is: it does not hide things from itself.
 */
static long asker(bool local, uint32_t entity)
{
    return local ? (long)entity : NOBODY;
}

/* --- heights ------------------------------------------------------------- */

static struct pel_cigi_packet answer_height(const struct pel_cigi_moment *m,
                                            const struct pel_cigi_packet *p,
                                            bool valid, struct pel_vec3 at,
                                            const struct pel_surface_sample *s)
{
    bool extended = pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_TYPE) >= 2;
    long but = asker(pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_LOCAL) != 0,
                     (uint32_t)pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_ENTITY));
    struct top top = top_with_things(m, at.x, at.y, s, but);
    double hot = top.height_m, hat = at.z - hot;
    double id = pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_ID);
    struct pel_cigi_packet a = pel_cigi_packet_of(
        extended ? PEL_CIGI_KIND_HAT_EXTENDED : PEL_CIGI_KIND_HAT_RESPONSE);
    if (!extended) {
        bool wants_hot = pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_TYPE) == 1;
        pel_cigi_set(&a, PEL_CIGI_HAT_RESPONSE_ID, id);
        pel_cigi_set(&a, PEL_CIGI_HAT_RESPONSE_VALID, valid);
        pel_cigi_set(&a, PEL_CIGI_HAT_RESPONSE_TYPE, wants_hot);
        pel_cigi_set(&a, PEL_CIGI_HAT_RESPONSE_HOST_FRAME, m->host_frame & 15);
        if (valid) {
            pel_cigi_set(&a, PEL_CIGI_HAT_RESPONSE_HEIGHT,
                         wants_hot ? hot : hat);
        }
        return a;
    }
    pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_ID, id);
    pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_VALID, valid);
    pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_HOST_FRAME, m->host_frame & 15);
    if (valid) {
        double azimuth, elevation;
        direction(m, at, top.normal, &azimuth, &elevation);
        pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_HAT, hat);
        pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_HOT, hot);
        pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_MATERIAL, top.material);
        pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_AZIMUTH, azimuth);
        pel_cigi_set(&a, PEL_CIGI_HAT_EXTENDED_ELEVATION, elevation);
    }
    return a;
}

static struct pel_cigi_packet
answer_maritime(const struct pel_cigi_moment *m,
                const struct pel_cigi_packet *p,
                const struct pel_surface_sample *s)
{
    struct pel_cigi_packet a =
        pel_cigi_packet_of(PEL_CIGI_KIND_MARITIME_RESPONSE);
    pel_cigi_set(&a, PEL_CIGI_MARITIME_RESPONSE_ID,
                 pel_cigi_get(p, PEL_CIGI_ENVIRONMENT_REQUEST_ID));
    pel_cigi_set(&a, PEL_CIGI_MARITIME_RESPONSE_HEIGHT, s->height_m);
    pel_cigi_set(&a, PEL_CIGI_MARITIME_RESPONSE_TEMPERATURE,
                 m->world->water_temperature);
    pel_cigi_set(&a, PEL_CIGI_MARITIME_RESPONSE_CLARITY,
                 pel_cigi_clarity(m->snapshot->chlorophyll_mg_m3));
    return a;
}

static struct pel_cigi_packet answer_weather(const struct pel_cigi_moment *m,
                                             const struct pel_cigi_packet *p)
{
    const struct pel_snapshot *s = m->snapshot;
    struct pel_cigi_packet a =
        pel_cigi_packet_of(PEL_CIGI_KIND_WEATHER_RESPONSE);
    /* The scene holds the mathematical direction the wind goes to. */
    double from_deg = pel_cigi_wrap(270 - s->wind_to_rad / PEL_DEG);
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_ID,
                 pel_cigi_get(p, PEL_CIGI_ENVIRONMENT_REQUEST_ID));
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_HUMIDITY, m->world->humidity);
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_TEMPERATURE,
                 m->world->air_temperature);
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_VISIBILITY, s->visibility_m);
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_WIND, s->wind_mps);
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_WIND_DIRECTION, from_deg);
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_VERTICAL_WIND,
                 m->world->vertical_wind_mps);
    pel_cigi_set(&a, PEL_CIGI_WEATHER_RESPONSE_PRESSURE, m->world->pressure);
    return a;
}

/* --- lines of sight ------------------------------------------------------ */

struct ray {
    struct pel_vec3 from, along; /* unit */
    double begin_m, end_m;
};

struct hit {
    bool met;
    double range_m;
    struct pel_vec3 at;
    struct top top;
};

static struct pel_vec3 ray_at(const struct ray *ray, double range_m)
{
    return pel_globe_at(ray->from, pel_vec3_scale(ray->along, range_m));
}

/* Height of the ray above the sea at `count` ranges. */
static void clearances(const struct pel_cigi_moment *m, const struct ray *ray,
                       const double *range_m, size_t count, double *out)
{
    struct pel_vec2 points[AT_ONCE] = { 0 };
    struct pel_surface_sample samples[AT_ONCE];
    for (size_t i = 0; i < count; i++) {
        struct pel_vec3 at = ray_at(ray, range_m[i]);
        points[i] = (struct pel_vec2){ at.x, at.y };
        out[i] = at.z;
    }
    pel_snapshot_surface(m->snapshot, points, count, m->time_s, false, samples);
    for (size_t i = 0; i < count; i++) {
        out[i] -= top_m(&samples[i]);
    }
}

/* Ranges between which the ray is below `limit_m`: straight, over a surface
 * that falls away by r² / 2R. False: nowhere. */
static bool below(const struct ray *ray, double limit_m, double *from,
                  double *to)
{
    double flat = hypot(ray->along.x, ray->along.y);
    double a = flat * flat / (2 * PEL_EARTH_RADIUS), b = ray->along.z;
    double c = ray->from.z - limit_m, root = b * b - 4 * a * c;
    *from = -INFINITY;
    *to = INFINITY;
    if (a < 1e-15) { /* up or down */
        *(b > 0 ? to : from) = -c / b;
        return true;
    }
    if (root < 0) {
        return false;
    }
    /* The sum without cancellation first. */
    double q = -0.5 * (b + copysign(sqrt(root), b));
    double one = q / a, other = q != 0 ? c / q : 0;
    *from = fmin(one, other);
    *to = fmax(one, other);
    return true;
}

/* Cuts the ray to where waves or land can be; false: nowhere. */
static bool cut_to_waves(const struct pel_cigi_moment *m, struct ray *ray)
{
    /* The sphere falls less than the parabola of below(), by r^4 / 24 R³. */
    double far = ray->end_m / PEL_EARTH_RADIUS;
    double waves = pel_snapshot_sea(m->snapshot)->max_height_m + MET_M +
                   far * far * far * ray->end_m / 24;
    double level = m->snapshot->sea_level_m;
    double top = level + waves, low = level - waves, from, to;
    if (m->snapshot->seabed) {
        top = fmax(top, m->snapshot->seabed->highest_m + MET_M);
    }
    if (!below(ray, top, &from, &to)) {
        return false;
    }
    ray->begin_m = fmax(ray->begin_m, from);
    ray->end_m = fmin(ray->end_m, to);
    /* It has met the water before it is below all waves, or comes from there.
     */
    if (below(ray, low, &from, &to) && to > ray->begin_m && from < ray->end_m) {
        if (from >= ray->begin_m) {
            ray->end_m = from;
        } else {
            ray->begin_m = to;
        }
    }
    return ray->begin_m < ray->end_m;
}

/* The surface lies between two ranges; `above`: the nearer is above it. */
static void meet(const struct pel_cigi_moment *m, const struct ray *ray,
                 double near_m, double far_m, bool above, struct hit *out)
{
    for (int i = 0; i < HALVINGS && far_m - near_m > 0.1 * MET_M; i++) {
        double middle = 0.5 * (near_m + far_m), clear;
        clearances(m, ray, &middle, 1, &clear);
        if ((clear > 0) == above) {
            near_m = middle;
        } else {
            far_m = middle;
        }
    }
    out->met = true;
    out->range_m = far_m;
    out->at = ray_at(ray, far_m);
    struct pel_vec2 point = { out->at.x, out->at.y };
    struct pel_surface_sample sample;
    pel_snapshot_surface(m->snapshot, &point, 1, m->time_s, false, &sample);
    out->top = top_of(m, point.x, point.y, &sample);
}

/* The first place where the ray goes from one side of the surface to the
 * other. */
static struct hit follow(const struct pel_cigi_moment *m, struct ray ray)
{
    struct hit hit = { 0 };
    if (!cut_to_waves(m, &ray)) {
        return hit;
    }
    double length = ray.end_m - ray.begin_m;
    double step = fmax(STEP_M, length / (double)m->sight_steps);
    size_t steps = (size_t)ceil(length / step);
    double range[AT_ONCE], clear[AT_ONCE];
    double last_range = ray.begin_m, last;
    clearances(m, &ray, &last_range, 1, &last);
    for (size_t done = 0; done < steps;) {
        size_t count = steps - done < AT_ONCE ? steps - done : AT_ONCE;
        for (size_t i = 0; i < count; i++) {
            range[i] =
                fmin(ray.begin_m + (double)(done + i + 1) * step, ray.end_m);
        }
        clearances(m, &ray, range, count, clear);
        for (size_t i = 0; i < count; i++) {
            if ((clear[i] > 0) != (last > 0)) {
                meet(m, &ray, last_range, range[i], last > 0, &hit);
                return hit;
            }
            last = clear[i];
            last_range = range[i];
        }
        done += count;
    }
    return hit;
}

/* The first of sea, land and things. */
static struct hit look(const struct pel_cigi_moment *m, const struct ray *ray,
                       long but)
{
    struct hit hit = follow(m, *ray);
    struct pel_object_hit thing;
    if (pel_objects_cast(m->objects, m->object_count, but, ray->from,
                         ray->along, ray->begin_m,
                         hit.met ? hit.range_m : ray->end_m, &thing)) {
        hit = (struct hit){ .met = true, .range_m = thing.range_m };
        hit.at = ray_at(ray, thing.range_m);
        hit.top = (struct top){ hit.at.z, thing.normal, THING, thing.id };
    }
    return hit;
}

static struct pel_cigi_packet answer_sight(const struct pel_cigi_moment *m,
                                           double id, bool extended,
                                           bool segment, bool valid,
                                           const uint32_t *along,
                                           const struct hit *hit)
{
    struct pel_cigi_packet a = pel_cigi_packet_of(
        extended ? PEL_CIGI_KIND_LOS_EXTENDED : PEL_CIGI_KIND_LOS_RESPONSE);
    bool good = valid && (segment || hit->met);
    /* The plain answer's flag is that of its range. */
    bool ranged = valid && hit->met;
    bool visible = valid && !hit->met;
    bool thing = ranged && hit->top.material == THING;
    if (!extended) {
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_ID, id);
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_VALID, ranged);
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_VISIBLE, visible);
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_HOST_FRAME, m->host_frame & 15);
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_COUNT, 1);
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_RANGE, hit->range_m);
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_ENTITY_VALID, thing);
        pel_cigi_set(&a, PEL_CIGI_LOS_RESPONSE_ENTITY, hit->top.entity);
        return a;
    }
    pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_ID, id);
    pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_VALID, good);
    pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_RANGE_VALID, hit->met);
    pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_VISIBLE, visible);
    pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_HOST_FRAME, m->host_frame & 15);
    pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_COUNT, 1);
    if (hit->met) {
        double latitude, longitude, altitude = hit->at.z, azimuth, elevation;
        struct pel_vec3 from;
        struct pel_mat3 body;
        bool in_axes = along && pel_cigi_entity_axes(m->snapshot, *along,
                                                     m->time_s, &from, &body);
        if (in_axes) {
            struct pel_vec3 to =
                pel_vec3_add(hit->at, pel_vec3_scale(from, -1));
            latitude = pel_vec3_dot(to, body.x);
            longitude = pel_vec3_dot(to, body.y);
            altitude = pel_vec3_dot(to, body.z);
        } else {
            pel_cigi_geodetic(m->snapshot, hit->at, &latitude, &longitude);
        }
        if (in_axes) { /* from the bow to starboard, and up */
            struct pel_vec3 n = hit->top.normal;
            azimuth = atan2(pel_vec3_dot(n, body.y), pel_vec3_dot(n, body.x)) /
                      PEL_DEG;
            elevation =
                asin(pel_clamp(-pel_vec3_dot(n, body.z), -1, 1)) / PEL_DEG;
        } else {
            direction(m, hit->at, hit->top.normal, &azimuth, &elevation);
        }
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_RANGE, hit->range_m);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_ENTITY_VALID, thing);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_ENTITY, hit->top.entity);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_LATITUDE, latitude);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_LONGITUDE, longitude);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_ALTITUDE, altitude);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_MATERIAL, hit->top.material);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_AZIMUTH, azimuth);
        pel_cigi_set(&a, PEL_CIGI_LOS_EXTENDED_ELEVATION, elevation);
    }
    return a;
}

static struct pel_cigi_packet answer_segment(const struct pel_cigi_moment *m,
                                             const struct pel_cigi_packet *p)
{
    uint32_t source = (uint32_t)pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_ENTITY);
    uint32_t target =
        pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_DESTINATION_VALID) != 0
            ? (uint32_t)pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_DESTINATION_ENTITY)
            : source;
    bool local = pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_RESPONSE) != 0;
    bool from_local = pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_LOCAL) != 0;
    struct pel_vec3 from, to;
    struct hit hit = { 0 };
    bool valid =
        place(m, p, from_local, source, PEL_CIGI_LOS_SEGMENT_LATITUDE, &from) &&
        place(m, p,
              pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_DESTINATION_LOCAL) != 0,
              target, PEL_CIGI_LOS_SEGMENT_TO_LATITUDE, &to);
    if (valid) {
        struct pel_vec3 way = pel_globe_offset(from, to);
        double length = sqrt(pel_vec3_dot(way, way));
        if (length > MET_M) {
            struct ray ray = { from, pel_vec3_scale(way, 1 / length), 0,
                               length };
            hit = look(m, &ray, asker(from_local, source));
        }
    }
    return answer_sight(m, pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_ID),
                        pel_cigi_get(p, PEL_CIGI_LOS_SEGMENT_TYPE) != 0, true,
                        valid, local ? &source : NULL, &hit);
}

static struct pel_cigi_packet answer_vector(const struct pel_cigi_moment *m,
                                            const struct pel_cigi_packet *p)
{
    uint32_t entity = (uint32_t)pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_ENTITY);
    bool local = pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_LOCAL) != 0;
    bool answer_local = pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_RESPONSE) != 0;
    double azimuth = pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_AZIMUTH) * PEL_DEG;
    double elevation = pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_ELEVATION) * PEL_DEG;
    double least = fmax(pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_MIN_RANGE), 0);
    double most = pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_MAX_RANGE);
    struct pel_vec3 from, unused;
    struct pel_mat3 body;
    struct hit hit = { 0 };
    bool valid =
        place(m, p, local, entity, PEL_CIGI_LOS_VECTOR_LATITUDE, &from);
    if (valid) {
        struct pel_mat3 sight = pel_cigi_axes(azimuth, elevation, 0);
        struct pel_vec3 along = sight.x;
        if (local && pel_cigi_entity_axes(m->snapshot, entity, m->time_s,
                                          &unused, &body)) {
            /* Bow, starboard, down for north, east, down. */
            struct pel_vec3 in_body = { along.y, along.x, -along.z };
            along = pel_mat3_apply(&body, in_body);
        }
        struct ray ray = { from, along, least, fmin(most, PEL_CIGI_REACH_M) };
        hit = look(m, &ray, asker(local, entity));
    }
    return answer_sight(m, pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_ID),
                        pel_cigi_get(p, PEL_CIGI_LOS_VECTOR_TYPE) != 0, false,
                        valid, answer_local ? &entity : NULL, &hit);
}

/* --- positions ----------------------------------------------------------- */

static bool view_axes(const struct pel_cigi_moment *m, unsigned id,
                      struct pel_vec3 *at, struct pel_mat3 *axes)
{
    char name[PEL_NAME_SIZE];
    struct pel_camera c;
    pel_cigi_view_name(m->snapshot, id, name);
    int index = pel_snapshot_find_view(m->snapshot, name);
    if (index < 0) {
        return false;
    }
    pel_snapshot_camera(m->snapshot, (size_t)index, m->time_s, 0, 0, &c);
    *at = (struct pel_vec3){ c.east_m, c.north_m, c.altitude_m };
    *axes = (struct pel_mat3){ pel_vec3_scale(c.world_from_camera.z, -1),
                               c.world_from_camera.x,
                               pel_vec3_scale(c.world_from_camera.y, -1) };
    return true;
}

static bool object_axes(const struct pel_cigi_moment *m, unsigned class,
                        unsigned id, struct pel_vec3 *at, struct pel_mat3 *axes)
{
    if (class == 0) {
        return pel_cigi_entity_axes(m->snapshot, id, m->time_s, at, axes);
    }
    if (class == 2) {
        return view_axes(m, id, at, axes);
    }
    for (size_t i = 0; class == 3 && i < PEL_CIGI_VIEWS; i++) {
        const struct pel_cigi_view_memo *memo = &m->world->views[i];
        if (memo->used && memo->group == id && id != 0) {
            return view_axes(m, memo->id, at, axes);
        }
    }
    return false;
}

static bool answer_position(const struct pel_cigi_moment *m,
                            const struct pel_cigi_packet *p,
                            struct pel_cigi_packet *a)
{
    unsigned class = (unsigned)pel_cigi_get(p, PEL_CIGI_POSITION_REQUEST_CLASS);
    unsigned id = (unsigned)pel_cigi_get(p, PEL_CIGI_POSITION_REQUEST_ID);
    struct pel_vec3 at;
    struct pel_mat3 axes;
    double latitude, longitude, heading, pitch, roll;
    if (!object_axes(m, class, id, &at, &axes)) {
        return false;
    }
    pel_cigi_geodetic(m->snapshot, at, &latitude, &longitude);
    pel_cigi_angles(&axes, &heading, &pitch, &roll);
    *a = pel_cigi_packet_of(PEL_CIGI_KIND_POSITION_RESPONSE);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_ID, id);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_CLASS, class);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_LATITUDE, latitude);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_LONGITUDE, longitude);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_ALTITUDE, at.z);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_ROLL, roll / PEL_DEG);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_PITCH, pitch / PEL_DEG);
    pel_cigi_set(a, PEL_CIGI_POSITION_RESPONSE_YAW,
                 pel_cigi_true_deg(m->snapshot, at, heading));
    return true;
}

/* --- all ----------------------------------------------------------------- */

/* Where a request asks for the sea; false: it asks nothing of it. */
static bool asks_sea(const struct pel_cigi_moment *m,
                     const struct pel_cigi_packet *p, struct pel_vec3 *at)
{
    if (p->kind == PEL_CIGI_KIND_HAT_REQUEST) {
        return place(m, p, pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_LOCAL) != 0,
                     (uint32_t)pel_cigi_get(p, PEL_CIGI_HAT_REQUEST_ENTITY),
                     PEL_CIGI_HAT_REQUEST_LATITUDE, at);
    }
    return p->kind == PEL_CIGI_KIND_ENVIRONMENT_REQUEST &&
           place(m, p, false, 0, PEL_CIGI_ENVIRONMENT_REQUEST_LATITUDE, at);
}

static size_t answer_one(const struct pel_cigi_moment *m,
                         const struct pel_cigi_packet *p, bool on_sea,
                         struct pel_vec3 at,
                         const struct pel_surface_sample *sample,
                         struct pel_cigi_packet out[2])
{
    unsigned type;
    size_t count = 0;
    switch (p->kind) {
    case PEL_CIGI_KIND_HAT_REQUEST:
        out[0] = answer_height(m, p, on_sea, at, sample);
        return 1;
    case PEL_CIGI_KIND_LOS_SEGMENT:
        out[0] = answer_segment(m, p);
        return 1;
    case PEL_CIGI_KIND_LOS_VECTOR:
        out[0] = answer_vector(m, p);
        return 1;
    case PEL_CIGI_KIND_POSITION_REQUEST:
        return answer_position(m, p, &out[0]);
    case PEL_CIGI_KIND_ENVIRONMENT_REQUEST:
        type = (unsigned)pel_cigi_get(p, PEL_CIGI_ENVIRONMENT_REQUEST_TYPE);
        if ((type & 1) && on_sea) {
            out[count++] = answer_maritime(m, p, sample);
        }
        if (type & 4) {
            out[count++] = answer_weather(m, p);
        }
        return count;
    default:
        return 0;
    }
}

size_t pel_cigi_answer(const struct pel_cigi_moment *moment,
                       const struct pel_cigi_packet *const *questions,
                       size_t count, pel_cigi_emit emit, void *user)
{
    static struct pel_vec3 at[PEL_CIGI_MAX_QUESTIONS];
    static struct pel_vec2 points[PEL_CIGI_MAX_QUESTIONS];
    static struct pel_surface_sample samples[PEL_CIGI_MAX_QUESTIONS];
    static int sample_of[PEL_CIGI_MAX_QUESTIONS]; /* -1: none */
    static struct pel_object objects[PEL_MAX_ENTITIES];
    const struct pel_surface_sample none = { 0 };
    size_t asked = 0, answers = 0, sights = 0;
    struct pel_cigi_moment m = *moment;
    count = count < PEL_CIGI_MAX_QUESTIONS ? count : PEL_CIGI_MAX_QUESTIONS;
    for (size_t i = 0; i < count; i++) {
        sample_of[i] = -1;
        sights += is_sight(questions[i]->kind);
        if (asks_sea(moment, questions[i], &at[i])) {
            points[asked] = (struct pel_vec2){ at[i].x, at[i].y };
            sample_of[i] = (int)asked++;
        }
    }
    pel_snapshot_surface(moment->snapshot, points, asked, moment->time_s, false,
                         samples);
    m.objects = objects;
    m.object_count = sights + asked > 0
                         ? pel_snapshot_objects(moment->snapshot,
                                                moment->time_s, NULL, objects)
                         : 0;
    m.sight_steps = ALL_STEPS / (sights > 0 ? sights : 1);
    m.sight_steps = m.sight_steps < MIN_STEPS   ? MIN_STEPS
                    : m.sight_steps > MAX_STEPS ? MAX_STEPS
                                                : m.sight_steps;
    for (size_t i = 0; i < count; i++) {
        struct pel_cigi_packet out[2];
        bool on_sea = sample_of[i] >= 0;
        size_t made = answer_one(&m, questions[i], on_sea, at[i],
                                 on_sea ? &samples[sample_of[i]] : &none, out);
        for (size_t k = 0; k < made; k++) {
            answers += emit(user, &out[k]);
        }
    }
    return answers;
}
