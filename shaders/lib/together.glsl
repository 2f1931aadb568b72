// What is a view's own: where several are drawn together, that of this layer of
// the dispatch. Includers have lib/blocks.h.
#ifndef PEL_TOGETHER_GLSL
#define PEL_TOGETHER_GLSL
#ifdef PEL_TOGETHER
#define PEL_OWN together[gl_WorkGroupID.z]
#define FIRST_VERTEX int(PEL_OWN.first.x)
#define FIRST_RING int(PEL_OWN.first.y)
#define FIRST_PIXEL PEL_OWN.first.z
#define COLUMN_ANGLE PEL_OWN.columns.x
#define COLUMNS_AROUND int(PEL_OWN.columns.y)
#define MESH_BLOCKS int(PEL_OWN.picture.z)
#define MESH_BLOCK(i) ivec4(PEL_OWN.blocks[i])
#define MESH_BASE(i) int(PEL_OWN.bases[i].x)
#ifndef PEL_METER
#define exposure exposures[gl_WorkGroupID.z].exposure
#define exposing exposures[gl_WorkGroupID.z].exposing
#define rods exposures[gl_WorkGroupID.z].rods
#define glare exposures[gl_WorkGroupID.z].glare
#endif

// Members of the block `view`.
PEL_VIEW_MEMBERS

void take_view()
{
    right = PEL_OWN.view.right;
    up = PEL_OWN.view.up;
    back = PEL_OWN.view.back;
    pixel = PEL_OWN.view.pixel;
    size = PEL_OWN.view.size;
    sensor = PEL_OWN.view.sensor;
    sensor_seed = PEL_OWN.view.sensor_seed;
}
#else
#define FIRST_VERTEX 0
#define FIRST_RING 0
#define FIRST_PIXEL 0u
#define COLUMN_ANGLE eye.z
#define COLUMNS_AROUND int(eye.w)
#define MESH_BLOCKS block_count
#define MESH_BLOCK(i) blocks[i]
#define MESH_BASE(i) bases[i]

void take_view()
{
}
#endif
#endif
