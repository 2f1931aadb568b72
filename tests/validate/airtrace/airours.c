/* The program's own sky, from its reference code, for lines of sight from
 * standard input (zenith angle and azimuth from the Sun's, degrees):
 *
 *     airours VISIBILITY_KM HEIGHT_M SUN_ZENITH…
 *
 * Prints `sight sun radiance radiance radiance` at 680, 550 and 440 nm. */
#include <stdio.h>
#include <stdlib.h>

#include "optics/atmosphere.h"

#define RADIAN (3.14159265358979323846 / 180)

static struct pel_atmosphere air;

static struct pel_vec3 toward(double zenith, double azimuth)
{
    return (struct pel_vec3){ sin(zenith) * cos(azimuth),
                              sin(zenith) * sin(azimuth), cos(zenith) };
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        fprintf(stderr, "airours: VISIBILITY_KM HEIGHT_M SUN_ZENITH…\n");
        return 2;
    }
    const struct pel_atmosphere_desc desc = { .visibility_m =
                                                  1e3 * atof(argv[1]) };
    pel_atmosphere_init(&desc, &air);
    if (pel_atmosphere_tabulate(&air, NULL, NULL)) {
        return 1;
    }
    double height_m = atof(argv[2]), zenith, azimuth;
    for (int sight = 0; scanf("%lf %lf", &zenith, &azimuth) == 2; sight++) {
        for (int s = 3; s < argc; s++) {
            struct pel_rgb l = pel_atmosphere_sky(
                &air, height_m, toward(zenith * RADIAN, azimuth * RADIAN),
                toward(atof(argv[s]) * RADIAN, 0));
            printf("%d %d %.7g %.7g %.7g\n", sight, s - 3, l.r, l.g, l.b);
        }
    }
    return 0;
}
