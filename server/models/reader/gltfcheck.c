#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "models/reader/meshfile.h"

#define MOST_BYTES ((size_t)256 << 20)

/* What Debian's assimp understands, or may pass over without harm. */
static bool is_known(const char *name, size_t length)
{
    static const char *const known[] = {
        "KHR_draco_mesh_compression",
        "KHR_texture_transform",
        "KHR_lights_punctual",
        "KHR_materials_",
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        size_t most = strlen(known[i]);
        bool family = known[i][most - 1] == '_';
        if (strncmp(name, known[i], most) == 0 && (family || length == most)) {
            return true;
        }
    }
    return false;
}

/* The strings of the list behind "extensionsRequired". */
static enum pel_err check_list(const char *at, struct pel_fault *fault)
{
    const char *end = strchr(at, ']');
    for (const char *p = strchr(at, '['); p && end && p < end;) {
        const char *open = strchr(p, '"');
        const char *close = open && open < end ? strchr(open + 1, '"') : NULL;
        if (!close) {
            break;
        }
        if (!is_known(open + 1, (size_t)(close - open - 1))) {
            return pel_fault_set(
                fault, PEL_ERR_INVALID,
                "it requires the extension %.*s, which is not "
                "read here; export it without",
                (int)(close - open - 1 < 60 ? close - open - 1 : 60), open + 1);
        }
        p = close + 1;
    }
    return PEL_OK;
}

enum pel_err pel_gltf_check(const char *path, struct pel_fault *fault)
{
    char *bytes = NULL;
    size_t size = 0;
    enum pel_err err = pel_file_read(path, MOST_BYTES, &bytes, &size, fault);
    if (err) {
        return err;
    }
    /* A GLB's JSON is its first chunk, behind 20 bytes. */
    bool binary = size >= 20 && memcmp(bytes, "glTF", 4) == 0;
    const char *text = bytes;
    if (binary) {
        uint32_t length;
        memcpy(&length, bytes + 12, 4);
        length = length < size - 20 ? length : (uint32_t)(size - 20);
        bytes[20 + length < size ? 20 + length : size] = '\0';
        text = bytes + 20;
    }
    const char *list = strstr(text, "\"extensionsRequired\"");
    err = list ? check_list(list, fault) : PEL_OK;
    free(bytes);
    return err;
}
