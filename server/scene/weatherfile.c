#include "scene/weatherfile.h"

#include <glib.h>

#include "base/log.h"
#include "fault.h"
#include "ocean/growth.h"
#include "weather/load.h"

bool pel_weather_is_named(const Pelagos__State *state)
{
    const Pelagos__WeatherField *f = state->sea->field;
    return f && f->file && *f->file;
}

enum pel_err pel_weather_file_get(const Pelagos__State *state,
                                  const char *directory, bool forgiving,
                                  const struct pel_weather_file *present,
                                  struct pel_weather_file *out,
                                  struct pel_fault *fault)
{
    struct pel_fault why = { 0 };
    *out = (struct pel_weather_file){ 0 };
    if (!pel_weather_is_named(state)) {
        return PEL_OK;
    }
    const char *file = state->sea->field->file;
    out->key = g_strdup(file);
    if (g_strcmp0(file, present->key) == 0) {
        out->field = pel_weather_ref(present->field);
        return PEL_OK;
    }
    enum pel_err err = pel_weather_load(directory, file, &out->field, &why);
    if (err && forgiving) {
        pel_error("SCN-019",
                  "wind and waves stay as they are, and the state keeps "
                  "sea.field.file: %s",
                  why.message);
        return PEL_OK;
    }
    if (!err) { /* so that the control thread need not */
        if (*out->field->notes) {
            pel_info("SCN-033", "sea.field.file %s: %s", file,
                     out->field->notes);
        }
        struct pel_growth_law law;
        pel_growth_of(PEL_SPECTRUM_ELFOUHAILY, 0, &law);
    }
    if (err) {
        pel_fault_at(&why, "sea.field.file", file);
        if (fault) {
            *fault = why;
        }
        pel_weather_file_finish(out);
    }
    return err;
}

bool pel_weather_file_is(const struct pel_weather_file *file,
                         const Pelagos__State *state)
{
    return g_strcmp0(pel_weather_is_named(state) ? state->sea->field->file
                                                 : NULL,
                     file->key) == 0;
}

struct pel_weather_file
pel_weather_file_ref(const struct pel_weather_file *file)
{
    return (struct pel_weather_file){ g_strdup(file->key),
                                      pel_weather_ref(file->field) };
}

void pel_weather_file_finish(struct pel_weather_file *file)
{
    pel_weather_unref(file->field);
    g_free(file->key);
    *file = (struct pel_weather_file){ 0 };
}
