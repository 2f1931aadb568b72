/* A series as NetCDF by the CF conventions 1.10. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <glib.h>

#include "net/series_parts.h"
#include "ocean/netcdffile.h"

/* The row's standard name and text; NULL: there is no row. */
static const char *const *row_of(const ProtobufCMessageDescriptor *message,
                                 const ProtobufCFieldDescriptor *field)
{
    static const char *const rows[][4] = {
#define PEL_CF(message, field, name, text) { message, field, name, text },
#include "proto/cf.def"
    };
    const char *own = pel_field_info(message, field)->name;
    for (size_t i = 0; i < G_N_ELEMENTS(rows); i++) {
        if (strcmp(rows[i][0], message->short_name) == 0 &&
            strcmp(rows[i][1], own) == 0) {
            return &rows[i][2];
        }
    }
    return NULL;
}

const char *pel_cf_name(const ProtobufCMessageDescriptor *message,
                        const ProtobufCFieldDescriptor *field)
{
    const char *const *row = row_of(message, field);
    return row ? row[0] : NULL;
}

const char *pel_cf_text(const ProtobufCMessageDescriptor *message,
                        const ProtobufCFieldDescriptor *field)
{
    const char *const *row = row_of(message, field);
    const char *doc = pel_field_info(message, field)->doc;
    return row && *row[1] ? row[1] : doc ? doc : "";
}

/* As UDUNITS writes it. */
static const char *unit_of(const Pelagos__SeriesList *list, const char *since,
                           char out[80])
{
    if (list->standard_name && strcmp(list->standard_name, "time") == 0) {
        g_snprintf(out, 80, "seconds since %s", since);
    } else {
        g_snprintf(out, 80, "%s",
                   strcmp(list->unit, "deg") == 0 ? "degree" : list->unit);
    }
    return out;
}

static void describe(struct pel_netcdf *nc, int var,
                     const Pelagos__SeriesList *list, const char *since)
{
    char unit[80];
    pel_netcdf_text(nc, var, "units", unit_of(list, since, unit));
    if (*list->text) {
        pel_netcdf_text(nc, var, "long_name", list->text);
    }
    if (list->standard_name) {
        pel_netcdf_text(nc, var, "standard_name", list->standard_name);
    }
    if (g_str_has_prefix(unit, "seconds since")) {
        pel_netcdf_text(nc, var, "calendar", "standard");
    }
}

#define MAPPING "crs"

/* Names the plane that the points' metres lie in: CF's azimuthal equidistant
 * mapping about the scene's origin, on WGS 84 (scene/geodesy.h). */
static void put_mapping(struct pel_netcdf *nc, const Pelagos__State *state)
{
    const Pelagos__Origin *o = state->origin;
    static const struct {
        const char *name;
        double value;
    } wgs84[] = {
        { "false_easting", 0 },
        { "false_northing", 0 },
        { "semi_major_axis", 6378137 },
        { "inverse_flattening", 298.257223563 },
        { "longitude_of_prime_meridian", 0 },
    };
    int var = pel_netcdf_variable(nc, MAPPING, PEL_NETCDF_DOUBLE, 0, NULL);
    pel_netcdf_text(nc, var, "long_name", "Map about the scene's origin");
    pel_netcdf_text(nc, var, "units", "1");
    pel_netcdf_text(nc, var, "grid_mapping_name", "azimuthal_equidistant");
    pel_netcdf_number(nc, var, "latitude_of_projection_origin", o->latitude);
    pel_netcdf_number(nc, var, "longitude_of_projection_origin", o->longitude);
    for (size_t i = 0; i < G_N_ELEMENTS(wgs84); i++) {
        pel_netcdf_number(nc, var, wgs84[i].name, wgs84[i].value);
    }
    pel_netcdf_text(nc, var, "horizontal_datum_name", "WGS_1984");
    const double none = 0;
    pel_netcdf_values(nc, var, &none, 1);
}

/* Whether points lie about one origin. */
static bool is_mapped(const Pelagos__Series *s, const Pelagos__State *state)
{
    bool points = false, moved = !state || !state->origin;
    for (size_t i = 0; i < s->n_axes; i++) {
        const char *name = s->axes[i]->name;
        points |= strcmp(name, "point") == 0;
        moved |=
            strcmp(name, "latitude") == 0 || strcmp(name, "longitude") == 0;
    }
    return points && !moved;
}

static void put_variable(struct pel_netcdf *nc, const Pelagos__Series *s,
                         const Pelagos__SeriesList *list, const char *since,
                         bool mapped)
{
    int dims[PEL_NETCDF_RANK], rank = 0;
    bool points = false;
    for (size_t k = 0; k < list->n_axes; k++) {
        for (size_t i = 0; i < s->n_axes; i++) {
            if (strcmp(s->axes[i]->name, list->axes[k]) == 0) {
                dims[rank++] = (int)i;
            }
        }
        points = points || strcmp(list->axes[k], "point") == 0;
    }
    int var =
        pel_netcdf_variable(nc, list->name, PEL_NETCDF_DOUBLE, rank, dims);
    describe(nc, var, list, since);
    pel_netcdf_number(nc, var, "_FillValue", NAN);
    if (points && strcmp(list->name, "east") != 0 &&
        strcmp(list->name, "north") != 0) {
        pel_netcdf_text(nc, var, "coordinates", "east north");
        if (mapped) {
            pel_netcdf_text(nc, var, "grid_mapping", MAPPING);
        }
    }
    pel_netcdf_values(nc, var, list->values, list->n_values);
}

enum pel_err pel_series_netcdf(const Pelagos__Series *series,
                               const struct pel_series_origin *origin,
                               unsigned char **out, size_t *size,
                               struct pel_fault *fault)
{
    const double epoch_unix_s = origin->epoch_unix_s;
    const bool mapped = is_mapped(series, origin->state);
    struct pel_netcdf *nc = pel_netcdf_create();
    if (!nc) {
        return pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    g_autoptr(GDateTime) epoch =
        g_date_time_new_from_unix_utc((gint64)floor(epoch_unix_s));
    g_autofree char *since =
        epoch ? g_date_time_format(epoch, "%Y-%m-%d %H:%M:%S") : NULL;
    char seconds[48]; /* with what is less than a second */
    g_snprintf(seconds, sizeof seconds, "%s.%03d UTC",
               since ? since : "1970-01-01 00:00:00",
               (int)((epoch_unix_s - floor(epoch_unix_s)) * 1e3));
    for (size_t i = 0; i < series->n_axes; i++) {
        pel_netcdf_dimension(nc, series->axes[i]->name,
                             series->axes[i]->n_values);
    }
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "Conventions", "CF-1.10");
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "title", series->title);
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "source", "pelagosd " PEL_VERSION);
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "history", series->history);
    pel_netcdf_text(nc, PEL_NETCDF_GLOBAL, "pelagos_state", series->state);
    for (size_t i = 0; i < series->n_axes; i++) {
        const Pelagos__SeriesList *axis = series->axes[i];
        const int dim = (int)i;
        int var =
            pel_netcdf_variable(nc, axis->name, PEL_NETCDF_DOUBLE, 1, &dim);
        describe(nc, var, axis, seconds);
        pel_netcdf_values(nc, var, axis->values, axis->n_values);
    }
    for (size_t i = 0; i < series->n_variables; i++) {
        put_variable(nc, series, series->variables[i], seconds, mapped);
    }
    if (mapped) {
        put_mapping(nc, origin->state);
    }
    return pel_netcdf_end(nc, out, size, fault);
}
