#include "scene/ephemeris.h"

#include <math.h>
#include <stddef.h>

#include "scene/orbit.h"

#define UNIX_J2000 946728000.0 /* 2000-01-01T12:00:00 */
#define DAY_S 86400.0
#define CENTURY_DAYS 36525.0
#define ARCSECOND (PEL_DEG / 3600.0)
#define OBLIQUITY_J2000 (23.4392911 * PEL_DEG)
#define AU_KM 149597870.7

static struct pel_mat3 turned(const struct pel_mat3 *by,
                              const struct pel_mat3 *m)
{
    return (struct pel_mat3){ pel_mat3_apply(by, m->x),
                              pel_mat3_apply(by, m->y),
                              pel_mat3_apply(by, m->z) };
}

/* Turns the axes, not what they measure. */
static struct pel_mat3 about_z(double angle)
{
    double c = cos(angle), s = sin(angle);
    return (struct pel_mat3){ { c, -s, 0 }, { s, c, 0 }, { 0, 0, 1 } };
}

static struct pel_mat3 about_x(double angle)
{
    double c = cos(angle), s = sin(angle);
    return (struct pel_mat3){ { 1, 0, 0 }, { 0, c, -s }, { 0, s, c } };
}

static struct pel_mat3 about_y(double angle)
{
    double c = cos(angle), s = sin(angle);
    return (struct pel_mat3){ { c, 0, s }, { 0, 1, 0 }, { -s, 0, c } };
}

double pel_ephemeris_delta_t(double unix_s)
{
    static const double at[][2] = {
        { 1900, -3 },   { 1910, 10.5 }, { 1920, 21.2 }, { 1940, 24.3 },
        { 1950, 29.1 }, { 1960, 33.2 }, { 1970, 40.2 }, { 1980, 50.5 },
        { 1990, 56.9 }, { 2000, 63.8 }, { 2010, 66.1 }, { 2026, 69.2 },
        { 2100, 200 }
    };
    const int last = sizeof at / sizeof *at - 1;
    double year = 2000.0 + (unix_s - UNIX_J2000) / (365.25 * DAY_S);
    int i = 0;
    while (i < last - 1 && year > at[i + 1][0]) {
        i++;
    }
    double t = (year - at[i][0]) / (at[i + 1][0] - at[i][0]);
    return at[i][1] + t * (at[i + 1][1] - at[i][1]);
}

static double centuries(double unix_s)
{
    return (unix_s - UNIX_J2000 + pel_ephemeris_delta_t(unix_s)) /
           (DAY_S * CENTURY_DAYS);
}

/* From the equator of J2000 to that of date: Lieske 1979. */
static struct pel_mat3 precession(double t)
{
    double zeta = t * (2306.2181 + t * (0.30188 + t * 0.017998)) * ARCSECOND;
    double z = t * (2306.2181 + t * (1.09468 + t * 0.018203)) * ARCSECOND;
    double theta = t * (2004.3109 - t * (0.42665 + t * 0.041833)) * ARCSECOND;
    struct pel_mat3 a = about_z(-zeta), b = about_y(theta), c = about_z(-z);
    struct pel_mat3 ba = turned(&b, &a);
    return turned(&c, &ba);
}

/* Meeus 1998, eq. 12.4. */
static double local_sidereal(double unix_s, double longitude_rad)
{
    double days = (unix_s - UNIX_J2000) / DAY_S, t = days / CENTURY_DAYS;
    double degrees = 280.46061837 + 360.98564736629 * days + 3.87933e-4 * t * t;
    return fmod(degrees, 360.0) * PEL_DEG + longitude_rad;
}

/* From the equator of date to east, north, up. */
static struct pel_mat3 horizon(double sidereal, double latitude_rad)
{
    double ct = cos(sidereal), st = sin(sidereal);
    double cp = cos(latitude_rad), sp = sin(latitude_rad);
    return (struct pel_mat3){ { -st, -sp * ct, cp * ct },
                              { ct, -sp * st, cp * st },
                              { 0, cp, sp } };
}

struct pel_mat3 pel_ephemeris_sky(double unix_s, double latitude_rad,
                                  double longitude_rad)
{
    struct pel_mat3 p = precession(centuries(unix_s));
    struct pel_mat3 h =
        horizon(local_sidereal(unix_s, longitude_rad), latitude_rad);
    return turned(&h, &p);
}

/* From the Earth's centre, equator of J2000, km. */
static struct pel_vec3 moon_of(double t)
{
    struct pel_mat3 from_ecliptic = about_x(-OBLIQUITY_J2000);
    return pel_mat3_apply(&from_ecliptic, pel_orbit_at(PEL_ORBIT_MOON, t));
}

static struct pel_vec3 sun_of(double t)
{
    struct pel_mat3 from_ecliptic = about_x(-OBLIQUITY_J2000);
    struct pel_vec3 earth = pel_orbit_at(PEL_ORBIT_EARTH, t);
    return pel_mat3_apply(&from_ecliptic, pel_vec3_scale(earth, -AU_KM));
}

/* Of the ellipsoid's surface (WGS84), local axes, km. */
static struct pel_vec3 place_of(double latitude_rad)
{
    const double a = 6378.137, e2 = 6.69437999014e-3;
    double s = sin(latitude_rad), c = cos(latitude_rad);
    double n = a / sqrt(1.0 - e2 * s * s);
    double out = n * c, along = n * (1.0 - e2) * s;
    return (struct pel_vec3){ 0, along * c - out * s, along * s + out * c };
}

void pel_ephemeris_moon(double unix_s, double latitude_rad,
                        double longitude_rad, struct pel_moon_place *out)
{
    double t = centuries(unix_s);
    struct pel_mat3 sky =
        pel_ephemeris_sky(unix_s, latitude_rad, longitude_rad);
    struct pel_vec3 centre = moon_of(t), sun = sun_of(t);
    struct pel_vec3 from = pel_vec3_scale(place_of(latitude_rad), -1.0);
    struct pel_vec3 seen = pel_vec3_add(pel_mat3_apply(&sky, centre), from);
    double km = sqrt(pel_vec3_dot(seen, seen));
    struct pel_vec3 to_sun =
        pel_mat3_apply(&sky, pel_vec3_add(sun, pel_vec3_scale(centre, -1.0)));
    double cosine = -pel_vec3_dot(pel_vec3_normalize(to_sun), seen) / km;
    *out = (struct pel_moon_place){ pel_vec3_scale(seen, 1.0 / km), 1e3 * km,
                                    0.5 * (1.0 + cosine) };
}

static double length(struct pel_vec3 v)
{
    return sqrt(pel_vec3_dot(v, v));
}

/* Of its place from Sun (at) and Earth (seen), phase angle in degrees. */
static double magnitude(int planet, struct pel_vec3 at, struct pel_vec3 seen)
{
    double r = length(at), d = length(seen), far = 5.0 * log10(r * d);
    double i =
        acos(pel_clamp(pel_vec3_dot(at, seen) / (r * d), -1, 1)) / PEL_DEG;
    if (planet == 0) {
        return -4.40 + far + i * (0.0009 + i * (0.000239 - i * 0.00000065));
    }
    if (planet == 1) {
        return -1.52 + far + 0.016 * i;
    }
    if (planet == 2) {
        return -9.40 + far + 0.005 * i;
    }
    /* The rings' pole. */
    const double tilt = 28.0749 * PEL_DEG, node = 169.5085 * PEL_DEG;
    const struct pel_vec3 pole = { sin(tilt) * sin(node),
                                   -sin(tilt) * cos(node), cos(tilt) };
    double b = fabs(pel_vec3_dot(pole, seen)) / d;
    return -8.88 + far + 0.044 * i - 2.60 * b + 1.25 * b * b;
}

static struct pel_planet planet_of(int planet, double t)
{
    static const enum pel_orbit of[PEL_PLANETS] = {
        PEL_ORBIT_VENUS, PEL_ORBIT_MARS, PEL_ORBIT_JUPITER, PEL_ORBIT_SATURN
    };
    const double light_days = 499.004784 / DAY_S; /* of an astronomical unit */
    struct pel_mat3 from_ecliptic = about_x(-OBLIQUITY_J2000);
    struct pel_vec3 earth = pel_orbit_at(PEL_ORBIT_EARTH, t);
    struct pel_vec3 at, seen = { 0, 0, 0 };
    for (int i = 0; i < 3; i++) {
        at = pel_orbit_at(of[planet],
                          t - length(seen) * light_days / CENTURY_DAYS);
        seen = pel_vec3_add(at, pel_vec3_scale(earth, -1.0));
    }
    return (struct pel_planet){
        .to = pel_vec3_normalize(pel_mat3_apply(&from_ecliptic, seen)),
        .magnitude = magnitude(planet, at, seen),
    };
}

void pel_ephemeris_night(double unix_s, double latitude_rad,
                         double longitude_rad, struct pel_night_sky *out)
{
    double t = centuries(unix_s);
    struct pel_vec3 earth = pel_orbit_at(PEL_ORBIT_EARTH, t);
    *out = (struct pel_night_sky){
        .local = pel_ephemeris_sky(unix_s, latitude_rad, longitude_rad),
        .local_minute = pel_ephemeris_sky(60.0 * floor(unix_s / 60.0),
                                          latitude_rad, longitude_rad),
        .sun_longitude_rad = atan2(-earth.y, -earth.x),
        .years = 100.0 * t,
    };
    for (int i = 0; i < PEL_PLANETS; i++) {
        out->planets[i] = planet_of(i, t);
    }
}
