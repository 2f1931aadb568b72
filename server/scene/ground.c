#include "scene/ground.h"

#include <glib.h>

#include "fault.h"
#include "seabed/load.h"

static bool is_named(const Pelagos__Seabed *seabed)
{
    return seabed->file && *seabed->file;
}

/* Everything that the field depends on; NULL: there is none. */
static char *key_of(const Pelagos__State *state)
{
    const Pelagos__Seabed *s = state->seabed;
    return is_named(s)
               ? g_strdup_printf("%.17g %.17g %d %.17g %.17g %.17g %.17g %s",
                                 state->origin->latitude,
                                 state->origin->longitude, (int)s->values,
                                 s->offset, s->latitude, s->longitude,
                                 s->has_spacing ? s->spacing : 0, s->file)
               : NULL;
}

enum pel_err pel_ground_get(const Pelagos__State *state, const char *directory,
                            const struct pel_ground *present,
                            struct pel_ground *out, struct pel_fault *fault)
{
    const Pelagos__Seabed *s = state->seabed;
    *out = (struct pel_ground){ .key = key_of(state) };
    if (!out->key) {
        return PEL_OK;
    }
    if (g_strcmp0(out->key, present->key) == 0) {
        out->bed = pel_seabed_ref(present->bed);
        return PEL_OK;
    }
    const struct pel_seabed_source source = {
        .directory = directory,
        .file = s->file,
        .origin_latitude = state->origin->latitude,
        .origin_longitude = state->origin->longitude,
        .placed = s->has_spacing,
        .latitude = s->latitude,
        .longitude = s->longitude,
        .spacing_m = s->spacing,
        .depths = s->values == PELAGOS__HEIGHT_KIND__DEPTH,
        .offset_m = s->offset,
    };
    enum pel_err err = pel_seabed_load(&source, &out->bed, fault);
    if (err) {
        pel_fault_at(fault, "seabed.file", s->file);
        pel_ground_finish(out);
    }
    return err;
}

bool pel_ground_is(const struct pel_ground *ground, const Pelagos__State *state)
{
    g_autofree char *key = key_of(state);
    return g_strcmp0(key, ground->key) == 0;
}

void pel_ground_finish(struct pel_ground *ground)
{
    pel_seabed_unref(ground->bed);
    g_free(ground->key);
    *ground = (struct pel_ground){ 0 };
}

void pel_ground_forget(Pelagos__State *state)
{
    g_free(state->seabed->file);
    state->seabed->file = NULL;
}
