#include "continents/continents.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/helper.h"
#include "base/log.h"
#include "base/vec.h"

#define PROGRAM "pelagos-continents"
#define DIRECTORY "/usr/share/gmt-gshhg"

static uint16_t word_of(double x)
{
    return (uint16_t)lround(65535.0 * pel_clamp(x, 0.0, 1.0));
}

static uint16_t (*make_ground(void))[4]
{
    uint16_t(*ground)[4] =
        malloc(sizeof *ground * PEL_GROUND_COLUMNS * PEL_GROUND_ROWS);
    for (int y = 0; ground && y < PEL_GROUND_ROWS; y++) {
        for (int x = 0; x < PEL_GROUND_COLUMNS; x++) {
            double albedo[3];
            pel_land_albedo((y + 0.5) * 180.0 / PEL_GROUND_ROWS - 90.0,
                            (x + 0.5) * 360.0 / PEL_GROUND_COLUMNS - 180.0,
                            albedo);
            uint16_t *to = ground[y * PEL_GROUND_COLUMNS + x];
            for (int k = 0; k < 3; k++) {
                to[k] = word_of(albedo[k]);
            }
            to[3] = 65535;
        }
    }
    return ground;
}

enum pel_err pel_continents_load(const char *directory, const char *file,
                                 struct pel_continents **out,
                                 struct pel_fault *fault)
{
    char *argv[] = { (char[]){ PROGRAM }, (char *)directory, (char *)file,
                     NULL };
    const struct pel_helper_task task = {
        .program = PROGRAM,
        .argv = argv,
        .subject = file,
        .most_bytes = PEL_CONTINENT_BYTES,
        .within_ms = PEL_CONTINENT_LOAD_MS,
    };
    unsigned char *bytes = NULL;
    size_t size = 0;
    enum pel_err err = pel_helper_find(directory, file, fault);
    if (!err) {
        err = pel_helper_run(&task, &bytes, &size, fault);
    }
    if (!err && (size != PEL_CONTINENT_BYTES ||
                 memcmp(bytes, PEL_CONTINENT_MAGIC, 8) != 0)) {
        err = pel_fault_set(fault, PEL_ERR_MALFORMED, "not shares of land");
    }
    struct pel_continents *c = err ? NULL : calloc(1, sizeof *c);
    if (c) {
        c->ground = make_ground();
    }
    if (!err && (!c || !c->ground)) {
        err = pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
        free(c);
    }
    if (err) {
        free(bytes);
        return err;
    }
    memmove(bytes, bytes + 8, size - 8);
    c->share = bytes;
    *out = c;
    return PEL_OK;
}

void pel_continents_free(struct pel_continents *c)
{
    if (c) {
        free((void *)c->share);
        free((void *)c->ground);
        free(c);
    }
}

static struct pel_continents *first;

static void load_first(void)
{
    static const char *const files[] = { "binned_GSHHS_i.nc",
                                         "binned_GSHHS_l.nc" };
    struct pel_fault fault = { 0 };
    for (int i = 0; i < 2 && !first; i++) {
        if (pel_continents_load(DIRECTORY, files[i], &first, &fault)) {
            first = NULL;
        }
    }
    if (!first) {
        pel_warn("RND-046",
                 "no continents are drawn from high up: %s; they need the "
                 "coastlines of Debian's gmt-gshhg-low",
                 fault.message);
    }
}

const struct pel_continents *pel_continents_get(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, load_first);
    return first;
}
