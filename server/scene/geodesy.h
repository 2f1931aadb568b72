/* WGS 84 geodesics: places between degrees and the local frame. Pure
 * functions, any thread. Source: T. Vincenty, Survey Review 23(176), 1975. */
#pragma once

/* Azimuthal equidistant coordinates of a place about an origin: metres along
 * the geodesic, split by its azimuth at the origin. Latitudes -90..90,
 * longitudes -180..180, degrees. Better than 1 mm to 10,000 km; near the
 * antipode, where the geodesic is not unique, a sphere is used. */
void pel_geo_to_local(double origin_lat, double origin_lon, double lat,
                      double lon, double *east_m, double *north_m);

/* The inverse; longitude in -180..180. */
void pel_geo_from_local(double origin_lat, double origin_lon, double east_m,
                        double north_m, double *lat, double *lon);

/* Angle from the local frame's north at the origin to true north at a place,
 * radians clockwise: local heading = true heading + this. */
double pel_geo_convergence(double origin_lat, double origin_lon, double lat,
                           double lon);
