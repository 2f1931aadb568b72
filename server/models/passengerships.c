/* Ships that carry people. */
#include "models/kinds.h"

/* An outline of the hull's shape from x0 to x1, `in` inside the deck's edge,
 * the after end straight. Returns its corners. */
enum { PART = 10 };
static int follow(const struct pel_hull_lines *h, double x0, double x1,
                  double in, struct pel_vec2 out[2 * PART])
{
    for (int i = 0; i < PART; i++) {
        double at = x0 + (x1 - x0) * i / (PART - 1);
        double half = fmax(pel_hull_half(h, at) - in, 0.05);
        out[i] = (struct pel_vec2){ at, -half };
        out[2 * PART - 1 - i] = (struct pel_vec2){ at, half };
    }
    return 2 * PART;
}

/* A deck house of the hull's outline. */
static void storey(struct pel_pen *pen, const struct pel_hull_lines *h,
                   double x0, double x1, double in, double z0, double z1)
{
    struct pel_vec2 outline[2 * PART];
    pel_solid_tower(pen, outline, follow(h, x0, x1, in, outline), z0, z1, 1, 0,
                    0);
}

/* Boats in their davits along one side and the other. */
static void lifeboats(struct pel_pen *pen, double x0, double x1, double y,
                      double z, int count, double size)
{
    pel_pen_node(pen, "lifeboats");
    for (int i = 0; i < count; i++) {
        double x = x0 + (x1 - x0) * (i + 0.5) / count;
        for (int side = -1; side <= 1; side += 2) {
            pel_pen_paint(pen, PEL_SHIP_WHITE, 0.4);
            pel_solid_ellipsoid(pen, (struct pel_vec3){ x, side * y, z },
                                0.5 * size, 0.2 * size, 0.16 * size, 10);
            pel_pen_paint(pen, PEL_ORANGE, 0.4);
            pel_solid_ellipsoid(
                pen, (struct pel_vec3){ x, side * y, z + 0.1 * size },
                0.44 * size, 0.18 * size, 0.14 * size, 10);
        }
    }
}

/* --- ferry -------------------------------------------------------------------
 */

static void ferry_house(struct pel_pen *pen, const struct pel_kind_size *s,
                        const struct pel_hull_lines *h)
{
    double l = s->length, z = h->freeboard, deck = 0.068 * s->height;
    pel_pen_node(pen, "superstructure");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    storey(pen, h, -0.497 * l, 0.4 * l, 0, z - 0.3, z + 2.2 * deck);
    storey(pen, h, -0.42 * l, 0.375 * l, 0.5, z + 2.2 * deck, z + 3.4 * deck);
    storey(pen, h, -0.3 * l, 0.345 * l, 1.2, z + 3.4 * deck, z + 4.6 * deck);
    /* Long rows of saloon windows. */
    pel_pen_node(pen, "windows");
    pel_pen_paint(pen, PEL_GLASS, 0.15);
    for (int row = 0; row < 2; row++) {
        double low = z + (1.35 + 1.2 * row) * deck;
        double half = s->beam / 2 - (row == 1 ? 0.5 : 0);
        for (int i = 0; i < 30; i++) {
            double x = -0.36 * l + i * 0.02 * l;
            pel_solid_boxes(pen, x, x + 0.013 * l, half - 0.12, half + 0.1, low,
                            low + 0.45 * deck);
        }
    }
    pel_pen_node(pen, "bridge");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    double bridge = z + 4.6 * deck;
    pel_kind_wheelhouse(pen, "bridge", 0.285 * l, 0.335 * l, 1.04 * s->beam,
                        bridge, bridge + 1.2 * deck);
}

void pel_kind_ferry(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, deck = 0.068 * s->height;
    struct pel_hull_lines h = {
        .length = l,
        .beam = s->beam,
        .draught = s->draught,
        .freeboard = 0.225 * s->height,
        .sheer_fore = 0.06 * s->height,
        .stem_rake = 0.045 * l,
        .keel_rake = 0.05 * l,
        .counter = 0.005 * l,
        .cutaway = 0.07 * l,
        .power = 5.5,
        .power_ends = 2,
        .entrance = 0.44,
        .run = 0.36,
        .bow_power = 1.9,
        .bow_round = 1.1,
        .stern_power = 2.2,
        .transom = 0.95,
        .transom_deep = 0.2,
        .flare = 0.8,
        .strake = 0.06 * s->draught,
        .strake_colour = PEL_BOOT_RED,
        .bottom = PEL_BOOT_RED,
        .side = s->colour,
        .deck = PEL_DECK_GREEN,
        .bulb = 0.028 * l,
        .rudder = true,
        .stations = 40,
    };
    pel_hull_draw(pen, &h);
    /* The white bow above the blue. */
    pel_pen_node(pen, "bow");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    storey(pen, &h, 0.3 * l, 0.492 * l, 0.1, h.freeboard,
           h.freeboard + 1.35 * deck);
    ferry_house(pen, s, &h);
    double roof = h.freeboard + 4.6 * deck;
    pel_pen_node(pen, "funnel");
    pel_kind_funnel(pen, -0.2 * l, 0, 0.075 * l, 0.3 * s->beam, roof - deck,
                    roof + 2.9 * deck, s->colour);
    pel_pen_node(pen, "mast");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    pel_kind_mast(pen, 0.29 * l, roof + 1.2 * deck, s->height, 0.35 * s->beam);
    lifeboats(pen, -0.2 * l, 0.22 * l, 0.47 * s->beam, roof - 0.4 * deck, 4,
              0.048 * l);
    pel_kind_navigation(pen, s,
                        (struct pel_vec3){ 0.44 * l, 0, 0.6 * s->height },
                        (struct pel_vec3){ 0.29 * l, 0, s->height },
                        (struct pel_vec3){ 0.31 * l, 0.51 * s->beam, roof },
                        (struct pel_vec3){ -0.5 * l, 0, h.freeboard });
}

/* --- cruise ship
 * ---------------------------------------------------------------- */

/* A tier of cabins: dark balconies between white slabs. */
static void tier(struct pel_pen *pen, const struct pel_hull_lines *h, double x0,
                 double x1, double in, double z, double deck)
{
    pel_pen_paint(pen, 0x4b555c, 0.4);
    storey(pen, h, x0 + 0.5, x1 - 0.5, in + 1.3, z, z + deck);
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    storey(pen, h, x0, x1, in, z - 0.15 * deck, z + 0.33 * deck);
    /* Walls between the balconies. */
    double half = h->beam / 2 - in;
    int count = (int)((x1 - x0) / (3.6 * deck));
    for (int i = 1; i < count; i++) {
        double x = x0 + (x1 - x0) * i / count;
        if (pel_hull_half(h, x) - in > half - 0.3) {
            pel_solid_boxes(pen, x, x + 0.12 * deck, half - 1.5, half - 0.05,
                            z + 0.3 * deck, z + 0.9 * deck);
        }
    }
}

static void cruise_house(struct pel_pen *pen, const struct pel_kind_size *s,
                         const struct pel_hull_lines *h)
{
    double l = s->length, deck = 0.051 * s->height, z = h->freeboard;
    pel_pen_node(pen, "promenade");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    storey(pen, h, -0.485 * l, 0.36 * l, 0.3, z - 0.3, z + deck);
    pel_pen_paint(pen, PEL_GLASS, 0.2);
    storey(pen, h, -0.44 * l, 0.35 * l, 3, z + deck, z + 2.2 * deck);
    for (int i = 0; i < 6; i++) {
        double back = -0.465 * l + 0.012 * l * i;
        double front = 0.345 * l - 0.009 * l * i;
        pel_pen_node(pen, "cabins");
        tier(pen, h, back, front, 0.3, z + (2.2 + i) * deck, deck);
    }
    pel_pen_node(pen, "lido");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    double top = z + 8.2 * deck;
    storey(pen, h, -0.39 * l, 0.29 * l, 0.6, top - 0.2 * deck,
           top + 0.35 * deck);
    storey(pen, h, 0.12 * l, 0.27 * l, 3, top, top + 1.3 * deck);
    storey(pen, h, -0.33 * l, -0.12 * l, 3, top, top + 1.3 * deck);
    pel_pen_node(pen, "bridge");
    pel_kind_wheelhouse(pen, "bridge", 0.3 * l, 0.325 * l, 1.08 * s->beam,
                        z + 5.2 * deck, z + 6.4 * deck);
}

void pel_kind_cruise_ship(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, deck = 0.051 * s->height;
    struct pel_hull_lines h = {
        .length = l,
        .beam = s->beam,
        .draught = s->draught,
        .freeboard = 0.2 * s->height,
        .sheer_fore = 0.09 * s->height,
        .stem_rake = 0.05 * l,
        .keel_rake = 0.055 * l,
        .counter = 0.012 * l,
        .cutaway = 0.06 * l,
        .power = 5.5,
        .power_ends = 2,
        .entrance = 0.44,
        .run = 0.36,
        .bow_power = 1.9,
        .bow_round = 1.1,
        .stern_power = 2.2,
        .transom = 0.85,
        .transom_deep = 0.15,
        .flare = 0.8,
        .strake = 0.08 * s->draught,
        .strake_colour = 0x1c3c66,
        .bottom = PEL_BOOT_RED,
        .side = s->colour,
        .deck = 0x9c8a6c,
        .bulb = 0.022 * l,
        .rudder = true,
        .stations = 40,
    };
    pel_hull_draw(pen, &h);
    cruise_house(pen, s, &h);
    double top = h.freeboard + 8.4 * deck;
    pel_pen_node(pen, "funnel");
    pel_kind_funnel(pen, -0.25 * l, 0, 0.07 * l, 0.4 * s->beam, top + deck,
                    0.96 * s->height, 0x1c3c66);
    pel_pen_node(pen, "mast");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.45);
    pel_kind_mast(pen, 0.24 * l, top + deck, s->height, 0.3 * s->beam);
    lifeboats(pen, -0.36 * l, 0.3 * l, 0.5 * s->beam - 0.8,
              h.freeboard + 1.5 * deck, 9, 0.034 * l);
    pel_pen_node(pen, "portholes");
    pel_pen_paint(pen, PEL_GLASS, 0.2);
    for (int i = 0; i < 56; i++) {
        double x = -0.4 * l + i * 0.0102 * l;
        for (int row = 0; row < 2; row++) {
            double z = (0.42 + 0.3 * row) * h.freeboard;
            pel_solid_boxes(pen, x, x + 0.0035 * l, s->beam / 2 - 0.12,
                            s->beam / 2 + 0.08, z, z + 0.0035 * l);
        }
    }
    pel_kind_navigation(
        pen, s, (struct pel_vec3){ 0.44 * l, 0, 0.5 * s->height },
        (struct pel_vec3){ 0.24 * l, 0, s->height },
        (struct pel_vec3){ 0.31 * l, 0.53 * s->beam, h.freeboard + 5.5 * deck },
        (struct pel_vec3){ -0.49 * l, 0, h.freeboard });
}
