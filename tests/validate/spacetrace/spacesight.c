#include "spacesight.h"

#define PI 3.14159265358979323846

/* Beyond it, rad, paths seek where the Sun shines. */
#define DUSK 1.5

struct air_vec space_toward(double nadir, double azimuth)
{
    return (struct air_vec){ sin(nadir) * cos(azimuth),
                             sin(nadir) * sin(azimuth), -cos(nadir) };
}

static struct air_vec eye_at(const struct air *air, const struct space_eye *eye)
{
    return (struct air_vec){ 0, 0, air->ground + eye->height };
}

static struct air_vec sun_of(const struct space_eye *eye)
{
    return (struct air_vec){ sin(eye->sun_zenith), 0, cos(eye->sun_zenith) };
}

/* Where a ray is within a sphere; false: never, or behind. The difference of
 * squares is a product, for eyes far away. */
static bool within(struct air_vec from, struct air_vec toward, double radius,
                   double *enter, double *leave)
{
    double r = sqrt(air_dot(from, from)), s = air_dot(from, toward);
    double root2 = s * s - (r - radius) * (r + radius);
    if (root2 <= 0) {
        return false;
    }
    double root = sqrt(root2);
    *enter = -s - root;
    *leave = -s + root;
    return *leave > 0;
}

enum space_end space_meets(const struct air *air, const struct space_eye *eye,
                           struct air_vec toward, struct air_vec *ground)
{
    struct air_vec from = eye_at(air, eye);
    double enter, leave;
    if (within(from, toward, air->ground, &enter, &leave) && enter >= 0) {
        *ground = air_along(from, enter, toward);
        return SPACE_GROUND;
    }
    return within(from, toward, air->top, &enter, &leave) ? SPACE_AIR
                                                          : SPACE_NOTHING;
}

/* From the eye, or where its sight enters the air, to the ground or the top. */
static bool stretch(const struct air *air, const struct space_eye *eye,
                    struct air_vec toward, double *from, double *to)
{
    struct air_vec place = eye_at(air, eye);
    double enter, leave;
    if (!within(place, toward, air->top, from, to)) {
        return false;
    }
    *from = fmax(*from, 0);
    if (within(place, toward, air->ground, &enter, &leave) && enter >= 0) {
        *to = enter;
    }
    return true;
}

/* Upright at the sight's first place, and the Sun over x. */
struct frame {
    struct air_vec x, y, up;
    double radius, from, to;
};

static bool frame_of(const struct air *air, const struct space_eye *eye,
                     struct air_vec toward, struct frame *f)
{
    if (!stretch(air, eye, toward, &f->from, &f->to)) {
        return false;
    }
    struct air_vec p = air_along(eye_at(air, eye), f->from, toward);
    struct air_vec sun = sun_of(eye);
    double r = sqrt(air_dot(p, p));
    struct air_vec up = { p.x / r, p.y / r, p.z / r };
    struct air_vec x = air_along(sun, -air_dot(up, sun), up);
    double level = sqrt(air_dot(x, x));
    if (level < 1e-12) {
        x = air_turned(up, 0, 0);
        level = 1;
    }
    x = (struct air_vec){ x.x / level, x.y / level, x.z / level };
    f->x = x;
    f->y = (struct air_vec){ up.y * x.z - up.z * x.y, up.z * x.x - up.x * x.z,
                             up.x * x.y - up.y * x.x };
    f->up = up;
    f->radius = r;
    return true;
}

static struct air_vec in_frame(const struct frame *f, struct air_vec v)
{
    return (struct air_vec){ air_dot(v, f->x), air_dot(v, f->y),
                             air_dot(v, f->up) };
}

struct air_vec space_turned(const struct air *air, const struct space_eye *eye,
                            struct air_vec toward, struct air_vec vector)
{
    struct frame f;
    return frame_of(air, eye, toward, &f) ? in_frame(&f, vector) : vector;
}

bool space_sight(const struct air *air, const struct space_eye *eye,
                 struct air_vec toward, int channel, struct air_sight *sight)
{
    struct frame f;
    if (!frame_of(air, eye, toward, &f)) {
        return false;
    }
    struct air_vec sun = sun_of(eye);
    /* The lowest place of the sight tells day from dusk. */
    struct air_vec low = eye_at(air, eye);
    double nearest = -air_dot(low, toward);
    low = air_along(low, fmin(fmax(nearest, f.from), f.to), toward);
    double low_zenith = acos(air_dot(low, sun) / sqrt(air_dot(low, low)));
    *sight = (struct air_sight){
        .channel = channel,
        .height = fmin(f.radius, air->top) - air->ground,
        .toward = in_frame(&f, toward),
        .suns = 1,
        .zenith = { acos(fmin(fmax(air_dot(f.up, sun), -1), 1)) },
        .guided = low_zenith > DUSK,
    };
    return true;
}

double space_glint(const struct air_scene *scene, const struct space_eye *eye,
                   struct air_vec toward, int channel)
{
    const struct air *air = scene->air;
    struct air_vec place;
    if (space_meets(air, eye, toward, &place) != SPACE_GROUND) {
        return 0;
    }
    double r = sqrt(air_dot(place, place));
    struct air_vec up = { place.x / r, place.y / r, place.z / r };
    struct air_vec back = { -toward.x, -toward.y, -toward.z };
    struct air_vec sun = sun_of(eye);
    double depth = air_depth(air, channel, 0, air_dot(back, up), 400);
    if (air->ground + eye->height < air->top) {
        depth -= air_depth(air, channel, eye->height, -toward.z, 400);
    }
    double cosine = air_dot(sun, up);
    if (cosine <= 0) {
        return 0;
    }
    return air_ground_mirror(scene->ground, channel, back, sun, up) * cosine *
           exp(-depth) * air_sun_exact(air, channel, 0, cosine, 16);
}

double space_once(const struct air *air, const struct space_eye *eye,
                  struct air_vec toward, int channel, int steps, int chords)
{
    double from, to, depth = 0, sum = 0;
    if (!stretch(air, eye, toward, &from, &to)) {
        return 0;
    }
    struct air_vec sun = sun_of(eye), start = eye_at(air, eye);
    double turned = air_dot(toward, sun), step = (to - from) / steps;
    for (int i = 0; i < steps; i++) {
        struct air_vec p = air_along(start, from + (i + 0.5) * step, toward);
        double r = sqrt(air_dot(p, p));
        struct air_point point = air_exact(air, channel, r - air->ground);
        double piece = point.extinction * step;
        double source = point.molecules * air_phase_molecules(air, turned) +
                        point.aerosols * air_phase_aerosols(air, turned);
        sum += source * step * exp(-depth - piece / 2) *
               air_sun_exact(air, channel, r - air->ground, air_dot(p, sun) / r,
                             chords);
        depth += piece;
    }
    return sum;
}
