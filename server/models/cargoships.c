/* Ships that carry goods. */
#include "models/kinds.h"

/* A number for the n-th of something, the same always: colours of boxes. */
static uint32_t scatter(uint32_t n)
{
    n = (n ^ 61u) ^ (n >> 16);
    n *= 9u;
    n ^= n >> 4;
    n *= 0x27d4eb2du;
    return n ^ (n >> 15);
}

/* The house of a cargo ship: decks, bridge with wings, mast, funnel. */
struct house {
    double x0, x1, wide, z0, bridge; /* the wheelhouse's floor */
    double wings, top;               /* over all, the truck */
    uint32_t funnel;
};

static void draw_house(struct pel_pen *pen, const struct house *h)
{
    double deck = 2.8 * fmax(0.3, (h->bridge - h->z0) / 18);
    int decks = (int)((h->bridge - h->z0) / deck);
    double long_m = h->x1 - h->x0;
    pel_pen_node(pen, "house");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_solid_block(pen, h->x0, h->x1, h->wide, h->z0, h->bridge);
    pel_kind_windows(pen, h->x0, h->x1, h->wide, h->z0, deck, decks);
    pel_pen_node(pen, "bridge");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_solid_block(pen, h->x1 - 0.55 * long_m, h->x1 + 0.3, h->wings,
                    h->bridge - 0.35, h->bridge);
    pel_solid_block(pen, h->x1 - 0.55 * long_m, h->x1 - 0.45 * long_m, h->wings,
                    h->bridge, h->bridge + 0.4 * deck);
    pel_solid_block(pen, h->x1 + 0.1, h->x1 + 0.3, h->wings, h->bridge,
                    h->bridge + 0.4 * deck);
    pel_kind_wheelhouse(pen, "bridge", h->x1 - 0.6 * long_m, h->x1,
                        0.92 * h->wide, h->bridge, h->bridge + 1.1 * deck);
    pel_pen_node(pen, "mast");
    double roof = h->bridge + 1.1 * deck;
    pel_kind_mast(pen, h->x1 - 0.35 * long_m, roof, h->top, 0.35 * h->wide);
    pel_pen_node(pen, "funnel");
    double base = h->x0 - 0.5 * long_m;
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_solid_block(pen, base - 0.35 * long_m, h->x0, 0.55 * h->wide, h->z0,
                    h->z0 + 0.45 * (h->bridge - h->z0));
    pel_kind_funnel(pen, base, 0, 0.55 * long_m, 0.3 * h->wide,
                    h->z0 + 0.45 * (h->bridge - h->z0), h->bridge + 0.9 * deck,
                    h->funnel);
}

static void draw_foremast(struct pel_pen *pen, double x, double z0, double z1)
{
    pel_pen_node(pen, "foremast");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    double r = 0.02 * (z1 - z0) + 0.1;
    pel_solid_pole(pen, (struct pel_vec3){ x, 0, z0 },
                   (struct pel_vec3){ x, 0, z1 }, 1.5 * r, r, 8);
    pel_solid_block(pen, x - 3 * r, x + 3 * r, 8 * r, z0 + 0.6 * (z1 - z0),
                    z0 + 0.6 * (z1 - z0) + r);
}

static void set_lights(struct pel_pen *pen, const struct pel_kind_size *s,
                       const struct house *h, double forecastle, double fore_x)
{
    pel_kind_navigation(
        pen, s, (struct pel_vec3){ fore_x, 0, forecastle },
        (struct pel_vec3){ h->x1 - 0.35 * (h->x1 - h->x0), 0, h->top },
        (struct pel_vec3){ h->x1, h->wings / 2, h->bridge + 1 },
        (struct pel_vec3){ -s->length / 2, 0, h->z0 + 2 });
}

/* Full hulls with a bulb and a flat transom stern. */
static struct pel_hull_lines cargo_hull(const struct pel_kind_size *s,
                                        double freeboard)
{
    return (struct pel_hull_lines){
        .length = s->length,
        .beam = s->beam,
        .draught = s->draught,
        .freeboard = freeboard,
        .sheer_fore = 0.25 * freeboard,
        .sheer_aft = 0,
        .stem_rake = 0.022 * s->length,
        .keel_rake = 0.03 * s->length,
        .counter = 0.012 * s->length,
        .cutaway = 0.05 * s->length,
        .power = 9,
        .power_ends = 3,
        .entrance = 0.2,
        .run = 0.28,
        .bow_power = 2.6,
        .bow_round = 1.7,
        .stern_power = 2.2,
        .transom = 0.75,
        .transom_deep = 0.06,
        .flare = 0.4,
        .strake = 0.05 * s->draught,
        .strake_colour = PEL_BOOT_RED,
        .bottom = PEL_BOOT_RED,
        .side = s->colour,
        .deck = PEL_DECK_RED,
        .bulb = 0.022 * s->length,
        .rudder = true,
        .stations = 40,
    };
}

/* A forecastle: the deck one step higher, from x to the stem. */
static void draw_forecastle(struct pel_pen *pen, const struct pel_hull_lines *h,
                            double x, double step)
{
    enum { N = 9 };
    struct pel_vec2 outline[2 * N];
    double end = h->length / 2 - 0.002 * h->length;
    for (int i = 0; i < N; i++) {
        double at = x + (end - x) * i / (N - 1);
        double half = fmax(pel_hull_half(h, at) - 0.05, 0.05);
        outline[i] = (struct pel_vec2){ at, -half };
        outline[2 * N - 1 - i] = (struct pel_vec2){ at, half };
    }
    pel_pen_node(pen, "forecastle");
    pel_pen_paint(pen, h->side, 0.35);
    double z = pel_hull_deck(h, x);
    pel_solid_tower(pen, outline, 2 * N, z - 0.3, pel_hull_deck(h, end) + step,
                    1, 0, 0);
}

/* --- containers --------------------------------------------------------------
 */

#define BOX_LONG 12.19
#define BOX_WIDE 2.5
#define BOX_HIGH 2.6
#define BAY 14.0
#define MOST_ROWS 26
#define MOST_TIERS 12

static const uint32_t box_colours[] = {
    0x8c2f24, 0x8c2f24, 0x1f4e7a, 0x1f4e7a, 0x2d6b46, 0xb8b8b2,
    0xc8752a, 0x6b2a2a, 0x39424c, 0x2a7d86, 0xcfc8b4, 0x8f3550,
};

static void set_box_paint(struct pel_pen *pen, uint32_t n)
{
    pel_pen_paint(
        pen,
        box_colours[scatter(n) % (sizeof box_colours / sizeof *box_colours)],
        0.6);
}

/* A bay: what of its boxes is outside, so that the whole is one body. */
static void draw_bay(struct pel_pen *pen, double x, double z, int rows,
                     const int tiers[MOST_ROWS + 2], uint32_t seed)
{
    double x1 = x + BOX_LONG;
    for (int r = 1; r <= rows; r++) {
        double y0 = (r - 1 - 0.5 * rows) * BOX_WIDE;
        double y1 = (r - 0.5 * rows) * BOX_WIDE;
        for (int t = 0; t < tiers[r]; t++) {
            double z0 = z + t * BOX_HIGH, z1 = z + (t + 1) * BOX_HIGH;
            struct pel_vec3 p[8];
            for (int i = 0; i < 8; i++) {
                p[i] = (struct pel_vec3){ i & 1 ? x1 : x, i & 2 ? y1 : y0,
                                          i & 4 ? z1 : z0 };
            }
            set_box_paint(pen, seed + (uint32_t)(r * 31 + t));
            pel_solid_quad(pen, p[1], p[3], p[7], p[5]);
            pel_solid_quad(pen, p[2], p[0], p[4], p[6]);
            if (t >= tiers[r - 1]) {
                pel_solid_quad(pen, p[0], p[1], p[5], p[4]);
            }
            if (t >= tiers[r + 1]) {
                pel_solid_quad(pen, p[3], p[2], p[6], p[7]);
            }
            if (t == 0) {
                pel_solid_quad(pen, p[0], p[2], p[3], p[1]);
            }
            if (t == tiers[r] - 1) {
                pel_solid_quad(pen, p[4], p[5], p[7], p[6]);
            }
        }
    }
}

/* Bays from x0 to x1, at most as high as what the bridge sees over. */
static void draw_containers(struct pel_pen *pen, const struct pel_hull_lines *h,
                            double x0, double x1, int tiers, double z)
{
    int bays = (int)((x1 - x0) / BAY);
    for (int b = 0; b < bays; b++) {
        double x = x1 - (b + 1) * BAY + (BAY - BOX_LONG) / 2;
        double half = fmin(pel_hull_half(h, x), pel_hull_half(h, x + BOX_LONG));
        int rows = (int)(2 * half / BOX_WIDE);
        int high[MOST_ROWS + 2] = { 0 };
        rows = rows < MOST_ROWS ? rows : MOST_ROWS;
        for (int r = 1; r <= rows; r++) {
            uint32_t n = scatter((uint32_t)(b * 97 + r * 5 + (int)x0));
            high[r] = tiers - (n % 9 == 0) - (scatter((uint32_t)b) % 5 == 0);
            if (x > 0.33 * h->length) {
                high[r] -= 2;
            }
            high[r] = high[r] < 1 ? 1 : high[r];
        }
        pel_pen_node(pen, "containers");
        draw_bay(pen, x, z, rows, high, (uint32_t)(b * 1000 + 7));
        /* The lashing bridge before it. */
        pel_pen_node(pen, "lashing bridge");
        pel_pen_paint(pen, 0x5a6066, 0.7);
        pel_solid_block(pen, x + BOX_LONG + 0.5, x + BOX_LONG + 1.3,
                        rows * BOX_WIDE, z - 1, z + 1.2 * BOX_HIGH);
    }
}

void pel_kind_container_ship(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double unit = s->length / 294;
    struct pel_hull_lines hull = cargo_hull(s, 0.2 * s->height);
    hull.entrance = 0.4;
    hull.bow_power = 1.8;
    hull.bow_round = 1.15;
    hull.flare = 0.75;
    hull.stem_rake = 0.03 * s->length;
    hull.keel_rake = 0.042 * s->length;
    hull.run = 0.4;
    hull.power = 6;
    hull.power_ends = 2;
    hull.transom = 0.92;
    hull.sheer_fore = 0.3 * hull.freeboard;
    double z = hull.freeboard + 0.15 * hull.freeboard;
    struct house house = { .x0 = -0.27 * s->length,
                           .x1 = -0.27 * s->length + 15 * unit,
                           .wide = 0.78 * s->beam,
                           .z0 = hull.freeboard,
                           .bridge = 0.76 * s->height,
                           .wings = s->beam,
                           .top = s->height,
                           .funnel = s->colour };
    int tiers = (int)((house.bridge - 3 - z) / BOX_HIGH);
    tiers = tiers > MOST_TIERS ? MOST_TIERS : tiers < 1 ? 1 : tiers;
    pel_hull_draw(pen, &hull);
    draw_forecastle(pen, &hull, 0.435 * s->length, 0.15 * hull.freeboard);
    pel_pen_node(pen, "hatches");
    pel_pen_paint(pen, 0x6d5148, 0.7);
    pel_solid_block(pen, house.x1 + 2 * unit, 0.36 * s->length, 0.86 * s->beam,
                    hull.freeboard - 0.5, z);
    pel_solid_block(pen, -0.475 * s->length, house.x0 - 15 * unit,
                    0.86 * s->beam, hull.freeboard - 0.5, z);
    draw_containers(pen, &hull, house.x1 + 2 * unit, 0.43 * s->length, tiers,
                    z);
    draw_containers(pen, &hull, -0.485 * s->length, house.x0 - 14 * unit,
                    tiers - 1, z);
    draw_house(pen, &house);
    double fore = 0.465 * s->length;
    draw_foremast(pen, fore, hull.freeboard, 0.62 * s->height);
    set_lights(pen, s, &house, 0.62 * s->height, fore);
}

/* --- tanker
 * ------------------------------------------------------------------- */

static void draw_pipes(struct pel_pen *pen, const struct pel_kind_size *s,
                       double z, double x0, double x1)
{
    double unit = s->beam / 42;
    pel_pen_node(pen, "pipes");
    pel_pen_paint(pen, 0x8f5a4a, 0.6);
    for (int i = -2; i <= 2; i++) {
        double y = i * 1.3 * unit;
        pel_solid_pole(pen, (struct pel_vec3){ x0, y, z + 1.5 * unit },
                       (struct pel_vec3){ x1, y, z + 1.5 * unit }, 0.35 * unit,
                       0.35 * unit, 6);
    }
    pel_pen_paint(pen, 0xb0a89a, 0.6);
    pel_solid_block(pen, x0, x1, 1.6 * unit, z + 2.4 * unit, z + 2.7 * unit);
    for (int i = 0; i < 12; i++) {
        double x = x0 + (x1 - x0) * (i + 0.5) / 12;
        pel_solid_block(pen, x, x + 0.5 * unit, 7 * unit, z - 0.2,
                        z + 1.1 * unit);
        pel_solid_block(pen, x, x + 0.4 * unit, 0.5 * unit, z, z + 2.5 * unit);
    }
    /* The manifold amidships, from side to side. */
    pel_pen_paint(pen, 0x8f5a4a, 0.6);
    for (int i = -2; i <= 2; i++) {
        double x = i * 2.5 * unit;
        pel_solid_pole(pen,
                       (struct pel_vec3){ x, -0.4 * s->beam, z + 1.8 * unit },
                       (struct pel_vec3){ x, 0.4 * s->beam, z + 1.8 * unit },
                       0.4 * unit, 0.4 * unit, 6);
    }
}

/* A crane on a post: its jib stowed towards `to`. */
static void draw_crane(struct pel_pen *pen, double x, double y, double z0,
                       double post, double thick, struct pel_vec3 to,
                       uint32_t colour)
{
    pel_pen_node(pen, "crane");
    pel_pen_paint(pen, colour, 0.5);
    struct pel_vec3 foot = { x, y, z0 }, top = { x, y, z0 + post };
    pel_solid_pole(pen, foot, top, thick, 0.8 * thick, 10);
    pel_solid_box(pen, x - 1.3 * thick, x + 1.3 * thick, y - 1.2 * thick,
                  y + 1.2 * thick, z0 + 0.78 * post, z0 + 1.1 * post);
    struct pel_vec3 root = { x, y, z0 + 0.84 * post };
    pel_solid_pole(pen, root, to, 0.4 * thick, 0.22 * thick, 4);
    struct pel_vec3 peak = { x, y, z0 + 1.3 * post };
    pel_solid_pole(pen, top, peak, 0.3 * thick, 0.2 * thick, 4);
    pel_solid_pole(pen, peak, to, 0.07 * thick, 0.07 * thick, 4);
}

void pel_kind_tanker(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double unit = s->length / 244;
    struct pel_hull_lines hull = cargo_hull(s, 0.14 * s->height);
    hull.entrance = 0.16;
    hull.bow_power = 3.2;
    hull.bow_round = 2;
    hull.flare = 0.2;
    hull.sheer_fore = 0.35 * hull.freeboard;
    hull.power = 14;
    struct house house = { .x0 = -0.405 * s->length,
                           .x1 = -0.405 * s->length + 15 * unit,
                           .wide = 0.62 * s->beam,
                           .z0 = hull.freeboard - 0.2,
                           .bridge = 0.62 * s->height,
                           .wings = s->beam,
                           .top = s->height,
                           .funnel = 0xb8862b };
    pel_hull_draw(pen, &hull);
    draw_forecastle(pen, &hull, 0.45 * s->length, 0.15 * hull.freeboard);
    draw_pipes(pen, s, hull.freeboard, house.x1, 0.43 * s->length);
    draw_crane(pen, 4 * unit, 0.12 * s->beam, hull.freeboard, 12 * unit,
               1.1 * unit,
               (struct pel_vec3){ -16 * unit, 0.12 * s->beam,
                                  hull.freeboard + 11.5 * unit },
               PEL_SHIP_WHITE);
    draw_crane(pen, 4 * unit, -0.12 * s->beam, hull.freeboard, 12 * unit,
               1.1 * unit,
               (struct pel_vec3){ -16 * unit, -0.12 * s->beam,
                                  hull.freeboard + 11.5 * unit },
               PEL_SHIP_WHITE);
    draw_house(pen, &house);
    double fore = 0.47 * s->length;
    draw_foremast(pen, fore, hull.freeboard, 0.55 * s->height);
    set_lights(pen, s, &house, 0.55 * s->height, fore);
}

/* --- bulk carrier
 * ---------------------------------------------------------------- */

void pel_kind_bulk_carrier(struct pel_pen *pen, const struct pel_kind_size *s)
{
    enum { HOLDS = 5 };
    double unit = s->length / 190;
    struct pel_hull_lines hull = cargo_hull(s, 0.15 * s->height);
    hull.entrance = 0.17;
    hull.bow_power = 3;
    hull.bow_round = 2;
    hull.flare = 0.25;
    hull.power = 12;
    hull.sheer_fore = 0.4 * hull.freeboard;
    struct house house = { .x0 = -0.41 * s->length,
                           .x1 = -0.41 * s->length + 12 * unit,
                           .wide = 0.66 * s->beam,
                           .z0 = hull.freeboard - 0.2,
                           .bridge = 0.63 * s->height,
                           .wings = s->beam,
                           .top = s->height,
                           .funnel = 0x24507a };
    pel_hull_draw(pen, &hull);
    draw_forecastle(pen, &hull, 0.44 * s->length, 0.3 * hull.freeboard);
    double x0 = house.x1 + 3 * unit, x1 = 0.42 * s->length;
    double pitch = (x1 - x0) / HOLDS, z = hull.freeboard;
    for (int i = 0; i < HOLDS; i++) {
        double at = x0 + i * pitch;
        double half = fmin(0.28 * s->beam,
                           0.75 * pel_hull_half(&hull, at + 0.85 * pitch));
        pel_pen_node(pen, "hatch");
        pel_pen_paint(pen, 0x7a5348, 0.7);
        pel_solid_box(pen, at + 0.14 * pitch, at + 0.86 * pitch, -half, half,
                      z - 0.3, z + 1.6 * unit);
        pel_pen_paint(pen, 0x8a6a58, 0.7);
        pel_solid_box(pen, at + 0.12 * pitch, at + 0.88 * pitch, -1.08 * half,
                      1.08 * half, z + 1.6 * unit, z + 2.5 * unit);
        if (i > 0) {
            draw_crane(pen, at, 0, z, 15 * unit, 1.5 * unit,
                       (struct pel_vec3){ at + 0.82 * pitch, 0, z + 9 * unit },
                       0xc9b27a);
        }
    }
    draw_house(pen, &house);
    double fore = 0.47 * s->length;
    draw_foremast(pen, fore, hull.freeboard, 0.6 * s->height);
    set_lights(pen, s, &house, 0.6 * s->height, fore);
}
