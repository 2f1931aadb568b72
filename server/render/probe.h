/* Single values of the functions that shade, from the device that draws: what
 * optics/lightreport.h computes in C. Render thread only. */
#pragma once

#include <epoxy/gl.h>

#include "optics/lightreport.h"

struct pel_probe {
    struct pel_vec3 dir; /* unit, east, north, up: to the eye for the sea, to
                            the place in the sky for the sky */
    double slope_along, slope_cross;
    double height_m; /* of the eye */
};

/* The sea is as `dir` sees it where that points up. */
struct pel_probe_answer {
    struct pel_brdf_terms sea;
    struct pel_sky_terms sky;
};

struct pel_prober {
    GLuint program[PEL_LIGHTS], buffer; /* by the number of lights, less one */
};

/* Makes the program for so many lights at first use. */
PEL_CHECK enum pel_err pel_prober_init(struct pel_prober *p, int lit,
                                       const char *shader_dir,
                                       struct pel_fault *fault);
void pel_prober_finish(struct pel_prober *p);

/* sun: its place among the lights. The blocks frame, eye, light, facets and the
 * tables are bound. */
void pel_prober_run(struct pel_prober *p, int lit, int sun,
                    const struct pel_probe *probe,
                    struct pel_probe_answer *out);
