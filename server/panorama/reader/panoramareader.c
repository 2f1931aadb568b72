/* pelagos-panorama: reads one picture of the whole sky and writes it to
 * standard output in the form of panorama/panorama.h. The daemon starts one
 * for a file and throws it away.
 *
 *   pelagos-panorama DIRECTORY FILE
 *
 * It may read that file and nothing else (base/sandbox.h). On failure a
 * sentence on standard error, status 1, or 2 for wrong use. */
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/reader.h"
#include "panorama/panorama.h"
#include "panorama/reader/equirect.h"

#define MOST_MEMORY ((size_t)1 << 30)
#define MOST_CPU_S 12

static enum pel_err read_file(const char *path, struct pel_equirect *out,
                              struct pel_fault *fault)
{
    unsigned char head[4] = { 0 };
    FILE *f = fopen(path, "rb");
    if (!f) {
        return pel_fault_set(fault, PEL_ERR_IO, "%s", strerror(errno));
    }
    size_t got = fread(head, 1, sizeof head, f);
    fclose(f);
    if (got == sizeof head && memcmp(head, "\x76\x2f\x31\x01", 4) == 0) {
        return pel_equirect_read_exr(path, out, fault);
    }
    if (got == sizeof head && memcmp(head, "#?", 2) == 0) {
        return pel_equirect_read_radiance(path, out, fault);
    }
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "neither OpenEXR nor Radiance");
}

int main(int argc, char **argv)
{
    struct pel_equirect picture;
    struct pel_fault fault = { 0 };
    char path[4096];
    if (argc != 3) {
        fprintf(stderr, "usage: pelagos-panorama DIRECTORY FILE\n");
        return 2;
    }
    snprintf(path, sizeof path, "./%.4000s", argv[2]);
    const char *readable[] = { path, NULL };
    pel_reader_begin(
        &(struct pel_reader){ argv[1], readable, MOST_CPU_S, MOST_MEMORY });
    if (read_file(path, &picture, &fault)) {
        pel_reader_refuse(fault.message);
    }
    const uint32_t sides[2] = { (uint32_t)picture.columns,
                                (uint32_t)picture.rows };
    size_t count = 3 * (size_t)picture.columns * (size_t)picture.rows;
    pel_reader_end(
        fwrite(PEL_PANORAMA_MAGIC, 8, 1, stdout) == 1 &&
        fwrite(sides, sizeof sides, 1, stdout) == 1 &&
        fwrite(picture.values, sizeof *picture.values, count, stdout) == count);
}
