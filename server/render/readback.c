#include "render/readback.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"
#include "render/ycbcr.h"

/* A buffer larger than this goes when so many pictures did not need it. */
#define KEPT_BYTES (16u << 20)
#define PASSED_BY (2 * PEL_READBACK_SLOTS)
#define ALIGN 256 /* layers start on cache lines and SIMD boundaries */

struct pel_readback_slot {
    struct pel_picture picture; /* first: released by its address */
    GLuint buffer;
    uint8_t *map;
    size_t capacity;
    uint64_t filled_at; /* pictures until one needed a quarter of it */
    GLsync fence;
    bool fence_on; /* the fence is of a picture behind it, too */
    int64_t started_ns;
    size_t ev_offset;
    bool auto_exposure;
    atomic_bool busy;
};

static size_t align_up(size_t n)
{
    return (n + ALIGN - 1) / ALIGN * ALIGN;
}

enum pel_err pel_readback_init(struct pel_readback *r)
{
    *r = (struct pel_readback){ 0 };
    r->slots = calloc(PEL_READBACK_SLOTS, sizeof *r->slots);
    if (!r->slots) {
        return PEL_ERR_NO_MEMORY;
    }
    glCreateFramebuffers(1, &r->read_fbo);
    return PEL_OK;
}

/* No picture is in it. */
static void drop_buffer(struct pel_readback_slot *slot)
{
    glDeleteBuffers(1, &slot->buffer);
    slot->buffer = 0;
    slot->map = NULL;
    slot->capacity = 0;
}

bool pel_readback_give_one(struct pel_readback *r)
{
    for (size_t i = 0; r->slots && i < PEL_READBACK_SLOTS; i++) {
        if (r->slots[i].buffer) {
            drop_buffer(&r->slots[i]);
            return true;
        }
    }
    return false;
}

void pel_readback_finish(struct pel_readback *r)
{
    if (!r->slots) {
        return;
    }
    glDeleteSync(r->band);
    for (size_t i = 0; i < PEL_READBACK_SLOTS; i++) {
        struct pel_readback_slot *slot = &r->slots[i];
        if (slot->fence && !slot->fence_on) {
            glDeleteSync(slot->fence);
        }
        glDeleteBuffers(1, &slot->buffer);
    }
    glDeleteFramebuffers(1, &r->read_fbo);
    free(r->slots);
    *r = (struct pel_readback){ 0 };
}

size_t pel_readback_free(const struct pel_readback *r)
{
    size_t count = 0;
    for (size_t i = 0; i < PEL_READBACK_SLOTS; i++) {
        count += !atomic_load_explicit(&r->slots[i].busy, memory_order_acquire);
    }
    return count;
}

static void trim(struct pel_readback *r)
{
    for (size_t i = 0; i < PEL_READBACK_SLOTS; i++) {
        struct pel_readback_slot *slot = &r->slots[i];
        if (slot->capacity > KEPT_BYTES &&
            r->pushed - slot->filled_at > PASSED_BY &&
            !atomic_load_explicit(&slot->busy, memory_order_acquire)) {
            drop_buffer(slot);
        }
    }
}

void pel_readback_rest(struct pel_readback *r)
{
    for (size_t i = 0; i < PEL_READBACK_SLOTS; i++) {
        struct pel_readback_slot *slot = &r->slots[i];
        if (slot->capacity > KEPT_BYTES &&
            !atomic_load_explicit(&slot->busy, memory_order_acquire)) {
            drop_buffer(slot);
        }
    }
}

/* The free slot that fits best; growing one only when none is large enough. */
static struct pel_readback_slot *take_slot(struct pel_readback *r, size_t size)
{
    struct pel_readback_slot *fit = NULL, *largest = NULL;
    for (size_t i = 0; i < PEL_READBACK_SLOTS; i++) {
        struct pel_readback_slot *slot = &r->slots[i];
        if (atomic_load_explicit(&slot->busy, memory_order_acquire)) {
            continue;
        }
        if (slot->capacity >= size &&
            (!fit || slot->capacity < fit->capacity)) {
            fit = slot;
        }
        if (!largest || slot->capacity > largest->capacity) {
            largest = slot;
        }
    }
    if (fit || !largest) {
        return fit;
    }
    const GLbitfield bits =
        GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    glDeleteBuffers(1, &largest->buffer);
    glCreateBuffers(1, &largest->buffer);
    glNamedBufferStorage(largest->buffer, (GLsizeiptr)size, NULL,
                         bits | GL_CLIENT_STORAGE_BIT);
    glObjectLabel(GL_BUFFER, largest->buffer, -1, "readback");
    largest->map =
        glMapNamedBufferRange(largest->buffer, 0, (GLsizeiptr)size, bits);
    largest->capacity = largest->map ? size : 0;
    return largest->map ? largest : NULL;
}

/* Queues the copy of every wanted layer to the bound pack buffer. */
static void copy_layers(const struct pel_readback *r,
                        const struct pel_readback_source *s, const uint8_t *map,
                        const size_t at[PEL_LAYERS],
                        const float *found[PEL_LAYERS])
{
    static const GLenum formats[] = { 0, GL_RED, GL_RG, 0, GL_RGBA };
    const uint8_t *base = NULL; /* offsets into the pack buffer */
    const unsigned stored = pel_layers_stored(s->layers);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, r->read_fbo);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        if (stored & l->bit) {
            glNamedFramebufferTexture(r->read_fbo, GL_COLOR_ATTACHMENT0,
                                      s->planes[i], 0);
            size_t before = (size_t)s->first_row * s->width * sizeof(float) *
                            (size_t)pel_layer_stride(l);
            glReadPixels(s->x, s->y, (GLsizei)s->width, (GLsizei)s->rows,
                         formats[pel_layer_stride(l)], GL_FLOAT,
                         (void *)(base + at[i] + before));
            found[i] = (const float *)(map + at[i]);
        }
    }
    /* The textures may go before the next picture. */
    glNamedFramebufferTexture(r->read_fbo, GL_COLOR_ATTACHMENT0, 0, 0);
}

/* The slot of the picture that the source is of; NULL: there is none. */
static struct pel_readback_slot *slot_of(struct pel_readback *r,
                                         const struct pel_readback_source *s,
                                         size_t size)
{
    struct pel_readback_slot *slot = r->open;
    if (s->first_row == 0) {
        if (s->rows < s->height) {
            pel_readback_drop_bands(r);
        }
        trim(r);
        slot = take_slot(r, size);
        if (slot) {
            r->pushed++;
            slot->started_ns = s->started_ns;
        }
        if (slot && 4 * size > slot->capacity) {
            slot->filled_at = r->pushed;
        }
    }
    return slot;
}

static void keep_open(struct pel_readback *r, struct pel_readback_slot *slot)
{
    atomic_store_explicit(&slot->busy, true, memory_order_release);
    r->open = slot;
    glDeleteSync(r->band);
    r->band = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    glFlush();
}

bool pel_readback_band_done(struct pel_readback *r, int64_t wait_ns)
{
    GLenum state = r->band
                       ? glClientWaitSync(r->band, GL_SYNC_FLUSH_COMMANDS_BIT,
                                          wait_ns > 0 ? (GLuint64)wait_ns : 0)
                       : GL_ALREADY_SIGNALED;
    if (state == GL_TIMEOUT_EXPIRED) {
        return false;
    }
    glDeleteSync(r->band);
    r->band = NULL;
    return true;
}

void pel_readback_drop_bands(struct pel_readback *r)
{
    if (r->open) {
        atomic_store_explicit(&r->open->busy, false, memory_order_release);
        r->open = NULL;
    }
}

enum pel_err pel_readback_push(struct pel_readback *r,
                               const struct pel_readback_source *s)
{
    size_t pixels = (size_t)s->width * s->height;
    const unsigned stored = pel_layers_stored(s->layers);
    size_t at[PEL_LAYERS];
    size_t size = s->layers & PEL_LAYER_COLOR ? align_up(pixels * 4) : 0;
    for (int i = 0; i < PEL_LAYERS; i++) {
        const struct pel_layer_info *l = &pel_layer_table[i];
        at[i] = size;
        if (stored & l->bit) {
            size +=
                align_up(pixels * sizeof(float) * (size_t)pel_layer_stride(l));
        }
    }
    size_t ev_offset = size;
    struct pel_readback_slot *slot = slot_of(r, s, ev_offset + 16);
    if (!slot) {
        return PEL_ERR_BUSY;
    }
    uint8_t *base = NULL; /* offsets into the pack buffer */
    glBindBuffer(GL_PIXEL_PACK_BUFFER, slot->buffer);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    if (s->layers & PEL_LAYER_COLOR) {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, s->color_fbo);
        glReadBuffer(GL_COLOR_ATTACHMENT0);
        glReadPixels(s->x, s->y, (GLsizei)s->width, (GLsizei)s->rows, GL_RGBA,
                     GL_UNSIGNED_BYTE,
                     base + (size_t)s->first_row * s->width * 4);
    }
    const float *found[PEL_LAYERS] = { NULL };
    copy_layers(r, s, slot->map, at, found);
    /* What was attached when it was read counts as being rendered to while the
     * framebuffer stays bound: NVIDIA's driver (580) then loses what the next
     * dispatch writes into it. */
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    if (s->first_row + s->rows < s->height) {
        keep_open(r, slot);
        return PEL_OK;
    }
    r->open = s->first_row > 0 ? NULL : r->open;
    glCopyNamedBufferSubData(s->exposure, slot->buffer, 0, (GLintptr)ev_offset,
                             16);
    slot->fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    slot->fence_on = false;
    glFlush();
    slot->picture = (struct pel_picture){
        .user = s->user,
        .width = s->width,
        .height = s->height,
        .exposure_ev = s->exposure_ev,
        .rgba = s->layers & PEL_LAYER_COLOR ? slot->map : NULL,
    };
    memcpy(slot->picture.layer, found, sizeof found);
    slot->ev_offset = ev_offset;
    slot->auto_exposure = s->auto_exposure;
    atomic_store_explicit(&slot->busy, true, memory_order_release);
    r->order[(r->head + r->in_flight++) % PEL_READBACK_SLOTS] = slot;
    return PEL_OK;
}

struct pel_readback_slot *
pel_readback_reserve(struct pel_readback *r,
                     const struct pel_readback_source *s)
{
    const bool planes = s->ycbcr != PEL_YCBCR_NONE;
    const struct pel_ycbcr_layout layout =
        pel_ycbcr_layout(s->ycbcr, s->width, s->height);
    size_t ev_offset =
        align_up(planes ? layout.size : (size_t)s->width * s->height * 4);
    struct pel_readback_slot *slot = slot_of(r, s, ev_offset + 16);
    if (!slot) {
        return NULL;
    }
    slot->picture = (struct pel_picture){
        .user = s->user,
        .width = s->width,
        .height = s->height,
        .exposure_ev = s->exposure_ev,
        .rgba = planes ? NULL : slot->map,
        .ycbcr = s->ycbcr,
    };
    if (s->ycbcr == PEL_YCBCR_CODED) {
        slot->picture.scan = (struct pel_jpeg_scan){
            .words = (const uint32_t *)(const void *)slot->map,
            .quality = s->quality,
        };
    }
    for (int i = 0; planes && i < layout.count; i++) {
        slot->picture.planes[i] = slot->map + layout.offset[i];
        slot->picture.strides[i] = (int)layout.stride[i];
    }
    slot->ev_offset = ev_offset;
    slot->auto_exposure = s->auto_exposure;
    atomic_store_explicit(&slot->busy, true, memory_order_release);
    return slot;
}

void pel_readback_unreserve(struct pel_readback_slot *const slots[],
                            size_t count)
{
    for (size_t i = 0; i < count; i++) {
        pel_picture_release(&slots[i]->picture);
    }
}

GLuint pel_readback_buffer(const struct pel_readback_slot *slot)
{
    return slot->buffer;
}

size_t pel_readback_ev_offset(const struct pel_readback_slot *slot)
{
    return slot->ev_offset;
}

void pel_readback_send(struct pel_readback *r,
                       struct pel_readback_slot *const slots[], size_t count)
{
    GLsync fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    glFlush();
    for (size_t i = 0; i < count; i++) {
        slots[i]->fence = fence;
        slots[i]->fence_on = i + 1 < count;
        r->order[(r->head + r->in_flight++) % PEL_READBACK_SLOTS] = slots[i];
    }
}

struct pel_picture *pel_readback_pop(struct pel_readback *r, int64_t wait_ns)
{
    if (r->in_flight == 0) {
        return NULL;
    }
    struct pel_readback_slot *slot = r->order[r->head];
    GLenum state = glClientWaitSync(slot->fence, GL_SYNC_FLUSH_COMMANDS_BIT,
                                    wait_ns > 0 ? (GLuint64)wait_ns : 0);
    if (state == GL_TIMEOUT_EXPIRED) {
        return NULL;
    }
    if (state == GL_WAIT_FAILED) {
        pel_error("RND-020", "waiting for pixels failed (GL 0x%x)",
                  glGetError());
    }
    if (!slot->fence_on) {
        glDeleteSync(slot->fence);
    }
    slot->fence = NULL;
    r->head = (r->head + 1) % PEL_READBACK_SLOTS;
    r->in_flight--;
    if (slot->auto_exposure) {
        slot->picture.exposure_ev =
            *(const float *)(slot->map + slot->ev_offset);
    }
    slot->picture.drawn_ns = pel_now_ns();
    slot->picture.render_ms =
        (double)(slot->picture.drawn_ns - slot->started_ns) * 1e-6;
    return &slot->picture;
}

size_t pel_readback_abandon(struct pel_readback *r, void **users, size_t most)
{
    size_t count = 0;
    while (r->in_flight > 0 && count < most) {
        struct pel_readback_slot *slot = r->order[r->head];
        users[count++] = slot->picture.user;
        r->head = (r->head + 1) % PEL_READBACK_SLOTS;
        r->in_flight--;
        pel_picture_release(&slot->picture);
    }
    return count;
}

void pel_picture_release(struct pel_picture *picture)
{
    if (picture) {
        struct pel_readback_slot *slot = (struct pel_readback_slot *)picture;
        atomic_store_explicit(&slot->busy, false, memory_order_release);
    }
}
