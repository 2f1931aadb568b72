/* dataset: labelled frames by the million, by a process of the Python client
 * that takes this one's place. */
#include "pelagosctl/ctl.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include <glib.h>

#define PROGRAM "pelagos-dataset"

/* What is handed on as it is. */
static const char *const given[] = { "output", "workers", "device", "threads",
                                     "slurm",  "sbatch",  "task",   "tasks" };
static const char *const flags[] = { "partial", "no-estimate", "json",
                                     "quiet" };

static enum ctl_exit check(struct ctl *ctl)
{
    static const char *const verbs[] = { "plan", "run", "status", "merge",
                                         "work" };
    const char *verb = ctl->args[0], *slurm = ctl_value(ctl, "slurm");
    double number = 0;
    size_t i = 0;
    while (i < G_N_ELEMENTS(verbs) && strcmp(verb, verbs[i]) != 0) {
        i++;
    }
    if (i == G_N_ELEMENTS(verbs)) {
        const char *near = ctl_nearest(verb, verbs, G_N_ELEMENTS(verbs));
        return ctl_say(CTL_USAGE,
                       "dataset %s: plan, run, status, merge or work is "
                       "wanted%s%s%s",
                       verb, near ? "; did you mean " : "", near ? near : "",
                       near ? "?" : "");
    }
    if (slurm && strcmp(slurm, "print") != 0 && strcmp(slurm, "submit") != 0) {
        return ctl_say(CTL_USAGE, "--slurm %s: print or submit is wanted",
                       slurm);
    }
    if (ctl_number(ctl, "workers", 1, 1024, &number) ||
        ctl_number(ctl, "threads", 1, 1024, &number) ||
        ctl_number(ctl, "task", 0, 1e6, &number) ||
        ctl_number(ctl, "tasks", 1, 1e6, &number)) {
        return CTL_USAGE;
    }
    if (ctl_flag(ctl, "task") && !ctl_flag(ctl, "tasks")) {
        return ctl_say(CTL_USAGE, "--task needs --tasks: of how many it is");
    }
    return CTL_DONE;
}

enum ctl_exit ctl_dataset(struct ctl *ctl)
{
    enum ctl_exit status = check(ctl);
    if (status != CTL_DONE) {
        return status;
    }
    g_autofree char *program = ctl_beside(PROGRAM);
    if (!program) {
        return ctl_say(CTL_FAILED,
                       PROGRAM " is not installed: apt install python3-pelagos "
                               "python3-numpy (or pip install pelagos numpy)");
    }
    /* It starts these two; whoever set the variables knows better. */
    g_autofree char *daemon = ctl_beside("pelagosd");
    g_autofree char *own = ctl_beside("pelagosctl");
    if (daemon) {
        g_setenv("PELAGOS_DAEMON", daemon, false);
    }
    if (own) {
        g_setenv("PELAGOS_CTL", own, false);
    }
    g_autoptr(GPtrArray) words = g_ptr_array_new_with_free_func(g_free);
    g_ptr_array_add(words, g_strdup(program));
    g_ptr_array_add(words, g_strdup(ctl->args[0]));
    for (size_t i = 0; i < G_N_ELEMENTS(given); i++) {
        const char *value = ctl_value(ctl, given[i]);
        if (value) {
            g_ptr_array_add(words, g_strdup_printf("--%s=%s", given[i], value));
        }
    }
    for (size_t i = 0; i < G_N_ELEMENTS(flags); i++) {
        if (ctl_flag(ctl, flags[i])) {
            g_ptr_array_add(words, g_strdup_printf("--%s", flags[i]));
        }
    }
    g_ptr_array_add(words, g_strdup("--"));
    g_ptr_array_add(words, g_strdup(ctl->args[1]));
    g_ptr_array_add(words, NULL);
    execv(program, (char **)words->pdata);
    return ctl_say(CTL_FAILED, "%s: %s", program, g_strerror(errno));
}
