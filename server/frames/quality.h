/* How finely live views are drawn, so that they keep their rate: a scale that
 * all of them share (so that the windows of one bridge stay of one density),
 * chosen from what the last frames cost. Pictures keep the size that was asked
 * for: they are scaled when they are encoded. Stills are never drawn coarser.
 *
 * Steps of 1/sqrt(2) in pixels. It goes down when frames cost more than their
 * period, by as many steps as should bring them to four fifths of it; up by one
 * when the finer step should cost less than that for some seconds. A step up
 * that is taken back at once makes the next wait twice as long. One thread. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PEL_QUALITY_MIN 0.25 /* of width and height */
#define PEL_QUALITY_STEPS 9  /* the scales 1 .. 1/4 */
#define PEL_QUALITY_SAMPLES 9

struct pel_quality {
    double fixed;      /* a scale that stays, 0: by itself */
    double pixel_ms;   /* what a drawn pixel costs, 0: not known */
    unsigned step;     /* 0: full */
    uint64_t pixels;   /* of a frame in full, of the samples */
    uint64_t expected; /* the same, of the next frame */
    double samples[PEL_QUALITY_SAMPLES]; /* [ms], at the scale `sampled` */
    double sampled;
    size_t count;
    int64_t calm_ns;  /* since then a finer step would do; 0: it would not */
    int64_t wait_ns;  /* before the next step up */
    int64_t up_ns;    /* when the last one was taken */
    uint64_t changes; /* of the step so far */
};

/* All zero at the start, but for pixel_ms if there is an idea of it.
 * fixed: PEL_QUALITY_MIN .. 1, or 0: by itself, beginning in full. A scale that
 * was found stays when only that is said again. */
void pel_quality_set(struct pel_quality *quality, double fixed);

/* Scale of width and height that the next frame is drawn at. */
double pel_quality_scale(const struct pel_quality *quality);

/* That size in pixels: even, 16 or more, `full` where the scale is 1. */
uint32_t pel_quality_size(double scale, uint32_t full);

/* Announces the pixels of the next frame in full. Where there are more than
 * before and their known cost predicts a frame far too slow, the scale is
 * chosen before it is drawn, so that the first picture comes soon. True when
 * the scale has changed. */
bool pel_quality_expect(struct pel_quality *quality, uint64_t pixels,
                        double period_ms);

/* A frame that was drawn at `scale` kept the renderer for busy_ms; `pixels`:
 * its size in full; period_ms: between frames; now_ns: of any clock that does
 * not run backwards. Frames of finer scales than the present one are passed
 * over; those of coarser ones, which somebody else has chosen, say no more than
 * that even they are too much. True when the scale has changed. */
bool pel_quality_feed(struct pel_quality *quality, double scale,
                      uint64_t pixels, double busy_ms, double period_ms,
                      int64_t now_ns);
