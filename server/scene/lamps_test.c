/* Lamps of a snapshot: which are lit, how strong, where they shine. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "models/builtin.h"
#include "models/model.h"
#include "scene/lampplan.h"
#include "scene/lamps.h"
#include "scene/scene_testkit.h"

#define MILE_M 1852.0

static struct pel_object objects[PEL_MAX_ENTITIES];
static struct pel_lamp lamps[PEL_MAX_LAMPS];

static struct pel_scene *night_scene(void)
{
    struct pel_scene *s = make_scene((struct pel_scene_options){ 0 });
    must(s, "{\"clock\":{\"mode\":\"STEPPED\",\"utc\":\"2026-06-21T00:00:00Z\"}"
            ",\"sky\":{\"sunElevation\":-20}}");
    return s;
}

static size_t lit(struct pel_scene *scene, double time_s)
{
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    size_t n = pel_snapshot_objects(s, time_s, NULL, objects);
    size_t count = pel_snapshot_lamps(s, time_s, NULL, objects, n, lamps);
    pel_snapshot_unref(s);
    return count;
}

static double candela(const struct pel_lamp *l)
{
    return 0.2126390059 * l->intensity_cd[0] +
           0.7151686788 * l->intensity_cd[1] +
           0.0721923154 * l->intensity_cd[2];
}

static char colour_letter(const struct pel_lamp *l)
{
    const double *c = l->intensity_cd;
    return c[2] > 0.2 * c[0] && c[0] > 0 ? 'W'
           : c[0] < 0                    ? 'G'
           : c[1] < 0                    ? 'R'
           : c[2] > 2 * (c[0] + c[1])    ? 'B'
                                         : 'Y';
}

/* --- what a vessel shows -------------------------------------------------- */

/* By the rules' own words: how many white masthead (M), sidelights (P, S),
 * sternlights (s), towing (y), all-round lights by colour (w r g). */
static const struct {
    double length_m;
    enum pel_nav_status status;
    bool makes_way, anchored;
    double tow_m;
    const char *shows; /* sorted */
} rules[] = {
    { 200, PEL_NAV_ENGINE, true, false, 0, "MMPSs" },  /* 23 (a) */
    { 200, PEL_NAV_ENGINE, false, false, 0, "MMPSs" }, /* under way */
    { 49.9, PEL_NAV_ENGINE, true, false, 0, "MPSs" },
    { 15, PEL_NAV_ENGINE, true, false, 0, "MPSs" },
    { 8, PEL_NAV_ENGINE, true, false, 0, "PSw" },         /* 23 (d) i */
    { 200, PEL_NAV_TOWING, true, false, 150, "MMMPSsy" }, /* 24 (a), 24 (d) */
    { 200, PEL_NAV_TOWING, true, false, 250, "MMMMPSsy" },
    { 30, PEL_NAV_TOWING, true, false, 200, "MMPSsy" },
    { 30, PEL_NAV_TOWING, true, false, 201, "MMMPSsy" },
    { 30, PEL_NAV_PUSHING, true, false, 500, "MMPSs" }, /* 24 (c) */
    { 60, PEL_NAV_PUSHING, true, false, 500, "MMMPSs" },
    { 30, PEL_NAV_TOWED, true, false, 0, "PSs" },      /* 24 (e) */
    { 12, PEL_NAV_SAILING, true, false, 0, "PSs" },    /* 25 (a) */
    { 4, PEL_NAV_OARS, true, false, 0, "w" },          /* 25 (d) ii */
    { 30, PEL_NAV_TRAWLING, true, false, 0, "PSgsw" }, /* 26 (b) */
    { 30, PEL_NAV_TRAWLING, false, false, 0, "gw" },
    { 60, PEL_NAV_TRAWLING, true, false, 0, "MPSgsw" },
    { 60, PEL_NAV_TRAWLING, false, false, 0, "Mgw" },
    { 60, PEL_NAV_FISHING, true, false, 0, "PSrsw" }, /* 26 (c) */
    { 30, PEL_NAV_FISHING, false, false, 0, "rw" },
    { 200, PEL_NAV_NOT_UNDER_COMMAND, false, false, 0, "rr" }, /* 27 (a) */
    { 200, PEL_NAV_NOT_UNDER_COMMAND, true, false, 0, "PSrrs" },
    { 200, PEL_NAV_RESTRICTED, false, false, 0, "rrw" }, /* 27 (b) */
    { 200, PEL_NAV_RESTRICTED, true, false, 0, "MMPSrrsw" },
    { 200, PEL_NAV_RESTRICTED, false, true, 0, "rrwww" },
    { 40, PEL_NAV_RESTRICTED, true, false, 0, "MPSrrsw" },
    { 200, PEL_NAV_CONSTRAINED, true, false, 0, "MMPSrrrs" }, /* 28 */
    { 17, PEL_NAV_PILOT, true, false, 0, "PSrsw" },           /* 29 (a) */
    { 17, PEL_NAV_PILOT, false, true, 0, "rww" },
    { 200, PEL_NAV_ANCHOR, false, false, 0, "ww" },    /* 30 (a) */
    { 49, PEL_NAV_ANCHOR, false, false, 0, "w" },      /* 30 (b) */
    { 200, PEL_NAV_AGROUND, false, false, 0, "rrww" }, /* 30 (d) */
    { 30, PEL_NAV_AGROUND, false, false, 0, "rrw" },
    { 10, PEL_NAV_AGROUND, false, false, 0, "w" }, /* 30 (f) */
    { 200, PEL_NAV_MOORED, false, false, 0, "" },
};

static int by_code(const void *a, const void *b)
{
    return *(const char *)a - *(const char *)b;
}

static char letter_of(const struct pel_nav_light *n)
{
    static const char all_round[] = "wrgyb";
    return n->kind == PEL_NAV_MASTHEAD
               ? (n->colour == PEL_LAMP_WHITE ? 'M' : '?')
           : n->kind == PEL_NAV_PORT ? (n->colour == PEL_LAMP_RED ? 'P' : '?')
           : n->kind == PEL_NAV_STARBOARD
               ? (n->colour == PEL_LAMP_GREEN ? 'S' : '?')
           : n->kind == PEL_NAV_STERN
               ? (n->colour == PEL_LAMP_YELLOW ? 'y' : 's')
               : all_round[n->colour];
}

static struct pel_vessel vessel_of(double length_m, enum pel_nav_status status)
{
    return (struct pel_vessel){ .length_m = length_m,
                                .breadth_m = length_m / 6.5,
                                .height_m = 4 + length_m / 6,
                                .status = status };
}

static void vessels_show_what_the_rules_say(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        struct pel_vessel v = vessel_of(rules[i].length_m, rules[i].status);
        struct pel_nav_light out[PEL_NAV_MOST];
        char shown[PEL_NAV_MOST + 1] = "";
        v.makes_way = rules[i].makes_way;
        v.anchored = rules[i].anchored;
        v.tow_m = rules[i].tow_m;
        size_t n = pel_colregs_lights(&v, out);
        for (size_t k = 0; k < n; k++) {
            shown[k] = letter_of(&out[k]);
        }
        qsort(shown, n, 1, by_code);
        if (strcmp(shown, rules[i].shows) != 0) {
            fail_msg("%g m, status %d: %s instead of %s", rules[i].length_m,
                     (int)rules[i].status, shown, rules[i].shows);
        }
    }
}

/* --- where ---------------------------------------------------------------- */

static void stand_as_annex_one_says(const struct pel_vessel *v,
                                    const char *name)
{
    struct pel_nav_light out[PEL_NAV_MOST];
    size_t n = pel_colregs_lights(v, out);
    const struct pel_nav_light *mast[2] = { NULL, NULL }, *side = NULL;
    int masts = 0;
    for (size_t i = 0; i < n; i++) {
        if (out[i].kind == PEL_NAV_MASTHEAD && masts < 2) {
            mast[masts++] = &out[i];
        }
        side = out[i].kind == PEL_NAV_PORT ? &out[i] : side;
    }
    double deck = pel_colregs_deck(v);
    assert_non_null(side);
    if (!side || !mast[0]) {
        return;
    }
    double up = mast[0]->at.z - deck;
    print_message("%s: masthead %.1f m above the deck at %.1f, side %.1f\n",
                  name, up, mast[0]->at.x, side->at.z - deck);
    assert_true(up + 1e-9 >= (v->length_m < 20 ? 1 : 6)); /* 2 (a) i, (c) */
    assert_true(up + 1e-9 >= (v->length_m < 20 ? 0 : fmin(v->breadth_m, 12)));
    assert_true(side->at.z - deck <= 0.75 * up + 1e-9); /* 2 (g) */
    assert_true(v->length_m < 20 || side->at.x <= mast[0]->at.x + 1e-9);
    assert_int_equal(masts, v->length_m >= 50 ? 2 : v->length_m >= 12 ? 1 : 0);
    if (mast[1]) {
        double apart = mast[0]->at.x - mast[1]->at.x;
        assert_true(mast[1]->at.z - mast[0]->at.z >= 4.5 - 1e-9); /* 2 (a) ii */
        assert_true(apart + 1e-9 >= fmin(v->length_m / 2, 100));  /* 3 (a) */
        assert_true(mast[0]->at.x + 1e-9 >= v->length_m / 4);
        /* 2 (b): from 1000 m before the stem, at sea level. */
        double stem = v->length_m / 2, eye = stem + 1000;
        assert_true(mast[1]->at.z / (eye - mast[1]->at.x) >
                    mast[0]->at.z / (eye - mast[0]->at.x));
    }
}

static void lights_stand_where_annex_one_wants_them(void **state)
{
    (void)state;
    for (double length = 8; length < 400; length *= 1.17) {
        struct pel_vessel v = vessel_of(length, PEL_NAV_ENGINE);
        stand_as_annex_one_says(&v, "any");
    }
    static const char *const names[] = { "container-ship", "tanker",
                                         "bulk-carrier",   "ferry",
                                         "cruise-ship",    "tug",
                                         "fishing-boat",   "patrol-boat" };
    struct pel_scene *scene = night_scene();
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char json[160];
        snprintf(json, sizeof json,
                 "{\"entities\":{\"%d\":{\"model\":{\"name\":\"%s\"},"
                 "\"lights\":\"ON\"}}}",
                 (int)i + 10, names[i]);
        must(scene, json);
    }
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_int_equal(s->lamps->count, sizeof names / sizeof names[0]);
    for (size_t i = 0; i < s->lamps->count; i++) {
        stand_as_annex_one_says(&s->lamps->sets[i].vessel, names[i]);
    }
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

/* Lights of a vertical line are as far apart as 2 (i) wants, their lowest high
 * enough. */
static void vertical_lines_are_wide_enough(void **state)
{
    (void)state;
    for (double length = 12; length < 300; length *= 1.3) {
        struct pel_vessel v = vessel_of(length, PEL_NAV_CONSTRAINED);
        struct pel_nav_light out[PEL_NAV_MOST];
        size_t n = pel_colregs_lights(&v, out);
        double z[3] = { 0 }, apart = length >= 20 ? 2 : 1;
        int count = 0;
        for (size_t i = 0; i < n; i++) {
            if (out[i].kind == PEL_NAV_ALL_ROUND) {
                z[count++] = out[i].at.z;
            }
        }
        assert_int_equal(count, 3);
        assert_true(z[0] - z[1] >= apart - 1e-9);
        assert_near(z[1] - z[2], z[0] - z[1], 1e-9);
        assert_true(z[2] - pel_colregs_deck(&v) >=
                    (length >= 20 ? 4 : 2) - 1e-9);
        for (size_t i = 0; i < n; i++) {
            assert_true(length >= 50 || out[i].kind != PEL_NAV_MASTHEAD ||
                        out[i].at.z > z[0]);
        }
    }
}

/* --- how strong ----------------------------------------------------------- */

/* Illuminance at the range of rule 22, through air of K = 0.8 a mile, is
 * 2e-7 lx (Annex I, section 8): within 2 %, for every light of four lengths. */
static void lights_reach_as_far_as_rule_22_wants(void **state)
{
    (void)state;
    static const struct {
        const char *model;
        double masthead, side, others; /* nautical miles */
    } rows[] = { { "{\"name\":\"tanker\"}", 6, 3, 3 },
                 { "{\"name\":\"tug\",\"length\":30}", 5, 2, 2 },
                 { "{\"name\":\"patrol-boat\",\"length\":16}", 3, 2, 2 },
                 { "{\"name\":\"patrol-boat\",\"length\":11}", 2, 1, 2 } };
    for (size_t i = 0; i < 4; i++) {
        struct pel_scene *scene = night_scene();
        char json[256];
        snprintf(json, sizeof json,
                 "{\"entities\":{\"5\":{\"model\":%s,\"lights\":\"ON\","
                 "\"navigationStatus\":\"TOWING\"}}}",
                 rows[i].model);
        must(scene, json);
        size_t n = lit(scene, 0);
        assert_true(n >= 6);
        for (size_t k = 0; k < n; k++) {
            const struct pel_lamp *l = &lamps[k];
            char c = colour_letter(l);
            double arc = l->arc_rad / PEL_DEG;
            double nm = c == 'R' || c == 'G'     ? rows[i].side
                        : fabs(arc - 225) < 1e-6 ? rows[i].masthead
                                                 : rows[i].others;
            double m = nm * MILE_M;
            double lx = candela(l) * pow(0.8, nm) / (m * m);
            assert_near(lx / 2e-7, 1, 0.02);
        }
        pel_scene_destroy(scene);
    }
}

/* A mark's nominal range: 2e-7 lx through 0.74 a mile. */
static void marks_reach_their_nominal_range(void **state)
{
    (void)state;
    struct pel_scene *scene = night_scene();
    must(scene, "{\"entities\":{\"7\":{\"lights\":\"ON\","
                "\"light\":{\"character\":\"F G\",\"range\":18}}}}");
    assert_int_equal(lit(scene, 0), 1);
    double m = 18 * MILE_M;
    assert_near(candela(&lamps[0]) * pow(0.74, 18) / (m * m) / 2e-7, 1, 0.02);
    assert_int_equal(colour_letter(&lamps[0]), 'G');
    pel_scene_destroy(scene);
}

/* Corners of Annex I, section 7, in an order that goes around. */
static const struct {
    enum pel_lamp_colour colour;
    int corners;
    double x[6], y[6];
} regions[] = {
    { PEL_LAMP_WHITE,
      6,
      { 0.525, 0.525, 0.452, 0.310, 0.310, 0.443 },
      { 0.382, 0.440, 0.440, 0.348, 0.283, 0.382 } },
    { PEL_LAMP_GREEN,
      4,
      { 0.028, 0.009, 0.300, 0.203 },
      { 0.385, 0.723, 0.511, 0.356 } },
    { PEL_LAMP_RED,
      4,
      { 0.680, 0.735, 0.721, 0.660 },
      { 0.320, 0.265, 0.259, 0.320 } },
    { PEL_LAMP_YELLOW,
      4,
      { 0.612, 0.618, 0.575, 0.575 },
      { 0.382, 0.382, 0.425, 0.406 } },
};

static void colours_lie_in_their_regions(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof regions / sizeof regions[0]; i++) {
        double c[3];
        pel_lamp_colour_of((int)regions[i].colour, c);
        double big_x = 0.4124 * c[0] + 0.3576 * c[1] + 0.1805 * c[2];
        double big_y = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        double big_z = 0.0193 * c[0] + 0.1192 * c[1] + 0.9505 * c[2];
        double sum = big_x + big_y + big_z;
        double x = big_x / sum, y = big_y / sum;
        int crossings = 0, n = regions[i].corners;
        assert_near(big_y, 1, 1e-3);
        for (int k = 0; k < n; k++) {
            const double *px = regions[i].x, *py = regions[i].y;
            int j = (k + 1) % n;
            crossings +=
                (py[k] > y) != (py[j] > y) &&
                x < px[k] + (y - py[k]) * (px[j] - px[k]) / (py[j] - py[k]);
        }
        assert_int_equal(crossings % 2, 1);
    }
}

/* --- sectors -------------------------------------------------------------- */

static struct pel_vec3 towards(double bearing_deg, double elevation_deg)
{
    double b = bearing_deg * PEL_DEG, e = elevation_deg * PEL_DEG;
    return (struct pel_vec3){ sin(b) * cos(e), cos(b) * cos(e), sin(e) };
}

/* Of the lamp, from a heading: full to the limits of Annex I, nothing beyond
 * two degrees more; within half a degree. */
static void assert_sector(const struct pel_lamp *l, double heading, double from,
                          double to)
{
    for (double side = -1; side <= 1; side += 2) {
        double edge = side < 0 ? from : to;
        double in = heading + edge - side * 0.5;
        double half = heading + edge + side * 1.0;
        double out = heading + edge + side * 2.5;
        assert_near(pel_lamp_towards(l, towards(in, 0)), 1, 1e-9);
        assert_near(pel_lamp_towards(l, towards(half, 0)), 0.5, 0.25);
        assert_near(pel_lamp_towards(l, towards(out, 0)), 0, 1e-9);
    }
}

static void sectors_end_where_they_shall(void **state)
{
    (void)state;
    struct pel_scene *scene = night_scene();
    must(scene, "{\"entities\":{\"5\":{\"model\":{\"name\":\"tug\"},"
                "\"lights\":\"ON\",\"heading\":60}}}");
    assert_int_equal(lit(scene, 0), 4);
    assert_sector(&lamps[0], 60, -112.5, 112.5);
    assert_sector(&lamps[1], 60, -112.5, 0);
    assert_sector(&lamps[2], 60, 0, 112.5);
    assert_sector(&lamps[3], 60, 112.5, 247.5);
    /* Annex I, section 10: full to 5 degrees, 60 % to 7.5. */
    for (double e = -7.5; e <= 7.5; e += 2.5) {
        double share = pel_lamp_towards(&lamps[0], towards(60, e));
        assert_true(share >= (fabs(e) > 5 ? 0.6 : 1 - 1e-9));
    }
    /* They go with the hull: rolled to starboard, the port light looks up. */
    must(scene, "{\"entities\":{\"5\":{\"roll\":20}}}");
    assert_int_equal(lit(scene, 0), 4);
    assert_near(pel_lamp_towards(&lamps[1], towards(-30, 20)), 1, 1e-9);
    assert_true(pel_lamp_towards(&lamps[1], towards(-30, 0)) < 0.01);
    pel_scene_destroy(scene);
}

/* A lighthouse from 10 to 45 red, to 60 white, to 120 green, from seaward, on
 * whatever heading: who stands there sees it on that bearing. */
static void marks_sectors_are_from_seaward(void **state)
{
    (void)state;
    struct pel_scene *scene = night_scene();
    must(scene,
         "{\"entities\":{\"7\":{\"lights\":\"ON\",\"heading\":77,"
         "\"latitude\":52.6,\"longitude\":5.2,"
         "\"light\":{\"character\":\"Iso WRG 4s\",\"phase\":0,\"sectors\":["
         "{\"colour\":\"LIGHT_RED\",\"begin\":10,\"end\":45},"
         "{\"colour\":\"LIGHT_WHITE\",\"begin\":45,\"end\":60},"
         "{\"colour\":\"LIGHT_GREEN\",\"begin\":60,\"end\":120}]}}}}");
    assert_int_equal(lit(scene, 0), 3);
    for (double bearing = 0; bearing < 360; bearing += 0.25) {
        char expected = bearing < 9.5                        ? ' '
                        : bearing > 10.5 && bearing < 44.5   ? 'R'
                        : bearing > 45.5 && bearing < 59.5   ? 'W'
                        : bearing > 60.5 && bearing < 119.5  ? 'G'
                        : bearing > 120.5 && bearing < 359.5 ? ' '
                                                             : '?';
        char seen = ' ';
        double sum = 0;
        for (int i = 0; i < 3; i++) {
            double share =
                pel_lamp_towards(&lamps[i], towards(bearing + 180, 0));
            seen = share > 0.5 ? colour_letter(&lamps[i]) : seen;
            sum += share;
        }
        assert_true(expected == '?' || expected == seen);
        assert_true(expected == '?' || fabs(sum - (seen != ' ')) < 1e-9);
    }
    pel_scene_destroy(scene);
}

/* --- when ----------------------------------------------------------------- */

static void nothing_is_lit_by_default(void **state)
{
    (void)state;
    struct pel_scene *scene = night_scene();
    must(scene, "{\"entities\":{\"5\":{\"model\":{\"name\":\"tug\"},"
                "\"light\":{\"character\":\"F\"},\"navigationStatus\":"
                "\"TOWING\"}}}");
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_null(s->lamps);
    pel_snapshot_unref(s);
    assert_int_equal(lit(scene, 0), 0);
    pel_scene_destroy(scene);
}

static void auto_is_by_sunset_or_visibility(void **state)
{
    (void)state;
    static const struct {
        double elevation, visibility_m;
        size_t count;
    } rows[] = { { 10, 40000, 0 }, { -0.8, 40000, 0 }, { -0.87, 40000, 4 },
                 { 10, 3700, 4 },  { 10, 3710, 0 },    { -30, 40000, 4 } };
    struct pel_scene *scene = night_scene();
    must(scene, "{\"entities\":{\"5\":{\"model\":{\"name\":\"tug\"},"
                "\"lights\":\"AUTO\"}}}");
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char json[96];
        snprintf(json, sizeof json,
                 "{\"sky\":{\"sunElevation\":%g,\"visibility\":%g}}",
                 rows[i].elevation, rows[i].visibility_m);
        must(scene, json);
        assert_int_equal(lit(scene, 0), rows[i].count);
    }
    pel_scene_destroy(scene);
}

static void a_class_has_its_status(void **state)
{
    (void)state;
    static const struct {
        const char *entity;
        size_t count;
    } rows[] = {
        { "\"model\":{\"name\":\"sailing-yacht\"}", 3 },
        { "\"model\":{\"name\":\"pilot-launch\"}", 5 },
        { "\"model\":{\"name\":\"tanker\"},\"mooring\":300", 2 + 10 },
        { "\"model\":{\"name\":\"tanker\"},\"navigationStatus\":\"MOORED\"",
          0 },
        { "\"model\":{\"name\":\"tug\"},\"deckLights\":true", 4 + 1 },
        { "\"model\":{\"name\":\"life-raft\"}", 1 },
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pel_scene *scene = night_scene();
        char json[256];
        snprintf(json, sizeof json,
                 "{\"entities\":{\"5\":{\"lights\":\"ON\",%s}}}",
                 rows[i].entity);
        must(scene, json);
        assert_int_equal(lit(scene, 0), rows[i].count);
        pel_scene_destroy(scene);
    }
}

/* Region B's lateral marks have the other colours. */
static void marks_have_their_regions_colours(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        char colour;
    } rows[] = { { "lateral-port-a", 'R' },      { "lateral-port-b", 'G' },
                 { "lateral-starboard-a", 'G' }, { "lateral-starboard-b", 'R' },
                 { "special-mark", 'Y' },        { "cardinal-north", 'W' } };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        struct pel_scene *scene = night_scene();
        char json[200];
        snprintf(json, sizeof json,
                 "{\"entities\":{\"5\":{\"lights\":\"ON\",\"model\":"
                 "{\"name\":\"%s\"},\"light\":{\"phase\":0}}}}",
                 rows[i].name);
        must(scene, json);
        assert_int_equal(lit(scene, 0.1), 1);
        assert_int_equal(colour_letter(&lamps[0]), rows[i].colour);
        pel_scene_destroy(scene);
    }
}

static void a_searchlight_goes_where_it_is_pointed(void **state)
{
    (void)state;
    struct pel_scene *scene = night_scene();
    must(scene, "{\"entities\":{\"5\":{\"heading\":40,\"roll\":8,"
                "\"model\":{\"name\":\"tug\"},\"searchlight\":{\"on\":true,"
                "\"bearing\":90,\"elevation\":0,\"width\":4,"
                "\"intensity\":2e6}}}}");
    assert_int_equal(lit(scene, 0), 1);
    /* To starboard, which is 8 degrees down. */
    assert_near(pel_lamp_towards(&lamps[0], towards(130, -8)), 1, 1e-6);
    assert_near(pel_lamp_towards(&lamps[0], towards(130, -6)), 0.5, 1e-6);
    assert_near(candela(&lamps[0]), 2e6, 2e3);
    pel_scene_destroy(scene);
}

static void a_signal_lamp_sends_its_text(void **state)
{
    (void)state;
    /* "SO E" at 12 words a minute: a unit is 0.1 s. */
    const char *expected = "1010100011101110111"
                           "0000000"
                           "1";
    struct pel_scene *scene = night_scene();
    must(scene, "{\"entities\":{\"5\":{\"model\":{\"name\":\"tug\"},"
                "\"signal\":{\"text\":\"so e\",\"start\":20,\"speed\":12}}}}");
    assert_int_equal(lit(scene, 19.99), 0);
    for (size_t i = 0; expected[i]; i++) {
        assert_int_equal(lit(scene, 20.05 + 0.1 * (double)i),
                         expected[i] - '0');
    }
    assert_int_equal(lit(scene, 20.05 + 0.1 * (double)strlen(expected)), 0);
    pel_scene_destroy(scene);
}

/* Moments in any order give the same list. */
static void the_list_is_a_function_of_the_moment(void **state)
{
    (void)state;
    enum { MOMENTS = 40 };
    static struct pel_lamp first[MOMENTS][64];
    size_t counts[MOMENTS];
    struct pel_scene *scene = night_scene();
    must(scene,
         "{\"entities\":{\"5\":{\"model\":{\"name\":\"ferry\"},\"lights\":"
         "\"ON\",\"speed\":9,\"course\":20,\"heading\":20,\"turnRate\":1},"
         "\"6\":{\"model\":{\"name\":\"cardinal-south\"},\"lights\":\"ON\","
         "\"afloat\":true},\"7\":{\"lights\":\"ON\",\"light\":"
         "{\"character\":\"Mo(A) 8s\"}}}}");
    for (int i = 0; i < MOMENTS; i++) {
        counts[i] = lit(scene, 0.37 * i);
        assert_true(counts[i] <= 64);
        memcpy(first[i], lamps, counts[i] * sizeof lamps[0]);
    }
    for (int k = 0; k < MOMENTS; k++) {
        int i = (k * 17 + 5) % MOMENTS;
        assert_int_equal(lit(scene, 0.37 * i), counts[i]);
        assert_memory_equal(first[i], lamps, counts[i] * sizeof lamps[0]);
    }
    pel_scene_destroy(scene);
}

/* Periods begin at phase after whole periods since 1970: 2026-06-21T00:00Z is
 * 1782000000 s. Without a phase two lights of one character are not alike. */
static void phase_is_from_utc(void **state)
{
    (void)state;
    struct pel_scene *scene = night_scene();
    must(scene, "{\"entities\":{\"5\":{\"lights\":\"ON\",\"light\":"
                "{\"character\":\"Fl 7s\",\"phase\":1.5}}}}");
    for (int i = 0; i < 900; i++) {
        double t = (i + 0.5) / 30, at = fmod(1782000000 + t - 1.5, 7);
        assert_int_equal(lit(scene, t), at < 0.7);
    }
    must(scene,
         "{\"entities\":{\"5\":{\"light\":{\"phase\":null}},\"6\":{\"lights\":"
         "\"ON\",\"light\":{\"character\":\"Fl 7s\"}}}}");
    int alone = 0;
    for (int i = 0; i < 210; i++) {
        alone += lit(scene, (i + 0.5) / 30) == 1;
    }
    assert_in_range(alone, 40, 43); /* twice 0.7 of 7 s */
    pel_scene_destroy(scene);
}

/* --- refusals ------------------------------------------------------------- */

static void assert_refused(const char *entity, const char *path,
                           const char *says)
{
    struct pel_scene *scene = night_scene();
    struct pel_fault fault;
    char json[400];
    snprintf(json, sizeof json, "{\"entities\":{\"5\":{%s}}}", entity);
    enum pel_err err = patch(scene, json, &fault);
    assert_int_not_equal(err, PEL_OK);
    assert_string_equal(fault.path, path);
    if (!strstr(fault.message, says)) {
        fail_msg("%s", fault.message);
    }
    pel_scene_destroy(scene);
}

static void wrong_lights_are_refused(void **state)
{
    (void)state;
#define CHARACTER(text) "\"light\":{\"character\":\"" text "\"}"
    const char *at = "entities.5.light.character";
    assert_refused(CHARACTER("Flash"), at, "like Fl(2) R 10s");
    assert_refused(CHARACTER(""), at, "begins with no class");
    assert_refused(CHARACTER("Fl R"), at, "needs a period");
    assert_refused(CHARACTER("Fl R 10"), at, "does not end in s");
    assert_refused(CHARACTER("Fl R 10s 8M"), at, "does not end in s");
    assert_refused(CHARACTER("Fl(9) 4s"), at, "more flashes");
    assert_refused(CHARACTER("Fl 1s"), at, "that is Q");
    assert_refused(CHARACTER("F R 4s"), at, "none of");
    assert_refused(CHARACTER("Mo(*) 8s"), at, "no such group");
    assert_refused(CHARACTER("Al.W 6s"), at, "two colours");
    assert_refused(CHARACTER("Iso WR 4s"), "entities.5.light.sectors",
                   "a sector for each");
    assert_refused("\"signal\":{\"text\":\"a*b\"}", "entities.5.signal.text",
                   "Morse");
    assert_refused("\"light\":{\"range\":90}", "entities.5.light.range", "40");
#undef CHARACTER
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vessels_show_what_the_rules_say),
        cmocka_unit_test(lights_stand_where_annex_one_wants_them),
        cmocka_unit_test(vertical_lines_are_wide_enough),
        cmocka_unit_test(lights_reach_as_far_as_rule_22_wants),
        cmocka_unit_test(marks_reach_their_nominal_range),
        cmocka_unit_test(colours_lie_in_their_regions),
        cmocka_unit_test(sectors_end_where_they_shall),
        cmocka_unit_test(marks_sectors_are_from_seaward),
        cmocka_unit_test(nothing_is_lit_by_default),
        cmocka_unit_test(auto_is_by_sunset_or_visibility),
        cmocka_unit_test(a_class_has_its_status),
        cmocka_unit_test(marks_have_their_regions_colours),
        cmocka_unit_test(a_searchlight_goes_where_it_is_pointed),
        cmocka_unit_test(a_signal_lamp_sends_its_text),
        cmocka_unit_test(the_list_is_a_function_of_the_moment),
        cmocka_unit_test(phase_is_from_utc),
        cmocka_unit_test(wrong_lights_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
