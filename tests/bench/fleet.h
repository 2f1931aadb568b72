/* Things on the sea of the benchmark's scene. */
#pragma once

#include "render/renderer.h"

enum bench_fleet {
    BENCH_NO_FLEET,
    BENCH_TANKER_NEAR, /* 220 m ahead */
    BENCH_TANKER_FAR,  /* 2 km */
    BENCH_BUOY,        /* 50 m */
    BENCH_MARKS, /* 50,000 triangles, 300 m ahead, in a lane of 20 buoys */
    BENCH_BOATS, /* 256 of some 2,000 triangles, 200 m to 6 km away */
    BENCH_FLEETS
};

const char *bench_fleet_name(enum bench_fleet fleet);

/* Puts it before the eye of *env's scene, at its moment; what it points to
 * stays until the program ends. One thread. False: out of memory. */
PEL_CHECK bool bench_fleet_set(enum bench_fleet fleet,
                               struct pel_environment *env);

/* The waves of so many ships of 100 m (at most PEL_WAKES) that have gone in
 * circles of 1 km at 12 kn for ten minutes, the first there ahead; as above. */
PEL_CHECK bool bench_fleet_wakes(int ships, double away_m,
                                 struct pel_environment *env);
