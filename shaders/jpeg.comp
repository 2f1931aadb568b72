#version 450 core
// Planes of luma and chroma, of whole blocks, as the bits of a baseline JPEG's
// scan (ITU-T T.81): transformed (Arai, Agui, Nakajima 1988), divided and coded
// in the library's integers, so that files have the same bytes whoever made
// them. An invocation has a block; those of a group are in the scan's order.
#include "lib/blocks.h"

layout(local_size_x = PEL_GROUP_LINE) in;
// Width and height; of each picture's planes the first word; the word of its
// buffer that gets the EV100 from behind them, 0: none.
layout(location = 0) uniform uvec4 pictures_of[PEL_TOGETHER_MOST];
layout(location = PEL_TOGETHER_MOST) uniform uint qualities[PEL_TOGETHER_MOST];
layout(std430, binding = PEL_STORE_PLANES) restrict readonly buffer planes_block { uint planes[]; };
// struct pel_jpeg_tables of encode/jpegcode.h
layout(std430, binding = PEL_STORE_JPEG) restrict readonly buffer tables_block
{
    uint dc_codes[2 * 16];
    uint ac_codes[2 * 256];
    uint order[64];
    uint place[64];
    uint divisors[PEL_JPEG_BEST * 2 * 64];
};
layout(std430, binding = PEL_STORE_PICTURES) restrict writeonly buffer picture_block { uint words[]; }
pictures[PEL_TOGETHER_MOST];

// Blocks of the last unit before the group, of which it needs the means.
const uint OWN = PEL_JPEG_UNITS * PEL_JPEG_BLOCKS;

shared int values[64 * PEL_GROUP_LINE]; // by invocation within coefficient
shared int means[PEL_GROUP_LINE];
shared uint lengths[PEL_GROUP_LINE];
shared uint bits[PEL_JPEG_MOST_WORDS];

uint own = 0u;
uvec4 of = uvec4(0u);
uvec2 units = uvec2(0u); // across, down

// Of 16 bits, which the largest slopes overflow, as the library's vectors do.
int times(int a, int factor)
{
    return bitfieldExtract(a << 2, 0, 16) * (factor << 6) >> 16;
}

void transform(inout int d[8])
{
    int sum0 = d[0] + d[7], sum1 = d[1] + d[6], sum2 = d[2] + d[5], sum3 = d[3] + d[4];
    int less0 = d[0] - d[7], less1 = d[1] - d[6], less2 = d[2] - d[5], less3 = d[3] - d[4];
    int outer = sum0 - sum3, whole = sum0 + sum3, inner = sum1 + sum2;
    d[0] = whole + inner;
    d[4] = whole - inner;
    int turned = times(sum1 - sum2 + outer, 181); // 256 cos pi/4
    d[2] = outer + turned;
    d[6] = outer - turned;
    int low = less3 + less2, mid = less2 + less1, high = less1 + less0;
    int both = times(low - high, 98); // 256 cos 3 pi/8
    int a = times(low, 139) + both;   // 256 (cos pi/8 - cos 3 pi/8)
    int b = times(high, 334) + both;  // 256 (cos pi/8 + cos 3 pi/8)
    int c = times(mid, 181);
    d[5] = less0 - c + a;
    d[3] = less0 - c - a;
    d[1] = less0 + c + b;
    d[7] = less0 + c - b;
}

// Whether the picture reaches into this block of luma of a unit; others are not
// coded but for a mean that does not change.
bool reached(uint unit, uint block)
{
    uvec2 at = 2u * uvec2(unit % units.x, unit / units.x) + uvec2(block & 1u, block >> 1);
    return 8u * at.x < of.x && 8u * at.y < of.y;
}

uint last_reached(uint unit)
{
    uint block = 3u;
    while (!reached(unit, block)) {
        block--;
    }
    return block;
}

// The first word of the block's first row, and words from row to row.
uvec2 rows_of(uint unit, uint block)
{
    uvec2 at = uvec2(unit % units.x, unit / units.x);
    uint stride = 4u * units.x;
    if (block < 4u) {
        at = 2u * at + uvec2(block & 1u, block >> 1);
        return uvec2(of.z + 8u * at.y * stride + 2u * at.x, stride);
    }
    uint luma = 64u * units.x * units.y;
    uint first = of.z + luma + (block == 5u ? luma / 4u : 0u);
    return uvec2(first + 4u * at.y * stride + 2u * at.x, stride / 2u);
}

// Leaves the block's quantised coefficients in `values`; which of them beyond
// the mean are not 0, in the scan's order.
uvec2 quantise(uvec2 rows, uint table)
{
    for (uint y = 0u; y < 8u; y++) {
        uint first = planes[rows.x + y * rows.y], second = planes[rows.x + y * rows.y + 1u];
        int d[8];
        for (int i = 0; i < 4; i++) {
            d[i] = int(first >> 8 * i & 0xFFu) - 128;
            d[i + 4] = int(second >> 8 * i & 0xFFu) - 128;
        }
        transform(d);
        for (uint x = 0u; x < 8u; x++) {
            values[(8u * y + x) * PEL_GROUP_LINE + own] = d[x];
        }
    }
    uvec2 found = uvec2(0u);
    for (uint x = 0u; x < 8u; x++) {
        int d[8];
        for (uint y = 0u; y < 8u; y++) {
            d[y] = values[(8u * y + x) * PEL_GROUP_LINE + own];
        }
        transform(d);
        for (uint y = 0u; y < 8u; y++) {
            uint i = 8u * y + x;
            uint divisor = divisors[table + i];
            int size = int((uint(abs(d[y])) + divisor / 2u) / divisor);
            values[i * PEL_GROUP_LINE + own] = d[y] < 0 ? -size : size;
            uint at = place[i];
            uint bit = size != 0 && i != 0u ? 1u << (at & 31u) : 0u;
            found |= at < 32u ? uvec2(bit, 0u) : uvec2(0u, bit);
        }
    }
    return found;
}

uint at = 0u; // bits so far

void put(uint value, uint count)
{
    uint word = at >> 5, room = 32u - (at & 31u);
    if (count <= room) {
        atomicOr(bits[word], value << (room - count));
    } else {
        atomicOr(bits[word], value >> (count - room));
        atomicOr(bits[word + 1u], value << (32u - (count - room)));
    }
    at += count;
}

uint size_of(int value)
{
    return uint(findMSB(uint(abs(value))) + 1);
}

// A code and the value's own bits behind it.
void emit(uint code, int value, uint size, bool counting)
{
    uint count = (code >> 16) + size;
    if (counting) {
        at += count;
    } else {
        uint low = uint(value < 0 ? value - 1 : value) & (1u << size) - 1u;
        put((code & 0xFFFFu) << size | low, count);
    }
}

void code_block(int difference, uvec2 left, uint kind, bool counting)
{
    uint size = size_of(difference);
    emit(dc_codes[16u * kind + size], difference, size, counting);
    uint last = 0u;
    while ((left.x | left.y) != 0u) {
        uint next = left.x != 0u ? uint(findLSB(left.x)) : 32u + uint(findLSB(left.y));
        left = left.x != 0u ? uvec2(left.x & left.x - 1u, left.y) : uvec2(0u, left.y & left.y - 1u);
        uint run = next - last - 1u;
        for (; run > 15u; run -= 16u) {
            emit(ac_codes[256u * kind + 0xF0u], 0, 0u, counting);
        }
        int value = values[order[next] * PEL_GROUP_LINE + own];
        size = size_of(value);
        emit(ac_codes[256u * kind + 16u * run + size], value, size, counting);
        last = next;
    }
    if (last < 63u) {
        emit(ac_codes[256u * kind], 0, 0u, counting);
    }
}

// The mean before this block's in the scan, of its component.
int mean_before(uint unit, uint block)
{
    bool first = own < PEL_JPEG_BLOCKS;
    if (block >= 4u) {
        return means[first ? OWN + block - 3u : own - PEL_JPEG_BLOCKS];
    }
    for (uint i = block; i > 0u; i--) {
        if (reached(unit, i - 1u)) {
            return means[own - block + i - 1u];
        }
    }
    return means[first ? OWN : own - block - PEL_JPEG_BLOCKS + last_reached(unit - 1u)];
}

void main()
{
    of = pictures_of[gl_WorkGroupID.y];
    own = gl_LocalInvocationID.x;
    units = (of.xy + 15u) / 16u;
    uint all = units.x * units.y, first = gl_WorkGroupID.x * PEL_JPEG_UNITS;
    if (first >= all) {
        return;
    }
    uint unit = first + own / PEL_JPEG_BLOCKS, block = own % PEL_JPEG_BLOCKS;
    bool coded = own < OWN && unit < all;
    bool known = coded;
    if (own >= OWN && own < OWN + 3u && first > 0u) {
        unit = first - 1u;
        block = own == OWN ? last_reached(unit) : own - OWN + 3u;
        known = true;
    }
    bool is_reached = known && (block >= 4u || reached(unit, block));
    uint kind = block >= 4u ? 1u : 0u;
    uvec2 found = uvec2(0u);
    if (is_reached) {
        found = quantise(rows_of(unit, block),
                         ((qualities[gl_WorkGroupID.y] - 1u) * 2u + kind) * 64u);
    }
    means[own] = is_reached ? values[own] : 0;
    barrier();
    int difference = coded && is_reached ? means[own] - mean_before(unit, block) : 0;
    if (coded) {
        code_block(difference, found, kind, true);
    }
    lengths[own] = at;
    for (uint step = 1u; step < PEL_GROUP_LINE; step *= 2u) {
        barrier();
        uint before = own >= step ? lengths[own - step] : 0u;
        barrier();
        lengths[own] += before;
    }
    barrier();
    uint total = lengths[PEL_GROUP_LINE - 1u];
    bool fits = total <= 32u * PEL_JPEG_MOST_WORDS; // else the host tells of it
    uint used = fits ? (total + 31u) / 32u : 0u;
    for (uint i = own; i < used; i += PEL_GROUP_LINE) {
        bits[i] = 0u;
    }
    barrier();
    at = lengths[own] - at;
    if (coded && fits) {
        code_block(difference, found, kind, false);
    }
    barrier();
    uint to = gl_WorkGroupID.x * PEL_JPEG_GROUP_WORDS;
    for (uint i = own; i <= used; i += PEL_GROUP_LINE) {
        pictures[gl_WorkGroupID.y].words[to + i] = i == 0u ? total : bits[i - 1u];
    }
    if (gl_WorkGroupID.x + own == 0u && of.w != 0u) {
        pictures[gl_WorkGroupID.y].words[of.w] = planes[of.z + 96u * all];
    }
}
