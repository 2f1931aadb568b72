#include "token.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pelagos.h"

int client_token(char out[CLIENT_TOKEN_MAX + 1], char *why, size_t why_size)
{
    const char *text = getenv(PEL_CLIENT_TOKEN_VARIABLE);
    const char *path = getenv(PEL_CLIENT_TOKEN_FILE_VARIABLE);
    out[0] = '\0';
    if (text && *text) {
        if (strlen(text) > CLIENT_TOKEN_MAX) {
            snprintf(why, why_size, "$%s is too long",
                     PEL_CLIENT_TOKEN_VARIABLE);
            return -1;
        }
        memcpy(out, text, strlen(text) + 1);
        return 0;
    }
    if (!path || !*path) {
        return 0;
    }
    FILE *file = fopen(path, "re");
    if (!file) {
        snprintf(why, why_size, "cannot read the token in %s: %s", path,
                 strerror(errno));
        return -1;
    }
    char line[CLIENT_TOKEN_MAX + 3] = "";
    char *got = fgets(line, sizeof line, file);
    fclose(file);
    line[strcspn(line, "\r\n")] = '\0';
    if (!got || !*line || strlen(line) > CLIENT_TOKEN_MAX) {
        snprintf(why, why_size, "there is no token in %s", path);
        return -1;
    }
    memcpy(out, line, strlen(line) + 1);
    return 0;
}
