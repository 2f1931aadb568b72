/* Where the programs are that pelagosctl starts. */
#include "pelagosctl/ctl.h"

#include <limits.h>
#include <unistd.h>

#include <glib.h>

char *ctl_beside(const char *program)
{
    char own[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", own, sizeof own - 1);
    if (length > 0) {
        own[length] = '\0';
        g_autofree char *folder = g_path_get_dirname(own);
        static const char *const places[] = { ".", "../libexec/pelagos" };
        for (size_t i = 0; i < G_N_ELEMENTS(places); i++) {
            g_autofree char *there =
                g_build_filename(folder, places[i], program, NULL);
            if (access(there, X_OK) == 0) {
                return g_steal_pointer(&there);
            }
        }
    }
    return g_find_program_in_path(program);
}
