#include "watercanonical.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "optics/facets.h"
#include "optics/linear.h"
#include "watercolumn.h"
#include "waterrays.h"

#define BACK 0.0183 /* Petzold's backscattered fraction */
#define SKY_NODES 24
#define LEVELS 3
#define DEEP 1000.0

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *of, int count)
{
    qsort(of, (size_t)count, sizeof *of, ascending);
    return 0.5 * (of[(count - 1) / 2] + of[count / 2]);
}

/* --- problems 1, 2, 6 ----------------------------------------------------- */

enum { FOUND = 3 }; /* E_d, E_ou, L_u */

/* Averages of the seven models, of a Sun at 60° of irradiance 1 normal to its
 * beam and no sky, and how their results scatter, in % (as M. Gimond's AOMC
 * and, at a depth of 1, A. Castagna's Monte Carlo quote the paper). 0: not
 * read, where the quotation has no more than two digits. */
static const struct published {
    const char *name;
    double albedo; /* of single scattering */
    bool molecules;
    double depth, bottom, at;
    double value[FOUND], scatter[FOUND];
} problems[] = {
    { "1", 0.2, 1, DEEP, 0, 1, { .141, .0134, 1.72e-3 }, { .1, .3, 4.4 } },
    { "1", 0.2, 1, DEEP, 0, 5, { 1.07e-3, 1e-4, 1.37e-5 }, { .5, 3.9, 28.8 } },
    { "1", 0.9, 1, DEEP, 0, 1, { .366, .372, .0485 }, { .2, .5, 1.5 } },
    { "1", 0.9, 1, DEEP, 0, 5, { .0433, .0435, 5.59e-3 }, { .3, .7, 5.2 } },
    { "1", 0.9, 1, DEEP, 0, 10, { 3.16e-3, 3.2e-3, 4.37e-4 }, { 1.5, 3.8, 9 } },
    { "2", 0.2, 0, DEEP, 0, 1, { .162, 9.66e-4, 5.47e-5 }, { 0, 2.3, 6 } },
    { "2", 0.2, 0, DEEP, 0, 5, { 2.27e-3, 1.37e-5, 0 }, { .2, 6.3, 0 } },
    { "2", 0.2, 0, DEEP, 0, 10, { 1.3e-5, 0, 0 }, { 4.7, 0, 0 } },
    { "2", 0.9, 0, DEEP, 0, 1, { .413, .0931, 6.99e-3 }, { .1, 2.1, 6.3 } },
    { "2", 0.9, 0, DEEP, 0, 5, { .187, .0463, 3.29e-3 }, { .5, 1.7, 5.5 } },
    { "2", 0.9, 0, DEEP, 0, 10, { .0685, .0165, 1.21e-3 }, { 1, 1.4, 10.9 } },
    { "6", 0.2, 0, 5, 0.5, 1, { .162, 9.81e-4, 6.84e-5 }, { 0, 1, 2 } },
    { "6", 0.2, 0, 5, 0.5, 5, { 2.28e-3, 2.28e-3, 3.6e-4 }, { .3, .2, 1 } },
};
enum { PROBLEMS = sizeof problems / sizeof *problems };

static struct pel_medium medium_of(const struct published *p)
{
    return (struct pel_medium){
        .absorption = 1.0 - p->albedo,
        .scattering = p->albedo,
        .molecular = p->molecules ? 1.0 : 0.0,
        .back = p->molecules ? 0.0 : BACK,
        .depth_m = p->depth,
        .albedo = p->bottom,
    };
}

double canonical_published(FILE *md, struct pel_ordinates *o)
{
    double off[PROBLEMS * FOUND];
    int count = 0;
    fprintf(md,
            "\n### Canonical problems 1, 2, 6 (Mobley et al. 1993)\n\n"
            "How the seven models scatter is the standard deviation; "
            "particles are Petzold's there, here Fournier and Forand's of the "
            "same backscattered fraction.\n\n"
            "| problem | ω0 | depth | E_d | published | they scatter, %% | "
            "off, %% | E_ou | published | they scatter | off | L_u | published "
            "| they scatter | off |\n"
            "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < PROBLEMS; i++) {
        const struct published *p = &problems[i];
        const struct pel_medium m = medium_of(p);
        struct pel_field f;
        pel_ordinates_field(o, &m, 60 * PEL_DEG, &p->at, 1, &f);
        const double found[FOUND] = { f.down, f.scalar_up, f.nadir };
        fprintf(md, "| %s | %g | %g |", p->name, p->albedo, p->at);
        for (int k = 0; k < FOUND; k++) {
            if (p->value[k] > 0.0) {
                double by = found[k] / p->value[k] - 1.0;
                off[count++] = fabs(by);
                fprintf(md, " %.3g | %.3g | %.1f | %+.1f |", found[k],
                        p->value[k], p->scatter[k], 100 * by);
            } else {
                fprintf(md, " %.3g | | | |", found[k]);
            }
        }
        fprintf(md, "\n");
    }
    return median(off, count);
}

/* --- columns of water ----------------------------------------------------- */

static struct column particles(void)
{
    double low = 3.01, high = 4.8;
    for (int i = 0; i < 30; i++) {
        double mu = 0.5 * (low + high);
        if (water_ray_back(1.01 + 0.1542 * (mu - 3.0), mu) < BACK) {
            low = mu;
        } else {
            high = mu;
        }
    }
    return (struct column){
        .by = COLUMN_FOURNIER_FORAND,
        .index = 1.01 + 0.1542 * (low - 3.0),
        .size_slope = low,
        .molecular_anisotropy = (1.0 - 0.039) / (1.0 + 0.039),
    };
}

static struct column_water dark(double depth_m)
{
    (void)depth_m;
    return (struct column_water){ 0.8, 0.0, 0.2 };
}

static struct column_water bright(double depth_m)
{
    (void)depth_m;
    return (struct column_water){ 0.1, 0.0, 0.9 };
}

static double sun_60(double u)
{
    (void)u;
    return 0.5;
}

static double sun_80(double u)
{
    (void)u;
    return cos(80 * PEL_DEG);
}

struct tally {
    double off[64], noise[64];
    int count;
};

static void put(FILE *md, struct tally *t, double ours, double mean,
                double error)
{
    t->off[t->count] = fabs(ours / mean - 1.0);
    t->noise[t->count++] = error / mean;
    fprintf(md, " %.3g | %.3g | %.1f | %+.1f |", ours, mean, 100 * error / mean,
            100 * (ours / mean - 1.0));
}

static void put_field(FILE *md, struct tally *t, const struct pel_field *ours,
                      const struct column_field *mean,
                      const struct column_field *error)
{
    put(md, t, ours->down, mean->down, error->down);
    put(md, t, ours->scalar_up, mean->scalar_up, error->scalar_up);
    put(md, t, ours->nadir, mean->nadir, error->nadir);
    fprintf(md, "\n");
}

static void put_head(FILE *md, const char *first)
{
    fprintf(md,
            "| %s | E_d | photons | noise, %% | off, %% | E_ou | photons | "
            "noise | off | L_u | photons | noise | off |\n"
            "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
            first);
}

/* What the photons are worth: problems 2 and 6 with Petzold's own function,
 * against the published averages. */
static double photons_published(FILE *md, bool quick)
{
    struct tally t = { 0 };
    fprintf(md, "\n## Columns of water\n\n### The photons themselves: problems "
                "2 and 6 with Petzold's own function, against what is "
                "published\n\n");
    fprintf(md, "| problem, ω0, depth | E_d | published | noise, %% | off, %% "
                "| E_ou | published | noise | off | L_u | published | noise | "
                "off |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|"
                "\n");
    for (int i = 0; i < PROBLEMS; i++) {
        const struct published *p = &problems[i];
        if (p->molecules || p->at > 5) {
            continue;
        }
        struct column c = particles();
        struct column_field mean, error;
        c.at = p->albedo < 0.5 ? dark : bright;
        c.by = COLUMN_PETZOLD;
        c.light = sun_60;
        c.depth_m = fmin(p->depth, 40.0);
        c.bottom = p->bottom;
        water_column(&c, &p->at, 1, quick ? 30000 : 500000, 1 + (uint64_t)i,
                     &mean, &error);
        const double found[FOUND] = { mean.down, mean.scalar_up, mean.nadir };
        const double noise[FOUND] = { error.down, error.scalar_up,
                                      error.nadir };
        fprintf(md, "| %s, %g, %g |", p->name, p->albedo, p->at);
        for (int k = 0; k < FOUND; k++) {
            if (p->value[k] > 0.0) {
                put(md, &t, 0.5 * found[k], p->value[k],
                    p->value[k] * noise[k] / found[k]);
            } else {
                fprintf(md, " %.3g | | %.1f | |", 0.5 * found[k],
                        100 * noise[k] / found[k]);
            }
        }
        fprintf(md, "\n");
    }
    return median(t.off, t.count);
}

/* Problem 3: chlorophyll of a mean profile of the Celtic Sea in May, by the
 * law of case 1 waters of its time, at 500 nm. */
static struct column_water layered(double z)
{
    const double away = (z - 17.0) / 9.0;
    double c =
        0.2 + 144.0 / (9.0 * sqrt(2.0 * PEL_PI)) * exp(-0.5 * away * away);
    return (struct column_water){
        .absorption = (0.0257 + 0.06 * 0.668 * pow(c, 0.65)) *
                      (1.0 + 0.2 * exp(-0.014 * (500.0 - 440.0))),
        .molecular = 0.0029,
        .particles = 550.0 / 500.0 * 0.3 * pow(c, 0.62),
    };
}

/* The water that such a column looks like from above: its constituents by the
 * light that comes to them and back (Gordon and Clark 1980). */
static struct pel_medium weighted(void)
{
    const double step = 0.05;
    double way = 0.0, sum = 0.0, a = 0.0, m = 0.0, p = 0.0;
    for (double z = 0.5 * step; z < 100.0; z += step) {
        struct column_water w = layered(z);
        double k = (w.absorption + 0.5 * w.molecular + BACK * w.particles) /
                   sqrt(1.0 - 0.75 / (1.34 * 1.34));
        double weight = exp(-2.0 * (way + 0.5 * k * step));
        way += k * step;
        sum += weight;
        a += weight * w.absorption;
        m += weight * w.molecular;
        p += weight * w.particles;
    }
    return (struct pel_medium){
        .absorption = a / sum,
        .scattering = (m + p) / sum,
        .molecular = m / (m + p),
        .back = BACK,
        .depth_m = DEEP,
    };
}

static double stratified(FILE *md, struct pel_ordinates *o, bool quick)
{
    const double depths[] = { 0, 5, 25, 60 };
    struct column c = particles();
    struct column_field mean[4], error[4];
    struct pel_field ours[4];
    struct tally top = { 0 }, below = { 0 };
    c.at = layered;
    c.light = sun_60;
    c.depth_m = 120.0;
    water_column(&c, depths, 4, quick ? 30000 : 600000, 11, mean, error);
    const struct pel_medium m = weighted();
    pel_ordinates_field(o, &m, 60 * PEL_DEG, depths, 4, ours);
    fprintf(md,
            "\n### Problem 3: chlorophyll by depth\n\nThe solver's water is "
            "the same at every depth: the constituents of the column by the "
            "light that comes to them and back, a %.4f, b %.4f 1/m.\n\n",
            m.absorption, m.scattering);
    put_head(md, "depth, m");
    for (int i = 0; i < 4; i++) {
        struct column_field half = { 0.5 * mean[i].down,
                                     0.5 * mean[i].scalar_up,
                                     0.5 * mean[i].nadir };
        struct column_field wide = { 0.5 * error[i].down,
                                     0.5 * error[i].scalar_up,
                                     0.5 * error[i].nadir };
        fprintf(md, "| %g |", depths[i]);
        put_field(md, i ? &below : &top, &ours[i], &half, &wide);
    }
    return median(top.off, top.count);
}

/* --- below a sky ---------------------------------------------------------- */

#define DIFFUSE 0.3 /* of the horizontal irradiance */
#define SKY_CELLS 512

/* A clear sky, Harrison and Coombes 1988, the mean around the zenith. */
static double harrison(double mu)
{
    double sum = 0.0, sun = 60 * PEL_DEG;
    for (int i = 0; i < 64; i++) {
        double c = mu * cos(sun) + sqrt(1.0 - mu * mu) * sin(sun) *
                                       cos(PEL_PI * (i + 0.5) / 64);
        double away = acos(fmin(fmax(c, -1.0), 1.0));
        sum += 1.63 + 53.7 * exp(-5.49 * away) + 2.04 * c * c * cos(sun);
    }
    return sum / 64 * (1.0 - exp(-0.19 / fmax(mu, 1e-6))) *
           (1.0 - exp(-0.53 / cos(sun)));
}

static double sky_below[SKY_CELLS + 1]; /* its horizontal irradiance by μ² */

static double fill_sky(void)
{
    for (int i = 0; i < SKY_CELLS; i++) {
        /* μ dμ = d(μ²) / 2 */
        sky_below[i + 1] =
            sky_below[i] +
            PEL_PI / SKY_CELLS * harrison(sqrt((i + 0.5) / SKY_CELLS));
    }
    double whole = sky_below[SKY_CELLS];
    for (int i = 0; i <= SKY_CELLS; i++) {
        sky_below[i] /= whole;
    }
    return whole;
}

static double sun_and_sky(double u)
{
    if (u >= DIFFUSE) {
        return 0.5;
    }
    u /= DIFFUSE;
    int i = 0;
    while (i < SKY_CELLS - 1 && sky_below[i + 1] < u) {
        i++;
    }
    double part = (u - sky_below[i]) / (sky_below[i + 1] - sky_below[i]);
    return sqrt((i + fmin(fmax(part, 0.0), 1.0)) / SKY_CELLS);
}

static void add_field(struct pel_field *to, const struct pel_field *f,
                      double by)
{
    to->down += by * f->down;
    to->up += by * f->up;
    to->scalar_up += by * f->scalar_up;
    to->nadir += by * f->nadir;
}

/* The sky as beams. */
static void field_of_sky(struct pel_ordinates *o, const struct pel_medium *m,
                         double scale, const double *depths, int count,
                         struct pel_field *out)
{
    double mu[SKY_NODES], weight[SKY_NODES];
    struct pel_field f[COLUMN_DEPTHS];
    pel_gauss_legendre(SKY_NODES, 0.0, 1.0, mu, weight);
    pel_ordinates_field(o, m, 60 * PEL_DEG, depths, count, f);
    for (int k = 0; k < count; k++) {
        out[k] = (struct pel_field){ 0 };
        add_field(&out[k], &f[k], (1.0 - DIFFUSE) / 0.5);
    }
    for (int i = 0; i < SKY_NODES; i++) {
        pel_ordinates_field(o, m, acos(mu[i]), depths, count, f);
        for (int k = 0; k < count; k++) {
            add_field(&out[k], &f[k],
                      2.0 * PEL_PI * weight[i] * scale * harrison(mu[i]));
        }
    }
}

/* The sky by its modes, as pictures' skylight is solved: straight up just
 * below the surface. */
static double nadir_of_sky(struct pel_ordinates *o, const struct pel_medium *m,
                           double scale)
{
    double sky[PEL_ORDINATES_MAX], out[2 * PEL_ORDINATES_MAX];
    const double up = 1.0, sun = (1.0 - DIFFUSE) / 0.5;
    int modes;
    for (int i = 0; i < pel_ordinates_sky_nodes(o); i++) {
        sky[i] = scale * harrison(cos(pel_ordinates_sky_node(o, i)));
    }
    const struct pel_ordinates_light light = {
        .sun_zenith_rad = 60 * PEL_DEG, .sun = sun, .sky = sky, .sky_modes = 1
    };
    pel_ordinates_solve(o, m, &light, &up, 1, out, &modes, NULL);
    const struct pel_geometry at = { 60 * PEL_DEG, 0, 0 };
    struct pel_interface face = pel_interface_at(&at);
    return out[0] + pel_ordinates_single(o, m, sun * face.beam, face.sun_mu,
                                         1.0, -face.sun_mu);
}

/* At depths where photons know the light that comes up. */
static const struct {
    const char *name;
    struct column_water (*at)(double depth_m);
    double albedo;
    int depths;
} waters[] = { { "0.2", dark, 0.2, 2 }, { "0.9", bright, 0.9, 3 } };

static double below_sky(FILE *md, struct pel_ordinates *o, bool quick,
                        double *noise)
{
    const double depths[LEVELS] = { 0, 1, 5 };
    struct tally t = { 0 };
    double scale = DIFFUSE / fill_sky();
    fprintf(md, "\n### Problem 4: the particles of problem 2 below a clear sky "
                "(Harrison and Coombes 1988), 0.3 of the horizontal "
                "irradiance\n\n");
    put_head(md, "ω0, depth");
    for (int i = 0; i < 2; i++) {
        struct column c = particles();
        struct column_field mean[LEVELS], error[LEVELS];
        struct pel_field ours[LEVELS];
        const struct pel_medium m = { .absorption = 1.0 - waters[i].albedo,
                                      .scattering = waters[i].albedo,
                                      .back = BACK,
                                      .depth_m = DEEP };
        c.at = waters[i].at;
        c.light = sun_and_sky;
        c.depth_m = 40.0;
        water_column(&c, depths, waters[i].depths, quick ? 30000 : 800000, 21,
                     mean, error);
        field_of_sky(o, &m, scale, depths, waters[i].depths, ours);
        for (int k = 0; k < LEVELS && k < waters[i].depths; k++) {
            fprintf(md, "| %s, %g |", waters[i].name, depths[k]);
            put_field(md, &t, &ours[k], &mean[k], &error[k]);
        }
        fprintf(md, "| %s, by modes | | | | | | | | |", waters[i].name);
        put(md, &t, nadir_of_sky(o, &m, scale), mean[0].nadir, error[0].nadir);
        fprintf(md, "\n");
    }
    *noise = median(t.noise, t.count);
    return median(t.off, t.count);
}

/* --- below waves ---------------------------------------------------------- */

/* The part that enters, as pictures have it. */
static double through_waves(double zenith, double slopes)
{
    const struct pel_vec3 to = { sin(zenith), 0.0, cos(zenith) };
    return pel_facets_entering(to, 0.5 * slopes, 0.5 * slopes);
}

static struct column_water black(double depth_m)
{
    (void)depth_m;
    return (struct column_water){ 1.0, 1e-9, 0.0 };
}

static double low_sun;

static double from_low_sun(double u)
{
    (void)u;
    return cos(low_sun);
}

/* What enters by Sun and slopes, against photons. */
static double entering(FILE *md, bool quick)
{
    static const double zeniths[] = { 30, 60, 70, 75, 80, 85 };
    static const double slopes[] = { 0.013, 0.04, 0.08 };
    const double surface = 0.0;
    double off[18];
    fprintf(md, "\n### What enters through waves, of what falls on them\n\n"
                "Mean square slopes; ours as pictures have it, photons', off "
                "in %%.\n\n| Sun | level | 0.013 (2 m/s) | | | 0.04 (7 m/s) | "
                "| | 0.08 (15 m/s) | | |\n|---|---|---|---|---|---|---|---|---|"
                "---|---|\n");
    for (int i = 0; i < 6; i++) {
        low_sun = zeniths[i] * PEL_DEG;
        fprintf(md, "| %g° | %.3f |", zeniths[i], through_waves(low_sun, 0.0));
        for (int k = 0; k < 3; k++) {
            struct column c = particles();
            struct column_field mean, error;
            c.at = black;
            c.light = from_low_sun;
            c.depth_m = 10.0;
            c.slopes = slopes[k];
            water_column(&c, &surface, 1, quick ? 10000 : 100000, 41, &mean,
                         &error);
            double ours = through_waves(low_sun, slopes[k]);
            off[3 * i + k] = fabs(ours / mean.down - 1.0);
            fprintf(md, " %.3f | %.3f | %+.1f |", ours, mean.down,
                    100 * (ours / mean.down - 1.0));
        }
        fprintf(md, "\n");
    }
    return median(off, 18);
}

static double below_waves(FILE *md, struct pel_ordinates *o, bool quick)
{
    const double depths[LEVELS] = { 0, 1, 5 };
    struct tally t = { 0 };
    double more =
        through_waves(80 * PEL_DEG, 0.04) / through_waves(80 * PEL_DEG, 0.0);
    fprintf(md,
            "\n### Problem 5: the particles of problem 2 below waves of a "
            "mean square slope of 0.04 (7.23 m/s), Sun at 80°\n\nThe "
            "solver's surface is level; what enters is the pictures', "
            "%.3f of what enters so.\n\n",
            more);
    put_head(md, "ω0, depth");
    for (int i = 0; i < 2; i++) {
        struct column c = particles();
        struct column_field mean[LEVELS], error[LEVELS];
        struct pel_field ours[LEVELS];
        const struct pel_medium m = { .absorption = 1.0 - waters[i].albedo,
                                      .scattering = waters[i].albedo,
                                      .back = BACK,
                                      .depth_m = DEEP };
        c.at = waters[i].at;
        c.light = sun_80;
        c.depth_m = 40.0;
        c.slopes = 0.04;
        water_column(&c, depths, waters[i].depths, quick ? 30000 : 600000, 31,
                     mean, error);
        pel_ordinates_field(o, &m, 80 * PEL_DEG, depths, waters[i].depths,
                            ours);
        for (int k = 0; k < LEVELS && k < waters[i].depths; k++) {
            struct pel_field unit = { 0 };
            add_field(&unit, &ours[k], more / cos(80 * PEL_DEG));
            fprintf(md, "| %s, %g |", waters[i].name, depths[k]);
            put_field(md, &t, &unit, &mean[k], &error[k]);
        }
    }
    return median(t.off, t.count);
}

bool check_columns(FILE *md, bool quick)
{
    struct pel_ordinates *o = pel_ordinates_create(24, 1e-7);
    if (!o) {
        abort(); /* no memory */
    }
    double noise;
    double own = photons_published(md, quick);
    double layers = stratified(md, o, quick);
    double sky = below_sky(md, o, quick, &noise);
    double waves = below_waves(md, o, quick);
    double enters = entering(md, quick);
    pel_ordinates_destroy(o);
    fprintf(md,
            "\nColumns, median off: photons against published %.1f %%, "
            "problem 3 %.1f %%, problem 4 %.1f %% (noise %.1f %%), problem 5 "
            "%.1f %%, light through waves %.1f %%.\n",
            100 * own, 100 * layers, 100 * sky, 100 * noise, 100 * waves,
            100 * enters);
    return own <= 0.1 && sky <= hypot(0.01, 1.5 * noise);
}
