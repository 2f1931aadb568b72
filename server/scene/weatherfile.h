/* The weather field that a state names (sea.field.file). Any thread. */
#pragma once

#include <stdbool.h>

#include "base/err.h"
#include "pelagos.pb-c.h"
#include "weather/weather.h"

/* A field and what it was made from; zeroed: none. */
struct pel_weather_file {
    char *key; /* NULL: none */
    const struct pel_weather *field;
};

/* Whether the state names one. */
bool pel_weather_is_named(const Pelagos__State *state);

/* The field of a tested, complete state: `present` again where it is the same,
 * else read from `directory` (NULL: none is configured), which waits for it
 * (weather/load.h). forgiving: where it does not read, none, which is logged,
 * and OK. Else *fault (NULL allowed) says what is wrong with sea.field.file. */
PEL_CHECK enum pel_err
pel_weather_file_get(const Pelagos__State *state, const char *directory,
                     bool forgiving, const struct pel_weather_file *present,
                     struct pel_weather_file *out, struct pel_fault *fault);
/* Whether `file` is that of the state. */
bool pel_weather_file_is(const struct pel_weather_file *file,
                         const Pelagos__State *state);
struct pel_weather_file
pel_weather_file_ref(const struct pel_weather_file *file);
void pel_weather_file_finish(struct pel_weather_file *file);
