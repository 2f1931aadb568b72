#include "models/modelload.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/file.h"
#include "base/helper.h"

#define PROGRAM "pelagos-model"

const char *const pel_model_endings[] = { "glb", "gltf", "obj", "dae", "3ds",
                                          "ac",  "stl",  "x",   NULL };

bool pel_model_is_file(const char *name)
{
    const char *dot = strrchr(name, '.');
    for (int i = 0; dot && pel_model_endings[i]; i++) {
        if (strcasecmp(dot + 1, pel_model_endings[i]) == 0) {
            return true;
        }
    }
    return false;
}

static enum pel_err check(const struct pel_model_source *s,
                          struct pel_fault *fault)
{
    if (!s->directory) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "%.80s: no such built-in model, and files need "
                             "pelagosd --models",
                             s->file);
    }
    if (!pel_model_is_file(s->file)) {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "%.80s: neither a built-in model nor a file that "
                             "ends in .glb, .gltf, .obj, .dae, .3ds, .ac, .stl "
                             "or .x",
                             s->file);
    }
    return pel_helper_find(s->directory, s->file, fault);
}

/* What NAME.json says. */
static enum pel_err describe(const char *directory, const char *file,
                             struct pel_model_description *out,
                             struct pel_fault *fault)
{
    char name[4096];
    char *text = NULL;
    size_t size = 0;
    pel_model_description_init(out);
    snprintf(name, sizeof name, "%s", file);
    char *dot = strrchr(name, '.');
    if (!dot || (size_t)(dot - name) + 6 > sizeof name) {
        return PEL_OK;
    }
    memcpy(dot, ".json", 6);
    enum pel_err err = pel_file_read_in(directory, name, PEL_DESCRIPTION_MOST,
                                        &text, &size, fault);
    if (err == PEL_ERR_NOT_FOUND) {
        return PEL_OK;
    }
    if (!err) {
        struct pel_fault why = { 0 };
        err = pel_model_description_read(text, size, out, &why);
        if (err && fault) {
            const char *last = strrchr(name, '/');
            *fault = why;
            snprintf(fault->message, sizeof fault->message, "%.60s: %.180s",
                     last ? last + 1 : name, why.message);
        }
    }
    free(text);
    return err;
}

static enum pel_err run(const struct pel_model_source *s,
                        const struct pel_model_description *d,
                        unsigned char **out, size_t *size,
                        struct pel_fault *fault)
{
    char numbers[5][32];
    const double values[] = { d->bow, d->up, d->scale, d->length_m,
                              isnan(d->draught_m) ? -1 : d->draught_m };
    for (int i = 0; i < 5; i++) {
        snprintf(numbers[i], sizeof *numbers, "%.12g", values[i]);
    }
    char *argv[] = { (char[]){ PROGRAM }, (char *)s->directory, (char *)s->file,
                     numbers[0],          numbers[1],           numbers[2],
                     numbers[3],          numbers[4],           NULL };
    const struct pel_helper_task task = {
        .program = PROGRAM,
        .argv = argv,
        .subject = s->file,
        .most_bytes = PEL_MODEL_WIRE_MOST,
        .within_ms = PEL_MODEL_LOAD_MS,
    };
    return pel_helper_run(&task, out, size, fault);
}

/* Positions by k, normals by its inverse. */
static void scale_vertices(struct pel_model_vertex *v, size_t count,
                           const double k[3])
{
    for (size_t i = 0; i < count; i++) {
        double n[3], l2 = 0;
        for (int a = 0; a < 3; a++) {
            v[i].position[a] = (float)((double)v[i].position[a] * k[a]);
            n[a] = (double)v[i].normal[a] / k[a];
            l2 += n[a] * n[a];
        }
        for (int a = 0; a < 3; a++) {
            v[i].normal[a] = (float)(n[a] / sqrt(l2));
        }
    }
}

static struct pel_vec3 scaled(struct pel_vec3 v, const double k[3])
{
    return (struct pel_vec3){ v.x * k[0], v.y * k[1], v.z * k[2] };
}

/* What the file and its description make of the draft. */
static void dress(const struct pel_model_source *s,
                  struct pel_model_description *d, struct pel_model *m)
{
    double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY };
    for (size_t i = 0; i < m->vertex_count; i++) {
        for (int a = 0; a < 2; a++) {
            low[a] = fmin(low[a], (double)m->vertices[i].position[a]);
            high[a] = fmax(high[a], (double)m->vertices[i].position[a]);
        }
    }
    double length = d->length_m > 0 ? d->length_m : high[0] - low[0];
    double beam = d->beam_m > 0 ? d->beam_m : high[1] - low[1];
    double by = s->length_m > 0 ? s->length_m / length : 1;
    const double k[] = { by, s->beam_m > 0 ? s->beam_m / beam : by, by };
    if (k[0] != 1 || k[1] != 1) {
        scale_vertices((struct pel_model_vertex *)m->vertices, m->vertex_count,
                       k);
    }
    for (int i = 0; i < m->level_count; i++) {
        m->levels[i].error_m *= (float)fmax(k[0], k[1]);
    }
    for (size_t i = 0; i < d->eye_count; i++) {
        d->eyes[i].at = scaled(d->eyes[i].at, k);
    }
    for (size_t i = 0; i < d->light_count; i++) {
        d->lights[i].at = scaled(d->lights[i].at, k);
    }
    m->class = d->class;
    m->length_m = length * k[0];
    m->beam_m = beam * k[1];
    m->height_m = d->height_m * k[2];
    m->draught_m = isnan(d->draught_m) ? 0 : d->draught_m * k[2];
    m->eyes = d->eyes;
    m->eye_count = d->eye_count;
    m->lights = d->lights;
    m->light_count = d->light_count;
    snprintf(m->name, sizeof m->name, "%s", s->file);
}

enum pel_err pel_model_load(const struct pel_model_source *source,
                            const struct pel_model **out,
                            char notes[PEL_MODEL_NOTES],
                            struct pel_fault *fault)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    struct pel_model_description *d = malloc(sizeof *d);
    struct pel_model_draft draft;
    *out = NULL;
    notes[0] = '\0';
    enum pel_err err =
        d ? check(source, fault)
          : pel_fault_set(fault, PEL_ERR_NO_MEMORY, "out of memory");
    err = err ? err : describe(source->directory, source->file, d, fault);
    err = err ? err : run(source, d, &bytes, &size, fault);
    if (!err) {
        struct pel_fault why = { 0 };
        err = pel_model_wire_read(bytes, size, &draft, notes, &why);
        if (!err) {
            dress(source, d, &draft.model);
            err = pel_model_create(&draft.model, out, &why);
            pel_model_draft_clear(&draft);
        }
        if (err) {
            pel_fault_set(fault, err, "%.60s: %.180s", source->file,
                          why.message);
        }
    }
    free(bytes);
    free(d);
    return err;
}
