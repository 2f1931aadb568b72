#include "scene/missing.h"

#include <glib.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/reserve.h"
#include "message.h"
#include "scene/ground.h"

static const char *const paths[PEL_MISSING_COUNT] = {
    [PEL_MISSING_SEABED] = "seabed.file",
    [PEL_MISSING_SPECTRUM] = "sea.measured",
};

void pel_missing_finish(struct pel_missing *missing)
{
    for (int i = 0; i < PEL_MISSING_COUNT; i++) {
        g_free(missing->fields[i].name);
        missing->fields[i].name = NULL;
    }
}

const char *pel_missing_path(enum pel_missing_kind kind)
{
    return paths[kind];
}

bool pel_missing_may(enum pel_missing_kind kind, const Pelagos__State *state)
{
    return kind == PEL_MISSING_SEABED
               ? state->seabed->file && *state->seabed->file
               : state->sea->spectrum == PELAGOS__SPECTRUM_KIND__MEASURED;
}

void pel_missing_note(struct pel_missing *missing, enum pel_missing_kind kind,
                      Pelagos__State *state, const struct pel_fault *why)
{
    char **name = &missing->fields[kind].name;
    g_free(*name);
    g_strlcpy(missing->fields[kind].reason, why->message,
              sizeof missing->fields[kind].reason);
    if (kind == PEL_MISSING_SEABED) {
        *name = g_strdup(state->seabed->file);
        pel_error("SCN-009",
                  "the bottom is flat, and the state file keeps seabed.file: "
                  "%s",
                  why->message);
        pel_ground_forget(state);
    } else {
        *name = g_strdup(state->sea->measured ? state->sea->measured : "");
        pel_error(
            "SCN-005",
            "the sea is Pierson–Moskowitz, not measured, and the state file "
            "keeps sea.spectrum: %s",
            why->message);
        state->sea->spectrum = PELAGOS__SPECTRUM_KIND__PIERSON_MOSKOWITZ;
    }
}

static bool removes(const Pelagos__Patch *patch, const char *whole,
                    const char *part)
{
    for (size_t i = 0; i < patch->n_remove; i++) {
        if (strcmp(patch->remove[i], whole) == 0 ||
            strcmp(patch->remove[i], part) == 0) {
            return true;
        }
    }
    return false;
}

void pel_missing_edited(struct pel_missing *missing,
                        const Pelagos__Patch *patch)
{
    const Pelagos__State *to = patch->state;
    const Pelagos__Sea *sea = to ? to->sea : NULL;
    bool says[PEL_MISSING_COUNT] = {
        [PEL_MISSING_SEABED] = (to && to->seabed && to->seabed->file) ||
                               removes(patch, "seabed", "seabed.file"),
        [PEL_MISSING_SPECTRUM] = (sea && (sea->has_spectrum || sea->measured ||
                                          sea->measured_time)) ||
                                 removes(patch, "sea", "sea.spectrum") ||
                                 removes(patch, "sea", "sea.measured"),
    };
    for (int i = 0; i < PEL_MISSING_COUNT; i++) {
        if (says[i]) {
            g_free(missing->fields[i].name);
            missing->fields[i].name = NULL;
        }
    }
}

Pelagos__State *pel_missing_restored(const struct pel_missing *missing,
                                     const Pelagos__State *state)
{
    const char *file = missing->fields[PEL_MISSING_SEABED].name;
    bool measured = missing->fields[PEL_MISSING_SPECTRUM].name;
    if (!file && !measured) {
        return NULL;
    }
    Pelagos__State *whole = (Pelagos__State *)pel_message_copy(&state->base);
    if (file) {
        pel_ground_forget(whole);
        whole->seabed->file = pel_sure_strdup(file);
    }
    if (measured) {
        whole->sea->spectrum = PELAGOS__SPECTRUM_KIND__MEASURED;
    }
    return whole;
}
