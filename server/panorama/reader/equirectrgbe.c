#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "panorama/reader/equirect.h"

#define MOST_HEAD_LINES 100

static enum pel_err bad(struct pel_fault *fault, const char *what)
{
    return pel_fault_set(fault, PEL_ERR_MALFORMED, "the Radiance picture %s",
                         what);
}

/* Up to the line of sizes, which is left in `line`. */
static enum pel_err read_head(FILE *f, char line[256], struct pel_fault *fault)
{
    bool blank = false;
    if (!fgets(line, 256, f) || strncmp(line, "#?", 2) != 0) {
        return bad(fault, "does not begin with #?");
    }
    for (int i = 0; i < MOST_HEAD_LINES; i++) {
        if (!fgets(line, 256, f)) {
            return bad(fault, "ends in its head");
        }
        if (blank) {
            return PEL_OK;
        }
        if (strncmp(line, "FORMAT=", 7) == 0 &&
            strncmp(line, "FORMAT=32-bit_rle_rgbe", 22) != 0) {
            return bad(fault, "is not of RGBE");
        }
        blank = line[0] == '\n' || line[0] == '\r';
    }
    return bad(fault, "has too long a head");
}

/* A component of a row by runs. */
static bool read_runs(FILE *f, uint8_t *to, int columns)
{
    for (int x = 0; x < columns;) {
        int count = getc(f);
        if (count == EOF || count == 0) {
            return false;
        }
        bool run = count > 128;
        count = run ? count - 128 : count;
        if (x + count > columns) {
            return false;
        }
        int value = run ? getc(f) : 0;
        if (value == EOF ||
            (!run && fread(to + x, 1, (size_t)count, f) != (size_t)count)) {
            return false;
        }
        if (run) {
            memset(to + x, value, (size_t)count);
        }
        x += count;
    }
    return true;
}

/* Four planes, one after another. */
static bool read_row(FILE *f, uint8_t *planes, int columns)
{
    uint8_t head[4];
    if (fread(head, 4, 1, f) != 1) {
        return false;
    }
    bool runs = columns >= 8 && columns < 32768 && head[0] == 2 &&
                head[1] == 2 && head[2] < 128;
    if (runs && (head[2] << 8 | head[3]) != columns) {
        return false;
    }
    for (int i = 0; i < 4 && runs; i++) {
        if (!read_runs(f, planes + (size_t)i * (size_t)columns, columns)) {
            return false;
        }
    }
    for (int x = 0; x < columns && !runs; x++) {
        if (x > 0 && fread(head, 4, 1, f) != 1) {
            return false;
        }
        if (head[0] == 1 && head[1] == 1 && head[2] == 1) {
            return false; /* runs as before 1991 */
        }
        for (int i = 0; i < 4; i++) {
            planes[(size_t)i * (size_t)columns + (size_t)x] = head[i];
        }
    }
    return true;
}

static void decode(const uint8_t *planes, int columns, float *rgb)
{
    const uint8_t *e = planes + 3 * (size_t)columns;
    for (int x = 0; x < columns; x++) {
        double unit = e[x] ? ldexp(1.0, e[x] - 136) : 0.0;
        for (int i = 0; i < 3; i++) {
            double mantissa = planes[(size_t)i * (size_t)columns + (size_t)x];
            rgb[3 * x + i] = e[x] ? (float)(unit * (mantissa + 0.5)) : 0.0f;
        }
    }
}

static enum pel_err read_rows(FILE *f, struct pel_equirect *out,
                              struct pel_fault *fault)
{
    size_t columns = (size_t)out->file_columns;
    uint8_t *planes = malloc(4 * columns);
    float *rgb = malloc(3 * columns * sizeof *rgb);
    enum pel_err err = PEL_OK;
    if (!planes || !rgb) {
        err = pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    for (int row = 0; row < out->file_rows && !err; row++) {
        if (!read_row(f, planes, out->file_columns)) {
            err = bad(fault, "is cut short, or its runs are wrong");
            break;
        }
        decode(planes, out->file_columns, rgb);
        pel_equirect_add(out, row, rgb);
    }
    free(planes);
    free(rgb);
    return err;
}

enum pel_err pel_equirect_read_radiance(const char *path,
                                        struct pel_equirect *out,
                                        struct pel_fault *fault)
{
    char line[256], end;
    int columns, rows;
    FILE *f = fopen(path, "rb");
    if (!f) {
        return pel_fault_set(fault, PEL_ERR_IO, "it cannot be opened");
    }
    enum pel_err err = read_head(f, line, fault);
    if (!err && (sscanf(line, "-Y %6d +X %6d%c", &rows, &columns, &end) != 3 ||
                 (end != '\n' && end != '\r'))) {
        err = bad(fault, "is not of the order -Y +X");
    }
    if (!err) {
        err = pel_equirect_begin(out, columns, rows, fault);
    }
    if (!err) {
        err = read_rows(f, out, fault);
    }
    fclose(f);
    return err;
}
