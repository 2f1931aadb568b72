/* Where Moon, Earth and planets are on their orbits, by libnova (ELP 2000-82B,
 * VSOP87). Their series take 0.2 to 1 ms each, and every frame asks for them:
 * so they are computed at nodes, every hour of terrestrial time, and cubics
 * through four nodes give what is between. A pure function of the body and the
 * time. Thread-safe; a call may wait while another computes nodes. */
#ifndef PELAGOS_SCENE_ORBIT_H
#define PELAGOS_SCENE_ORBIT_H

#include "base/vec.h"

enum pel_orbit {
    PEL_ORBIT_MOON,  /* from the Earth's centre, km */
    PEL_ORBIT_EARTH, /* this and the others from the Sun, astronomical units */
    PEL_ORBIT_VENUS,
    PEL_ORBIT_MARS,
    PEL_ORBIT_JUPITER,
    PEL_ORBIT_SATURN,
    PEL_ORBITS
};

/* Centuries of 36525 days. */
#define PEL_ORBIT_CENTURY_S (36525.0 * 86400.0)

/* In axes of the ecliptic and equinox of J2000, `centuries` of terrestrial time
 * after 2000-01-01T12. From 1900 to 2100 off the series by
 * 4e-10 of the Moon's distance, 2e-11 of the others' (orbit_test). */
struct pel_vec3 pel_orbit_at(enum pel_orbit body, double centuries);

/* By the series themselves. */
struct pel_vec3 pel_orbit_series(enum pel_orbit body, double centuries);

#endif
