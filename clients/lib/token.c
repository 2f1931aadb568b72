#include "token.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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
    char line[CLIENT_TOKEN_MAX + 3] = "";
    struct stat is;
    /* A FIFO or a device in its place must not hold the caller up. */
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (fd < 0 || fstat(fd, &is)) {
        snprintf(why, why_size, "cannot read the token in %s: %s", path,
                 strerror(errno));
        return -1;
    }
    ssize_t got = S_ISREG(is.st_mode) ? read(fd, line, sizeof line - 1) : -1;
    close(fd);
    if (!S_ISREG(is.st_mode)) {
        snprintf(why, why_size, "%s is no regular file", path);
        return -1;
    }
    line[strcspn(line, "\r\n")] = '\0';
    if (got <= 0 || !*line || strlen(line) > CLIENT_TOKEN_MAX) {
        snprintf(why, why_size, "there is no token in %s", path);
        return -1;
    }
    memcpy(out, line, strlen(line) + 1);
    return 0;
}
