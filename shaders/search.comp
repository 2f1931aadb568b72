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
#define vertex_count int(PEL_OWN.first.w)
const int both_sides = 0;
#else
layout(location = 0) uniform int vertex_count;
layout(location = 1) uniform int both_sides; // 1: also the surface's underside
#endif

const float NEAR = 0.05;
const int FAR_OUT = 1 << 22; // 1/256 px; corners beyond are cut by rays instead
const int SMALL_SIDE = 48;   // px; products of edges fit 32 bits below
const int SMALL_AREA = 160;  // px; larger boxes are shared by the group

struct corners {
    vec3 a, b, c;    // in the camera's axes: right, down, forward
    ivec2 p, q, r;   // on the picture, 1/256 px; where all three are in sight
    bool plain;      // they are
    ivec4 box;       // first and last pixel
};

shared uint large[64];
shared uint large_count;

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

double edge_at(ivec2 from, ivec2 to, ivec2 at)
{
    ivec2 e = to - from;
    double value = double(e.x) * double(at.y - from.y) - double(e.y) * double(at.x - from.x);
    return owns(e) ? value : value - 0.5LF;
}

void cover_large(corners t, uint number, uint lane)
{
    double area = 0.0LF;
    if (t.plain) {
        area = double(t.q.x - t.p.x) * double(t.r.y - t.p.y) -
               double(t.q.y - t.p.y) * double(t.r.x - t.p.x);
    } else {
        area = double(dot(t.a, cross(t.b, t.c)));
    }
    if (area == 0.0LF || (both_sides == 0 && !is_front(number, area > 0.0LF))) {
        return;
    }
    bool turned = area < 0.0LF;
    ivec2 q = turned ? t.r : t.q;
    ivec2 r = turned ? t.q : t.r;
    vec3 na = cross(t.b, t.c) * (turned ? -1.0 : 1.0);
    vec3 nb = cross(t.c, t.a) * (turned ? -1.0 : 1.0);
    vec3 nc = cross(t.a, t.b) * (turned ? -1.0 : 1.0);
    int wide = t.box.z - t.box.x + 1;
    int all = wide * (t.box.w - t.box.y + 1);
    for (int i = int(lane); i < all; i += 64) {
        ivec2 at = t.box.xy + ivec2(i % wide, i / wide);
        bool inside;
        if (t.plain) {
            ivec2 middle = at * 256 + 128;
            inside = edge_at(t.p, q, middle) >= 0.0LF && edge_at(q, r, middle) >= 0.0LF &&
                     edge_at(r, t.p, middle) >= 0.0LF;
        } else {
            vec3 ray = vec3((pixel.zw + vec2(at) + 0.5) * pixel.xy, 1.0);
            vec3 e = vec3(dot(ray, na), dot(ray, nb), dot(ray, nc));
            float sum = e.x + e.y + e.z;
            inside = min(e.x, min(e.y, e.z)) >= 0.0 && abs(float(area)) > NEAR * sum;
        }
        if (inside) {
            take(at, number);
        }
    }
}

void main()
{
    take_view();
    uint lane = gl_LocalInvocationIndex;
    uint number = gl_GlobalInvocationID.x + 1u;
    if (lane == 0u) {
        large_count = 0u;
    }
    barrier();
    corners t;
    if (number <= uint(vertex_count) * 2u && corners_of(number, t)) {
        ivec2 sides = t.box.zw - t.box.xy + 1;
        ivec2 reach = max(t.p, max(t.q, t.r)) - min(t.p, min(t.q, t.r));
        if (t.plain && sides.x * sides.y <= SMALL_AREA &&
            max(reach.x, reach.y) < SMALL_SIDE * 256) {
            cover_small(t, number);
        } else {
            large[atomicAdd(large_count, 1u)] = number;
        }
    }
    barrier();
    for (uint i = 0u; i < large_count; i++) {
        corners shared_one;
        if (corners_of(large[i], shared_one)) {
            cover_large(shared_one, large[i], lane);
        }
    }
}
