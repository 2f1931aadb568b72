/* NetCDF by libnetcdf: which variables are wind and waves of the sea, where
 * their axes and units say what they are. */
#include "weather/reader/netcdffile.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define MOST_VARIABLES 64 /* of ours in a file */

/* A variable of ours. */
struct variable {
    int id;
    char name[NC_MAX_NAME + 1];
    nc_type type;
    int rank;
    struct pel_netcdf_axis axes[PEL_NETCDF_MOST_RANK];
    size_t fixed[PEL_NETCDF_MOST_RANK]; /* where on axes that time is not of */
    int latitude, longitude, version;   /* axes; version: -1 is none */
    double factor; /* from its unit to that of its quantity */
};

struct set {
    int id;
    bool opened;
    struct variable variables[MOST_VARIABLES];
    size_t count;
};

/* --- what a variable is -----------------------------------------------------
 */

/* Finds the number that a variable holds; "…to" in its title without a
 * standard_name is no direction that can be trusted. */
static bool kind_of(struct pel_forecast_file *file, const struct set *s,
                    const struct variable *v, struct pel_forecast_kind *kind)
{
    char standard[160], why[96];
    struct pel_forecast_name name = { .variable = v->name,
                                      .parameter = { -1, -1, -1 } };
    struct pel_forecast_kind plain;
    pel_netcdf_text(s->id, v->id, "standard_name", standard, sizeof standard);
    if (*standard && strcmp(standard, "unknown") != 0) {
        name.standard = standard;
    }
    if (!pel_forecast_kind_of(&name, kind)) {
        name.standard = NULL;
        if (pel_forecast_kind_of(&name, &plain)) {
            pel_forecast_words_add(&file->unread, "%.40s (standard_name %.80s)",
                                   v->name, standard);
        } else if (strncmp(standard, "sea_surface_w", 13) == 0 ||
                   strncmp(standard, "sea_surface_s", 13) == 0) {
            pel_forecast_words_add(&file->unread, "%.40s", v->name);
        }
        return false;
    }
    if (pel_netcdf_other_product(s->id, v->id, kind, why)) {
        pel_forecast_words_add(&file->unread, "%.40s (%s)", v->name, why);
        return false;
    }
    return true;
}

static enum pel_err take_unit(struct pel_forecast_file *file,
                              const struct set *s, struct variable *v,
                              const struct pel_forecast_kind *kind,
                              struct pel_fault *fault)
{
    static const char *const ours[] = { [PEL_CF_MPS] = "m s-1",
                                        [PEL_CF_M] = "m",
                                        [PEL_CF_S] = "s",
                                        [PEL_CF_HZ] = "Hz",
                                        [PEL_CF_DEG] = "degree" };
    char units[80];
    v->factor = 1;
    if (!pel_netcdf_text(s->id, v->id, "units", units, sizeof units)) {
        pel_forecast_note(file, "%.40s has no units: %s is taken", v->name,
                          ours[kind->quantity]);
    } else if (!pel_cf_unit(units, kind->quantity, &v->factor)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.40s is in \"%.40s\", which is not read for it: "
                             "convert it, or set what it is in, as by "
                             "ncatted -a units,%.40s,o,c,\"%s\" FILE",
                             v->name, units, v->name, ours[kind->quantity]);
    }
    return PEL_OK;
}

/* --- where it lies ----------------------------------------------------------
 */

static void list_values(const struct pel_netcdf_axis *a, char out[64])
{
    size_t length = 0;
    *out = '\0';
    for (size_t i = 0; a->values && i < a->count && length < 40; i++) {
        length += (size_t)snprintf(out + length, 64 - length, "%s%.6g",
                                   i ? ", " : "", a->values[i]);
    }
    if (a->values && *a->unit) {
        snprintf(out + length, 64 - length, " %s", a->unit);
    }
    if (!a->values) {
        snprintf(out, 64, "%zu without coordinates", a->count);
    }
}

/* Where on the axis its value is; -1: nowhere. */
static int find_value(const struct pel_netcdf_axis *a, double value)
{
    for (size_t i = 0; a->values && i < a->count && i < 100000; i++) {
        if (fabs(a->values[i] - value) < 1e-4) {
            return (int)i;
        }
    }
    return -1;
}

static enum pel_err refuse_axis(const struct variable *v, int i,
                                const char *wanted, struct pel_fault *fault)
{
    char values[64];
    const struct pel_netcdf_axis *a = &v->axes[i];
    list_values(a, values);
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "%.30s has %s along %.30s; there is: %s (one can be "
                         "taken by ncwa -a %.30s -d %.30s,I,I FILE OUT)",
                         v->name, wanted, a->name, values, a->name, a->name);
}

/* Coordinates by which a field is none of a run's own, nor of the sea's
 * surface. */
static bool is_statistic(const char *name)
{
    static const char *const words[] = { "quantile",  "percentile", "probab",
                                         "threshold", "statistic",  "theta",
                                         "layer",     "potential",  "levels" };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcasestr(name, words[i])) {
            return true;
        }
    }
    return false;
}

/* One value counts of an axis that is neither place nor time. */
static enum pel_err fix_axis(struct pel_forecast_file *file, struct variable *v,
                             int i, const struct pel_forecast_kind *kind,
                             struct pel_fault *fault)
{
    const struct pel_netcdf_axis *a = &v->axes[i];
    bool wind = kind->height == PEL_FORECAST_AT_10_M;
    int at = 0;
    const char *wanted = NULL;
    switch (a->role) {
    case PEL_NETCDF_MEMBER:
        at = find_value(a, 0);
        wanted = "no control member (0)";
        break;
    case PEL_NETCDF_HEIGHT:
        if (wind) {
            at = !a->metres ? -1 : find_value(a, 10);
            at = a->count == 1 && strcasecmp(a->name, "surface") == 0 ? 0 : at;
            wanted = "no height of 10 m";
        } else {
            at = a->count == 1 ? 0 : find_value(a, 0);
            wanted = "no one surface";
        }
        break;
    case PEL_NETCDF_SEQUENCE:
        at = kind->height == PEL_FORECAST_IN_SEQUENCE ? find_value(a, 1)
             : a->count == 1                          ? 0
                                                      : -1;
        wanted = "no first swell (1)";
        break;
    case PEL_NETCDF_EXPVER:
        v->version = i;
        break;
    default:
        at = a->count == 1 && !is_statistic(a->name) ? 0 : -1;
        wanted = "a dimension that is not known";
        if (at == 0 && a->values) {
            pel_forecast_note(file, "%.30s is taken at its one %.30s, %.6g",
                              v->name, a->name, a->values[0]);
        }
    }
    v->fixed[i] = at < 0 ? 0 : (size_t)at;
    return at < 0 ? refuse_axis(v, i, wanted, fault) : PEL_OK;
}

static enum pel_err refuse_place(const struct set *s, const struct variable *v,
                                 struct pel_fault *fault)
{
    char mapping[64] = "", by[80] = "", where[96] = "";
    int id;
    if (pel_netcdf_text(s->id, v->id, "grid_mapping", by, sizeof by) &&
        !nc_inq_varid(s->id, by, &id)) {
        pel_netcdf_text(s->id, id, "grid_mapping_name", mapping,
                        sizeof mapping);
    }
    pel_netcdf_text(s->id, v->id, "coordinates", by, sizeof by);
    snprintf(where, sizeof where, "%.40s%s%.40s", mapping,
             *mapping && *by ? ", " : "", by);
    return pel_fault_set(fault, PEL_ERR_INVALID,
                         "%.30s is not on equal steps of latitude and "
                         "longitude: %.30s, %.30s%s%s%s; bring it to them, as "
                         "by cdo remapbil,global_0.25 IN OUT",
                         v->name, v->rank > 1 ? v->axes[v->rank - 2].name : "",
                         v->rank > 0 ? v->axes[v->rank - 1].name : "",
                         *where ? " (" : "", where, *where ? ")" : "");
}

/* Whether its grid mapping is another than that of latitude and longitude,
 * whose names coordinates of any pole may have. */
static bool is_mapped(const struct set *s, const struct variable *v)
{
    char name[80];
    int id;
    return pel_netcdf_text(s->id, v->id, "grid_mapping", name, sizeof name) &&
           !nc_inq_varid(s->id, name, &id) &&
           pel_netcdf_text(s->id, id, "grid_mapping_name", name, sizeof name) &&
           strcasecmp(name, "latitude_longitude") != 0;
}

static bool is_climatology(const struct set *s, const struct pel_netcdf_axis *a)
{
    char name[80];
    return a->role == PEL_NETCDF_TIME && a->variable >= 0 &&
           pel_netcdf_text(s->id, a->variable, "climatology", name,
                           sizeof name);
}

static enum pel_err take_axes(struct pel_forecast_file *file,
                              const struct set *s, struct variable *v,
                              const struct pel_forecast_kind *kind,
                              struct pel_fault *fault)
{
    int of[NC_MAX_VAR_DIMS];
    enum pel_err err = PEL_OK;
    v->latitude = v->longitude = v->version = -1;
    if (v->rank > PEL_NETCDF_MOST_RANK || nc_inq_vardimid(s->id, v->id, of)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.60s has %d dimensions; at most %d", v->name,
                             v->rank, PEL_NETCDF_MOST_RANK);
    }
    for (int i = 0; !err && i < v->rank; i++) {
        struct pel_netcdf_axis *a = &v->axes[i];
        err = pel_netcdf_axis_of(s->id, of[i], a, fault);
        v->latitude = a->role == PEL_NETCDF_LATITUDE ? i : v->latitude;
        v->longitude = a->role == PEL_NETCDF_LONGITUDE ? i : v->longitude;
    }
    if (err) {
        return err;
    }
    if (v->latitude < 0 || v->longitude < 0 || is_mapped(s, v)) {
        return refuse_place(s, v, fault);
    }
    for (int i = 0; !err && i < v->rank; i++) {
        enum pel_netcdf_role role = v->axes[i].role;
        if (is_climatology(s, &v->axes[i])) {
            return pel_fault_set(fault, PEL_ERR_INVALID,
                                 "%.40s is a climatology by its %.40s; a run "
                                 "or an analysis is needed",
                                 v->name, v->axes[i].name);
        }
        if (role != PEL_NETCDF_LATITUDE && role != PEL_NETCDF_LONGITUDE &&
            role != PEL_NETCDF_TIME && role != PEL_NETCDF_RUN &&
            role != PEL_NETCDF_STEP) {
            err = fix_axis(file, v, i, kind, fault);
        }
    }
    return err;
}

/* Whether the word stands between blanks in the list. */
static bool lists(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = strstr(list, word); at; at = strstr(at + 1, word)) {
        if ((at == list || at[-1] == ' ') &&
            (at[length] == ' ' || at[length] == '\0')) {
            return true;
        }
    }
    return false;
}

/* Whether a coordinate without a dimension is this variable's: it says so, or
 * nobody does. */
static bool is_of(const struct set *s, const struct variable *v,
                  const char *name)
{
    char list[256];
    int count = 0;
    if (pel_netcdf_text(s->id, v->id, "coordinates", list, sizeof list)) {
        return lists(list, name);
    }
    if (pel_netcdf_height_told(s->id, v->id) > 0) {
        return false; /* it has told its own, and is here if that is 10 m */
    }
    (void)nc_inq_nvars(s->id, &count);
    for (int k = 0; k < count; k++) {
        pel_netcdf_text(s->id, k, "coordinates", list, sizeof list);
        if (lists(list, name)) {
            return false;
        }
    }
    return true;
}

/* Coordinates without a dimension: of a member, of a height. */
static enum pel_err check_scalar(const struct set *s, const struct variable *v,
                                 const struct pel_forecast_kind *kind, int k,
                                 struct pel_fault *fault)
{
    char name[NC_MAX_NAME + 1] = "", unit[24];
    double value = 0;
    enum pel_netcdf_role role = pel_netcdf_role_of(s->id, k);
    bool height = role == PEL_NETCDF_HEIGHT;
    (void)nc_inq_varname(s->id, k, name);
    bool counts = role == PEL_NETCDF_MEMBER ||
                  (height && kind->height == PEL_FORECAST_AT_10_M &&
                   strcasecmp(name, "surface") != 0 && is_of(s, v, name));
    if (is_statistic(name) && is_of(s, v, name)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.40s is of a %.40s, not a run's own: give a "
                             "file without it",
                             v->name, name);
    }
    if (!counts) {
        return PEL_OK;
    }
    bool metres = pel_netcdf_metres(s->id, k, unit);
    enum pel_err err = pel_netcdf_coordinates(s->id, k, role, 1, &value, fault);
    if (err || (height ? metres && fabs(value - 10) < 1e-3 : value == 0)) {
        return err;
    }
    return height ? pel_fault_set(fault, PEL_ERR_INVALID,
                                  "%.40s is at %.40s %g %s; wind 10 m above "
                                  "the sea is needed",
                                  v->name, name, value, unit)
                  : pel_fault_set(fault, PEL_ERR_INVALID,
                                  "%.40s is of ensemble member %g (%.40s); the "
                                  "control (0) or a single run is needed",
                                  v->name, value, name);
}

static enum pel_err check_scalars(const struct set *s, const struct variable *v,
                                  const struct pel_forecast_kind *kind,
                                  struct pel_fault *fault)
{
    int count = 0, rank = 0;
    enum pel_err err = PEL_OK;
    (void)nc_inq_nvars(s->id, &count);
    for (int k = 0; !err && k < count; k++) {
        if (!nc_inq_varndims(s->id, k, &rank) && rank == 0) {
            err = check_scalar(s, v, kind, k, fault);
        }
    }
    return err;
}

/* --- its times --------------------------------------------------------------
 */

static bool is_of_time(enum pel_netcdf_role role)
{
    return role == PEL_NETCDF_TIME || role == PEL_NETCDF_RUN ||
           role == PEL_NETCDF_STEP;
}

/* Where on each axis of time the part is: the last axis varies fastest. */
static void part_at(const struct variable *v, size_t part,
                    size_t at[PEL_NETCDF_MOST_RANK])
{
    for (int i = v->rank - 1; i >= 0; i--) {
        at[i] = v->fixed[i];
        if (is_of_time(v->axes[i].role)) {
            at[i] = part % v->axes[i].count;
            part /= v->axes[i].count;
        }
    }
}

static enum pel_err scalar_value(const struct set *s, enum pel_netcdf_role role,
                                 double *out, struct pel_fault *fault)
{
    int k = pel_netcdf_scalar(s->id, role);
    *out = NAN;
    return k < 0 ? PEL_OK
                 : pel_netcdf_coordinates(s->id, k, role, 1, out, fault);
}

static enum pel_err times_of(const struct set *s, const struct variable *v,
                             size_t part, const double scalar[3],
                             struct pel_forecast_slice *out,
                             struct pel_fault *fault)
{
    size_t at[PEL_NETCDF_MOST_RANK];
    double time = NAN, run = NAN, step = NAN;
    (void)s;
    part_at(v, part, at);
    for (int i = 0; i < v->rank; i++) {
        const struct pel_netcdf_axis *a = &v->axes[i];
        double value = a->values ? a->values[at[i]] : NAN;
        time = a->role == PEL_NETCDF_TIME ? value : time;
        run = a->role == PEL_NETCDF_RUN ? value : run;
        step = a->role == PEL_NETCDF_STEP ? value : step;
    }
    bool along_step = !isnan(step);
    if (along_step) { /* from a run, or from what is called time */
        run = !isnan(run)         ? run
              : !isnan(time)      ? time
              : !isnan(scalar[1]) ? scalar[1]
                                  : scalar[0];
        time = run + step;
    } else if (isnan(time) && !isnan(run)) {
        time = run + (isnan(scalar[2]) ? 0 : scalar[2]);
    } else if (isnan(time)) {
        time = !isnan(scalar[0])
                   ? scalar[0]
                   : scalar[1] + (isnan(scalar[2]) ? 0 : scalar[2]);
    }
    run = isnan(run) ? scalar[1] : run;
    out->unix_s = time;
    out->run_s = isnan(run) ? -PEL_CF_MOST_UNIX_S : run;
    return fabs(time) < PEL_CF_MOST_UNIX_S
               ? PEL_OK
               : pel_fault_set(fault, PEL_ERR_INVALID,
                               "%.40s has no time: NetCDF needs a variable "
                               "with units \"hours since 1970-01-01\" or the "
                               "like",
                               v->name);
}

static enum pel_err add_slices(struct pel_forecast_file *file, struct set *s,
                               const struct pel_forecast_kind *kind,
                               struct pel_fault *fault)
{
    const struct variable *v = &s->variables[s->count];
    const struct pel_netcdf_axis *y = &v->axes[v->latitude];
    const struct pel_netcdf_axis *x = &v->axes[v->longitude];
    struct pel_forecast_slice slice = { .kind = *kind, .place = s->count };
    double scalar[3];
    size_t parts = 1;
    snprintf(slice.label, sizeof slice.label, "%s", v->name);
    if (!y->values || !x->values ||
        !pel_forecast_axis_fit(y->values, y->count, false, &slice.y) ||
        !pel_forecast_axis_fit(x->values, x->count, true, &slice.x)) {
        return pel_fault_set(
            fault, PEL_ERR_INVALID,
            "%.30s: its grid has no equal steps of latitude and longitude "
            "(%.30s %zu, %.30s %zu): bring it to one, as by "
            "cdo remapbil,global_0.25 IN OUT",
            v->name, y->name, y->count, x->name, x->count);
    }
    enum pel_err err = scalar_value(s, PEL_NETCDF_TIME, &scalar[0], fault);
    err = err ? err : scalar_value(s, PEL_NETCDF_RUN, &scalar[1], fault);
    err = err ? err : scalar_value(s, PEL_NETCDF_STEP, &scalar[2], fault);
    for (int i = 0; i < v->rank; i++) {
        parts *= is_of_time(v->axes[i].role) ? v->axes[i].count : 1;
    }
    for (slice.part = 0; !err && slice.part < parts; slice.part++) {
        err = times_of(s, v, slice.part, scalar, &slice, fault);
        err = err ? err : pel_forecast_add(file, &slice, fault);
    }
    return err;
}

/* --- listing ----------------------------------------------------------------
 */

/* Beside wind at 10 m lies that of pressure levels, beside the peak's period
 * rain: a variable that cannot be one of ours leaves the file to the others. */
static void leave_out(struct pel_forecast_file *file, struct variable *v,
                      int number, const struct pel_fault *why)
{
    pel_forecast_words_add(&file->unread, "%.40s", v->name);
    if (!file->was_refused[number]) {
        file->was_refused[number] = true;
        file->refused[number] = *why;
    }
    for (int i = 0; i < v->rank && i < PEL_NETCDF_MOST_RANK; i++) {
        free(v->axes[i].values);
        v->axes[i].values = NULL;
    }
}

static enum pel_err take(struct pel_forecast_file *file, struct set *s, int id,
                         struct pel_fault *fault)
{
    struct pel_forecast_kind kind;
    struct variable *v = &s->variables[s->count];
    *v = (struct variable){ .id = id };
    if (nc_inq_varname(s->id, id, v->name) ||
        nc_inq_vartype(s->id, id, &v->type) ||
        nc_inq_varndims(s->id, id, &v->rank) || v->rank < 2 ||
        v->type == NC_CHAR || v->type > NC_UINT64 ||
        !kind_of(file, s, v, &kind)) {
        return PEL_OK;
    }
    if (s->count + 1 == MOST_VARIABLES) {
        return pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                             "it has more than %d variables of wind and waves",
                             MOST_VARIABLES - 1);
    }
    enum pel_err err = take_axes(file, s, v, &kind, fault);
    err = err ? err : check_scalars(s, v, &kind, fault);
    err = err ? err : pel_netcdf_check_way(s->id, v->id, &kind, fault);
    err = err ? err : take_unit(file, s, v, &kind, fault);
    if (err == PEL_ERR_INVALID) {
        leave_out(file, v, kind.number, fault);
        return PEL_OK;
    }
    err = err ? err : add_slices(file, s, &kind, fault);
    s->count += !err;
    return err;
}

static void note_versions(struct pel_forecast_file *file,
                          const struct variable *v)
{
    char values[64];
    if (v->version >= 0 && v->axes[v->version].count > 1) {
        list_values(&v->axes[v->version], values);
        pel_forecast_note(
            file, "expver %s: each number is of the first that has it", values);
    }
}

/* --- its numbers ------------------------------------------------------------
 */

/* One version's numbers where the plane has none yet. */
static int read_version(const struct set *s, const struct variable *v,
                        const struct pel_forecast_slice *slice, size_t *at,
                        double *raw, double *plane,
                        struct pel_netcdf_holes *holes)
{
    size_t count[PEL_NETCDF_MOST_RANK];
    size_t nx = (size_t)slice->x.count, ny = (size_t)slice->y.count;
    bool by_rows = v->latitude < v->longitude;
    for (int i = 0; i < v->rank; i++) {
        count[i] = i == v->latitude ? ny : i == v->longitude ? nx : 1;
    }
    int why = nc_get_vara_double(s->id, v->id, at, count, raw);
    if (why && why != NC_ERANGE) {
        return why;
    }
    for (size_t y = 0; y < ny; y++) {
        size_t j = slice->y.falling ? ny - 1 - y : y;
        for (size_t x = 0; x < nx; x++) {
            size_t i = slice->x.falling ? nx - 1 - x : x;
            double *to = &plane[y * nx + x];
            if (isnan(*to)) {
                *to = v->factor *
                      pel_netcdf_value(holes,
                                       raw[by_rows ? j * nx + i : i * ny + j]);
            }
        }
    }
    return 0;
}

static enum pel_err read_slice(struct pel_forecast_file *file,
                               const struct pel_forecast_slice *slice,
                               double *plane, struct pel_fault *fault)
{
    const struct set *s = file->user;
    const struct variable *v = &s->variables[slice->place];
    size_t at[PEL_NETCDF_MOST_RANK];
    size_t nodes = (size_t)slice->x.count * (size_t)slice->y.count;
    size_t versions = v->version < 0 ? 1 : v->axes[v->version].count;
    double *raw = malloc(nodes * sizeof *raw), before = -INFINITY;
    int why = raw ? 0 : NC_ENOMEM;
    struct pel_netcdf_holes holes;
    pel_netcdf_find_holes(s->id, v->id, v->type, &holes);
    part_at(v, slice->part, at);
    for (size_t i = 0; i < nodes; i++) {
        plane[i] = NAN;
    }
    /* The least number first: the ECMWF's final data before the preliminary. */
    for (size_t k = 0; !why && k < versions; k++) {
        if (v->version >= 0 && v->axes[v->version].values) {
            const double *numbers = v->axes[v->version].values;
            size_t next = versions;
            for (size_t i = 0; i < versions; i++) {
                bool later = numbers[i] > before;
                if (later && (next == versions || numbers[i] < numbers[next])) {
                    next = i;
                }
            }
            if (next == versions) {
                break;
            }
            before = numbers[next];
            at[v->version] = next;
        } else if (v->version >= 0) {
            at[v->version] = k;
        }
        why = read_version(s, v, slice, at, raw, plane, &holes);
    }
    free(raw);
    return why ? pel_fault_set(fault, PEL_ERR_MALFORMED,
                               "%s cannot be read: %.80s", slice->label,
                               nc_strerror(why))
               : pel_netcdf_check_ends(&holes, v->name, fault);
}

/* The number as the file has it. */
static void declare(const struct pel_forecast_file *file,
                    const struct pel_forecast_slice *slice, double value,
                    char out[112])
{
    const struct set *s = file->user;
    const struct variable *v = &s->variables[slice->place];
    struct pel_netcdf_holes holes;
    pel_netcdf_find_holes(s->id, v->id, v->type, &holes);
    pel_netcdf_declare(&holes, v->name, value / v->factor, out);
}

static void finish(struct pel_forecast_file *file)
{
    struct set *s = file->user;
    for (size_t i = 0; s && i < MOST_VARIABLES; i++) {
        for (size_t k = 0; k < PEL_NETCDF_MOST_RANK; k++) {
            free(s->variables[i].axes[k].values);
        }
    }
    if (s && s->opened) {
        nc_close(s->id);
    }
    free(s);
    file->user = NULL;
}

static bool looks_so(const char *path)
{
    unsigned char start[8] = { 0 };
    FILE *file = fopen(path, "rb");
    bool read = file && fread(start, sizeof start, 1, file) == 1;
    if (file) {
        fclose(file);
    }
    return read && (memcmp(start, "CDF", 3) == 0 ||
                    memcmp(start, "\211HDF\r\n\032\n", 8) == 0);
}

enum pel_err pel_forecast_list_netcdf(const char *path,
                                      struct pel_forecast_file *out,
                                      bool *is_one, struct pel_fault *fault)
{
    int count = 0;
    struct set *s = calloc(1, sizeof *s);
    *is_one = looks_so(path);
    out->user = s;
    out->read = read_slice;
    out->declare = declare;
    out->finish = finish;
    out->shown_by = "ncdump -h FILE";
    if (!*is_one || !s) {
        return s ? PEL_OK
                 : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    }
    int why = nc_open(path, NC_NOWRITE, &s->id);
    s->opened = !why;
    if (why || nc_inq_nvars(s->id, &count)) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "it is NetCDF that cannot be read: %.100s",
                             nc_strerror(why));
    }
    int groups = 0;
    enum pel_err err = PEL_OK;
    if (!nc_inq_grps(s->id, &groups, NULL) && groups > 0) {
        pel_forecast_words_add(&out->unread, "%d groups (ncks -G : IN OUT)",
                               groups);
    }
    for (int v = 0; !err && v < count; v++) {
        size_t before = s->count;
        err = take(out, s, v, fault);
        if (!err && s->count > before) {
            note_versions(out, &s->variables[before]);
        }
    }
    return err;
}
