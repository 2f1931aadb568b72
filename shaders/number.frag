#version 450 core
#ifdef PEL_HOLES
#include "lib/blocks.h"
#include "lib/model.glsl"
#include "lib/holes.glsl"
in vec2 painted_at;
flat in uint material;
#endif
// The entity and its triangle.
flat in uvec2 number;
layout(location = 0) out uvec2 seen;

void main()
{
#ifdef PEL_HOLES
    vec2 wide = fwidth(painted_at);
    if (hole_at(material, painted_at, max(wide.x, wide.y), 0.5)) {
        discard;
    }
#endif
    seen = number;
}
