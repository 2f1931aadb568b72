/* The programs that draw a picture, made when one first needs them. Render
 * thread only. */
#pragma once

#include <epoxy/gl.h>
#include <stdbool.h>

#include "ocean/sea.h"
#include "render/coast.h"
#include "render/filtering.h"
#include "render/shader.h"

/* What the shading of a picture writes. */
enum pel_shading {
    PEL_SHADE_COLOR,  /* the colour only */
    PEL_SHADE_BOTH,   /* the colour and the radiance */
    PEL_SHADE_LIGHT,  /* radiance; in one dispatch also the colour */
    PEL_SHADE_LAYERS, /* and layers of the surface */
    PEL_SHADE_PARTS,  /* and of the water's light taken apart */
    PEL_SHADE_COUNT,
};

/* What a program of the sea knows of objects. */
enum pel_objects_known {
    PEL_OBJECTS_UNKNOWN,
    PEL_OBJECTS_MIRRORED,
    PEL_OBJECTS_ALL, /* their shadows and hulls in the water too */
    /* The same of tiles near one alone, away from coasts. */
    PEL_OBJECTS_ONE_MIRRORED,
    PEL_OBJECTS_ONE,
    PEL_OBJECTS_KNOWN_COUNT
};

/* By the numbers of layers and banks, and whether a layer is above the sea. */
#define PEL_FOG_KINDS (2 * (PEL_FOGS + 1) * (PEL_FOGS + 1))

/* By what the lights of a picture are: how many give light, whether the disc
 * of one that gives none may be seen; and by whether only cameras see it. */
enum pel_programs_light {
    PEL_LIGHT_ONE, /* as by day */
    PEL_LIGHT_ONE_AND_DISC,
    PEL_LIGHT_TWO,
    PEL_LIGHT_NIGHT, /* added to these: with the night's map and stars */
    PEL_LIGHT_PANORAMA = 2 * PEL_LIGHT_NIGHT, /* with a picture as the sky */
    PEL_LIGHT_CLOUDED = 3 * PEL_LIGHT_NIGHT,  /* added to those: with clouds */
    /* Times the kind of fog added to those. */
    PEL_LIGHT_FOGGED = 2 * PEL_LIGHT_CLOUDED,
    /* Added to all: of views none of which is an eye's or a sensor's. Software
     * devices compute both sides of a branch, and what an eye sees by night is
     * a tenth of a picture by day. */
    PEL_LIGHT_CAMERAS = PEL_FOG_KINDS * PEL_LIGHT_FOGGED,
    PEL_LIGHT_KINDS = 2 * PEL_LIGHT_CAMERAS
};

/* How the sky is come by. */
enum pel_sky_look {
    PEL_SKY_DAY,
    PEL_SKY_NIGHT,    /* with the night's map and stars */
    PEL_SKY_PANORAMA, /* from a picture */
    PEL_SKY_LOOKS
};
const char *pel_sky_look_defines(enum pel_sky_look look);

/* What draws one kind of sea, by enum pel_shading. */
struct pel_sea_programs {
    GLuint mesh;
    GLuint together_mesh, together;    /* of views that are drawn together */
    GLuint fragments[PEL_SHADE_COUNT]; /* fragments */
    GLuint compute_program[PEL_SHADE_COUNT]; /* sky, sea and colour in one
                                                dispatch */
    GLuint coast[PEL_SHADE_COUNT];   /* either wrapper, with land and bottom */
    GLuint shallow[PEL_SHADE_COUNT]; /* with the bottom alone */
    /* Either wrapper, in tiles with objects, by enum pel_coast_tile. */
    GLuint objects[PEL_COAST_TILES][PEL_SHADE_COUNT];
    /* Fragments, in other tiles with objects, by enum pel_objects_known. */
    GLuint near[PEL_OBJECTS_KNOWN_COUNT][PEL_SHADE_COUNT];
};

/* Of trochoids and of cascades (odd); without foam, with it, with streaks of
 * it; without areas, with, with wash besides; without and with ship waves, a
 * bottom that waves feel, clouds below the eye, lamps. */
#define PEL_SEA_PROGRAMS 288

/* By enum pel_shading, and those of them that tone for pictures with lamps. */
#define PEL_BACKDROPS (PEL_SHADE_COUNT + PEL_SHADE_LIGHT)

struct pel_programs {
    const char *shader_dir;
    const struct pel_filtering *filtering; /* settled */
    bool software;
    bool compute;   /* shade in one dispatch instead of three */
    bool textured;  /* so are objects */
    bool automatic; /* not chosen by an option: may fall back to fragments */
    GLuint surface, search, tone;
    GLuint outline_find, outline;       /* in compute with either wrapper */
    GLuint outline_mix, outline_put[2]; /* of pictures with lamps */
    GLuint clear_keys;                  /* after outlines, in compute */
    GLuint together_mix;                /* render/together.h */
    /* By the sky's look: without a disc, and with discs. */
    GLuint backdrop[PEL_SKY_LOOKS][PEL_BACKDROPS];
    GLuint disc[PEL_SKY_LOOKS][PEL_BACKDROPS];
    GLuint cloudscape[2][PEL_SKY_LOOKS]; /* of a sky with clouds; in which
                                            lightning may shine */
    enum pel_sky_look look;              /* wanted */
    bool wakes, wash;                    /* those with them are wanted */
    bool above;                          /* for an eye above clouds */
    bool lamps;                          /* that the sea mirrors */
    bool storm;                          /* lightning, in clouds */
    struct pel_sea_programs seas[PEL_SEA_PROGRAMS];
    enum pel_programs_light light;
    struct pel_programs *others[PEL_LIGHT_KINDS]; /* for other lights, kept */
};

/* That draws the clouds of what is wanted. */
GLuint *pel_programs_cloudscape(struct pel_programs *p);

/* `shading` as in pel_renderer_options; `filtering`, settled, outlives the
 * programs. */
void pel_programs_init(struct pel_programs *p, const char *shader_dir,
                       bool software, const char *shading,
                       const struct pel_filtering *filtering);
void pel_programs_finish(struct pel_programs *p);

/* Whether objects are textured: forgets the programs that show them. */
void pel_programs_texture(struct pel_programs *p, bool textured);

/* Takes the programs for these lights, made as they are needed; those of others
 * are kept. GPU, NO_MEMORY. */
PEL_CHECK enum pel_err pel_programs_take_light(struct pel_programs *p,
                                               enum pel_programs_light light,
                                               struct pel_fault *fault);

/* What a view that is drawn by itself wants of all kinds of sea. GPU. */
PEL_CHECK enum pel_err pel_programs_need_alone(struct pel_programs *p,
                                               struct pel_fault *fault);

/* The place of a backdrop's program. */
int pel_programs_backdrop(const struct pel_programs *p, enum pel_shading kind);

/* Whether clouds or fog veil the lights; what of the above they add. */
bool pel_light_veiled(const struct pel_environment *env);
enum pel_programs_light pel_light_veils(const struct pel_environment *env);

/* The place of programs that differ by the lights, clouds and fog alone, below
 * PEL_LIGHT_PROGRAMS, and what they define. */
#define PEL_LIGHT_PROGRAMS (2 * PEL_LIGHTS * PEL_FOG_KINDS)
int pel_light_program(const struct pel_environment *env);
const char *pel_light_program_defines(const struct pel_environment *env);

/* What all shaders define by the lights, shorter than PEL_LIGHT_TEXT. */
#define PEL_LIGHT_TEXT 192
const char *pel_light_defines(enum pel_programs_light light);

/* What programs that place the sea's surface define, and those that show its
 * foam. */
#define PEL_SURFACE_TEXT 192
void pel_programs_surface(const struct pel_programs *all,
                          const struct pel_sea *sea,
                          char out[PEL_SURFACE_TEXT]);
const char *pel_programs_foam(const struct pel_sea *sea);

/* What the shaders of this kind define. */
const char *pel_shading_defines(enum pel_shading kind);

/* What those define that tone, where only cameras see. */
const char *pel_cameras_define(enum pel_programs_light light);

/* Makes the programs that this sea wants for a picture; `coast`: also those
 * over a height field, `objects`: those of tiles with objects. Where compute
 * was not asked for and does not compile, fragments replace it for good. GPU.
 */
PEL_CHECK enum pel_err pel_programs_need(struct pel_programs *p,
                                         const struct pel_sea *sea,
                                         enum pel_shading kind, bool coast,
                                         bool objects, struct pel_fault *fault);

/* Makes those of outlines, after pel_programs_need; a driver that does not
 * compile shading in compute draws none (false). */
bool pel_programs_have_edges(const struct pel_programs *p);
PEL_CHECK enum pel_err pel_programs_need_edges(struct pel_programs *p,
                                               struct pel_fault *fault);

/* Makes those that views are drawn together by (render/together.h), with their
 * outlines or without. */
PEL_CHECK enum pel_err pel_programs_need_together(struct pel_programs *p,
                                                  const struct pel_sea *sea,
                                                  bool outlines,
                                                  struct pel_fault *fault);

/* The same as pel_programs_need for tiles where no ship has been, without ship
 * waves and wash. */
PEL_CHECK enum pel_err pel_programs_need_still(struct pel_programs *p,
                                               const struct pel_sea *sea,
                                               enum pel_shading kind,
                                               bool coast, bool objects,
                                               struct pel_fault *fault);
const struct pel_sea_programs *pel_programs_still(struct pel_programs *p,
                                                  const struct pel_sea *sea);

/* Those that draw this sea. */
const struct pel_sea_programs *pel_programs_of(struct pel_programs *p,
                                               const struct pel_sea *sea);
