#include "ocean/spectrumfile.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "base/vec.h"

#define PROGRAM "pelagos-spectrum"

static bool within(const double *v, int count, double least, double most)
{
    for (int i = 0; i < count; i++) {
        if (!(v[i] >= least && v[i] <= most)) {
            return false;
        }
    }
    return true;
}

/* The reader works on files from anywhere: nothing of it is trusted. */
static bool take(const unsigned char *bytes, size_t size,
                 struct pel_measured *out, double *unix_s)
{
    int32_t count;
    if (size < PEL_SPECTRUM_FILE_HEAD ||
        memcmp(bytes, PEL_SPECTRUM_FILE_MAGIC, 8) != 0) {
        return false;
    }
    memcpy(&count, bytes + 8, sizeof count);
    memcpy(unix_s, bytes + 16, sizeof *unix_s);
    if (count < 3 || count > PEL_MEASURED_MOST || !isfinite(*unix_s) ||
        size != PEL_SPECTRUM_FILE_HEAD + 48 * (size_t)count) {
        return false;
    }
    double *const arrays[] = { out->frequency_hz, out->density,
                               out->r1,           out->r2,
                               out->alpha1_rad,   out->alpha2_rad };
    for (size_t i = 0; i < 6; i++) {
        memcpy(arrays[i],
               bytes + PEL_SPECTRUM_FILE_HEAD + 8 * i * (size_t)count,
               8 * (size_t)count);
    }
    out->count = count;
    for (int i = 1; i < count; i++) {
        if (!(out->frequency_hz[i] > out->frequency_hz[i - 1])) {
            return false;
        }
    }
    return within(out->frequency_hz, count, 0.005, 2) &&
           within(out->density, count, 0, 1e4) &&
           within(out->r1, count, 0, 1) && within(out->r2, count, 0, 1) &&
           within(out->alpha1_rad, count, -7, 7) &&
           within(out->alpha2_rad, count, -7, 7);
}

enum pel_err pel_spectrum_file_read(const char *directory, const char *file,
                                    const char *station, double unix_s,
                                    struct pel_measured *out,
                                    double *record_unix_s,
                                    struct pel_fault *fault)
{
    char when[40];
    unsigned char *bytes = NULL;
    size_t size = 0;
    struct pel_measured found = { 0 };
    double at = 0;
    enum pel_err err = pel_helper_find(directory, file, fault);
    if (err) {
        return err;
    }
    snprintf(when, sizeof when, "%.3f", unix_s); /* nan: the newest */
    char *argv[] = { (char[]){ PROGRAM }, (char *)directory,
                     (char *)file,        when,
                     (char *)station,     NULL };
    const struct pel_helper_task task = {
        .program = PROGRAM,
        .argv = argv,
        .subject = file,
        .most_bytes = PEL_SPECTRUM_FILE_WIRE_MOST,
        .within_ms = PEL_SPECTRUM_FILE_LOAD_MS,
    };
    err = pel_helper_run(&task, &bytes, &size, fault);
    if (!err && !take(bytes, size, &found, &at)) {
        err = pel_fault_set(fault, PEL_ERR_MALFORMED,
                            "%.80s: not a wave spectrum", file);
    }
    free(bytes);
    if (!err) {
        *out = found;
        if (record_unix_s) {
            *record_unix_s = at;
        }
    }
    return err;
}
