#version 450 core
// The nearest triangle of the mesh at each pixel without the rasteriser: data
// centre chips have few units for graphics and many for compute. Coverage is
// that of a rasteriser: corners on 1/256 pixel of the lattice, pixels' middles,
// the top-left rule. What is nearer is what comes first: rings are numbered
// outwards, and as long as the surface does not fold (ocean/cascade.h,
// ocean/sea.h) a ray crosses them in that order.
#include "lib/blocks.h"
#include "lib/together.glsl"
#include "lib/vertex.glsl"

layout(local_size_x = PEL_GROUP_LINE) in;
layout(std430, binding = PEL_STORE_VERTICES) restrict readonly buffer vertices_block { vertex vertices[]; };
// Of each pixel: all ones less the triangle's number; 0 where there is none.
layout(std430, binding = PEL_STORE_KEYS) restrict buffer keys_block { uint keys[]; };

#ifdef PEL_TOGETHER
// Lists of outlines begin here.
layout(std430, binding = PEL_STORE_SUSPECTS) restrict writeonly buffer suspects_block {
    uint suspect_counts[PEL_TOGETHER_MOST];
};
layout(std430, binding = PEL_STORE_EDGES) restrict writeonly buffer edges_block {
    uint edge_counts[PEL_TOGETHER_MOST];
};
#define vertex_count int(PEL_OWN.first.w)
const int both_sides = 0;
#else
layout(location = 0) uniform int vertex_count;
layout(location = 1) uniform int both_sides; // 1: also the surface's underside
#endif

const float NEAR = 0.05;
const int FAR_OUT = 1 << 22; // 1/256 px; corners beyond are cut by rays instead
const int SMALL_SIDE = 48;   // px; products of edges fit 32 bits below
const int SMALL_AREA = 160;  // px; rows of larger boxes are shared by the group

struct corners {
    vec3 a, b, c;    // in the camera's axes: right, down, forward
    ivec2 p, q, r;   // on the picture, 1/256 px; where all three are in sight
    bool plain;      // they are
    ivec4 box;       // first and last pixel
};

// Of each lane's triangle whose rows the group shares, turned to the front: its
// first row, and where its rows end among those of all.
shared ivec2 large_corners[PEL_GROUP_LINE][3];
shared int large_top[PEL_GROUP_LINE];
shared uint large_end[PEL_GROUP_LINE];
// Those that reach behind the eye.
shared uint wide[PEL_GROUP_LINE];
shared uint wide_count;

vec3 from_camera(int i)
{
    vec3 p = vertices[FIRST_VERTEX + i].position.xyz;
    return vec3(dot(p, right.xyz), -dot(p, up.xyz), -dot(p, back.xyz));
}

vec2 snapped(vec3 c)
{
    vec2 place = c.xy / pixel.xy;
    return floor(place / c.z * 256.0 + 0.5);
}

// Bounds of the part of an edge that lies before the eye.
void bound_edge(vec3 from, vec3 to, inout vec2 least, inout vec2 most)
{
    if (from.z <= NEAR && to.z <= NEAR) {
        return;
    }
    if (from.z <= NEAR) {
        from = mix(to, from, (to.z - NEAR) / (to.z - from.z));
        from.z = NEAR;
    }
    if (to.z <= NEAR) {
        to = mix(from, to, (from.z - NEAR) / (from.z - to.z));
        to.z = NEAR;
    }
    vec2 u = from.xy / from.z;
    vec2 v = to.xy / to.z;
    least = min(least, min(u, v));
    most = max(most, max(u, v));
}

// Whether all corners lie beyond one side of the picture, also behind the eye: the
// bounds of a triangle that reaches there are wide, and hundreds of thousands of
// pixels would be looked at for none.
bool is_beside(corners t)
{
    vec2 first = (pixel.zw - 1.0) * pixel.xy;
    vec2 last = (pixel.zw + size.xy + 1.0) * pixel.xy;
    bvec2 before = lessThan(max(max(t.a.xy - first * t.a.z, t.b.xy - first * t.b.z), t.c.xy - first * t.c.z), vec2(0.0));
    bvec2 after = greaterThan(min(min(t.a.xy - last * t.a.z, t.b.xy - last * t.b.z), t.c.xy - last * t.c.z), vec2(0.0));
    return any(before) || any(after);
}

// False: it covers no pixel.
bool corners_of(uint number, out corners t)
{
    uint id = number - 1u;
    int i = int(id >> 1u);
    const uint NEEDS = VERTEX_LEFT | VERTEX_OUTER;
    if ((uint(vertices[FIRST_VERTEX + i].rest.z) & NEEDS) != NEEDS) {
        return false;
    }
    bool outer = (id & 1u) == 1u; // its first corner lies on the outer ring
    int columns = int(vertices[FIRST_VERTEX + i].position.w);
    int i0 = outer ? i + columns : i;
    t.a = from_camera(i0);
    t.b = from_camera(i0 - 1);
    t.c = from_camera(outer ? i : i + columns - 1);
    vec2 last = size.xy - 1.0;
    ivec2 corner = ivec2(pixel.zw * 256.0);
    t.plain = false;
    t.p = t.q = t.r = ivec2(0);
    if (min(t.a.z, min(t.b.z, t.c.z)) > NEAR) {
        vec2 p = snapped(t.a);
        vec2 q = snapped(t.b);
        vec2 r = snapped(t.c);
        vec2 widest = max(abs(p), max(abs(q), abs(r)));
        if (max(widest.x, widest.y) < float(FAR_OUT)) {
            t.plain = true;
            t.p = ivec2(p) - corner;
            t.q = ivec2(q) - corner;
            t.r = ivec2(r) - corner;
            t.box = ivec4((min(t.p, min(t.q, t.r)) + 127) >> 8, (max(t.p, max(t.q, t.r)) - 128) >> 8);
        }
    }
    if (!t.plain) {
        if (is_beside(t)) {
            return false;
        }
        vec2 least = vec2(1e30);
        vec2 most = vec2(-1e30);
        bound_edge(t.a, t.b, least, most);
        bound_edge(t.b, t.c, least, most);
        bound_edge(t.c, t.a, least, most);
        t.box.xy = ivec2(floor(clamp(least / pixel.xy - pixel.zw - 1.0, -1.0, 1e5)));
        t.box.zw = ivec2(floor(clamp(most / pixel.xy - pixel.zw + 1.0, -1.0, 1e5)));
    }
    t.box.xy = max(t.box.xy, ivec2(0));
    t.box.zw = min(t.box.zw, ivec2(last));
    return t.box.x <= t.box.z && t.box.y <= t.box.w;
}

void take(ivec2 at, uint number)
{
    atomicMax(keys[FIRST_PIXEL + uint(at.y * int(size.x) + at.x)], 0xFFFFFFFFu - number);
}

// Whether an edge's own points belong to it: left edges and lower ones, in
// rows that count upwards.
bool owns(ivec2 edge)
{
    return edge.y < 0 || (edge.y == 0 && edge.x > 0);
}

bool is_front(uint number, bool positive)
{
    return ((number & 1u) == 0u) == positive; // strips alternate
}

void cover_small(corners t, uint number)
{
    ivec2 pq = t.q - t.p;
    ivec2 pr = t.r - t.p;
    int area = pq.x * pr.y - pq.y * pr.x;
    if (area == 0 || (both_sides == 0 && !is_front(number, area > 0))) {
        return;
    }
    if (area < 0) {
        ivec2 swapped = t.q;
        t.q = t.r;
        t.r = swapped;
    }
    ivec2 e0 = t.q - t.p;
    ivec2 e1 = t.r - t.q;
    ivec2 e2 = t.p - t.r;
    ivec2 first = t.box.xy * 256 + 128;
    ivec3 row = ivec3(e0.x * (first.y - t.p.y) - e0.y * (first.x - t.p.x),
                      e1.x * (first.y - t.q.y) - e1.y * (first.x - t.q.x),
                      e2.x * (first.y - t.r.y) - e2.y * (first.x - t.r.x));
    row -= ivec3(owns(e0) ? 0 : 1, owns(e1) ? 0 : 1, owns(e2) ? 0 : 1);
    ivec3 right_step = -256 * ivec3(e0.y, e1.y, e2.y);
    ivec3 down_step = 256 * ivec3(e0.x, e1.x, e2.x);
    for (int y = t.box.y; y <= t.box.w; y++) {
        ivec3 inside = row;
        for (int x = t.box.x; x <= t.box.z; x++) {
            if ((inside.x | inside.y | inside.z) >= 0) {
                take(ivec2(x, y), number);
            }
            inside += right_step;
        }
        row += down_step;
    }
}

// How many rows the group takes of it.
uint share(corners t, uint number, uint lane)
{
    double area = double(t.q.x - t.p.x) * double(t.r.y - t.p.y) -
                  double(t.q.y - t.p.y) * double(t.r.x - t.p.x);
    if (area == 0.0LF || (both_sides == 0 && !is_front(number, area > 0.0LF))) {
        return 0u;
    }
    large_corners[lane] = area < 0.0LF ? ivec2[3](t.p, t.r, t.q) : ivec2[3](t.p, t.q, t.r);
    large_top[lane] = t.box.y;
    return uint(t.box.w - t.box.y + 1);
}

// From rows of each to the ends of them.
void add_up(uint lane, uint rows)
{
    large_end[lane] = rows;
    for (uint step_ = 1u; step_ < uint(PEL_GROUP_LINE); step_ *= 2u) {
        barrier();
        rows += lane >= step_ ? large_end[lane - step_] : 0u;
        barrier();
        large_end[lane] = rows;
    }
    barrier();
}

// The pixels of a row on the inner side of an edge. Numbers are whole and below
// 2^47, so that quotients are on the right side of whole ones.
void bound_row(ivec2 from, ivec2 to, int y, inout ivec2 span)
{
    ivec2 e = to - from;
    double at_first = double(e.x) * double(y * 256 + 128 - from.y) -
                      double(e.y) * double(128 - from.x) - (owns(e) ? 0.0LF : 1.0LF);
    if (e.y == 0) {
        span.y = at_first < 0.0LF ? -1 : span.y;
        return;
    }
    int x = int(clamp(floor(at_first / (256.0LF * double(abs(e.y)))), -1e6LF, 1e6LF));
    span = e.y < 0 ? ivec2(max(span.x, -x), span.y) : ivec2(span.x, min(span.y, x));
}

void cover_row(uint i, int y, uint number)
{
    ivec2 p = large_corners[i][0], q = large_corners[i][1], r = large_corners[i][2];
    ivec2 span = ivec2(0, int(size.x) - 1);
    bound_row(p, q, y, span);
    bound_row(q, r, y, span);
    bound_row(r, p, y, span);
    for (int x = span.x; x <= span.y; x++) {
        take(ivec2(x, y), number);
    }
}

// Slivers fill little of their boxes: lanes take their rows; where there are few
// triangles those of several groups, in y.
void cover_large(uint lane)
{
    uint rows = large_end[PEL_GROUP_LINE - 1];
    uint all = gl_NumWorkGroups.y * uint(PEL_GROUP_LINE);
    uint i = 0u;
    for (uint row = gl_WorkGroupID.y * uint(PEL_GROUP_LINE) + lane; row < rows; row += all) {
        while (large_end[i] <= row) {
            i++;
        }
        uint start = i > 0u ? large_end[i - 1u] : 0u;
        cover_row(i, large_top[i] + int(row - start), gl_WorkGroupID.x * uint(PEL_GROUP_LINE) + i + 1u);
    }
}

// By rays through the pixels of its box.
void cover_wide(corners t, uint number, uint lane)
{
    float area = dot(t.a, cross(t.b, t.c));
    if (area == 0.0 || (both_sides == 0 && !is_front(number, area > 0.0))) {
        return;
    }
    float turned = area < 0.0 ? -1.0 : 1.0;
    vec3 na = cross(t.b, t.c) * turned;
    vec3 nb = cross(t.c, t.a) * turned;
    vec3 nc = cross(t.a, t.b) * turned;
    int across = t.box.z - t.box.x + 1;
    int all = across * (t.box.w - t.box.y + 1);
    int step_ = int(gl_NumWorkGroups.y) * PEL_GROUP_LINE;
    for (int i = int(gl_WorkGroupID.y) * PEL_GROUP_LINE + int(lane); i < all; i += step_) {
        ivec2 at = t.box.xy + ivec2(i % across, i / across);
        vec3 ray = vec3((pixel.zw + vec2(at) + 0.5) * pixel.xy, 1.0);
        vec3 e = vec3(dot(ray, na), dot(ray, nb), dot(ray, nc));
        if (min(e.x, min(e.y, e.z)) >= 0.0 && abs(area) > NEAR * (e.x + e.y + e.z)) {
            take(at, number);
        }
    }
}

void main()
{
    take_view();
    uint lane = gl_LocalInvocationIndex;
    uint number = gl_GlobalInvocationID.x + 1u;
#ifdef PEL_TOGETHER
    if (number == 1u && gl_WorkGroupID.y == 0u && PEL_OWN.picture.x != 0u) {
        suspect_counts[gl_WorkGroupID.z] = 0u;
        edge_counts[gl_WorkGroupID.z] = 0u;
    }
#endif
    if (lane == 0u) {
        wide_count = 0u;
    }
    barrier();
    corners t;
    uint rows = 0u;
    if (number <= uint(vertex_count) * 2u && corners_of(number, t)) {
        ivec2 sides = t.box.zw - t.box.xy + 1;
        ivec2 reach = max(t.p, max(t.q, t.r)) - min(t.p, min(t.q, t.r));
        if (t.plain && sides.x * sides.y <= SMALL_AREA &&
            max(reach.x, reach.y) < SMALL_SIDE * 256) {
            if (gl_WorkGroupID.y == 0u) {
                cover_small(t, number);
            }
        } else if (t.plain) {
            rows = share(t, number, lane);
        } else {
            wide[atomicAdd(wide_count, 1u)] = number;
        }
    }
    add_up(lane, rows);
    cover_large(lane);
    for (uint i = 0u; i < wide_count; i++) {
        corners shared_one;
        if (corners_of(wide[i], shared_one)) {
            cover_wide(shared_one, wide[i], lane);
        }
    }
}
