/* Who may do what. The first byte: T a file of tokens; A the value of an
 * Authorization header; else a patch as JSON, for each role: a role may make
 * what a lesser one may. */
#include <string.h>
#include <sys/stat.h>

#include "fuzz_file.h"
#include "json.h"
#include "net/roles.h"
#include "net/token.h"
#include "scene/edit.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char token[] = "0123456789abcdef";

static void demand(bool fine)
{
    if (!fine) {
        abort();
    }
}

static struct pel_token *tokens_of(const void *text, size_t size)
{
    char path[] = "/dev/shm/pelagos-fuzz-XXXXXX";
    struct pel_token *out = NULL;
    struct pel_fault fault = { 0 };
    int fd = mkstemp(path);
    demand(fd >= 0 && write(fd, text, size) == (ssize_t)size);
    demand(fchmod(fd, 0600) == 0 && close(fd) == 0);
    if (pel_token_create(path, &out, &fault)) {
        demand(out == NULL && fault.message[0] != '\0');
    } else {
        /* Neither nothing nor all of the file is a token, if it has a role. */
        demand(pel_token_who(out, "", 0).rank == PEL_RANK_NOBODY);
        demand(!pel_token_reload(out, &fault));
    }
    unlink(path);
    return out;
}

static void authorize(const char *value)
{
    static struct pel_token *known;
    if (!known) {
        known = tokens_of(token, strlen(token));
        demand(known != NULL);
    }
    enum pel_role role =
        pel_role_of_rank(pel_token_authorizes(known, value).rank);
    demand(role == PEL_ROLE_NONE || role == PEL_ROLE_INSTRUCT);
    if (strncasecmp(value, "Bearer ", 7) == 0) {
        demand(role == PEL_ROLE_NONE || strstr(value, token));
    }
}

static void patch_as(const uint8_t *data, size_t size)
{
    static Pelagos__State *state;
    Pelagos__Patch *patch;
    struct pel_fault fault = { 0 };
    state = state ? state : pel_state_default();
    if (pel_json_merge_patch((const char *)data, size, &patch, &fault)) {
        return;
    }
    bool may = false;
    for (int role = PEL_ROLE_NONE; role <= PEL_ROLE_INSTRUCT; role++) {
        bool can = !pel_role_patch((enum pel_role)role, patch, state, &fault);
        demand(can || (!may && fault.message[0] && fault.path[0]));
        may = can;
    }
    demand(may);
    pelagos__patch__free_unpacked(patch, NULL);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) {
        return 0;
    }
    if (data[0] == 'T') {
        pel_token_destroy(tokens_of(data + 1, size - 1));
    } else if (data[0] == 'A') {
        char *value = strndup((const char *)data + 1, size - 1);
        demand(value != NULL);
        authorize(value);
        free(value);
    } else {
        patch_as(data, size);
    }
    return 0;
}
