#include "scene/sun.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"

static double turn(double degrees)
{
    return fmod(degrees, 360.0) * PEL_DEG;
}

/* Apparent right ascension and declination, chapter 25. */
static void equatorial(double t, double *right_ascension, double *declination)
{
    double mean_longitude = 280.46646 + t * (36000.76983 + t * 0.0003032);
    double anomaly = turn(357.52911 + t * (35999.05029 - t * 0.0001537));
    double centre = (1.914602 - t * (0.004817 + t * 0.000014)) * sin(anomaly) +
                    (0.019993 - t * 0.000101) * sin(2 * anomaly) +
                    0.000289 * sin(3 * anomaly);
    double node = turn(125.04 - 1934.136 * t);
    double longitude =
        turn(mean_longitude + centre - 0.00569 - 0.00478 * sin(node));
    double obliquity =
        (23.43929111 - t * (0.0130041667 + t * (1.6e-7 - t * 5.04e-7)) +
         0.00256 * cos(node)) *
        PEL_DEG;
    *right_ascension = atan2(cos(obliquity) * sin(longitude), cos(longitude));
    *declination = asin(sin(obliquity) * sin(longitude));
}

void pel_sun_position(double unix_s, double latitude_rad, double longitude_rad,
                      double *azimuth_rad, double *elevation_rad)
{
    double days = unix_s / 86400.0 + 2440587.5 - 2451545.0;
    double right_ascension, declination;
    equatorial(days / 36525.0, &right_ascension, &declination);
    /* Eq. 12.4; the equation of the equinoxes stays below 0.005°. */
    double sidereal = turn(280.46061837 + 360.98564736629 * days);
    double hour = sidereal + longitude_rad - right_ascension;
    double east = -cos(declination) * sin(hour);
    double north = sin(declination) * cos(latitude_rad) -
                   cos(declination) * sin(latitude_rad) * cos(hour);
    double up = sin(declination) * sin(latitude_rad) +
                cos(declination) * cos(latitude_rad) * cos(hour);
    double elevation = atan2(up, hypot(east, north));
    /* Parallax of 8.794″: seen from the surface, not the Earth's centre. */
    *elevation_rad = elevation - 8.794 / 3600 * PEL_DEG * cos(elevation);
    double azimuth = atan2(east, north);
    *azimuth_rad = azimuth < 0 ? azimuth + 2 * PEL_PI : azimuth;
}
