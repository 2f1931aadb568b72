// An entry of the list of pixels that outlines cut: its place, the side on which
// the neighbour above it lies, and the parts of it that show the neighbours below
// and above.

uvec2 edge_of(ivec2 at, ivec2 up, vec2 parts)
{
    uint side = (up.x != 0 ? 1u << 15 : 0u) | (up.x + up.y < 0 ? 1u << 31 : 0u);
    return uvec2(uint(at.y) << 16 | uint(at.x) | side, packUnorm2x16(parts));
}

ivec2 edge_place(uvec2 edge)
{
    return ivec2(edge.x & 0x7FFFu, edge.x >> 16 & 0x7FFFu);
}

ivec2 edge_up(uvec2 edge)
{
    int step_ = edge.x >> 31 != 0u ? -1 : 1;
    return (edge.x >> 15 & 1u) != 0u ? ivec2(step_, 0) : ivec2(0, step_);
}
