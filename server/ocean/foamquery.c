#include <math.h>

#include "ocean/areas.h"
#include "ocean/atrest.h"
#include "ocean/foam.h"
#include "ocean/shore.h"
#include "ocean/wander.h"
#include "ocean/wash.h"

struct asked {
    const struct pel_sea *sea;
    const struct pel_wash *wash;
    struct pel_moment *breaking, *waves; /* of cascades; waves: by a shore */
    double time_s;
};

/* What breaks where the water rests at a place. */
struct breaking {
    struct pel_vec2 z; /* X, Y */
    double surf;       /* how much on the bottom, 0..1 */
    double high_m;     /* of the waves that feel the bottom */
};

/* Where the bands of a shore are read for a place; far from it: there. */
struct ashore {
    int bands; /* 0: far */
    struct pel_shored here[PEL_SHORE_BANDS];
    struct pel_vec2 read[PEL_SHORE_BANDS];
};

static void ashore_at(const struct pel_shore *shore, struct pel_vec2 x,
                      struct ashore *out)
{
    bool near = shore && !pel_shore_far(shore, x.x, x.y);
    *out = (struct ashore){ .bands = near ? shore->bands : 0 };
    for (int b = 0; b < out->bands; b++) {
        pel_shore_at(shore, b, x.x, x.y, &out->here[b]);
        out->read[b] =
            (struct pel_vec2){ x.x + out->here[b].s * shore->band[b].x,
                               x.y + out->here[b].s * shore->band[b].y };
    }
}

static void add_trochoids(const struct asked *q, struct pel_vec2 x,
                          const struct ashore *shore, struct breaking *to)
{
    for (int i = 0; i < q->sea->count; i++) {
        const struct pel_wave *w = &q->sea->waves[i];
        int band = shore->bands > 0 ? q->sea->shore->of_wave[i] : 0;
        bool feels = band < shore->bands;
        struct pel_vec2 at = feels ? shore->read[band] : x;
        double phase = pel_wave_at(w, at.x, at.y, q->time_s).phase;
        double kh = hypot(w->kx, w->ky) * w->amplitude;
        if (pel_foam_breaks(w)) {
            to->z.x += kh * cos(phase);
            to->z.y += kh * sin(phase);
        }
        if (feels) {
            to->high_m += shore->here[band].a * w->amplitude * cos(phase);
        }
    }
}

static void add_cascades(const struct asked *q, struct pel_vec2 x,
                         const struct ashore *shore, struct breaking *to)
{
    const struct pel_cascades *c = q->sea->cascades;
    for (int i = 0; i < PEL_FOAM_CASCADES; i++) {
        struct pel_vec2 at = i < shore->bands ? shore->read[i] : x;
        struct pel_vec2 z = pel_breaking_at(c, q->breaking, at.x, at.y, i);
        to->z.x += z.x;
        to->z.y += z.y;
    }
    for (int b = 0; b < shore->bands && to->surf > 0; b++) {
        struct pel_at_rest r = { 0 };
        pel_moment_at_rest(c, q->waves, shore->read[b].x, shore->read[b].y, b,
                           b + 1, &r);
        to->high_m += shore->here[b].a * r.d[2];
    }
}

static double smoothstep(double from, double to, double x)
{
    double t = pel_clamp((x - from) / (to - from), 0, 1);
    return t * t * (3.0 - 2.0 * t);
}

/* surf_bound of lib/foam.glsl. */
static double surf_bound(const struct breaking *b)
{
    double crest = -0.9 + 2.7 * smoothstep(-0.2, 0.6, b->high_m);
    return -5.0 + (crest + 5.0) * smoothstep(0.0, 0.35, b->surf);
}

/* foam_of, with every wave resolved. */
static double whitecaps_at(const struct asked *q, struct pel_vec2 x, double up)
{
    const struct pel_foam *foam = q->sea->foam;
    struct ashore shore;
    ashore_at(q->sea->shore, x, &shore);
    struct breaking b = { .surf = shore.bands ? shore.here[0].breaks : 0 };
    (q->sea->cascades ? add_cascades : add_trochoids)(q, x, &shore, &b);
    double bound =
        pel_foam_bound(foam, b.z.x / foam->deviation, b.z.y / foam->deviation,
                       PEL_FOAM_ALWAYS_LEFT);
    bound += PEL_AREA_FOAM * log(fmax(up, 0.05)) /
             (1.5976 + 0.211695 * bound * bound);
    return pel_foam_share(q->sea->shore ? fmax(bound, surf_bound(&b)) : bound);
}

static double foam_at(const struct asked *q, struct pel_vec2 x)
{
    struct pel_washed washed = { .up = 1 };
    struct pel_vec2 slope;
    if (q->wash) {
        washed = pel_wash_at(q->wash, x.x, x.y, 0);
    }
    double up = pel_areas_factor(&q->sea->desc, x.x, x.y, q->time_s, &slope);
    up = fmin(up * washed.up, PEL_AREA_MOST);
    double a = q->sea->foam ? whitecaps_at(q, x, up) : 0;
    double b = washed.foam < 1e-3 ? 0 : washed.foam;
    return a + b - a * b;
}

void pel_foam_query(const struct pel_sea *sea, const struct pel_wash *wash,
                    size_t n, double time_s, struct pel_surface_sample *samples)
{
    struct asked q = { .sea = sea, .wash = wash, .time_s = time_s };
    const struct pel_cascades *c = sea->foam && n > 0 ? sea->cascades : NULL;
    if (c) {
        q.breaking = pel_breaking_take(c, time_s);
        q.waves = sea->shore ? pel_moment_take(c, time_s, false) : NULL;
    }
    for (size_t i = 0; i < n; i++) {
        samples[i].foam = foam_at(&q, samples[i].rest_m);
    }
    if (c) {
        pel_moment_give(c, q.breaking);
    }
    if (q.waves) {
        pel_moment_give(c, q.waves);
    }
}
