/* WGS 84 geodesics: places between degrees and the local frame. Pure
 * functions, any thread. Source: T. Vincenty, Survey Review 23(176), 1975. */
#pragma once

#include "base/vec.h"

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

/* Both: the place in the local frame and, returned, its convergence. */
double pel_geo_to_plane(double origin_lat, double origin_lon, double lat,
                        double lon, double *east_m, double *north_m);

/* The same by parallel transport along the geodesic from the origin: what turns
 * the local frame's axes at a place rigidly. Where the map of the local frame
 * keeps lengths (within 100 km to 4e-5) it is the convergence; at the origin's
 * antipode there is none. */
double pel_geo_turn(double origin_lat, double origin_lon, double lat,
                    double lon);

/* Metres from the Earth's centre, x to 0 N 0 E, z to the pole, of a place at a
 * height above the ellipsoid; and the inverse (Bowring, Survey Review 23(181),
 * 1976, repeated), to 1e-8 m from 100 m below to 1e7 m above. */
struct pel_vec3 pel_geo_earth(double lat, double lon, double height_m);
void pel_geo_of_earth(struct pel_vec3 at, double *lat, double *lon,
                      double *height_m);

/* In those axes: east, north and up of a place. */
struct pel_mat3 pel_geo_axes(double lat, double lon);
/* The same of a local frame at a place, whose north is turned. */
struct pel_mat3 pel_geo_local_axes(double origin_lat, double origin_lon,
                                   double lat, double lon);
