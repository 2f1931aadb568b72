#include "seabed/reader/gdal.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <ogr_srs_api.h>
#include <stdlib.h>
#include <string.h>

static void say_nothing(CPLErr class, CPLErrorNum number, const char *text)
{
    (void)class;
    (void)number;
    (void)text;
}

void pel_gdal_prepare(void (*const *drivers)(void), size_t driver_count,
                      const char *places[PEL_GDAL_MOST_PLACES + 1])
{
    static const char *const settings[][2] = {
        { "GDAL_DRIVER_PATH", "disable" },
        { "GDAL_CACHEMAX", "64" },
        { "GDAL_NUM_THREADS", "1" },
        { "GDAL_PAM_ENABLED", "NO" }, /* no .aux.xml, read or written */
        { "GDAL_HTTP_MAX_RETRY", "0" },
        { "CPL_VSIL_CURL_ALLOWED_FILENAME", "none" },
    };
    size_t count = 0;
    CPLSetErrorHandler(say_nothing);
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        CPLSetConfigOption(settings[i][0], settings[i][1]);
    }
    /* The C library's own name for no file locking: that is a system call
     * which the sandbox has not. */
    setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
    for (size_t i = 0; i < driver_count; i++) {
        drivers[i]();
    }
    OSRSetPROJEnableNetwork(FALSE);
    char **proj = OSRGetPROJSearchPaths();
    for (int i = 0; proj && proj[i] && count + 1 < PEL_GDAL_MOST_PLACES; i++) {
        places[count++] = proj[i];
    }
    const char *own = CPLFindFile("gdal", "gdalvrt.xsd");
    if (own) {
        places[count++] = strdup(CPLGetPath(own));
    }
    places[count] = NULL;
}
