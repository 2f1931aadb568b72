#include "ocean/netcdffile.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/helper.h"

#define PROGRAM "pelagos-spectrum"

/* What the process is told, in the machine's own form: a letter, then
 *   D  name, u64 size             a dimension
 *   V  name, i32 type, i32 rank, i32[rank]   a variable
 *   T  i32 variable, name, text   an attribute
 *   N  i32 variable, name, f64    another
 *   E                             the end of the definitions; then values:
 *   F  i32 variable, u64 count, f64[count]
 *   C  i32 variable, u64 count, char[count]
 * Texts are u64 length and bytes. */
struct part {
    FILE *out;
    char *bytes;
    size_t size;
};

struct pel_netcdf {
    struct part definitions, values;
    int dimensions, variables;
};

static bool part_begin(struct part *part)
{
    part->out = open_memstream(&part->bytes, &part->size);
    return part->out != NULL;
}

/* False: not all of it is there. */
static bool part_end(struct part *part)
{
    bool whole = part->out && !ferror(part->out);
    return (!part->out || fclose(part->out) == 0) && whole;
}

struct pel_netcdf *pel_netcdf_create(void)
{
    struct pel_netcdf *nc = calloc(1, sizeof *nc);
    if (!nc) {
        return NULL;
    }
    if (!part_begin(&nc->definitions) || !part_begin(&nc->values)) {
        part_end(&nc->definitions);
        part_end(&nc->values);
        free(nc);
        return NULL;
    }
    return nc;
}

static void put_i32(FILE *out, int value)
{
    int32_t v = value;
    fwrite(&v, sizeof v, 1, out);
}

static void put_bytes(FILE *out, const void *bytes, size_t count, size_t each)
{
    uint64_t n = count;
    fwrite(&n, sizeof n, 1, out);
    fwrite(bytes, each, count, out);
}

static void put_text(FILE *out, const char *text)
{
    put_bytes(out, text, strlen(text), 1);
}

int pel_netcdf_dimension(struct pel_netcdf *nc, const char *name, size_t size)
{
    FILE *out = nc->definitions.out;
    uint64_t n = size;
    fputc('D', out);
    put_text(out, name);
    fwrite(&n, sizeof n, 1, out);
    return nc->dimensions++;
}

int pel_netcdf_variable(struct pel_netcdf *nc, const char *name,
                        enum pel_netcdf_type type, int rank, const int *dims)
{
    FILE *out = nc->definitions.out;
    fputc('V', out);
    put_text(out, name);
    put_i32(out, type);
    put_i32(out, rank);
    for (int i = 0; i < rank; i++) {
        put_i32(out, dims[i]);
    }
    return nc->variables++;
}

void pel_netcdf_text(struct pel_netcdf *nc, int var, const char *name,
                     const char *text)
{
    FILE *out = nc->definitions.out;
    fputc('T', out);
    put_i32(out, var);
    put_text(out, name);
    put_text(out, text);
}

void pel_netcdf_number(struct pel_netcdf *nc, int var, const char *name,
                       double value)
{
    FILE *out = nc->definitions.out;
    fputc('N', out);
    put_i32(out, var);
    put_text(out, name);
    fwrite(&value, sizeof value, 1, out);
}

void pel_netcdf_values(struct pel_netcdf *nc, int var, const double *values,
                       size_t count)
{
    FILE *out = nc->values.out;
    fputc('F', out);
    put_i32(out, var);
    put_bytes(out, values, count, sizeof *values);
}

void pel_netcdf_chars(struct pel_netcdf *nc, int var, const char *chars,
                      size_t count)
{
    FILE *out = nc->values.out;
    fputc('C', out);
    put_i32(out, var);
    put_bytes(out, chars, count, 1);
}

/* Both parts as one; false: no memory. */
static bool join(struct pel_netcdf *nc)
{
    fputc('E', nc->definitions.out);
    fflush(nc->values.out);
    fwrite(nc->values.bytes, 1, nc->values.size, nc->definitions.out);
    bool values = part_end(&nc->values);
    return part_end(&nc->definitions) && values;
}

enum pel_err pel_netcdf_end(struct pel_netcdf *nc, unsigned char **out,
                            size_t *size, struct pel_fault *fault)
{
    char *argv[] = { (char[]){ PROGRAM }, (char[]){ "--write" }, NULL };
    *out = NULL;
    *size = 0;
    enum pel_err err =
        join(nc) ? PEL_OK
                 : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    if (!err) {
        const struct pel_helper_task task = {
            .program = PROGRAM,
            .argv = argv,
            .subject = "the NetCDF file",
            .input = nc->definitions.bytes,
            .input_size = nc->definitions.size,
            .most_bytes = PEL_NETCDF_MOST_BYTES,
            .within_ms = PEL_NETCDF_WRITE_MS,
        };
        err = pel_helper_run(&task, out, size, fault);
    }
    free(nc->definitions.bytes);
    free(nc->values.bytes);
    free(nc);
    return err;
}
