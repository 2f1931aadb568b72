// A vertex of the mesh (mesh.comp).
struct vertex {
    vec4 position; // from the eye; w: column count of its block
    vec4 rest;     // place at rest, from the eye's nadir; z: flags below; w: ring
};

// What it has beside it in its block: a column to its left, a ring inside its
// own, a ring outside.
const uint VERTEX_LEFT = 1u;
const uint VERTEX_INNER = 2u;
const uint VERTEX_OUTER = 4u;
const uint VERTEX_BLOCK = 3u; // from this bit on: its block
