#include "proto/formats.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

const struct pel_format pel_format_table[PEL_FORMATS] = {
#define PEL_FORMAT(ID, ending, mime, encoder, uses, text)                      \
    { PELAGOS__FRAME_FORMAT__##ID, #ID, ending, mime, uses },
#include "proto/formats.def"
};

static const char endings[] =
#define PEL_FORMAT(ID, ending, mime, encoder, uses, text) ", " ending
#include "proto/formats.def"
    ;
const char *const pel_format_endings = endings + 2;

static const char names[] =
#define PEL_FORMAT(ID, ending, mime, encoder, uses, text) ", " #ID
#include "proto/formats.def"
    ;
const char *const pel_format_names = names + 2;

const struct pel_format *pel_format_of(Pelagos__FrameFormat format)
{
    for (int i = 0; i < PEL_FORMATS; i++) {
        if (pel_format_table[i].format == format) {
            return &pel_format_table[i];
        }
    }
    return NULL;
}

/* The ending of the table for one of a format, in any case. */
static const char *known(const char *ending)
{
    static const char *const aliases[][2] = {
#define PEL_FORMAT_ALIAS(ending, of) { ending, of },
#include "proto/formats.def"
    };
    for (size_t i = 0; i < sizeof aliases / sizeof *aliases; i++) {
        if (strcasecmp(ending, aliases[i][0]) == 0) {
            return aliases[i][1];
        }
    }
    return ending;
}

const struct pel_format *pel_format_by_ending(const char *ending)
{
    const char *word = known(ending);
    for (int i = 0; i < PEL_FORMATS; i++) {
        if (strcasecmp(word, pel_format_table[i].ending) == 0) {
            return &pel_format_table[i];
        }
    }
    return NULL;
}

const struct pel_format *pel_format_by_path(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot ? pel_format_by_ending(dot + 1) : NULL;
}

void pel_format_names_of(unsigned uses, char *out, size_t size)
{
    size_t length = 0;
    out[0] = '\0';
    for (int i = 0; i < PEL_FORMATS && length < size; i++) {
        if ((pel_format_table[i].uses & uses) == uses) {
            length +=
                (size_t)snprintf(out + length, size - length, "%s%s",
                                 length ? ", " : "", pel_format_table[i].name);
        }
    }
}
