#include "models/modelwire.h"

#include <stdlib.h>
#include <string.h>

struct head {
    char magic[8];
    uint32_t vertices, indices, materials, textures, nodes, levels;
    char notes[PEL_MODEL_NOTES];
};

struct wire_level {
    uint32_t parts, triangles;
    float error_m;
    uint32_t unused;
};

struct wire_material {
    char name[PEL_MODEL_NAME];
    float albedo[3], metallic, roughness, alpha_cutoff;
    int32_t texture;
    uint32_t two_sided;
};

struct wire_texture {
    uint32_t width, height;
};

/* --- writing ----------------------------------------------------------------
 */

static bool put(FILE *to, const void *from, size_t size)
{
    static const char zeros[8];
    size_t rest = -size & 7;
    return (size == 0 || fwrite(from, size, 1, to) == 1) &&
           (rest == 0 || fwrite(zeros, rest, 1, to) == 1);
}

static bool put_materials(FILE *to, const struct pel_model *m)
{
    bool fine = true;
    for (size_t i = 0; i < m->material_count && fine; i++) {
        const struct pel_model_material *a = &m->materials[i];
        struct wire_material w = { .metallic = a->metallic,
                                   .roughness = a->roughness,
                                   .alpha_cutoff = a->alpha_cutoff,
                                   .texture = a->texture,
                                   .two_sided = a->two_sided };
        memcpy(w.name, a->name, sizeof w.name);
        memcpy(w.albedo, a->albedo, sizeof w.albedo);
        fine = put(to, &w, sizeof w);
    }
    return fine;
}

bool pel_model_wire_write(FILE *to, const struct pel_model *m,
                          const char *notes)
{
    struct head head = { .magic = PEL_MODEL_WIRE_MAGIC,
                         .vertices = (uint32_t)m->vertex_count,
                         .indices = (uint32_t)m->index_count,
                         .materials = (uint32_t)m->material_count,
                         .textures = (uint32_t)m->texture_count,
                         .nodes = (uint32_t)m->node_count,
                         .levels = (uint32_t)m->level_count };
    snprintf(head.notes, sizeof head.notes, "%s", notes);
    bool fine = put(to, &head, sizeof head);
    for (int i = 0; i < m->level_count && fine; i++) {
        const struct pel_model_level *l = &m->levels[i];
        struct wire_level w = { (uint32_t)l->part_count, (uint32_t)l->triangles,
                                l->error_m, 0 };
        fine = put(to, &w, sizeof w) &&
               put(to, l->parts, l->part_count * sizeof *l->parts);
    }
    fine = fine &&
           put(to, m->vertices, m->vertex_count * sizeof *m->vertices) &&
           put(to, m->indices, m->index_count * sizeof *m->indices) &&
           put(to, m->nodes, m->node_count * sizeof *m->nodes) &&
           put_materials(to, m);
    for (size_t i = 0; i < m->texture_count && fine; i++) {
        const struct pel_model_texture *t = &m->textures[i];
        struct wire_texture w = { (uint32_t)t->width, (uint32_t)t->height };
        fine = put(to, &w, sizeof w) &&
               put(to, t->rgba, 4 * (size_t)t->width * (size_t)t->height);
    }
    return fine;
}

/* --- reading
 * ------------------------------------------------------------------ */

struct cursor {
    unsigned char *at;
    size_t left;
};

/* The next `count` things of `size` bytes; NULL: there are not so many. */
static void *next(struct cursor *c, size_t count, size_t size)
{
    if (count > c->left / size) {
        return NULL;
    }
    size_t bytes = (count * size + 7) & ~(size_t)7;
    void *at = c->at;
    bytes = bytes < c->left ? bytes : c->left;
    c->at += bytes;
    c->left -= bytes;
    return at;
}

static bool read_levels(struct cursor *c, const struct head *head,
                        struct pel_model_draft *out)
{
    if (head->levels < 1 || head->levels > PEL_MODEL_LEVELS) {
        return false;
    }
    for (uint32_t i = 0; i < head->levels; i++) {
        const struct wire_level *w = next(c, 1, sizeof *w);
        const struct pel_model_part *parts =
            w ? next(c, w->parts, sizeof *parts) : NULL;
        struct pel_model_part *copy =
            parts ? malloc(w->parts * sizeof *copy + 1) : NULL;
        if (!copy) {
            return false;
        }
        memcpy(copy, parts, w->parts * sizeof *copy);
        out->model.levels[out->model.level_count++] =
            (struct pel_model_level){ w->parts, copy, w->triangles,
                                      w->error_m };
    }
    return true;
}

static bool read_materials(struct cursor *c, const struct head *head,
                           struct pel_model_draft *out)
{
    const struct wire_material *w = next(c, head->materials, sizeof *w);
    struct pel_model_material *to =
        w ? calloc(head->materials + 1, sizeof *to) : NULL;
    out->model.materials = out->owned[0] = to;
    for (uint32_t i = 0; to && i < head->materials; i++) {
        to[i] = (struct pel_model_material){ .metallic = w[i].metallic,
                                             .roughness = w[i].roughness,
                                             .alpha_cutoff = w[i].alpha_cutoff,
                                             .two_sided = w[i].two_sided != 0,
                                             .texture = w[i].texture };
        memcpy(to[i].name, w[i].name, sizeof to[i].name);
        memcpy(to[i].albedo, w[i].albedo, sizeof to[i].albedo);
    }
    return to != NULL;
}

static bool read_textures(struct cursor *c, const struct head *head,
                          struct pel_model_draft *out)
{
    if (head->textures > PEL_MODEL_MOST_TEXTURES) {
        return false;
    }
    struct pel_model_texture *to = calloc(head->textures + 1, sizeof *to);
    out->model.textures = out->owned[1] = to;
    for (uint32_t i = 0; to && i < head->textures; i++) {
        const struct wire_texture *w = next(c, 1, sizeof *w);
        if (!w || w->width < 1 || w->width > PEL_MODEL_MOST_SIDE ||
            w->height < 1 || w->height > PEL_MODEL_MOST_SIDE) {
            return false;
        }
        to[i].width = (int)w->width;
        to[i].height = (int)w->height;
        to[i].rgba = next(c, (size_t)w->width * w->height, 4);
        if (!to[i].rgba) {
            return false;
        }
    }
    return to != NULL;
}

enum pel_err pel_model_wire_read(unsigned char *bytes, size_t size,
                                 struct pel_model_draft *out,
                                 char notes[PEL_MODEL_NOTES],
                                 struct pel_fault *fault)
{
    struct cursor c = { bytes, size };
    struct pel_model *m = &out->model;
    *out = (struct pel_model_draft){ 0 };
    notes[0] = '\0';
    const struct head *head = next(&c, 1, sizeof *head);
    bool fine =
        head &&
        memcmp(head->magic, PEL_MODEL_WIRE_MAGIC, sizeof head->magic) == 0 &&
        memchr(head->notes, '\0', sizeof head->notes) &&
        read_levels(&c, head, out);
    if (fine) {
        m->vertices = next(&c, head->vertices, sizeof *m->vertices);
        m->indices = next(&c, head->indices, sizeof *m->indices);
        m->nodes = next(&c, head->nodes, sizeof *m->nodes);
        fine = m->vertices && m->indices && m->nodes &&
               read_materials(&c, head, out) && read_textures(&c, head, out);
    }
    if (!fine) {
        pel_model_draft_clear(out);
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "what its reader says is no model");
    }
    m->vertex_count = head->vertices;
    m->index_count = head->indices;
    m->material_count = head->materials;
    m->texture_count = head->textures;
    m->node_count = head->nodes;
    memcpy(notes, head->notes, sizeof head->notes);
    return PEL_OK;
}
