#include "render/ycbcr.h"

#include "encode/jpegcode.h"
#include "render/room.h"
#include "render/shader.h"

#define BLOCK 16u                         /* of JPEG, and of H.264 */
#define ALIGN 256u                        /* of parts of storage buffers */
#define WIDE_PIXELS (4u * PEL_GROUP_LINE) /* of a group, in two rows */

_Static_assert((int)PEL_YCBCR_NONE == PEL_YCBCR_FORM_NONE &&
                   (int)PEL_YCBCR_JPEG == PEL_YCBCR_FORM_JPEG &&
                   (int)PEL_YCBCR_VIDEO == PEL_YCBCR_FORM_VIDEO,
               "shaders know them by these numbers");

static size_t round_up(size_t n, size_t to)
{
    return (n + to - 1) / to * to;
}

struct pel_ycbcr_layout pel_ycbcr_layout(enum pel_ycbcr form, uint32_t width,
                                         uint32_t height)
{
    size_t wide = round_up(width, BLOCK), high = round_up(height, BLOCK);
    size_t luma = wide * high;
    size_t chroma = form == PEL_YCBCR_VIDEO ? wide : wide / 2;
    if (form == PEL_YCBCR_CODED) {
        return (struct pel_ycbcr_layout){
            .size = pel_jpeg_groups(width, height) * PEL_JPEG_GROUP_WORDS * 4
        };
    }
    return (struct pel_ycbcr_layout){
        .count = form == PEL_YCBCR_VIDEO ? 2 : 3,
        .stride = { wide, chroma, chroma },
        .offset = { 0, luma, luma + luma / 4 },
        .size = luma * 3 / 2,
    };
}

enum pel_err pel_ycbcr_need(struct pel_ycbcr_pass *p, bool together,
                            enum pel_ycbcr form, const char *shader_dir,
                            struct pel_fault *fault)
{
    enum pel_err err = form == PEL_YCBCR_CODED
                           ? pel_jpeg_coder_need(&p->coder, shader_dir, fault)
                           : PEL_OK;
    if (err != PEL_OK) {
        return err;
    }
    GLuint *program = together ? &p->together : &p->one;
    return *program
               ? PEL_OK
               : pel_program_create(shader_dir, "ycbcr.comp", NULL,
                                    together ? "#define PEL_TOGETHER\n" : NULL,
                                    program, fault);
}

void pel_ycbcr_finish(struct pel_ycbcr_pass *p)
{
    pel_program_delete(p->one);
    pel_program_delete(p->together);
    glDeleteBuffers(1, &p->colors);
    pel_jpeg_coder_finish(&p->coder);
    *p = (struct pel_ycbcr_pass){ 0 };
}

/* Of what is coded, before it is. */
static size_t plane_bytes(const struct pel_ycbcr_view *v)
{
    return pel_ycbcr_layout(PEL_YCBCR_JPEG, v->width, v->height).size;
}

/* Gives planes that are coded their places on the device. */
static void fit_planes(struct pel_ycbcr_pass *p, struct pel_ycbcr_view *views,
                       size_t count)
{
    size_t size = 0;
    for (size_t i = 0; i < count; i++) {
        if (views[i].form == PEL_YCBCR_CODED) {
            views[i].planes_at = size;
            size += round_up(plane_bytes(&views[i]) + sizeof(float), ALIGN);
        }
    }
    if (size > 0) {
        pel_jpeg_coder_fit(&p->coder, size);
    }
}

static size_t pixel_bytes(const struct pel_ycbcr_view *v)
{
    return (size_t)v->width * v->height * 4;
}

void pel_ycbcr_fit(struct pel_ycbcr_pass *p, struct pel_ycbcr_view *views,
                   size_t count)
{
    size_t size = 0;
    fit_planes(p, views, count);
    for (size_t i = 0; i < count; i++) {
        views[i].at = size;
        size += round_up(pixel_bytes(&views[i]) + sizeof(float), ALIGN);
    }
    pel_room_fit(&p->colors, &p->capacity, size, "colours together");
}

void pel_ycbcr_begin(struct pel_ycbcr_pass *p,
                     const struct pel_ycbcr_view *views, size_t count)
{
    GLuint buffers[PEL_TOGETHER_MOST];
    GLintptr at[PEL_TOGETHER_MOST];
    GLsizeiptr bytes[PEL_TOGETHER_MOST];
    for (size_t i = 0; i < PEL_TOGETHER_MOST; i++) {
        const struct pel_ycbcr_view *v = &views[i < count ? i : 0];
        buffers[i] = p->colors;
        at[i] = (GLintptr)v->at;
        bytes[i] = (GLsizeiptr)(pixel_bytes(v) + sizeof(float));
    }
    glBindBuffersRange(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PICTURES,
                       PEL_TOGETHER_MOST, buffers, at, bytes);
}

static void dispatch(const struct pel_ycbcr_view *views, size_t count)
{
    uint32_t width = 1, height = 1;
    for (size_t i = 0; i < count; i++) {
        width = views[i].width > width ? views[i].width : width;
        height = views[i].height > height ? views[i].height : height;
    }
    glDispatchCompute((GLuint)(round_up(width, WIDE_PIXELS) / WIDE_PIXELS),
                      (GLuint)(round_up(height, BLOCK) / 2), (GLuint)count);
}

/* Where the planes of each go: into its slot, or to the coder. */
static void bind_out(const struct pel_ycbcr_pass *p,
                     const struct pel_ycbcr_view *views, size_t count)
{
    GLuint buffers[PEL_TOGETHER_MOST];
    GLintptr at[PEL_TOGETHER_MOST];
    GLsizeiptr bytes[PEL_TOGETHER_MOST];
    for (size_t i = 0; i < PEL_TOGETHER_MOST; i++) {
        const struct pel_ycbcr_view *v = &views[i < count ? i : 0];
        bool coded = v->form == PEL_YCBCR_CODED;
        size_t own = coded ? plane_bytes(v) : pel_readback_ev_offset(v->slot);
        buffers[i] = coded ? p->coder.planes : pel_readback_buffer(v->slot);
        at[i] = coded ? (GLintptr)v->planes_at : 0;
        bytes[i] = (GLsizeiptr)(own + sizeof(float));
    }
    glBindBuffersRange(GL_SHADER_STORAGE_BUFFER, PEL_STORE_PICTURES,
                       PEL_TOGETHER_MOST, buffers, at, bytes);
}

static GLuint shader_form(const struct pel_ycbcr_view *v)
{
    return v->form == PEL_YCBCR_CODED ? PEL_YCBCR_FORM_JPEG : (GLuint)v->form;
}

static void code(struct pel_ycbcr_pass *p, const struct pel_ycbcr_view *views,
                 size_t count, bool with_ev)
{
    struct pel_jpeg_work works[PEL_TOGETHER_MOST];
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        const struct pel_ycbcr_view *v = &views[i];
        if (v->form == PEL_YCBCR_CODED) {
            works[n++] = (struct pel_jpeg_work){ .width = v->width,
                                                 .height = v->height,
                                                 .quality = v->quality,
                                                 .at = v->planes_at,
                                                 .with_ev = with_ev,
                                                 .slot = v->slot };
        }
    }
    if (n > 0) {
        pel_jpeg_coder_run(&p->coder, works, n);
    }
}

void pel_ycbcr_end(struct pel_ycbcr_pass *p, const struct pel_ycbcr_view *views,
                   size_t count)
{
    GLuint of[PEL_TOGETHER_MOST][4] = { 0 }, forms[PEL_TOGETHER_MOST] = { 0 };
    for (size_t i = 0; i < count; i++) {
        const struct pel_ycbcr_view *v = &views[i];
        size_t ev = v->form == PEL_YCBCR_CODED
                        ? plane_bytes(v)
                        : pel_readback_ev_offset(v->slot);
        of[i][0] = v->width;
        of[i][1] = v->height;
        of[i][2] = (GLuint)(v->at / 4);
        of[i][3] = (GLuint)(ev / 4);
        forms[i] = shader_form(v);
    }
    bind_out(p, views, count);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, PEL_STORE_COLORS, p->colors);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    pel_program_use(p->together);
    glUniform4uiv(0, (GLsizei)count, of[0]);
    glUniform1uiv(PEL_TOGETHER_MOST, (GLsizei)count, forms);
    dispatch(views, count);
    code(p, views, count, true);
}

void pel_ycbcr_one(struct pel_ycbcr_pass *p, GLuint colors, int aside,
                   struct pel_ycbcr_view *view)
{
    fit_planes(p, view, 1);
    bind_out(p, view, 1);
    glBindTextureUnit(PEL_UNIT_COLORS, colors);
    glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    pel_program_use(p->one);
    glUniform4ui(0, view->width, view->height, (GLuint)aside, 0);
    glUniform1ui(PEL_TOGETHER_MOST, shader_form(view));
    dispatch(view, 1);
    code(p, view, 1, false);
}
