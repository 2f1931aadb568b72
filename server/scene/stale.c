/* Apart from the snapshot, so that what marks pictures needs no GLib. */
#include <stdio.h>
#include <string.h>

#include "scene/snapshot.h"

const char *pel_stale_text(unsigned stale, char out[PEL_STALE_TEXT])
{
    static const char *const names[] = { "cigi",    "modbus", "nmea",
                                         "console", "other",  "poses",
                                         "exercise" };
    size_t used = 0;
    strcpy(out, "none");
    for (unsigned i = 0; i < sizeof names / sizeof *names; i++) {
        if (stale >> i & 1) {
            used += (size_t)snprintf(out + used, PEL_STALE_TEXT - used, "%s%s",
                                     used > 0 ? "," : "", names[i]);
        }
    }
    return out;
}
