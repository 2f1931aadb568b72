/* Marks: buoys of the IALA system, a beacon, a light float. Colours and
 * topmarks as IALA Recommendation R1001. */
#include "models/kinds.h"

#define RED 0xb3161c
#define GREEN 0x0b7a43
#define YELLOW 0xf0b400
#define WHITE 0xececec
#define BLACK 0x141416

#define SIDES 20

/* --- topmarks
 * ------------------------------------------------------------------ */

/* Each stands on z, `d` wide and about as high. */
static void top_can(struct pel_pen *pen, double z, double d)
{
    const struct pel_vec2 p[] = { { d / 2, z }, { d / 2, z + d } };
    pel_solid_turned(pen, p, 2, 0, 0, 12);
}

static void top_cone(struct pel_pen *pen, double z, double d, bool up)
{
    const struct pel_vec2 p[] = { { up ? d / 2 : 0, z },
                                  { up ? 0 : d / 2, z + d } };
    pel_solid_turned(pen, p, 2, 0, 0, 12);
}

static void top_ball(struct pel_pen *pen, double z, double d)
{
    pel_solid_ellipsoid(pen, (struct pel_vec3){ 0, 0, z + d / 2 }, d / 2, d / 2,
                        d / 2, 14);
}

static void top_cross(struct pel_pen *pen, double z, double d)
{
    for (int side = -1; side <= 1; side += 2) {
        struct pel_vec3 low = { 0, side * -0.45 * d, z + 0.05 * d };
        struct pel_vec3 high = { 0, side * 0.45 * d, z + 0.95 * d };
        pel_solid_pole(pen, low, high, 0.12 * d, 0.12 * d, 6);
        low.x = low.y;
        high.x = high.y;
        low.y = high.y = 0;
        pel_solid_pole(pen, low, high, 0.12 * d, 0.12 * d, 6);
    }
}

/* --- bodies
 * -------------------------------------------------------------------- */

/* The float of a buoy with its tail tube and weight below the water. */
static void draw_float(struct pel_pen *pen, const struct pel_kind_size *s,
                       uint32_t colour)
{
    double r = s->length / 2, t = s->draught;
    const struct pel_vec2 body[] = {
        { 0.35 * r, -0.42 * t }, { 0.88 * r, -0.24 * t }, { r, -0.12 * t },
        { r, 0.25 * r },         { 0.94 * r, 0.32 * r },  { 0.5 * r, 0.4 * r }
    };
    const struct pel_vec2 tail[] = { { 0.3 * r, -t },
                                     { 0.3 * r, -0.85 * t },
                                     { 0.15 * r, -0.85 * t },
                                     { 0.15 * r, -0.4 * t } };
    pel_pen_node(pen, "hull");
    pel_pen_paint(pen, colour, 0.5);
    pel_solid_turned(pen, body, 6, 0, 0, SIDES);
    pel_pen_paint(pen, 0x3c3228, 0.9);
    pel_solid_turned(pen, tail, 4, 0, 0, 10);
}

static void lantern(struct pel_pen *pen, double z, double size,
                    const char *name, uint32_t colour, double miles)
{
    pel_pen_node(pen, "lantern");
    pel_pen_paint(pen, 0x2a2c2e, 0.5);
    const struct pel_vec2 base[] = { { 0.3 * size, z },
                                     { 0.3 * size, z + 0.3 * size } };
    pel_solid_turned(pen, base, 2, 0, 0, 10);
    pel_pen_paint(pen, 0xb8c4c8, 0.1);
    const struct pel_vec2 lens[] = { { 0.26 * size, z + 0.3 * size },
                                     { 0.28 * size, z + 0.75 * size },
                                     { 0, z + size } };
    pel_solid_turned(pen, lens, 3, 0, 0, 10);
    pel_kind_light(pen, name, colour, miles, 0, 0,
                   (struct pel_vec3){ 0, 0, z + 0.55 * size });
}

/* A tower in bands, each a colour of equal height from below. */
static void draw_bands(struct pel_pen *pen, double r0, double r1, double z0,
                       double z1, const uint32_t *colours, int count)
{
    pel_pen_node(pen, "tower");
    for (int i = 0; i < count; i++) {
        double a = (double)i / count, b = (double)(i + 1) / count;
        const struct pel_vec2 p[] = {
            { r0 + (r1 - r0) * a, z0 + (z1 - z0) * a },
            { r0 + (r1 - r0) * b, z0 + (z1 - z0) * b }
        };
        pel_pen_paint(pen, colours[i], 0.5);
        pel_solid_turned(pen, p, 2, 0, 0, SIDES);
    }
}

static void topmark_pole(struct pel_pen *pen, double z0, double z1)
{
    pel_pen_node(pen, "topmark");
    pel_pen_paint(pen, 0x2a2c2e, 0.6);
    pel_solid_pole(pen, (struct pel_vec3){ 0, 0, z0 },
                   (struct pel_vec3){ 0, 0, z1 }, 0.05, 0.05, 6);
}

/* --- lateral
 * --------------------------------------------------------------------- */

static void draw_lateral(struct pel_pen *pen, const struct pel_kind_size *s,
                         bool port, uint32_t colour, uint32_t light)
{
    double h = s->height, r = s->length / 2, low = 0.36 * r;
    double body = port ? 0.6 * h : 0.64 * h, d = 0.17 * h;
    draw_float(pen, s, colour);
    pel_pen_node(pen, "body");
    pel_pen_paint(pen, colour, 0.5);
    const struct pel_vec2 can[] = { { 0.62 * r, low }, { 0.62 * r, body } };
    const struct pel_vec2 cone[] = { { 0.8 * r, low }, { 0.09 * r, body } };
    pel_solid_turned(pen, port ? can : cone, 2, 0, 0, SIDES);
    /* The lantern before the topmark's pole, which carries it all. */
    topmark_pole(pen, body - 0.1, h - 0.22 * h);
    pel_pen_paint(pen, colour, 0.5);
    if (port) {
        top_can(pen, h - 0.31 * h, d);
    } else {
        top_cone(pen, h - 0.31 * h, d, true);
    }
    lantern(pen, h - 0.13 * h, 0.13 * h, port ? "port hand" : "starboard hand",
            light, 4);
}

void pel_kind_port_a(struct pel_pen *pen, const struct pel_kind_size *s)
{
    draw_lateral(pen, s, true, RED, 0xff0000);
}

void pel_kind_starboard_a(struct pel_pen *pen, const struct pel_kind_size *s)
{
    draw_lateral(pen, s, false, GREEN, 0x00ff40);
}

void pel_kind_port_b(struct pel_pen *pen, const struct pel_kind_size *s)
{
    draw_lateral(pen, s, true, GREEN, 0x00ff40);
}

void pel_kind_starboard_b(struct pel_pen *pen, const struct pel_kind_size *s)
{
    draw_lateral(pen, s, false, RED, 0xff0000);
}

/* --- cardinal
 * ---------------------------------------------------------------------- */

static void draw_pillar(struct pel_pen *pen, const struct pel_kind_size *s,
                        const uint32_t bands[3])
{
    draw_float(pen, s, bands[0]);
    draw_bands(pen, 0.42 * s->length / 2, 0.26 * s->length / 2,
               0.19 * s->length, 0.52 * s->height, bands, 3);
}

/* Up or down, the lower and the upper cone; the cones point to the black. */
static void draw_cardinal(struct pel_pen *pen, const struct pel_kind_size *s,
                          const uint32_t bands[3], bool low_up, bool high_up,
                          const char *name)
{
    double h = s->height, d = 0.155 * h;
    draw_pillar(pen, s, bands);
    topmark_pole(pen, 0.51 * h, 0.93 * h);
    pel_pen_paint(pen, BLACK, 0.6);
    top_cone(pen, 0.55 * h, d, low_up);
    top_cone(pen, 0.55 * h + 1.12 * d, d, high_up);
    lantern(pen, 0.91 * h, 0.09 * h, name, 0xffffff, 5);
}

void pel_kind_north(struct pel_pen *pen, const struct pel_kind_size *s)
{
    const uint32_t bands[] = { YELLOW, YELLOW, BLACK };
    draw_cardinal(pen, s, bands, true, true, "Q");
}

void pel_kind_east(struct pel_pen *pen, const struct pel_kind_size *s)
{
    const uint32_t bands[] = { BLACK, YELLOW, BLACK };
    draw_cardinal(pen, s, bands, false, true, "Q(3)10s");
}

void pel_kind_south(struct pel_pen *pen, const struct pel_kind_size *s)
{
    const uint32_t bands[] = { BLACK, BLACK, YELLOW };
    draw_cardinal(pen, s, bands, false, false, "Q(6)+LFl15s");
}

void pel_kind_west(struct pel_pen *pen, const struct pel_kind_size *s)
{
    const uint32_t bands[] = { YELLOW, BLACK, YELLOW };
    draw_cardinal(pen, s, bands, true, false, "Q(9)15s");
}

/* --- the others
 * ------------------------------------------------------------------------ */

void pel_kind_safe_water(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double h = s->height, r0 = 0.42 * s->length / 2, r1 = 0.26 * s->length / 2;
    double z0 = 0.19 * s->length, z1 = 0.64 * h;
    draw_float(pen, s, RED);
    /* Vertical stripes: wedges of the tower. */
    pel_pen_node(pen, "tower");
    for (int i = 0; i < 8; i++) {
        double a = 2 * PEL_PI * i / 8, b = 2 * PEL_PI * (i + 1) / 8;
        double m = (a + b) / 2;
        const struct pel_vec2 wedge[] = { { 0, 0 },
                                          { r0 * cos(a), r0 * sin(a) },
                                          { r0 * cos(m), r0 * sin(m) },
                                          { r0 * cos(b), r0 * sin(b) } };
        pel_pen_paint(pen, i & 1 ? WHITE : RED, 0.5);
        pel_solid_tower(pen, wedge, 4, z0, z1, r1 / r0, 0, 0);
    }
    topmark_pole(pen, z1 - 0.05, 0.91 * h);
    pel_pen_paint(pen, RED, 0.5);
    top_ball(pen, 0.7 * h, 0.15 * h);
    lantern(pen, 0.9 * h, 0.1 * h, "LFl10s", 0xffffff, 5);
}

void pel_kind_special(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double h = s->height;
    const uint32_t bands[] = { YELLOW };
    draw_float(pen, s, YELLOW);
    draw_bands(pen, 0.5 * s->length / 2, 0.3 * s->length / 2, 0.19 * s->length,
               0.62 * h, bands, 1);
    topmark_pole(pen, 0.6 * h, 0.9 * h);
    pel_pen_paint(pen, YELLOW, 0.5);
    top_cross(pen, 0.66 * h, 0.2 * h);
    lantern(pen, 0.88 * h, 0.12 * h, "special", 0xffc000, 4);
}

void pel_kind_isolated_danger(struct pel_pen *pen,
                              const struct pel_kind_size *s)
{
    double h = s->height, d = 0.155 * h;
    const uint32_t bands[] = { BLACK, RED, BLACK };
    draw_pillar(pen, s, bands);
    topmark_pole(pen, 0.51 * h, 0.93 * h);
    pel_pen_paint(pen, BLACK, 0.6);
    top_ball(pen, 0.55 * h, d);
    top_ball(pen, 0.55 * h + 1.1 * d, d);
    lantern(pen, 0.91 * h, 0.09 * h, "Fl(2)5s", 0xffffff, 5);
}

void pel_kind_beacon(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double h = s->height, r = 0.15 * s->length, wide = s->length / 2;
    pel_pen_node(pen, "hull");
    pel_pen_paint(pen, 0x5a5048, 0.9);
    const struct pel_vec2 foot[] = { { r, -s->draught }, { r, 0.12 * h } };
    pel_solid_turned(pen, foot, 2, 0, 0, 14);
    pel_pen_node(pen, "pile");
    for (int i = 0; i < 4; i++) {
        pel_pen_paint(pen, i & 1 ? WHITE : RED, 0.5);
        const struct pel_vec2 band[] = { { r, (0.12 + 0.12 * i) * h },
                                         { r, (0.12 + 0.12 * (i + 1)) * h } };
        pel_solid_turned(pen, band, 2, 0, 0, 14);
    }
    pel_pen_node(pen, "platform");
    pel_pen_paint(pen, 0x7d8387, 0.6);
    const struct pel_vec2 platform[] = {
        { r, 0.56 * h }, { wide, 0.6 * h }, { wide, 0.62 * h }, { r, 0.62 * h }
    };
    pel_solid_turned(pen, platform, 4, 0, 0, 16);
    for (int i = 0; i < 8; i++) {
        double a = 2 * PEL_PI * i / 8, x = 0.95 * wide * cos(a);
        double y = 0.95 * wide * sin(a), z = 0.62 * h;
        pel_solid_pole(pen, (struct pel_vec3){ x, y, z - 0.02 },
                       (struct pel_vec3){ x, y, z + 1.1 }, 0.03, 0.03, 4);
    }
    struct pel_vec3 rail[16];
    for (int i = 0; i < 16; i++) {
        double a = 2 * PEL_PI * i / 16;
        rail[i] = (struct pel_vec3){ 0.95 * wide * cos(a), 0.95 * wide * sin(a),
                                     0.62 * h + 1.1 };
    }
    pel_solid_tube(pen, rail, 16, 0.03, 4, true);
    pel_pen_node(pen, "daymark");
    pel_pen_paint(pen, RED, 0.5);
    pel_solid_turned(pen,
                     (const struct pel_vec2[]){ { 0.55 * wide, 0.62 * h },
                                                { 0.55 * wide, 0.84 * h } },
                     2, 0, 0, 14);
    lantern(pen, 0.84 * h, 0.14 * h, "beacon", 0xffffff, 9);
    pel_solid_pole(pen, (struct pel_vec3){ 0, 0, 0.97 * h },
                   (struct pel_vec3){ 0, 0, h }, 0.02, 0.02, 4);
    pel_pen_node(pen, "ladder");
    pel_pen_paint(pen, 0x7d8387, 0.6);
    for (int side = -1; side <= 1; side += 2) {
        pel_solid_pole(pen, (struct pel_vec3){ r + 0.1, side * 0.2, -1 },
                       (struct pel_vec3){ r + 0.1, side * 0.2, 0.58 * h }, 0.03,
                       0.03, 4);
    }
}

void pel_kind_light_float(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, b = s->beam, h = s->height;
    struct pel_hull_lines hull = { .length = l,
                                   .beam = b,
                                   .draught = s->draught,
                                   .freeboard = 0.1 * h,
                                   .sheer_fore = 0.05 * h,
                                   .sheer_aft = 0.05 * h,
                                   .stem_rake = 0.06 * l,
                                   .keel_rake = 0.12 * l,
                                   .counter = 0.06 * l,
                                   .cutaway = 0.12 * l,
                                   .power = 4,
                                   .power_ends = 2,
                                   .entrance = 0.45,
                                   .run = 0.45,
                                   .bow_power = 2,
                                   .bow_round = 1.2,
                                   .stern_power = 2.4,
                                   .transom = 0.15,
                                   .flare = 0.3,
                                   .bottom = 0x3c2420,
                                   .side = s->colour,
                                   .deck = s->colour,
                                   .stations = 24 };
    pel_hull_draw(pen, &hull);
    double z0 = hull.freeboard - 0.1, z1 = 0.78 * h;
    pel_pen_node(pen, "tower");
    pel_pen_paint(pen, s->colour, 0.5);
    for (int i = 0; i < 4; i++) {
        double x = i & 1 ? 1 : -1, y = i & 2 ? 1 : -1;
        pel_solid_pole(pen, (struct pel_vec3){ 0.14 * l * x, 0.3 * b * y, z0 },
                       (struct pel_vec3){ 0.04 * l * x, 0.1 * b * y, z1 }, 0.1,
                       0.08, 6);
    }
    for (int i = 1; i <= 3; i++) {
        double t = 0.28 * i, z = z0 + (z1 - z0) * t;
        double x = (0.14 - 0.1 * t) * l, y = (0.3 - 0.2 * t) * b;
        const struct pel_vec3 ring[] = {
            { x, y, z }, { -x, y, z }, { -x, -y, z }, { x, -y, z }
        };
        pel_solid_tube(pen, ring, 4, 0.06, 5, true);
    }
    pel_pen_node(pen, "panel");
    pel_pen_paint(pen, WHITE, 0.5);
    pel_solid_block(pen, -0.08 * l, 0.08 * l, 0.3 * b, 0.45 * h, 0.62 * h);
    pel_pen_node(pen, "gallery");
    pel_pen_paint(pen, s->colour, 0.5);
    const struct pel_vec2 gallery[] = { { 0.22 * b, z1 - 0.1 },
                                        { 0.3 * b, z1 + 0.1 },
                                        { 0.3 * b, z1 + 0.25 } };
    pel_solid_turned(pen, gallery, 3, 0, 0, 12);
    lantern(pen, z1 + 0.25, h - z1 - 0.25, "light float", 0xffffff, 10);
}
