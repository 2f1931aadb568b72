#include "scene/geodesy.h"

#include <math.h>
#include <stdbool.h>

#include "base/vec.h"

#define A 6378137.0
#define F (1 / 298.257223563)
#define B (A * (1 - F))

/* Reduced latitude. */
static double reduced(double lat_rad)
{
    return atan2((1 - F) * sin(lat_rad), cos(lat_rad));
}

/* Vincenty's series A and B as functions of u². */
static double series_a(double u2)
{
    return 1 + u2 / 16384 * (4096 + u2 * (-768 + u2 * (320 - 175 * u2)));
}

static double series_b(double u2)
{
    return u2 / 1024 * (256 + u2 * (-128 + u2 * (74 - 47 * u2)));
}

/* Vincenty eq. 6. */
static double delta_sigma(double b, double sin_s, double cos_s, double cos_2m)
{
    double c2 = cos_2m * cos_2m;
    return b * sin_s *
           (cos_2m +
            b / 4 *
                (cos_s * (2 * c2 - 1) -
                 b / 6 * cos_2m * (4 * sin_s * sin_s - 3) * (4 * c2 - 3)));
}

static double eq10_c(double cos2_alpha)
{
    return F / 16 * cos2_alpha * (4 + F * (4 - 3 * cos2_alpha));
}

struct inverse {
    double sin_sigma, cos_sigma, sigma, cos2_alpha, cos_2m;
};

/* Sines and cosines of the two reduced latitudes. */
struct ends {
    double s1, c1, s2, c2;
};

/* Eqs. 14 to 18 for one lambda. */
static void arc(const struct ends *u, double lambda, struct inverse *out,
                double *sin_alpha)
{
    double sl = sin(lambda), cl = cos(lambda);
    double x = u->c2 * sl;
    double y = u->c1 * u->s2 - u->s1 * u->c2 * cl;
    out->sin_sigma = hypot(x, y);
    out->cos_sigma = u->s1 * u->s2 + u->c1 * u->c2 * cl;
    out->sigma = atan2(out->sin_sigma, out->cos_sigma);
    *sin_alpha = out->sin_sigma > 0 ? u->c1 * u->c2 * sl / out->sin_sigma : 0;
    out->cos2_alpha = 1 - *sin_alpha * *sin_alpha;
    out->cos_2m = out->cos2_alpha > 1e-15
                      ? out->cos_sigma - 2 * u->s1 * u->s2 / out->cos2_alpha
                      : 0;
}

/* The geodesic's length, and its azimuths where it begins and where it ends. */
static double geodesic(double origin_lat, double origin_lon, double lat,
                       double lon, double *azimuth, double *arrival)
{
    double u1 = reduced(origin_lat * PEL_DEG), u2 = reduced(lat * PEL_DEG);
    const struct ends u = { sin(u1), cos(u1), sin(u2), cos(u2) };
    double l = remainder(lon - origin_lon, 360.0) * PEL_DEG;
    double lambda = l, sin_alpha;
    struct inverse at;
    bool converged = false;
    for (int i = 0; i < 50 && !converged; i++) {
        arc(&u, lambda, &at, &sin_alpha);
        double c = eq10_c(at.cos2_alpha);
        double next =
            l + (1 - c) * F * sin_alpha *
                    (at.sigma +
                     c * at.sin_sigma *
                         (at.cos_2m +
                          c * at.cos_sigma * (2 * at.cos_2m * at.cos_2m - 1)));
        converged = fabs(next - lambda) < 1e-14;
        lambda = next;
        if (!(fabs(lambda) <= PEL_PI)) {
            break;
        }
    }
    double distance;
    if (converged) {
        double u_sq = at.cos2_alpha * (A * A - B * B) / (B * B);
        distance = B * series_a(u_sq) *
                   (at.sigma - delta_sigma(series_b(u_sq), at.sin_sigma,
                                           at.cos_sigma, at.cos_2m));
    } else {
        lambda = l;
        arc(&u, lambda, &at, &sin_alpha);
        distance = A * at.sigma;
    }
    double sl = sin(lambda), cl = cos(lambda);
    *azimuth = atan2(u.c2 * sl, u.c1 * u.s2 - u.s1 * u.c2 * cl);
    *arrival = atan2(u.c1 * sl, u.c1 * u.s2 * cl - u.s1 * u.c2);
    return distance;
}

void pel_geo_to_local(double origin_lat, double origin_lon, double lat,
                      double lon, double *east_m, double *north_m)
{
    double azimuth, arrival;
    double distance =
        geodesic(origin_lat, origin_lon, lat, lon, &azimuth, &arrival);
    *east_m = distance * sin(azimuth);
    *north_m = distance * cos(azimuth);
}

void pel_geo_from_local(double origin_lat, double origin_lon, double east_m,
                        double north_m, double *lat, double *lon)
{
    double distance = hypot(east_m, north_m);
    double azimuth = distance > 0 ? atan2(east_m, north_m) : 0;
    double u1 = reduced(origin_lat * PEL_DEG);
    double sigma1 = atan2(tan(u1), cos(azimuth));
    double sin_alpha = cos(u1) * sin(azimuth);
    double cos2_alpha = 1 - sin_alpha * sin_alpha;
    double u_sq = cos2_alpha * (A * A - B * B) / (B * B);
    double first = distance / (B * series_a(u_sq)), sigma = first;
    double cos_2m = 0, b = series_b(u_sq);
    for (int i = 0; i < 50; i++) {
        cos_2m = cos(2 * sigma1 + sigma);
        double next = first + delta_sigma(b, sin(sigma), cos(sigma), cos_2m);
        double change = fabs(next - sigma);
        sigma = next;
        if (change < 1e-15) {
            break;
        }
    }
    cos_2m = cos(2 * sigma1 + sigma);
    double ss = sin(sigma), cs = cos(sigma);
    double x = sin(u1) * ss - cos(u1) * cs * cos(azimuth);
    double lat_rad = atan2(sin(u1) * cs + cos(u1) * ss * cos(azimuth),
                           (1 - F) * hypot(sin_alpha, x));
    double lambda =
        atan2(ss * sin(azimuth), cos(u1) * cs - sin(u1) * ss * cos(azimuth));
    double c = eq10_c(cos2_alpha);
    double l =
        lambda -
        (1 - c) * F * sin_alpha *
            (sigma + c * ss * (cos_2m + c * cs * (2 * cos_2m * cos_2m - 1)));
    *lat = lat_rad / PEL_DEG;
    *lon = remainder(origin_lon + l / PEL_DEG, 360.0);
}

double pel_geo_to_plane(double origin_lat, double origin_lon, double lat,
                        double lon, double *east_m, double *north_m)
{
    /* 111 m: far above the rounding of the projection, far below its scale. */
    double step = lat > 0 ? -1e-3 : 1e-3;
    double east1, north1;
    pel_geo_to_local(origin_lat, origin_lon, lat, lon, east_m, north_m);
    pel_geo_to_local(origin_lat, origin_lon, lat + step, lon, &east1, &north1);
    double east = (east1 - *east_m) / step, north = (north1 - *north_m) / step;
    return atan2(east, north);
}

double pel_geo_convergence(double origin_lat, double origin_lon, double lat,
                           double lon)
{
    double east, north;
    return pel_geo_to_plane(origin_lat, origin_lon, lat, lon, &east, &north);
}

double pel_geo_turn(double origin_lat, double origin_lon, double lat,
                    double lon)
{
    double azimuth, arrival;
    /* Of two places as good as one, azimuths are rounding. */
    return geodesic(origin_lat, origin_lon, lat, lon, &azimuth, &arrival) < 0.01
               ? pel_geo_convergence(origin_lat, origin_lon, lat, lon)
               : remainder(azimuth - arrival, 2 * PEL_PI);
}

struct pel_vec3 pel_geo_earth(double lat, double lon, double height_m)
{
    double s = sin(lat * PEL_DEG), c = cos(lat * PEL_DEG);
    double normal = A / sqrt(1 - F * (2 - F) * s * s);
    double out = (normal + height_m) * c;
    return (struct pel_vec3){ out * cos(lon * PEL_DEG),
                              out * sin(lon * PEL_DEG),
                              ((1 - F) * (1 - F) * normal + height_m) * s };
}

/* Bowring's reduced latitude (1976), again until it stands: of any height the
 * third is as good as the numbers. */
void pel_geo_of_earth(struct pel_vec3 at, double *lat, double *lon,
                      double *height_m)
{
    const double e2 = F * (2 - F);
    double out = hypot(at.x, at.y);
    double beta = atan2(at.z, (1 - F) * out), phi = 0;
    for (int i = 0; i < 6; i++) {
        double s = sin(beta), c = cos(beta);
        phi = atan2(at.z + e2 / (1 - e2) * B * s * s * s,
                    out - e2 * A * c * c * c);
        beta = atan2((1 - F) * sin(phi), cos(phi));
    }
    double s = sin(phi), c = cos(phi);
    *lat = phi / PEL_DEG;
    *lon = atan2(at.y, at.x) / PEL_DEG;
    *height_m = out * c + at.z * s - A * sqrt(1 - e2 * s * s);
}

struct pel_mat3 pel_geo_axes(double lat, double lon)
{
    double sp = sin(lat * PEL_DEG), cp = cos(lat * PEL_DEG);
    double sl = sin(lon * PEL_DEG), cl = cos(lon * PEL_DEG);
    return (struct pel_mat3){ { -sl, cl, 0 },
                              { -sp * cl, -sp * sl, cp },
                              { cp * cl, cp * sl, sp } };
}

struct pel_mat3 pel_geo_local_axes(double origin_lat, double origin_lon,
                                   double lat, double lon)
{
    struct pel_mat3 m = pel_geo_axes(lat, lon);
    double turned = pel_geo_turn(origin_lat, origin_lon, lat, lon);
    double s = sin(turned), c = cos(turned);
    /* A true heading 0 is `turned` there: its north lies before true north. */
    return (struct pel_mat3){
        pel_vec3_add(pel_vec3_scale(m.x, c), pel_vec3_scale(m.y, s)),
        pel_vec3_add(pel_vec3_scale(m.y, c), pel_vec3_scale(m.x, -s)), m.z
    };
}
