// The mapped readback buffers of views that are drawn together: their colours, top
// row first, then, at a word of its own, the EV100.
layout(std430, binding = PEL_STORE_PICTURES) restrict writeonly buffer picture_block { uint words[]; }
pictures[PEL_TOGETHER_MOST];

// A pixel of the targets, which have pixels more around the picture.
void put_color(ivec2 at, vec3 color)
{
    int margin = int(PEL_OWN.picture.x);
    ivec2 whole = ivec2(size.xy) - 2 * margin;
    at -= margin;
    if (min(at.x, at.y) >= 0 && at.x < whole.x && at.y < whole.y) {
        pictures[gl_WorkGroupID.z].words[at.y * whole.x + at.x] = packed_color(color);
    }
}

void put_exposure(float ev)
{
    pictures[gl_WorkGroupID.z].words[PEL_OWN.picture.y] = floatBitsToUint(ev);
}
