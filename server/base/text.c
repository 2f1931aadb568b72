#include "base/text.h"

#include <stdint.h>

/* Bytes of the character that begins here; 0: none does. Not overlong, no
 * surrogate, at most U+10FFFF (RFC 3629). */
static size_t character(const unsigned char *at, uint32_t *out)
{
    static const uint32_t least[] = { 0, 0, 0x80, 0x800, 0x10000 };
    size_t size = at[0] < 0x80             ? 1
                  : (at[0] & 0xe0) == 0xc0 ? 2
                  : (at[0] & 0xf0) == 0xe0 ? 3
                  : (at[0] & 0xf8) == 0xf0 ? 4
                                           : 0;
    uint32_t code = size < 2 ? at[0] : at[0] & (0x7fU >> size);
    for (size_t i = 1; i < size; i++) {
        if ((at[i] & 0xc0) != 0x80) {
            return 0; /* the end of the text too */
        }
        code = code << 6 | (at[i] & 0x3f);
    }
    bool good = size > 0 && code >= least[size] && code <= 0x10ffff &&
                (code < 0xd800 || code > 0xdfff);
    *out = code;
    return good ? size : 0;
}

static void clean(char *text, bool lines)
{
    unsigned char *to = (unsigned char *)text;
    const unsigned char *from = to;
    while (*from) {
        uint32_t code = 0;
        size_t size = character(from, &code);
        bool space =
            size == 1 && (code == '\n' || code == '\t' || code == '\r');
        bool shown = size > 0 && code >= 0x20 && (code < 0x7f || code > 0x9f);
        if (shown || (space && lines && code != '\r')) {
            for (size_t i = 0; i < size; i++) {
                *to++ = *from++;
            }
            continue;
        }
        *to++ = space ? ' ' : '?';
        from += size > 0 ? size : 1;
    }
    *to = '\0';
}

void pel_text_clean(char *text)
{
    clean(text, false);
}

void pel_text_clean_lines(char *text)
{
    clean(text, true);
}
