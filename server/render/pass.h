/* The passes that shade one picture: the first writes the radiance, each as
 * many layers as it has slots, so that the number of layers is not limited
 * (proto/layers.def). */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

#include "render/programs.h"
#include "render/renderer.h"
#include "shaders/lib/blocks.h"

/* With layers that are asked for: the depth's is written only where things and
 * land are, whose depth costs nothing; the sea's, by Newton's steps, is not. */
#define PEL_DEPTH_OF_THINGS (1u << 31)

struct pel_pass {
    enum pel_shading kind;
    bool first, last;
    int slots;                       /* of the wrapper */
    GLuint layers;                   /* as bits by PEL_AT_*, for the shaders */
    GLint layer[PEL_FRAGMENT_SLOTS]; /* PEL_AT_* of each slot; -1: none */
    unsigned left;                   /* layers of the passes after this */
};

/* The first pass of a picture of these layers (of enum pel_layer), by either
 * wrapper; and the one after *pass, false after the last. */
struct pel_pass pel_pass_first(unsigned asked, bool compute);
bool pel_pass_next(struct pel_pass *pass, bool compute);

/* Tells the program in use the layers of its slots. */
void pel_pass_use(const struct pel_pass *pass);

/* The part of a pass that is light, and the other, that shows what pixels'
 * middles do; false: there is none. */
bool pel_pass_light(const struct pel_pass *whole, struct pel_pass *light);
bool pel_pass_rest(const struct pel_pass *whole, struct pel_pass *rest);
