/* Triangles and the first of them that a ray meets. */
#ifndef SHIPMESH_H
#define SHIPMESH_H

#include <stddef.h>

struct ship_triangle {
    double corner[3][3];
    double normal[3]; /* unit */
    double albedo;
};

struct ship_node {
    double low[3], high[3];
    int first, count; /* of triangles; count 0: children */
    int child;        /* the first of two */
};

struct ship_mesh {
    int triangles, nodes;
    struct ship_triangle *triangle;
    struct ship_node *node;
};

struct ship_hit {
    double distance;
    double normal[3]; /* turned against the ray */
    double albedo;
};

/* Fills normals and sorts the triangles into boxes. Ends the program without
 * memory. The triangles are the mesh's from then on. */
void ship_mesh_init(struct ship_mesh *mesh, struct ship_triangle *triangle,
                    int count);
void ship_mesh_finish(struct ship_mesh *mesh);

/* Whether anything is met between 1e-4 m and `farthest`; where hit is not
 * NULL the nearest. The direction is a unit vector. */
int ship_mesh_cast(const struct ship_mesh *mesh, const double *from,
                   const double *direction, double farthest,
                   struct ship_hit *hit);

#endif
