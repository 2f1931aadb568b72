/* Lines of sight to the Earth from any height, for the Monte Carlo of the air
 * (airtrace). Lengths in km. The eye is over the z axis, the Sun over the x
 * axis; channels as in airmodel.h. */
#ifndef SPACESIGHT_H
#define SPACESIGHT_H

#include <stdbool.h>

#include "../airtrace/airpath.h"

struct space_eye {
    double height;
    double sun_zenith; /* rad, at the eye and its nadir */
};

/* A unit vector by the angle from the nadir and the azimuth from the Sun's. */
struct air_vec space_toward(double nadir, double azimuth);

/* What a line of sight meets: nothing, air alone, or the ground, there. */
enum space_end { SPACE_NOTHING, SPACE_AIR, SPACE_GROUND };
enum space_end space_meets(const struct air *air, const struct space_eye *eye,
                           struct air_vec toward, struct air_vec *ground);

/* The same sight for airpath.h, from where it enters the air; false where it
 * meets nothing. */
bool space_sight(const struct air *air, const struct space_eye *eye,
                 struct air_vec toward, int channel, struct air_sight *sight);

/* A vector of the eye's frame in that of this sight, which has its own. */
struct air_vec space_turned(const struct air *air, const struct space_eye *eye,
                            struct air_vec toward, struct air_vec vector);

/* Radiance for a solar irradiance of 1 of the Sun that facets mirror, through
 * the air. */
double space_glint(const struct air_scene *scene, const struct space_eye *eye,
                   struct air_vec toward, int channel);

/* Radiance for a solar irradiance of 1 of light that the air turns once, over
 * black ground, by a plain sum over the sight with `steps`, the optical depths
 * with it, and the Sun's disc by `chords`: shares the air's constants alone
 * with airpath.h, and no table. */
double space_once(const struct air *air, const struct space_eye *eye,
                  struct air_vec toward, int channel, int steps, int chords);

#endif
