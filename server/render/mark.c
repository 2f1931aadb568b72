#include "render/mark.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "scene/snapshot.h"

#define GLYPH_COLUMNS 5
#define GLYPH_ROWS 7
#define ADVANCE 6       /* columns from glyph to glyph */
#define BORDER_SHARE 90 /* of the height */
#define TEXT_SHARE 240  /* rows of the picture for a dot's side */

struct brush {
    GLuint framebuffer;
    int width, height;   /* of the picture */
    int first_row, rows; /* that it has */
    int corner;          /* where they begin in it, in x and in y */
};

static const float amber[] = { 1.0F, 0.69F, 0.0F, 1.0F };
static const float black[] = { 0.0F, 0.0F, 0.0F, 1.0F };

static void fill(const struct brush *b, int x, int y, int width, int height,
                 const float color[4])
{
    int right = x + width < b->width ? x + width : b->width;
    y -= b->first_row;
    int bottom = y + height < b->rows ? y + height : b->rows;
    height -= y < 0 ? -y : 0;
    y = y > 0 ? y : 0;
    if (right > x && bottom > y && height > 0) {
        glScissor(b->corner + x, b->corner + y, right - x, bottom - y);
        glClearNamedFramebufferfv(b->framebuffer, GL_COLOR, 0, color);
    }
}

/* Capitals of five by seven dots, a row a byte, the left dot is bit 4. */
static const uint8_t *glyph(char letter)
{
    static const struct {
        char letter;
        uint8_t rows[GLYPH_ROWS];
    } font[] = {
        { 'A', { 0x0e, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11 } },
        { 'B', { 0x1e, 0x11, 0x11, 0x1e, 0x11, 0x11, 0x1e } },
        { 'C', { 0x0e, 0x11, 0x10, 0x10, 0x10, 0x11, 0x0e } },
        { 'D', { 0x1e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x1e } },
        { 'E', { 0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x1f } },
        { 'G', { 0x0e, 0x11, 0x10, 0x17, 0x11, 0x11, 0x0f } },
        { 'H', { 0x11, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11 } },
        { 'I', { 0x0e, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0e } },
        { 'L', { 0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1f } },
        { 'M', { 0x11, 0x1b, 0x15, 0x15, 0x11, 0x11, 0x11 } },
        { 'N', { 0x11, 0x19, 0x15, 0x13, 0x11, 0x11, 0x11 } },
        { 'O', { 0x0e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e } },
        { 'P', { 0x1e, 0x11, 0x11, 0x1e, 0x10, 0x10, 0x10 } },
        { 'R', { 0x1e, 0x11, 0x11, 0x1e, 0x14, 0x12, 0x11 } },
        { 'S', { 0x0f, 0x10, 0x10, 0x0e, 0x01, 0x01, 0x1e } },
        { 'T', { 0x1f, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04 } },
        { 'U', { 0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e } },
    };
    for (size_t i = 0; i < sizeof font / sizeof *font; i++) {
        if (font[i].letter == letter) {
            return font[i].rows;
        }
    }
    return NULL;
}

/* Dots side by side are one rectangle. */
static void draw_glyph(const struct brush *b, const uint8_t *rows, int x, int y,
                       int dot)
{
    for (int row = 0; row < GLYPH_ROWS; row++) {
        for (int column = 0; column < GLYPH_COLUMNS;) {
            int end = column;
            while (end < GLYPH_COLUMNS && rows[row] >> (4 - end) & 1) {
                end++;
            }
            fill(b, x + column * dot, y + row * dot, (end - column) * dot, dot,
                 amber);
            column = end > column ? end : column + 1;
        }
    }
}

static void draw_text(const struct brush *b, const char *text, int margin)
{
    int length = (int)strlen(text);
    int dot = b->height > TEXT_SHARE ? b->height / TEXT_SHARE : 1;
    int fits = (b->width - 4 * margin) / (ADVANCE * length + 1);
    dot = dot < fits ? dot : fits;
    if (dot < 1) {
        return;
    }
    int x = 2 * margin, y = 2 * margin;
    fill(b, x, y, (ADVANCE * length + 1) * dot, (GLYPH_ROWS + 2) * dot, black);
    for (int i = 0; i < length; i++) {
        const uint8_t *rows = glyph(text[i]);
        if (rows) {
            draw_glyph(b, rows, x + (ADVANCE * i + 1) * dot, y + dot, dot);
        }
    }
}

void pel_mark_stale(GLuint framebuffer, uint32_t width, uint32_t height,
                    uint32_t first_row, uint32_t rows, int corner,
                    unsigned stale)
{
    const struct brush b = { framebuffer,    (int)width, (int)height,
                             (int)first_row, (int)rows,  corner };
    int thick = b.height / BORDER_SHARE > 2 ? b.height / BORDER_SHARE : 2;
    char names[PEL_STALE_TEXT], text[PEL_STALE_TEXT + 8];
    snprintf(text, sizeof text, "STALE %s", pel_stale_text(stale, names));
    for (char *c = text; *c; c++) {
        *c = (char)(*c >= 'a' && *c <= 'z' ? *c - 'a' + 'A' : *c);
    }
    glEnable(GL_SCISSOR_TEST);
    fill(&b, 0, 0, b.width, thick, amber);
    fill(&b, 0, b.height - thick, b.width, thick, amber);
    fill(&b, 0, 0, thick, b.height, amber);
    fill(&b, b.width - thick, 0, thick, b.height, amber);
    draw_text(&b, text, thick);
    glDisable(GL_SCISSOR_TEST);
}
