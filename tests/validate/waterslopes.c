#include "waterslopes.h"

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "optics/watermontecarlo.h"
#include "optics/waterslope.h"

#define SUNS 8
#define LEVELS 12 /* as render/seabedmap.c has it */

static const struct pel_montecarlo_sun suns[SUNS] = {
    { 30 * PEL_DEG, 0 },      { 30 * PEL_DEG, 0.5 * PEL_PI },
    { 30 * PEL_DEG, PEL_PI }, { 30 * PEL_DEG, 1.5 * PEL_PI },
    { 65 * PEL_DEG, 0 },      { 65 * PEL_DEG, 0.5 * PEL_PI },
    { 65 * PEL_DEG, PEL_PI }, { 65 * PEL_DEG, 1.5 * PEL_PI },
};

enum part {
    SINGLE,
    SECOND,
    HIGHER,
    BOTTOM,
    ALL,
    PARTS,
};

/* Deviations from the Monte Carlo, of its total. */
struct deviation {
    double square[PARTS], worst[PARTS], noise;
    int count;
};

/* The row of a table: level water as deep as the place looked at, and what is
 * drawn. */
struct row {
    struct deviation level, drawn;
};

static void deviate(struct deviation *d, const double got[PARTS],
                    const struct pel_montecarlo_result *r)
{
    const double want[PARTS] = { r->single.mean, r->second.mean, r->higher.mean,
                                 r->bottom_direct.mean +
                                     r->bottom_scattered.mean,
                                 r->total.mean };
    for (int k = 0; k < PARTS; k++) {
        double off = fabs(got[k] - want[k]) / r->total.mean;
        d->square[k] += off * off;
        d->worst[k] = fmax(d->worst[k], off);
    }
    double noise = r->total.error / r->total.mean;
    d->noise += noise * noise;
    d->count++;
}

static double rms(const struct deviation *d, enum part k)
{
    return d->count ? sqrt(d->square[k] / d->count) : 0.0;
}

/* --- one line of sight ---------------------------------------------------- */

struct water {
    struct pel_water_body body;
    struct pel_water_depths depths;
    struct pel_water_kernel levels[LEVELS];
};

struct sight {
    const struct water *water;
    const struct pel_section *bed;
    double view_rad;
    uint64_t paths;
};

/* `got`: single and second order filled. */
static void add_parts(const struct pel_slope_light *light, double got[PARTS])
{
    got[HIGHER] = light->volume - got[SINGLE] - got[SECOND];
    got[BOTTOM] = light->bottom;
    got[ALL] = light->volume + light->bottom;
}

/* Where the line of sight meets the bottom, and how a Sun finds it. */
static struct pel_slope_place place_of(const struct sight *s,
                                       const struct pel_geometry *at)
{
    struct pel_interface f = pel_interface_at(at);
    double sine = sqrt(1.0 - f.view_mu * f.view_mu);
    double along = sine * cos(s->bed->azimuth_rad);
    /* The Sun is the view's azimuth back from the line of sight. */
    double sunward = cos(s->bed->azimuth_rad + at->azimuth_rad) *
                     sqrt(1.0 - f.sun_mu * f.sun_mu);
    struct pel_section_hit hit = { 0 }, hidden;
    (void)pel_section_meet(s->bed, 0.0, 0.0, along, -f.view_mu, &hit);
    double depth = hit.length * f.view_mu, x = hit.length * along;
    bool dark =
        s->bed->knots > 1 && pel_section_meet(s->bed, x, depth * (1.0 - 1e-9),
                                              sunward, f.sun_mu, &hidden);
    return (struct pel_slope_place){
        .depth_m = depth,
        .under_m = pel_section_depth(s->bed, 0.0),
        .slope = fabs(hit.along) / fmax(hit.up, 1e-6),
        .gain = fmax(f.sun_mu * hit.up + sunward * hit.along, 0.0) / f.sun_mu,
        .lit = dark ? 0.0 : 1.0,
    };
}

/* All Suns and wavelengths; rows[sun's quarter turn from the bed]. */
static void look(const struct sight *s, uint64_t seed, struct row *rows[4])
{
    const struct water *w = s->water;
    struct pel_montecarlo_result r[PEL_WATER_WAVELENGTHS][SUNS];
    for (int c = 0; c < PEL_WATER_WAVELENGTHS; c++) {
        struct pel_medium m = pel_water_medium(&w->body, c);
        pel_montecarlo_leaving(&m, s->bed, s->view_rad, suns, SUNS, s->paths,
                               seed + (uint64_t)c, r[c], NULL);
    }
    for (int i = 0; i < SUNS; i++) {
        const struct pel_geometry at = { suns[i].zenith_rad, s->view_rad,
                                         suns[i].azimuth_rad };
        struct pel_slope_place place = place_of(s, &at);
        struct pel_slope_place flat = { place.depth_m, place.depth_m, 0, 1, 1 };
        struct pel_slope_light drawn[PEL_WATER_WAVELENGTHS];
        struct pel_slope_light level[PEL_WATER_WAVELENGTHS];
        pel_slope_light(&w->body, &w->depths, w->levels, &at, &place, drawn);
        pel_slope_light(&w->body, &w->depths, w->levels, &at, &flat, level);
        double turn = s->bed->azimuth_rad + at.azimuth_rad;
        struct row *to = rows[(int)lround(2.0 * turn / PEL_PI) & 3];
        for (int c = 0; c < PEL_WATER_WAVELENGTHS; c++) {
            struct pel_medium m = pel_water_medium(&w->body, c);
            m.depth_m = place.depth_m;
            double got[PARTS] = {
                pel_transport_single(&m, &at, PEL_EXTINCTION_FULL),
                pel_transport_second(&m, &at),
            };
            add_parts(&level[c], got);
            deviate(&to->level, got, &r[c][i]);
            add_parts(&drawn[c], got);
            deviate(&to->drawn, got, &r[c][i]);
        }
    }
}

/* --- the tables ----------------------------------------------------------- */

static void put_row(FILE *md, const char *name, const struct row *r)
{
    if (r->level.count == 0) {
        return;
    }
    fprintf(md, "| %s |", name);
    for (int k = 0; k < PARTS; k++) {
        fprintf(md, " %.2f → %.2f |", 100 * rms(&r->level, (enum part)k),
                100 * rms(&r->drawn, (enum part)k));
    }
    fprintf(md, " %.0f → %.0f | %.1f |\n", 100 * r->level.worst[ALL],
            100 * r->drawn.worst[ALL],
            100 * sqrt(r->level.noise / r->level.count));
}

static void look_at_plane(const struct water *w, double slope_deg, int turn,
                          double view_rad, double depth_m, uint64_t paths,
                          struct row *rows[4])
{
    struct pel_section bed;
    const struct pel_geometry at = { .view_zenith_rad = view_rad };
    if (pel_section_plane(tan(slope_deg * PEL_DEG), 0.5 * PEL_PI * turn,
                          pel_interface_at(&at).view_mu, depth_m, 1000.0,
                          &bed)) {
        return; /* would be seen from land */
    }
    const struct sight s = { w, &bed, view_rad, paths };
    look(&s, (uint64_t)(1000 * slope_deg) + (uint64_t)turn, rows);
}

static void look_at_planes(const struct water *w, double slope_deg,
                           uint64_t paths, struct row *rows[4])
{
    static const double views[] = { 20, 60 }, depths[] = { 2, 8 };
    for (int turn = 0; turn < (slope_deg > 0 ? 3 : 1); turn++) {
        for (int k = 0; k < 4; k++) {
            look_at_plane(w, slope_deg, turn, views[k % 2] * PEL_DEG,
                          depths[k / 2], paths, rows);
        }
    }
}

/* A ridge of 45° and a step, at five distances from the line of sight. */
static void look_at_shape(const struct water *w,
                          const struct pel_section *shape, uint64_t paths,
                          struct row *row)
{
    struct row *rows[4] = { row, row, row, row };
    for (int k = 0; k < 2 * 3 * 5; k++) {
        struct pel_section bed = *shape;
        bed.azimuth_rad = 0.5 * PEL_PI * (k / 2 % 3);
        for (int i = 0; i < bed.knots; i++) {
            bed.along_m[i] += 1.7 * (k / 6 - 2) + 0.37;
        }
        const struct sight s = { w, &bed, (k % 2 ? 60 : 20) * PEL_DEG, paths };
        look(&s, (uint64_t)k, rows);
    }
}

#define SLOPES 5
static const double slopes_deg[SLOPES] = { 0, 5, 15, 30, 45 };

struct tables {
    struct row plane[SLOPES][4], ridge, step;
};

static int fill(struct tables *t, struct water *w, enum pel_water_name name,
                uint64_t paths)
{
    const struct pel_section ridge = { .knots = 3,
                                       .along_m = { -4, 0, 4 },
                                       .depth_m = { 6, 2, 6 } };
    const struct pel_section step = { .knots = 2,
                                      .along_m = { -1, 1 },
                                      .depth_m = { 3, 8 } };
    const struct pel_water_desc desc = { .kind = PEL_WATER_NAMED,
                                         .name = name,
                                         .depth_m = 8,
                                         .salinity_g_kg = PEL_SALINITY_USUAL,
                                         .temperature_c = PEL_TEMPERATURE_USUAL,
                                         .bottom = PEL_BOTTOM_SAND };
    if (pel_water_resolve(&desc, &w->body, NULL)) {
        return 1;
    }
    w->depths = (struct pel_water_depths){ LEVELS, 0.25,
                                           pel_water_visible_m(&w->body) };
    int failed =
        pel_water_kernel_build(&w->body, &w->depths, PEL_ORDERS_ALL, w->levels);
    for (int s = 0; s < SLOPES && !failed; s++) {
        struct row *p = t->plane[s];
        struct row *rows[4] = { &p[0], &p[1], &p[2], &p[3] };
        look_at_planes(w, slopes_deg[s], paths, rows);
        fprintf(stderr, "\rslopes: water %d, %g° ", (int)name, slopes_deg[s]);
    }
    if (!failed) {
        look_at_shape(w, &ridge, paths / 2, &t->ridge);
        look_at_shape(w, &step, paths / 2, &t->step);
    }
    return failed;
}

static double put_tables(FILE *md, const struct tables *t)
{
    static const char *const falls[4] = { "to the Sun", "across",
                                          "from the Sun", "across, other way" };
    double most = 0.0, noise = 0.0;
    fprintf(md,
            "\n## Over bottoms that are not level\n\n"
            "Deviation from the Monte Carlo's total in %%, rms: level water "
            "as deep as the place looked at → what is drawn. Tropical, North "
            "Atlantic and Baltic water over sand, three wavelengths, views of "
            "20 and 60°, 2 and 8 m deep where the line of sight ends, Sun at "
            "30 and 65°.\n\n"
            "| the bottom falls | single | second | higher | bottom | all | "
            "all, worst | noise |\n|---|---|---|---|---|---|---|---|\n");
    for (int s = 0; s < SLOPES; s++) {
        for (int k = 0; k < 4; k++) {
            char name[64];
            snprintf(name, sizeof name, "%g° %s", slopes_deg[s], falls[k]);
            put_row(md, name, &t->plane[s][k]);
            double off = rms(&t->plane[s][k].drawn, ALL);
            if (s == 0) {
                noise = fmax(noise, off);
            } else if (slopes_deg[s] <= 30) {
                most = fmax(most, off);
            }
        }
    }
    put_row(md, "ridge, 45°, 6 to 2 m", &t->ridge);
    put_row(md, "step, 3 to 8 m in 2 m", &t->step);
    /* Level water is the solver's, which other photons judge: what it is off by
     * here is these photons' own noise, large where particles scatter ahead. */
    return sqrt(fmax(most * most - noise * noise, 0.0));
}

double put_slopes(FILE *md, bool quick)
{
    static struct tables t;
    static struct water w;
    static const enum pel_water_name names[] = { PEL_WATER_TROPICAL,
                                                 PEL_WATER_NORTH_ATLANTIC,
                                                 PEL_WATER_BALTIC };
    memset(&t, 0, sizeof t);
    for (int i = 0; i < 3; i++) {
        if (fill(&t, &w, names[i], quick ? 4000 : 40000)) {
            return -1.0;
        }
    }
    return put_tables(md, &t);
}
