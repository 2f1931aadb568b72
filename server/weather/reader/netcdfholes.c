/* NetCDF's numbers: their scale, and those that stand for no value. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "weather/reader/netcdffile.h"

#define FEW 3 /* nodes that have one number by chance */

static bool default_fill(nc_type type, double *out)
{
    switch (type) {
    case NC_SHORT:
        *out = NC_FILL_SHORT;
        return true;
    case NC_INT:
        *out = NC_FILL_INT;
        return true;
    case NC_FLOAT:
        *out = NC_FILL_FLOAT;
        return true;
    case NC_DOUBLE:
        *out = NC_FILL_DOUBLE;
        return true;
    case NC_INT64:
        *out = (double)NC_FILL_INT64;
        return true;
    default:
        return false; /* of bytes every value is one */
    }
}

static bool is_whole(nc_type type)
{
    return type != NC_FLOAT && type != NC_DOUBLE;
}

/* Numbers that a type has at its ends, and that packed data seldom have. */
static void find_ends(nc_type type, bool is_unsigned, double out[2])
{
    double size = type == NC_SHORT || type == NC_USHORT ? 65536
                  : type == NC_INT || type == NC_UINT   ? 4294967296.0
                                                        : NAN;
    is_unsigned = is_unsigned || type == NC_USHORT || type == NC_UINT;
    out[0] = is_unsigned ? NAN : -size / 2; /* 0 is nothing odd */
    out[1] = is_unsigned ? size - 1 : size / 2 - 1;
}

/* missing_value is of the packed numbers; files have it of values too. */
static void find_missing(int id, int variable, struct pel_netcdf_holes *h)
{
    double values[8];
    nc_type type = NC_NAT;
    size_t count = pel_netcdf_numbers(id, variable, "missing_value", 8, values);
    bool other = !nc_inq_atttype(id, variable, "missing_value", &type) &&
                 is_whole(h->type) &&
                 (!is_whole(type) || type >= NC_STRING || type == NC_CHAR);
    for (size_t i = 0; i < count; i++) {
        double v = values[i];
        if (!other || (v == rint(v) && fabs(v) >= 999)) {
            h->values[h->count++] = v;
        }
        if (other) {
            h->unpacked[h->unpacked_count++] = v;
        }
    }
    h->told = h->told || count > 0;
}

static void find_range(int id, int variable, struct pel_netcdf_holes *h)
{
    double range[2];
    nc_type type = NC_NAT;
    (void)pel_netcdf_numbers(id, variable, "valid_min", 1, &h->least);
    (void)pel_netcdf_numbers(id, variable, "valid_max", 1, &h->most);
    if (pel_netcdf_numbers(id, variable, "valid_range", 2, range) == 2) {
        h->least = range[0];
        h->most = range[1];
    }
    bool told = !nc_inq_atttype(id, variable, "valid_range", &type) ||
                !nc_inq_atttype(id, variable, "valid_min", &type) ||
                !nc_inq_atttype(id, variable, "valid_max", &type);
    h->scaled =
        told && is_whole(h->type) && (type == NC_FLOAT || type == NC_DOUBLE);
    h->told = h->told || told;
}

void pel_netcdf_find_holes(int id, int variable, nc_type type,
                           struct pel_netcdf_holes *h)
{
    char word[16];
    *h = (struct pel_netcdf_holes){
        .type = type, .scale = 1, .least = -INFINITY, .most = INFINITY
    };
    h->count = pel_netcdf_numbers(id, variable, "_FillValue", 8, h->values);
    h->told = h->count > 0;
    if (h->count == 0 && default_fill(type, &h->values[0])) {
        h->count = 1;
    }
    (void)pel_netcdf_numbers(id, variable, "scale_factor", 1, &h->scale);
    (void)pel_netcdf_numbers(id, variable, "add_offset", 1, &h->offset);
    find_missing(id, variable, h);
    find_range(id, variable, h);
    bool is_unsigned =
        pel_netcdf_text(id, variable, "_Unsigned", word, sizeof word) &&
        strcasecmp(word, "true") == 0;
    h->wrap = !is_unsigned       ? 0
              : type == NC_BYTE  ? 256
              : type == NC_SHORT ? 65536
              : type == NC_INT   ? 4294967296.0
                                 : 0;
    for (size_t i = 0; i < h->count; i++) {
        h->values[i] += h->values[i] < 0 ? h->wrap : 0;
    }
    find_ends(type, is_unsigned, h->ends);
}

double pel_netcdf_value(struct pel_netcdf_holes *h, double raw)
{
    bool single = h->type == NC_FLOAT;
    raw += raw < 0 ? h->wrap : 0;
    double v = raw * h->scale + h->offset;
    double judged = h->scaled ? v : raw;
    bool none = !isfinite(v) || judged < h->least || judged > h->most;
    for (size_t i = 0; i < h->count; i++) {
        double hole = h->values[i];
        none = none || raw == hole || (single && (float)raw == (float)hole) ||
               (h->scale != 1 && fabs(v - hole) < 1e-9 * fabs(hole) &&
                fabs(hole) > 1e3);
    }
    for (size_t i = 0; i < h->unpacked_count; i++) {
        none = none || fabs(v - h->unpacked[i]) <= 0.5 * fabs(h->scale);
    }
    h->at_end[0] += !none && raw == h->ends[0];
    h->at_end[1] += !none && raw == h->ends[1];
    return none ? NAN : v;
}

void pel_netcdf_declare(const struct pel_netcdf_holes *h, const char *name,
                        double value, char out[112])
{
    double raw = (value - h->offset) / h->scale;
    const char *type = h->type == NC_DOUBLE  ? "d"
                       : h->type == NC_FLOAT ? "f"
                       : h->type == NC_SHORT ? "s"
                       : h->type == NC_BYTE  ? "b"
                                             : "l";
    snprintf(out, 112, "ncatted -a missing_value,%.30s,o,%s,%.*g FILE", name,
             type, is_whole(h->type) ? 17 : 9,
             is_whole(h->type) ? rint(raw) : raw);
}

enum pel_err pel_netcdf_check_ends(const struct pel_netcdf_holes *h,
                                   const char *name, struct pel_fault *fault)
{
    char cure[112];
    for (int i = 0; !h->told && i < 2; i++) {
        if (h->at_end[i] >= FEW) {
            pel_netcdf_declare(h, name, h->ends[i] * h->scale + h->offset,
                               cure);
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "%.30s has %.0f, the end of its type, at %zu "
                                 "nodes, and declares no fill value: if it is "
                                 "one %s",
                                 name, h->ends[i], h->at_end[i], cure);
        }
    }
    return PEL_OK;
}
