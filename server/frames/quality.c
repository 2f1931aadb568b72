#include "frames/quality.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TARGET 0.8       /* of the period: what a step is chosen for */
#define TOO_MUCH 0.97    /* a median above it is */
#define FAR_TOO_MUCH 1.2 /* with so few samples already */
#define FEW 3
#define WAIT_NS (3 * 1000000000LL)
#define WAIT_MAX_NS (96 * 1000000000LL)
#define TAKEN_BACK_NS (10 * 1000000000LL)

static double scale_of(unsigned step)
{
    return exp2(-0.25 * step);
}

void pel_quality_set(struct pel_quality *quality, double fixed)
{
    if (quality->fixed != fixed || quality->wait_ns == 0) {
        uint64_t changes = quality->changes;
        *quality = (struct pel_quality){ .fixed = fixed,
                                         .pixel_ms = quality->pixel_ms,
                                         .wait_ns = WAIT_NS,
                                         .changes = changes };
    }
}

double pel_quality_scale(const struct pel_quality *quality)
{
    return quality->fixed > 0 ? quality->fixed : scale_of(quality->step);
}

uint32_t pel_quality_size(double scale, uint32_t full)
{
    uint32_t size = 2 * (uint32_t)(0.5 * scale * full + 0.5);
    size = size < 16 ? 16 : size;
    return scale >= 1 || size > full ? full : size;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const struct pel_quality *quality)
{
    double sorted[PEL_QUALITY_SAMPLES];
    size_t n = quality->count < PEL_QUALITY_SAMPLES ? quality->count
                                                    : PEL_QUALITY_SAMPLES;
    memcpy(sorted, quality->samples, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare);
    return sorted[n / 2];
}

static void go_to(struct pel_quality *quality, unsigned step)
{
    quality->step = step;
    quality->count = 0;
    quality->calm_ns = 0;
    quality->changes++;
}

/* The finest step that should cost no more than the target: cost goes with
 * pixels, as far as it goes with anything that can be changed here. */
static unsigned step_for(const struct pel_quality *quality, double load)
{
    unsigned step = quality->step;
    while (step < PEL_QUALITY_STEPS - 1 && load > TARGET) {
        load *= M_SQRT1_2;
        step++;
    }
    return step;
}

bool pel_quality_expect(struct pel_quality *quality, uint64_t pixels,
                        double period_ms)
{
    bool more = pixels > quality->expected;
    double scale = scale_of(quality->step);
    double load =
        quality->pixel_ms * scale * scale * (double)pixels / period_ms;
    quality->expected = pixels;
    if (quality->fixed > 0 || !more || load <= FAR_TOO_MUCH) {
        return false;
    }
    unsigned step = step_for(quality, load);
    bool changed = step != quality->step;
    if (changed) {
        go_to(quality, step);
    }
    return changed;
}

static bool go_down(struct pel_quality *quality, double load, int64_t now_ns)
{
    unsigned step = step_for(quality, load);
    if (step == quality->step) {
        return false;
    }
    bool taken_back = quality->up_ns && now_ns - quality->up_ns < TAKEN_BACK_NS;
    quality->wait_ns = taken_back ? 2 * quality->wait_ns : WAIT_NS;
    if (quality->wait_ns > WAIT_MAX_NS) {
        quality->wait_ns = WAIT_MAX_NS;
    }
    go_to(quality, step);
    return true;
}

static bool go_up(struct pel_quality *quality, double load, int64_t now_ns)
{
    if (quality->step == 0 || load * M_SQRT2 > TARGET) {
        quality->calm_ns = 0;
        return false;
    }
    if (quality->calm_ns == 0) {
        quality->calm_ns = now_ns;
    }
    if (now_ns - quality->calm_ns < quality->wait_ns) {
        return false;
    }
    quality->up_ns = now_ns;
    go_to(quality, quality->step - 1);
    return true;
}

bool pel_quality_feed(struct pel_quality *quality, double scale,
                      uint64_t pixels, double busy_ms, double period_ms,
                      int64_t now_ns)
{
    double own = scale_of(quality->step);
    if (quality->fixed > 0 || scale > own) {
        return false;
    }
    /* Other views, or another scale: nothing is known. */
    if (pixels != quality->pixels || scale != quality->sampled) {
        quality->pixels = pixels;
        quality->sampled = scale;
        quality->count = 0;
        quality->calm_ns = 0;
    }
    quality->samples[quality->count++ % PEL_QUALITY_SAMPLES] = busy_ms;
    if (quality->count < FEW) {
        return false;
    }
    double load = median(quality) / period_ms;
    quality->pixel_ms = median(quality) / ((double)pixels * scale * scale);
    bool many = quality->count >= PEL_QUALITY_SAMPLES;
    if (load > (many ? TOO_MUCH : FAR_TOO_MUCH)) {
        while (scale_of(quality->step) > scale &&
               quality->step < PEL_QUALITY_STEPS - 1) {
            quality->step++;
        }
        return go_down(quality, load, now_ns) || scale < own;
    }
    return scale == own && many && go_up(quality, load, now_ns);
}
