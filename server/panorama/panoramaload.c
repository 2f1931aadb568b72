#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "panorama/panorama.h"

#define PROGRAM "pelagos-panorama"

static enum pel_err run(const char *directory, const char *file,
                        unsigned char **out, size_t *size,
                        struct pel_fault *fault)
{
    char *argv[] = { (char[]){ PROGRAM }, (char *)directory, (char *)file,
                     NULL };
    const struct pel_helper_task task = {
        .program = PROGRAM,
        .argv = argv,
        .subject = file,
        .most_bytes = PEL_PANORAMA_WIRE_MOST,
        .within_ms = PEL_PANORAMA_LOAD_MS,
    };
    return pel_helper_run(&task, out, size, fault);
}

/* The reader works on files from anywhere: nothing of it is trusted. */
static enum pel_err take(unsigned char *bytes, size_t size, bool take_sun,
                         const struct pel_panorama **out,
                         struct pel_fault *fault)
{
    uint32_t sides[2];
    if (size < PEL_PANORAMA_HEAD || memcmp(bytes, PEL_PANORAMA_MAGIC, 8) != 0) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "not a panorama");
    }
    memcpy(sides, bytes + 8, 8);
    if (sides[0] > PEL_PANORAMA_MOST_COLUMNS ||
        sides[1] > PEL_PANORAMA_MOST_COLUMNS ||
        size - PEL_PANORAMA_HEAD != (size_t)12 * sides[0] * sides[1]) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "%u × %u texels in %zu bytes", sides[0], sides[1],
                             size);
    }
    /* Sixteen bytes from where memory was allotted: floats may lie there. */
    return pel_panorama_create((int)sides[0], (int)sides[1],
                               (float *)(void *)(bytes + PEL_PANORAMA_HEAD),
                               take_sun, out, fault);
}

enum pel_err pel_panorama_load(const char *directory, const char *file,
                               bool take_sun, const struct pel_panorama **out,
                               struct pel_fault *fault)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    if (!directory) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "sky.file needs pelagosd --panoramas");
    }
    enum pel_err err = pel_helper_find(directory, file, fault);
    if (!err) {
        err = run(directory, file, &bytes, &size, fault);
    }
    if (!err) {
        struct pel_fault why = { 0 };
        err = take(bytes, size, take_sun, out, &why);
        if (err) {
            pel_fault_set(fault, err, "%.80s: %.160s", file, why.message);
        }
    }
    free(bytes);
    return err;
}
