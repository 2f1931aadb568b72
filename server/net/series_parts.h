/* Internals of series: the axes and the questions (series_plan.c), the numbers
 * of the answers (series_table.c), what is made of them (series_file.c). */
#pragma once

#include <glib.h>

#include "fields.h"
#include "net/series.h"

#define PEL_SERIES_AXES 4

/* Dimensions that answers have by themselves, inside each cell. */
enum pel_series_inner {
    PEL_INNER_WAVELENGTH,
    PEL_INNER_OMEGA,
    PEL_INNER_DIRECTION,
    PEL_INNER_POINT,
    PEL_INNER_COUNT,
};

struct pel_series_axis {
    char name[64];
    char path[96];  /* of the state; "": a number of the question */
    bool of_optics; /* of OpticsQuery, not of its question */
    const ProtobufCFieldDescriptor *field;
    const ProtobufCMessageDescriptor *message; /* that has the field */
    double *values;
    size_t count;
};

struct pel_series_plan {
    Pelagos__SeriesQuery *query; /* own copy */
    struct pel_series_axis axes[PEL_SERIES_AXES];
    unsigned axis_count;
    size_t cells; /* questions: product of the axes */
};

/* Takes a copy of the query and finds its axes. Finish in any case. */
PEL_CHECK enum pel_err pel_series_plan_make(const Pelagos__SeriesQuery *query,
                                            struct pel_series_plan *out,
                                            struct pel_fault *fault);
/* Every cell is of this moment, unless the query or an axis says another. */
void pel_series_plan_at(struct pel_series_plan *plan, double time_s);
void pel_series_plan_finish(struct pel_series_plan *plan);

/* The cell that is asked n-th: axes of the state run slowest, so that one sea
 * and one water serve as many questions as they can. */
size_t pel_series_cell(const struct pel_series_plan *plan, size_t n);

/* The question of a cell: an OpticsQuery, SpectrumQuery or SurfaceQuery. */
PEL_CHECK enum pel_err pel_series_question(const struct pel_series_plan *plan,
                                           size_t cell, ProtobufCMessage **out,
                                           struct pel_fault *fault);

/* The value of an axis in a cell. */
double pel_series_at(const struct pel_series_plan *plan, unsigned axis,
                     size_t cell);

/* A number of the answers, in each cell, and within it by inner dimensions. */
struct pel_series_column {
    char name[96];
    const char *unit; /* of the schema, or NULL */
    char *text;
    const ProtobufCMessageDescriptor *message;
    const ProtobufCFieldDescriptor *field;
    unsigned inner; /* bits of enum pel_series_inner */
    size_t block;   /* values in a cell */
    double *values; /* [cells * block], NAN: the answer had none */
    bool *given;    /* [cells]: whether an answer has been there */
};

struct pel_series_table {
    const struct pel_series_plan *plan;
    size_t inner_size[PEL_INNER_COUNT]; /* 0: there is none */
    double *inner_values[PEL_INNER_COUNT];
    GArray *columns; /* of struct pel_series_column */
    size_t values;   /* of all columns */
};

void pel_series_table_init(const struct pel_series_plan *plan,
                           struct pel_series_table *out);
void pel_series_table_finish(struct pel_series_table *table);

/* Takes the numbers of a cell's answer. OUT_OF_RANGE: more than
 * PEL_BOUND_SERIES_VALUES in all. */
PEL_CHECK enum pel_err pel_series_table_take(struct pel_series_table *table,
                                             size_t cell,
                                             const ProtobufCMessage *answer,
                                             struct pel_fault *fault);

/* After the last answer: NAN where there was none. Any thread. */
void pel_series_table_end(struct pel_series_table *table);

const char *pel_series_inner_name(enum pel_series_inner inner);
/* The field that gives an inner dimension its values; NULL: numbers from 0. */
const ProtobufCFieldDescriptor *
pel_series_inner_field(enum pel_series_inner inner,
                       const ProtobufCMessageDescriptor **message);

/* Whence the answers are, for who reads them later. */
struct pel_series_origin {
    char when[32];       /* UTC of the machine, ISO 8601 */
    double epoch_unix_s; /* of simulated time 0 */
    char device[96];
    Pelagos__State *state; /* sections that answers depend on */
};

/* Any thread. *answer: as `form` and the query's format want it. */
PEL_CHECK enum pel_err pel_series_file(const struct pel_series_table *table,
                                       const struct pel_series_origin *origin,
                                       const struct pel_series_form *form,
                                       struct pel_series_answer *answer,
                                       struct pel_fault *fault);
/* The lists as a message; pelagos__series__free_unpacked(). */
Pelagos__Series *pel_series_message(const struct pel_series_table *table,
                                    const struct pel_series_origin *origin);
/* The same as NetCDF's bytes. */
PEL_CHECK enum pel_err pel_series_netcdf(const Pelagos__Series *series,
                                         const struct pel_series_origin *origin,
                                         unsigned char **out, size_t *size,
                                         struct pel_fault *fault);
/* CF's name of a field, or NULL. */
const char *pel_cf_name(const ProtobufCMessageDescriptor *message,
                        const ProtobufCFieldDescriptor *field);
/* What it is, in a sentence. */
const char *pel_cf_text(const ProtobufCMessageDescriptor *message,
                        const ProtobufCFieldDescriptor *field);
