#include "airsun.h"

#define PI 3.14159265358979323846

static const double node[3] = { 0.1127016653792583, 0.5, 0.8872983346207417 };
static const double weight[3] = { 5.0 / 18, 8.0 / 18, 5.0 / 18 };

/* From s0 to s1 along a ray, both counted from the point nearest the centre,
 * at the distance `nearest`: pieces are short where the ray is low. */
static double leg(const struct air *air, int channel, double nearest, double s0,
                  double s1, int pieces)
{
    double sum = 0;
    for (int i = 0; i < pieces; i++) {
        double a = (double)i / pieces, b = (i + 1.0) / pieces;
        double from = s0 + (s1 - s0) * a * a, to = s0 + (s1 - s0) * b * b;
        for (int k = 0; k < 3; k++) {
            double s = from + (to - from) * node[k];
            double height = sqrt(nearest * nearest + s * s) - air->ground;
            sum += (to - from) * weight[k] *
                   air_at(air, channel, height).extinction;
        }
    }
    return sum;
}

double air_depth(const struct air *air, int channel, double height,
                 double cosine, int pieces)
{
    double r = air->ground + height, s = r * cosine;
    double nearest = r * sqrt(fmax(0, 1 - cosine * cosine));
    if (cosine < 0 && nearest < air->ground) {
        return 1e30;
    }
    double end = sqrt(air->top * air->top - nearest * nearest);
    return s >= 0 ? leg(air, channel, nearest, s, end, pieces)
                  : leg(air, channel, nearest, 0, end, pieces) +
                        leg(air, channel, nearest, 0, -s, pieces);
}

/* Chebyshev's nodes of the second kind: the disc's chords by their height. */
static double chord(int i, int chords, double *share)
{
    double angle = PI * (i + 1) / (chords + 1);
    *share = 2 * pow(sin(angle), 2) / (chords + 1);
    return AIR_SUN_RADIUS * cos(angle);
}

double air_sun_exact(const struct air *air, int channel, double height,
                     double cosine, int chords)
{
    double middle = acos(cosine), sum = 0;
    for (int i = 0; i < chords; i++) {
        double share, away = chord(i, chords, &share);
        double depth = air_depth(air, channel, height, cos(middle + away), 200);
        sum += share * exp(-depth);
    }
    return sum;
}

/* Angle from the zenith to the ground's edge. */
static double edge(double ground, double distance)
{
    return PI - asin(fmin(ground / distance, 1));
}

static double height_of(const struct air *air, int j)
{
    return (air->top - air->ground) * pow(j / (AIR_SUN_HEIGHTS - 1.0), 3);
}

static double angle_of(int i, double widest)
{
    return widest * pow(i / (AIR_SUN_ANGLES - 1.0), 2);
}

/* Optical depths over the angle above the ground's edge at one height. */
static void depths(const struct air *air, int channel, double height,
                   double *out)
{
    double limb = edge(air->ground, air->ground + height);
    for (int i = 0; i < AIR_SUN_ANGLES; i++) {
        /* Never below the edge by rounding. */
        double above = fmax(angle_of(i, limb), 1e-9);
        out[i] = air_depth(air, channel, height, cos(limb - above), 24);
        if (out[i] > 700) {
            out[i] = 700;
        }
    }
}

static double through(const double *depth, double widest, double above)
{
    if (above < 0) {
        return 0;
    }
    double x = sqrt(above / widest) * (AIR_SUN_ANGLES - 1);
    int i = x > AIR_SUN_ANGLES - 1.001 ? AIR_SUN_ANGLES - 2 : (int)x;
    return exp(-(depth[i] + (x - i) * (depth[i + 1] - depth[i])));
}

void air_sun_init(struct air_sun *sun, const struct air *air)
{
    enum { CHORDS = 16 };
    static _Thread_local double depth[AIR_SUN_ANGLES];
    sun->ground = air->ground;
    sun->top = air->top;
    for (int c = 0; c < AIR_CHANNELS; c++) {
        for (int j = 0; j < AIR_SUN_HEIGHTS; j++) {
            double height = height_of(air, j);
            double limb = edge(air->ground, air->ground + height);
            depths(air, c, height, depth);
            for (int i = 0; i < AIR_SUN_ANGLES; i++) {
                double above =
                    angle_of(i, limb + AIR_SUN_RADIUS) - AIR_SUN_RADIUS;
                double sum = 0;
                for (int k = 0; k < CHORDS; k++) {
                    double share, away = chord(k, CHORDS, &share);
                    /* Over the zenith and down again. */
                    double at = fmin(above + away, 2 * limb - above - away);
                    sum += share * through(depth, limb, fmin(at, limb));
                }
                sun->through[c][j][i] = (float)sum;
            }
        }
    }
}

struct air_sun_place air_sun_place(const struct air_sun *sun, int channel,
                                   double distance)
{
    double height = (distance - sun->ground) / (sun->top - sun->ground);
    double y = height > 0 ? cbrt(height) * (AIR_SUN_HEIGHTS - 1) : 0;
    int j = y > AIR_SUN_HEIGHTS - 1.001 ? AIR_SUN_HEIGHTS - 2 : (int)y;
    return (struct air_sun_place){
        .lower = sun->through[channel][j],
        .upper = sun->through[channel][j + 1],
        .between = y - j,
        .limb = edge(sun->ground, fmax(distance, sun->ground)),
    };
}

double air_sun_seen(const struct air_sun_place *place, double cosine)
{
    double above = place->limb + AIR_SUN_RADIUS -
                   acos(cosine > 1    ? 1
                        : cosine < -1 ? -1
                                      : cosine);
    if (above <= 0) {
        return 0;
    }
    double x =
        sqrt(above / (place->limb + AIR_SUN_RADIUS)) * (AIR_SUN_ANGLES - 1);
    int i = x > AIR_SUN_ANGLES - 1.001 ? AIR_SUN_ANGLES - 2 : (int)x;
    const float *p = place->lower + i, *q = place->upper + i;
    x -= i;
    double y = place->between;
    return (1 - y) * (p[0] + x * (p[1] - p[0])) +
           y * (q[0] + x * (q[1] - q[0]));
}
