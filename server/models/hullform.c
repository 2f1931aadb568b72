#include <string.h>

#include "models/solid.h"

#define BELOW 8 /* rows from keel to waterline */
#define ABOVE 4 /* rows from strake to deck */
#define MOST_ROWS (BELOW + ABOVE + 2)
#define MOST_STATIONS 64

static double mixed(double a, double b, double t)
{
    return a + (b - a) * t;
}

static double smooth(double t)
{
    t = pel_clamp(t, 0, 1);
    return t * t * (3 - 2 * t);
}

/* Height of the deck's edge where the deck is `s` of its length from the
 * stern: a parabola each way from a third of the length before the stern. */
static double edge(const struct pel_hull_lines *h, double s)
{
    const double lowest = 0.4;
    double t = s > lowest ? (s - lowest) / (1 - lowest) : (lowest - s) / lowest;
    return h->freeboard + (s > lowest ? h->sheer_fore : h->sheer_aft) * t * t;
}

/* The breadth of a waterline at s, of its largest; `deck` is 0 at the
 * waterline and below, 1 at the deck; `deep` 1 at the keel. */
static double outline(const struct pel_hull_lines *h, double s, double deck,
                      double deep)
{
    double entrance = h->entrance * (1 - 0.5 * h->flare * deck);
    double power = h->bow_power * (1 + h->flare * deck);
    double transom =
        mixed(mixed(h->transom, h->transom_deep, 0.5), h->transom, deck);
    transom =
        deep > 0 ? mixed(transom, h->transom_deep, smooth(deep)) : transom;
    if (s > 1 - entrance) {
        double t = pel_clamp((s - 1 + entrance) / entrance, 0, 1);
        return pow(1 - pow(t, power), 1 / h->bow_round);
    }
    if (s < h->run) {
        double t = (h->run - s) / h->run;
        return transom + (1 - transom) * (1 - pow(t, h->stern_power));
    }
    return 1;
}

/* Fore and after end at a height: 0 keel, 1 waterline, 2 deck. */
static void ends(const struct pel_hull_lines *h, double level, double *aft,
                 double *fore)
{
    double below = smooth(pel_clamp(1 - level, 0, 1));
    double above = pel_clamp(level - 1, 0, 1);
    *fore = h->length / 2 - h->stem_rake * (1 - pow(above, 0.8)) -
            (h->keel_rake - h->stem_rake) * below;
    *aft = -h->length / 2 + h->counter * (1 - above) +
           (h->cutaway - h->counter) * below;
}

/* One point of the port side. Row `row` of the rows, s from the stern. */
static struct pel_vec3 point(const struct pel_hull_lines *h, double row,
                             double s)
{
    double aft, fore, y, z;
    double narrow = h->narrow > 0 ? h->narrow : 1;
    if (row <= BELOW) {
        /* A superellipse by its angle. */
        double towards = fabs(2 * s - 1);
        double power =
            mixed(h->power, h->power_ends, smooth((towards - 0.3) / 0.7));
        double a = PEL_PI / 2 * row / BELOW;
        double up = row >= BELOW ? 1 : 1 - pow(cos(a), 2 / power);
        ends(h, up, &aft, &fore);
        z = row >= BELOW ? 0 : -h->draught * (1 - up);
        y = (row > 0 ? pow(sin(a), 2 / power) : 0) * narrow *
            outline(h, s, 0, 1 - up);
    } else {
        double strake = h->strake / edge(h, s);
        double up = row <= BELOW + 1
                        ? (row - BELOW) * strake
                        : strake + (1 - strake) * (row - BELOW - 1) / ABOVE;
        ends(h, 1 + up, &aft, &fore);
        z = edge(h, s) * up;
        y = mixed(narrow, 1, smooth(up)) * outline(h, s, up, 0);
    }
    return (struct pel_vec3){ mixed(aft, fore, s), y * h->beam / 2, z };
}

/* Stations lie closer at the ends. */
static double station(int i, int count)
{
    double t = (double)i / (count - 1);
    return mixed(t, (1 - cos(PEL_PI * t)) / 2, 0.8);
}

double pel_hull_deck(const struct pel_hull_lines *h, double x)
{
    return edge(h, pel_clamp(x / h->length + 0.5, 0, 1));
}

double pel_hull_half(const struct pel_hull_lines *h, double x)
{
    return h->beam / 2 * outline(h, pel_clamp(x / h->length + 0.5, 0, 1), 1, 0);
}

static struct pel_vec3 mirror(struct pel_vec3 p)
{
    return (struct pel_vec3){ p.x, -p.y, p.z };
}

/* A patch of the port side, and the same of starboard. */
static void both(struct pel_pen *pen, struct pel_vec3 a, struct pel_vec3 b,
                 struct pel_vec3 c, struct pel_vec3 d)
{
    pel_solid_quad(pen, a, b, c, d);
    pel_solid_quad(pen, mirror(d), mirror(c), mirror(b), mirror(a));
}

static void draw_sides(struct pel_pen *pen, const struct pel_hull_lines *h,
                       int rows, int stations)
{
    for (int r = 0; r < rows - 1; r++) {
        bool strake = h->strake > 0 && r == BELOW;
        pel_pen_paint(pen,
                      r < BELOW ? h->bottom
                      : strake  ? h->strake_colour
                                : h->side,
                      r < BELOW ? 0.7 : 0.35);
        for (int i = 0; i < stations - 1; i++) {
            double s0 = station(i, stations), s1 = station(i + 1, stations);
            both(pen, point(h, r, s1), point(h, r, s0), point(h, r + 1, s0),
                 point(h, r + 1, s1));
        }
        /* The transom, and a round stem's flat. */
        struct pel_vec3 low = point(h, r, 0), high = point(h, r + 1, 0);
        pel_solid_quad(pen, low, mirror(low), mirror(high), high);
        low = point(h, r, 1);
        high = point(h, r + 1, 1);
        pel_solid_quad(pen, mirror(low), low, high, mirror(high));
    }
}

static void draw_deck(struct pel_pen *pen, const struct pel_hull_lines *h,
                      int rows, int stations)
{
    pel_pen_paint(pen, h->deck, 0.8);
    for (int i = 0; i < stations - 1; i++) {
        struct pel_vec3 aft = point(h, rows - 1, station(i, stations));
        struct pel_vec3 fore = point(h, rows - 1, station(i + 1, stations));
        pel_solid_quad(pen, mirror(aft), mirror(fore), fore, aft);
    }
}

/* A wall around the deck, with a flat top. */
static void draw_bulwark(struct pel_pen *pen, const struct pel_hull_lines *h,
                         int rows, int stations)
{
    double thick = fmax(0.04, 0.008 * h->beam);
    pel_pen_paint(pen, h->side, 0.35);
    for (int side = 0; side < 2; side++) {
        struct pel_vec3 last[4];
        for (int i = 0; i < stations; i++) {
            struct pel_vec3 p = point(h, rows - 1, station(i, stations));
            double in = fmax(p.y - thick, 0), top = p.z + h->bulwark;
            struct pel_vec3 ring[4] = { { p.x, p.y, p.z - 0.02 },
                                        { p.x, p.y, top },
                                        { p.x, in, top },
                                        { p.x, in, p.z - 0.02 } };
            for (int k = 0; k < 4 && side; k++) {
                ring[k] = mirror(ring[k]);
            }
            for (int k = 0; k < 4 && i > 0; k++) {
                int j = (k + 1) % 4;
                if (side) {
                    pel_solid_quad(pen, last[k], ring[k], ring[j], last[j]);
                } else {
                    pel_solid_quad(pen, last[j], ring[j], ring[k], last[k]);
                }
            }
            if (i == 0 || i == stations - 1) {
                bool turned = (i == 0) != (side == 0);
                pel_solid_quad(pen, ring[0], ring[turned ? 1 : 3], ring[2],
                               ring[turned ? 3 : 1]);
            }
            memcpy(last, ring, sizeof last);
        }
    }
}

static void draw_bulb(struct pel_pen *pen, const struct pel_hull_lines *h)
{
    double end = h->length / 2 - h->keel_rake;
    pel_pen_paint(pen, h->bottom, 0.7);
    pel_solid_ellipsoid(
        pen, (struct pel_vec3){ end - 0.6 * h->bulb, 0, -0.58 * h->draught },
        1.6 * h->bulb, 0.075 * h->beam + 0.08 * h->draught, 0.36 * h->draught,
        16);
}

static void draw_rudder(struct pel_pen *pen, const struct pel_hull_lines *h)
{
    double aft = -h->length / 2 + h->counter + 0.002 * h->length;
    double chord = fmax(0.018 * h->length, 0.25 * h->draught);
    const struct pel_vec2 blade[] = { { aft, -0.92 * h->draught },
                                      { aft + chord, -0.92 * h->draught },
                                      { aft + chord, -0.1 * h->draught },
                                      { aft, -0.1 * h->draught } };
    double thick = 0.08 * chord;
    pel_pen_paint(pen, h->bottom, 0.7);
    pel_solid_side(pen, blade, 4, -thick, thick);
    pel_pen_metal(pen, 0xb08040, 0.4);
    double screw = -h->length / 2 + h->cutaway;
    struct pel_vec3 boss = { screw + 0.01 * h->length, 0, -0.6 * h->draught };
    struct pel_vec3 tip = { boss.x - 0.02 * h->length - 0.1 * h->draught, 0,
                            boss.z };
    pel_solid_pole(pen, boss, tip, 0.07 * h->draught, 0.03 * h->draught, 8);
    for (int i = 0; i < 4; i++) {
        double a = PEL_PI / 2 * i + 0.3, r = 0.32 * h->draught;
        struct pel_vec3 end = { tip.x + 0.05 * h->draught, r * cos(a),
                                tip.z + r * sin(a) };
        pel_solid_pole(pen, (struct pel_vec3){ end.x, 0, tip.z }, end,
                       0.03 * h->draught, 0.09 * h->draught, PEL_SOLID_THIN);
    }
}

void pel_hull_draw(struct pel_pen *pen, const struct pel_hull_lines *hull)
{
    struct pel_hull_lines h = *hull;
    int stations = h.stations > 0 ? h.stations : 32;
    h.strake = fmax(h.strake, 0.001 * h.freeboard);
    h.strake_colour = hull->strake > 0 ? h.strake_colour : h.side;
    pel_pen_node(pen, "hull");
    draw_sides(pen, &h, MOST_ROWS, stations);
    draw_deck(pen, &h, MOST_ROWS, stations);
    if (h.bulwark > 0) {
        pel_pen_node(pen, "bulwark");
        draw_bulwark(pen, &h, MOST_ROWS, stations);
    }
    if (h.bulb > 0) {
        pel_pen_node(pen, "bulb");
        draw_bulb(pen, &h);
    }
    if (h.rudder) {
        pel_pen_node(pen, "rudder and propeller");
        draw_rudder(pen, &h);
    }
}
