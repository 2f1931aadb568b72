#include "scene/presets.h"

#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include <glib.h>

#include "bounds.h"
#include "fault.h"
#include "json.h"
#include "ranges.h"
#include "scene/snapshot.h"

#define NAME_CHARACTERS                                                        \
    "ABCDEFGHIJKLMNOPQRSTUVWXYZ"                                               \
    "abcdefghijklmnopqrstuvwxyz0123456789_-"

static enum pel_err check_name(const Pelagos__State *state, size_t index,
                               struct pel_fault *fault)
{
    const char *name = state->presets[index]->name;
    size_t length = name ? strlen(name) : 0;
    if (length == 0 || length >= PEL_NAME_SIZE ||
        strspn(name, NAME_CHARACTERS) != length) {
        return pel_fault_refuse(PEL_ERR_INVALID, "presets", name,
                                "needs names of 1 to 64 of A-Z a-z 0-9 _ -",
                                fault);
    }
    for (size_t i = 0; i < index; i++) {
        if (strcmp(state->presets[i]->name, name) == 0) {
            return pel_fault_refuse(PEL_ERR_CONFLICT, "presets", name,
                                    "has a name twice", fault);
        }
    }
    return PEL_OK;
}

enum pel_err pel_presets_check(const Pelagos__State *state,
                               struct pel_fault *fault)
{
    if (state->n_presets > PEL_BOUND_PRESETS) {
        char value[24], what[64];
        g_snprintf(value, sizeof value, "%zu", state->n_presets);
        g_snprintf(what, sizeof what, "would have %s elements; at most %d",
                   value, PEL_BOUND_PRESETS);
        return pel_fault_refuse(PEL_ERR_OUT_OF_RANGE, "presets", value, what,
                                fault);
    }
    enum pel_err err = PEL_OK;
    for (size_t i = 0; !err && i < state->n_presets; i++) {
        err = check_name(state, i, fault);
    }
    return err;
}

static bool changes_presets(const Pelagos__Patch *patch)
{
    bool found = patch->state && patch->state->n_presets > 0;
    for (size_t i = 0; i < patch->n_remove; i++) {
        found = found || g_str_has_prefix(patch->remove[i], "presets");
    }
    return found;
}

/* What is wrong within the patch, as a fault of the preset. */
static enum pel_err refuse(const Pelagos__Preset *preset, enum pel_err err,
                           const char *why, struct pel_fault *fault)
{
    char path[PEL_NAME_SIZE + 32], what[200];
    g_snprintf(path, sizeof path, "presets.%.64s.patch",
               preset->name ? preset->name : "");
    g_snprintf(what, sizeof what, "cannot be made: %.160s", why);
    return pel_fault_refuse(err, path, NULL, what, fault);
}

enum pel_err pel_preset_patch(const Pelagos__Preset *preset,
                              Pelagos__Patch **out, struct pel_fault *fault)
{
    const char *text = preset->patch ? preset->patch : "";
    struct pel_fault why = { 0 };
    *out = NULL;
    if (strlen(text) > PEL_BOUND_PRESET_BYTES) {
        return refuse(preset, PEL_ERR_INVALID, "it is longer than 4096 bytes",
                      fault);
    }
    enum pel_err err = pel_json_merge_patch(text, strlen(text), out, &why);
    if (!err && (*out)->state) {
        err = pel_message_check(&(*out)->state->base, "", &why);
    }
    if (!err && changes_presets(*out)) {
        err = pel_fault_set(&why, PEL_ERR_INVALID, "it changes presets");
    }
    if (!err) {
        return PEL_OK;
    }
    if (*out) {
        pelagos__patch__free_unpacked(*out, NULL);
        *out = NULL;
    }
    return refuse(preset, err, why.message, fault);
}

/* Texts that were found good, the newest last: a patch is tested as it is read,
 * by a thread, and once more or twice as it is applied. */
#define KNOWN 64
static struct {
    pthread_mutex_t lock; /* protects the rest */
    char *text[KNOWN];
    guint hash[KNOWN];
    unsigned next;
} known = { .lock = PTHREAD_MUTEX_INITIALIZER };

static bool is_known(const char *text, guint hash)
{
    bool found = false;
    pthread_mutex_lock(&known.lock);
    for (unsigned i = 0; i < KNOWN && !found; i++) {
        found = known.text[i] && known.hash[i] == hash &&
                strcmp(known.text[i], text) == 0;
    }
    pthread_mutex_unlock(&known.lock);
    return found;
}

static void make_known(const char *text, guint hash)
{
    char *copy = g_strdup(text);
    pthread_mutex_lock(&known.lock);
    unsigned place = known.next++ % KNOWN;
    char *before = known.text[place];
    known.text[place] = copy;
    known.hash[place] = hash;
    pthread_mutex_unlock(&known.lock);
    g_free(before);
}

static enum pel_err check_patch(const Pelagos__Preset *preset,
                                struct pel_fault *fault)
{
    Pelagos__Patch *made;
    guint hash = g_str_hash(preset->patch);
    if (is_known(preset->patch, hash)) {
        return PEL_OK;
    }
    enum pel_err err = pel_preset_patch(preset, &made, fault);
    if (!err) {
        pelagos__patch__free_unpacked(made, NULL);
        make_known(preset->patch, hash);
    }
    return err;
}

enum pel_err pel_presets_brought(const Pelagos__State *patch,
                                 struct pel_fault *fault)
{
    enum pel_err err = PEL_OK;
    for (size_t i = 0; !err && i < patch->n_presets; i++) {
        const Pelagos__Preset *preset = patch->presets[i];
        if (!preset->name) {
            err = pel_fault_refuse(PEL_ERR_INVALID, "presets", NULL,
                                   "needs a name for each element", fault);
        } else if (preset->patch) {
            err = check_patch(preset, fault);
        }
    }
    return err;
}

void pel_presets_learn(const Pelagos__State *patch)
{
    for (size_t i = 0; i < patch->n_presets && i < KNOWN; i++) {
        struct pel_fault ignored;
        if (patch->presets[i]->patch &&
            check_patch(patch->presets[i], &ignored)) {
            return; /* it is said when the patch is applied */
        }
    }
}
