/* Writes what ocean/netcdffile.c describes on standard input as a file of
 * NetCDF's 64-bit offset format to standard output, all in memory. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <netcdf.h>
#include <netcdf_mem.h>

#include "ocean/netcdffile.h"
#include "ocean/reader/shelf.h"

#define MOST_TEXT ((uint64_t)1 << 24)

static char *input, *at, *end;

/* False: it ends too early. */
static bool take(void *out, size_t size)
{
    if ((size_t)(end - at) < size) {
        return false;
    }
    memcpy(out, at, size);
    at += size;
    return true;
}

static bool take_i32(int *out)
{
    int32_t v = 0;
    bool there = take(&v, sizeof v);
    *out = v;
    return there;
}

/* With a 0 after it; free(). */
static char *take_text(void)
{
    uint64_t length = 0;
    if (!take(&length, sizeof length) || length > MOST_TEXT) {
        return NULL;
    }
    char *text = calloc(1, length + 1);
    if (text && !take(text, length)) {
        free(text);
        text = NULL;
    }
    return text;
}

static nc_type type_of(int letter)
{
    return letter == PEL_NETCDF_DOUBLE  ? NC_DOUBLE
           : letter == PEL_NETCDF_FLOAT ? NC_FLOAT
           : letter == PEL_NETCDF_INT   ? NC_INT
                                        : NC_CHAR;
}

static int dimension(int id)
{
    char *name = take_text();
    uint64_t size = 0;
    int unused, status = NC_EINVAL;
    if (name && take(&size, sizeof size)) {
        status = nc_def_dim(id, name, size, &unused);
    }
    free(name);
    return status;
}

static int variable(int id)
{
    char *name = take_text();
    int type, rank, dims[PEL_NETCDF_RANK], unused, status = NC_EINVAL;
    bool whole = name && take_i32(&type) && take_i32(&rank) && rank >= 0 &&
                 rank <= PEL_NETCDF_RANK;
    for (int i = 0; whole && i < rank; i++) {
        whole = take_i32(&dims[i]);
    }
    if (whole) {
        status = nc_def_var(id, name, type_of(type), rank, dims, &unused);
    }
    free(name);
    return status;
}

static int attribute(int id, bool text)
{
    int var = NC_GLOBAL, status = NC_EINVAL;
    char *name = take_i32(&var) ? take_text() : NULL;
    if (name && text) {
        char *value = take_text();
        status = value ? nc_put_att_text(id, var, name, strlen(value), value)
                       : status;
        free(value);
    } else if (name) {
        double value;
        nc_type type = NC_DOUBLE;
        if (take(&value, sizeof value) &&
            (var == NC_GLOBAL || nc_inq_vartype(id, var, &type) == 0)) {
            status = nc_put_att_double(id, var, name, type, 1, &value);
        }
    }
    free(name);
    return status;
}

static int values(int id, bool chars)
{
    int var, status = NC_EINVAL;
    uint64_t count = 0;
    size_t each = chars ? 1 : sizeof(double);
    if (!take_i32(&var) || !take(&count, sizeof count) ||
        count > (uint64_t)(end - at) / each) {
        return status;
    }
    void *copy = malloc(count * each + 1); /* aligned */
    if (copy && take(copy, count * each)) {
        status = chars ? nc_put_var_text(id, var, copy)
                       : nc_put_var_double(id, var, copy);
    }
    free(copy);
    return status;
}

static int obey(int id)
{
    int status = NC_NOERR;
    while (at < end && status == NC_NOERR) {
        char letter = *at++;
        status = letter == 'D'   ? dimension(id)
                 : letter == 'V' ? variable(id)
                 : letter == 'T' ? attribute(id, true)
                 : letter == 'N' ? attribute(id, false)
                 : letter == 'E' ? nc_enddef(id)
                 : letter == 'F' ? values(id, false)
                 : letter == 'C' ? values(id, true)
                                 : NC_EINVAL;
    }
    return status;
}

static bool read_input(void)
{
    size_t size = 0, room = 1 << 20;
    input = malloc(room);
    while (input) {
        ssize_t got = read(STDIN_FILENO, input + size, room - size);
        if (got <= 0) {
            at = input;
            end = input + size;
            return got == 0;
        }
        size += (size_t)got;
        if (size == room) {
            char *more = realloc(input, room *= 2);
            if (!more) {
                free(input);
            }
            input = more;
        }
    }
    return false;
}

enum pel_err pel_write_netcdf(struct pel_fault *fault)
{
    int id;
    NC_memio out = { 0 };
    if (!read_input()) {
        return pel_fault_set(fault, PEL_ERR_IO, "its description is not whole");
    }
    int status = nc_create_mem("memory", NC_64BIT_OFFSET, 0, &id);
    if (status == NC_NOERR) {
        status = obey(id);
    }
    if (status == NC_NOERR) {
        status = nc_close_memio(id, &out);
    }
    if (status != NC_NOERR) {
        return pel_fault_set(fault, PEL_ERR_INVALID, "libnetcdf: %s",
                             nc_strerror(status));
    }
    return fwrite(out.memory, 1, out.size, stdout) == out.size &&
                   fflush(stdout) == 0
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_IO, "it cannot be written");
}
