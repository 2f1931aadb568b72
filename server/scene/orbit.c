#include "scene/orbit.h"

#include <libnova/earth.h>
#include <libnova/jupiter.h>
#include <libnova/ln_types.h>
#include <libnova/lunar.h>
#include <libnova/mars.h>
#include <libnova/saturn.h>
#include <libnova/venus.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>

#define JD_J2000 2451545.0
#define CENTURY_DAYS 36525.0
#define NODE_S 3600.0
#define KEPT 8 /* nodes of a body: of two moments asked for in turn */

struct node {
    bool known;
    double number; /* in steps of NODE_S from J2000, whole */
    struct pel_vec3 place;
};

/* libnova keeps the last moment's terms in variables of its own. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct node kept[PEL_ORBITS][KEPT];

/* Under the lock. */
static struct pel_vec3 series(enum pel_orbit body, double centuries)
{
    static void (*const of[PEL_ORBITS])(double, struct ln_helio_posn *) = {
        [PEL_ORBIT_EARTH] = ln_get_earth_helio_coords,
        [PEL_ORBIT_VENUS] = ln_get_venus_helio_coords,
        [PEL_ORBIT_MARS] = ln_get_mars_helio_coords,
        [PEL_ORBIT_JUPITER] = ln_get_jupiter_helio_coords,
        [PEL_ORBIT_SATURN] = ln_get_saturn_helio_coords,
    };
    const double day = JD_J2000 + centuries * CENTURY_DAYS;
    if (body == PEL_ORBIT_MOON) {
        struct ln_rect_posn p;
        ln_get_lunar_geo_posn(day, &p, 0);
        return (struct pel_vec3){ p.X, p.Y, p.Z };
    }
    struct ln_helio_posn p;
    of[body](day, &p);
    double l = p.L * PEL_DEG, b = p.B * PEL_DEG;
    const struct pel_vec3 v = { cos(b) * cos(l), cos(b) * sin(l), sin(b) };
    return pel_vec3_scale(v, p.R);
}

struct pel_vec3 pel_orbit_series(enum pel_orbit body, double centuries)
{
    pthread_mutex_lock(&lock);
    struct pel_vec3 at = series(body, centuries);
    pthread_mutex_unlock(&lock);
    return at;
}

/* Under the lock. */
static struct pel_vec3 node_of(enum pel_orbit body, double number)
{
    double slot = fmod(number, KEPT);
    struct node *n = &kept[body][(int)(slot < 0 ? slot + KEPT : slot)];
    if (!n->known || n->number != number) {
        *n = (struct node){
            true, number, series(body, number * NODE_S / PEL_ORBIT_CENTURY_S)
        };
    }
    return n->place;
}

/* Lagrange's cubic through the nodes at -1, 0, 1, 2. */
struct pel_vec3 pel_orbit_at(enum pel_orbit body, double centuries)
{
    const double steps = centuries * PEL_ORBIT_CENTURY_S / NODE_S;
    const double first = floor(steps), f = steps - first;
    const double weight[4] = { -f * (f - 1) * (f - 2) / 6,
                               (f + 1) * (f - 1) * (f - 2) / 2,
                               -(f + 1) * f * (f - 2) / 2,
                               (f + 1) * f * (f - 1) / 6 };
    struct pel_vec3 at = { 0, 0, 0 };
    pthread_mutex_lock(&lock);
    for (int i = 0; i < 4; i++) {
        at = pel_vec3_add(
            at, pel_vec3_scale(node_of(body, first + i - 1), weight[i]));
    }
    pthread_mutex_unlock(&lock);
    return at;
}
