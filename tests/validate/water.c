/* `make validate`: the orders of scattering against a Monte Carlo of the same
 * water, over waters, depths, Suns and views; the paper's form beside them;
 * its sampling study (figs. 7 and 8); bottoms that are not level; constituents
 * against photons and published numbers. Prints
 * progress, writes build/validate/water.md, water.json and sampling.json;
 * status 1 when a promise is broken. --quick: every fifth water, at most a
 * fifteenth of the paths, the maps as they are made, into
 * build/validate/quick/: what is compared with a Monte Carlo has three of its
 * standard errors as room, so fewer paths see only larger faults. --sampling,
 * --slopes, --sea: these alone. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/clock.h"
#include "base/vec.h"
#include "optics/watermontecarlo.h"
#include "watercanonical.h"
#include "waterchecks.h"
#include "watersampling.h"
#include "waterslopes.h"

#define SUNS 10
#define VIEWS 4
#define WATERS 24
#define ROWS (WATERS * VIEWS * SUNS)
#define QUICK_STEP 5 /* meets every pair of coefficients, asymmetry, depth */

static const struct pel_montecarlo_sun suns[SUNS] = {
    { 0, 0 },
    { 30 * PEL_DEG, 0 },
    { 30 * PEL_DEG, 0.5 * PEL_PI },
    { 30 * PEL_DEG, PEL_PI },
    { 60 * PEL_DEG, 0 },
    { 60 * PEL_DEG, 0.5 * PEL_PI },
    { 60 * PEL_DEG, PEL_PI },
    { 85 * PEL_DEG, 0 },
    { 85 * PEL_DEG, 0.5 * PEL_PI },
    { 85 * PEL_DEG, PEL_PI },
};
static const double views[VIEWS] = { 0, 40, 70, 88 };

/* Clear, middling, turbid and red: ω0 0.67, 0.89, 0.92, 0.33. */
static const double coefficients[4][2] = {
    { 0.05, 0.1 }, { 0.05, 0.4 }, { 0.15, 1.7 }, { 0.4, 0.2 }
};
static const double depths[3] = { 1, 10, 1000 };

struct row {
    double mc_two, mc_two_error, mc_all, mc_all_error;
    double two, all, paper, single;
};

static struct row rows[ROWS];

static bool is_known(const struct row *r)
{
    return r->mc_all > 0.0;
}

static struct pel_medium water(int i)
{
    return (struct pel_medium){
        .absorption = coefficients[i / 6][0],
        .scattering = coefficients[i / 6][1],
        .asymmetry = i / 3 % 2 ? 0.75 : 0.924,
        .depth_m = depths[i % 3],
        .albedo = i % 3 == 2 ? 0.0 : 0.3,
    };
}

/* Batches until every Sun is known well enough, or as many as may be. Weighs
 * batches equally; their errors add in squares. */
static void judge(const struct pel_medium *m, double view_deg, bool quick,
                  uint64_t seed, struct row out[SUNS])
{
    const double wanted = quick ? 0.02 : 0.006;
    const int most = quick ? 4 : 24, paths = quick ? 20000 : 50000;
    struct pel_montecarlo_result r[SUNS];
    double two[SUNS] = { 0 }, two2[SUNS] = { 0 };
    double all[SUNS] = { 0 }, all2[SUNS] = { 0 };
    for (int n = 1; n <= most; n++) {
        double worst = 0.0;
        pel_montecarlo_leaving(m, NULL, view_deg * PEL_DEG, suns, SUNS, paths,
                               seed + (uint64_t)n, r, NULL);
        for (int i = 0; i < SUNS; i++) {
            two[i] +=
                r[i].single.mean + r[i].second.mean + r[i].bottom_direct.mean;
            two2[i] += r[i].single.error * r[i].single.error +
                       r[i].second.error * r[i].second.error +
                       r[i].bottom_direct.error * r[i].bottom_direct.error;
            all[i] += r[i].total.mean;
            all2[i] += r[i].total.error * r[i].total.error;
            out[i].mc_two = two[i] / n;
            out[i].mc_two_error = sqrt(two2[i]) / n;
            out[i].mc_all = all[i] / n;
            out[i].mc_all_error = sqrt(all2[i]) / n;
            worst = fmax(worst, out[i].mc_two_error / out[i].mc_two);
            worst = fmax(worst, out[i].mc_all_error / out[i].mc_all);
        }
        if (worst < wanted && n >= 4) {
            return;
        }
    }
}

static int compute(const struct pel_medium *m, double view_deg,
                   struct row out[SUNS])
{
    for (int i = 0; i < SUNS; i++) {
        struct pel_geometry at = { suns[i].zenith_rad, view_deg * PEL_DEG,
                                   suns[i].azimuth_rad };
        struct pel_leaving two, all, paper;
        if (pel_transport_leaving(m, &at, PEL_ORDERS_TWO, &two) ||
            pel_transport_leaving(m, &at, PEL_ORDERS_ALL, &all) ||
            pel_transport_leaving(m, &at, PEL_ORDERS_PAPER, &paper)) {
            return 1;
        }
        out[i].two = two.total;
        out[i].all = all.total;
        out[i].paper = paper.total;
        out[i].single = paper.single + paper.bottom_direct;
    }
    return 0;
}

/* Deviation of a set of rows from the Monte Carlo. */
struct deviation {
    double worst, square, chance; /* chance: worst beyond 3 standard errors */
    int count;
};

static void deviate(struct deviation *d, double value, double truth,
                    double error)
{
    double off = value / truth - 1.0;
    d->worst = fmax(d->worst, fabs(off));
    d->chance = fmax(d->chance, fabs(off) - 3.0 * error / truth);
    d->square += off * off;
    d->count++;
}

static double rms(const struct deviation *d)
{
    return sqrt(d->square / d->count);
}

static void put_water(FILE *md, int w, struct deviation total[4])
{
    struct pel_medium m = water(w);
    struct deviation d[4] = { 0 };
    double noise = 0.0;
    for (int k = w * VIEWS * SUNS; k < (w + 1) * VIEWS * SUNS; k++) {
        const struct row *r = &rows[k];
        const double values[4] = { r->two, r->all, r->paper, r->single };
        for (int j = 0; j < 4; j++) {
            double truth = j == 0 ? r->mc_two : r->mc_all;
            double error = j == 0 ? r->mc_two_error : r->mc_all_error;
            deviate(&d[j], values[j], truth, error);
            deviate(&total[j], values[j], truth, error);
        }
        noise = fmax(noise, r->mc_all_error / r->mc_all);
    }
    fprintf(md,
            "| %.2f | %.2f | %.3f | %g | %.1f | %.2f | %.2f | %.2f | %.2f | "
            "%.2f | %.0f | %.0f |\n",
            m.absorption, m.scattering, m.asymmetry, m.depth_m, m.albedo,
            100 * d[0].worst, 100 * rms(&d[0]), 100 * d[1].worst,
            100 * rms(&d[1]), 100 * noise, 100 * rms(&d[2]), 100 * rms(&d[3]));
}

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Median of a member of the rows over a black bottom, of all orders. */
static double median_deep(size_t member)
{
    static double all[ROWS];
    int count = 0;
    for (int i = 0; i < ROWS; i++) {
        if (water(i / (VIEWS * SUNS)).albedo == 0.0 && is_known(&rows[i])) {
            const double *value =
                (const double *)((const char *)&rows[i] + member);
            all[count++] = *value / rows[i].mc_all;
        }
    }
    qsort(all, (size_t)count, sizeof *all, ascending);
    return all[count / 2];
}

static void put_json(FILE *json)
{
    fprintf(json, "[\n");
    const char *separator = "";
    for (int k = 0; k < ROWS; k++) {
        const struct row *r = &rows[k];
        struct pel_medium m = water(k / (VIEWS * SUNS));
        if (!is_known(r)) {
            continue;
        }
        int s = k % SUNS;
        fprintf(json,
                "%s{\"absorption\": %g, \"scattering\": %g, \"asymmetry\": %g, "
                "\"depth\": %g, \"albedo\": %g, \"viewZenith\": %g, "
                "\"sunZenith\": %g, \"azimuth\": %g, \"montecarloTwo\": %.6g, "
                "\"montecarloTwoError\": %.2g, \"montecarlo\": %.6g, "
                "\"montecarloError\": %.2g, \"two\": %.6g, \"all\": %.6g, "
                "\"paper\": %.6g}",
                separator, m.absorption, m.scattering, m.asymmetry, m.depth_m,
                m.albedo, views[k / SUNS % VIEWS], suns[s].zenith_rad / PEL_DEG,
                suns[s].azimuth_rad / PEL_DEG, r->mc_two, r->mc_two_error,
                r->mc_all, r->mc_all_error, r->two, r->all, r->paper);
        separator = ",\n";
    }
    fprintf(json, "\n]\n");
}

static int report(FILE *md, bool quick)
{
    struct deviation total[4] = { 0 };
    fprintf(md, "# The water against Monte Carlo\n\n"
                "Deviation in %% over 4 views (0 to 88°) and 10 Suns (0 to "
                "85°): single + second + direct bottom, and all orders, each "
                "against the Monte Carlo's own; worst and rms. Noise: the "
                "largest standard error of the Monte Carlo's total. Last "
                "columns: the paper's form, and its single scattering alone, "
                "against all orders, rms.\n\n"
                "| a | b | g | depth | albedo | two: worst | rms | all: worst "
                "| rms | noise | paper | single |\n"
                "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int w = 0; w < WATERS; w += quick ? QUICK_STEP : 1) {
        put_water(md, w, total);
    }
    fprintf(md,
            "\nAll %d: single + second worst %.2f %%, rms %.2f %%, beyond "
            "three standard errors %.2f %%; all orders worst %.2f %%, rms "
            "%.2f %%, beyond three standard errors %.2f %%.\n\n"
            "Of all orders over a black bottom, two orders bring %.2f in the "
            "median and the paper's form %.2f; over every bottom the paper's "
            "form is off by %.0f %% rms, %.0f %% at worst, its single "
            "scattering by %.0f %% rms.\n",
            total[1].count, 100 * total[0].worst, 100 * rms(&total[0]),
            100 * fmax(total[0].chance, 0.0), 100 * total[1].worst,
            100 * rms(&total[1]), 100 * fmax(total[1].chance, 0.0),
            median_deep(offsetof(struct row, two)),
            median_deep(offsetof(struct row, paper)), 100 * rms(&total[2]),
            100 * total[2].worst, 100 * rms(&total[3]));
    /* So few paths understate their own error where light is rare. */
    double rare = quick ? 0.01 : 0.0;
    return total[0].chance > 0.02 + rare || total[1].chance > 0.03 + rare;
}

static int validate(bool quick, FILE *md, FILE *json, int64_t start)
{
    for (int w = 0; w < WATERS; w += quick ? QUICK_STEP : 1) {
        for (int v = 0; v < VIEWS; v++) {
            struct pel_medium m = water(w);
            struct row *to = &rows[(w * VIEWS + v) * SUNS];
            judge(&m, views[v], quick, (uint64_t)(w * VIEWS + v) * 1000, to);
            if (compute(&m, views[v], to)) {
                return 1;
            }
            fprintf(stderr, "\rwater %d/%d, view %d/%d, %.0f s ", w + 1, WATERS,
                    v + 1, VIEWS, 1e-9 * (double)(pel_now_ns() - start));
        }
    }
    int broken = report(md, quick);
    put_json(json);
    return broken;
}

/* A report of these figures; the quick ones never replace the full ones. */
static FILE *open_report(bool quick, bool wanted, const char *name,
                         const char *how)
{
    char path[64];
    snprintf(path, sizeof path, "build/validate/%s%s", quick ? "quick/" : "",
             name);
    return fopen(wanted ? path : "/dev/null", how);
}

int main(int argc, char **argv)
{
    bool quick = false, study = false, slopes = false, sea = false;
    for (int i = 1; i < argc; i++) {
        bool *named = strcmp(argv[i], "--quick") == 0      ? &quick
                      : strcmp(argv[i], "--sampling") == 0 ? &study
                      : strcmp(argv[i], "--slopes") == 0   ? &slopes
                      : strcmp(argv[i], "--sea") == 0      ? &sea
                                                           : NULL;
        if (!named) {
            fprintf(stderr,
                    "usage: water [--quick] [--sampling] [--slopes] [--sea]\n");
            return 2;
        }
        *named = true;
    }
    int64_t start = pel_now_ns();
    mkdir("build", 0777);
    mkdir("build/validate", 0777);
    mkdir("build/validate/quick", 0777);
    const bool part = study || slopes || sea;
    const char *how = part ? "a" : "w";
    FILE *md = open_report(quick, true, "water.md", how);
    FILE *json = open_report(quick, !part, "water.json", "w");
    FILE *sampling = open_report(quick, !slopes && !sea, "sampling.json", "w");
    if (!md || !json || !sampling) {
        perror("build/validate");
        return 1;
    }
    int broken = part ? 0 : validate(quick, md, json, start);
    if (!slopes && !sea) {
        broken |= put_sampling(md, sampling, quick) > 1e-3;
    }
    if (!study && !sea) {
        double most = put_slopes(md, quick);
        broken |= most < 0.0 || most > (quick ? 0.12 : 0.08);
    }
    if (!study && !slopes) {
        broken |= !check_published(md);
        broken |= !check_columns(md, quick);
        broken |= !check_rays(md, quick);
    }
    if (fclose(md) || fclose(json) || fclose(sampling)) {
        perror("build/validate");
        return 1;
    }
    fprintf(stderr, "\r%.0f s; see build/validate/%swater.md\n",
            1e-9 * (double)(pel_now_ns() - start), quick ? "quick/" : "");
    fprintf(stderr, broken ? "a promise is broken\n" : "all promises hold\n");
    return broken;
}
