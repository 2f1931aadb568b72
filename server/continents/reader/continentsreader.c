/* pelagos-continents: reads coastlines and writes shares of land to standard
 * output in the form of continents/continents.h. Started once, when a picture
 * from high up first needs them.
 *
 *   pelagos-continents DIRECTORY FILE
 *
 * It may read that file and nothing else (base/sandbox.h). On failure a
 * sentence on standard error, status 1, or 2 for wrong use. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/sandbox.h"
#include "continents/continents.h"
#include "continents/reader/coastlines.h"

#define MOST_MEMORY ((size_t)1 << 30)
#define MOST_CPU_S 16

_Noreturn static void refuse(const char *why)
{
    fprintf(stderr, "%s\n", why);
    fflush(stderr);
    _Exit(1);
}

static enum pel_err enter(const char *directory, const char *path,
                          struct pel_fault *fault)
{
    const char *readable[] = { path, NULL };
    const struct pel_sandbox sandbox = { .readable = readable,
                                         .cpu_s = MOST_CPU_S,
                                         .memory_bytes = MOST_MEMORY,
                                         .walls = PEL_SANDBOX_ALL };
    if (chdir(directory)) {
        return pel_fault_set(fault, PEL_ERR_IO, "%.160s: %s", directory,
                             strerror(errno));
    }
    return pel_sandbox_close(&sandbox, fault);
}

int main(int argc, char **argv)
{
    struct pel_coastlines lines = { 0 };
    struct pel_fault fault = { 0 };
    char path[4096];
    if (argc != 3) {
        fprintf(stderr, "usage: pelagos-continents DIRECTORY FILE\n");
        return 2;
    }
    snprintf(path, sizeof path, "./%.4000s", argv[2]);
    unsigned char *share = NULL;
    /* HDF5 would lock the file, which the sandbox does not let it. */
    setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
    if (enter(argv[1], path, &fault) ||
        pel_coastlines_read(path, &lines, &fault) ||
        pel_coastlines_fill(&lines, PEL_CONTINENT_COLUMNS, PEL_CONTINENT_ROWS,
                            &share, &fault)) {
        refuse(fault.message);
    }
    const size_t count = PEL_CONTINENT_BYTES - 8;
    if (fwrite(PEL_CONTINENT_MAGIC, 8, 1, stdout) != 1 ||
        fwrite(share, 1, count, stdout) != count || fflush(stdout)) {
        refuse(strerror(errno));
    }
    fflush(stderr);
    _Exit(0);
}
