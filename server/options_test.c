#include "options.h"

#include <glib.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/hostport.h"

#define READ(options, action, fault, ...)                                      \
    read_options(options, action, fault,                                       \
                 (char *[]){ (char *)"pelagosd", __VA_ARGS__, NULL })

static enum pel_err read_options(struct pel_options *options,
                                 enum pel_options_action *action,
                                 struct pel_fault *fault, char **argv)
{
    int argc = 0;
    while (argv[argc]) {
        argc++;
    }
    return pel_options_read(argc, argv, options, action, fault);
}

static struct pel_options options;
static enum pel_options_action action;
static struct pel_fault fault;

static void defaults_are_the_tables(void **state)
{
    (void)state;
    char *none[] = { (char *)"pelagosd", NULL };
    assert_int_equal(pel_options_read(1, none, &options, &action, &fault),
                     PEL_OK);
    assert_int_equal(action, PEL_ACTION_RUN);
    assert_string_equal(options.http, "127.0.0.1:8080");
    assert_string_equal(options.tcp, "127.0.0.1:7878");
    assert_string_equal(options.modbus, "127.0.0.1:1502");
    assert_string_equal(options.nmea, "127.0.0.1:10110");
    assert_string_equal(options.unix_path, "");
    assert_true(options.fps == 30);
    assert_int_equal(options.waves, 60);
    assert_int_equal(options.log_level, 2);
}

static void both_forms_of_the_command_line(void **state)
{
    (void)state;
    assert_int_equal(READ(&options, &action, &fault, "--fps", "12.5",
                          "--http=[::1]:0", "--tcp", "off", "--plain",
                          "--modbus-order=dcba", "--nmea", "localhost:9",
                          "--modbus-units", "7"),
                     PEL_OK);
    assert_true(options.fps == 12.5);
    assert_string_equal(options.http, "[::1]:0");
    assert_string_equal(options.tcp, "");
    assert_true(options.plain);
    assert_int_equal(options.modbus_order, 3);
    char host[PEL_HOST_SIZE];
    uint16_t port;
    assert_int_equal(pel_hostport_split(options.http, host, &port),
                     PEL_HOST_NUMBER);
    assert_string_equal(host, "::1");
    assert_int_equal(port, 0);
    assert_int_equal(pel_hostport_split(options.nmea, host, &port),
                     PEL_HOST_NUMBER);
    assert_string_equal(host, "127.0.0.1");
    assert_int_equal(port, 9);
}

/* Each message names the option, the value and what is legal. */
static void bad_values_say_what_is_legal(void **state)
{
    (void)state;
    static const struct {
        const char *option, *value, *legal;
    } bad[] = {
        { "--fps", "0", "1 .. 240 Hz" },
        { "--fps", "nan", "1 .. 240 Hz" },
        { "--fps", "inf", "1 .. 240 Hz" },
        { "--fps", "3x", "1 .. 240 Hz" },
        { "--fps", "", "1 .. 240 Hz" },
        { "--waves", "60.5", "20 .. 256" },
        { "--waves", "99999999999999999999", "20 .. 256" },
        { "--log-level", "loud", "error, warning, info, debug" },
        { "--http", "8080", "ADDRESS:PORT" },
        { "--http", "127.0.0.1:65536", "65535" },
        { "--http", "127.0.0.1:", "ADDRESS:PORT" },
        { "--http", "somewhere:80", "ADDRESS:PORT" },
        { "--http", "::1:80", "ADDRESS:PORT" },
        { "--http", "127.0.0.1:80x", "ADDRESS:PORT" },
        { "--device", "gpu", "software" },
        { "--http", "0.0.0.0:8080", "--token-file" },
        { "--tcp", "[::]:8080", "--token-file" },
        { "--rtsp", "10.0.0.1:8554", "--token-file" },
        { "--modbus", "0.0.0.0:1502", "--modbus-allow" },
        { "--nmea", "192.168.1.5:10110", "--nmea-allow" },
        { "--nmea-tcp", "192.168.1.5:10110", "--nmea-allow" },
        { "--cigi", "192.168.1.5:8000", "--cigi-allow" },
        { "--whep-ports", "50063-50000", "1 .. 65535" },
        { "--whep-ports", "0-9", "1 .. 65535" },
        { "--whep-ports", "50000", "FIRST-LAST" },
        { "--whep-servers", "http://here", "stun://" },
        { "--state", "", "off" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_int_not_equal(READ(&options, &action, &fault,
                                  (char *)bad[i].option, (char *)bad[i].value),
                             PEL_OK);
        assert_non_null(strstr(fault.message, bad[i].option));
        assert_non_null(strstr(fault.message, bad[i].value));
        assert_non_null(strstr(fault.message, bad[i].legal));
    }
    assert_int_not_equal(READ(&options, &action, &fault, "--nothing"), PEL_OK);
    assert_non_null(strstr(fault.message, "--nothing"));
    assert_int_not_equal(READ(&options, &action, &fault, "--fps"), PEL_OK);
    assert_int_not_equal(READ(&options, &action, &fault, "stray"), PEL_OK);
    assert_int_not_equal(READ(&options, &action, &fault, "--"), PEL_OK);
    char longest[400];
    memset(longest, 'a', sizeof longest - 1);
    longest[sizeof longest - 1] = 0;
    assert_int_not_equal(READ(&options, &action, &fault, "--state", longest),
                         PEL_OK);
    assert_int_equal(READ(&options, &action, &fault, "--modbus", "0.0.0.0:1502",
                          "--modbus-allow", "10.0.0.0/8"),
                     PEL_OK);
}

/* They are not on the command line. */
static void developers_have_the_environment(void **state)
{
    (void)state;
    assert_true(setenv("PELAGOS_SHADING", "compute", 1) == 0);
    assert_true(setenv("PELAGOS_GL_DEBUG", "yes", 1) == 0);
    assert_true(setenv("PELAGOS_REFLECTION", "paper", 1) == 0);
    assert_true(setenv("PELAGOS_SHADER_DIR", "", 1) == 0);
    assert_int_equal(READ(&options, &action, &fault, "--fps", "20"), PEL_OK);
    assert_int_equal(options.shading, 2);
    assert_true(options.gl_debug);
    assert_int_equal(options.reflection, 1);
    assert_string_equal(options.shader_dir, "");
    assert_true(setenv("PELAGOS_SHADING", "both", 1) == 0);
    assert_int_equal(READ(&options, &action, &fault, "--fps", "20"),
                     PEL_ERR_INVALID);
    assert_non_null(strstr(fault.message, "PELAGOS_SHADING: 'both'"));
    assert_non_null(strstr(fault.message, "auto, fragment, compute"));
    for (const struct pel_option *o = pel_developer_table; o->name; o++) {
        assert_true(unsetenv(o->name) == 0);
    }
    assert_int_equal(READ(&options, &action, &fault, "--shading", "auto"),
                     PEL_ERR_NOT_FOUND);
    assert_int_equal(READ(&options, &action, &fault, "--fps", "20"), PEL_OK);
    assert_int_equal(options.shading, 0);
    assert_false(options.gl_debug);
}

static char *write_file(const char *text)
{
    char *path = NULL;
    int fd = g_file_open_tmp("pelagosd-XXXXXX.conf", &path, NULL);
    assert_true(fd >= 0);
    close(fd);
    assert_true(g_file_set_contents(path, text, -1, NULL));
    return path;
}

static void key_file_is_read_before_the_command_line(void **state)
{
    (void)state;
    char *path = write_file("[render]\nfps=15\n[scene]\nwaves=100\n"
                            "[bridges]\nnmea-ais=yes\nmodbus=off\n");
    assert_int_equal(
        READ(&options, &action, &fault, "--fps", "20", "--config", path),
        PEL_OK);
    assert_true(options.fps == 20);
    assert_int_equal(options.waves, 100);
    assert_true(options.nmea_ais);
    assert_string_equal(options.modbus, "");
    unlink(path);
    g_free(path);
}

static void unknown_options_say_what_was_meant(void **state)
{
    (void)state;
    assert_int_equal(READ(&options, &action, &fault, "--htpp", "1"),
                     PEL_ERR_NOT_FOUND);
    assert_non_null(strstr(fault.message, "did you mean --http?"));
    assert_int_equal(READ(&options, &action, &fault, "--wavs=9"),
                     PEL_ERR_NOT_FOUND);
    assert_non_null(strstr(fault.message, "did you mean --waves?"));
    assert_int_equal(READ(&options, &action, &fault, "--entirely-other"),
                     PEL_ERR_NOT_FOUND);
    assert_null(strstr(fault.message, "mean"));
}

static void bad_key_files_say_where(void **state)
{
    (void)state;
    static const struct {
        const char *text, *say;
    } bad[] = {
        { "[render]\nfps=0\n", "[render] fps" },
        { "[scene]\nfps=10\n", "belongs into [render]" },
        { "[render]\nspeed=1\n", "speed is no option" },
        { "fps=10\n", "" },
        { "[render\n", "" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char *path = write_file(bad[i].text);
        assert_int_not_equal(READ(&options, &action, &fault, "--config", path),
                             PEL_OK);
        assert_non_null(strstr(fault.message, path));
        assert_non_null(strstr(fault.message, bad[i].say));
        unlink(path);
        g_free(path);
    }
    assert_int_not_equal(
        READ(&options, &action, &fault, "--config", "/nonexistent/file"),
        PEL_OK);
}

static char *config_of(const struct pel_options *of)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    pel_options_print_config(file, of);
    fclose(file);
    return text;
}

/* The printed options are those in force, and can be read again. */
static void the_printed_file_is_what_is_in_force(void **state)
{
    (void)state;
    char *path = write_file("[render]\nfps=15\nquality=full\n[scene]\n"
                            "waves=100\n[network]\nallow-origin="
                            "https://a.example , http://b:81\n");
    assert_int_equal(READ(&options, &action, &fault, "--fps", "20", "--config",
                          path, "--nmea-ais", "--cigi-host", "vm:33001",
                          "--print-config"),
                     PEL_OK);
    assert_int_equal(action, PEL_ACTION_CONFIG);
    struct pel_options given = options;
    char *text = config_of(&given);
    g_autofree char *from = g_strdup_printf("# From %s:\nwaves=100\n", path);
    assert_non_null(strstr(text, from));
    assert_non_null(strstr(text, "# From the command line:\nfps=20\n"));
    assert_non_null(strstr(text, "# From the command line:\nnmea-ais=yes\n"));
    assert_non_null(strstr(text, "cigi-host=vm:33001\n"));
    assert_non_null(strstr(text, "quality=full\n"));
    assert_non_null(strstr(text, "https://a.example,http://b:81\n"));
    assert_non_null(strstr(text, "]\ntcp=127.0.0.1:7878\n"));
    char *again = write_file(text);
    assert_int_equal(READ(&options, &action, &fault, "--config", again),
                     PEL_OK);
    for (const struct pel_option *o = pel_option_table; o->name; o++) {
        assert_true(pel_option_equal(o, &options, &given));
    }
    free(text);
    unlink(path);
    unlink(again);
    g_free(path);
    g_free(again);
}

static void passwords_are_not_printed(void **state)
{
    (void)state;
    assert_int_equal(READ(&options, &action, &fault, "--whep-servers",
                          "stun://a:1, turn://me:hush@relay.example:3478",
                          "--exercise",
                          "http://root:hush@10.0.0.1:2379/bridge"),
                     PEL_OK);
    char *text = config_of(&options);
    assert_null(strstr(text, "hush"));
    assert_non_null(strstr(
        text,
        "\n# whep-servers=stun://a:1,turn://me:***@relay.example:3478\n"));
    assert_non_null(
        strstr(text, "\n# exercise=http://root:***@10.0.0.1:2379/bridge\n"));
    free(text);
}

/* Every list is read by one reader: blanks, and why an element is none. */
static void lists_take_blanks_and_refuse_nonsense(void **state)
{
    (void)state;
    static const struct {
        const char *option, *value, *kept;
    } good[] = {
        { "--allow-origin", " https://a.example ,http://b:8080,\tapp://c",
          "https://a.example,http://b:8080,app://c" },
        { "--allow-origin", "https://[::1]:8443", "https://[::1]:8443" },
        { "--http-hosts", "ship.example, bridge", "ship.example,bridge" },
        { "--trust-proxy", "127.0.0.1 , ::1", "127.0.0.1,::1" },
        { "--whep-servers", "stun://a:3478, turns://u:p@b",
          "stun://a:3478,turns://u:p@b" },
        { "--modbus-allow", "10.0.0.7, 192.168.1.0/24",
          "10.0.0.7,192.168.1.0/24" },
        { "--nmea-allow", " fd00::/8", "fd00::/8" },
        { "--cigi-allow", "10.0.0.0/8 ,10.1.2.3", "10.0.0.0/8,10.1.2.3" },
        { "--modbus-units", "1, 2:cdab", "1,2:cdab" },
        { "--modbus-safe", "a=1, b=2", "a=1,b=2" },
        { "--nmea-out", "127.0.0.1:1, 7@chart.example:10110, [::1]:9",
          "127.0.0.1:1,7@chart.example:10110,[::1]:9" },
        { "--device", "0, 1, software", "0,1,software" },
        { "--exercise", "http://a:1, http://b:2/x", "http://a:1,http://b:2/x" },
        { "--nmea-out", "off", "" },
        { "--http-hosts", "  ", "" },
    };
    static const struct {
        const char *option, *value, *why;
    } bad[] = {
        { "--allow-origin", "foo", "scheme://host[:port]" },
        { "--allow-origin", "https://a.example, foo", "'foo'" },
        { "--allow-origin", "*", "scheme://host[:port]" },
        { "--allow-origin", "null", "scheme://host[:port]" },
        { "--allow-origin", "https://a.example/", "no path" },
        { "--allow-origin", "https://a.example/page", "no path" },
        { "--allow-origin", "https://a.example?x", "no path" },
        { "--allow-origin", "https://", "no host" },
        { "--allow-origin", "https://me@a.example", "no user" },
        { "--allow-origin", "https://a.example:0", "1 .. 65535" },
        { "--allow-origin", "https://a.example:x", "1 .. 65535" },
        { "--allow-origin", "https://a.example:443", "leave" },
        { "--allow-origin", "https://a b", "no host" },
        { "--allow-origin", "https://a.example,,https://b", "two commas" },
        { "--trust-proxy", "nginx", "numeric" },
        { "--trust-proxy", "127.0.0.1, 10.0.0.0/8", "numeric" },
        { "--trust-proxy", "127.0.0.1:80", "numeric" },
        { "--http-hosts", "http://x/", "no scheme" },
        { "--http-hosts", "x:8080", "port" },
        { "--http-hosts", "x/y", "name of a host" },
        { "--http-hosts", "10.0.0.1", "numeric" },
        { "--http-hosts", "a, ", "two commas" },
        { "--whep-servers", "stun://a, http://b", "turn://" },
        { "--modbus-allow", "10.0.0", "address or network" },
        { "--nmea-allow", "bridge", "address or network" },
        { "--cigi-allow", "10.0.0.0/33", "address or network" },
        { "--nmea-out", "chart", "HOST:PORT" },
        { "--nmea-out", "x@127.0.0.1:1", "HOST:PORT" },
        { "--nmea-out", "70000@127.0.0.1:1", "HOST:PORT" },
        { "--nmea-out", "127.0.0.1:0", "HOST:PORT" },
        { "--nmea-out", "1.2.3:4", "HOST:PORT" },
        { "--device", "0, gpu", "software" },
        { "--device", "all,0", "neither all" },
        { "--device", "off", "neither all" },
        { "--cigi-host", "vm", "HOST:PORT" },
        { "--cigi-host", "256.1.1.1:80", "HOST:PORT" },
        { "--cigi-host", "vm:0", "HOST:PORT" },
        { "--console", "a b:502", "HOST:PORT" },
    };
    for (size_t i = 0; i < G_N_ELEMENTS(good); i++) {
        assert_int_equal(READ(&options, &action, &fault, (char *)good[i].option,
                              (char *)good[i].value),
                         PEL_OK);
        for (const struct pel_option *o = pel_option_table; o->name; o++) {
            if (strcmp(o->name, good[i].option + 2) == 0) {
                char text[PEL_OPTION_TEXT];
                assert_int_equal(o->kind, PEL_OPTION_LIST);
                pel_option_text(o, &options, text);
                assert_string_equal(text, good[i].kept);
            }
        }
    }
    for (size_t i = 0; i < G_N_ELEMENTS(bad); i++) {
        enum pel_err err = READ(&options, &action, &fault,
                                (char *)bad[i].option, (char *)bad[i].value);
        if (err == PEL_OK || !strstr(fault.message, bad[i].why)) {
            fail_msg("%s '%s': %s", bad[i].option, bad[i].value,
                     err ? fault.message : "taken");
        }
        assert_non_null(strstr(fault.message, bad[i].option));
    }
}

static void texts_name_every_option(void **state)
{
    (void)state;
    void (*const printers[])(FILE *) = { pel_options_print_help,
                                         pel_options_print_man,
                                         pel_options_print_completion };
    for (size_t i = 0; i < G_N_ELEMENTS(printers); i++) {
        char *text = NULL;
        size_t size = 0;
        FILE *file = open_memstream(&text, &size);
        printers[i](file);
        fclose(file);
        for (char *c = text; *c; c++) { /* undo roff's minus */
            if (c[0] == '\\' && c[1] == '-') {
                memmove(c, c + 1, strlen(c));
            }
        }
        for (const struct pel_option *o = pel_option_table; o->name; o++) {
            assert_non_null(strstr(text, o->name));
        }
        free(text);
    }
}

static void actions_are_found(void **state)
{
    (void)state;
    assert_int_equal(READ(&options, &action, &fault, "--help"), PEL_OK);
    assert_int_equal(action, PEL_ACTION_HELP);
    assert_int_equal(READ(&options, &action, &fault, "-h"), PEL_OK);
    assert_int_equal(action, PEL_ACTION_HELP);
    assert_int_equal(READ(&options, &action, &fault, "--check"), PEL_OK);
    assert_int_equal(action, PEL_ACTION_CHECK);
    assert_int_equal(READ(&options, &action, &fault, "--version"), PEL_OK);
    assert_int_equal(action, PEL_ACTION_VERSION);
    assert_int_not_equal(READ(&options, &action, &fault, "--help=1"), PEL_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_the_tables),
        cmocka_unit_test(both_forms_of_the_command_line),
        cmocka_unit_test(bad_values_say_what_is_legal),
        cmocka_unit_test(developers_have_the_environment),
        cmocka_unit_test(key_file_is_read_before_the_command_line),
        cmocka_unit_test(unknown_options_say_what_was_meant),
        cmocka_unit_test(bad_key_files_say_where),
        cmocka_unit_test(the_printed_file_is_what_is_in_force),
        cmocka_unit_test(passwords_are_not_printed),
        cmocka_unit_test(lists_take_blanks_and_refuse_nonsense),
        cmocka_unit_test(texts_name_every_option),
        cmocka_unit_test(actions_are_found),
    };
    return cmocka_run_group_tests_name("options", tests, NULL, NULL);
}
