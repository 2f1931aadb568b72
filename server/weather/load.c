#include "weather/load.h"

#include <stdlib.h>
#include <string.h>

#include "base/helper.h"
#include "weather/wire.h"

#define PROGRAM "pelagos-weather"

static enum pel_err check(const char *directory, const char *file,
                          struct pel_fault *fault)
{
    if (!directory) {
        return pel_fault_set(fault, PEL_ERR_CONFLICT,
                             "sea.field.file needs pelagosd --weather");
    }
    if (strchr(file, '/') || file[0] == '.' || file[0] == '-') {
        return pel_fault_set(fault, PEL_ERR_INVALID,
                             "sea.field.file must be the name of a file in the "
                             "directory of pelagosd --weather, without /");
    }
    return pel_helper_find(directory, file, fault);
}

enum pel_err pel_weather_load(const char *directory, const char *file,
                              const struct pel_weather **out,
                              struct pel_fault *fault)
{
    char *argv[] = { (char[]){ PROGRAM }, (char *)directory, (char *)file,
                     NULL };
    const struct pel_helper_task task = {
        .program = PROGRAM,
        .argv = argv,
        .subject = file,
        .most_bytes = PEL_WEATHER_WIRE_MOST,
        .within_ms = PEL_WEATHER_LOAD_MS,
    };
    unsigned char *bytes = NULL;
    size_t size = 0;
    enum pel_err err = check(directory, file, fault);
    if (!err) {
        err = pel_helper_run(&task, &bytes, &size, fault);
    }
    if (!err) {
        struct pel_fault why;
        err = pel_weather_wire_read(bytes, size, out, &why);
        if (err) {
            pel_fault_set(fault, err, "%.80s: %.160s", file, why.message);
        }
    }
    free(bytes);
    return err;
}
