#include "render/uniforms.h"

#include <math.h>
#include <string.h>

#include "ocean/areas.h"
#include "ocean/foam.h"
#include "ocean/wash.h"
#include "optics/atmosphere.h"
#include "optics/brdf.h"
#include "optics/colour.h"
#include "optics/facets.h"
#include "optics/moon.h"
#include "render/panoramamap.h"
#include "render/waterlight.h"

static struct pel_vec4 vec4(double x, double y, double z, double w)
{
    return (struct pel_vec4){ (float)x, (float)y, (float)z, (float)w };
}

struct pel_vec4 pel_water_levels(const struct pel_environment *env, double last)
{
    struct pel_water_depths d = pel_water_light_depths(env);
    return vec4(
        d.levels, log2(d.first_m),
        d.levels > 1 ? (d.levels - 1) / log2(d.last_m / d.first_m) : 0.0, last);
}

static struct pel_vec4 rgb4(struct pel_rgb c, double w)
{
    return vec4(c.r, c.g, c.b, w);
}

static double moon_alpha(const struct pel_light *at)
{
    return acos(pel_clamp(-pel_vec3_dot(at->source, at->direction), -1, 1));
}

static struct pel_shader_light light_of(const struct pel_environment *env,
                                        int i)
{
    const struct pel_light *at = &env->lights[i];
    const struct pel_light_body *body = &pel_light_bodies[at->body];
    double radius = pel_light_radius(at);
    double grown = radius / body->angular_radius_rad;
    struct pel_rgb limb = body->limb;
    if (at->body == PEL_LIGHT_MOON) {
        double lit = pel_moon_disc(moon_alpha(at));
        limb = (struct pel_rgb){ 2.0 / fmax(lit, 1e-6), 0, 0 };
    }
    /* A uniform disc has a quarter of its squared radius as variance an axis;
     * facets turn half as far as what they mirror. */
    double disc = radius * radius / 16.0;
    const struct pel_rgb e = { at->strength * body->irradiance.r,
                               at->strength * body->irradiance.g,
                               at->strength * body->irradiance.b };
    return (struct pel_shader_light){
        .direction =
            vec4(at->direction.x, at->direction.y, at->direction.z, radius),
        .irradiance = rgb4(e, body->solid_angle_sr * grown * grown),
        .limb = rgb4(limb, disc),
    };
}

/* Of its night side: what the Earth lights does not wane as the Sun's light
 * does. */
static struct pel_vec4 source_of(const struct pel_environment *env, int i)
{
    const struct pel_light *at = &env->lights[i];
    if (at->body != PEL_LIGHT_MOON) {
        return vec4(0, 0, 0, 0);
    }
    double alpha = moon_alpha(at);
    double full = pel_moon_strength(0.0, PEL_MOON_DISTANCE),
           now = pel_moon_strength(alpha, PEL_MOON_DISTANCE);
    double dark =
        pel_moon_earthlight(alpha) * full / now * pel_moon_disc(alpha);
    return vec4(at->source.x, at->source.y, at->source.z, fmax(dark, 1e-9));
}

/* A half holds down to 6e-5 whole: so much light as by day at a thousand lx. */
static struct pel_vec4 dusk_of(const struct pel_environment *env)
{
    double level = pel_lights_level(env->lights, env->lit, env->night.on);
    double power = level > 0.0 && level < 1e3 ? round(log2(1e3 / level)) : 0.0;
    power = fmin(power, 40.0);
    return vec4(exp2(power), exp2(-power), 0, 0);
}

/* Whole lives of glints since the start; other seeds begin elsewhere. */
static double glint_lives(const struct pel_environment *env)
{
    double whole = floor(env->time_s / PEL_GLINT_LIFE) +
                   40503.0 * (env->sea->desc.seed & 0xffff);
    return whole - 16777216.0 * floor(whole / 16777216.0);
}

/* Means over all places. */
static struct pel_vec4 cloud_light(const struct pel_environment *env)
{
    enum { RANKS = 64 };
    const struct pel_clouds *c = &env->clouds;
    const struct pel_cloud_kind *kind = pel_cloud_kind(c->genus);
    double mu = fmax(env->lights[0].direction.z, 0.05), all = 0, beam = 0;
    for (int i = 0; i < RANKS; i++) {
        double thick = pel_cloud_thick(c, (i + 0.5) / RANKS);
        double depth = kind->extinction * c->thickness_m * thick;
        all += pel_cloud_through((1 - PEL_CLOUD_ASYMMETRY) * depth, mu) / RANKS;
        beam += exp(-depth / mu) / RANKS;
    }
    return vec4(all, beam, kind->grain, 0);
}

static void fill_clouds(const struct pel_environment *env,
                        struct pel_block_frame *out)
{
    const struct pel_clouds *c = &env->clouds;
    const struct pel_cloud_kind *kind = pel_cloud_kind(c->genus);
    if (c->cover > 0) {
        out->cloud_shape =
            vec4(pel_cloud_bound(c), 1 / (kind->rise * c->cover),
                 kind->extinction, fmin(kind->soft_m, 0.5 * c->thickness_m));
        out->cloud_size =
            vec4(c->base_m, c->thickness_m, 1 / kind->tile_m, kind->along);
        out->cloud_light = cloud_light(env);
    }
}

void pel_fill_frame(const struct pel_environment *env,
                    struct pel_block_frame *out)
{
    struct pel_atmosphere air;
    const struct pel_atmosphere_desc desc = { env->visibility_m };
    pel_atmosphere_init(&desc, &air);
    const double *n = env->water.index;
    const double r0 = (PEL_WATER_INDEX - 1.0) / (PEL_WATER_INDEX + 1.0);
    double lives = env->time_s / PEL_GLINT_LIFE;
    double m[9];
    pel_lights_colours(env->lights, env->lit, env->night.on, m);
    *out = (struct pel_block_frame){
        .wind = vec4(cos(env->wind_to_rad), sin(env->wind_to_rad),
                     env->sea->slope_variance_along,
                     env->sea->slope_variance_cross),
        .rayleigh = rgb4(air.rayleigh, air.rayleigh_height_m),
        .mie = vec4(air.mie_extinction, air.mie_scattering, air.mie_height_m,
                    air.mie_g),
        .ozone = rgb4(air.ozone, air.ozone_center_m),
        .planet = vec4(PEL_EARTH_RADIUS, PEL_ATMOSPHERE_RADIUS,
                       air.ozone_width_m, r0 * r0),
        .refraction = vec4(n[0] * n[0], n[1] * n[1], n[2] * n[2], 0.0),
        .water = pel_water_levels(env, env->no_air ? 1.0 : 0.0),
        .red = vec4(m[0], m[1], m[2], glint_lives(env)),
        .green = vec4(m[3], m[4], m[5], lives - floor(lives)),
        .blue = vec4(m[6], m[7], m[8], env->sparkle ? PEL_GLINT_SHARE : 0.0),
    };
    out->dusk = dusk_of(env);
    if (env->panorama) {
        pel_panorama_fill(env, m, out->panorama);
    }
    fill_clouds(env, out);
    struct pel_folding fold = pel_sea_folding(env->sea);
    out->crests = vec4(0.75 * fold.finest, 0.75 * fold.more, 0.0, 0.0);
    const struct pel_foam *foam = env->sea->foam;
    if (foam) {
        out->crests.z = (float)(PEL_FOAM_THIN + PEL_FOAM_BLOWN * foam->blown);
        out->whitecaps = vec4(1.0 / foam->deviation,
                              PEL_FOAM_STREAK_WEIGHT *
                                  sqrt(foam->spread / PEL_FOAM_STREAK_SHARE),
                              1.0 / (PEL_FOAM_GRAIN_M * foam->drawn_out),
                              foam->coverage * PEL_FOAM_DENSE);
    }
    for (int i = 0; i < PEL_LIGHTS; i++) {
        out->lights[i] = light_of(env, i);
        out->sources[i] = source_of(env, i);
    }
}

/* Of a place, in tiles along and across the wind. */
static struct pel_vec2 in_tiles(double along_m, double across_m,
                                double tile_along_m, double tile_across_m)
{
    double u = along_m / tile_along_m, v = across_m / tile_across_m;
    return (struct pel_vec2){ u - floor(u), v - floor(v) };
}

void pel_fill_cloud_eye(const struct pel_environment *env, double x_m,
                        double y_m, struct pel_block_eye *out)
{
    const struct pel_clouds *c = &env->clouds;
    const struct pel_cloud_kind *kind = pel_cloud_kind(c->genus);
    double speed = hypot(c->east_mps, c->north_mps);
    double ex = speed > 0 ? c->east_mps / speed : cos(env->wind_to_rad);
    double ey = speed > 0 ? c->north_mps / speed : sin(env->wind_to_rad);
    if (c->cover > 0) {
        double period_m = PEL_CLOUD_PERIOD * kind->tile_m;
        struct pel_vec2 at = in_tiles(x_m * ex + y_m * ey, y_m * ex - x_m * ey,
                                      period_m * kind->along, period_m);
        out->eye_clouds =
            vec4(PEL_CLOUD_PERIOD * at.x, PEL_CLOUD_PERIOD * at.y, ex, ey);
    }
}

/* Layers, then banks. */
void pel_fill_fog(const struct pel_environment *env, double east_m,
                  double north_m, struct pel_block_eye *out)
{
    int count = 0;
    double deep = 0;
    for (int banks = 0; banks < 2; banks++) {
        for (int i = 0; i < env->fog_count; i++) {
            struct pel_shader_fog *f = &out->fogs[count];
            if ((env->fog[i].radius_m > 0) != banks) {
                continue;
            }
            count++;
            *f = pel_fog_seen(&env->fog[i], env->time_s, east_m, north_m);
            if (!banks) {
                double above, below;
                pel_fog_column(f, (struct pel_vec3){ 0, 0, 0 }, &above, &below);
                deep += above;
                f->place.x =
                    (float)pel_fog_slant(f, env->lights[0].direction.z);
                f->place.y =
                    (float)pel_fog_slant(f, env->lights[1].direction.z);
            }
        }
    }
    out->fog_layers = vec4(deep, 0, 0, 0);
}

static float stepped(float metres)
{
    return (float)PEL_FOG_STEP_M * roundf(metres / (float)PEL_FOG_STEP_M);
}

void pel_fill_fog_own(const struct pel_environment *env,
                      struct pel_block_eye *out)
{
    pel_fill_fog(env, env->own_east_m, env->own_north_m, out);
    for (int i = 0; i < env->fog_count; i++) {
        struct pel_vec4 *place = &out->fogs[i].place;
        if (place->z > 0) {
            place->x = stepped(place->x);
            place->y = stepped(place->y);
        }
    }
}

void pel_fill_grain(const struct pel_foam *foam, double wind_to_rad,
                    double east_m, double north_m, struct pel_block_eye *out)
{
    double c = cos(wind_to_rad), s = sin(wind_to_rad);
    double u = east_m * c + north_m * s, v = north_m * c - east_m * s;
    struct pel_vec2 grain =
        in_tiles(u, v, PEL_FOAM_GRAIN_M * foam->drawn_out, PEL_FOAM_GRAIN_M);
    struct pel_vec2 streaks =
        in_tiles(u, v, PEL_FOAM_STREAK_ALONG_M, PEL_FOAM_STREAK_ACROSS_M);
    out->grain = vec4(grain.x, grain.y, streaks.x, streaks.y);
    double bend = u / PEL_FOAM_BEND_ALONG_M + v / PEL_FOAM_BEND_ACROSS_M;
    out->bends = vec4(bend - floor(bend), 0.0, 0.0, 0.0);
}

void pel_fill_spray(const struct pel_foam *foam, double height_m,
                    struct pel_block_eye *out)
{
    if (foam && height_m > 0.0) {
        out->lut.z = (float)pel_foam_spray(foam, height_m);
    }
}

void pel_fill_eye(double height_m, double table_height_m,
                  const struct pel_mesh *mesh, struct pel_block_eye *out)
{
    double above = fmax(height_m, 0.0);
    double dip = acos(PEL_EARTH_RADIUS / (PEL_EARTH_RADIUS + above));
    *out = (struct pel_block_eye){
        .eye = vec4(height_m, dip, mesh ? mesh->column_rad : 0.0,
                    mesh ? mesh->columns_around : 1.0),
        .lut = vec4(table_height_m, 0.0, 0.0, 0.0),
    };
}

static void fill_corners(const struct pel_area_desc *a, struct pel_vec4 *out,
                         double *radius_m)
{
    for (int i = 0; i < a->corner_count; i++) {
        float x = (float)a->corner[i].x, y = (float)a->corner[i].y;
        if (i % 2) {
            out[i / 2].z = x;
            out[i / 2].w = y;
        } else {
            out[i / 2].x = x;
            out[i / 2].y = y;
        }
        *radius_m = fmax(*radius_m, hypot(a->corner[i].x, a->corner[i].y));
    }
}

void pel_fill_areas(const struct pel_environment *env, double east_m,
                    double north_m, struct pel_block_areas *out)
{
    const struct pel_sea_desc *d = &env->sea->desc;
    struct pel_slopes below =
        pel_sea_slopes_below(env->sea, PEL_AREA_SHORTER_M);
    *out = (struct pel_block_areas){
        .area_count = vec4(d->area_count, 0.0, below.along, below.cross),
    };
    for (int i = 0; i < d->area_count; i++) {
        const struct pel_area_desc *a = &d->area[i];
        struct pel_vec2 at = pel_area_place(a, env->time_s);
        double radius_m = a->corner_count ? 0.0 : a->radius_m;
        fill_corners(a, &out->area_corners[i * PEL_AREA_CORNERS / 2],
                     &radius_m);
        out->areas[i].place =
            vec4(at.x - east_m, at.y - north_m, radius_m, a->edge_m);
        out->areas[i].shape = vec4(a->factor - 1.0, a->corner_count, 0.0, 0.0);
    }
}

static struct pel_vec2 tiles_at(double east_m, double north_m, double tile_m)
{
    return in_tiles(east_m, north_m, tile_m, tile_m);
}

/* Of a layer DEEP_M thick that scatters BACK of the light back: what comes up
 * through it has been coloured by the water on both ways; n⁻² of it gets out in
 * a direction. */
static double aerated(const struct pel_environment *env, int i)
{
    const double deep_m = 4.0, back = 0.22;
    double way = 2.0 * deep_m * env->water.absorption[i];
    double index = env->water.index[i];
    return back * -expm1(-way) / way / (PEL_PI * index * index);
}

void pel_fill_wash(const struct pel_environment *env, double east_m,
                   double north_m, struct pel_block_wash *out)
{
    const struct pel_wash *w = env->wash;
    size_t nodes = PEL_WASH_NODE_WORDS * w->count;
    struct pel_vec2 fine = tiles_at(east_m, north_m, PEL_FOAM_GRAIN_M);
    struct pel_vec2 torn = tiles_at(east_m, north_m, PEL_WASH_GRAIN_M);
    double one = east_m * PEL_WASH_BEND_1_X + north_m * PEL_WASH_BEND_1_Y;
    double two = east_m * PEL_WASH_BEND_2_X + north_m * PEL_WASH_BEND_2_Y;
    *out = (struct pel_block_wash){
        .wash_box = vec4(w->west_m - east_m, w->south_m - north_m,
                         w->cells_per_m, (double)(nodes + w->listed)),
        .wash_size = vec4(w->columns, w->rows, (double)nodes, 0.0),
        .wash_grain = vec4(fine.x, fine.y, torn.x, torn.y),
        .wash_bends = vec4(one - floor(one), two - floor(two), 0.0, 0.0),
        .wash_water =
            vec4(aerated(env, 0), aerated(env, 1), aerated(env, 2), 0.0),
    };
}

/* A fraction that stays one when single precision holds it with a whole part
 * below 512. */
static double below_one(double fraction)
{
    return fmin(fraction, 1.0 - 0x1p-14);
}

void pel_fill_waves(const struct pel_environment *env, double east_m,
                    double north_m, struct pel_block_waves *out)
{
    *out = (struct pel_block_waves){ 0 };
    for (int i = 0; i < env->sea->count && i < PEL_WAVE_LIMIT; i++) {
        const struct pel_wave *w = &env->sea->waves[i];
        double phase = (w->kx * east_m + w->ky * north_m -
                        w->omega * env->time_s + w->phase) /
                       (2.0 * PEL_PI);
        double start = w->wander_x * east_m + w->wander_y * north_m -
                       w->wander_rate * env->time_s + w->wander_start - 0.5;
        struct pel_shader_wave *to = &out->waves[i];
        to->phase =
            vec4(w->kx / (2.0 * PEL_PI), w->ky / (2.0 * PEL_PI),
                 below_one(phase - floor(phase)) + w->chop * PEL_CHOP_STEPS,
                 2.0 * PEL_PI / hypot(w->kx, w->ky));
        to->wander = vec4(w->wander_x, w->wander_y,
                          below_one(start - floor(start)) + w->swing / PEL_PI,
                          2.0 * PEL_PI * w->amplitude);
    }
}

void pel_fill_cascades(const struct pel_cascades *cascades, double east_m,
                       double north_m, struct pel_block_cascades *out)
{
    double x = east_m, y = north_m;
    for (int i = 0; i < PEL_CASCADES; i++) {
        const struct pel_cascade *c = &cascades->cascade[i];
        const struct pel_shears *s = &cascades->shears;
        double turns[2];
        for (int j = 0; j < 2; j++) {
            int at = 2 * i + j;
            /* The shaders leave out the constant 1/8 and add 1/2. */
            double t = s->fx[at] * east_m + s->fy[at] * north_m + 0.75;
            turns[j] = t - floor(t);
            x -= 0.125 * s->v[at][0];
            y -= 0.125 * s->v[at][1];
        }
        double u = (x * c->turn_cos + y * c->turn_sin) / c->length_m;
        double v = (y * c->turn_cos - x * c->turn_sin) / c->length_m;
        out->cascades[i].place =
            vec4(c->turn_cos, c->turn_sin, 1.0 / c->length_m, c->texel_m);
        out->cascades[i].offset =
            vec4(u - floor(u), v - floor(v), turns[0], turns[1]);
        double fx = s->fx[2 * i], fy = s->fy[2 * i];
        double shear = hypot(s->v[2 * i][0], s->v[2 * i][1]);
        out->cascades[i].shear = vec4(fx, fy, shear / hypot(fx, fy), 0.0);
    }
}

void pel_fill_facets(struct pel_block_facets *out)
{
    for (int i = 0; i <= PEL_FACET_STEPS; i++) {
        double q = (double)i / PEL_FACET_STEPS, z[4], w[4];
        pel_facets_seen(i < PEL_FACET_STEPS ? q / (1.0 - q) : INFINITY, z, w);
        out->facets[i].node = vec4(z[0], z[1], z[2], z[3]);
        out->facets[i].weight = vec4(w[0], w[1], w[2], w[3]);
    }
}

void pel_fill_variance(const struct pel_sea *sea,
                       const struct pel_filter *filter,
                       struct pel_variance out[PEL_VARIANCE_COUNT])
{
    for (int i = 0; i < PEL_VARIANCE_COUNT; i++) {
        double l = exp2(PEL_VARIANCE_FIRST + i / PEL_VARIANCE_STEPS);
        struct pel_slopes left = pel_sea_slopes_left(sea, filter, l);
        out[i] = (struct pel_variance){ (float)left.along, (float)left.cross };
    }
}

void pel_pair_variance(const struct pel_variance table[PEL_VARIANCE_COUNT],
                       struct pel_variance out[PEL_VARIANCE_COUNT - 1][2])
{
    for (int i = 0; i + 1 < PEL_VARIANCE_COUNT; i++) {
        out[i][0] = table[i];
        out[i][1] = table[i + 1];
    }
}

void pel_fill_foam_left(const struct pel_sea *sea,
                        const struct pel_filter *filter,
                        struct pel_variance out[PEL_VARIANCE_COUNT])
{
    for (int i = 0; i < PEL_VARIANCE_COUNT; i++) {
        double l = exp2(PEL_VARIANCE_FIRST + i / PEL_VARIANCE_STEPS);
        double left = sqrt(pel_foam_left(sea, filter, l));
        out[i] = (struct pel_variance){ (float)left, 0.0f };
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

_Static_assert(PEL_SENSOR_NONE == 0 && PEL_SENSOR_ON == PEL_SHADER_SENSOR_ON &&
                   PEL_SENSOR_OFF == PEL_SHADER_SENSOR_OFF,
               "the kinds that shaders/lib/tone.glsl knows");
#define DROPOUT (1.0 / 64) /* of the lines */

static double cloud_node_px(double pitch)
{
    return fmin(fmax(floor(PEL_CLOUD_NODE / pitch), 1), PEL_CLOUD_NODE_PX);
}

void pel_fill_view(const struct pel_camera *camera,
                   const struct pel_filter *filter, struct pel_block_view *out)
{
    double px =
        pel_pixel_pitch(camera->tan_left, camera->tan_right, camera->width);
    double py =
        pel_pixel_pitch(camera->tan_bottom, camera->tan_top, camera->height);
    const struct pel_mat3 *m = &camera->world_from_camera;
    const struct pel_sensor *sensor = &camera->sensor;
    *out = (struct pel_block_view){
        .right = vec4(m->x.x, m->x.y, m->x.z, filter->n_min),
        .up =
            vec4(m->y.x, m->y.y, m->y.z, 1.0 / (filter->n_max - filter->n_min)),
        .back = vec4(m->z.x, m->z.y, m->z.z, pel_filter_slope_bias(filter)),
        .pixel = vec4(px, py, lattice_place(camera->tan_left, px),
                      lattice_place(-camera->tan_top, py)),
        .size = vec4(camera->width, camera->height, camera->antialiasing,
                     1.0 / cloud_node_px(px)),
        .sensor =
            vec4(sensor->kind, sensor->scale, sensor->offset, sensor->noise),
        .sensor_seed = vec4(sensor->seed & 0xffff, sensor->seed >> 16,
                            sensor->dropout ? DROPOUT : 0, camera->tone),
    };
}

static struct pel_shader_sight window_of(const struct pel_sight *w)
{
    const struct pel_mat3 *m = &w->world_from_camera;
    return (struct pel_shader_sight){
        .right = vec4(m->x.x, m->x.y, m->x.z, w->tan_left),
        .up = vec4(m->y.x, m->y.y, m->y.z, w->tan_right),
        .back = vec4(m->z.x, m->z.y, m->z.z, w->tan_top),
        .below = vec4(w->tan_bottom, 0.0, 0.0, 0.0),
    };
}

void pel_fill_sights(const struct pel_environment *env,
                     const struct pel_camera *camera,
                     struct pel_block_sighted *out)
{
    const struct pel_camera *c = camera;
    const struct pel_sight own = { c->world_from_camera, c->altitude_m,
                                   c->tan_left,          c->tan_right,
                                   c->tan_top,           c->tan_bottom };
    int count = c->sight_count;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < (count ? count : 1); i++) {
        out->sights[i] = window_of(count ? &c->sights[i] : &own);
    }
    out->meter = vec4(c->auto_exposure ? (count ? count : 1) : 0,
                      c->exposure_ev, c->tone, c->glare);
    if (c->vision == PEL_VISION_EYE) {
        double rods[3];
        pel_lights_rods(env->lights, env->lit, env->night.on, rods);
        out->rod = vec4(rods[0], rods[1], rods[2], c->vision);
    }
}
