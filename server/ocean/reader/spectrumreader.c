/* pelagos-spectrum: reads one record of a file of wave spectra and writes it to
 * standard output in the form of ocean/spectrumfile.h. The daemon starts one
 * for a file and throws it away.
 *
 *   pelagos-spectrum DIRECTORY FILE UNIX-TIME|nan STATION
 *   pelagos-spectrum --write
 *
 * The second writes NetCDF: what ocean/netcdffile.c describes on standard
 * input. It may read that file, and of NDBC's historical text those beside it,
 * or none, and nothing else (base/sandbox.h). On failure a sentence on standard
 * error, status 1, or 2 for wrong use. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/reader.h"
#include "ocean/reader/shelf.h"
#include "ocean/spectrumfile.h"

#define MOST_MEMORY ((size_t)2 << 30)
#define MOST_CPU_S 12

/* The file, and of NDBC's historical text those beside it. */
static void begin(const char *directory, const char *path)
{
    static char others[4][4096];
    const char *readable[6] = { path };
    for (int i = 0; i < 4; i++) {
        snprintf(others[i], sizeof others[i], "%s", path);
        char *w = pel_shelf_letter(others[i]);
        if (w) {
            *w = (*w == 'W' ? "DIJK" : "dijk")[i];
        }
        readable[1 + i] = others[i];
    }
    pel_reader_begin(
        &(struct pel_reader){ directory, readable, MOST_CPU_S, MOST_MEMORY });
}

/* By its first bytes; Datawell's numbers by the name. */
static pel_shelf_form *form_of(const char *path)
{
    char head[24] = { 0 };
    FILE *f = fopen(path, "rb");
    size_t got = f ? fread(head, 1, sizeof head - 1, f) : 0;
    if (f) {
        fclose(f);
    }
    char *mark = strrchr(path, '.');
    if (mark && strcasecmp(mark, ".spt") == 0) {
        return pel_read_datawell;
    }
    bool netcdf = got > 4 && (memcmp(head, "CDF", 3) == 0 ||
                              memcmp(head, "\x89HDF", 4) == 0);
    return netcdf                                     ? pel_read_netcdf
           : strncmp(head, "SWAN", 4) == 0            ? pel_read_swan
           : strncmp(head, "'WAVEWATCH III", 14) == 0 ? pel_read_ww3
           : strncmp(head + (head[0] == '#'), "YY", 2) == 0
               ? pel_read_historical
           : strchr("{[", head[strspn(head, " \t\r\n")]) && got
               ? pel_read_spotter
               : NULL;
}

#define MOST_HEIGHT_M 30.0 /* half as much again as any that was measured */

/* Numbers in another unit, or of another quantity, are no sea. */
static enum pel_err check_height(const struct pel_measured *m,
                                 struct pel_fault *fault)
{
    double m0 = 0;
    for (int i = 1; i < m->count; i++) {
        m0 += 0.5 * (m->density[i] + m->density[i - 1]) *
              (m->frequency_hz[i] - m->frequency_hz[i - 1]);
    }
    double height = 4 * sqrt(m0);
    return height <= MOST_HEIGHT_M
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                               "its significant height would be %.4g m, at "
                               "most %g m can be: are its numbers densities, "
                               "in the unit that the file says?",
                               height, MOST_HEIGHT_M);
}

_Noreturn static void write_netcdf(void)
{
    static const char *const nothing[] = { NULL };
    struct pel_fault fault = { 0 };
    pel_reader_begin(
        &(struct pel_reader){ NULL, nothing, MOST_CPU_S, MOST_MEMORY });
    if (pel_write_netcdf(&fault)) {
        pel_reader_refuse(fault.message);
    }
    pel_reader_end(true);
}

static bool put(const double *v, int count)
{
    return fwrite(v, sizeof *v, (size_t)count, stdout) == (size_t)count;
}

int main(int argc, char **argv)
{
    static struct pel_measured m;
    struct pel_fault fault = { 0 };
    char path[4096];
    double unix_s = 0;
    if (argc == 2 && strcmp(argv[1], "--write") == 0) {
        write_netcdf();
    }
    if (argc != 5) {
        fprintf(stderr, "usage: pelagos-spectrum DIRECTORY FILE UNIX-TIME|nan "
                        "STATION, or --write\n");
        return 2;
    }
    const struct pel_want want = { argv[4], strtod(argv[3], NULL) };
    snprintf(path, sizeof path, "./%.4000s", argv[2]);
    /* HDF5 would lock the file, which the sandbox does not let it. */
    setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
    begin(argv[1], path);
    pel_shelf_form *read = form_of(path);
    if (!read) {
        pel_reader_refuse(
            "neither NetCDF, nor SWAN's, WAVEWATCH III's or NDBC's "
            "historical text, Datawell's .spt or Spotter's JSON");
    }
    if (read(path, &want, &m, &unix_s, &fault) || check_height(&m, &fault)) {
        pel_reader_refuse(fault.message);
    }
    const int32_t head[2] = { m.count, 0 };
    pel_reader_end(fwrite(PEL_SPECTRUM_FILE_MAGIC, 8, 1, stdout) == 1 &&
                   fwrite(head, sizeof head, 1, stdout) == 1 &&
                   put(&unix_s, 1) && put(m.frequency_hz, m.count) &&
                   put(m.density, m.count) && put(m.r1, m.count) &&
                   put(m.r2, m.count) && put(m.alpha1_rad, m.count) &&
                   put(m.alpha2_rad, m.count));
}
