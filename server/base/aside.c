#include "base/aside.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

#define MOST_BYTES ((size_t)64 << 20)

static char *name_of(const char *path, const char *suffix, int number)
{
    return number == 1 ? g_strconcat(path, suffix, NULL)
                       : g_strdup_printf("%s%s.%d", path, suffix, number);
}

static bool same_file(const char *a, const char *b)
{
    struct stat one, two;
    return lstat(a, &one) == 0 && lstat(b, &two) == 0 &&
           one.st_ino == two.st_ino && one.st_dev == two.st_dev;
}

/* For file systems without links. */
static bool copy(const char *from, const char *to)
{
    char *bytes;
    size_t size;
    int fd = open(to, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0) {
        return false;
    }
    bool good = pel_file_read(from, MOST_BYTES, &bytes, &size, NULL) == PEL_OK;
    if (good) {
        good = pel_file_write(fd, bytes, size) && fsync(fd) == 0;
        free(bytes);
    }
    close(fd);
    if (!good) {
        unlink(to);
    }
    return good;
}

char *pel_aside_keep(const char *path, const char *suffix)
{
    for (int i = 1; i <= PEL_ASIDE_MOST; i++) {
        g_autofree char *to = name_of(path, suffix, i);
        if (link(path, to) == 0 || same_file(path, to)) {
            return g_steal_pointer(&to);
        }
        if (errno != EEXIST) {
            return copy(path, to) ? g_steal_pointer(&to) : NULL;
        }
    }
    return NULL;
}
