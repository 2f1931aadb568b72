#include "seabed/load.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "seabed/wire.h"

#define PROGRAM "pelagos-seabed"

static enum pel_err check(const struct pel_seabed_source *s,
                          struct pel_fault *fault)
{
    if (!s->directory) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "seabed.file needs pelagosd --bathymetry");
    }
    if (strchr(s->file, '/') || s->file[0] == '.' || s->file[0] == '-') {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "seabed.file must be the name of a file in the "
                             "directory of pelagosd --bathymetry, without /");
    }
    return pel_helper_find(s->directory, s->file, fault);
}

/* Runs the reader. */
static enum pel_err run(const struct pel_seabed_source *s, unsigned char **out,
                        size_t *size, struct pel_fault *fault)
{
    char places[5][32];
    const double values[] = { s->origin_latitude, s->origin_longitude,
                              s->latitude, s->longitude, s->spacing_m };
    for (int i = 0; i < 5; i++) {
        snprintf(places[i], sizeof *places, "%.12g", values[i]);
    }
    char *argv[] = { (char[]){ PROGRAM },
                     places[0],
                     places[1],
                     s->depths ? (char[]){ "depth" } : (char[]){ "elevation" },
                     (char *)s->directory,
                     (char *)s->file,
                     s->placed ? places[2] : NULL,
                     places[3],
                     places[4],
                     NULL };
    const struct pel_helper_task task = {
        .program = PROGRAM,
        .argv = argv,
        .subject = s->file,
        .most_bytes = PEL_SEABED_WIRE_MOST,
        .within_ms = PEL_SEABED_LOAD_MS,
    };
    return pel_helper_run(&task, out, size, fault);
}

/* The wire's heights, moved by the source's offset. */
static enum pel_err read_field(unsigned char *bytes, size_t size,
                               double offset_m, const struct pel_seabed **out,
                               struct pel_fault *fault)
{
    for (size_t at = PEL_SEABED_WIRE_HEAD; offset_m != 0 && at + 4 <= size;
         at += 4) {
        float height;
        memcpy(&height, bytes + at, 4);
        height += (float)offset_m;
        memcpy(bytes + at, &height, 4);
    }
    return pel_seabed_wire_read(bytes, size, out, fault);
}

enum pel_err pel_seabed_load(const struct pel_seabed_source *source,
                             const struct pel_seabed **out,
                             struct pel_fault *fault)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    enum pel_err err = check(source, fault);
    if (!err) {
        err = run(source, &bytes, &size, fault);
    }
    if (!err) {
        struct pel_fault why;
        err = read_field(bytes, size, source->offset_m, out, &why);
        if (err) {
            pel_fault_set(fault, err, "%.80s: %.160s", source->file,
                          why.message);
        }
    }
    free(bytes);
    return err;
}
