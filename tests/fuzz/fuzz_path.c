/* Paths and values, a line each: `path=value` (`?` before it: as a number) into
 * one patch, `path` read, `-path` removed from a copy of the state. What was
 * set is what is read, after the patch is made. */
#include <string.h>

#include "fuzz_scene.h"
#include "message.h"
#include "path.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static Pelagos__State *state_of_all(void)
{
    static Pelagos__State *state;
    if (!state) {
        static const char text[] =
            "{\"entities\":{\"7\":{\"name\":\"tug\"},\"8\":{\"name\":\"tug\"}},"
            "\"sea\":{\"swell\":[{\"height\":2},{\"height\":3}]}}";
        Pelagos__State *first = pel_state_default();
        Pelagos__Patch *patch;
        if (pel_json_merge_patch(text, sizeof text - 1, &patch, NULL) ||
            pel_state_apply(first, patch, &state, NULL)) {
            abort();
        }
        pelagos__patch__free_unpacked(patch, NULL);
        pelagos__state__free_unpacked(first, NULL);
    }
    return state;
}

static void count(const char *path, const struct pel_path_info *info,
                  void *user)
{
    struct pel_path_info found;
    if (!strstr(path, ".*") && (pel_path_find(path, &found, NULL) != PEL_OK ||
                                found.field != info->field)) {
        abort();
    }
    ++*(int *)user;
}

static void read_at(const char *path)
{
    static char text[1 << 16];
    struct pel_fault fault = { 0 };
    if (pel_path_get(state_of_all(), path, text, sizeof text, &fault) !=
            PEL_OK &&
        !fault.message[0]) {
        abort();
    }
}

static void remove_at(const char *path)
{
    ProtobufCMessage *copy = pel_message_copy(&state_of_all()->base);
    (void)!pel_path_remove((Pelagos__State *)copy, path, NULL);
    free(pel_json_from_message(copy, false));
    protobuf_c_message_free_unpacked(copy, NULL);
}

static void take(Pelagos__Patch *patch, char *line)
{
    char *equals = strchr(line, '=');
    struct pel_fault fault = { 0 };
    enum pel_err err;
    if (line[0] == '-') {
        remove_at(line + 1);
    } else if (!equals) {
        read_at(line);
    } else {
        *equals = '\0';
        err =
            line[0] == '?'
                ? pel_path_set_number(patch, state_of_all(), line + 1,
                                      strtod(equals + 1, NULL), &fault)
                : pel_path_set(patch, state_of_all(), line, equals + 1, &fault);
        if (err && !fault.message[0]) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1), *rest = text, *line;
    int fields = 0;
    memcpy(text, data, size);
    text[size] = '\0';
    Pelagos__Patch *patch = pel_patch_new();
    while ((line = strsep(&rest, "\n"))) {
        take(patch, line);
    }
    if (size > 0 && data[0] == '*') {
        pel_path_each(count, &fields);
    }
    fuzz_edit(patch);
    pelagos__patch__free_unpacked(patch, NULL);
    free(text);
    return 0;
}
