/* Makers of built-in models, a function a kind: each draws bodies of the given
 * dimensions with `pen` and sets eye points and lights of its shape. */
#pragma once

#include "models/solid.h"

struct pel_kind_size {
    double length, beam, draught; /* over all; below the waterline */
    double height;                /* from the waterline to the truck */
    uint32_t colour;
};

#define PEL_BUILTIN(name, function, ...)                                       \
    void function(struct pel_pen *pen, const struct pel_kind_size *size);
#include "models/kinds.def"

/* Colours that ships share. */
#define PEL_BOOT_RED 0x7a2a22 /* antifouling */
#define PEL_DECK_GREEN 0x4f6b58
#define PEL_DECK_RED 0x7d4438
#define PEL_SHIP_WHITE 0xe6e6e0
#define PEL_GLASS 0x1a2228
#define PEL_STEEL_GREY 0x8a8f92
#define PEL_ORANGE 0xe0571c
#define PEL_BLACK 0x16171a

/* An eye point. */
void pel_kind_eye(struct pel_pen *pen, const char *name, double x, double y,
                  double z);
/* A light: sRGB colour, nautical miles, arc from..to in degrees clockwise from
 * the bow (equal: all round). */
void pel_kind_light(struct pel_pen *pen, const char *name, uint32_t colour,
                    double miles, double from, double to, struct pel_vec3 at);
/* What COLREG wants of a power-driven vessel of this length: masthead lights
 * (a second one from 50 m), sidelights at (x, half, z), a sternlight. */
void pel_kind_navigation(struct pel_pen *pen, const struct pel_kind_size *size,
                         struct pel_vec3 masthead, struct pel_vec3 second,
                         struct pel_vec3 side, struct pel_vec3 stern);

/* A wheelhouse with a band of windows around, from x0 to x1, and the eye point
 * of that name before them. */
void pel_kind_wheelhouse(struct pel_pen *pen, const char *eye, double x0,
                         double x1, double wide, double z0, double z1);
/* Rows of windows on the sides and the front of a block. */
void pel_kind_windows(struct pel_pen *pen, double x0, double x1, double wide,
                      double z0, double deck, int decks);
/* A funnel with a coloured band. */
void pel_kind_funnel(struct pel_pen *pen, double x, double y, double long_m,
                     double wide, double z0, double z1, uint32_t colour);
/* A mast with a yard and a radar. */
void pel_kind_mast(struct pel_pen *pen, double x, double z0, double z1,
                   double yard);
