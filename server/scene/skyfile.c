#include "scene/skyfile.h"

#include <glib.h>

#include "base/log.h"
#include "fault.h"

static char *key_of(const Pelagos__State *state)
{
    const Pelagos__Sky *s = state->sky;
    return s->file && *s->file
               ? g_strdup_printf("%d %s",
                                 s->file_sun ==
                                     PELAGOS__PICTURE_SUN__IN_THE_PICTURE,
                                 s->file)
               : NULL;
}

enum pel_err pel_sky_file_get(const Pelagos__State *state,
                              const char *directory, bool forgiving,
                              const struct pel_sky_file *present,
                              struct pel_sky_file *out, struct pel_fault *fault)
{
    struct pel_fault why = { 0 };
    *out = (struct pel_sky_file){ .key = key_of(state) };
    if (!out->key) {
        return PEL_OK;
    }
    if (g_strcmp0(out->key, present->key) == 0) {
        out->picture = pel_panorama_ref(present->picture);
        return PEL_OK;
    }
    enum pel_err err = pel_panorama_load(
        directory, state->sky->file,
        state->sky->file_sun == PELAGOS__PICTURE_SUN__IN_THE_PICTURE,
        &out->picture, &why);
    if (err && forgiving) {
        pel_error("SCN-018",
                  "the sky is the computed one, and the state keeps sky.file: "
                  "%s",
                  why.message);
        return PEL_OK;
    }
    if (err) {
        pel_fault_at(&why, "sky.file", state->sky->file);
        if (fault) {
            *fault = why;
        }
        pel_sky_file_finish(out);
    }
    return err;
}

bool pel_sky_file_is(const struct pel_sky_file *file,
                     const Pelagos__State *state)
{
    g_autofree char *key = key_of(state);
    return g_strcmp0(key, file->key) == 0;
}

struct pel_sky_file pel_sky_file_ref(const struct pel_sky_file *file)
{
    return (struct pel_sky_file){ g_strdup(file->key),
                                  pel_panorama_ref(file->picture) };
}

void pel_sky_file_finish(struct pel_sky_file *file)
{
    pel_panorama_unref(file->picture);
    g_free(file->key);
    *file = (struct pel_sky_file){ 0 };
}
