#include "pelagosctl/nmea_log.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static struct nmea_log read_text(const char *text)
{
    struct nmea_log log;
    nmea_log_read(text, strlen(text), &log);
    return log;
}

static void assert_times(const struct nmea_log *log, const double *times,
                         size_t count)
{
    assert_int_equal(log->count, count);
    for (size_t i = 0; i < count; i++) {
        /* Sums of decimal tenths: rounding only. */
        assert_true(fabs(log->lines[i].time_s - times[i]) < 1e-9);
    }
}

static void test_rmc_sets_the_pace(void **state)
{
    (void)state;
    struct nmea_log log = read_text("# a comment\r\n"
                                    "$GPHDT,10.0,T*00\r\n"
                                    "$GPRMC,235958.5,A,,,,,,,,,*00\r\n"
                                    "$GPZDA,235959,01,01,2020,,*00\n"
                                    "!AIVDM,1,1,,A,15,0*00\n"
                                    "noise\n"
                                    "$GPRMC,235959.5,A,,,,,,,,,*00\n"
                                    "$GPRMC,000001.0,A,,,,,,,,,*00");
    const double times[] = { 0, 0, 0, 0, 1.0, 2.5 };
    assert_true(log.stamped);
    assert_times(&log, times, 6);
    assert_true(fabs(log.duration_s - 4.0) < 1e-9);
    assert_int_equal(log.lines[0].length, strlen("$GPHDT,10.0,T*00"));
    nmea_log_finish(&log);
}

static void test_gaps_and_steps_back_count_a_second(void **state)
{
    (void)state;
    struct nmea_log log = read_text("$GPGGA,120000,,,\n$GPGGA,130000,,,\n"
                                    "$GPGGA,125959,,,\n$GPGGA,,,,\n"
                                    "$GPGGA,130001,,,\n");
    const double times[] = { 0, 1, 2, 2, 4 };
    assert_times(&log, times, 5);
    nmea_log_finish(&log);
}

static void test_without_times_repetition_sets_the_pace(void **state)
{
    (void)state;
    struct nmea_log log = read_text("$HCHDG,1\n$WIMWV,1\n$HCHDG,2\n$HCHDG,3\n");
    const double times[] = { 0, 0, 1, 2 };
    assert_false(log.stamped);
    assert_times(&log, times, 4);
    assert_true(fabs(log.duration_s - 3.0) < 1e-9);
    nmea_log_finish(&log);
}

static void test_empty_and_broken_logs(void **state)
{
    (void)state;
    static const char *const texts[] = { "",         "\n\n",
                                         "#\n",      "$",
                                         "$GPRMC",   "$GPRMC,",
                                         "$GPRMC,1", "$GPRMC,99x999,\n" };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct nmea_log log = read_text(texts[i]);
        assert_true(log.count <= 1);
        assert_false(log.stamped);
        assert_true(isfinite(log.duration_s));
        nmea_log_finish(&log);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rmc_sets_the_pace),
        cmocka_unit_test(test_gaps_and_steps_back_count_a_second),
        cmocka_unit_test(test_without_times_repetition_sets_the_pace),
        cmocka_unit_test(test_empty_and_broken_logs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
