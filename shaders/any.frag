#version 450 core
// Whether a pixel has a sample with an object: as depth, so that what follows
// is drawn nowhere else.
#include "lib/blocks.h"

layout(binding = PEL_UNIT_OBJECT_DEPTHS) uniform sampler2DMS object_depths;

void main()
{
    float nearest = 0.0;
    for (int i = 0; i < PEL_SAMPLES; i++) {
        nearest = max(nearest, texelFetch(object_depths, ivec2(gl_FragCoord.xy), i).r);
    }
    gl_FragDepth = nearest > 0.0 ? 1.0 : 0.0;
}
