#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "optics/linear.h"
#include "optics/ordinatesparts.h"

#define BEAMS PEL_ORDINATES_BEAMS
#define VIEWS PEL_ORDINATES_VIEWS

/* One mode's work. */
struct inside {
    int beams, views;
    const double *mu, *view_mu;
    double rate[BEAMS], sum[BEAMS][N_MAX], difference[BEAMS][N_MAX];
    double total_s[BEAMS][N_MAX], total_d[BEAMS][N_MAX];
    double right[BEAMS][2 * N_MAX];
    /* Sources towards a view, of the eigenmodes and of the beams, of terms that
     * are alike up and down and of those that change their sign. */
    double view_s[VIEWS][N_MAX], view_d[VIEWS][N_MAX];
    double beam_s[BEAMS][VIEWS], beam_d[BEAMS][VIEWS];
    double once_s[BEAMS][VIEWS], once_d[BEAMS][VIEWS];
};

static void find_beams(struct pel_ordinates *o, struct pel_ordinates_problem *p,
                       struct inside *w)
{
    int n = o->n;
    for (int b = 0; b < w->beams; b++) {
        p->sun_mu = w->mu[b];
        p->rate = 1.0 / w->mu[b];
        pel_ordinates_leave_resonance(o, p);
        pel_ordinates_beam_modes(o, p);
        w->rate[b] = p->rate;
        memcpy(w->sum[b], o->beam_sum, (size_t)n * sizeof(double));
        memcpy(w->difference[b], o->beam_difference,
               (size_t)n * sizeof(double));
        for (int i = 0; i < n; i++) {
            double s = 0.0, d = 0.0;
            for (int j = 0; j < n; j++) {
                s += o->sum[i * n + j] * o->beam_sum[j];
                d += o->difference[i * n + j] * o->beam_difference[j];
            }
            w->total_s[b][i] = 0.5 * s;
            w->total_d[b][i] = 0.5 * d;
        }
    }
}

static void find_views(const struct pel_ordinates *o,
                       const struct pel_ordinates_problem *p, struct inside *w)
{
    int n = o->n;
    double strength = p->omega / (4.0 * PEL_PI) * (p->mode ? 2.0 : 1.0);
    for (int v = 0; v < w->views; v++) {
        double at_view[N_MAX];
        pel_ordinates_legendre(p->mode, o->terms, w->view_mu[v], at_view, 1);
        memset(w->view_s[v], 0, sizeof w->view_s[v]);
        memset(w->view_d[v], 0, sizeof w->view_d[v]);
        for (int i = 0; i < n; i++) {
            double sum[2] = { 0.0, 0.0 };
            for (int l = p->mode; l < o->terms; l++) {
                sum[(l + p->mode) & 1] +=
                    o->moment[l] * at_view[l] * o->legendre[l][i];
            }
            double half = 0.5 * p->omega * o->weight[i];
            for (int j = 0; j < n; j++) {
                w->view_s[v][j] += half * sum[0] * o->sum[i * n + j];
                w->view_d[v][j] += half * sum[1] * o->difference[i * n + j];
            }
        }
        for (int b = 0; b < w->beams; b++) {
            double at_beam[N_MAX], once[2] = { 0.0, 0.0 };
            pel_ordinates_legendre(p->mode, o->terms, w->mu[b], at_beam, 1);
            for (int l = p->mode; l < o->terms; l++) {
                once[(l + p->mode) & 1] +=
                    o->moment[l] * at_view[l] * at_beam[l];
            }
            w->once_s[b][v] = strength * once[0];
            w->once_d[b][v] = strength * once[1];
            w->beam_s[b][v] = w->beam_d[b][v] = 0.0;
            for (int j = 0; j < n; j++) {
                w->beam_s[b][v] += w->view_s[v][j] * w->sum[b][j];
                w->beam_d[b][v] += w->view_d[v][j] * w->difference[b][j];
            }
        }
    }
}

/* ∫ of a source e^(−k t) along a line that comes to depth t from the surface,
 * and one that comes from the bottom, τ deep. */
static double from_surface(double k, double mu, double t)
{
    return pel_ordinates_from_below(k, mu, t);
}

static double from_bottom(double k, double mu, double t, double tau)
{
    return exp(-k * t) * -expm1(-(tau - t) * (k + 1.0 / mu)) / (1.0 + k * mu);
}

/* All beams to a view, at a depth; many, once: [beams][2][views]. */
static void see(const struct pel_ordinates *o,
                const struct pel_ordinates_problem *p, const struct inside *w,
                double t, int v, double *many, double *once)
{
    double up[2][N_MAX], down[2][N_MAX]; /* looking; of a_j and b_j */
    double mu = w->view_mu[v];
    for (int j = 0; j < o->n; j++) {
        double k = o->k[j], s = w->view_s[v][j], d = k * w->view_d[v][j];
        up[0][j] = (s + d) * from_surface(k, mu, t);
        up[1][j] = (s - d) * from_bottom(k, mu, p->tau - t, p->tau);
        down[0][j] = (s - d) * from_bottom(k, mu, t, p->tau);
        down[1][j] = (s + d) * from_surface(k, mu, p->tau - t);
    }
    for (int b = 0; b < w->beams; b++) {
        const double *a_ = w->right[b], *b_ = w->right[b] + o->n;
        double sky = from_surface(w->rate[b], mu, t);
        double bed = from_bottom(w->rate[b], mu, t, p->tau);
        double above = (w->beam_s[b][v] - w->beam_d[b][v]) * sky;
        double below = (w->beam_s[b][v] + w->beam_d[b][v]) * bed;
        for (int j = 0; j < o->n; j++) {
            above += a_[j] * up[0][j] + b_[j] * up[1][j];
            below += a_[j] * down[0][j] + b_[j] * down[1][j];
        }
        many[(2 * b) * w->views + v] = above;
        many[(2 * b + 1) * w->views + v] = below;
        once[(2 * b) * w->views + v] =
            (w->once_s[b][v] + w->once_d[b][v]) * sky;
        once[(2 * b + 1) * w->views + v] =
            (w->once_s[b][v] - w->once_d[b][v]) * bed;
    }
}

static void find_flux(const struct pel_ordinates *o,
                      const struct pel_ordinates_problem *p,
                      const struct inside *w, double t, int b, double flux[2])
{
    const double *a_ = w->right[b], *b_ = w->right[b] + o->n;
    double e = exp(-w->rate[b] * t);
    flux[0] = flux[1] = 0.0;
    for (int i = 0; i < o->n; i++) {
        double s = w->total_s[b][i] * e, d = w->total_d[b][i] * e;
        double ring = 2.0 * PEL_PI * o->weight[i] * o->mu[i];
        for (int j = 0; j < o->n; j++) {
            double k = o->k[j], above = a_[j] * exp(-k * t);
            double below = b_[j] * exp(-k * (p->tau - t));
            s += 0.5 * o->sum[i * o->n + j] * (above + below);
            d += 0.5 * o->difference[i * o->n + j] * k * (below - above);
        }
        flux[0] += ring * (s - d);
        flux[1] += ring * (s + d);
    }
}

enum pel_err pel_ordinates_inside(struct pel_ordinates *o,
                                  const struct pel_medium *medium,
                                  const double *mu, int beams,
                                  const double *depths, int levels,
                                  const double *view_mu, int views, int modes,
                                  double *many, double *once, double *flux)
{
    struct inside *w = calloc(1, sizeof *w);
    if (!w) {
        return PEL_ERR_NO_MEMORY;
    }
    struct pel_ordinates_problem p = { .beam = 1.0 };
    pel_ordinates_scale(o, medium, &p);
    double c = p.tau / medium->depth_m;
    const int block = 2 * beams * views;
    w->beams = beams;
    w->views = views;
    w->mu = mu;
    w->view_mu = view_mu;
    memset(many, 0, sizeof *many * (size_t)(levels * modes * block));
    memset(once, 0, sizeof *once * (size_t)(levels * modes * block));
    for (p.mode = 0; p.mode < modes && p.mode < o->terms; p.mode++) {
        pel_ordinates_eigenmodes(o, &p);
        find_beams(o, &p, w);
        find_views(o, &p, w);
        pel_ordinates_boundary(o, &p, p.albedo);
        pel_lu_factor(o->matrix, 2 * o->n, o->pivot);
        for (int b = 0; b < beams; b++) {
            pel_ordinates_beam_right(o, &p, p.albedo, mu[b], w->rate[b],
                                     w->total_s[b], w->total_d[b], w->right[b]);
            pel_lu_apply(o->matrix, 2 * o->n, o->pivot, w->right[b]);
        }
        for (int i = 0; i < levels; i++) {
            double t = fmin(c * depths[i], p.tau);
            const int at = (i * modes + p.mode) * block;
            for (int v = 0; v < views; v++) {
                see(o, &p, w, t, v, many + at, once + at);
            }
            for (int b = 0; b < beams && p.mode == 0; b++) {
                find_flux(o, &p, w, t, b, flux + 2 * (i * beams + b));
            }
        }
    }
    free(w);
    return PEL_OK;
}
