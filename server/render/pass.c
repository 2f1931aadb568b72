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
    pass.left = left;
    pass.last = left == 0;
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
    if (asked == PEL_LAYER_COLOR && !compute) {
        pass.kind = PEL_SHADE_COLOR;
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
