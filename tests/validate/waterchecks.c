#include "waterchecks.h"

#include <math.h>
#include <stdlib.h>

#include "base/vec.h"
#include "optics/ordinates.h"
#include "optics/waterreport.h"
#include "watercanonical.h"
#include "waterrays.h"

static struct pel_water_desc sea(double chlorophyll)
{
    return (struct pel_water_desc){ .chlorophyll_mg_m3 = chlorophyll,
                                    .salinity_g_kg = 35.0,
                                    .temperature_c = 15.0,
                                    .raman = true,
                                    .depth_m = 5000.0 };
}

/* Case 1 water with the dissolved matter that is measured in it on average:
 * Morel and Gentili 2009, a(400 nm) = 0.065 C^0.63 with a fall of 0.018 1/nm.
 * K_d and R by chlorophyll are averages of such water; the program's own
 * default has less. */
static struct pel_water_desc average_sea(double chlorophyll)
{
    struct pel_water_desc desc = sea(chlorophyll);
    desc.has_dissolved = true;
    desc.dissolved_slope = 0.018;
    desc.dissolved_per_m =
        0.065 * pow(chlorophyll, 0.63) * exp(-0.018 * (440.0 - 400.0));
    return desc;
}

/* Water by chlorophyll. */
struct recipe {
    const char *name;
    struct pel_water_desc (*sea)(double chlorophyll);
};

static const struct recipe average = { "average Case 1 water, CDOM after "
                                       "Morel and Gentili 2009",
                                       average_sea };
static const struct recipe usual = { "the program's default water", sea };

static struct pel_water_body body_of(const struct pel_water_desc *desc)
{
    struct pel_water_body body = { 0 };
    if (pel_water_resolve(desc, &body, NULL)) {
        abort(); /* our own waters */
    }
    return body;
}

/* --- against photons ------------------------------------------------------ */

struct tally {
    double square, noise, worst;
    int count;
};

static struct ray_water particles_of(const struct pel_iop *iop)
{
    double low = 3.01, high = 4.8;
    for (int i = 0; i < 30; i++) {
        double mu = 0.5 * (low + high);
        if (water_ray_back(1.01 + 0.1542 * (mu - 3.0), mu) < iop->back) {
            low = mu;
        } else {
            high = mu;
        }
    }
    return (struct ray_water){
        .absorption = pel_iop_absorption(iop),
        .molecular = iop->molecular,
        .particles = iop->particles,
        .index = 1.01 + 0.1542 * (low - 3.0),
        .size_slope = low,
        .molecular_anisotropy = (1.0 - 0.039) / (1.0 + 0.039),
    };
}

static const double views[] = { 0, 40, 70 };
static const struct ray_sun suns[] = {
    { 0, 0 },
    { 30 * PEL_DEG, 0.5 * PEL_PI },
    { 60 * PEL_DEG, PEL_PI },
    { 75 * PEL_DEG, 0 },
};

static void add(struct tally *t, double ours, double mean, double error)
{
    double off = ours / mean - 1.0, noise = error / mean;
    t->square += off * off;
    t->noise += noise * noise;
    t->worst = fmax(t->worst, fabs(off));
    t->count++;
}

static void compare_water(double chlorophyll, double nm, uint64_t paths,
                          struct tally *t)
{
    struct pel_water_desc desc = sea(chlorophyll);
    struct pel_water_body body = body_of(&desc);
    struct pel_medium m = pel_water_medium_at(&desc, &body, nm);
    struct pel_iop iop = pel_water_iop(&desc, nm);
    struct ray_water water = particles_of(&iop);
    for (int k = 0; k < 3 * 4; k++) {
        double view = views[k / 4] * PEL_DEG, mean, error;
        const struct ray_sun *sun = &suns[k % 4];
        water_rays(&water, view, sun, 1, paths, 1 + (uint64_t)k, &mean, &error);
        const struct pel_geometry at = { sun->zenith, view, sun->azimuth };
        struct pel_leaving l;
        if (pel_transport_leaving(&m, &at, PEL_ORDERS_ALL, &l)) {
            abort(); /* no memory */
        }
        add(t, l.total, mean, error);
    }
}

static void compare_raman(double chlorophyll, double nm, uint64_t paths,
                          struct tally *t, double *share)
{
    struct pel_water_desc desc = sea(chlorophyll);
    struct pel_water_body body = body_of(&desc);
    struct pel_iop iop = pel_water_iop(&desc, nm);
    struct pel_iop blue = pel_water_iop(&desc, pel_raman_excitation_nm(nm));
    struct ray_water water = particles_of(&iop), from = particles_of(&blue);
    *share = 0.0;
    for (int k = 0; k < 3 * 4; k++) {
        double view = views[k / 4] * PEL_DEG, mean, error;
        const struct ray_sun *sun = &suns[k % 4];
        water_rays_raman(&water, &from, pel_raman_strength(nm), view, sun, 1,
                         paths, 1 + (uint64_t)k, &mean, &error);
        const struct pel_geometry at = { sun->zenith, view, sun->azimuth };
        struct pel_water_report r;
        if (pel_water_report(&desc, &body, nm, &at, PEL_ORDERS_ALL, &r)) {
            abort(); /* no memory */
        }
        add(t, r.raman, mean, error);
        *share += r.raman / (r.raman + r.leaving.total) / 12.0;
    }
}

/* Raman's light by itself, whose share of all is the last column. */
static bool check_raman(FILE *md, bool quick)
{
    static const double waters[][2] = { { 0.05, 440 }, { 0.05, 550 },
                                        { 0.05, 680 }, { 0.5, 440 },
                                        { 0.5, 550 },  { 0.5, 680 },
                                        { 5, 680 } };
    const int count = sizeof waters / sizeof *waters;
    double squares = 0.0, noises = 0.0, worst = 0.0;
    fprintf(md, "\n## Raman scattering against photons\n\nWhat leaves the "
                "same waters of light whose wavelength the water changed, by "
                "itself, in %%; no strength, which both are given.\n\n| "
                "chlorophyll | nm | rms | its noise | worst | of what leaves "
                "|\n|---|---|---|---|---|---|\n");
    for (int i = 0; i < count; i++) {
        struct tally t = { 0 };
        double share;
        compare_raman(waters[i][0], waters[i][1], quick ? 5000 : 400000, &t,
                      &share);
        fprintf(md, "| %g | %g | %.2f | %.2f | %.2f | %.1f |\n", waters[i][0],
                waters[i][1], 100 * sqrt(t.square / t.count),
                100 * sqrt(t.noise / t.count), 100 * t.worst, 100 * share);
        squares += t.square / t.count / count;
        noises += t.noise / t.count / count;
        worst = fmax(worst, t.worst);
    }
    double rms = sqrt(squares), noise = sqrt(noises);
    fprintf(md,
            "\nRaman, all %d: rms %.2f %%, of which the photons' noise %.2f "
            "%%; worst %.2f %%.\n",
            count * 12, 100 * rms, 100 * noise, 100 * worst);
    /* 1 % of what is at most a fifth of the light. */
    return rms <= hypot(0.01, 1.5 * noise);
}

bool check_rays(FILE *md, bool quick)
{
    static const struct {
        double chlorophyll, nm;
        uint64_t paths; /* turbid water needs more */
    } waters[] = {
        { 0.05, 440, 2000000 }, { 0.05, 550, 2000000 }, { 0.05, 680, 500000 },
        { 0.5, 440, 4000000 },  { 0.5, 550, 4000000 },  { 0.5, 680, 1000000 },
        { 5, 680, 4000000 },
    };
    const int count = sizeof waters / sizeof *waters;
    struct tally all = { 0 };
    fprintf(md, "\n## Constituents against photons\n\nAll orders of deep "
                "water by chlorophyll, 3 views (0 to 70°) and 4 Suns (0 to "
                "75°), against photons that share no code with them "
                "(waterrays.c), in %%.\n\n| chlorophyll | nm | rms | its noise "
                "| worst |\n|---|---|---|---|---|\n");
    for (int i = 0; i < count; i++) {
        struct tally t = { 0 };
        compare_water(waters[i].chlorophyll, waters[i].nm,
                      waters[i].paths / (quick ? 40 : 1), &t);
        fprintf(md, "| %g | %g | %.2f | %.2f | %.2f |\n", waters[i].chlorophyll,
                waters[i].nm, 100 * sqrt(t.square / t.count),
                100 * sqrt(t.noise / t.count), 100 * t.worst);
        all.square += t.square;
        all.noise += t.noise;
        all.worst = fmax(all.worst, t.worst);
        all.count += t.count;
    }
    double rms = sqrt(all.square / all.count);
    double noise = sqrt(all.noise / all.count);
    fprintf(md,
            "\nAll %d: rms %.2f %%, of which the photons' noise %.2f %%; worst "
            "%.2f %%.\n",
            all.count, 100 * rms, 100 * noise, 100 * all.worst);
    /* 0.3 % beyond the noise, whose own error a sample's tails leave open. */
    return rms <= hypot(0.003, 1.5 * noise) && check_raman(md, quick);
}

/* --- published ------------------------------------------------------------ */

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

static const double chlorophylls[] = { 0.03, 0.1, 0.3, 1, 3, 10 };
enum { CHLOROPHYLLS = sizeof chlorophylls / sizeof *chlorophylls };

/* K_d = K_w + χ C^e: Morel and Maritorena 2001, table 2. */
static const double k_table[][4] = {
    { 400, 0.01042, 0.11748, 0.64358 },   { 412, 0.007932, 0.122858, 0.65327 },
    { 443, 0.00948, 0.107212, 0.673358 }, { 490, 0.0166, 0.07242, 0.68955 },
    { 510, 0.03385, 0.05943, 0.68567 },   { 555, 0.06053, 0.03996, 0.64204 },
    { 625, 0.284, 0.04, 0.647 },          { 670, 0.43946, 0.0515, 0.695 },
};
enum { ROWS = sizeof k_table / sizeof *k_table };

static double said_attenuation(int row, double chlorophyll)
{
    const double *k = k_table[row];
    return k[1] + k[2] * pow(chlorophyll, k[3]);
}

static double attenuation(FILE *md, const struct recipe *water)
{
    double off[ROWS * CHLOROPHYLLS];
    fprintf(md,
            "\n### K_d (Morel and Maritorena 2001), off by %%, Sun at 30°; "
            "%s\n\n| nm |",
            water->name);
    for (int c = 0; c < CHLOROPHYLLS; c++) {
        fprintf(md, " %g mg/m³ |", chlorophylls[c]);
    }
    fprintf(md, "\n|---|---|---|---|---|---|---|\n");
    for (int i = 0; i < ROWS; i++) {
        fprintf(md, "| %g |", k_table[i][0]);
        for (int c = 0; c < CHLOROPHYLLS; c++) {
            struct pel_water_desc desc = water->sea(chlorophylls[c]);
            struct pel_water_body body = body_of(&desc);
            struct pel_water_report r;
            const struct pel_geometry at = { 30 * PEL_DEG, 0, 0 };
            if (pel_water_report(&desc, &body, k_table[i][0], &at,
                                 PEL_ORDERS_SINGLE, &r)) {
                abort(); /* no memory */
            }
            double said = said_attenuation(i, chlorophylls[c]);
            off[i * CHLOROPHYLLS + c] = fabs(r.attenuation / said - 1.0);
            fprintf(md, " %+.1f |", 100 * (r.attenuation / said - 1.0));
        }
        fprintf(md, "\n");
    }
    return median(off, ROWS * CHLOROPHYLLS);
}

/* R under the surface: 0.33 b_b / (u K_d), u = 0.9 (1 − R) / (1 + 2.25 R),
 * with their K_d and their b_b, and sea water's scattering after Morel 1974:
 * Morel 1988; Morel and Maritorena 2001. */
static double said_reflectance(int row, double c)
{
    double nm = k_table[row][0], l = log10(c), r = 0.02;
    double power = c < 2.0 ? 0.5 * (l - 0.3) : 0.0;
    double back = 0.5 * 0.00288 * pow(nm / 500.0, -4.3) +
                  0.416 * pow(c, 0.766) *
                      (0.002 + 0.01 * (0.5 - 0.25 * l) * pow(nm / 550, power));
    for (int i = 0; i < 20; i++) {
        double u = 0.9 * (1.0 - r) / (1.0 + 2.25 * r);
        r = 0.33 * back / (u * said_attenuation(row, c));
    }
    return r;
}

static double by_chlorophyll(FILE *md, const struct recipe *water)
{
    double off[ROWS * CHLOROPHYLLS];
    fprintf(md,
            "\n### R (Morel and Maritorena 2001), off by %%, Sun at 30°; %s\n"
            "\n| nm | 0.03 mg/m³ | 0.1 | 0.3 | 1 | 3 | 10 |\n"
            "|---|---|---|---|---|---|---|\n",
            water->name);
    for (int i = 0; i < ROWS; i++) {
        fprintf(md, "| %g |", k_table[i][0]);
        for (int c = 0; c < CHLOROPHYLLS; c++) {
            struct pel_water_desc desc = water->sea(chlorophylls[c]);
            struct pel_water_body body = body_of(&desc);
            const struct pel_geometry at = { 30 * PEL_DEG, 0, 0 };
            struct pel_water_report r;
            if (pel_water_report(&desc, &body, k_table[i][0], &at,
                                 PEL_ORDERS_ALL, &r)) {
                abort(); /* no memory */
            }
            double by =
                r.reflectance / said_reflectance(i, chlorophylls[c]) - 1.0;
            off[i * CHLOROPHYLLS + c] = fabs(by);
            fprintf(md, " %.2f %% %+.1f |", 100 * r.reflectance, 100 * by);
        }
        fprintf(md, "\n");
    }
    return median(off, ROWS * CHLOROPHYLLS);
}

/* f = R a/b_b and Q of the nadir, f0 + s_f (1 − cos θ) and Q0 + s_Q (1 − cos
 * θ): Morel, Antoine and Gentili 2002, appendix B, at these wavelengths. */
static const double wavelengths[7] = { 412.5, 442.5, 490, 510, 560, 620, 660 };
static const double f_0[6][7] = {
    { 0.297892, 0.311742, 0.34728, 0.359728, 0.375008, 0.370053, 0.372716 },
    { 0.324018, 0.328848, 0.345755, 0.350503, 0.358735, 0.350497, 0.349206 },
    { 0.340239, 0.341657, 0.35098, 0.349334, 0.34957, 0.334437, 0.330755 },
    { 0.351673, 0.352505, 0.362207, 0.359773, 0.357388, 0.327275, 0.320913 },
    { 0.359587, 0.360429, 0.374357, 0.376513, 0.383433, 0.335178, 0.323731 },
    { 0.37057, 0.370782, 0.389128, 0.397841, 0.424316, 0.362306, 0.340204 },
};
static const double f_slope[6][7] = {
    { 0.065801, 0.076526, 0.095435, 0.103901, 0.121165, 0.134426, 0.143912 },
    { 0.095786, 0.111534, 0.138252, 0.14728, 0.16921, 0.183429, 0.195362 },
    { 0.131988, 0.154209, 0.191203, 0.201694, 0.225606, 0.227381, 0.236441 },
    { 0.18317, 0.213187, 0.261757, 0.276009, 0.305781, 0.284162, 0.285455 },
    { 0.239626, 0.273898, 0.330935, 0.349059, 0.386471, 0.352961, 0.343078 },
    { 0.316124, 0.35172, 0.415626, 0.438584, 0.482277, 0.457638, 0.433943 },
};
static const double q_0[6][7] = {
    { 3.31822, 3.29125, 3.24564, 3.1765, 3.13802, 3.11668, 3.12653 },
    { 3.3754, 3.3857, 3.40843, 3.35968, 3.33689, 3.30997, 3.33238 },
    { 3.48495, 3.52968, 3.61341, 3.60166, 3.60695, 3.5423, 3.5602 },
    { 3.67506, 3.74683, 3.86893, 3.89409, 3.94203, 3.81524, 3.80191 },
    { 3.91353, 3.99138, 4.11003, 4.14114, 4.18865, 4.10416, 4.05361 },
    { 4.2527, 4.31326, 4.39395, 4.40546, 4.36813, 4.42719, 4.37105 },
};
static const double q_slope[6][7] = {
    { 0.863223, 0.976278, 1.12929, 1.2031, 1.29677, 1.41301, 1.47942 },
    { 1.05551, 1.19009, 1.38213, 1.48291, 1.62596, 1.77507, 1.86629 },
    { 1.30283, 1.46993, 1.70068, 1.82746, 2.0361, 2.1757, 2.26936 },
    { 1.67118, 1.8777, 2.11591, 2.23996, 2.47982, 2.71118, 2.78971 },
    { 2.08395, 2.30369, 2.50664, 2.58009, 2.7077, 3.14131, 3.22904 },
    { 2.62595, 2.84375, 2.97879, 2.98696, 2.89875, 3.52796, 3.71754 },
};

static double reflectance(FILE *md, struct pel_ordinates *o)
{
    static const double zeniths[] = { 0, 30, 60 };
    double off[3 * 42], off_f[3 * 42], off_q[3 * 42];
    fprintf(md, "\n### f/Q of the nadir (Morel, Antoine and Gentili 2002), off "
                "by %%, Sun at 30°\n\n| mg/m³ |");
    for (int i = 0; i < 7; i++) {
        fprintf(md, " %g nm |", wavelengths[i]);
    }
    fprintf(md, "\n|---|---|---|---|---|---|---|---|\n");
    for (int k = 0; k < 3 * 42; k++) {
        int s = k / 42, c = k / 7 % 6, i = k % 7;
        struct pel_water_desc desc = sea(chlorophylls[c]);
        struct pel_water_body body = body_of(&desc);
        struct pel_medium m = pel_water_medium_at(&desc, &body, wavelengths[i]);
        double sun = zeniths[s] * PEL_DEG, surface = 0.0, low = 1.0 - cos(sun);
        struct pel_field at;
        pel_ordinates_field(o, &m, sun, &surface, 1, &at);
        const struct pel_geometry down = { sun, 0, 0 };
        struct pel_water_report r;
        if (pel_water_report(&desc, &body, wavelengths[i], &down,
                             PEL_ORDERS_ALL, &r)) {
            abort(); /* no memory */
        }
        double back = (1.0 - pel_medium_forward(&m)) * m.scattering;
        double f = r.reflectance * m.absorption / back /
                   (f_0[c][i] + low * f_slope[c][i]);
        double nadir = at.nadir + r.raman / pel_interface_at(&down).leaving;
        double q =
            r.reflectance * at.down / nadir / (q_0[c][i] + low * q_slope[c][i]);
        off[k] = fabs(f / q - 1.0);
        off_f[k] = fabs(f - 1.0);
        off_q[k] = fabs(q - 1.0);
        if (s == 1) {
            if (i == 0) {
                fprintf(md, "| %g |", chlorophylls[c]);
            }
            fprintf(md, " %+.1f |", 100 * (f / q - 1.0));
            fprintf(md, "%s", i == 6 ? "\n" : "");
        }
    }
    fprintf(md,
            "\nMedians over Suns at 0, 30 and 60°: f %.1f %%, Q %.1f %%, f/Q "
            "%.1f %%.\n",
            100 * median(off_f, 126), 100 * median(off_q, 126),
            100 * median(off, 126));
    return median(off, 126);
}

bool check_published(FILE *md)
{
    struct pel_ordinates *o = pel_ordinates_create(24, 1e-7);
    if (!o) {
        abort(); /* no memory */
    }
    fprintf(md, "\n## Published numbers\n");
    double models = canonical_published(md, o);
    double k_d = attenuation(md, &average), k_usual = attenuation(md, &usual);
    double r = by_chlorophyll(md, &average);
    double r_usual = by_chlorophyll(md, &usual);
    double f_q = reflectance(md, o);
    pel_ordinates_destroy(o);
    fprintf(md,
            "\nMedian off: canonical problems %.1f %%, K_d %.1f %%, R %.1f %%, "
            "f/Q %.1f %%.\nIn the default water: K_d %.1f %%, R %.1f %%.\n",
            100 * models, 100 * k_d, 100 * r, 100 * f_q, 100 * k_usual,
            100 * r_usual);
    /* The default water has less dissolved matter than the average, of which
     * K_d in the blue is then short: docs/physics/water.md. */
    return models <= 0.1 && f_q <= 0.1 && r <= 0.1 && k_d <= 0.1 &&
           k_usual <= 0.14;
}
