/* Small things that float: yacht, inflatables, drone, raft, a person. */
#include "models/kinds.h"

/* --- sailing yacht
 * -------------------------------------------------------------- */

/* A sail: a triangle with a belly to leeward, closed, a hand thick. */
static void sail(struct pel_pen *pen, struct pel_vec3 tack,
                 struct pel_vec3 clew, struct pel_vec3 head, double belly)
{
    enum { N = 10 };
    struct pel_vec3 grid[2][N + 1][N + 1];
    for (int i = 0; i <= N; i++) {
        for (int j = 0; j <= N; j++) {
            double up = (double)i / N, out = (double)j / N;
            struct pel_vec3 a = pel_vec3_add(pel_vec3_scale(tack, 1 - up),
                                             pel_vec3_scale(head, up));
            struct pel_vec3 b = pel_vec3_add(pel_vec3_scale(clew, 1 - up),
                                             pel_vec3_scale(head, up));
            struct pel_vec3 p = pel_vec3_add(pel_vec3_scale(a, 1 - out),
                                             pel_vec3_scale(b, out));
            p.y += belly * 4 * out * (1 - out) * (0.4 + 0.6 * (1 - up)) *
                   fmin(1, 6 * up * (1 - up) + 0.25);
            grid[0][i][j] = grid[1][i][j] = p;
            if (j > 0 && j < N && i > 0 && i < N) {
                grid[0][i][j].y += 0.02;
                grid[1][i][j].y -= 0.02;
            }
        }
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            pel_solid_quad(pen, grid[1][i][j + 1], grid[1][i][j],
                           grid[1][i + 1][j], grid[1][i + 1][j + 1]);
            pel_solid_quad(pen, grid[0][i][j + 1], grid[0][i + 1][j + 1],
                           grid[0][i + 1][j], grid[0][i][j]);
        }
    }
}

static void yacht_rig(struct pel_pen *pen, const struct pel_kind_size *s,
                      double z)
{
    double l = s->length, top = s->height, mast = 0.09 * l;
    pel_pen_node(pen, "mast");
    pel_pen_metal(pen, 0xc4c8cc, 0.35);
    pel_solid_pole(pen, (struct pel_vec3){ mast, 0, z - 0.1 },
                   (struct pel_vec3){ mast, 0, top }, 0.09, 0.06, 8);
    struct pel_vec3 goose = { mast - 0.1, 0, z + 0.075 * l };
    struct pel_vec3 boom = { -0.32 * l, 0.06 * l, z + 0.085 * l };
    pel_solid_pole(pen, goose, boom, 0.06, 0.05, 8);
    for (int side = -1; side <= 1; side += 2) {
        pel_solid_pole(
            pen, (struct pel_vec3){ mast - 0.2, side * 0.42 * s->beam, z },
            (struct pel_vec3){ mast, 0, 0.96 * top }, 0.008, 0.008,
            PEL_SOLID_THIN);
    }
    struct pel_vec3 stem = { 0.48 * l, 0, z + 0.03 * l };
    pel_solid_pole(pen, stem, (struct pel_vec3){ mast, 0, 0.93 * top }, 0.012,
                   0.012, PEL_SOLID_THIN);
    pel_solid_pole(pen, (struct pel_vec3){ -0.49 * l, 0, z },
                   (struct pel_vec3){ mast, 0, top }, 0.008, 0.008,
                   PEL_SOLID_THIN);
    pel_pen_node(pen, "mainsail");
    pel_pen_paint(pen, 0xf2efe6, 0.8);
    sail(pen, (struct pel_vec3){ goose.x - 0.05, 0, goose.z + 0.15 },
         (struct pel_vec3){ boom.x + 0.1, boom.y, boom.z + 0.15 },
         (struct pel_vec3){ mast - 0.1, 0, 0.98 * top }, 0.045 * l);
    pel_pen_node(pen, "jib");
    pel_pen_paint(pen, 0xf2efe6, 0.8);
    sail(pen, (struct pel_vec3){ stem.x - 0.05, 0, stem.z + 0.4 },
         (struct pel_vec3){ mast - 0.06 * l, 0.16 * s->beam, z + 0.06 * l },
         (struct pel_vec3){ mast + 0.25, 0, 0.9 * top }, 0.05 * l);
}

void pel_kind_sailing_yacht(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, b = s->beam;
    struct pel_hull_lines h = { .length = l,
                                .beam = b,
                                .draught = 0.27 * s->draught,
                                .freeboard = 0.09 * l,
                                .sheer_fore = 0.03 * l,
                                .sheer_aft = 0.004 * l,
                                .stem_rake = 0.04 * l,
                                .keel_rake = 0.12 * l,
                                .counter = 0.04 * l,
                                .cutaway = 0.16 * l,
                                .power = 1.9,
                                .power_ends = 1.6,
                                .entrance = 0.58,
                                .run = 0.42,
                                .bow_power = 1.7,
                                .bow_round = 1,
                                .stern_power = 2,
                                .transom = 0.72,
                                .transom_deep = 0.2,
                                .flare = 0.25,
                                .narrow = 0.88,
                                .strake = 0.012 * l,
                                .strake_colour = 0x1f3a6e,
                                .bottom = 0x24304a,
                                .side = s->colour,
                                .deck = 0xc8b48c,
                                .stations = 32 };
    double z = h.freeboard;
    pel_hull_draw(pen, &h);
    pel_pen_node(pen, "keel");
    pel_pen_paint(pen, 0x24304a, 0.7);
    const struct pel_vec2 fin[] = { { -0.06 * l, -s->draught },
                                    { 0.05 * l, -s->draught },
                                    { 0.09 * l, -0.6 * h.draught },
                                    { -0.04 * l, -0.6 * h.draught } };
    pel_solid_side(pen, fin, 4, -0.1, 0.1);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ 0, 0, -s->draught + 0.17 },
                        0.09 * l, 0.2, 0.17, 12);
    const struct pel_vec2 rudder[] = { { -0.42 * l, -0.75 * s->draught },
                                       { -0.39 * l, -0.75 * s->draught },
                                       { -0.37 * l, -0.2 * h.draught },
                                       { -0.42 * l, 0.1 * h.draught } };
    pel_solid_side(pen, rudder, 4, -0.04, 0.04);
    pel_pen_node(pen, "coach roof");
    pel_pen_paint(pen, s->colour, 0.4);
    const struct pel_vec2 roof[] = { { -0.14 * l, z - 0.1 },
                                     { 0.28 * l, z - 0.1 },
                                     { 0.12 * l, z + 0.035 * l },
                                     { -0.14 * l, z + 0.045 * l } };
    pel_solid_side(pen, roof, 4, -0.27 * b, 0.27 * b);
    pel_pen_paint(pen, PEL_GLASS, 0.1);
    pel_solid_boxes(pen, -0.1 * l, 0.06 * l, 0.27 * b - 0.05, 0.27 * b + 0.02,
                    z + 0.01 * l, z + 0.026 * l);
    pel_pen_node(pen, "spray hood");
    pel_pen_paint(pen, 0x1f3a6e, 0.8);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ -0.13 * l, 0, z + 0.03 * l },
                        0.06 * l, 0.25 * b, 0.05 * l, 12);
    yacht_rig(pen, s, z);
    pel_kind_eye(pen, "cockpit", -0.35 * l, 0, z + 0.1 * l);
    pel_kind_light(pen, "steaming", 0xffffff, 3, -112.5, 112.5,
                   (struct pel_vec3){ 0.1 * l, 0, 0.6 * s->height });
    pel_kind_light(pen, "port", 0xff0000, 2, -112.5, 0,
                   (struct pel_vec3){ 0.46 * l, 0.05 * b, z + 0.07 * l });
    pel_kind_light(pen, "starboard", 0x00ff40, 2, 0, 112.5,
                   (struct pel_vec3){ 0.46 * l, -0.05 * b, z + 0.07 * l });
    pel_kind_light(pen, "stern", 0xffffff, 2, 112.5, 247.5,
                   (struct pel_vec3){ -0.49 * l, 0, z + 0.05 * l });
}

/* --- rigid inflatable
 * ------------------------------------------------------------- */

/* Someone who sits or stands: head, trunk; the hips at `z`. */
static void crew(struct pel_pen *pen, double x, double y, double z,
                 uint32_t colour)
{
    pel_pen_paint(pen, colour, 0.8);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ x, y, z + 0.32 }, 0.16, 0.24,
                        0.36, 10);
    pel_pen_paint(pen, 0xc09070, 0.7);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ x, y, z + 0.78 }, 0.11, 0.09,
                        0.13, 8);
}

static void outboard(struct pel_pen *pen, double x, double y, double deep,
                     double u)
{
    pel_pen_paint(pen, 0x202226, 0.3);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ x, y, 0.75 * u }, 0.32 * u,
                        0.2 * u, 0.32 * u, 10);
    pel_solid_box(pen, x - 0.1 * u, x + 0.1 * u, y - 0.06 * u, y + 0.06 * u,
                  -deep, 0.6 * u);
}

void pel_kind_rib(struct pel_pen *pen, const struct pel_kind_size *s)
{
    enum { SIDE = 9 };
    double l = s->length, b = s->beam, u = l / 7.6, r = 0.1 * b;
    struct pel_hull_lines h = { .length = 0.93 * l,
                                .beam = 0.78 * b,
                                .draught = s->draught,
                                .freeboard = 0.35 * u,
                                .sheer_fore = 0.3 * u,
                                .stem_rake = 0.1 * l,
                                .keel_rake = 0.22 * l,
                                .cutaway = 0.02 * l,
                                .power = 1.25,
                                .power_ends = 1,
                                .entrance = 0.5,
                                .run = 0.1,
                                .bow_power = 1.9,
                                .bow_round = 1.2,
                                .stern_power = 2,
                                .transom = 0.97,
                                .transom_deep = 0.9,
                                .flare = 0.5,
                                .bottom = 0xd8d8d4,
                                .side = 0xd8d8d4,
                                .deck = 0x70767a,
                                .stations = 24 };
    pel_hull_draw(pen, &h);
    struct pel_vec3 path[2 * SIDE];
    for (int i = 0; i < SIDE; i++) {
        double t = (double)i / (SIDE - 1);
        double x = l * (-0.5 + 0.96 * sin(PEL_PI / 2 * t));
        double y = fmax((b / 2 - r) * pow(fmax(1 - pow(t, 4.5), 0), 0.6), 0.02);
        double z = 0.45 * u + 0.33 * u * t * t;
        path[i] = (struct pel_vec3){ x, -y, z };
        path[2 * SIDE - 1 - i] = (struct pel_vec3){ x, y, z };
    }
    pel_pen_node(pen, "tube");
    pel_pen_paint(pen, s->colour, 0.7);
    pel_solid_tube(pen, path, 2 * SIDE, r, 10, false);
    pel_pen_node(pen, "console");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.4);
    const struct pel_vec2 console[] = { { -0.02 * l, 0.3 * u },
                                        { 0.1 * l, 0.3 * u },
                                        { 0.05 * l, 1.35 * u },
                                        { 0.0 * l, 1.35 * u } };
    pel_solid_side(pen, console, 4, -0.35 * u, 0.35 * u);
    pel_pen_paint(pen, PEL_GLASS, 0.1);
    pel_solid_block(pen, 0.04 * l, 0.055 * l, 0.6 * u, 1.35 * u, 1.7 * u);
    pel_pen_paint(pen, 0x2a2c30, 0.7);
    pel_solid_block(pen, -0.2 * l, -0.06 * l, 0.6 * u, 0.3 * u, 0.95 * u);
    pel_pen_node(pen, "crew");
    crew(pen, -0.08 * l, 0, 1.0 * u, PEL_ORANGE);
    crew(pen, -0.17 * l, 0, 1.0 * u, PEL_ORANGE);
    pel_pen_node(pen, "frame");
    pel_pen_metal(pen, 0xc4c8cc, 0.35);
    const struct pel_vec3 arch[] = {
        { -0.42 * l, -0.36 * b, 0.4 * u },
        { -0.45 * l, -0.3 * b, s->height - 0.5 * u },
        { -0.45 * l, 0.3 * b, s->height - 0.5 * u },
        { -0.42 * l, 0.36 * b, 0.4 * u }
    };
    pel_solid_tube(pen, arch, 4, 0.05 * u, 6, false);
    pel_solid_pole(pen, (struct pel_vec3){ -0.45 * l, 0, s->height - 0.55 * u },
                   (struct pel_vec3){ -0.45 * l, 0, s->height }, 0.03 * u,
                   0.02 * u, 5);
    pel_pen_node(pen, "outboards");
    outboard(pen, -0.48 * l, 0.3 * u, s->draught, u);
    outboard(pen, -0.48 * l, -0.3 * u, s->draught, u);
    pel_kind_eye(pen, "helm", -0.08 * l + 0.3 * u, 0, 1.8 * u);
    pel_kind_light(pen, "all round", 0xffffff, 2, 0, 0,
                   (struct pel_vec3){ -0.45 * l, 0, s->height });
}

/* --- unmanned catamaran
 * ------------------------------------------------------------ */

/* A float of the catamaran, a long body of revolution, flat on top. */
static void pontoon(struct pel_pen *pen, const struct pel_kind_size *s,
                    double y, double z)
{
    enum { N = 12, SIDES = 12 };
    struct pel_vec3 rings[N][SIDES];
    double l = s->length, r = 0.1 * s->beam + 0.5 * s->draught;
    for (int i = 0; i < N; i++) {
        double t = (double)i / (N - 1);
        double thick = i == 0 || i == N - 1 ? 0.02 : 1;
        thick *= pow(sin(PEL_PI * (0.06 + 0.88 * t)), 0.4);
        double rise = 0.35 * r * pow(fmax(0, t - 0.6) / 0.4, 2);
        for (int k = 0; k < SIDES; k++) {
            double a = 2 * PEL_PI * k / SIDES;
            rings[i][k] =
                (struct pel_vec3){ l * (t - 0.5), y + 0.8 * r * thick * cos(a),
                                   z + rise + r * thick * sin(a) };
        }
    }
    for (int i = 0; i + 1 < N; i++) {
        for (int k = 0; k < SIDES; k++) {
            int j = (k + 1) % SIDES;
            pel_solid_quad(pen, rings[i][k], rings[i][j], rings[i + 1][j],
                           rings[i + 1][k]);
        }
    }
    for (int k = 1; k + 1 < SIDES; k++) {
        pel_solid_triangle(pen, rings[0][0], rings[0][k + 1], rings[0][k]);
        pel_solid_triangle(pen, rings[N - 1][0], rings[N - 1][k],
                           rings[N - 1][k + 1]);
    }
}

void pel_kind_usv(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double l = s->length, b = s->beam, u = s->height / 3;
    double r = 0.1 * b + 0.5 * s->draught, z = r - s->draught;
    pel_pen_node(pen, "hull");
    pel_pen_paint(pen, s->colour, 0.5);
    pontoon(pen, s, b / 2 - 0.8 * r, z);
    pontoon(pen, s, -b / 2 + 0.8 * r, z);
    pel_pen_node(pen, "frame");
    pel_pen_metal(pen, 0x9aa0a4, 0.4);
    for (int i = -1; i <= 1; i += 2) {
        double x = 0.18 * l * i;
        const struct pel_vec3 arch[] = { { x, -b / 2 + 0.8 * r, z + 0.5 * r },
                                         { x, -0.2 * b, 0.85 * u },
                                         { x, 0.2 * b, 0.85 * u },
                                         { x, b / 2 - 0.8 * r, z + 0.5 * r } };
        pel_solid_tube(pen, arch, 4, 0.05 * u, 6, false);
    }
    pel_pen_node(pen, "deck");
    pel_pen_paint(pen, 0x3a3f44, 0.7);
    pel_solid_block(pen, -0.25 * l, 0.25 * l, 0.45 * b, 0.82 * u, 0.98 * u);
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.5);
    pel_solid_block(pen, -0.2 * l, 0.02 * l, 0.36 * b, 0.98 * u, 1.35 * u);
    pel_pen_node(pen, "mast");
    pel_pen_metal(pen, 0x9aa0a4, 0.4);
    pel_solid_pole(pen, (struct pel_vec3){ 0.1 * l, 0, 0.9 * u },
                   (struct pel_vec3){ 0.1 * l, 0, 0.9 * s->height }, 0.06 * u,
                   0.05 * u, 8);
    pel_solid_block(pen, 0.08 * l, 0.12 * l, 0.4 * b, 0.72 * s->height,
                    0.74 * s->height);
    pel_pen_node(pen, "sensors");
    pel_pen_paint(pen, PEL_BLACK, 0.3);
    pel_solid_pole(pen, (struct pel_vec3){ 0.1 * l, 0, 0.88 * s->height },
                   (struct pel_vec3){ 0.1 * l, 0, 0.94 * s->height }, 0.12 * u,
                   0.12 * u, 10);
    pel_solid_box(pen, 0.11 * l, 0.14 * l, -0.18 * b, -0.1 * b,
                  0.74 * s->height, 0.8 * s->height);
    pel_solid_box(pen, 0.11 * l, 0.14 * l, 0.1 * b, 0.18 * b, 0.74 * s->height,
                  0.8 * s->height);
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.3);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ -0.08 * l, 0, 1.45 * u },
                        0.16 * u, 0.16 * u, 0.16 * u, 10);
    pel_solid_pole(pen, (struct pel_vec3){ -0.18 * l, 0.12 * b, 1.3 * u },
                   (struct pel_vec3){ -0.18 * l, 0.12 * b, s->height },
                   0.015 * u, 0.01 * u, PEL_SOLID_THIN);
    pel_kind_eye(pen, "camera", 0.14 * l, 0, 0.77 * s->height);
    pel_kind_light(pen, "all round", 0xffffff, 2, 0, 0,
                   (struct pel_vec3){ 0.1 * l, 0, 0.95 * s->height });
}

/* --- life raft, person
 * ---------------------------------------------------------------- */

void pel_kind_life_raft(struct pel_pen *pen, const struct pel_kind_size *s)
{
    enum { N = 16 };
    double r = 0.07 * s->length, out = s->length / 2 - r;
    double wide = s->beam / s->length;
    struct pel_vec3 ring[2][N];
    for (int i = 0; i < N; i++) {
        double a = 2 * PEL_PI * i / N;
        for (int k = 0; k < 2; k++) {
            ring[k][i] = (struct pel_vec3){ out * cos(a), wide * out * sin(a),
                                            r - s->draught + k * 1.7 * r };
        }
    }
    pel_pen_node(pen, "hull");
    pel_pen_paint(pen, PEL_BLACK, 0.7);
    pel_solid_tube(pen, ring[0], N, r, 10, true);
    pel_solid_tube(pen, ring[1], N, r, 10, true);
    pel_pen_node(pen, "floor");
    pel_pen_paint(pen, s->colour, 0.8);
    struct pel_vec2 floor[N];
    for (int i = 0; i < N; i++) {
        floor[i] = (struct pel_vec2){ ring[0][i].x, ring[0][i].y };
    }
    pel_solid_tower(pen, floor, N, 0.3 * r - s->draught, 1.2 * r - s->draught,
                    1, 0, 0);
    pel_pen_node(pen, "canopy");
    double low = 3 * r - s->draught, high = s->height - low;
    const struct pel_vec2 tent[] = { { out, low },
                                     { 0.96 * out, low + 0.35 * high },
                                     { 0.72 * out, low + 0.7 * high },
                                     { 0.3 * out, low + 0.95 * high },
                                     { 0, s->height } };
    pel_solid_turned(pen, tent, 5, 0, 0, N);
    pel_pen_node(pen, "opening");
    pel_pen_paint(pen, PEL_BLACK, 0.9);
    pel_solid_ellipsoid(pen,
                        (struct pel_vec3){ 0.85 * out, 0, low + 0.2 * high },
                        0.16 * out, 0.3 * out, 0.3 * high, 10);
    pel_pen_node(pen, "bands");
    pel_pen_paint(pen, PEL_SHIP_WHITE, 0.2);
    pel_solid_boxes(pen, -0.2 * out, 0.2 * out, 0.9 * out, 0.97 * out,
                    low + 0.1 * high, low + 0.3 * high);
    pel_kind_light(pen, "canopy", 0xffffff, 2, 0, 0,
                   (struct pel_vec3){ 0, 0, s->height });
}

void pel_kind_person(struct pel_pen *pen, const struct pel_kind_size *s)
{
    double u = s->height / 0.42, d = s->draught / 1.35;
    pel_pen_node(pen, "hull"); /* what floats */
    pel_pen_paint(pen, s->colour, 0.8);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ 0.02 * u, 0, -0.02 * u },
                        0.15 * u, 0.22 * u, 0.2 * u, 12);
    pel_solid_tube(
        pen,
        (const struct pel_vec3[]){ { 0.1 * u, 0.12 * u, 0.05 * u },
                                   { -0.05 * u, 0.11 * u, 0.16 * u },
                                   { -0.11 * u, 0, 0.17 * u },
                                   { -0.05 * u, -0.11 * u, 0.16 * u },
                                   { 0.1 * u, -0.12 * u, 0.05 * u } },
        5, 0.075 * u, 8, false);
    pel_pen_node(pen, "head");
    pel_pen_paint(pen, 0xc09070, 0.7);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ 0, 0, 0.27 * u }, 0.11 * u,
                        0.085 * u, 0.14 * u, 12);
    pel_pen_paint(pen, 0x3a2a20, 0.9);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ -0.025 * u, 0, 0.31 * u },
                        0.1 * u, 0.09 * u, 0.11 * u, 10);
    pel_pen_node(pen, "body");
    pel_pen_paint(pen, 0x24364f, 0.9);
    pel_solid_ellipsoid(pen, (struct pel_vec3){ 0, 0, -0.35 * d }, 0.12 * u,
                        0.18 * u, 0.35 * d, 10);
    for (int side = -1; side <= 1; side += 2) {
        pel_solid_pole(
            pen, (struct pel_vec3){ 0, side * 0.09 * u, -0.6 * d },
            (struct pel_vec3){ -0.1 * u, side * 0.11 * u, -1.35 * d }, 0.08 * u,
            0.05 * u, 8);
        pel_solid_pole(pen, (struct pel_vec3){ 0, side * 0.18 * u, 0.0 },
                       (struct pel_vec3){ 0.24 * u, side * 0.29 * u, 0.02 * u },
                       0.05 * u, 0.04 * u, 8);
    }
}
