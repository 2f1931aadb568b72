/* The helper is this program itself, with a word that says what it does. */
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/helper.h"

static int act(const char *word)
{
    static char zeros[1 << 20];
    if (strcmp(word, "say") == 0) {
        /* What it has been given. */
        printf("%s %s %d %zd", getenv("PELAGOS_SECRET") ? "secret" : "none",
               getenv("GDAL_DATA") ? getenv("GDAL_DATA") : "none",
               fcntl(90, F_GETFD), read(STDIN_FILENO, zeros, 1));
    } else if (strcmp(word, "flood") == 0) {
        fwrite(zeros, sizeof zeros, 1, stdout);
    } else if (strcmp(word, "refuse") == 0) {
        fprintf(stderr, "the chart has no depths\n");
        return 1;
    } else if (strcmp(word, "crash") == 0) {
        signal(SIGABRT, SIG_DFL);
        raise(SIGKILL);
    } else if (strcmp(word, "sleep") == 0) {
        pause();
    } else if (strcmp(word, "hide") == 0) {
        close(STDOUT_FILENO);
        close(STDERR_FILENO);
        pause();
    }
    return 0;
}

/* A minute for those that end by themselves. */
static int limit_ms(const char *word)
{
    bool stays = strcmp(word, "sleep") == 0 || strcmp(word, "hide") == 0;
    return stays ? 1000 : 60000;
}

static enum pel_err run(const char *program, char *word, char **out,
                        struct pel_fault *fault)
{
    char *argv[] = { (char *)program, word, NULL };
    const struct pel_helper_task task = { .program = program,
                                          .argv = argv,
                                          .subject = "bay.tif",
                                          .most_bytes = 1000,
                                          .within_ms = limit_ms(word) };
    size_t size = 0;
    unsigned char *bytes = NULL;
    enum pel_err err = pel_helper_run(&task, &bytes, &size, fault);
    *out = NULL;
    if (bytes) { /* no text: it has no end */
        *out = calloc(1, size + 1);
        memcpy(*out, bytes, size);
    }
    free(bytes);
    return err;
}

static void it_gets_no_more_than_it_needs(void **state)
{
    (void)state;
    char *out = NULL;
    struct pel_fault fault = { 0 };
    setenv("PELAGOS_SECRET", "x", 1);
    setenv("GDAL_DATA", "/there", 1);
    int fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
    assert_int_equal(fcntl(fd, F_DUPFD_CLOEXEC, 90), 90);
    if (run("helper_test", (char[]){ "say" }, &out, &fault)) {
        fail_msg("%s", fault.message);
    }
    assert_string_equal(out, "none /there -1 0");
    free(out);
    close(90);
    close(fd);
}

static void its_end_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *word, *words;
    } cases[] = {
        { "refuse", "bay.tif: the chart has no depths" },
        { "flood", "bay.tif: reading it gave more than 1000 bytes" },
        { "crash", "bay.tif: reading it ended with signal 9" },
        { "sleep", "bay.tif: it was not read within 1 s" },
        { "hide", "bay.tif: it was not read within 1 s" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char word[16], *out = NULL;
        struct pel_fault fault = { 0 };
        snprintf(word, sizeof word, "%s", cases[i].word);
        assert_int_equal(run("helper_test", word, &out, &fault),
                         PEL_ERR_INVALID);
        assert_null(out);
        assert_string_equal(fault.message, cases[i].words);
    }
}

static void one_that_is_not_there_is_told(void **state)
{
    (void)state;
    char *out = NULL;
    struct pel_fault fault = { 0 };
    assert_int_equal(run("pelagos-nothing", (char[]){ "say" }, &out, &fault),
                     PEL_ERR_IO);
    assert_string_equal(fault.message, "pelagos-nothing is not installed");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_gets_no_more_than_it_needs),
        cmocka_unit_test(its_end_is_told),
        cmocka_unit_test(one_that_is_not_there_is_told),
    };
    return argc > 1 ? act(argv[1]) : cmocka_run_group_tests(tests, NULL, NULL);
}
