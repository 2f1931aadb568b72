#include <fcntl.h>
#include <linux/openat2.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/file.h"
#include "base/sandbox.h"

static char folder[] = "/tmp/pelagos-file-XXXXXX";

static const char *at(const char *name)
{
    static char path[160];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_files(void **state)
{
    (void)state;
    if (!mkdtemp(folder) || mkfifo(at("fifo"), 0600) ||
        mkdir(at("directory"), 0700)) {
        return -1;
    }
    FILE *file = fopen(at("text"), "w");
    fputs("twelve bytes", file);
    fclose(file);
    fclose(fopen(at("empty"), "w"));
    struct sockaddr_un to = { .sun_family = AF_UNIX };
    snprintf(to.sun_path, sizeof to.sun_path, "%.60s/socket", folder);
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    return bind(fd, (struct sockaddr *)&to, sizeof to) || close(fd);
}

static int remove_files(void **state)
{
    (void)state;
    unlink(at("fifo"));
    unlink(at("text"));
    unlink(at("empty"));
    unlink(at("socket"));
    rmdir(at("directory"));
    return rmdir(folder);
}

static void a_file_is_read_whole(void **state)
{
    (void)state;
    char *text = NULL;
    size_t size = 0;
    assert_int_equal(pel_file_read(at("text"), 12, &text, &size, NULL), PEL_OK);
    assert_int_equal(size, 12);
    assert_string_equal(text, "twelve bytes");
    free(text);
    assert_int_equal(pel_file_read(at("empty"), 12, &text, &size, NULL),
                     PEL_OK);
    assert_int_equal(size, 0);
    assert_string_equal(text, "");
    free(text);
    /* Files that say they are empty and are not. */
    assert_int_equal(pel_file_read("/proc/self/stat", 4096, &text, &size, NULL),
                     PEL_OK);
    assert_true(size > 10);
    free(text);
}

/* The alarm ends a test that hangs. */
static void what_is_no_regular_file_is_refused_at_once(void **state)
{
    (void)state;
    static const struct {
        const char *name, *words;
        enum pel_err err;
    } cases[] = {
        { "fifo", "a FIFO", PEL_ERR_INVALID },
        { "directory", "a directory", PEL_ERR_INVALID },
        { "socket", "a socket", PEL_ERR_INVALID },
        { "none", "No such file", PEL_ERR_NOT_FOUND },
        { "text/none", "Not a directory", PEL_ERR_NOT_FOUND },
    };
    char *text;
    size_t size;
    int fd;
    struct pel_fault fault;
    alarm(60);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(
            pel_file_read(at(cases[i].name), 100, &text, &size, &fault),
            cases[i].err);
        assert_non_null(strstr(fault.message, cases[i].words));
        assert_non_null(strstr(fault.message, at(cases[i].name)));
        assert_int_equal(pel_file_open(at(cases[i].name), &fd, NULL),
                         cases[i].err);
    }
    assert_int_equal(pel_file_read("/dev/zero", 100, &text, &size, &fault),
                     PEL_ERR_INVALID);
    assert_non_null(strstr(fault.message, "a device"));
    alarm(0);
}

static void a_larger_file_is_refused(void **state)
{
    (void)state;
    char *text;
    size_t size;
    struct pel_fault fault;
    assert_int_equal(pel_file_read(at("text"), 11, &text, &size, &fault),
                     PEL_ERR_OUT_OF_RANGE);
    assert_non_null(strstr(fault.message, "11 bytes"));
    assert_int_equal(pel_file_read("/proc/self/stat", 10, &text, &size, &fault),
                     PEL_ERR_OUT_OF_RANGE);
}

/* --- links ---------------------------------------------------------------- */

static char tree[] = "/tmp/pelagos-links-XXXXXX";

static const char *in_tree(const char *name)
{
    static char paths[32][160];
    static int turn;
    char *path = paths[turn = (turn + 1) % 32];
    snprintf(path, sizeof paths[0], "%s/%s", tree, name);
    return path;
}

static bool put(const char *name, const char *text)
{
    FILE *file = fopen(in_tree(name), "w");
    return file && fputs(text, file) >= 0 && fclose(file) == 0;
}

/* in/ is the directory, out/ what is beside it. */
static int make_links(void **state)
{
    (void)state;
    if (!mkdtemp(tree) || mkdir(in_tree("in"), 0700) ||
        mkdir(in_tree("in/sub"), 0700) || mkdir(in_tree("out"), 0700) ||
        mkdir(in_tree("in-too"), 0700) || !put("in/own", "own") ||
        !put("in/sub/own", "own") || !put("out/secret", "secret") ||
        !put("in-too/secret", "secret")) {
        return -1;
    }
    const char *const links[][2] = {
        { "own", "in/near" },
        { "../own", "in/sub/up" },
        { "sub", "in/folder" },
        { "near", "in/chain" },
        { in_tree("in/own"), "in/whole" },
        { "../in/own", "in/round" },
        { "../out/secret", "in/away" },
        { in_tree("out/secret"), "in/away-whole" },
        { "../out", "in/away-folder" },
        { "away", "in/away-chain" },
        { "../in-too/secret", "in/away-beside" },
        { "/etc/passwd", "in/passwd" },
        { "/proc/self/cwd/../../../../../etc/passwd", "in/magic" },
        { "loop", "in/loop" },
        { "none", "in/dangling" },
    };
    for (size_t i = 0; i < sizeof links / sizeof *links; i++) {
        if (symlink(links[i][0], in_tree(links[i][1]))) {
            return -1;
        }
    }
    return 0;
}

static int remove_links(void **state)
{
    (void)state;
    char command[80];
    snprintf(command, sizeof command, "rm -r %s", tree);
    return system(command);
}

static const struct {
    const char *name;
    enum pel_err err;
} links_of[] = {
    { "own", PEL_OK },
    { "./own", PEL_OK },
    { "sub/own", PEL_OK },
    { "near", PEL_OK },
    { "sub/up", PEL_OK },
    { "folder/own", PEL_OK },
    { "chain", PEL_OK },
    { "whole", PEL_OK },
    { "round", PEL_OK },
    { "away", PEL_ERR_INVALID },
    { "away-whole", PEL_ERR_INVALID },
    { "away-folder/secret", PEL_ERR_INVALID },
    { "away-chain", PEL_ERR_INVALID },
    { "away-beside", PEL_ERR_INVALID },
    { "passwd", PEL_ERR_INVALID },
    { "magic", PEL_ERR_INVALID },
    { "../out/secret", PEL_ERR_INVALID },
    { "/etc/passwd", PEL_ERR_INVALID },
    { "loop", PEL_ERR_IO },
    { "dangling", PEL_ERR_NOT_FOUND },
    { "sub", PEL_ERR_INVALID }, /* a directory */
};

/* The first that is not as it should be; -1: none. */
static int wrong_link(void)
{
    for (size_t i = 0; i < sizeof links_of / sizeof *links_of; i++) {
        char *text = NULL;
        size_t size;
        int fd = -1;
        enum pel_err err = links_of[i].err;
        bool wrong = pel_file_read_in(in_tree("in"), links_of[i].name, 100,
                                      &text, &size, NULL) != err ||
                     (text && strcmp(text, "own") != 0);
        free(text);
        wrong = wrong || pel_file_open_in(in_tree("in"), links_of[i].name, &fd,
                                          NULL) != err;
        if (fd >= 0) {
            close(fd);
        }
        if (wrong) {
            return (int)i;
        }
    }
    return -1;
}

static void links_that_lead_out_are_refused(void **state)
{
    (void)state;
    int wrong = wrong_link();
    if (wrong >= 0) {
        fail_msg("%s", links_of[wrong].name);
    }
}

/* As a kernel before 5.6 and some supervisors of containers. */
static void so_they_are_without_openat2(void **state)
{
    (void)state;
    const char *const nothing[] = { NULL };
    const struct pel_sandbox sandbox = { nothing, NULL, 60, 1u << 30,
                                         PEL_SANDBOX_CALLS };
    if (!(pel_sandbox_walls() & PEL_SANDBOX_CALLS)) {
        skip();
    }
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0) {
        struct open_how how = { .flags = O_PATH };
        bool closed = pel_sandbox_close(&sandbox, NULL) == PEL_OK &&
                      syscall(SYS_openat2, AT_FDCWD, "/", &how, sizeof how) < 0;
        _exit(closed ? wrong_link() + 1 : 99);
    }
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    if (WEXITSTATUS(status) > 0) {
        fail_msg("%s", WEXITSTATUS(status) == 99
                           ? "no sandbox"
                           : links_of[WEXITSTATUS(status) - 1].name);
    }
}

/* Somebody who may write in the directory turns a link to and fro, and a
 * folder of the path. */
static void whoever_is_fast_gets_nothing_out(void **state)
{
    (void)state;
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        for (;;) {
            (void)!symlink("own", in_tree("in/next"));
            (void)!rename(in_tree("in/next"), in_tree("in/turning"));
            (void)!symlink("../out/secret", in_tree("in/next"));
            (void)!rename(in_tree("in/next"), in_tree("in/turning"));
        }
    }
    int own = 0, refused = 0;
    alarm(60);
    while (own < 10000 || refused < 10000) {
        char *text = NULL;
        size_t size;
        enum pel_err err =
            pel_file_read_in(in_tree("in"), "turning", 100, &text, &size, NULL);
        own += err == PEL_OK;
        refused += err == PEL_ERR_INVALID;
        if (text) {
            assert_string_equal(text, "own");
        }
        free(text);
    }
    alarm(0);
    kill(pid, SIGKILL);
    waitpid(pid, NULL, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_read_whole),
        cmocka_unit_test(what_is_no_regular_file_is_refused_at_once),
        cmocka_unit_test(a_larger_file_is_refused),
    };
    const struct CMUnitTest links[] = {
        cmocka_unit_test(links_that_lead_out_are_refused),
        cmocka_unit_test(so_they_are_without_openat2),
        cmocka_unit_test(whoever_is_fast_gets_nothing_out),
    };
    int failed = cmocka_run_group_tests(tests, make_files, remove_files);
    return failed + cmocka_run_group_tests(links, make_links, remove_links);
}
