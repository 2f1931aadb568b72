/* The sandbox by itself: a child closes it, then tries what a hostile file
 * would make a library do. Each wall alone and both; skipped where the system
 * has none. */
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/sandbox.h"

static char folder[] = "/tmp/pelagos-sandbox-XXXXXX";
static char inside[128], outside[128], beneath[160], leading_out[160];

static void write_file(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("depths", file);
    fclose(file);
}

static int make_files(void **state)
{
    (void)state;
    if (!mkdtemp(folder)) {
        return -1;
    }
    snprintf(inside, sizeof inside, "%s/inside", folder);
    snprintf(outside, sizeof outside, "%s/outside", folder);
    snprintf(beneath, sizeof beneath, "%s/file", inside);
    snprintf(leading_out, sizeof leading_out, "%s/link", inside);
    if (mkdir(inside, 0700) || symlink(outside, leading_out)) {
        return -1;
    }
    write_file(outside);
    write_file(beneath);
    return 0;
}

static int remove_files(void **state)
{
    (void)state;
    unlink(leading_out);
    unlink(beneath);
    unlink(outside);
    return rmdir(inside) || rmdir(folder);
}

/* --- attempts: true where one succeeds ------------------------------------ */

static bool opens(const char *path, int flags)
{
    int fd = open(path, flags, 0600);
    return fd >= 0 && close(fd) == 0;
}

static bool reads_inside(void)
{
    char bytes[8] = "";
    int fd = open(beneath, O_RDONLY);
    return fd >= 0 && read(fd, bytes, sizeof bytes) == 6 &&
           memcmp(bytes, "depths", 6) == 0;
}

static bool lists_inside(void)
{
    return opens(inside, O_RDONLY | O_DIRECTORY);
}

static bool reads_outside(void)
{
    return opens(outside, O_RDONLY);
}

static bool reads_by_link(void)
{
    return opens(leading_out, O_RDONLY);
}

static bool reads_system(void)
{
    return opens("/etc/passwd", O_RDONLY) ||
           opens("/proc/self/environ", O_RDONLY);
}

static bool writes_inside(void)
{
    return opens(beneath, O_WRONLY) || opens(beneath, O_RDWR);
}

static bool writes_outside(void)
{
    return opens(outside, O_WRONLY | O_APPEND);
}

static bool creates(void)
{
    char path[200];
    snprintf(path, sizeof path, "%s.new", beneath);
    return opens(path, O_WRONLY | O_CREAT) || mkdir(path, 0700) == 0 ||
           symlink("x", path) == 0 || link(beneath, path) == 0 ||
           mkfifo(path, 0600) == 0 || opens(inside, O_TMPFILE | O_WRONLY);
}

static bool truncates(void)
{
    return opens(beneath, O_RDONLY | O_TRUNC) || truncate(beneath, 0) == 0;
}

static bool renames(void)
{
    char path[200];
    snprintf(path, sizeof path, "%s.moved", beneath);
    return rename(beneath, path) == 0 || unlink(beneath) == 0;
}

static bool runs_a_program(void)
{
    char *const argv[] = { (char[]){ "true" }, NULL };
    execv("/bin/true", argv);
    return false; /* what it became ends with 0: see attempt() */
}

static bool changes_modes(void)
{
    return chmod(beneath, 0777) == 0;
}

static bool has_sockets(void)
{
    static const int kinds[][2] = { { AF_INET, SOCK_STREAM },
                                    { AF_INET, SOCK_DGRAM },
                                    { AF_INET6, SOCK_STREAM },
                                    { AF_UNIX, SOCK_STREAM },
                                    { AF_NETLINK, SOCK_RAW } };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (socket(kinds[i][0], kinds[i][1], 0) >= 0) {
            return true;
        }
    }
    return false;
}

static bool connects(void)
{
    struct sockaddr_in to = { .sin_family = AF_INET, .sin_port = htons(9) };
    int fd = socket(AF_INET, SOCK_STREAM, 0);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    /* Refused by nobody's listening is reached. */
    return fd >= 0 && (connect(fd, (struct sockaddr *)&to, sizeof to) == 0 ||
                       errno == ECONNREFUSED);
}

static bool makes_processes(void)
{
    pid_t pid = fork();
    if (pid == 0) {
        _exit(0);
    }
    return pid > 0;
}

static bool traces(void)
{
    return syscall(SYS_ptrace, 16 /* attach */, getppid(), 0, 0) == 0;
}

static bool signals_others(void)
{
    return kill(getppid(), 0) == 0;
}

static bool executes_memory(void)
{
    void *at = mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC,
                    MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return at != MAP_FAILED;
}

static bool raises_limits(void)
{
    struct rlimit limit = { 1 << 20, 1 << 20 };
    return setrlimit(RLIMIT_FSIZE, &limit) == 0;
}

static bool holds_descriptors(void)
{
    return fcntl(100, F_GETFD) >= 0;
}

static bool computes(void)
{
    char *bytes = malloc(1 << 22);
    bool good = bytes && memset(bytes, 1, 1 << 22) && getpid() > 0;
    free(bytes);
    return good && write(STDERR_FILENO, "", 0) == 0;
}

/* --- the walls ------------------------------------------------------------ */

/* Whether the attempt succeeds in a child behind the walls. */
static bool attempt(unsigned walls, bool (*try)(void))
{
    const char *const readable[] = { inside, "/no/such/place", NULL };
    const struct pel_sandbox sandbox = { readable, NULL, 5, 1u << 30, walls };
    int status = 0;
    struct pel_fault fault;
    dup2(STDERR_FILENO, 100);
    pid_t pid = fork();
    if (pid == 0) {
        if (pel_sandbox_close(&sandbox, &fault)) {
            fprintf(stderr, "%s\n", fault.message);
            _exit(9);
        }
        _exit(try() ? 0 : 1);
    }
    close(100);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    assert_int_not_equal(WEXITSTATUS(status), 9);
    return WEXITSTATUS(status) == 0;
}

static const struct {
    const char *name;
    bool (*try)(void);
    unsigned kept_by; /* each of these walls alone */
} attempts[] = {
    { "read another file", reads_outside, PEL_SANDBOX_FILES },
    { "read through a link", reads_by_link, PEL_SANDBOX_FILES },
    { "read the system's files", reads_system, PEL_SANDBOX_FILES },
    { "write in the directory", writes_inside, PEL_SANDBOX_ALL },
    { "write elsewhere", writes_outside, PEL_SANDBOX_ALL },
    { "create", creates, PEL_SANDBOX_ALL },
    { "rename, remove", renames, PEL_SANDBOX_ALL },
    { "run a program", runs_a_program, PEL_SANDBOX_ALL },
    { "truncate", truncates, PEL_SANDBOX_CALLS },
    { "change modes", changes_modes, PEL_SANDBOX_CALLS },
    { "make a socket", has_sockets, PEL_SANDBOX_CALLS },
    { "connect", connects, PEL_SANDBOX_CALLS },
    { "make a process", makes_processes, PEL_SANDBOX_CALLS },
    { "trace", traces, PEL_SANDBOX_CALLS },
    { "signal others", signals_others, PEL_SANDBOX_CALLS },
    { "make executable memory", executes_memory, PEL_SANDBOX_CALLS },
    { "set limits", raises_limits, PEL_SANDBOX_CALLS },
    { "use descriptors from before", holds_descriptors, PEL_SANDBOX_ALL },
};

static void check_walls(unsigned walls)
{
    if ((pel_sandbox_walls() & walls) != walls) {
        print_message("skipped: %s\n", pel_sandbox_lack(pel_sandbox_walls()));
        skip();
    }
    assert_true(attempt(walls, reads_inside));
    assert_true(attempt(walls, lists_inside));
    assert_true(attempt(walls, computes));
    for (size_t i = 0; i < sizeof attempts / sizeof *attempts; i++) {
        if ((attempts[i].kept_by & walls) && attempt(walls, attempts[i].try)) {
            fail_msg("walls %u: it could %s", walls, attempts[i].name);
        }
    }
}

static void landlock_alone_holds(void **state)
{
    (void)state;
    check_walls(PEL_SANDBOX_FILES);
}

static void seccomp_alone_holds(void **state)
{
    (void)state;
    check_walls(PEL_SANDBOX_CALLS);
}

static void both_hold(void **state)
{
    (void)state;
    check_walls(PEL_SANDBOX_ALL);
}

/* What the walls keep from would otherwise be possible: the attempts are
 * real. (Some change the files: those are left out here.) */
static void without_walls_nothing_holds(void **state)
{
    (void)state;
    assert_true(attempt(0, reads_outside));
    assert_true(attempt(0, reads_by_link));
    assert_true(attempt(0, writes_inside));
    assert_true(attempt(0, has_sockets));
    assert_true(attempt(0, makes_processes));
    assert_true(attempt(0, runs_a_program));
    assert_true(attempt(0, executes_memory));
    assert_true(attempt(0, signals_others));
    /* Limits and descriptors do without walls. */
    assert_false(attempt(0, holds_descriptors));
}

static bool fills_a_file(void)
{
    int fd = open(beneath, O_WRONLY | O_APPEND);
    signal(SIGXFSZ, SIG_IGN);
    return fd >= 0 && write(fd, "more", 4) == 4;
}

static void files_stay_empty_by_limit(void **state)
{
    (void)state;
    assert_false(attempt(0, fills_a_file));
}

static void a_lack_is_named(void **state)
{
    (void)state;
    assert_null(pel_sandbox_lack(PEL_SANDBOX_ALL));
    assert_non_null(strstr(pel_sandbox_lack(PEL_SANDBOX_FILES), "no seccomp"));
    assert_non_null(strstr(pel_sandbox_lack(PEL_SANDBOX_CALLS), "no Landlock"));
    assert_non_null(strstr(pel_sandbox_lack(0), "neither"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_walls_nothing_holds),
        cmocka_unit_test(files_stay_empty_by_limit),
        cmocka_unit_test(landlock_alone_holds),
        cmocka_unit_test(seccomp_alone_holds),
        cmocka_unit_test(both_hold),
        cmocka_unit_test(a_lack_is_named),
    };
    return cmocka_run_group_tests(tests, make_files, remove_files);
}
