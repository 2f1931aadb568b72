#include "encode/encode.h"

#include <stdlib.h>

void pel_bytes_finish(struct pel_bytes *bytes)
{
    free(bytes->data);
    *bytes = (struct pel_bytes){ 0 };
}
