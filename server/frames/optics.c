#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/reserve.h"
#include "frames/core.h"
#include "message.h"
#include "optics/colour.h"

static void query_free(struct pel_optics_query *query)
{
    pel_snapshot_unref(query->snapshot);
    pelagos__optics_query__free_unpacked(query->asked, NULL);
    if (query->made) {
        pelagos__optics__free_unpacked(query->made, NULL);
    }
    free(query->water.reports);
    free(query);
}

static struct pel_vec3 towards(double elevation_deg, double azimuth_deg)
{
    double e = elevation_deg * PEL_DEG, a = azimuth_deg * PEL_DEG;
    return (struct pel_vec3){ cos(e) * sin(a), cos(e) * cos(a), sin(e) };
}

static void read_question(const Pelagos__OpticsQuery *from,
                          struct pel_optics_query *to)
{
    struct pel_probe *p = &to->probe;
    p->height_m = 2.0;
    p->slope_along = p->slope_cross = NAN; /* the sea's: pel_optics_settle */
    if (from->question_case == PELAGOS__OPTICS_QUERY__QUESTION_WATER) {
        pel_optics_read_water(from->water, &to->water);
        to->water.montecarlo = from->from == PELAGOS__OPTICS_SOURCE__MONTECARLO;
        return;
    }
    if (from->question_case == PELAGOS__OPTICS_QUERY__QUESTION_SKY) {
        const Pelagos__SkyQuery *q = from->sky;
        p->height_m = q->height;
        p->dir = towards(q->elevation, q->azimuth);
        return;
    }
    const Pelagos__BrdfQuery *q = from->brdf;
    struct pel_vec3 sun = to->environment.lights[PEL_LIGHT_SUN].direction;
    double opposite = atan2(-sun.x, -sun.y) / PEL_DEG;
    p->dir = towards(90.0 - q->view_zenith,
                     q->has_view_azimuth ? q->view_azimuth : opposite);
    p->slope_along = q->has_slope_along ? q->slope_along : p->slope_along;
    p->slope_cross = q->has_slope_cross ? q->slope_cross : p->slope_cross;
}

void pel_optics_settle(struct pel_optics_query *query)
{
    query->environment = pel_environment_of(query->snapshot, query->time_s);
    pel_environment_light(query->snapshot, &query->environment);
    read_question(query->asked, query);
    if (query->question != PELAGOS__OPTICS_QUERY__QUESTION_BRDF) {
        query->probe.slope_along = query->probe.slope_cross = 1e-8; /* unused */
        return;
    }
    const struct pel_sea *sea = pel_snapshot_sea(query->snapshot);
    struct pel_probe *p = &query->probe;
    double along =
        isnan(p->slope_along) ? sea->slope_variance_along : p->slope_along;
    double cross =
        isnan(p->slope_cross) ? sea->slope_variance_cross : p->slope_cross;
    p->slope_along = fmax(along, 1e-8);
    p->slope_cross = fmax(cross, 1e-8);
}

enum pel_err pel_frames_optics(struct pel_frames *frames,
                               const Pelagos__OpticsQuery *question,
                               pel_optics_callback done, void *user,
                               struct pel_fault *fault)
{
    if (frames->stopping) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    }
    if (frames->optics_count == PEL_MAX_OPTICS_QUERIES) {
        frames->stats.requests_refused++;
        return pel_fault_set(fault, PEL_ERR_BUSY,
                             "%d queries of optics are waiting already",
                             PEL_MAX_OPTICS_QUERIES);
    }
    if (!question->brdf) { /* any member of the union */
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "the query asks for nothing: give brdf, sky or "
                             "water");
    }
    if (question->from == PELAGOS__OPTICS_SOURCE__MONTECARLO &&
        question->question_case != PELAGOS__OPTICS_QUERY__QUESTION_WATER) {
        enum pel_err err = pel_fault_set(fault, PEL_ERR_INVALID,
                                         "from: MONTECARLO is for water alone");
        snprintf(fault->path, sizeof fault->path, "from");
        snprintf(fault->value, sizeof fault->value, "MONTECARLO");
        return err;
    }
    enum pel_err err = pel_optics_check_water(question, fault);
    if (err != PEL_OK) {
        return err;
    }
    const struct pel_snapshot *s = NULL;
    err = pel_scene_try_snapshot(frames->scene, question->patch, &s, fault);
    if (err != PEL_OK) {
        return err;
    }
    struct pel_optics_query *query = calloc(1, sizeof *query);
    if (!query) {
        pel_snapshot_unref(s);
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    Pelagos__OpticsQuery own = *question;
    own.patch = NULL;
    query->asked = (Pelagos__OpticsQuery *)pel_message_copy(&own.base);
    query->time_s =
        question->has_time ? question->time : pel_shown_time(frames);
    query->mail.kind = PEL_MAIL_OPTICS;
    query->snapshot = s;
    query->question = question->question_case;
    query->gpu = question->from == PELAGOS__OPTICS_SOURCE__GPU;
    query->done = done;
    query->user = user;
    frames->optics[frames->optics_count++] = query;
    if (query->gpu) {
        pel_devices_push_optics(frames->devices, query);
    } else {
        pel_encoder_pool_push_optics(frames->pool, query);
    }
    return PEL_OK;
}

static struct pel_vec3 in_wind(const struct pel_environment *env,
                               struct pel_vec3 v)
{
    double c = cos(env->wind_to_rad), s = sin(env->wind_to_rad);
    return (struct pel_vec3){ c * v.x + s * v.y, c * v.y - s * v.x, v.z };
}

static struct pel_rgb plus(struct pel_rgb a, struct pel_rgb b)
{
    return (struct pel_rgb){ a.r + b.r, a.g + b.g, a.b + b.b };
}

/* Of the Moon's light above the air, over the Sun's. */
static struct pel_rgb moon_over_sun(const struct pel_environment *env)
{
    const struct pel_rgb m = pel_light_bodies[PEL_LIGHT_MOON].irradiance,
                         s = pel_light_bodies[PEL_LIGHT_SUN].irradiance;
    double k = env->lights[PEL_LIGHT_MOON].strength;
    return (struct pel_rgb){ k * m.r / s.r, k * m.g / s.g, k * m.b / s.b };
}

static void add_night(struct pel_optics_query *query)
{
    const struct pel_environment *env = &query->environment;
    bool sky = query->question == PELAGOS__OPTICS_QUERY__QUESTION_SKY;
    struct pel_night_map *map =
        sky && env->night.on ? malloc(sizeof *map) : NULL;
    if (map) {
        struct pel_rgb *radiance = &query->answer.sky.radiance;
        pel_night_map_make(&env->night, env->visibility_m, map);
        query->night = pel_night_seen(map, query->probe.dir, false);
        *radiance =
            plus(*radiance, pel_night_seen(map, query->probe.dir, query->gpu));
        free(map);
    }
}

static enum pel_err sky_of_all(const struct pel_environment *env,
                               const struct pel_probe *p,
                               struct pel_sky_terms *out)
{
    enum pel_err err = pel_sky_terms(env->visibility_m, p->height_m, p->dir,
                                     env->lights[PEL_LIGHT_SUN].direction, out);
    if (err == PEL_OK && env->lights[PEL_LIGHT_MOON].strength > 0.0) {
        struct pel_sky_terms moon;
        struct pel_rgb k = moon_over_sun(env);
        err = pel_sky_terms(env->visibility_m, p->height_m, p->dir,
                            env->lights[PEL_LIGHT_MOON].direction, &moon);
        const struct pel_rgb r = moon.radiance;
        out->radiance = plus(
            out->radiance, (struct pel_rgb){ k.r * r.r, k.g * r.g, k.b * r.b });
    }
    return err;
}

void pel_optics_reference(struct pel_optics_query *query)
{
    const struct pel_environment *env = &query->environment;
    const struct pel_probe *p = &query->probe;
    pel_optics_settle(query);
    if (query->question == PELAGOS__OPTICS_QUERY__QUESTION_SKY) {
        query->err = sky_of_all(env, p, &query->answer.sky);
    } else if (query->question == PELAGOS__OPTICS_QUERY__QUESTION_WATER) {
        query->err = pel_optics_water(query);
    } else {
        pel_brdf_terms(in_wind(env, p->dir),
                       in_wind(env, env->lights[PEL_LIGHT_SUN].direction),
                       p->slope_along, p->slope_cross, env->water.index[1],
                       &query->answer.sea);
    }
    if (query->err != PEL_OK) {
        pel_fault_set(&query->fault, query->err, "out of memory");
    }
    pel_optics_conclude(query);
}

/* --- the answer as a message ---------------------------------------------- */

#define SET(message, field, value)                                             \
    ((message)->has_##field = true, (message)->field = (value))

static Pelagos__Brdf *brdf_message(const struct pel_optics_query *q)
{
    const struct pel_brdf_terms *t = &q->answer.sea;
    Pelagos__Brdf *out =
        (Pelagos__Brdf *)pel_message_new(&pelagos__brdf__descriptor);
    SET(out, slope_along, q->probe.slope_along);
    SET(out, slope_cross, q->probe.slope_cross);
    SET(out, half_zenith, acos(pel_clamp(t->half_cosine, -1.0, 1.0)) / PEL_DEG);
    SET(out, lambda_view, t->lambda_view);
    SET(out, lambda_sun, t->lambda_light);
    SET(out, shadowing, 1.0 / (1.0 + t->lambda_view + t->lambda_light));
    SET(out, mean_fresnel, t->mean_fresnel);
    SET(out, seen_fresnel, t->seen_fresnel);
    SET(out, brdf, t->brdf);
    SET(out, reflected_sun, t->reflected_sun);
    SET(out, slope_density, t->slope_density);
    SET(out, fresnel, t->fresnel);
    return out;
}

static void set_list(size_t *n, double **list, struct pel_rgb c)
{
    double *v = pel_sure_malloc(3 * sizeof *v);
    v[0] = c.r;
    v[1] = c.g;
    v[2] = c.b;
    *n = 3;
    *list = v;
}

static double luminance_of(const struct pel_environment *env,
                           struct pel_rgb radiance)
{
    struct pel_light lights[PEL_LIGHTS];
    memcpy(lights, env->lights, sizeof lights);
    struct pel_lights_shown shown = pel_lights_order(lights);
    double m[9];
    pel_lights_colours(lights, shown.lit, env->night.on, m);
    const double c[3] = { radiance.r, radiance.g, radiance.b };
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        sum += (0.2126 * m[k] + 0.7152 * m[3 + k] + 0.0722 * m[6 + k]) * c[k];
    }
    return sum;
}

static Pelagos__SkyLight *sky_message(const struct pel_optics_query *q)
{
    const struct pel_sky_terms *t = &q->answer.sky;
    Pelagos__SkyLight *out =
        (Pelagos__SkyLight *)pel_message_new(&pelagos__sky_light__descriptor);
    struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { q->environment.visibility_m };
    pel_atmosphere_init(&desc, &air);
    struct pel_rgb e = air.solar_irradiance, s = t->sun_transmittance;
    e = (struct pel_rgb){ e.r * s.r, e.g * s.g, e.b * s.b };
    const double *nm = pel_water_wavelength_nm;
    set_list(&out->n_wavelength, &out->wavelength,
             (struct pel_rgb){ nm[0], nm[1], nm[2] });
    set_list(&out->n_radiance, &out->radiance, t->radiance);
    set_list(&out->n_transmittance, &out->transmittance, t->transmittance);
    set_list(&out->n_sun_transmittance, &out->sun_transmittance, s);
    set_list(&out->n_sun_irradiance, &out->sun_irradiance, e);
    const struct pel_environment *env = &q->environment;
    set_list(&out->n_night_radiance, &out->night_radiance, q->night);
    if (env->lights[PEL_LIGHT_MOON].strength > 0.0) {
        struct pel_rgb k = moon_over_sun(env);
        e = pel_atmosphere_sun_irradiance(
            &air, q->probe.height_m, env->lights[PEL_LIGHT_MOON].direction);
        e = (struct pel_rgb){ k.r * e.r, k.g * e.g, k.b * e.b };
        set_list(&out->n_moon_irradiance, &out->moon_irradiance, e);
    }
    SET(out, luminance, luminance_of(env, t->radiance));
    return out;
}

static Pelagos__Optics *message(const struct pel_optics_query *q)
{
    Pelagos__Optics *out =
        (Pelagos__Optics *)pel_message_new(&pelagos__optics__descriptor);
    struct pel_vec3 sun = q->environment.lights[PEL_LIGHT_SUN].direction;
    double azimuth = atan2(sun.x, sun.y) / PEL_DEG;
    bool water = q->question == PELAGOS__OPTICS_QUERY__QUESTION_WATER;
    SET(out, from,
        q->gpu                         ? PELAGOS__OPTICS_SOURCE__GPU
        : water && q->water.montecarlo ? PELAGOS__OPTICS_SOURCE__MONTECARLO
                                       : PELAGOS__OPTICS_SOURCE__REFERENCE);
    if (water) {
        SET(out, sun_elevation, 90.0 - q->water.at.sun_zenith_rad / PEL_DEG);
        out->answer_case = PELAGOS__OPTICS__ANSWER_WATER;
        out->water = pel_optics_water_message(q);
        return out;
    }
    SET(out, sun_elevation, asin(pel_clamp(sun.z, -1.0, 1.0)) / PEL_DEG);
    SET(out, sun_azimuth, azimuth < 0.0 ? azimuth + 360.0 : azimuth);
    const struct pel_light *moon = &q->environment.lights[PEL_LIGHT_MOON];
    if (moon->strength > 0.0) {
        struct pel_vec3 to = moon->direction;
        azimuth = atan2(to.x, to.y) / PEL_DEG;
        SET(out, moon_elevation, asin(pel_clamp(to.z, -1.0, 1.0)) / PEL_DEG);
        SET(out, moon_azimuth, azimuth < 0.0 ? azimuth + 360.0 : azimuth);
        SET(out, moon_phase, 0.5 - 0.5 * pel_vec3_dot(moon->source, to));
    }
    if (q->question == PELAGOS__OPTICS_QUERY__QUESTION_SKY) {
        out->answer_case = PELAGOS__OPTICS__ANSWER_SKY;
        out->sky = sky_message(q);
    } else {
        out->answer_case = PELAGOS__OPTICS__ANSWER_BRDF;
        out->brdf = brdf_message(q);
    }
    return out;
}

void pel_optics_conclude(struct pel_optics_query *query)
{
    add_night(query);
    query->made = query->err == PEL_OK ? message(query) : NULL;
}

static void forget(struct pel_frames *frames, struct pel_optics_query *query)
{
    unsigned last = --frames->optics_count;
    for (unsigned i = 0; i < last; i++) {
        if (frames->optics[i] == query) {
            frames->optics[i] = frames->optics[last];
            break;
        }
    }
}

void pel_optics_answer(struct pel_frames *frames,
                       struct pel_optics_query *query)
{
    forget(frames, query);
    if (query->made && query->gpu) {
        query->made->device = pel_sure_strdup(pel_frames_device(frames));
    }
    query->done(query->user, query->err, &query->fault, query->made);
    query_free(query);
}

void pel_optics_finish_all(struct pel_frames *frames, bool joined)
{
    struct pel_fault fault;
    pel_fault_set(&fault, PEL_ERR_CONFLICT, "the daemon is stopping");
    while (frames->optics_count > 0) {
        struct pel_optics_query *query = frames->optics[--frames->optics_count];
        query->done(query->user, PEL_ERR_CONFLICT, &fault, NULL);
        if (joined) { /* else a thread that hangs may still write to it */
            query_free(query);
        }
    }
}
