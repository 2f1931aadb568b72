#include "shiplight.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846
#define SUN_RADIUS_RAD 4.652e-3

static void unit(double *v)
{
    double length = sqrt(sea_dot(v, v));
    for (int i = 0; i < 3; i++) {
        v[i] /= length;
    }
}

/* Two directions square to a unit vector and each other. */
static void frame(const double *n, double *a, double *b)
{
    double other[3] = { fabs(n[0]) < 0.6, fabs(n[0]) >= 0.6, 0 };
    double d = sea_dot(other, n);
    for (int i = 0; i < 3; i++) {
        a[i] = other[i] - d * n[i];
    }
    unit(a);
    b[0] = n[1] * a[2] - n[2] * a[1];
    b[1] = n[2] * a[0] - n[0] * a[2];
    b[2] = n[0] * a[1] - n[1] * a[0];
}

/* By the cosine to n. */
static void scatter(const double *n, struct sea_random *random, double *out)
{
    double a[3], b[3], u = sea_random_unit(random);
    double angle = 2 * PI * sea_random_unit(random), r = sqrt(u);
    frame(n, a, b);
    for (int i = 0; i < 3; i++) {
        out[i] =
            r * cos(angle) * a[i] + r * sin(angle) * b[i] + sqrt(1 - u) * n[i];
    }
    unit(out);
}

static void to_sun(const struct sea_sky *sky, struct sea_random *random,
                   double *s)
{
    double a[3], b[3], r = SUN_RADIUS_RAD * sqrt(sea_random_unit(random));
    double angle = 2 * PI * sea_random_unit(random);
    frame(sky->sun, a, b);
    for (int i = 0; i < 3; i++) {
        s[i] = sky->sun[i] + r * (cos(angle) * a[i] + sin(angle) * b[i]);
    }
    unit(s);
}

/* Refracts a unit direction at a surface of unit normal against it, into a
 * medium `index` times as dense. */
static void refract(const double *direction, const double *normal, double index,
                    double *out)
{
    double cosine = -sea_dot(direction, normal);
    double inside = sqrt(1 - (1 - cosine * cosine) / (index * index));
    for (int i = 0; i < 3; i++) {
        out[i] = direction[i] / index + (cosine / index - inside) * normal[i];
    }
    unit(out);
}

static int is_free(const struct ship_mesh *mesh, const double *from,
                   const double *direction)
{
    return !ship_mesh_cast(mesh, from, direction, INFINITY, NULL);
}

static void along(const double *from, const double *direction, double distance,
                  double *out)
{
    for (int i = 0; i < 3; i++) {
        out[i] = from[i] + distance * direction[i];
    }
}

/* --- light on the ship --------------------------------------------------- */

/* Times pi, of light from `to`. */
static double paint(const struct ship_hit *hit, const double *direction,
                    const double *to)
{
    const double normal = 0.04; /* reflectance of facets square to the light */
    double half[3], from = -sea_dot(direction, hit->normal);
    for (int i = 0; i < 3; i++) {
        half[i] = to[i] - direction[i];
    }
    unit(half);
    double facing = fmax(sea_dot(half, to), 0);
    double facets = normal + (1 - normal) * pow(1 - facing, 5);
    double sum = fmax(from + sea_dot(to, hit->normal), 1e-3);
    return hit->albedo + facets * 0.5 / sum;
}

/* The Sun from above, and from its image in a flat sea. */
static void add_suns(const struct ship_scene *scene, const double *point,
                     const double *direction, const struct ship_hit *hit,
                     struct sea_random *random,
                     double (*radiance)[SHIP_CHANNELS])
{
    for (int s = 0; s < scene->suns; s++) {
        double to[3], light = 0;
        to_sun(&scene->sky[s], random, to);
        double cosine = sea_dot(to, hit->normal);
        if (cosine > 0 && is_free(&scene->mesh, point, to)) {
            light += cosine * paint(hit, direction, to);
        }
        double down[3] = { to[0], to[1], -to[2] };
        cosine = sea_dot(down, hit->normal);
        double far = point[2] / to[2], sea[3];
        if (cosine > 0 && point[2] > 0 &&
            !ship_mesh_cast(&scene->mesh, point, down, far, NULL)) {
            along(point, down, far, sea);
            if (is_free(&scene->mesh, sea, to)) {
                light += cosine * paint(hit, direction, down) *
                         sea_fresnel(to[2], scene->index);
            }
        }
        for (int c = 0; c < SHIP_CHANNELS; c++) {
            radiance[s][c] += scene->irradiance[c] / PI * light;
        }
    }
}

/* Radiance that comes from a direction to a point, other than the Sun's. */
static void look_around(const struct ship_scene *scene, const double *point,
                        const double *direction, int turns,
                        struct sea_random *random,
                        double (*radiance)[SHIP_CHANNELS])
{
    struct ship_hit hit;
    double from[3], to[3], weight = 1, own[SHIP_SUNS][SHIP_CHANNELS] = { 0 };
    memcpy(from, point, sizeof(from));
    memcpy(to, direction, sizeof(to));
    double sea = to[2] < 0 ? from[2] / -to[2] : INFINITY;
    int met = ship_mesh_cast(&scene->mesh, from, to, sea, &hit);
    if (!met && to[2] < 0) { /* a flat sea */
        weight = sea_fresnel(-to[2], scene->index);
        for (int s = 0; s < scene->suns; s++) {
            for (int c = 0; c < SHIP_CHANNELS; c++) {
                radiance[s][c] += (1 - weight) * scene->water[c];
            }
        }
        along(from, to, sea, from);
        from[2] = 0;
        to[2] = -to[2];
        met = ship_mesh_cast(&scene->mesh, from, to, INFINITY, &hit);
    }
    if (met) {
        along(from, to, hit.distance, from);
        if (turns > 0) {
            ship_radiance(scene, from, to, &hit, turns - 1, random, own);
        }
    } else {
        for (int s = 0; s < scene->suns; s++) {
            sea_sky_look(&scene->sky[s], to, own[s]);
        }
    }
    for (int s = 0; s < scene->suns; s++) {
        for (int c = 0; c < SHIP_CHANNELS; c++) {
            radiance[s][c] += weight * own[s][c];
        }
    }
}

/* Under a film of water, where one of twenty crests (Rayleigh) has been; of a
 * hull that goes along with longer waves. Light is shut in by the film's
 * surface: reflectance from inside by that from outside, 0.066, and n² (Lekner
 * and Dorf 1988). */
static double wetted(const struct ship_scene *scene, double height,
                     double albedo)
{
    double inside = 1 - (1 - 0.066) / (scene->index * scene->index);
    double crest = height / fmax(scene->washed, 1e-9);
    double dry = 1;
    for (int i = 0; i < 20; i++) {
        dry *= 1 - exp(-0.5 * crest * crest);
    }
    double wet = (1 - 0.066) * (1 - inside) * albedo / (1 - inside * albedo);
    return height > 0 ? dry * albedo + (1 - dry) * wet : albedo;
}

void ship_radiance(const struct ship_scene *scene, const double *place,
                   const double *direction, const struct ship_hit *met,
                   int turns, struct sea_random *random,
                   double (*radiance)[SHIP_CHANNELS])
{
    struct ship_hit washed = *met, *hit = &washed;
    washed.albedo = wetted(scene, place[2], met->albedo);
    double point[3], to[3], come[SHIP_SUNS][SHIP_CHANNELS] = { 0 };
    along(place, hit->normal, 1e-3, point);
    memset(radiance, 0, SHIP_SUNS * sizeof(*radiance));
    add_suns(scene, point, direction, hit, random, radiance);
    scatter(hit->normal, random, to);
    look_around(scene, point, to, turns, random, come);
    double share = paint(hit, direction, to);
    for (int s = 0; s < scene->suns; s++) {
        for (int c = 0; c < SHIP_CHANNELS; c++) {
            radiance[s][c] += share * come[s][c];
        }
    }
}

/* --- under water --------------------------------------------------------- */

/* Whether light along `into` (in the air, from above) reaches a point under
 * the flat sea; *way: its length in the water. */
static int reaches(const struct ship_scene *scene, const double *point,
                   const double *to, double *way)
{
    static const double up[3] = { 0, 0, 1 };
    double down[3] = { -to[0], -to[1], -to[2] }, in[3], surface[3];
    refract(down, up, scene->index, in);
    *way = fmax(-point[2], 0) / -in[2];
    double back[3] = { -in[0], -in[1], -in[2] };
    along(point, back, *way, surface);
    surface[2] = fmax(surface[2], 0) + 1e-6;
    return !ship_mesh_cast(&scene->mesh, point, back, *way, NULL) &&
           is_free(&scene->mesh, surface, to);
}

/* What is left of the water's light where it turns towards the eye at a point:
 * of the Sun's, and of a sky's by one direction of it. */
static void add_turn(const struct ship_scene *scene, const double *point,
                     int channel, struct sea_random *random,
                     struct ship_sight *sight)
{
    static const double up[3] = { 0, 0, 1 };
    double to[3], way;
    for (int s = 0; s < scene->suns; s++) {
        sight->lit[s][channel] = reaches(scene, point, scene->sky[s].sun, &way);
    }
    scatter(up, random, to);
    to[2] = fmax(to[2], 1e-3);
    sight->open[channel] = reaches(scene, point, to, &way);
}

/* The hull under water: Lambert's law in what is left of the light there. */
static void add_hull(const struct ship_scene *scene, const double *point,
                     const struct ship_hit *hit, double way, double through,
                     struct sea_random *random, struct ship_sight *sight)
{
    static const double up[3] = { 0, 0, 1 };
    double place[3], to[3], in[3], down[3], length = 0;
    along(point, hit->normal, 1e-3, place);
    scatter(up, random, to);
    to[2] = fmax(to[2], 1e-3);
    for (int i = 0; i < 3; i++) {
        down[i] = -to[i];
    }
    refract(down, up, scene->index, in);
    double sky_cosine = -sea_dot(in, hit->normal) / -in[2];
    int sky_free = sky_cosine > 0 && reaches(scene, place, to, &length);
    double sky_way = length, out = through / (scene->index * scene->index);
    for (int s = 0; s < scene->suns; s++) {
        const double *sun = scene->sky[s].sun;
        double sky[SHIP_CHANNELS] = { 0 },
               minus[3] = { -sun[0], -sun[1], -sun[2] };
        sea_sky_look(&scene->sky[s], to, sky);
        refract(minus, up, scene->index, in);
        double cosine = -sea_dot(in, hit->normal) / -in[2];
        int sunny = cosine > 0 && reaches(scene, place, sun, &length);
        for (int c = 0; c < SHIP_CHANNELS; c++) {
            double light = 0;
            if (sunny) {
                light += scene->irradiance[c] / PI * sun[2] * cosine *
                         (1 - sea_fresnel(sun[2], scene->index)) *
                         exp(-scene->fade[c] * length);
            }
            if (sky_free) {
                light += sky[c] * sky_cosine *
                         (1 - sea_fresnel(to[2], scene->index)) *
                         exp(-scene->fade[c] * sky_way);
            }
            sight->hull[s][c] =
                hit->albedo * light * out * exp(-scene->fade[c] * way);
        }
    }
}

static void look_below(const struct ship_scene *scene,
                       const struct sea_hit *place, const double *direction,
                       double through, struct sea_random *random,
                       struct ship_sight *sight)
{
    double in[3], from[3], point[3];
    refract(direction, place->normal, scene->index, in);
    along(place->point, place->normal, -2e-6, from);
    struct ship_hit hit;
    double end = INFINITY;
    if (ship_mesh_cast(&scene->mesh, from, in, INFINITY, &hit)) {
        end = hit.distance;
        sight->wet = 1;
        along(from, in, end, point);
        add_hull(scene, point, &hit, end, through, random, sight);
    }
    double u = 1 - sea_random_unit(random);
    double steep = fmax(-in[2], 0.05);
    for (int c = 0; c < SHIP_CHANNELS; c++) {
        /* The Sun's light comes down by as much as the sight goes. */
        double sun = sqrt(1 - (1 - pow(scene->sky[0].sun[2], 2)) /
                                  (scene->index * scene->index));
        double way = -log(u) / (scene->fade[c] * (1 + steep / sun));
        if (way < end) {
            along(from, in, way, point);
            point[2] = fmin(point[2], -1e-4);
            add_turn(scene, point, c, random, sight);
        }
    }
}

/* --- a line of sight ----------------------------------------------------- */

static void follow(const struct ship_scene *scene, struct sea_hit hit,
                   const double *towards, struct sea_random *random,
                   struct ship_sight *sight)
{
    enum { ORDERS = 5 };
    double direction[3], next[3], weight = 1;
    double at_ship = 0, ship[SHIP_SUNS][SHIP_CHANNELS] = { 0 };
    memcpy(direction, towards, sizeof(direction));
    for (int order = 0; order < ORDERS; order++) {
        double cosine = fmax(-sea_dot(direction, hit.normal), 0);
        weight *= sea_fresnel(cosine, scene->index);
        sea_reflect(direction, hit.normal, next);
        memcpy(direction, next, sizeof(direction));
        struct sea_hit other;
        struct ship_hit body;
        enum sea_end end =
            sea_trace(&scene->surface, hit.point, direction, &other);
        double far = INFINITY;
        if (end == SEA_HIT) {
            double d[3];
            for (int i = 0; i < 3; i++) {
                d[i] = other.point[i] - hit.point[i];
            }
            far = sqrt(sea_dot(d, d));
        }
        if (at_ship == 0 &&
            ship_mesh_cast(&scene->mesh, hit.point, direction, far, &body)) {
            double point[3];
            along(hit.point, direction, body.distance, point);
            ship_radiance(scene, point, direction, &body, 2, random, ship);
            at_ship = weight;
            sight->mirrors = 1;
        }
        if (end != SEA_HIT) {
            for (int s = 0; s < scene->suns; s++) {
                sea_sky_look(&scene->sky[s], direction, sight->sky[s]);
                for (int c = 0; c < SHIP_CHANNELS; c++) {
                    sight->sky[s][c] *= weight;
                }
            }
            break;
        }
        hit = other;
    }
    for (int s = 0; s < scene->suns; s++) {
        for (int c = 0; c < SHIP_CHANNELS; c++) {
            sight->with[s][c] =
                at_ship > 0 ? at_ship * ship[s][c] : sight->sky[s][c];
        }
    }
}

void ship_look(const struct ship_scene *scene, const double *eye,
               const double *direction, struct sea_random *random,
               struct ship_sight *sight)
{
    memset(sight, 0, sizeof(*sight));
    struct sea_hit hit;
    struct ship_hit body;
    enum sea_end end = sea_trace(&scene->surface, eye, direction, &hit);
    double far = INFINITY;
    if (end == SEA_HIT) {
        double d[3];
        for (int i = 0; i < 3; i++) {
            d[i] = hit.point[i] - eye[i];
        }
        far = sqrt(sea_dot(d, d));
    }
    if (ship_mesh_cast(&scene->mesh, eye, direction, far, &body)) {
        double point[3];
        along(eye, direction, body.distance, point);
        ship_radiance(scene, point, direction, &body, 2, random, sight->body);
        sight->direct = 1;
        return;
    }
    if (end != SEA_HIT) {
        for (int s = 0; s < scene->suns; s++) {
            sea_sky_look(&scene->sky[s], direction, sight->sky[s]);
        }
        memcpy(sight->with, sight->sky, sizeof(sight->with));
        return;
    }
    for (int s = 0; s < scene->suns; s++) {
        double to[3];
        to_sun(&scene->sky[s], random, to);
        sight->sunny[s] = is_free(&scene->mesh, hit.point, to);
    }
    follow(scene, hit, direction, random, sight);
    double cosine = fmax(-sea_dot(direction, hit.normal), 0);
    look_below(scene, &hit, direction, 1 - sea_fresnel(cosine, scene->index),
               random, sight);
}
