/* Boats that work. */
#include "models/kinds.h"

/* Fenders: a rubber tube at the deck's edge around the hull. */
static void fender(struct pel_pen *pen, const struct pel_hull_lines *h,
                   double below, double r)
{
    enum { N = 14 };
    struct pel_vec3 path[2 * N];
    double half = 0.49 * h->length;
    for (int i = 0; i < N; i++) {
        double x = -half + 2 * half * i / (N - 1);
        double y = fmax(pel_hull_half(h, x), 0.4 * r);
        double z = pel_hull_deck(h, x) - below;
        path[i] = (struct pel_vec3){ x, -y, z };
        path[2 * N - 1 - i] = (struct pel_vec3){ x, y, z };
    }
    pel_pen_node(pen, "fender");
    pel_pen_paint(pen, PEL_BLACK, 0.9);
    pel_solid_tube(pen, path, 2 * N, r, 6, true);
}

/* Rails: stanchions and two wires along both sides, from x0 to x1. */
static void rails(struct pel_pen *pen, const struct pel_hull_lines *h,
                  double x0, double x1, double high, double r)
{
    enum { N = 9 };
    pel_pen_node(pen, "rails");
    pel_pen_metal(pen, 0xc8ccd0, 0.3);
    for (int side = -1; side <= 1; side += 2) {
        struct pel_vec3 path[N];
        for (int i = 0; i < N; i++) {
            double x = x0 + (x1 - x0) * i / (N - 1);
            double y = side * fmax(pel_hull_half(h, x) - 3 * r, r);
            double z = pel_hull_deck(h, x);
            path[i] = (struct pel_vec3){ x, y, z + high };
            pel_solid_pole(pen, (struct pel_vec3){ x, y, z - r }, path[i], r, r,
                           4);
        }
        pel_solid_tube(pen, path, N, r, 4, false);
    }
}

static struct pel_hull_lines boat_hull(const struct pel_kind_size *s)
{
    return (struct pel_hull_lines){
        .length = s->length,
        .beam = s->beam,
        .draught = s->draught,
        .stem_rake = 0.06 * s->length,
        .keel_rake = 0.16 * s->length,
        .counter = 0.005 * s->length,
        .cutaway = 0.03 * s->length,
        .power = 2.2,
        .power_ends = 1.3,
        .entrance = 0.5,
        .run = 0.35,
        .bow_power = 1.8,
        .bow_round = 1.2,
        .stern_power = 2,
        .transom = 0.85,
        .transom_deep = 0.3,
        .flare = 0.7,
        .strake_colour = PEL_BLACK,
        .bottom = PEL_BOOT_RED,
        .side = s->colour,
        .deck = PEL_DECK_GREEN,
        .stations = 28,
    };
}

/* --- tug
 * ---------------------------------------------------------------------- */

static void tug_house(struct pel_pen *pen, const struct pel_kind_size *s,
                      const struct pel_hull_lines *h)
{
    double l = s->length, b = s->beam, z = h->freeboard;
    double deck = 0.135 * s->height;
    pel_pen_node(pen, "house");
    pel_pen_paint(pen, 0xd9b97a, 0.5);
    pel_solid_block(pen, -0.1 * l, 0.3 * l, 0.62 * b, z - 0.3, z + deck);
    pel_kind_windows(pen, -0.1 * l, 0.3 * l, 0.62 * b, z, deck, 1);
    pel_solid_block(pen, 0.0 * l, 0.26 * l, 0.55 * b, z + deck, z + 2 * deck);
    pel_kind_windows(pen, 0.0 * l, 0.26 * l, 0.55 * b, z + deck, deck, 1);
    pel_pen_node(pen, "wheelhouse");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_kind_wheelhouse(pen, "wheelhouse", 0.04 * l, 0.23 * l, 0.46 * b,
                        z + 2 * deck, z + 3.1 * deck);
    for (int side = -1; side <= 1; side += 2) {
        pel_pen_node(pen, "funnel");
        pel_kind_funnel(pen, -0.06 * l, side * 0.2 * b, 0.07 * l, 0.1 * b,
                        z + deck, z + 2.7 * deck, 0xc43a2a);
    }
    pel_pen_node(pen, "mast");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_kind_mast(pen, 0.1 * l, z + 3.1 * deck, s->height, 0.3 * b);
    pel_pen_node(pen, "fire monitor");
    pel_pen_paint(pen, 0xc43a2a, 0.5);
    pel_solid_pole(pen, (struct pel_vec3){ 0.2 * l, 0.15 * b, z + 3.1 * deck },
                   (struct pel_vec3){ 0.23 * l, 0.15 * b, z + 3.45 * deck },
                   0.12, 0.09, 6);
}

void pel_kind_tug(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, b = s->beam;
    struct pel_hull_lines h = boat_hull(s);
    h.freeboard = 0.11 * s->height;
    h.sheer_fore = 0.13 * s->height;
    h.sheer_aft = 0.02 * s->height;
    h.stem_rake = 0.05 * l;
    h.keel_rake = 0.14 * l;
    h.cutaway = 0.14 * l;
    h.power = 3;
    h.power_ends = 2;
    h.entrance = 0.4;
    h.bow_power = 2.2;
    h.bow_round = 1.9;
    h.transom = 0.8;
    h.strake = 0.05 * s->draught;
    h.bulwark = 0.055 * s->height;
    h.rudder = true;
    pel_hull_draw(pen, &h);
    fender(pen, &h, -0.5 * h.bulwark, 0.04 * b);
    tug_house(pen, s, &h);
    pel_pen_node(pen, "winch");
    pel_pen_paint(pen, 0x3d4a44, 0.6);
    pel_solid_pole(
        pen, (struct pel_vec3){ -0.2 * l, -0.13 * b, h.freeboard + 1 },
        (struct pel_vec3){ -0.2 * l, 0.13 * b, h.freeboard + 1 }, 0.9, 0.9, 10);
    pel_pen_node(pen, "tow bow");
    pel_pen_paint(pen, 0xd9b97a, 0.5);
    const struct pel_vec3 arch[] = {
        { -0.33 * l, -0.3 * b, h.freeboard - 0.1 },
        { -0.33 * l, -0.28 * b, h.freeboard + 2.2 },
        { -0.33 * l, 0.28 * b, h.freeboard + 2.2 },
        { -0.33 * l, 0.3 * b, h.freeboard - 0.1 }
    };
    pel_solid_tube(pen, arch, 4, 0.15, 6, false);
    pel_kind_navigation(
        pen, s, (struct pel_vec3){ 0.1 * l, 0, s->height },
        (struct pel_vec3){ 0 },
        (struct pel_vec3){ 0.15 * l, 0.25 * b, h.freeboard + 0.42 * s->height },
        (struct pel_vec3){ -0.06 * l, 0, h.freeboard + 0.3 * s->height });
}

/* --- fishing boat
 * ---------------------------------------------------------------- */

static void gantry(struct pel_pen *pen, double x, double half, double z0,
                   double z1, double r)
{
    const struct pel_vec3 arch[] = { { x, -half, z0 },
                                     { x + 0.3, -0.85 * half, z1 },
                                     { x + 0.3, 0.85 * half, z1 },
                                     { x, half, z0 } };
    pel_solid_tube(pen, arch, 4, r, 6, false);
    pel_solid_pole(pen, (struct pel_vec3){ x + 0.3, 0, z1 - 0.05 },
                   (struct pel_vec3){ x + 0.3, 0, z1 + 1.2 }, r, 0.6 * r, 6);
}

void pel_kind_fishing_boat(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, b = s->beam, u = s->height / 14;
    struct pel_hull_lines h = boat_hull(s);
    h.freeboard = 1.5 * u;
    h.sheer_fore = 2.6 * u;
    h.sheer_aft = 0.3 * u;
    h.stem_rake = 0.09 * l;
    h.keel_rake = 0.16 * l;
    h.power = 2.4;
    h.strake = 0.25 * u;
    h.strake_colour = PEL_BOOT_RED;
    h.bulwark = 1.0 * u;
    h.deck = 0x6c6256;
    h.rudder = true;
    double z = h.freeboard;
    pel_hull_draw(pen, &h);
    pel_pen_node(pen, "house");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_solid_block(pen, 0.02 * l, 0.27 * l, 0.66 * b, z - 0.3, z + 2.6 * u);
    pel_kind_windows(pen, 0.02 * l, 0.27 * l, 0.66 * b, z + 0.4 * u, 2.2 * u,
                     1);
    pel_kind_wheelhouse(pen, "wheelhouse", 0.07 * l, 0.22 * l, 0.5 * b,
                        z + 2.6 * u, z + 5.1 * u);
    pel_pen_node(pen, "shelter");
    pel_pen_paint(pen, s->colour, 0.5);
    const struct pel_vec2 whaleback[] = { { 0.27 * l, z },
                                          { 0.44 * l, z + 2.0 * u },
                                          { 0.44 * l, z + 2.6 * u },
                                          { 0.27 * l, z + 2.6 * u } };
    pel_solid_side(pen, whaleback, 4, -0.2 * b, 0.2 * b);
    pel_pen_node(pen, "mast");
    pel_pen_paint(pen, 0xd8a33a, 0.5);
    pel_kind_mast(pen, 0.09 * l, z + 5.1 * u, s->height, 0.4 * b);
    pel_pen_node(pen, "gantry");
    gantry(pen, -0.46 * l, 0.42 * b, pel_hull_deck(&h, -0.46 * l) - 0.1,
           z + 5 * u, 0.16 * u);
    gantry(pen, -0.12 * l, 0.3 * b, z - 0.1, z + 6 * u, 0.14 * u);
    pel_solid_pole(pen, (struct pel_vec3){ -0.11 * l, 0, z + 6.4 * u },
                   (struct pel_vec3){ -0.42 * l, 0, z + 5.4 * u }, 0.1 * u,
                   0.07 * u, 5);
    pel_pen_node(pen, "net drum");
    pel_pen_paint(pen, 0x3f7a5a, 0.9);
    pel_solid_pole(pen, (struct pel_vec3){ -0.3 * l, -0.25 * b, z + 1.2 * u },
                   (struct pel_vec3){ -0.3 * l, 0.25 * b, z + 1.2 * u }, 1 * u,
                   1 * u, 12);
    pel_kind_light(pen, "fishing, green", 0x00ff40, 2, 0, 0,
                   (struct pel_vec3){ 0.09 * l, 0, s->height - 0.6 * u });
    pel_kind_light(pen, "fishing, white", 0xffffff, 2, 0, 0,
                   (struct pel_vec3){ 0.09 * l, 0, s->height - 1.6 * u });
    pel_kind_navigation(pen, s, (struct pel_vec3){ 0.09 * l, 0, s->height },
                        (struct pel_vec3){ 0 },
                        (struct pel_vec3){ 0.15 * l, 0.26 * b, z + 4.6 * u },
                        (struct pel_vec3){ -0.49 * l, 0, z + 1.5 * u });
}

/* --- pilot launch
 * ------------------------------------------------------------------ */

void pel_kind_pilot_launch(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, b = s->beam, u = s->height / 8;
    struct pel_hull_lines h = boat_hull(s);
    h.freeboard = 1.35 * u;
    h.sheer_fore = 0.85 * u;
    h.stem_rake = 0.09 * l;
    h.keel_rake = 0.2 * l;
    h.power = 1.7;
    h.power_ends = 1.1;
    h.run = 0.2;
    h.transom = 0.92;
    h.transom_deep = 0.7;
    h.strake = 0.15 * u;
    h.strake_colour = PEL_SHIP_WHITE;
    h.deck = 0x7a7d7a;
    double z = h.freeboard;
    pel_hull_draw(pen, &h);
    fender(pen, &h, 0.15 * u, 0.17 * u);
    pel_pen_node(pen, "house");
    pel_pen_paint(pen, PEL_ORANGE, 0.5);
    const struct pel_vec2 cabin[] = { { -0.2 * l, z - 0.2 },
                                      { 0.2 * l, z - 0.2 },
                                      { 0.15 * l, z + 1.3 * u },
                                      { -0.2 * l, z + 1.3 * u } };
    pel_solid_side(pen, cabin, 4, -0.33 * b, 0.33 * b);
    pel_kind_windows(pen, -0.2 * l, 0.12 * l, 0.66 * b, z + 0.1 * u, 1.2 * u,
                     1);
    pel_pen_paint(pen, PEL_ORANGE, 0.5);
    pel_kind_wheelhouse(pen, "wheelhouse", -0.08 * l, 0.12 * l, 0.58 * b,
                        z + 1.3 * u, z + 3.1 * u);
    pel_pen_node(pen, "mast");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_kind_mast(pen, -0.05 * l, z + 3.1 * u, s->height, 0.35 * b);
    rails(pen, &h, -0.45 * l, 0.47 * l, 1.05 * u, 0.03 * u);
    /* White over red: a pilot vessel on duty. */
    pel_kind_light(pen, "pilot, white", 0xffffff, 3, 0, 0,
                   (struct pel_vec3){ -0.05 * l, 0, s->height });
    pel_kind_light(pen, "pilot, red", 0xff0000, 3, 0, 0,
                   (struct pel_vec3){ -0.05 * l, 0, s->height - u });
    pel_kind_navigation(pen, s,
                        (struct pel_vec3){ -0.05 * l, 0, s->height - 1.6 * u },
                        (struct pel_vec3){ 0 },
                        (struct pel_vec3){ 0.05 * l, 0.3 * b, z + 3 * u },
                        (struct pel_vec3){ -0.49 * l, 0, z + 0.5 * u });
}

/* --- patrol boat
 * ---------------------------------------------------------------------- */

static void patrol_house(struct pel_pen *pen, const struct pel_kind_size *s,
                         double z)
{
    double l = s->length, b = s->beam, u = s->height / 18;
    const struct pel_vec2 low[] = { { -0.24 * l, z - 0.3 },
                                    { 0.19 * l, z - 0.3 },
                                    { 0.15 * l, z + 2.6 * u },
                                    { -0.22 * l, z + 2.6 * u } };
    const struct pel_vec2 high[] = { { -0.06 * l, z + 2.6 * u },
                                     { 0.13 * l, z + 2.6 * u },
                                     { 0.125 * l, z + 3.4 * u },
                                     { -0.05 * l, z + 3.4 * u } };
    pel_pen_node(pen, "house");
    pel_pen_paint(pen, s->colour, 0.5);
    pel_solid_side(pen, low, 4, -0.38 * b, 0.38 * b);
    pel_kind_windows(pen, -0.2 * l, 0.14 * l, 0.76 * b, z + 0.5 * u, 1.9 * u,
                     1);
    pel_solid_side(pen, high, 4, -0.36 * b, 0.36 * b);
    pel_pen_node(pen, "bridge");
    pel_kind_wheelhouse(pen, "bridge", -0.04 * l, 0.12 * l, 0.72 * b,
                        z + 3.0 * u, z + 5.5 * u);
    pel_pen_node(pen, "mast");
    pel_pen_paint(pen, s->colour, 0.5);
    double roof = z + 5.4 * u, x = -0.02 * l;
    for (int i = 0; i < 4; i++) {
        double dx = i & 1 ? 1.0 : -1.0, dy = i & 2 ? 0.9 : -0.9;
        pel_solid_pole(pen, (struct pel_vec3){ x + dx * u, dy * u, roof },
                       (struct pel_vec3){ x + 0.2 * dx * u, 0.2 * dy * u,
                                          s->height - 2.5 * u },
                       0.12 * u, 0.09 * u, 5);
    }
    pel_kind_mast(pen, x, s->height - 4 * u, s->height, 0.5 * b);
    pel_pen_node(pen, "radome");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.4);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ -0.16 * l, 0, z + 3.6 * u },
                        1.1 * u, 1.1 * u, 1.2 * u, 12);
}

void pel_kind_patrol_boat(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, b = s->beam, u = s->height / 18;
    struct pel_hull_lines h = boat_hull(s);
    h.freeboard = 2.5 * u;
    h.sheer_fore = 1.4 * u;
    h.stem_rake = 0.07 * l;
    h.keel_rake = 0.14 * l;
    h.power = 2;
    h.power_ends = 1.2;
    h.run = 0.25;
    h.transom = 0.88;
    h.transom_deep = 0.6;
    h.strake = 0.25 * u;
    h.deck = 0x60686c;
    double z = h.freeboard;
    pel_hull_draw(pen, &h);
    patrol_house(pen, s, z);
    pel_pen_node(pen, "gun");
    pel_pen_paint(pen, s->colour, 0.5);
    double deck = pel_hull_deck(&h, 0.3 * l);
    const struct pel_vec2 turret[] = { { 1.0 * u, deck - 0.2 },
                                       { 1.0 * u, deck + 0.6 * u },
                                       { 0.7 * u, deck + 1.5 * u },
                                       { 0, deck + 1.6 * u } };
    pel_solid_turned(pen, turret, 4, 0.3 * l, 0, 10);
    pel_solid_pole(pen, (struct pel_vec3){ 0.3 * l, 0, deck + 1.1 * u },
                   (struct pel_vec3){ 0.3 * l + 3 * u, 0, deck + 1.5 * u },
                   0.1 * u, 0.07 * u, 6);
    pel_pen_node(pen, "boat");
    pel_pen_paint(pen, PEL_BLACK, 0.7);
    for (int side = -1; side <= 1; side += 2) {
        pel_solid_pole(
            pen, (struct pel_vec3){ -0.44 * l, side * 0.12 * b, z + 0.9 * u },
            (struct pel_vec3){ -0.29 * l, side * 0.1 * b, z + 1.1 * u },
            0.35 * u, 0.3 * u, 8);
    }
    pel_pen_paint(pen, PEL_ORANGE, 0.6);
    pel_solid_block(pen, -0.43 * l, -0.3 * l, 0.22 * b, z + 0.4 * u,
                    z + 0.9 * u);
    rails(pen, &h, 0.16 * l, 0.48 * l, 1.0 * u, 0.035 * u);
    pel_kind_navigation(pen, s, (struct pel_vec3){ -0.02 * l, 0, s->height },
                        (struct pel_vec3){ 0 },
                        (struct pel_vec3){ 0.08 * l, 0.37 * b, z + 4 * u },
                        (struct pel_vec3){ -0.49 * l, 0, z + 0.8 * u });
}
