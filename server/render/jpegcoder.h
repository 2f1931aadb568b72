/* Codes planes of luma and chroma as scans of JPEGs (encode/jpegcode.h) on the
 * device: some hundred kilobytes go to the host instead of its planes, and no
 * processor transforms them. Render thread only. */
#ifndef PELAGOS_RENDER_JPEGCODER_H
#define PELAGOS_RENDER_JPEGCODER_H

#include <epoxy/gl.h>
#include <stddef.h>
#include <stdint.h>

#include "base/err.h"
#include "render/readback.h"

/* Zeroed before its first use. */
struct pel_jpeg_coder {
    GLuint program;
    GLuint tables; /* struct pel_jpeg_tables */
    GLuint planes; /* of pictures, and behind each one's the EV100 */
    size_t capacity;
};

/* Makes the program and its tables. GPU, NO_MEMORY. */
PEL_CHECK enum pel_err pel_jpeg_coder_need(struct pel_jpeg_coder *c,
                                           const char *shader_dir,
                                           struct pel_fault *fault);
void pel_jpeg_coder_finish(struct pel_jpeg_coder *c);

/* Room for planes of so many bytes. */
void pel_jpeg_coder_fit(struct pel_jpeg_coder *c, size_t bytes);

struct pel_jpeg_work {
    uint32_t width, height;
    int quality;
    size_t at;    /* bytes into the planes */
    bool with_ev; /* behind them is the picture's EV100 */
    const struct pel_readback_slot *slot;
};

/* Into their slots, 1..PEL_TOGETHER_MOST; what wrote the planes is waited for.
 */
void pel_jpeg_coder_run(struct pel_jpeg_coder *c,
                        const struct pel_jpeg_work *works, size_t count);

#endif
