/* Files of wave spectra as pelagos-spectrum reads them, and NDBC's of the
 * daemon itself: what is taken is a spectrum. The first line says which form,
 * of which station and of which time (none: the newest); behind it comes the
 * file. NDBC's historical form has five, with a byte 1 between them. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <sys/stat.h>

#include "fuzz_file.h"
#include "fuzz_kept.h"
#include "ocean/ndbc.h"

#define calloc(n, s) fuzz_keep(calloc(n, s))
#define free(p) fuzz_drop(p)
#include "ocean/reader/shelf.c"     /* NOLINT(bugprone-suspicious-include) */
#include "ocean/reader/textforms.c" /* NOLINT(bugprone-suspicious-include) */
#undef calloc
#undef free

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

static void look(const struct pel_measured *m, double unix_s)
{
    demand(isfinite(unix_s) && m->count >= 3 && m->count <= PEL_MEASURED_MOST);
    for (int i = 0; i < m->count; i++) {
        demand(m->frequency_hz[i] >= 0.005 && m->frequency_hz[i] <= 2 &&
               m->density[i] >= 0 && m->r1[i] >= 0 && m->r1[i] <= 1 &&
               m->r2[i] >= 0 && m->r2[i] <= 1 && fabs(m->alpha1_rad[i]) < 7 &&
               fabs(m->alpha2_rad[i]) < 7);
    }
}

/* A folder of our own, in memory where there is such a place. */
static const char *folder(void)
{
    static char path[64];
    if (!path[0]) {
        snprintf(path, sizeof path, "%s/pelagos-fuzz-XXXXXX",
                 access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm");
        demand(mkdtemp(path) != NULL);
    }
    return path;
}

/* The parts between bytes 1, by these endings of names; more are not made. */
static void put_files(const uint8_t *data, size_t size, const char *start,
                      const char *const *endings, int count)
{
    char path[160];
    for (int i = 0; i < count; i++) {
        const uint8_t *end = size > 0 ? memchr(data, 1, size) : NULL;
        size_t length = end ? (size_t)(end - data) : size;
        snprintf(path, sizeof path, "%s/%s%s", folder(), start, endings[i]);
        unlink(path);
        if (i > 0 && length == 0) {
            continue;
        }
        FILE *f = fopen(path, "wb");
        demand(f && fwrite(data, 1, length, f) == length && !fclose(f));
        length += end != NULL;
        data += length;
        size -= length;
    }
}

static enum pel_err read_form(char form, const struct pel_want *want,
                              const uint8_t *data, size_t size,
                              struct pel_measured *out, double *unix_s,
                              struct pel_fault *fault)
{
    static const char *const years[] = { "w2020.txt", "d2020.txt", "i2020.txt",
                                         "j2020.txt", "k2020.txt" };
    static const char *const kinds[] = { ".data_spec", ".swdir", ".swdir2",
                                         ".swr1", ".swr2" };
    char path[160];
    const char *made;
    switch (form) {
    case 'S':
        return pel_read_swan(fuzz_file(data, size), want, out, unix_s, fault);
    case 'W':
        return pel_read_ww3(fuzz_file(data, size), want, out, unix_s, fault);
    case 'N':
        made = fuzz_netcdf(data, size, NC_CLOBBER);
        return made ? pel_read_netcdf(made, want, out, unix_s, fault)
                    : pel_fault_set(fault, PEL_ERR_INVALID, "no such file");
    case 'D':
        return pel_read_datawell(fuzz_file(data, size), want, out, unix_s,
                                 fault);
    case 'J':
        return pel_read_spotter(fuzz_file(data, size), want, out, unix_s,
                                fault);
    case 'H':
        put_files(data, size, "tst", years, 5);
        snprintf(path, sizeof path, "%s/tst%s", folder(), years[0]);
        return pel_read_historical(path, want, out, unix_s, fault);
    default:
        put_files(data, size, "tst", kinds, 5);
        return pel_ndbc_read(folder(), "tst", want->unix_s, out, unix_s, fault);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct pel_measured m;
    struct pel_fault fault = { 0 };
    char line[100] = "", station[64] = "";
    double unix_s = NAN;
    const uint8_t *end = size > 0 ? memchr(data, '\n', size) : NULL;
    if (!end || end - data >= (ptrdiff_t)sizeof line) {
        return 0;
    }
    memcpy(line, data, (size_t)(end - data));
    struct pel_want want = { station, NAN };
    (void)sscanf(line + (line[0] != 0), "%63[^ ] %lf", station, &want.unix_s);
    if (strcmp(station, "-") == 0) {
        station[0] = '\0';
    }
    size -= (size_t)(end + 1 - data);
    if (read_form(line[0], &want, end + 1, size, &m, &unix_s, &fault)) {
        demand(fault.message[0] != '\0');
    } else {
        look(&m, unix_s);
    }
    fuzz_release();
    return 0;
}
