#include "ocean/directional.h"

#include <complex.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/areas.h"
#include "ocean/ringwaves.h"
#include "ocean/spectrum.h"

#define NODES PEL_DIRECTIONAL_NODES
#define CUT PEL_DIRECTIONAL_CUT
#define OMEGA2_LEVEL (8.1e-3 * PEL_GRAVITY * PEL_GRAVITY)
#define SWELL_BANDWIDTH 0.06 /* in ω, as the trochoids' */

double pel_dispersion_depth(double k, double depth_m)
{
    double omega = pel_dispersion_omega(k);
    return depth_m > 0 ? omega * sqrt(tanh(k * depth_m)) : omega;
}

/* Newton's steps on ln ω(ln k), whose slope is between ¼ and 3/2. */
double pel_dispersion_k(double omega, double depth_m)
{
    if (!(omega > 0)) {
        return 0;
    }
    double u = log(omega * omega / PEL_GRAVITY);
    if (depth_m > 0) {
        double shallow = log(omega / sqrt(PEL_GRAVITY * depth_m));
        u = fmax(u, shallow);
    }
    for (int i = 0; i < 60; i++) {
        const double h = 1e-5;
        double at = log(pel_dispersion_depth(exp(u), depth_m) / omega);
        double up = log(pel_dispersion_depth(exp(u + h), depth_m) / omega);
        double step = at * h / (up - at);
        u -= step;
        if (fabs(step) < 1e-13) {
            break;
        }
    }
    return exp(u);
}

/* --- ranges --------------------------------------------------------------- */

static bool inside(double v, double lo, double hi)
{
    return v >= lo && v <= hi; /* false for NaN */
}

static bool measured_ok(const struct pel_measured *m)
{
    bool ok = m->count >= 3 && m->count <= PEL_MEASURED_MOST;
    for (int i = 0; ok && i < m->count; i++) {
        ok = inside(m->frequency_hz[i], 0.005, 2) &&
             (i == 0 || m->frequency_hz[i] > m->frequency_hz[i - 1]) &&
             inside(m->density[i], 0, 1e4) && inside(m->r1[i], 0, 1) &&
             inside(m->r2[i], 0, 1) && isfinite(m->alpha1_rad[i]) &&
             isfinite(m->alpha2_rad[i]);
    }
    return ok;
}

bool pel_sea_desc_ok(const struct pel_sea_desc *d)
{
    bool ok = (int)d->synthesiser >= 0 && d->synthesiser < PEL_SYNTHESISERS &&
              (int)d->kind >= 0 && (int)d->kind < PEL_SPECTRA &&
              inside(d->wind_mps, 0, 30) && inside(d->whitecaps, 0, 4) &&
              inside(d->rain_mm_h, 0, PEL_RAIN_MOST_MM_H) &&
              isfinite(d->direction_rad) && d->wave_count >= 20 &&
              d->wave_count <= PEL_SEA_MAX_WAVES && d->swell_count >= 0 &&
              d->swell_count <= PEL_SEA_MAX_SWELLS &&
              (d->depth_m == 0 || inside(d->depth_m, 1, 11000));
#define PEL_SPECTRUM_NUMBER(ID, member, field, path, least, most)              \
    ok = ok && (!pel_spectrum_uses(d->kind, PEL_USES_##ID) ||                  \
                inside(d->member, least, most));
#include "ocean/spectra.def"
    if (ok && pel_spectrum_uses(d->kind, PEL_USES_RECORD)) {
        ok = measured_ok(&d->measured);
    }
    for (int i = 0; ok && i < d->swell_count; i++) {
        const struct pel_swell_desc *s = &d->swell[i];
        ok = inside(s->height_m, 0, 15) && inside(s->period_s, 3, 30) &&
             isfinite(s->direction_rad) && inside(s->spread_rad, 1e-6, PEL_PI);
    }
    ok = ok && d->single_count >= 0 && d->single_count <= PEL_SEA_MAX_SINGLES;
    for (int i = 0; ok && i < d->single_count; i++) {
        const struct pel_single_desc *w = &d->single[i];
        ok = inside(w->height_m, 0, 15) && inside(w->period_s, 1, 30) &&
             isfinite(w->direction_rad) && isfinite(w->phase_rad);
    }
    return ok && pel_areas_ok(d);
}

/* --- parts ---------------------------------------------------------------- */

static double node_k(const struct pel_directional *d, int i)
{
    return exp(d->log_k0 + d->step * i);
}

/* Gravity waves only: how spectra over frequency are turned. */
static double gravity_omega(double k, double depth_m)
{
    double t = depth_m > 0 ? tanh(k * depth_m) : 1.0;
    return sqrt(PEL_GRAVITY * k * t);
}

/* d ω / d ln k of the same. */
static double omega_for_log_k(double k, double depth_m)
{
    double omega = gravity_omega(k, depth_m);
    double x = 2.0 * k * depth_m;
    double group = depth_m > 0 && x < 500 ? 1.0 + x / sinh(x) : 1.0;
    return 0.5 * omega * group;
}

static struct pel_directional_part *new_part(struct pel_directional *d,
                                             enum pel_spreading spreading,
                                             double direction_rad)
{
    struct pel_directional_part *p = &d->part[d->count++];
    p->spreading = spreading;
    p->last = CUT;
    p->direction_rad = direction_rad;
    return p;
}

static double integral(const struct pel_directional *d,
                       const struct pel_directional_part *p)
{
    double sum = 0;
    for (int i = 0; i < p->last; i++) {
        sum += 0.5 * d->step * (p->energy[i] + p->energy[i + 1]);
    }
    return sum;
}

/* Makes the table's integral exactly m0. */
static void normalise(const struct pel_directional *d,
                      struct pel_directional_part *p, double m0)
{
    double sum = integral(d, p);
    for (int i = 0; i < NODES && sum > 0; i++) {
        p->energy[i] *= m0 / sum;
    }
}

static double log_cosine_norm(double s)
{
    int sign; /* lgamma() would write it where other threads read */
    return lgamma_r(s + 1.0, &sign) - lgamma_r(s + 0.5, &sign) -
           log(2.0 * sqrt(PEL_PI));
}

/* Kitaigorodskii's factor, Bouws et al. 1985. */
static double shallow_factor(double k, double depth_m)
{
    double kd = k * depth_m, t = tanh(kd);
    return t * t / (kd < 250 ? 1.0 + 2.0 * kd / sinh(2.0 * kd) : 1.0);
}

/* S(ω) [m² s/rad] of the gravity wave (k, ω). */
typedef double frequency_density(const struct pel_sea_desc *desc, double k,
                                 double omega);

static void fill_frequencies(struct pel_directional *d,
                             const struct pel_sea_desc *desc,
                             frequency_density *density,
                             struct pel_directional_part *p)
{
    for (int i = 0; i <= CUT; i++) {
        double k = node_k(d, i);
        double omega = gravity_omega(k, desc->depth_m);
        p->energy[i] =
            density(desc, k, omega) * omega_for_log_k(k, desc->depth_m);
    }
}

/* A wind sea over frequency, spread as Hasselmann 1980. */
static struct pel_directional_part *
add_hasselmann(struct pel_directional *d, const struct pel_sea_desc *desc,
               frequency_density *density)
{
    struct pel_directional_part *p =
        new_part(d, PEL_SPREADING_COSINE, d->wind_to_rad);
    fill_frequencies(d, desc, density, p);
    for (int i = 0; i <= CUT; i++) {
        double omega = gravity_omega(node_k(d, i), desc->depth_m);
        double s =
            fmax(pel_spectrum_spreading(desc, omega), PEL_SEA_SPREADING_FLOOR);
        p->shape[i] = s;
        p->log_norm[i] = log_cosine_norm(s);
    }
    return p;
}

static double top_omega(const struct pel_directional *d)
{
    return gravity_omega(node_k(d, CUT), d->depth_m);
}

static double wind_density(const struct pel_sea_desc *desc, double k,
                           double omega)
{
    (void)k;
    return pel_spectrum_wind(desc, omega);
}

static enum pel_err add_wind_sea(struct pel_directional *d,
                                 const struct pel_sea_desc *desc)
{
    struct pel_directional_part *p = add_hasselmann(d, desc, wind_density);
    normalise(d, p, pel_spectrum_m0(desc, 0, top_omega(d)));
    return PEL_OK;
}

static double tma_density(const struct pel_sea_desc *desc, double k,
                          double omega)
{
    double factor = desc->depth_m > 0 ? shallow_factor(k, desc->depth_m) : 1.0;
    return pel_spectrum_wind(desc, omega) * factor;
}

static enum pel_err add_tma(struct pel_directional *d,
                            const struct pel_sea_desc *desc)
{
    add_hasselmann(d, desc, tma_density);
    return PEL_OK;
}

static double omega2_density(const struct pel_sea_desc *desc, double k,
                             double omega)
{
    (void)k;
    return omega < pel_spectrum_peak(desc) ? 0.0
                                           : OMEGA2_LEVEL / pow(omega, 5.0);
}

static enum pel_err add_omega2(struct pel_directional *d,
                               const struct pel_sea_desc *desc)
{
    struct pel_directional_part *p = add_hasselmann(d, desc, omega2_density);
    double peak = pel_spectrum_peak(desc), top = top_omega(d);
    normalise(d, p, 0.25 * OMEGA2_LEVEL * (pow(peak, -4.0) - pow(top, -4.0)));
    return PEL_OK;
}

static double bretschneider_density(const struct pel_sea_desc *desc, double k,
                                    double omega)
{
    (void)k;
    double b = 1.25 * pow(2.0 * PEL_PI / desc->period_s, 4.0);
    double a = 0.25 * b * desc->height_m * desc->height_m;
    return a / pow(omega, 5.0) * exp(-b / pow(omega, 4.0));
}

static enum pel_err add_bretschneider(struct pel_directional *d,
                                      const struct pel_sea_desc *desc)
{
    struct pel_directional_part *p =
        new_part(d, PEL_SPREADING_ELLIPSE, d->wind_to_rad);
    fill_frequencies(d, desc, bretschneider_density, p);
    for (int i = 0; i <= CUT; i++) {
        p->shape[i] = 1; /* 2/π cos² */
    }
    double ratio = 2.0 * PEL_PI / (desc->period_s * top_omega(d));
    normalise(d, p,
              desc->height_m * desc->height_m / 16.0 *
                  exp(-1.25 * pow(ratio, 4.0)));
    return PEL_OK;
}

static enum pel_err add_elfouhaily(struct pel_directional *d,
                                   const struct pel_sea_desc *desc)
{
    struct pel_directional_part *p =
        new_part(d, PEL_SPREADING_ELLIPSE, d->wind_to_rad);
    p->last = NODES - 1;
    for (int i = 0; i < NODES; i++) {
        double k = node_k(d, i), s, delta;
        pel_elfouhaily(k, desc->wind_mps, desc->fetch_m, &s, &delta);
        p->energy[i] = k * s * pel_wind_over_viscosity(k, desc->wind_mps);
        p->shape[i] = delta;
    }
    return PEL_OK;
}

static void add_swell(struct pel_directional *d, const struct pel_swell_desc *s)
{
    struct pel_directional_part *p =
        new_part(d, PEL_SPREADING_NORMAL, s->direction_rad);
    double peak = 2.0 * PEL_PI / s->period_s;
    for (int i = 0; i <= CUT; i++) {
        double k = node_k(d, i);
        double t =
            (gravity_omega(k, d->depth_m) / peak - 1.0) / SWELL_BANDWIDTH;
        p->energy[i] = fabs(t) < 5
                           ? exp(-0.5 * t * t) * omega_for_log_k(k, d->depth_m)
                           : 0.0;
        p->shape[i] = s->spread_rad;
    }
    normalise(d, p, s->height_m * s->height_m / 16.0);
}

/* Maximum entropy of the moments c1 = ⟨e^{iθ}⟩, c2 = ⟨e^{2iθ}⟩. */
static struct pel_entropy entropy(double complex c1, double complex c2)
{
    double one = 1.0 - cabs(c1) * cabs(c1);
    double complex p = one > 1e-6 ? (c1 - c2 * conj(c1)) / one : 0;
    double complex q = c2 - c1 * p;
    double top = creal(1.0 - p * conj(c1) - q * conj(c2)) / (2.0 * PEL_PI);
    if (one <= 1e-6 || top <= 1e-6 || cabs(q) >= 0.999) {
        /* Not the moments of any density: keep the first. */
        double complex c = c1 * fmin(1.0, 0.97 / fmax(cabs(c1), 1e-9));
        p = c;
        q = 0;
        top = (1.0 - cabs(c) * cabs(c)) / (2.0 * PEL_PI);
    }
    return (struct pel_entropy){ creal(p), cimag(p), creal(q), cimag(q), top };
}

static double complex first_moment(const struct pel_measured *m, int i)
{
    return m->r1[i] * cexp(I * m->alpha1_rad[i]);
}

static double complex second_moment(const struct pel_measured *m, int i)
{
    return m->r2[i] * cexp(2.0 * I * m->alpha2_rad[i]);
}

/* What lies beyond a buoy's frequencies. A large hull answers ever less to the
 * last of them, often not at all, so they all speak, from BUOY_TAIL of the
 * highest on. */
#define BUOY_TAIL 0.6
struct tail {
    double level; /* S f⁵, m² Hz⁴ */
    double complex c[2];
};

static struct tail tail_of(const struct pel_measured *m)
{
    struct tail t = { 0 };
    double sum = 0;
    int n = 0;
    for (int i = 0; i < m->count; i++) {
        double f = m->frequency_hz[i];
        if (f >= BUOY_TAIL * m->frequency_hz[m->count - 1]) {
            double level = m->density[i] * pow(f, 5.0);
            t.c[0] += level * first_moment(m, i);
            t.c[1] += level * second_moment(m, i);
            sum += level;
            n++;
        }
    }
    t.level = sum / n;
    t.c[0] = sum > 0 ? t.c[0] / sum : 0;
    t.c[1] = sum > 0 ? t.c[1] / sum : 0;
    return t;
}

static enum pel_err add_measured(struct pel_directional *d,
                                 const struct pel_measured *m)
{
    struct pel_directional_part *p = new_part(d, PEL_SPREADING_ENTROPY, 0);
    p->entropy = calloc(NODES, sizeof *p->entropy);
    if (!p->entropy) {
        return PEL_ERR_NO_MEMORY;
    }
    struct tail tail = tail_of(m);
    int last = m->count - 1, at = 0;
    for (int i = 0; i <= CUT; i++) {
        double k = node_k(d, i);
        double f = gravity_omega(k, d->depth_m) / (2.0 * PEL_PI);
        while (at < last - 1 && f > m->frequency_hz[at + 1]) {
            at++;
        }
        double span = m->frequency_hz[at + 1] - m->frequency_hz[at];
        double u = pel_clamp((f - m->frequency_hz[at]) / span, 0, 1);
        double density = (1.0 - u) * m->density[at] + u * m->density[at + 1];
        double complex c1 =
            (1.0 - u) * first_moment(m, at) + u * first_moment(m, at + 1);
        double complex c2 =
            (1.0 - u) * second_moment(m, at) + u * second_moment(m, at + 1);
        if (f < m->frequency_hz[0]) {
            density = 0;
        } else if (f > m->frequency_hz[last]) {
            density = tail.level / pow(f, 5.0);
            c1 = tail.c[0];
            c2 = tail.c[1];
        }
        p->energy[i] =
            density / (2.0 * PEL_PI) * omega_for_log_k(k, d->depth_m);
        p->entropy[i] = entropy(c1, c2);
    }
    return PEL_OK;
}

static enum pel_err add_record(struct pel_directional *d,
                               const struct pel_sea_desc *desc)
{
    return add_measured(d, &desc->measured);
}

/* Rain on the parts there are, and the ring waves as one more. */
static void add_rain(struct pel_directional *d, const struct pel_sea_desc *desc)
{
    for (int p = 0; p < d->count; p++) {
        for (int i = 0; i <= d->part[p].last; i++) {
            d->part[p].energy[i] *=
                pel_rain_leaves(desc->rain_mm_h, node_k(d, i), desc->wind_mps);
        }
    }
    struct pel_directional_part *p = new_part(d, PEL_SPREADING_COSINE, 0);
    p->last = NODES - 1;
    for (int i = 0; i < NODES; i++) {
        const double h = 1e-4;
        double k = node_k(d, i);
        double slope = (pel_dispersion_depth(k * exp(h), d->depth_m) -
                        pel_dispersion_depth(k * exp(-h), d->depth_m)) /
                       (2.0 * h);
        double omega = pel_dispersion_depth(k, d->depth_m);
        p->energy[i] =
            pel_ring_density(desc->rain_mm_h, omega / (2.0 * PEL_PI)) * slope /
            (2.0 * PEL_PI);
        p->log_norm[i] = log_cosine_norm(0); /* cos⁰: to all sides */
    }
}

static enum pel_err (*const wind_sea[PEL_SPECTRA])(
    struct pel_directional *d, const struct pel_sea_desc *desc) = {
#define PEL_SPECTRUM(ID, uses, whole, add) add,
#include "ocean/spectra.def"
};

enum pel_err pel_directional_create(const struct pel_sea_desc *desc,
                                    struct pel_directional **out)
{
    if (!pel_sea_desc_ok(desc)) {
        return PEL_ERR_OUT_OF_RANGE;
    }
    struct pel_directional *d = calloc(1, sizeof *d);
    if (!d) {
        return PEL_ERR_NO_MEMORY;
    }
    d->log_k0 = log(2.0 * PEL_PI / PEL_DIRECTIONAL_LONGEST_M);
    d->step = log(PEL_DIRECTIONAL_LONGEST_M / PEL_SEA_SHORTEST_M) / CUT;
    d->depth_m = desc->depth_m;
    d->wind_to_rad = remainder(desc->direction_rad, 2.0 * PEL_PI);
    enum pel_err err = PEL_OK;
    if (!pel_spectrum_uses(desc->kind, PEL_USES_WIND) ||
        desc->wind_mps > 0.15) {
        err = wind_sea[desc->kind](d, desc);
    }
    if (desc->rain_mm_h > 0) {
        add_rain(d, desc);
    }
    for (int i = 0; i < desc->swell_count; i++) {
        if (desc->swell[i].height_m > 0) {
            add_swell(d, &desc->swell[i]);
        }
    }
    for (int i = 0; i < desc->single_count; i++) {
        const struct pel_single_desc *w = &desc->single[i];
        double k = pel_dispersion_k(2.0 * PEL_PI / w->period_s, d->depth_m);
        d->line[d->line_count++] =
            (struct pel_directional_line){ k * cos(w->direction_rad),
                                           k * sin(w->direction_rad),
                                           w->height_m * w->height_m / 8.0 };
    }
    if (err) {
        pel_directional_destroy(d);
        return err;
    }
    *out = d;
    return PEL_OK;
}

void pel_directional_destroy(struct pel_directional *d)
{
    for (int i = 0; d && i < d->count; i++) {
        free(d->part[i].entropy);
    }
    free(d);
}

/* --- evaluation ------------------------------------------------------------
 */

/* Density of directions of node i + f at the unit vector (x, y). */
static double spread(const struct pel_directional_part *p, int i, double f,
                     double x, double y)
{
    double shape = p->shape[i] + f * (p->shape[i + 1] - p->shape[i]);
    double cx = cos(p->direction_rad), cy = sin(p->direction_rad);
    double along = x * cx + y * cy;
    switch (p->spreading) {
    case PEL_SPREADING_COSINE: {
        double half = fmax(0.5 * (1.0 + along), 1e-300); /* cos²(θ/2) */
        double norm =
            p->log_norm[i] + f * (p->log_norm[i + 1] - p->log_norm[i]);
        return exp(norm + shape * log(half));
    }
    case PEL_SPREADING_ELLIPSE:
        return along > 0 ? (1.0 + shape * (2.0 * along * along - 1.0)) / PEL_PI
                         : 0.0;
    case PEL_SPREADING_NORMAL: {
        double t = atan2(y * cx - x * cy, along) / shape;
        /* Wide ones are cut at the opposite direction. */
        return exp(-0.5 * t * t) /
               (sqrt(2.0 * PEL_PI) * shape * erf(PEL_PI / (shape * sqrt(2.0))));
    }
    case PEL_SPREADING_ENTROPY: {
        const struct pel_entropy *e = &p->entropy[f < 0.5 ? i : i + 1];
        double x2 = x * x - y * y, y2 = 2.0 * x * y;
        double re = 1.0 - e->px * x - e->py * y - e->qx * x2 - e->qy * y2;
        double im = e->px * y - e->py * x + e->qx * y2 - e->qy * x2;
        return e->top / (re * re + im * im);
    }
    }
    return 0;
}

double pel_directional_density(const struct pel_directional *d, double kx,
                               double ky)
{
    double k = sqrt(kx * kx + ky * ky);
    double place = (log(k) - d->log_k0) / d->step;
    if (!(place >= 0 && place < NODES - 1)) {
        return 0;
    }
    int i = (int)place;
    double f = place - i, sum = 0;
    for (int j = 0; j < d->count; j++) {
        const struct pel_directional_part *p = &d->part[j];
        double e = p->energy[i] + f * (p->energy[i + 1] - p->energy[i]);
        if (e > 0 && i < p->last) {
            sum += e * spread(p, i, f, kx / k, ky / k);
        }
    }
    return sum;
}

double pel_directional_at(const struct pel_directional *d, double omega,
                          double theta)
{
    double k = pel_dispersion_k(omega, d->depth_m);
    if (!(k > 0)) {
        return 0;
    }
    const double h = 1e-4;
    double slope = (pel_dispersion_depth(k * exp(h), d->depth_m) -
                    pel_dispersion_depth(k * exp(-h), d->depth_m)) /
                   (2.0 * h);
    return pel_directional_density(d, k * cos(theta), k * sin(theta)) / slope;
}

/* ⟨e^{iθ}⟩ and ⟨e^{2iθ}⟩ of a part at a node. */
static void angular(const struct pel_directional_part *p, int i,
                    double complex c[2])
{
    double s = p->shape[i], one = 0, two = 0;
    switch (p->spreading) {
    case PEL_SPREADING_COSINE:
        one = s / (s + 1.0);
        two = s * (s - 1.0) / ((s + 1.0) * (s + 2.0));
        break;
    case PEL_SPREADING_ELLIPSE:
        one = (2.0 + s * 2.0 / 3.0) / PEL_PI;
        two = 0.5 * s;
        break;
    case PEL_SPREADING_NORMAL:
        one = exp(-0.5 * s * s);
        two = exp(-2.0 * s * s);
        break;
    case PEL_SPREADING_ENTROPY: {
        /* Yule and Walker's equations, backwards. */
        const struct pel_entropy *e = &p->entropy[i];
        double complex a = e->px + I * e->py, b = e->qx + I * e->qy;
        double bb = 1.0 - creal(b * conj(b));
        c[0] = (a + b * conj(a)) / bb;
        c[1] = a * c[0] + b;
        return;
    }
    }
    c[0] = one * cexp(I * p->direction_rad);
    c[1] = two * cexp(2.0 * I * p->direction_rad);
}

/* At node i, of the parts that go on after node `from`. */
static void node_moments(const struct pel_directional *d, int i, int from,
                         struct pel_node_moments *out)
{
    double complex one = 0, two = 0;
    *out = (struct pel_node_moments){ 0 };
    for (int j = 0; j < d->count; j++) {
        double complex c[2];
        double e = d->part[j].energy[i];
        if (e > 0 && from < d->part[j].last) {
            angular(&d->part[j], i, c);
            out->energy += e;
            one += e * c[0];
            two += e * c[1];
        }
    }
    out->c1 = creal(one);
    out->s1 = cimag(one);
    out->c2 = creal(two);
    out->s2 = cimag(two);
}

void pel_directional_node(const struct pel_directional *d, int i,
                          struct pel_node_moments *out)
{
    node_moments(d, i, i - 1, out);
}

static void add_moments(const struct pel_directional *d,
                        const struct pel_node_moments *n, double k,
                        double weight, struct pel_band_moments *out)
{
    double c2 = cos(2.0 * d->wind_to_rad), s2 = sin(2.0 * d->wind_to_rad);
    double even = n->c2 * c2 + n->s2 * s2; /* ⟨cos 2(θ − wind)⟩ */
    double odd = n->s2 * c2 - n->c2 * s2;
    double slope = 0.5 * weight * k * k;
    out->m0 += weight * n->energy;
    out->along += slope * (n->energy + even);
    out->cross += slope * (n->energy - even);
    out->mixed += slope * odd;
    out->east += weight * n->c1;
    out->north += weight * n->s1;
}

/* Trapezia between nodes, with the ends of the band inside them. */
void pel_directional_continuous(const struct pel_directional *d, double k_lo,
                                double k_hi, struct pel_band_moments *out)
{
    *out = (struct pel_band_moments){ 0 };
    double lo = k_lo > 0 ? (log(k_lo) - d->log_k0) / d->step : 0;
    double hi = isfinite(k_hi) ? (log(k_hi) - d->log_k0) / d->step : NODES - 1;
    lo = fmax(lo, 0);
    hi = fmin(hi, NODES - 1);
    for (int i = (int)lo; i < NODES - 1 && i < hi; i++) {
        double a = fmax(lo - i, 0), b = fmin(hi - i, 1);
        if (!(b > a)) {
            continue;
        }
        struct pel_node_moments at[2];
        node_moments(d, i, i, &at[0]);
        node_moments(d, i + 1, i, &at[1]);
        double right = 0.5 * (b * b - a * a), left = b - a - right;
        add_moments(d, &at[0], node_k(d, i), left * d->step, out);
        add_moments(d, &at[1], node_k(d, i + 1), right * d->step, out);
    }
}

void pel_directional_moments(const struct pel_directional *d, double k_lo,
                             double k_hi, struct pel_band_moments *out)
{
    pel_directional_continuous(d, k_lo, k_hi, out);
    for (int i = 0; i < d->line_count; i++) {
        const struct pel_directional_line *l = &d->line[i];
        double k = hypot(l->kx, l->ky), x = l->kx / k, y = l->ky / k;
        const struct pel_node_moments at = { l->energy, l->energy * x,
                                             l->energy * y,
                                             l->energy * (x * x - y * y),
                                             l->energy * 2.0 * x * y };
        if (k >= k_lo && k < k_hi) {
            add_moments(d, &at, k, 1.0, out);
        }
    }
}
