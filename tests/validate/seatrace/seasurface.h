/* A realised surface: a sum of periodic height grids, each with waves of one
 * band, turned and moved against each other. Between its nodes a grid is
 * bilinear: the surface is exactly that, and normals are its own gradient.
 *
 * x east, y north, z up, metres. Shared by threads once it is filled.
 */
#ifndef SEASURFACE_H
#define SEASURFACE_H

#include "searandom.h"
#include "seaspectrum.h"

enum { SEA_LEVELS = 8, SEA_CELLS_PER_WAVE = 8 };

struct sea_level {
    int n;           /* nodes a side, a power of two */
    double size_m;   /* of the tile */
    double cos, sin; /* of its turn */
    double move_x, move_y;
    double k_from, k_to;
    float *amplitude; /* of a mode: square root of its energy */
    float *height;    /* n x n, row by row */
    float *shift[2];  /* choppy: displacement along the level's axes */
    double chop;      /* c of its displacements */
    double highest;   /* of |height| */
    double steepest;  /* bound of the gradient */
};

struct sea_surface {
    int levels; /* from the longest waves to the shortest */
    struct sea_level level[SEA_LEVELS];
    double wind_x, wind_y; /* unit, where the wind blows to */
    int choppy;
    double finer[SEA_LEVELS + 1];   /* greatest height of this and later ones */
    double steeper[SEA_LEVELS + 1]; /* gradient bound of those before */
    /* Of the last filling, over all nodes' cells. */
    double m0, along, cross;
};

/* Room and amplitudes for a spectrum; nodes: a side of each grid. Ends the
 * program without memory. */
void sea_surface_init(struct sea_surface *surface,
                      const struct sea_spectrum *spectrum, int nodes,
                      double wind_to_rad);

/* Before the first filling: particles move horizontally as in trochoids,
 * D = i k/|k| c h of each mode, which sharpens crests. c is 1 where the
 * mean-square slope of all longer waves is below (0.7 / 5.5)2, and less for
 * shorter ones, so that the whole is (0.98 / 5.5)2 at most: as the drawn sea
 * is defined. The spectrum then is of heights over places at rest. */
void sea_surface_chop(struct sea_surface *surface,
                      const struct sea_spectrum *spectrum);

/* A new realisation. */
void sea_surface_fill(struct sea_surface *surface, struct sea_random *random);

/* For tests: one level z = a sin(k x) of n nodes over `waves` waves; n = 2
 * with amplitude 0 is flat. */
void sea_surface_sinusoid(struct sea_surface *surface, double amplitude_m,
                          double wavelength_m, int waves, int nodes);

void sea_surface_finish(struct sea_surface *surface);

/* Height, and where gradient is not NULL dz/dx and dz/dy. */
double sea_surface_height(const struct sea_surface *surface, double x, double y,
                          double *gradient);

/* Height of one level at a place, which is at rest where it is choppy. */
double sea_level_height(const struct sea_level *level, double x, double y);

#endif
