#include "optics/light.h"

#include <math.h>
#include <stdbool.h>

#include "optics/colour.h"
#include "optics/moon.h"

/* Irradiance of magnitude 0 in V is 3.63e-11 W m⁻² nm⁻¹ at 550 nm (Bessell,
 * Castelli, Plez 1998). The Moon is redder than the Sun: its B − V is 0.27
 * more (Allen's Astrophysical Quantities), its albedo at 680 nm 1.19 times that
 * at 550 (Lane and Irvine 1973). */
#define FULL_MOON 4.4866e-6
const struct pel_light_body pel_light_bodies[PEL_LIGHTS] = {
    [PEL_LIGHT_SUN] = { .name = "sun",
                        .irradiance = PEL_SUN_IRRADIANCE,
                        .angular_radius_rad = PEL_SUN_ANGULAR_RADIUS,
                        .solid_angle_sr = PEL_SUN_SOLID_ANGLE,
                        .limb = { 0.43, 0.5, 0.6 } },
    [PEL_LIGHT_MOON] = { .name = "moon",
                         .irradiance = { FULL_MOON * 1.19 * 1.474 / 1.850,
                                         FULL_MOON,
                                         FULL_MOON * 0.78 * 1.912 / 1.850 },
                         .angular_radius_rad = PEL_MOON_ANGULAR_RADIUS,
                         .solid_angle_sr = 6.418e-5 },
};

double pel_light_radius(const struct pel_light *light)
{
    return light->radius_rad > 0.0
               ? light->radius_rad
               : pel_light_bodies[light->body].angular_radius_rad;
}

void pel_lights_of_sun(struct pel_vec3 direction,
                       struct pel_light out[PEL_LIGHTS])
{
    for (int i = 0; i < PEL_LIGHTS; i++) {
        out[i] = (struct pel_light){ .direction = { 0, 0, -1 }, .body = i };
    }
    out[PEL_LIGHT_SUN].direction = direction;
    out[PEL_LIGHT_SUN].strength = 1.0;
}

struct pel_light pel_light_moon(struct pel_vec3 direction, struct pel_vec3 sun,
                                double lit, double distance_m)
{
    double alpha = pel_moon_alpha(lit);
    struct pel_vec3 beside = pel_vec3_add(
        sun, pel_vec3_scale(direction, -pel_vec3_dot(sun, direction)));
    if (pel_vec3_dot(beside, beside) < 1e-12) {
        beside = (struct pel_vec3){ direction.y, -direction.x, 1e-6 };
    }
    beside = pel_vec3_normalize(beside);
    return (struct pel_light){
        .direction = direction,
        .strength = pel_moon_strength(alpha, distance_m),
        .radius_rad = asin(PEL_MOON_RADIUS / distance_m),
        .source = pel_vec3_add(pel_vec3_scale(direction, -cos(alpha)),
                               pel_vec3_scale(beside, sin(alpha))),
        .body = PEL_LIGHT_MOON,
    };
}

double pel_light_level(double sine)
{
    static const struct {
        double degrees, log_lx;
    } at[] = { { -18, -4.0 }, { -15, -3.0 }, { -12, -2.05 }, { -9, -0.7 },
               { -6, 0.72 },  { -3, 2.0 },   { 0, 2.95 },    { 5, 3.75 },
               { 10, 4.1 },   { 20, 4.5 },   { 90, 5.1 } };
    const int count = sizeof at / sizeof *at;
    double e = asin(pel_clamp(sine, -1.0, 1.0)) / PEL_DEG;
    if (e < at[0].degrees) { /* none that matters */
        return pow(10.0, at[0].log_lx + (e - at[0].degrees) / 3.0);
    }
    int i = 0;
    while (i < count - 2 && e > at[i + 1].degrees) {
        i++;
    }
    double t = (e - at[i].degrees) / (at[i + 1].degrees - at[i].degrees);
    return pow(10.0, at[i].log_lx + t * (at[i + 1].log_lx - at[i].log_lx));
}

double pel_light_of(const struct pel_light *light)
{
    return light->strength * pel_light_bodies[light->body].irradiance.g /
           pel_light_bodies[PEL_LIGHT_SUN].irradiance.g *
           pel_light_level(light->direction.z);
}

struct pel_lights_shown pel_lights_order(struct pel_light lights[PEL_LIGHTS])
{
    const double set = sin(PEL_SUN_ANGULAR_RADIUS), high = sin(4.0 * PEL_DEG);
    for (int i = 0; i < PEL_LIGHTS; i++) {
        lights[i].body = i;
    }
    const struct pel_light sun = lights[PEL_LIGHT_SUN],
                           moon = lights[PEL_LIGHT_MOON];
    double by_sun = pel_light_of(&sun), by_moon = pel_light_of(&moon);
    if (by_moon <= PEL_LIGHT_LEAST * by_sun) {
        bool up = moon.strength > 0.0 && moon.direction.z > -high;
        return (struct pel_lights_shown){ 1, up ? 2 : 1 };
    }
    if (sun.direction.z < -set) {
        lights[0] = moon;
        lights[1] = sun;
    }
    return by_sun <= PEL_LIGHT_LEAST * by_moon
               ? (struct pel_lights_shown){ 1, 1 }
               : (struct pel_lights_shown){ 2, 2 };
}

#define NIGHT_LX 1e-3  /* of its own light */
#define STARS_SINE 0.7 /* of a Sun whose daylight has their spectrum */

double pel_lights_level(const struct pel_light *lights, int lit, bool night)
{
    double level = night ? NIGHT_LX : 0.0;
    for (int i = 0; i < lit; i++) {
        level += pel_light_of(&lights[i]);
    }
    return level;
}

/* The mean of `of` (n numbers of a Sun's sine) by what each light gives. */
static void mix_lights(const struct pel_light *lights, int lit, bool night,
                       void (*of)(double, double *), int n, double *m)
{
    of(lights[0].direction.z, m);
    if (lit < 2 && !night) {
        return;
    }
    double mixed[9] = { 0 }, sum = pel_lights_level(lights, lit, night);
    for (int i = 0; i <= lit; i++) {
        bool stars = i == lit;
        double level = !stars  ? pel_light_of(&lights[i])
                       : night ? NIGHT_LX
                               : 0.0;
        of(stars ? STARS_SINE : lights[i].direction.z, m);
        for (int k = 0; k < n; k++) {
            mixed[k] += level * m[k];
        }
    }
    for (int k = 0; k < n; k++) {
        m[k] = mixed[k] / sum;
    }
}

void pel_lights_colours(const struct pel_light *lights, int lit, bool night,
                        double m[9])
{
    mix_lights(lights, lit, night, pel_colour_matrix, 9, m);
}

void pel_lights_rods(const struct pel_light *lights, int lit, bool night,
                     double weights[3])
{
    mix_lights(lights, lit, night, pel_colour_rods, 3, weights);
}
