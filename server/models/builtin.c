#include "models/builtin.h"

#include <stdio.h>
#include <string.h>

#include "models/kinds.h"

static const struct pel_builtin_kind kinds[] = {
#define PEL_BUILTIN(kind_name, function, id, length, beam, draught, height,    \
                    paint, words)                                              \
    { .name = (kind_name),                                                     \
      .text = (words),                                                         \
      .class = PEL_MODEL_##id,                                                 \
      .length_m = (length),                                                    \
      .beam_m = (beam),                                                        \
      .draught_m = (draught),                                                  \
      .height_m = (height),                                                    \
      .colour = (paint) },
#include "models/kinds.def"
};
#define KINDS (sizeof kinds / sizeof *kinds)

static void (*const makers[])(struct pel_pen *,
                              const struct pel_kind_size *) = {
#define PEL_BUILTIN(name, function, ...) function,
#include "models/kinds.def"
};

const struct pel_builtin_kind *pel_builtin_kinds(size_t *count)
{
    *count = KINDS;
    return kinds;
}

const struct pel_builtin_kind *pel_builtin_find(const char *name)
{
    for (size_t i = 0; i < KINDS; i++) {
        if (strcmp(kinds[i].name, name) == 0) {
            return &kinds[i];
        }
    }
    return NULL;
}

/* The dimension asked for, or the kind's; without others a ship's follow its
 * length. */
static enum pel_err choose(const char *what, double asked, double typical,
                           double scale, double *out, struct pel_fault *fault)
{
    *out = asked == 0 ? typical * scale : asked;
    if (*out >= typical / PEL_BUILTIN_FACTOR &&
        *out <= typical * PEL_BUILTIN_FACTOR) {
        return PEL_OK;
    }
    pel_fault_set(fault, PEL_ERR_OUT_OF_RANGE,
                  "%s %.4g m: it can be %.4g to %.4g m; 0 or leaving it out "
                  "takes %.4g m",
                  what, *out, typical / PEL_BUILTIN_FACTOR,
                  typical * PEL_BUILTIN_FACTOR, typical);
    if (fault) {
        snprintf(fault->path, sizeof fault->path, "%s", what);
    }
    return PEL_ERR_OUT_OF_RANGE;
}

static enum pel_err measure(const struct pel_builtin *what,
                            const struct pel_builtin_kind *kind,
                            struct pel_kind_size *size, struct pel_fault *fault)
{
    size->colour = what->coloured ? what->colour : kind->colour;
    enum pel_err err = choose("length", what->length_m, kind->length_m, 1,
                              &size->length, fault);
    double scale = size->length / kind->length_m;
    err = err ? err
              : choose("beam", what->beam_m, kind->beam_m, scale, &size->beam,
                       fault);
    err = err ? err
              : choose("draught", what->draught_m, kind->draught_m, scale,
                       &size->draught, fault);
    return err ? err
               : choose("height", what->height_m, kind->height_m, scale,
                        &size->height, fault);
}

enum pel_err pel_builtin_check(const struct pel_builtin *what,
                               struct pel_fault *fault)
{
    const struct pel_builtin_kind *kind = pel_builtin_find(what->name);
    struct pel_kind_size size;
    return kind ? measure(what, kind, &size, fault)
                : pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                                "%.64s: no such built-in model", what->name);
}

enum pel_err pel_builtin_make(const struct pel_builtin *what,
                              const struct pel_model **out,
                              struct pel_fault *fault)
{
    const struct pel_builtin_kind *kind = pel_builtin_find(what->name);
    struct pel_kind_size size;
    *out = NULL;
    if (!kind) {
        return pel_fault_set(fault, PEL_ERR_NOT_FOUND,
                             "%.64s: no such built-in model", what->name);
    }
    enum pel_err err = measure(what, kind, &size, fault);
    if (err) {
        return err;
    }
    struct pel_shape shape = { .class = kind->class,
                               .length_m = size.length,
                               .beam_m = size.beam,
                               .draught_m = size.draught,
                               .height_m = size.height };
    struct pel_pen pen = { .shape = &shape };
    struct pel_model_draft draft;
    snprintf(shape.name, sizeof shape.name, "%s", kind->name);
    makers[kind - kinds](&pen, &size);
    err = pel_shape_finish(&shape, &draft, fault);
    if (!err) {
        err = pel_model_create(&draft.model, out, fault);
        pel_model_draft_clear(&draft);
    }
    pel_shape_clear(&shape);
    return err;
}
