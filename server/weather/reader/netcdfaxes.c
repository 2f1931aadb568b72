/* Axes of NetCDF files: CF's conventions, and names where files lack them. */
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "weather/reader/netcdffile.h"

bool pel_netcdf_text(int id, int variable, const char *name, char *out,
                     size_t size)
{
    nc_type type = NC_NAT;
    size_t length = 0;
    char *string = NULL;
    *out = '\0';
    if (nc_inq_att(id, variable, name, &type, &length) || length == 0 ||
        length > 4096) {
        return false;
    }
    if (type == NC_STRING && length == 1) {
        if (nc_get_att_string(id, variable, name, &string) || !string) {
            return false;
        }
        snprintf(out, size, "%s", string + strspn(string, " "));
    } else if (type == NC_CHAR) {
        char *text = calloc(length + 1, 1);
        if (!text || nc_get_att_text(id, variable, name, text)) {
            free(text);
            return false;
        }
        snprintf(out, size, "%s", text + strspn(text, " "));
        free(text);
    }
    for (size_t n = strlen(out); n > 0 && out[n - 1] == ' '; n--) {
        out[n - 1] = '\0';
    }
    return *out != '\0';
}

size_t pel_netcdf_numbers(int id, int variable, const char *name, size_t most,
                          double *out)
{
    nc_type type = NC_NAT;
    size_t length = 0;
    char text[40], *end = text;
    bool has = !nc_inq_att(id, variable, name, &type, &length);
    if (has && most > 0 && (type == NC_CHAR || type == NC_STRING) &&
        pel_netcdf_text(id, variable, name, text, sizeof text)) {
        out[0] = strtod(text, &end);
        return end > text && *end == '\0' ? 1 : 0;
    }
    bool fine = has && length > 0 && length <= most && type != NC_CHAR &&
                type <= NC_UINT64 &&
                !nc_get_att_double(id, variable, name, out);
    return fine ? length : 0;
}

static bool among(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = list; length > 0 && *at; at++) {
        if (*at == ' ' && strncasecmp(at + 1, word, length) == 0 &&
            at[1 + length] == ' ') {
            return true;
        }
    }
    return false;
}

static const struct {
    enum pel_netcdf_role role;
    const char *standards, *units, *names; /* each between blanks */
} roles[] = {
    { PEL_NETCDF_ROTATED,
      " grid_latitude grid_longitude projection_x_coordinate "
      "projection_y_coordinate ",
      "", " rlat rlon " },
    { PEL_NETCDF_LATITUDE, " latitude ",
      " degrees_north degree_north degree_n degrees_n degreen degreesn ",
      " lat latitude lats latitudes nav_lat " },
    { PEL_NETCDF_LONGITUDE, " longitude ",
      " degrees_east degree_east degree_e degrees_e degreee degreese ",
      " lon longitude long lons longitudes nav_lon " },
    { PEL_NETCDF_RUN, " forecast_reference_time ", "",
      " reftime forecast_reference_time initial_time analysis_time " },
    { PEL_NETCDF_STEP, " forecast_period ", "",
      " step lead leadtime lead_time forecast_period forecast_hour "
      "prediction_timedelta " },
    { PEL_NETCDF_TIME, " time ", "", " time valid_time " },
    { PEL_NETCDF_MEMBER, " realization ", "",
      " number member members ensemble ens realization realisation "
      "ensemble_member ensemblemember " },
    { PEL_NETCDF_EXPVER, "", "", " expver " },
    { PEL_NETCDF_SEQUENCE, "", "",
      " orderedsequencedata ordered_sequence_of_data partition npart "
      "swell_partition " },
    { PEL_NETCDF_HEIGHT,
      " height height_above_mean_sea_level altitude air_pressure "
      "height_above_reference_ellipsoid depth model_level_number "
      "atmosphere_hybrid_sigma_pressure_coordinate "
      "atmosphere_sigma_coordinate ",
      " pa hpa millibar mbar mb ",
      " height heightaboveground height_above_ground z lev level plev levels "
      "isobaricinhpa isobaric pressure_level pressure altitude depth surface "
      "hybrid sigma " },
};

enum pel_netcdf_role pel_netcdf_role_of(int id, int variable)
{
    char standard[128], units[128], axis[8], name[NC_MAX_NAME + 1] = "";
    pel_netcdf_text(id, variable, "standard_name", standard, sizeof standard);
    pel_netcdf_text(id, variable, "units", units, sizeof units);
    pel_netcdf_text(id, variable, "axis", axis, sizeof axis);
    (void)nc_inq_varname(id, variable, name);
    for (size_t n = strlen(name); n > 1 && isdigit((unsigned char)name[n - 1]);
         n--) {
        name[n - 1] = '\0'; /* "time1", "height_above_ground2" */
    }
    bool since = strstr(units, " since ") != NULL;
    for (size_t i = 0; i < sizeof roles / sizeof *roles; i++) {
        if (among(roles[i].standards, standard)) {
            return roles[i].role;
        }
    }
    for (size_t i = 0; i < sizeof roles / sizeof *roles; i++) {
        if (among(roles[i].units, units)) {
            return roles[i].role;
        }
    }
    for (size_t i = 0; i < sizeof roles / sizeof *roles; i++) {
        if (among(roles[i].names, name)) {
            return roles[i].role;
        }
    }
    bool vertical = strcasecmp(axis, "Z") == 0 ||
                    !nc_inq_attlen(id, variable, "positive", &(size_t){ 0 });
    return since                        ? PEL_NETCDF_TIME
           : strcasecmp(axis, "T") == 0 ? PEL_NETCDF_TIME
           : strcasecmp(axis, "E") == 0 ? PEL_NETCDF_MEMBER
           : vertical                   ? PEL_NETCDF_HEIGHT
                                        : PEL_NETCDF_UNKNOWN;
}

/* Texts of numbers, as the ECMWF's expver is. */
static bool read_texts(int id, int variable, size_t count, double *out)
{
    char **texts = calloc(count, sizeof *texts);
    bool fine = texts && !nc_get_var_string(id, variable, texts);
    for (size_t i = 0; fine && i < count; i++) {
        out[i] = texts[i] ? strtod(texts[i], NULL) : 0;
    }
    if (fine) {
        (void)nc_free_string(count, texts);
    }
    free(texts);
    return fine;
}

static enum pel_err convert(int id, int variable, enum pel_netcdf_role role,
                            size_t count, double *v, struct pel_fault *fault)
{
    char units[128], calendar[64], name[NC_MAX_NAME + 1] = "";
    double factor = 1;
    pel_netcdf_text(id, variable, "units", units, sizeof units);
    pel_netcdf_text(id, variable, "calendar", calendar, sizeof calendar);
    (void)nc_inq_varname(id, variable, name);
    switch (role) {
    case PEL_NETCDF_TIME:
    case PEL_NETCDF_RUN:
        for (size_t i = 0; i < count; i++) {
            enum pel_err err = pel_cf_time(units, calendar, v[i], &v[i], fault);
            if (err) {
                return err;
            }
        }
        return PEL_OK;
    case PEL_NETCDF_STEP:
        factor = pel_cf_unit_s(units, strlen(units));
        if (!(factor > 0)) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "its steps (%.40s) are in \"%.60s\", which is "
                                 "no unit of time",
                                 name, units);
        }
        break;
    case PEL_NETCDF_LATITUDE:
    case PEL_NETCDF_LONGITUDE:
        if (*units && !strstr(units, "north") && !strstr(units, "east") &&
            strncasecmp(units, "degree", 6) != 0 &&
            !pel_cf_unit(units, PEL_CF_DEG, &factor)) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "its %.40s is in \"%.60s\", which is no unit "
                                 "of degrees",
                                 name, units);
        }
        break;
    case PEL_NETCDF_HEIGHT:
        (void)pel_cf_unit(units, PEL_CF_M, &factor);
        break;
    default:
        break;
    }
    for (size_t i = 0; i < count; i++) {
        v[i] *= factor;
    }
    return PEL_OK;
}

enum pel_err pel_netcdf_coordinates(int id, int variable,
                                    enum pel_netcdf_role role, size_t count,
                                    double *out, struct pel_fault *fault)
{
    char name[NC_MAX_NAME + 1] = "";
    nc_type type = NC_NAT;
    double scale = 1, offset = 0;
    (void)nc_inq_varname(id, variable, name);
    (void)nc_inq_vartype(id, variable, &type);
    bool fine = type == NC_STRING
                    ? read_texts(id, variable, count, out)
                    : type != NC_CHAR && !nc_get_var_double(id, variable, out);
    if (!fine) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "its coordinates %.60s cannot be read", name);
    }
    (void)pel_netcdf_numbers(id, variable, "scale_factor", 1, &scale);
    (void)pel_netcdf_numbers(id, variable, "add_offset", 1, &offset);
    for (size_t i = 0; i < count; i++) {
        out[i] = out[i] * scale + offset;
    }
    return convert(id, variable, role, count, out, fault);
}

/* Whether the variable lies along this dimension alone. */
static bool is_along(int id, int variable, int dimension)
{
    int rank = 0, of[NC_MAX_VAR_DIMS];
    return !nc_inq_varndims(id, variable, &rank) && rank == 1 &&
           !nc_inq_vardimid(id, variable, of) && of[0] == dimension;
}

/* The variable of a dimension's coordinates: a valid time along it, that of its
 * name, or another that is of place or time. */
static void find_coordinates(int id, int dimension, struct pel_netcdf_axis *out)
{
    static const char valid[] = "valid_time";
    const char *const names[] = { valid, out->name };
    int count = 0, v = -1;
    for (size_t i = 0; i < 2; i++) {
        if (!nc_inq_varid(id, names[i], &v) && is_along(id, v, dimension)) {
            out->variable = v;
            out->role = pel_netcdf_role_of(id, v);
            if (out->role != PEL_NETCDF_UNKNOWN) {
                return;
            }
        }
    }
    (void)nc_inq_nvars(id, &count);
    for (v = 0; v < count; v++) {
        enum pel_netcdf_role role = pel_netcdf_role_of(id, v);
        if (role >= PEL_NETCDF_LATITUDE && role <= PEL_NETCDF_STEP &&
            is_along(id, v, dimension)) {
            out->variable = v;
            out->role = role;
            return;
        }
    }
}

bool pel_netcdf_metres(int id, int variable, char unit[24])
{
    double factor;
    char name[NC_MAX_NAME + 1] = "", standard[64], positive[8];
    bool told = pel_netcdf_text(id, variable, "units", unit, 24);
    bool metres = told && pel_cf_unit(unit, PEL_CF_M, &factor);
    (void)nc_inq_varname(id, variable, name);
    pel_netcdf_text(id, variable, "standard_name", standard, sizeof standard);
    pel_netcdf_text(id, variable, "positive", positive, sizeof positive);
    if (!told) { /* levels of pressure and of models have numbers too */
        const char *by = *standard ? standard : name;
        metres = strncasecmp(by, "height", 6) == 0 ||
                 strcasecmp(by, "altitude") == 0 || strcasecmp(by, "z") == 0;
        snprintf(unit, 24, "without units");
    }
    bool down = metres && (strcasecmp(positive, "down") == 0 ||
                           strncasecmp(standard, "depth", 5) == 0 ||
                           strcasecmp(name, "depth") == 0);
    if (metres) {
        snprintf(unit, 24, down ? "m down" : "m");
    }
    return metres && !down;
}

enum pel_err pel_netcdf_axis_of(int id, int dimension,
                                struct pel_netcdf_axis *out,
                                struct pel_fault *fault)
{
    *out = (struct pel_netcdf_axis){ .variable = -1 };
    if (nc_inq_dim(id, dimension, out->name, &out->count)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "a dimension cannot be read");
    }
    find_coordinates(id, dimension, out);
    if (out->variable < 0) {
        return PEL_OK;
    }
    if (out->count == 0 || out->count > 1000000) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "its dimension %.60s has %zu coordinates",
                             out->name, out->count);
    }
    if (out->role == PEL_NETCDF_HEIGHT) {
        out->metres = pel_netcdf_metres(id, out->variable, out->unit);
    }
    out->values = calloc(out->count, sizeof *out->values);
    return out->values
               ? pel_netcdf_coordinates(id, out->variable, out->role,
                                        out->count, out->values, fault)
               : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
}

int pel_netcdf_scalar(int id, enum pel_netcdf_role role)
{
    int count = 0, rank = 0;
    (void)nc_inq_nvars(id, &count);
    for (int v = 0; v < count; v++) {
        if (!nc_inq_varndims(id, v, &rank) && rank == 0 &&
            pel_netcdf_role_of(id, v) == role) {
            return v;
        }
    }
    return -1;
}
