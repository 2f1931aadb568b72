/* Readback: a pool of persistently mapped buffers that pixels are packed into
 * while later frames are drawn. Render thread, except pel_picture_release. */
#pragma once

#include <epoxy/gl.h>

#include "render/renderer.h"

#define PEL_READBACK_SLOTS (PEL_MAX_VIEWS * 2 + 16)

struct pel_readback_slot;

struct pel_readback {
    struct pel_readback_slot *slots; /* PEL_READBACK_SLOTS */
    GLuint read_fbo;                 /* around the layer that is copied */
    size_t head, in_flight;          /* ring of submission order */
    uint64_t pushed;                 /* pictures so far */
    struct pel_readback_slot *order[PEL_READBACK_SLOTS];
    struct pel_readback_slot *open; /* some bands of a picture are in it */
    GLsync band;                    /* of the last one; NULL: none */
};

/* Where the layers of one picture are read from. */
struct pel_readback_source {
    GLuint color_fbo;     /* RGBA8 */
    const GLuint *planes; /* textures by PEL_AT_* */
    GLuint exposure; /* buffer that begins with the automatic EV100 (float) */
    bool auto_exposure;
    double exposure_ev;       /* where not automatic */
    uint32_t width, height;   /* of the picture */
    uint32_t first_row, rows; /* that are read now */
    int x, y;                 /* where they begin in the textures */
    unsigned layers;
    enum pel_ycbcr ycbcr; /* reserved: what shaders write */
    int quality;          /* of what is coded */
    void *user;
    int64_t started_ns;
};

PEL_CHECK enum pel_err pel_readback_init(struct pel_readback *r);
void pel_readback_finish(struct pel_readback *r);
/* Gives back large buffers in which no picture is. */
void pel_readback_rest(struct pel_readback *r);
/* Gives one buffer back, which no picture is in; false: there is none left. */
bool pel_readback_give_one(struct pel_readback *r);

/* Queues the copies and a fence; BUSY when no slot is free. Bands of a picture
 * come from the top to the bottom, of one picture at a time; it is in flight
 * with the last. */
PEL_CHECK enum pel_err pel_readback_push(struct pel_readback *r,
                                         const struct pel_readback_source *s);

/* For pictures of colours alone, which shaders write: whole ones, with the
 * members of *s that say where they are read from left out. A slot for one,
 * NULL: none is free, or no memory; and those that are given up. */
struct pel_readback_slot *
pel_readback_reserve(struct pel_readback *r,
                     const struct pel_readback_source *s);
void pel_readback_unreserve(struct pel_readback_slot *const slots[],
                            size_t count);
/* Its buffer: colours, top row first, tightly packed, or planes, and at an
 * offset in bytes the EV100 (float). */
GLuint pel_readback_buffer(const struct pel_readback_slot *slot);
size_t pel_readback_ev_offset(const struct pel_readback_slot *slot);
/* What was given to write them is on its way: they are in flight in this order,
 * behind one fence. */
void pel_readback_send(struct pel_readback *r,
                       struct pel_readback_slot *const slots[], size_t count);

/* Whether the last band's pixels are there within wait_ns. */
bool pel_readback_band_done(struct pel_readback *r, int64_t wait_ns);
/* Discards a picture whose last band has not come. */
void pel_readback_drop_bands(struct pel_readback *r);

/* Oldest picture if its pixels are there within wait_ns, else NULL. */
struct pel_picture *pel_readback_pop(struct pel_readback *r, int64_t wait_ns);

/* Gives up all pictures in flight, oldest first: their `user`, at most `most`;
 * how many. Without GL. */
size_t pel_readback_abandon(struct pel_readback *r, void **users, size_t most);

/* Slots that are free now. */
size_t pel_readback_free(const struct pel_readback *r);
