#include "spacewaves.h"

#define PI 3.14159265358979323846

enum { NODES = 512, LEVEL_RAYS = 2000 };

/* The Sun as a disc so wide, rad, for what is mirrored twice: noise. */
#define WIDE_SUN 0.08

void space_waves_init(struct space_waves *waves,
                      const struct air_ground *ground, double wind, int orders,
                      uint64_t seed)
{
    static struct sea_spectrum spectrum;
    struct sea_random random;
    sea_random_init(&random, seed);
    sea_spectrum_init(&spectrum, SEA_ELFOUHAILY, wind, 2e6, 0.0028);
    sea_surface_init(&waves->surface, &spectrum, NODES, 0);
    sea_surface_fill(&waves->surface, &random);
    double across = ground->across > 0 ? ground->across : ground->variance;
    waves->ground = ground;
    waves->along = sqrt(waves->surface.along / ground->variance);
    waves->across = sqrt(waves->surface.cross / across);
    waves->orders = orders;
}

void space_waves_finish(struct space_waves *waves)
{
    sea_surface_finish(&waves->surface);
}

/* Axes of the waves as they lie at a place. */
struct frame {
    struct air_vec a, b, up;
};

static struct frame frame_at(const struct air_ground *ground, struct air_vec up)
{
    struct air_vec a = air_along(ground->axis, -air_dot(ground->axis, up), up);
    double length = sqrt(air_dot(a, a));
    if (length < 1e-9) {
        a = air_turned(up, 0, 0);
        length = 1;
    }
    a = (struct air_vec){ a.x / length, a.y / length, a.z / length };
    return (struct frame){ a,
                           { up.y * a.z - up.z * a.y, up.z * a.x - up.x * a.z,
                             up.x * a.y - up.y * a.x },
                           up };
}

/* One ray from the eye until nothing more is met. */
struct followed {
    double weight[AIR_CHANNELS], water[AIR_CHANNELS];
    int met;
    double toward[3];
};

static void unit(double *v)
{
    double length = sqrt(sea_dot(v, v));
    for (int i = 0; i < 3; i++) {
        v[i] /= length;
    }
}

static void meet(struct followed *f, const struct air_ground *ground,
                 double cosine)
{
    for (int c = 0; c < AIR_CHANNELS; c++) {
        double mirrored = sea_fresnel(cosine, ground->index[c]);
        f->water[c] += f->weight[c] * (1 - mirrored);
        f->weight[c] *= mirrored;
    }
    f->met++;
}

/* Directions in the axes of the waves. */
static struct followed follow(const struct space_waves *waves,
                              const double *toward, struct sea_random *random)
{
    const struct sea_surface *surface = &waves->surface;
    struct followed f = { .weight = { 1, 1, 1 },
                          .toward = { toward[0], toward[1], toward[2] } };
    double from[3] = { 2e4 * sea_random_unit(random),
                       2e4 * sea_random_unit(random), surface->finer[0] + 1 };
    for (;;) {
        double d[3] = { f.toward[0] / waves->along, f.toward[1] / waves->across,
                        f.toward[2] };
        struct sea_hit hit;
        unit(d);
        enum sea_end end = sea_trace(surface, from, d, &hit);
        if (end == SEA_ESCAPED) {
            return f;
        }
        if (end == SEA_LOST || f.met == waves->orders) {
            f.weight[0] = f.weight[1] = f.weight[2] = 0;
            return f;
        }
        double n[3] = { hit.normal[0] / waves->along,
                        hit.normal[1] / waves->across, hit.normal[2] };
        double next[3];
        unit(n);
        meet(&f, waves->ground, fmax(-sea_dot(f.toward, n), 0));
        sea_reflect(f.toward, n, next);
        for (int i = 0; i < 3; i++) {
            f.toward[i] = next[i];
            from[i] = hit.point[i];
        }
    }
}

/* Mean over light of one radiance below that comes through a level surface, by
 * what it brings to a level face above. */
static double level_transmittance(double index)
{
    double sum = 0;
    for (int i = 0; i < LEVEL_RAYS; i++) {
        sum += 1 - sea_fresnel(sqrt((i + 0.5) / LEVEL_RAYS), index);
    }
    return sum / LEVEL_RAYS;
}

static struct followed follow_from(const struct space_waves *waves,
                                   const struct frame *f, struct air_vec toward,
                                   struct sea_random *random)
{
    double d[3] = { air_dot(toward, f->a), air_dot(toward, f->b),
                    air_dot(toward, f->up) };
    return follow(waves, d, random);
}

static struct air_vec out_of(const struct frame *f, const double *v)
{
    struct air_vec along = air_along((struct air_vec){ 0 }, v[0], f->a);
    return air_along(air_along(along, v[1], f->b), v[2], f->up);
}

struct air_first space_waves_first(const struct space_waves *waves,
                                   struct air_vec toward, struct air_vec up,
                                   struct air_vec sun, uint64_t seed,
                                   struct air_escape *escapes, int count,
                                   double *error)
{
    struct frame frame = frame_at(waves->ground, up);
    struct air_first first = { .escapes = escapes };
    struct sea_random random;
    double whole = 0, squares = 0;
    sea_random_init(&random, seed);
    for (int i = 0; i < count; i++) {
        struct followed ray = follow_from(waves, &frame, toward, &random);
        struct air_vec to = out_of(&frame, ray.toward);
        bool again = ray.met > 1 && air_dot(to, sun) > cos(WIDE_SUN);
        for (int c = 0; c < AIR_CHANNELS; c++) {
            first.leaves[c] += ray.water[c] / count;
            first.again[c] +=
                again ? ray.weight[c] / count / (2 * PI * (1 - cos(WIDE_SUN)))
                      : 0;
        }
        if (ray.weight[1] > 0) {
            whole += ray.weight[1];
            squares += ray.weight[1] * ray.weight[1];
            escapes[first.count++] = (struct air_escape){
                to, whole, { ray.weight[0], ray.weight[1], ray.weight[2] }
            };
        }
    }
    first.drawn = whole / count;
    *error =
        whole > 0 ? sqrt(fmax(squares - whole * whole / count, 0)) / whole : 0;
    for (int c = 0; c < AIR_CHANNELS; c++) {
        first.leaves[c] /= level_transmittance(waves->ground->index[c]);
    }
    return first;
}

struct space_white space_waves_white(const struct space_waves *waves,
                                     struct air_vec toward, struct air_vec up,
                                     int rays, uint64_t seed)
{
    struct frame frame = frame_at(waves->ground, up);
    struct space_white white = { 0 };
    struct sea_random random;
    sea_random_init(&random, seed);
    for (int i = 0; i < rays; i++) {
        struct followed ray = follow_from(waves, &frame, toward, &random);
        white.mirrored += ray.weight[1] / rays;
        white.once += ray.met == 1 ? ray.weight[1] / rays : 0;
        white.water += ray.water[1] / rays;
    }
    return white;
}
