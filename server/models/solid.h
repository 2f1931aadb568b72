/* Closed bodies for shapes that code of ours makes: boxes, prisms, poles,
 * turned bodies, hulls. Each body is closed, with its faces outward, so that a
 * shape of such bodies has an inside. Metres, model's frame. */
#pragma once

#include "models/shape.h"

/* Where bodies go, and what of. */
struct pel_pen {
    struct pel_shape *shape;
    int material, node;
};

/* Bodies from now on belong to this node, and are of this paint: an sRGB
 * colour 0xRRGGBB, roughness 0..1; metal. */
void pel_pen_node(struct pel_pen *pen, const char *name);
void pel_pen_paint(struct pel_pen *pen, uint32_t colour, double roughness);
void pel_pen_metal(struct pel_pen *pen, uint32_t colour, double roughness);

/* Triangles; corners counterclockwise seen from outside. */
void pel_solid_triangle(struct pel_pen *pen, struct pel_vec3 a,
                        struct pel_vec3 b, struct pel_vec3 c);
void pel_solid_quad(struct pel_pen *pen, struct pel_vec3 a, struct pel_vec3 b,
                    struct pel_vec3 c, struct pel_vec3 d);

/* From (x0, y0, z0) to (x1, y1, z1), each first less than its second. */
void pel_solid_box(struct pel_pen *pen, double x0, double x1, double y0,
                   double y1, double z0, double z1);
/* On the centreline, `wide` across. */
void pel_solid_block(struct pel_pen *pen, double x0, double x1, double wide,
                     double z0, double z1);
/* The same to port and to starboard of the centreline, y0 < y1 of port's. */
void pel_solid_boxes(struct pel_pen *pen, double x0, double x1, double y0,
                     double y1, double z0, double z1);

/* A convex outline of n corners in the plane of x and z, counterclockwise seen
 * from starboard (from −y: x to the right, z up), from y0 to y1. */
void pel_solid_side(struct pel_pen *pen, const struct pel_vec2 *outline, int n,
                    double y0, double y1);
/* A convex outline in the plane of x and y, counterclockwise from above, from
 * z0 to z1, where it is `top` times as large about (cx, cy). */
void pel_solid_tower(struct pel_pen *pen, const struct pel_vec2 *outline, int n,
                     double z0, double z1, double top, double cx, double cy);

/* From a to b, of radius ra and rb there, with `sides` sides. A radius of 0
 * makes a point. */
void pel_solid_pole(struct pel_pen *pen, struct pel_vec3 a, struct pel_vec3 b,
                    double ra, double rb, int sides);
/* A profile of n points (radius, z), from its lowest end on the axis' side
 * upward, turned about the vertical through (x, y). Ends with radius > 0 get
 * lids. */
void pel_solid_turned(struct pel_pen *pen, const struct pel_vec2 *profile,
                      int n, double x, double y, int sides);
/* An ellipsoid with half axes a, b, c. */
void pel_solid_ellipsoid(struct pel_pen *pen, struct pel_vec3 centre, double a,
                         double b, double c, int sides);
/* A tube of radius r along a path, closed to a ring if `ring`. */
void pel_solid_tube(struct pel_pen *pen, const struct pel_vec3 *path, int n,
                    double r, int sides, bool ring);

/* A mast or spar of the railings' thickness needs no more than 4 sides. */
#define PEL_SOLID_THIN 4

/* A monohull, port and starboard alike, closed by its deck.
 * Sections are superellipses below the waterline (power 2: round, 8: boxy, 1:
 * a vee), and flare from there to the deck. */
struct pel_hull_lines {
    double length, beam, draught; /* over all, moulded */
    double freeboard;             /* of the deck amidships */
    double sheer_fore, sheer_aft; /* what the deck rises to the ends */
    double stem_rake, keel_rake;  /* the waterline's, the keel's fore end aft of
                                     the deck's */
    double counter, cutaway;      /* the same of the after end */
    double power;                 /* of the midship section */
    double power_ends;            /* towards bow and stern */
    double entrance, run; /* lengths where the sides come together, of the
                             waterline's */
    double bow_power;     /* of the waterline there: 1.5 fine, 4 full */
    double bow_round;     /* 1 sharp, 2 a round stem */
    double stern_power;
    double transom;      /* its breadth at the deck, of the beam */
    double transom_deep; /* at the keel */
    double flare;        /* what the waterline at the bow is finer than the
                            deck, 0..1 */
    double narrow;       /* the waterline amidships, of the beam; 0: 1 */
    double bulwark;      /* of wall above the deck's edge; it is drawn as deck
                            that far up */
    double strake;       /* of other paint up to this height */
    uint32_t bottom, side, deck, strake_colour; /* paints */
    double bulb;  /* length of a bulbous bow before the keel's end */
    bool rudder;  /* and a propeller's boss */
    int stations; /* 0: 32 */
};

/* Draws it; node "hull". The deck's edge at x, both for what stands on it:
 * half breadth and height. */
void pel_hull_draw(struct pel_pen *pen, const struct pel_hull_lines *hull);
double pel_hull_deck(const struct pel_hull_lines *hull, double x);
double pel_hull_half(const struct pel_hull_lines *hull, double x);
