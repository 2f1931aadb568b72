#include <math.h>

#include "base/vec.h"
#include "continents/continents.h"

struct cover {
    double r, g, b;
};

static const struct cover rainforest = { 0.035, 0.065, 0.025 },
                          savanna = { 0.13, 0.12, 0.055 },
                          steppe = { 0.12, 0.115, 0.055 },
                          woods = { 0.055, 0.075, 0.03 },
                          taiga = { 0.045, 0.06, 0.03 },
                          tundra = { 0.13, 0.125, 0.085 },
                          sand = { 0.4, 0.3, 0.165 }, ice = { 0.76, 0.79, 0.8 };

/* Covers from the equator to the poles, by the degrees of latitude from which
 * on each is whole. */
static const struct {
    double latitude;
    const struct cover *cover;
} zones[] = {
    { 6, &rainforest }, { 13, &savanna }, { 28, &steppe }, { 38, &steppe },
    { 46, &woods },     { 54, &woods },   { 60, &taiga },  { 66, &taiga },
    { 71, &tundra },    { 76, &tundra },  { 81, &ice },
};

/* Middle and half-widths, degrees. */
static const struct {
    double latitude, longitude, high, wide;
} deserts[] = {
    { 24, 8, 8, 30 },     /* Sahara */
    { 24, 47, 9, 12 },    /* Arabia */
    { 30, 61, 6, 13 },    /* Iran to the Thar */
    { 42, 62, 5, 10 },    /* Turan */
    { 41, 95, 5, 18 },    /* Taklamakan, Gobi */
    { 32, -111, 6, 8 },   /* Sonora, Mojave */
    { -24, 20, 7, 6 },    /* Namib, Kalahari */
    { -25, 131, 6, 14 },  /* Australia */
    { -22, -69.5, 9, 3 }, /* Atacama */
};

static double smooth(double from, double to, double x)
{
    double t = pel_clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

static void toward(double out[3], const struct cover *c, double share)
{
    out[0] += (c->r - out[0]) * share;
    out[1] += (c->g - out[1]) * share;
    out[2] += (c->b - out[2]) * share;
}

/* 1 inside an ellipse, 0 from 1.4 times its size on. */
static double inside(double latitude, double longitude, double high,
                     double wide)
{
    return 1.0 - smooth(0.8, 1.4, hypot(latitude / high, longitude / wide));
}

void pel_land_albedo(double latitude, double longitude, double out[3])
{
    const int count = sizeof zones / sizeof *zones;
    double away = fabs(latitude);
    out[0] = zones[0].cover->r;
    out[1] = zones[0].cover->g;
    out[2] = zones[0].cover->b;
    for (int i = 1; i < count; i++) {
        toward(out, zones[i].cover,
               smooth(zones[i - 1].latitude, zones[i].latitude, away));
    }
    for (size_t i = 0; i < sizeof deserts / sizeof *deserts; i++) {
        toward(out, &sand,
               inside(latitude - deserts[i].latitude,
                      remainder(longitude - deserts[i].longitude, 360.0),
                      deserts[i].high, deserts[i].wide));
    }
    /* Greenland's ice leaves its coasts free. */
    toward(out, &ice, inside(latitude - 72, longitude + 41, 10, 14));
    toward(out, &ice, smooth(-60, -63, latitude));
}
