/* The gate before RTSP: what comes whole and what comes in pieces must be taken
 * alike, and what was broken stays so. The first byte is a piece's length. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "net/rtspguard.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static bool may_use(const void *who, const char *session)
{
    return strcmp(session, who) == 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char mine[] = "12345678";
    struct pel_rtsp_framing whole = { .may_use = may_use, .who = mine };
    struct pel_rtsp_framing parts = whole;
    if (size < 2) {
        return 0;
    }
    size_t piece = data[0] % 64 + 1u;
    bool good = true;
    for (size_t at = 1; at < size; at += piece) {
        size_t length = size - at < piece ? size - at : piece;
        bool now = pel_rtsp_framing_take(&parts, data + at, length);
        if (now && !good) {
            abort();
        }
        good = now;
    }
    if (pel_rtsp_framing_take(&whole, data + 1, size - 1) != good ||
        (good && (whole.state != parts.state || whole.left != parts.left))) {
        abort();
    }
    return 0;
}
