#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "optics/linear.h"
#include "optics/ordinatesparts.h"

#define BEAMS PEL_ORDINATES_BEAMS

/* What the beams and views of a response share in one mode. */
struct response {
    int beams;
    double rate[BEAMS];               /* 1 / μ, off every eigenvalue */
    double sum[BEAMS][N_MAX];         /* beam_sum and beam_difference */
    double difference[BEAMS][N_MAX];  /* of each beam */
    double total_s[BEAMS][N_MAX];     /* at the nodes, halved */
    double total_d[BEAMS][N_MAX];     /* */
    double view_s[BEAMS][N_MAX];      /* eigenmodes' source at a view */
    double view_d[BEAMS][N_MAX];      /* */
    double beam_source[BEAMS][BEAMS]; /* [beam][view], the beams' own */
    double top[BEAMS][N_MAX];         /* [view][eigenmode] */
    double bottom[BEAMS][N_MAX];      /* */
    double right[2 * N_MAX];
};

static void respond_beams(struct pel_ordinates *o,
                          struct pel_ordinates_problem *p, const double *mu,
                          struct response *r)
{
    int n = o->n;
    for (int b = 0; b < r->beams; b++) {
        p->sun_mu = mu[b];
        p->rate = 1.0 / mu[b];
        pel_ordinates_leave_resonance(o, p);
        pel_ordinates_beam_modes(o, p);
        r->rate[b] = p->rate;
        memcpy(r->sum[b], o->beam_sum, (size_t)n * sizeof(double));
        memcpy(r->difference[b], o->beam_difference,
               (size_t)n * sizeof(double));
        for (int i = 0; i < n; i++) {
            double s = 0.0, d = 0.0;
            for (int j = 0; j < n; j++) {
                s += o->sum[i * n + j] * o->beam_sum[j];
                d += o->difference[i * n + j] * o->beam_difference[j];
            }
            r->total_s[b][i] = 0.5 * s;
            r->total_d[b][i] = 0.5 * d;
        }
    }
}

/* Sources of eigenmodes and beams towards each view; uses up `even`, `odd`. */
static void respond_views(struct pel_ordinates *o,
                          const struct pel_ordinates_problem *p,
                          const double *mu, struct response *r)
{
    int n = o->n;
    for (int v = 0; v < r->beams; v++) {
        double at_view[N_MAX], weight_s[N_MAX], weight_d[N_MAX];
        pel_ordinates_legendre(p->mode, o->terms, mu[v], at_view, 1);
        for (int i = 0; i < n; i++) {
            double sum[2] = { 0.0, 0.0 };
            for (int l = p->mode; l < o->terms; l++) {
                sum[(l + p->mode) & 1] +=
                    o->moment[l] * at_view[l] * o->legendre[l][i];
            }
            weight_s[i] = o->weight[i] * sum[0];
            weight_d[i] = o->weight[i] * sum[1];
        }
        memset(r->view_s[v], 0, sizeof r->view_s[v]);
        memset(r->view_d[v], 0, sizeof r->view_d[v]);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                r->view_s[v][j] += weight_s[i] * o->sum[i * n + j];
                r->view_d[v][j] += weight_d[i] * o->difference[i * n + j];
            }
        }
        for (int b = 0; b < r->beams; b++) {
            double source = 0.0;
            for (int j = 0; j < n; j++) {
                source += r->view_s[v][j] * r->sum[b][j] +
                          r->view_d[v][j] * r->difference[b][j];
            }
            r->beam_source[b][v] = source;
        }
    }
}

void pel_ordinates_beam_right(const struct pel_ordinates *o,
                              const struct pel_ordinates_problem *p,
                              double albedo, double mu, double rate,
                              const double *total_s, const double *total_d,
                              double *right)
{
    int n = o->n;
    double e = exp(-rate * p->tau), down = 0.0;
    for (int i = 0; i < n; i++) {
        double s = total_s[i], d = total_d[i];
        double r = o->reflected[i];
        right[i] = -((1.0 - r) * s - (1.0 + r) * d);
        right[n + i] = -e * (s + d);
        down += 2.0 * o->weight[i] * o->mu[i] * e * (s - d);
    }
    if (p->mode == 0) {
        down += mu * exp(-p->tau / mu) / PEL_PI;
        for (int i = 0; i < n; i++) {
            right[n + i] += albedo * down;
        }
    }
}

static void respond_right(const struct pel_ordinates *o,
                          const struct pel_ordinates_problem *p, double albedo,
                          double mu, const struct response *from, int beam,
                          double *right)
{
    pel_ordinates_beam_right(o, p, albedo, mu, from->rate[beam],
                             from->total_s[beam], from->total_d[beam], right);
}

/* What a bottom, equally bright everywhere, sends up. */
static double respond_bottom(const struct pel_ordinates *o,
                             const struct pel_ordinates_problem *p,
                             const struct response *from, int beam,
                             const double *right)
{
    int n = o->n;
    const double *a = right, *b = right + n;
    double e_beam = exp(-from->rate[beam] * p->tau), up = 0.0;
    for (int j = 0; j < n; j++) {
        double k = o->k[j], e = exp(-k * p->tau);
        up +=
            0.5 * o->sum[j] * (a[j] * e + b[j] + from->sum[beam][j] * e_beam) +
            0.5 * o->difference[j] *
                (k * (b[j] - a[j] * e) + from->difference[beam][j] * e_beam);
    }
    return up;
}

/* Every beam to every view at one depth: out[beam][view]. */
static void respond(struct pel_ordinates *o,
                    const struct pel_ordinates_problem *p, double albedo,
                    const double *mu, struct response *r, double *out)
{
    int n = o->n;
    for (int v = 0; v < r->beams; v++) {
        for (int j = 0; j < n; j++) {
            double k = o->k[j];
            double s = r->view_s[v][j], d = k * r->view_d[v][j];
            r->top[v][j] = (s - d) * -expm1(-p->tau * (k + 1.0 / mu[v])) /
                           (1.0 + k * mu[v]);
            r->bottom[v][j] =
                (s + d) * pel_ordinates_from_below(k, mu[v], p->tau);
        }
    }
    pel_ordinates_boundary(o, p, albedo);
    pel_lu_factor(o->matrix, 2 * n, o->pivot);
    for (int b = 0; b < r->beams; b++) {
        respond_right(o, p, albedo, mu[b], r, b, r->right);
        pel_lu_apply(o->matrix, 2 * n, o->pivot, r->right);
        double up = p->mode == 0 && albedo > 0.0
                        ? respond_bottom(o, p, r, b, r->right)
                        : 0.0;
        for (int v = 0; v < r->beams; v++) {
            double total = 0.0, rate = r->rate[b];
            for (int j = 0; j < n; j++) {
                total += r->right[j] * r->top[v][j] +
                         r->right[n + j] * r->bottom[v][j];
            }
            total += r->beam_source[b][v] *
                     -expm1(-p->tau * (rate + 1.0 / mu[v])) /
                     (1.0 + rate * mu[v]);
            out[b * r->beams + v] =
                0.5 * p->omega * total + up * exp(-p->tau / mu[v]);
        }
    }
}

enum pel_err pel_ordinates_respond(struct pel_ordinates *o,
                                   const struct pel_medium *medium,
                                   const double *depths, int levels,
                                   const double *mu, int beams, int modes,
                                   double *dark, double *bottom)
{
    struct response *r = calloc(1, sizeof *r);
    if (!r) {
        return PEL_ERR_NO_MEMORY;
    }
    struct pel_ordinates_problem p = { .beam = 1.0 };
    struct pel_medium unit = *medium;
    unit.depth_m = 1.0;
    pel_ordinates_scale(o, &unit, &p);
    double extinction = p.tau, first = 0.0;
    int block = beams * beams, quiet = 0;
    r->beams = beams;
    memset(dark, 0, (size_t)(levels * modes * block) * sizeof *dark);
    memset(bottom, 0, (size_t)(levels * block) * sizeof *bottom);
    for (p.mode = 0; p.mode < modes && p.mode < o->terms && quiet < 2;
         p.mode++) {
        double most = 0.0;
        pel_ordinates_eigenmodes(o, &p);
        respond_beams(o, &p, mu, r);
        respond_views(o, &p, mu, r);
        for (int i = 0; i < levels; i++) {
            double *to = dark + (i * modes + p.mode) * block;
            p.tau = extinction * depths[i];
            respond(o, &p, 0.0, mu, r, to);
            most = fmax(most, pel_ordinates_largest(to, block));
            if (p.mode == 0 && p.albedo > 0.0) {
                double *lit = bottom + i * block;
                respond(o, &p, p.albedo, mu, r, lit);
                for (int k = 0; k < block; k++) {
                    lit[k] -= to[k];
                }
            }
        }
        first = p.mode == 0 ? most : first;
        quiet = most < o->tolerance * first ? quiet + 1 : 0;
    }
    free(r);
    return PEL_OK;
}

double pel_ordinates_largest(const double *v, int count)
{
    double most = 0.0;
    for (int i = 0; i < count; i++) {
        most = fmax(most, fabs(v[i]));
    }
    return most;
}

/* Σ_i w_i Λ(μ_i) of the eigenmodes and of each beam: what a moment takes of
 * light that goes both ways alike (even l + m) or differently (odd). */
struct moment {
    bool odd;
    double mode[N_MAX], beam[BEAMS], straight[BEAMS];
};

static void make_moment(const struct pel_ordinates *o,
                        const struct pel_ordinates_problem *p, int l,
                        const double *mu, const struct response *r,
                        struct moment *out)
{
    int n = o->n;
    const double *from = (l + p->mode) & 1 ? o->difference : o->sum;
    memset(out, 0, sizeof *out);
    out->odd = (l + p->mode) & 1;
    for (int i = 0; i < n; i++) {
        double w = 2.0 * PEL_PI * o->weight[i] * o->legendre[l][i];
        for (int j = 0; j < n; j++) {
            out->mode[j] += w * from[i * n + j];
        }
    }
    for (int b = 0; b < r->beams; b++) {
        double at[PEL_MOMENTS_TERMS];
        pel_ordinates_legendre(p->mode, PEL_MOMENTS_TERMS, mu[b], at, 1);
        out->straight[b] = (p->mode ? 2.0 : 1.0) * at[l];
        for (int j = 0; j < n; j++) {
            out->beam[b] +=
                out->mode[j] * (out->odd ? -r->difference[b][j] : r->sum[b][j]);
        }
    }
}

/* How far each eigenmode is down at a depth, from above and from below. */
struct decay {
    double above[N_MAX], below[N_MAX];
};

static void make_decay(const struct pel_ordinates *o, double tau, double t,
                       struct decay *out)
{
    for (int j = 0; j < o->n; j++) {
        out->above[j] = exp(-o->k[j] * t);
        out->below[j] = exp(-o->k[j] * (tau - t));
    }
}

/* A beam's moment at scaled depth t; a, b: what decays from above and below. */
static double moment_at(const struct pel_ordinates *o, const struct moment *m,
                        const struct response *r, const struct decay *d,
                        const double *a, double mu, int beam, double t)
{
    const double *b = a + o->n;
    double sum = m->straight[beam] * exp(-t / mu) +
                 m->beam[beam] * exp(-r->rate[beam] * t);
    for (int j = 0; j < o->n; j++) {
        double above = a[j] * d->above[j], below = b[j] * d->below[j];
        sum +=
            m->mode[j] * (m->odd ? o->k[j] * (above - below) : above + below);
    }
    return sum;
}

enum pel_err pel_ordinates_moments(struct pel_ordinates *o,
                                   const struct pel_medium *medium,
                                   const double *mu, int beams,
                                   const double *depths, int count, double *out)
{
    static const struct {
        int mode, l;
    } moments[PEL_MOMENTS] = { { 0, 0 }, { 0, 2 }, { 1, 2 }, { 2, 2 } };
    struct response *r = calloc(1, sizeof *r);
    struct decay *decay = calloc((size_t)count, sizeof *decay);
    if (!r || !decay) {
        free(r);
        free(decay);
        return PEL_ERR_NO_MEMORY;
    }
    struct pel_ordinates_problem p = { .beam = 1.0 };
    pel_ordinates_scale(o, medium, &p);
    double c = p.tau / medium->depth_m;
    r->beams = beams;
    for (p.mode = 0; p.mode < 3; p.mode++) {
        struct moment m[PEL_MOMENTS];
        pel_ordinates_eigenmodes(o, &p);
        respond_beams(o, &p, mu, r);
        for (int i = 0; i < PEL_MOMENTS; i++) {
            if (moments[i].mode == p.mode) {
                make_moment(o, &p, moments[i].l, mu, r, &m[i]);
            }
        }
        pel_ordinates_boundary(o, &p, p.albedo);
        pel_lu_factor(o->matrix, 2 * o->n, o->pivot);
        for (int k = 0; k < count; k++) {
            make_decay(o, p.tau, c * depths[k], &decay[k]);
        }
        for (int b = 0; b < beams; b++) {
            respond_right(o, &p, p.albedo, mu[b], r, b, r->right);
            pel_lu_apply(o->matrix, 2 * o->n, o->pivot, r->right);
            for (int i = 0; i < PEL_MOMENTS * count; i++) {
                int which = i / count, k = i % count;
                if (moments[which].mode == p.mode) {
                    out[i * beams + b] =
                        moment_at(o, &m[which], r, &decay[k], r->right, mu[b],
                                  b, c * depths[k]);
                }
            }
        }
    }
    free(decay);
    free(r);
    return PEL_OK;
}
