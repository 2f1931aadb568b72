#version 450 core
// The colours of pictures as planes of luma and chroma in their readback
// buffers: what encoders take, in 1.5 bytes a pixel instead of 4. The integers
// are libyuv's of ITU-R BT.601, so that files have the same bytes whoever made
// the planes.
#include "lib/blocks.h"

layout(local_size_x = PEL_GROUP_LINE) in;
// Width and height; of each picture's source the first word, or pixels aside;
// the word of its buffer that gets the EV100. And its PEL_YCBCR_FORM_*.
layout(location = 0) uniform uvec4 pictures_of[PEL_TOGETHER_MOST];
layout(location = PEL_TOGETHER_MOST) uniform uint forms[PEL_TOGETHER_MOST];
#ifdef PEL_TOGETHER
layout(std430, binding = PEL_STORE_COLORS) restrict readonly buffer colors_block { uint colors[]; };
#else
layout(binding = PEL_UNIT_COLORS) uniform sampler2D colors;
#endif
layout(std430, binding = PEL_STORE_PICTURES) restrict writeonly buffer picture_block { uint words[]; }
#ifdef PEL_TOGETHER
pictures[PEL_TOGETHER_MOST];
#define PUT(word, value) pictures[gl_WorkGroupID.z].words[word] = value
#else
picture;
#define PUT(word, value) picture.words[word] = value
#endif

uvec4 of = uvec4(0u);
bool studio = false;

ivec3 color_at(uvec2 at)
{
#ifdef PEL_TOGETHER
    uint c = colors[of.z + at.y * of.x + at.x];
    return ivec3(c & 0xFFu, c >> 8 & 0xFFu, c >> 16 & 0xFFu);
#else
    return ivec3(texelFetch(colors, ivec2(at + of.z), 0).rgb * 255.0 + 0.5);
#endif
}

uint luma(ivec3 c)
{
    return uint((studio ? 66 * c.r + 129 * c.g + 25 * c.b + 0x1080
                        : 77 * c.r + 150 * c.g + 29 * c.b + 0x80) >> 8);
}

// Cb below, Cr above.
uint chroma(ivec3 c)
{
    int b = studio ? 112 * c.b - 74 * c.g - 38 * c.r + 0x8000
                   : 127 * c.b - 84 * c.g - 43 * c.r + 0x8080;
    int r = studio ? 112 * c.r - 94 * c.g - 18 * c.b + 0x8000
                   : 127 * c.r - 107 * c.g - 20 * c.b + 0x8080;
    return uint(b >> 8 | r >> 8 << 16);
}

#ifdef PEL_TOGETHER
// A picture of colours among those of planes, from its group's first pixel plus
// its own invocation on.
void copy_colors(uvec2 at)
{
    for (uint y = at.y; y < min(at.y + 2u, of.y); y++) {
        for (uint i = 0u; i < 4u; i++) {
            uint x = at.x + i * PEL_GROUP_LINE;
            if (x < of.x) {
                PUT(y * of.x + x, colors[of.z + y * of.x + x]);
            }
        }
    }
}
#endif

ivec3 middle(ivec3 a, ivec3 b)
{
    return a + b + 1 >> 1;
}

uint word_of(uint a, uint b, uint c, uint d)
{
    return a | b << 8 | c << 16 | d << 24;
}

shared uint halves[PEL_GROUP_LINE];

// Pixels of two rows, four of each: neighbours write neighbouring words, since
// the host's memory takes what is written apart many times as slowly. Blocks
// beyond the picture repeat its last column and row.
void main()
{
    of = pictures_of[gl_WorkGroupID.z];
    uint form = forms[gl_WorkGroupID.z];
    studio = form == PEL_YCBCR_FORM_VIDEO;
    uvec2 high = of.xy;
    uvec2 whole = (high + 15u) / 16u * 16u;
    uint own = gl_LocalInvocationID.x;
    uvec2 at = uvec2(gl_WorkGroupID.x * 4u * PEL_GROUP_LINE, gl_WorkGroupID.y * 2u);
#ifdef PEL_TOGETHER
    if (gl_WorkGroupID.x + gl_WorkGroupID.y + own == 0u) {
        PUT(of.w, colors[of.z + high.x * high.y]);
    }
    if (form == PEL_YCBCR_FORM_NONE) {
        copy_colors(at + uvec2(own, 0u));
        return;
    }
#endif
    if (at.x >= whole.x || at.y >= whole.y) {
        return;
    }
    at.x += own * 4u;
    uint luma_words = whole.x * whole.y / 4u;
    uint c[2];
    if (at.x < whole.x) {
        ivec3 upper[4], lower[4];
        uint y = min(at.y, high.y - 1u), below = min(at.y + 1u, high.y - 1u);
        for (uint i = 0u; i < 4u; i++) {
            uint x = min(at.x + i, high.x - 1u);
            upper[i] = color_at(uvec2(x, y));
            lower[i] = color_at(uvec2(x, below));
        }
        uint word = (at.y * whole.x + at.x) / 4u;
        PUT(word, word_of(luma(upper[0]), luma(upper[1]), luma(upper[2]), luma(upper[3])));
        PUT(word + whole.x / 4u,
            word_of(luma(lower[0]), luma(lower[1]), luma(lower[2]), luma(lower[3])));
        bool inside = at.x + 4u <= high.x && at.y + 2u <= high.y;
        for (uint i = 0u; i < 2u; i++) {
            ivec3 left, right;
            if (inside) {
                left = middle(upper[2u * i], lower[2u * i]);
                right = middle(upper[2u * i + 1u], lower[2u * i + 1u]);
            } else {
                uvec2 p = min(at + uvec2(2u * i, 0u), (high - 1u) / 2u * 2u);
                uvec2 q = min(p + 1u, high - 1u);
                left = middle(color_at(p), color_at(uvec2(p.x, q.y)));
                right = middle(color_at(uvec2(q.x, p.y)), color_at(q));
            }
            c[i] = chroma(middle(left, right));
        }
        if (studio) {
            PUT(luma_words + (at.y / 2u * whole.x + at.x) / 4u,
                word_of(c[0] & 0xFFu, c[0] >> 16, c[1] & 0xFFu, c[1] >> 16));
        }
    }
    if (studio) {
        return;
    }
    // Two columns of one chroma are half a word: Cb below, Cr above.
    halves[own] = c[0] | c[1] << 8;
    barrier();
    uint half_of = own % (PEL_GROUP_LINE / 2u) * 2u;
    bool is_cr = own >= PEL_GROUP_LINE / 2u;
    uint column = gl_WorkGroupID.x * 2u * PEL_GROUP_LINE + half_of * 2u;
    if (column < whole.x / 2u) {
        uint a = halves[half_of], b = halves[half_of + 1u];
        uint word = luma_words + (at.y * whole.x / 4u + column) / 4u;
        PUT(is_cr ? word + luma_words / 4u : word,
            is_cr ? a >> 16 | b & 0xFFFF0000u : a & 0xFFFFu | b << 16);
    }
}
