#include "encode/encode.h"

#include <stdlib.h>
#include <string.h>

void pel_bytes_finish(struct pel_bytes *bytes)
{
    free(bytes->data);
    *bytes = (struct pel_bytes){ 0 };
}

enum pel_err pel_text_encode(const struct pel_encode_input *in,
                             struct pel_bytes *out)
{
    *out = (struct pel_bytes){ 0 };
    if (!in->text) {
        return PEL_ERR_INVALID;
    }
    size_t size = strlen(in->text);
    out->data = malloc(size + 1);
    if (!out->data) {
        return PEL_ERR_NO_MEMORY;
    }
    memcpy(out->data, in->text, size + 1);
    out->size = size;
    return PEL_OK;
}
