// Sparkle: of the waves that a pixel does not resolve the longest are so few
// in it that their slopes do not average out. Includers have lib/turns.glsl.

// A hash (Jarzynski and Olano 2020: pcg3d).
uvec3 glint_hash(uvec3 v)
{
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Of a footprint that holds many waves of every length all slopes average out.
float glint_share(float footprint)
{
    float waves = footprint / PEL_GLINT_LONGEST;
    return blue.w / (1.0 + waves * waves);
}

// The mean slope of what a pixel does not resolve, as two independent normal
// numbers: of a cell as large as a pixel on the sphere of directions (Lambert's
// map, true to area), so that glints stay where they are when the camera turns,
// for about a period of the waves as long as the footprint.
vec2 glint_slopes(vec3 dir, float footprint)
{
    ivec2 cell = ivec2(floor(dir.xy * (sqrt(2.0 / (1.0 + abs(dir.z))) / pixel.x)));
    uint place = uint(cell.x & 0xffff) | uint(cell.y) << 16u;
    uvec3 first = glint_hash(uvec3(place, dir.z > 0.0 ? 1u : 0u, 0u));
    // Cells change one by one.
    uint octave = uint(clamp(0.5 * log2(footprint / PEL_GLINT_SHORTEST), 0.0, 5.0));
    uint lives = uint(red.w);
    float part = (float(lives & ((1u << octave) - 1u)) + green.w) / float(1u << octave);
    uint begun = (lives >> octave) + (part + float(first.x >> 8u) / 16777216.0 >= 1.0 ? 1u : 0u);
    uvec3 now = glint_hash(uvec3(place, first.y + octave, begun));
    vec2 even = (vec2(now.xy >> 8u) + 0.5) / 16777216.0;
    return sqrt(-2.0 * log(even.x)) * sine_cosine_turns(even.y).yx;
}
