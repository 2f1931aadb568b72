/* pelagos-continents: reads coastlines and writes shares of land to standard
 * output in the form of continents/continents.h. Started once, when a picture
 * from high up first needs them.
 *
 *   pelagos-continents DIRECTORY FILE
 *
 * It may read that file and nothing else (base/sandbox.h). On failure a
 * sentence on standard error, status 1, or 2 for wrong use. */
#include <stdio.h>
#include <stdlib.h>

#include "base/reader.h"
#include "continents/continents.h"
#include "continents/reader/coastlines.h"

#define MOST_MEMORY ((size_t)1 << 30)
#define MOST_CPU_S 16

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
    const char *readable[] = { path, NULL };
    pel_reader_begin(
        &(struct pel_reader){ argv[1], readable, MOST_CPU_S, MOST_MEMORY });
    if (pel_coastlines_read(path, &lines, &fault) ||
        pel_coastlines_fill(&lines, PEL_CONTINENT_COLUMNS, PEL_CONTINENT_ROWS,
                            &share, &fault)) {
        pel_reader_refuse(fault.message);
    }
    const size_t count = PEL_CONTINENT_BYTES - 8;
    pel_reader_end(fwrite(PEL_CONTINENT_MAGIC, 8, 1, stdout) == 1 &&
                   fwrite(share, 1, count, stdout) == count);
}
