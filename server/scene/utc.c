#include <glib.h>

#include "scene/sun.h"

#define UNIX_1900 (-2208988800.0)
#define UNIX_2101 4133980800.0

enum pel_err pel_utc_parse(const char *text, double *unix_s)
{
    /* No default zone: local time would be a guess. */
    GDateTime *when = g_date_time_new_from_iso8601(text, NULL);
    if (!when) {
        return PEL_ERR_INVALID;
    }
    *unix_s = (double)g_date_time_to_unix(when) +
              g_date_time_get_microsecond(when) * 1e-6;
    g_date_time_unref(when);
    return *unix_s >= UNIX_1900 && *unix_s < UNIX_2101 ? PEL_OK
                                                       : PEL_ERR_OUT_OF_RANGE;
}
