#include "base/trial.h"

#include <arpa/inet.h>
#include <errno.h>
#include <glib.h>
#include <netinet/in.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MOST 16 /* sockets that a daemon listens on */

static bool on;
static struct {
    const char *option;
    int type;
    struct sockaddr_storage address;
} tried[MOST];
static size_t tried_count;

void pel_trial_begin(void)
{
    on = true;
}

bool pel_trial(void)
{
    return on;
}

void pel_trial_note(const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    printf("note: %s\n", text);
}

/* --- sockets -------------------------------------------------------------- */

static uint16_t port_of(const struct sockaddr_storage *a)
{
    return ntohs(a->ss_family == AF_INET
                     ? ((const struct sockaddr_in *)a)->sin_port
                     : ((const struct sockaddr_in6 *)a)->sin6_port);
}

static bool is_any(const struct sockaddr_storage *a)
{
    return a->ss_family == AF_INET
               ? ((const struct sockaddr_in *)a)->sin_addr.s_addr == INADDR_ANY
               : IN6_IS_ADDR_UNSPECIFIED(
                     &((const struct sockaddr_in6 *)a)->sin6_addr);
}

static bool overlaps(const struct sockaddr_storage *a,
                     const struct sockaddr_storage *b)
{
    bool same = a->ss_family == b->ss_family;
    const struct sockaddr_in *a4 = (const struct sockaddr_in *)a;
    const struct sockaddr_in *b4 = (const struct sockaddr_in *)b;
    const struct sockaddr_in6 *a6 = (const struct sockaddr_in6 *)a;
    const struct sockaddr_in6 *b6 = (const struct sockaddr_in6 *)b;
    if (port_of(a) != port_of(b) || port_of(a) == 0) {
        return false;
    }
    if (!same) { /* :: takes IPv4 as well */
        return is_any(a->ss_family == AF_INET6 ? a : b);
    }
    return is_any(a) || is_any(b) ||
           (a->ss_family == AF_INET
                ? a4->sin_addr.s_addr == b4->sin_addr.s_addr
                : IN6_ARE_ADDR_EQUAL(&a6->sin6_addr, &b6->sin6_addr));
}

enum pel_err pel_trial_listen(const char *option, int type,
                              const struct sockaddr *address, socklen_t size,
                              struct pel_fault *fault)
{
    struct sockaddr_storage a = { 0 };
    memcpy(&a, address, size);
    for (size_t i = 0; i < tried_count; i++) {
        if (tried[i].type == type && overlaps(&tried[i].address, &a)) {
            return pel_fault_set(fault, PEL_ERR_CONFLICT,
                                 "--%s: port %u is where --%s listens; name "
                                 "another port",
                                 option, port_of(&a), tried[i].option);
        }
    }
    if (tried_count < MOST) {
        tried[tried_count].option = option;
        tried[tried_count].type = type;
        tried[tried_count++].address = a;
    }
    int yes = 1;
    int fd = socket(a.ss_family, type | SOCK_CLOEXEC, 0);
    bool good = fd >= 0 &&
                (type != SOCK_STREAM || setsockopt(fd, SOL_SOCKET, SO_REUSEADDR,
                                                   &yes, sizeof yes) == 0) &&
                bind(fd, address, size) == 0;
    int why = errno;
    if (fd >= 0) {
        close(fd);
    }
    if (!good && why == EADDRINUSE) {
        pel_trial_note("--%s: port %u is in use now; a daemon starts when it "
                       "is free",
                       option, port_of(&a));
        return PEL_OK;
    }
    return good ? PEL_OK
                : pel_fault_set(fault, PEL_ERR_IO,
                                "--%s: cannot listen on port %u: %s", option,
                                port_of(&a), strerror(why));
}

/* --- files ---------------------------------------------------------------- */

enum pel_err pel_trial_write(const char *option, const char *path,
                             struct pel_fault *fault)
{
    struct stat info;
    g_autofree char *folder = g_path_get_dirname(path);
    const char *wrong = NULL;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode)) {
        wrong = "it is a directory";
    } else if (stat(folder, &info) != 0 || !S_ISDIR(info.st_mode)) {
        wrong = "its directory is not there";
    } else if (access(folder, W_OK | X_OK) != 0 ||
               (access(path, F_OK) == 0 && access(path, R_OK | W_OK) != 0)) {
        wrong = strerror(errno);
    }
    return wrong ? pel_fault_set(fault, PEL_ERR_IO,
                                 "--%s: %.140s cannot be written: %s; name a "
                                 "file in a directory that this user may write",
                                 option, path, wrong)
                 : PEL_OK;
}
