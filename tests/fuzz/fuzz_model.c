/* Descriptions of models, and models as their reader process hands them over:
 * what is taken must be within its limits everywhere, and can be looked at. The
 * first byte says which, and puts a head in front. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "models/describe.h"
#include "models/modelwire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

static void describe(const uint8_t *data, size_t size)
{
    struct pel_model_description d;
    struct pel_fault fault = { 0 };
    if (pel_model_description_read((const char *)data, size, &d, &fault)) {
        demand(fault.message[0] != '\0');
        return;
    }
    demand((unsigned)d.class < PEL_MODEL_CLASSES);
    demand(d.eye_count <= PEL_MODEL_MOST_EYES);
    demand(d.light_count <= PEL_MODEL_MOST_LIGHTS);
    demand(d.length_m >= 0 && d.length_m <= 1000 && d.scale >= 0);
    demand(d.bow == PEL_AXIS_NONE || d.up == PEL_AXIS_NONE ||
           d.bow / 2 != d.up / 2);
    for (size_t i = 0; i < d.eye_count; i++) {
        demand(fabs(d.eyes[i].at.x) <= 1000 &&
               memchr(d.eyes[i].name, 0, PEL_MODEL_NAME));
    }
}

static void look(const struct pel_model *m)
{
    for (int i = 0; i < 16; i++) {
        struct pel_model_hit hit;
        double z, x = m->low.x + (m->high.x - m->low.x) * (i % 4) / 3.1;
        double y = m->low.y + (m->high.y - m->low.y) * (i / 4) / 3.3;
        if (pel_model_top(m, x, y, &hit, &z)) {
            demand(hit.node < m->node_count &&
                   hit.material < m->material_count && z <= m->high.z + 1e-3 &&
                   z >= m->low.z - 1e-3);
        }
    }
    demand(pel_model_level_for(m, 1, 1) < m->level_count);
}

static void read_wire(const uint8_t *data, size_t size)
{
    const struct pel_model *m = NULL;
    struct pel_model_draft draft;
    struct pel_fault fault;
    char notes[PEL_MODEL_NOTES];
    unsigned char *bytes = malloc(size + 8);
    if (!bytes) {
        abort();
    }
    memcpy(bytes, PEL_MODEL_WIRE_MAGIC, 8);
    memcpy(bytes + 8, data, size);
    if (!pel_model_wire_read(bytes, size + 8, &draft, notes, &fault)) {
        if (!pel_model_create(&draft.model, &m, &fault)) {
            look(m);
            pel_model_unref(m);
        }
        pel_model_draft_clear(&draft);
    }
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size > 0 && data[0] == 'W') {
        read_wire(data + 1, size - 1);
    } else if (size > 0) {
        describe(data, size);
    }
    return 0;
}
