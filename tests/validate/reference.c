#include "tests/validate/reference.h"

#include <stdlib.h>

#include "optics/brdf.h"

#define AZIMUTHS 256
#define ELEVATIONS 256
#define LANES 8
/* No slope of the sea reaches this but on crests a few centimetres long. */
#define STEEPEST 0.7
#define NEAR_M 0.03 /* below it the shorter waves are asked too */

typedef float lanes __attribute__((vector_size(LANES * sizeof(float))));
/* Twice as fast where the processor has 8 lanes; the last bits differ. */
#define CLONED __attribute__((target_clones("arch=haswell", "default")))

typedef int32_t ilanes __attribute__((vector_size(LANES * sizeof(float))));

struct reference {
    struct reference_light light;
    struct pel_rgb sky[ELEVATIONS][AZIMUTHS]; /* elevation = π/2 (i/(n−1))² */
    int blocks;
    int coarse;    /* blocks of the longest waves */
    double rest_m; /* the others change heights by no more: 5 sigma */
    double top_m;
    /* Waves in blocks: turns/m, phase in turns, c h k̂, h, h k. */
    lanes kx[32], ky[32], phase[32], sx[32], sy[32], h[32], hx[32], hy[32];
    lanes fxx[32], fxy[32], fyy[32];
};

/* sin 2π x to 1e-7, eight at a time. */
static inline __attribute__((always_inline)) lanes sine(lanes x)
{
    x += 0.25f;
    /* Truncation leaves (−1, 1); negative ones are lifted by one. */
    lanes f =
        x - __builtin_convertvector(__builtin_convertvector(x, ilanes), lanes);
    f -= __builtin_convertvector(f < 0.0f, lanes);
    lanes y = 0.25f - (lanes)((ilanes)(f - 0.5f) & 0x7FFFFFFF);
    lanes z = y * y;
    return y *
           (6.283185160f +
            z * (-41.34165503f +
                 z * (81.60100405f + z * (-76.54978184f + z * 39.53670244f))));
}

static inline __attribute__((always_inline)) float total(lanes v)
{
    float sum = 0.0f;
    for (int i = 0; i < LANES; i++) {
        sum += v[i];
    }
    return sum;
}

CLONED
static void displacement(const struct reference *r, int blocks, double x,
                         double y, double out[3])
{
    lanes dx = { 0 }, dy = { 0 }, dz = { 0 };
    for (int b = 0; b < blocks; b++) {
        lanes turns = r->kx[b] * (float)x + r->ky[b] * (float)y + r->phase[b];
        lanes s = sine(turns), c = sine(turns + 0.25f);
        dx -= r->sx[b] * s;
        dy -= r->sy[b] * s;
        dz += r->h[b] * c;
    }
    out[0] = total(dx);
    out[1] = total(dy);
    out[2] = total(dz);
}

CLONED
static void derivatives(const struct reference *r, double x, double y,
                        double out[5])
{
    lanes a = { 0 }, b = { 0 }, c = { 0 }, sx = { 0 }, sy = { 0 };
    for (int i = 0; i < r->blocks; i++) {
        lanes turns = r->kx[i] * (float)x + r->ky[i] * (float)y + r->phase[i];
        lanes s = sine(turns), co = sine(turns + 0.25f);
        a += r->fxx[i] * co;
        b += r->fxy[i] * co;
        c += r->fyy[i] * co;
        sx += r->hx[i] * s;
        sy += r->hy[i] * s;
    }
    const lanes all[5] = { a, b, c, sx, sy };
    for (int i = 0; i < 5; i++) {
        out[i] = (double)total(all[i]);
    }
}

static struct pel_vec3 normal(const struct reference *r, double x, double y)
{
    double d[5];
    derivatives(r, x, y, d);
    double A = d[0], B = d[1], C = d[2], X = d[3], Y = d[4];
    return pel_vec3_normalize((struct pel_vec3){
        B * Y + X * (1 - C), B * X + Y * (1 - A), (1 - A) * (1 - C) - B * B });
}

/* Where a ray is over the sea, and the place at rest of the water under it. */
struct over {
    double rest[2], shift[2]; /* shift: of the water from there */
};

/* How far (x, y, z) is above the sea. The search begins where the last one
 * ended, so on a ray's way two steps are enough. */
static double above(const struct reference *r, int blocks, double x, double y,
                    double z, struct over *at)
{
    double d[3];
    for (int i = 0; i < 2; i++) {
        at->rest[0] = x - at->shift[0];
        at->rest[1] = y - at->shift[1];
        displacement(r, blocks, at->rest[0], at->rest[1], d);
        at->shift[0] = d[0];
        at->shift[1] = d[1];
    }
    return z - d[2];
}

struct reference *reference_create(const struct pel_sea *sea, double time_s,
                                   double visibility_m,
                                   const struct reference_light *light)
{
    struct reference *r = aligned_alloc(64, (sizeof *r + 63) / 64 * 64);
    struct pel_atmosphere *air = malloc(sizeof *air);
    if (!r || !air) {
        free(r);
        free(air);
        return NULL;
    }
    *r = (struct reference){ .light = *light };
    r->blocks = (sea->count + LANES - 1) / LANES;
    r->top_m = fmin(sea->max_height_m, 6.0 * sqrt(sea->m0)) + 0.01;
    for (int i = 0; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        int b = i / LANES, l = i % LANES;
        double k = hypot(w->kx, w->ky), ux = w->kx / k, uy = w->ky / k;
        double phase = (w->phase - w->omega * time_s) / (2 * PEL_PI);
        r->kx[b][l] = (float)(w->kx / (2 * PEL_PI));
        r->ky[b][l] = (float)(w->ky / (2 * PEL_PI));
        r->phase[b][l] = (float)(phase - floor(phase));
        r->sx[b][l] = (float)(w->chop * w->amplitude * ux);
        r->sy[b][l] = (float)(w->chop * w->amplitude * uy);
        r->h[b][l] = (float)w->amplitude;
        r->hx[b][l] = (float)(w->amplitude * w->kx);
        r->hy[b][l] = (float)(w->amplitude * w->ky);
        double f = w->chop * w->amplitude * k;
        r->fxx[b][l] = (float)(f * ux * ux);
        r->fxy[b][l] = (float)(f * ux * uy);
        r->fyy[b][l] = (float)(f * uy * uy);
    }
    r->coarse = (5 * r->blocks + 7) / 8;
    double rest = 0.0;
    for (int i = r->coarse * LANES; i < sea->count; i++) {
        const struct pel_wave *w = &sea->waves[i];
        rest += 0.5 * w->amplitude * w->amplitude;
    }
    r->rest_m = 5.0 * sqrt(rest) * (1.0 + STEEPEST);
    const struct pel_atmosphere_desc desc = { visibility_m };
    pel_atmosphere_init(&desc, air);
    if (pel_atmosphere_tabulate(air, NULL, NULL)) {
        free(air);
        free(r);
        return NULL;
    }
    double sun_azimuth = atan2(light->sun.y, light->sun.x);
    for (int e = 0; e < ELEVATIONS; e++) {
        double q = e / (ELEVATIONS - 1.0), el = 0.5 * PEL_PI * q * q;
        for (int a = 0; a < AZIMUTHS; a++) {
            double az = sun_azimuth + PEL_PI * a / (AZIMUTHS - 1.0);
            r->sky[e][a] = pel_atmosphere_sky(
                air, 2.0,
                (struct pel_vec3){ cos(el) * cos(az), cos(el) * sin(az),
                                   sin(el) },
                light->sun);
        }
    }
    pel_atmosphere_finish(air);
    free(air);
    return r;
}

void reference_destroy(struct reference *r)
{
    free(r);
}

static struct pel_rgb mix(struct pel_rgb a, struct pel_rgb b, double f)
{
    return (struct pel_rgb){ a.r + (b.r - a.r) * f, a.g + (b.g - a.g) * f,
                             a.b + (b.b - a.b) * f };
}

/* Light of the water where the line of sight is not known: 37° aside. */
static struct pel_rgb sea_in_the_mean(const struct reference_light *l)
{
    struct pel_rgb a = pel_water_table_fetch(l->water->sun, 0.6, 0.0);
    struct pel_rgb b = pel_water_table_fetch(l->water->sky, 0.6, 0.0);
    struct pel_rgb e = l->sun_irradiance, s = l->sky_irradiance;
    return (struct pel_rgb){ e.r * a.r + s.r * b.r, e.g * a.g + s.g * b.g,
                             e.b * a.b + s.b * b.b };
}

struct pel_rgb reference_environment(const struct reference *r,
                                     struct pel_vec3 dir)
{
    const struct pel_vec3 sun = r->light.sun;
    double across = hypot(dir.x, dir.y) * hypot(sun.x, sun.y);
    double c = across > 0 ? (dir.x * sun.x + dir.y * sun.y) / across : 1.0;
    double a = acos(pel_clamp(c, -1, 1)) / PEL_PI * (AZIMUTHS - 1.0);
    double el = asin(pel_clamp(fabs(dir.z), 0, 1));
    double e = sqrt(el / (0.5 * PEL_PI)) * (ELEVATIONS - 1.0);
    int a0 = (int)fmin(a, AZIMUTHS - 2), e0 = (int)fmin(e, ELEVATIONS - 2);
    struct pel_rgb sky =
        mix(mix(r->sky[e0][a0], r->sky[e0][a0 + 1], a - a0),
            mix(r->sky[e0 + 1][a0], r->sky[e0 + 1][a0 + 1], a - a0), e - e0);
    if (dir.z >= 0) {
        return sky;
    }
    double s = r->light.slope_sigma;
    const struct pel_vec3 view = { sqrt(1 - dir.z * dir.z), 0, -dir.z };
    return mix(sea_in_the_mean(&r->light), sky,
               pel_ross_mean_fresnel(view, s * s, s * s));
}

/* Fresnel's equations without polarisation, by angles and not by the program:
 * n of sea water at 550 nm. */
static double reflectance(double cosine)
{
    double in = acos(pel_clamp(cosine, 0.0, 1.0));
    double inside = asin(sin(in) / 1.3413);
    if (in < 1e-4) {
        return pow((1.3413 - 1.0) / (1.3413 + 1.0), 2.0);
    }
    double s = sin(in - inside) / sin(in + inside);
    double p = tan(in - inside) / tan(in + inside);
    return 0.5 * (s * s + p * p);
}

static void reflect(const struct reference *r, struct pel_vec3 n,
                    struct pel_vec3 v, struct reference_sample *out)
{
    double vn = fmax(pel_vec3_dot(n, v), 0.0);
    struct pel_vec3 m =
        pel_vec3_add(pel_vec3_scale(n, 2 * vn), pel_vec3_scale(v, -1));
    double f = reflectance(vn);
    struct pel_rgb l = reference_environment(r, m);
    out->sky = (struct pel_rgb){ f * l.r, f * l.g, f * l.b };
    struct pel_rgb w = pel_water_table_leaving(
        r->light.water, v, n, r->light.sun, r->light.sun_irradiance,
        r->light.sky_irradiance);
    out->water =
        (struct pel_rgb){ (1 - f) * w.r, (1 - f) * w.g, (1 - f) * w.b };
    /* The widened Sun: a Gaussian over the slopes that would mirror it, times
     * d²ζ = d²ω / (4 n_z³ v·n) there, so that its irradiance stays; but for the
     * slowly varying h_z it is what eq. 15 gives for slopes and blur together.
     */
    struct pel_vec3 h = pel_vec3_normalize(pel_vec3_add(v, r->light.sun));
    double vh = fmax(pel_vec3_dot(v, h), 1e-6),
           b2 = r->light.blur * r->light.blur;
    double dx = n.x / n.z - h.x / h.z, dy = n.y / n.z - h.y / h.z;
    double kernel = exp(-0.5 * (dx * dx + dy * dy) / b2) / (2 * PEL_PI * b2);
    double g = kernel * reflectance(vh) /
               (4 * h.z * h.z * h.z * h.z * fmax(vn / n.z, 1e-3));
    struct pel_rgb e = r->light.sun_irradiance;
    out->sun = (struct pel_rgb){ g * e.r, g * e.g, g * e.b };
}

bool reference_trace(const struct reference *r, struct pel_vec3 eye,
                     struct pel_vec3 dir, struct reference_sample *out)
{
    if (dir.z >= -1e-4) {
        return false;
    }
    double t = fmax((r->top_m - eye.z) / dir.z, 0.0);
    double end = (-r->top_m - eye.z) / dir.z;
    double grazing = -dir.z / hypot(dir.x, dir.y);
    struct over at = { 0 };
    double low = t, high_above = -1.0, low_above = 0.0;
    while (t < end) {
        double x = eye.x + t * dir.x, y = eye.y + t * dir.y;
        double z = eye.z + t * dir.z;
        double h = above(r, r->coarse, x, y, z, &at) - r->rest_m;
        if (h < NEAR_M) {
            h = above(r, r->blocks, x, y, z, &at);
        }
        if (h < 0) {
            high_above = h;
            break;
        }
        low = t;
        low_above = h;
        t += fmax(h / (STEEPEST + grazing), 0.01);
    }
    if (t >= end) {
        return false;
    }
    /* Regula falsi, the stale side halved (Illinois). */
    double high = t;
    for (int i = 0, side = 0; i < 12 && high - low > 1e-4; i++) {
        double f = low_above / (low_above - high_above);
        double middle = low + f * (high - low);
        double h = above(r, r->blocks, eye.x + middle * dir.x,
                         eye.y + middle * dir.y, eye.z + middle * dir.z, &at);
        if (fabs(h) < 1e-5) {
            break;
        }
        if (h < 0) {
            high = middle;
            high_above = h;
            low_above *= side < 0 ? 0.5 : 1.0;
            side = -1;
        } else {
            low = middle;
            low_above = h;
            high_above *= side > 0 ? 0.5 : 1.0;
            side = 1;
        }
    }
    reflect(r, normal(r, at.rest[0], at.rest[1]), pel_vec3_scale(dir, -1), out);
    return true;
}
