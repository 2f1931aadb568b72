#include "render/pass.h"

_Static_assert(PEL_COMPUTE_SLOTS <= PEL_FRAGMENT_SLOTS,
               "struct pel_pass has a place for each slot");

/* The next pass of what is left; `but`: layers that it is not to draw. */
static struct pel_pass take(unsigned left, unsigned but, bool compute)
{
    struct pel_pass pass = {
        .kind = PEL_SHADE_LIGHT,
        .slots = compute ? PEL_COMPUTE_SLOTS : PEL_FRAGMENT_SLOTS,
    };
    int used = 0;
    for (int i = 0; i < PEL_LAYERS && used < pass.slots; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        if (left & ~but & l->bit) {
            left &= ~(unsigned)l->bit;
            pass.layers |= 1u << i;
            pass.layer[used++] = i;
            if (l->from == PEL_LAYER_FROM_WATER) {
                pass.kind = PEL_SHADE_PARTS;
            } else if (pass.kind == PEL_SHADE_LIGHT) {
                pass.kind = PEL_SHADE_LAYERS;
            }
        }
    }
    while (used < PEL_FRAGMENT_SLOTS) {
        pass.layer[used++] = -1;
    }
    if (left & PEL_DEPTH_OF_THINGS) {
        pass.layers &= ~(1u << PEL_AT_DEPTH);
    }
    pass.left = left;
    pass.last = (left & ~PEL_DEPTH_OF_THINGS) == 0;
    return pass;
}

struct pel_pass pel_pass_first(unsigned asked, bool compute)
{
    const unsigned light = pel_layers_from(PEL_LAYER_FROM_LIGHT);
    /* Programs that take the water's light apart may round the radiance in
     * another way: it and the colour are the same whatever else is asked for.
     */
    unsigned but = asked & (light | PEL_LAYER_COLOR)
                       ? pel_layers_from(PEL_LAYER_FROM_WATER)
                       : 0;
    struct pel_pass pass =
        take(pel_layers_stored(asked) & ~light, but, compute);
    pass.first = true;
    /* In one dispatch the same program writes either. */
    if (!compute && asked == PEL_LAYER_COLOR) {
        pass.kind = PEL_SHADE_COLOR;
    } else if (!compute && asked == (PEL_LAYER_COLOR | light)) {
        pass.kind = PEL_SHADE_BOTH;
    }
    return pass;
}

bool pel_pass_next(struct pel_pass *pass, bool compute)
{
    if (pass->last) {
        return false;
    }
    *pass = take(pass->left, 0, compute);
    return true;
}

void pel_pass_use(const struct pel_pass *pass)
{
    if (pass->kind >= PEL_SHADE_LAYERS) {
        glUniform1ui(PEL_UNIFORM_LAYERS, pass->layers);
        glUniform1iv(PEL_UNIFORM_SLOTS, pass->slots, pass->layer);
    }
}

bool pel_pass_light(const struct pel_pass *whole, struct pel_pass *light)
{
    const unsigned of_light = pel_layers_of_light();
    *light = *whole;
    light->layers = 0;
    light->kind = whole->kind == PEL_SHADE_BOTH ? PEL_SHADE_LIGHT : whole->kind;
    int used = 0;
    for (int i = 0; i < PEL_FRAGMENT_SLOTS; i++) {
        int layer = whole->layer[i];
        light->layer[i] = -1;
        if (layer >= 0 && of_light & pel_layer_table[layer].bit) {
            light->layer[used++] = layer;
            light->layers |= 1U << layer;
        }
    }
    return used > 0 || whole->first;
}

bool pel_pass_rest(const struct pel_pass *whole, struct pel_pass *rest)
{
    const unsigned of_light = pel_layers_of_light();
    *rest = *whole;
    rest->layers = 0;
    rest->first = false;
    int used = 0;
    for (int i = 0; i < PEL_FRAGMENT_SLOTS; i++) {
        int layer = whole->layer[i];
        rest->layer[i] = -1;
        if (layer >= 0 && !(of_light & pel_layer_table[layer].bit)) {
            rest->layer[used++] = layer;
            rest->layers |= 1U << layer;
        }
    }
    return used > 0;
}
