#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/file.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_read_whole),
        cmocka_unit_test(what_is_no_regular_file_is_refused_at_once),
        cmocka_unit_test(a_larger_file_is_refused),
    };
    return cmocka_run_group_tests(tests, make_files, remove_files);
}
