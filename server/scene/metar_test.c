/* Reports as stations sent them, read by hand; what is none is refused whole;
 * what a report does to the state. */
#include "scene/metar.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_testkit.h"

#define KT(N) ((N)*1852.0 / 3600)
#define NO NAN

/* NAN: not said. */
static const struct {
    const char *text;
    double wind, gust, direction, visibility;
    int octas;
    double base, temperature, dew_point, pressure;
    enum pel_metar_fog fog;
    bool rain, snow, thunder;
} reports[] = {
    { "METAR EHAM 231355Z 24015G25KT 210V270 9999 -RA FEW012 SCT020 BKN035 "
      "12/09 Q1003 NOSIG=",
      KT(15), KT(25), 240, 10000, 6, 1066.8, 12, 9, 1003, PEL_METAR_NO_FOG,
      true, false, false },
    { "EGLL 120620Z AUTO 00000KT 0150 R27L/0325N R09R/0450U FG VV001 06/06 "
      "Q1029",
      0, 0, NO, 150, 8, 30.48, 6, 6, 1029, PEL_METAR_FOG, false, false, false },
    { "METAR KJFK 041951Z 18016G24KT 10SM FEW250 29/21 A2998 RMK AO2 SLP152 "
      "T02940211",
      KT(16), KT(24), 180, 16093.44, 2, 7620, 29, 21, 1015.24, PEL_METAR_NO_FOG,
      false, false, false },
    { "SPECI KSFO 151215Z VRB03KT 1 1/2SM BR OVC003 11/11 A3004", KT(3), 0, NO,
      2414.016, 8, 91.44, 11, 11, 1017.27, PEL_METAR_NO_FOG, false, false,
      false },
    { "METAR ULLI 101200Z 08007MPS 3000 -SN BKN008 OVC030CB M05/M07 Q1008 "
      "R28L/590335 TEMPO 1000 SHSN",
      7, 0, 80, 3000, 8, 914.4, -5, -7, 1008, PEL_METAR_NO_FOG, false, true,
      false },
    { "METAR LFPG 302130Z 33004KT CAVOK 21/13 Q1017 NOSIG", KT(4), 0, 330,
      10000, 0, 0, 21, 13, 1017, PEL_METAR_NO_FOG, false, false, false },
    { "METAR WSSS 230630Z 27012KT 4000 +TSRA FEW010CB SCT018 BKN160 25/24 "
      "Q1009 RETS",
      KT(12), 0, 270, 4000, 6, 4876.8, 25, 24, 1009, PEL_METAR_NO_FOG, true,
      false, true },
    { "KBOS 071654Z COR 04022G35KT 1/4SM R04R/1600V2600FT +SN FZFG VV002 "
      "M03/M04 A2956",
      KT(22), KT(35), 40, 402.336, 8, 60.96, -3, -4, 1001.02, PEL_METAR_FOG,
      false, true, false },
    { "METAR EDDF 180520Z 00000KT 4500 MIFG BR NSC 03/02 Q1031 NOSIG", 0, 0, NO,
      4500, 0, 0, 3, 2, 1031, PEL_METAR_SHALLOW, false, false, false },
    { "METAR ENBR 052050Z 16028KT 9999 VCSH FEW015TCU SCT025 BKN042 07/02 "
      "Q0984 "
      "WS R17",
      KT(28), 0, 160, 10000, 6, 1280.16, 7, 2, 984, PEL_METAR_NO_FOG, false,
      false, false },
    { "METAR RJTT 221000Z 05010KT 8000 -SHRA DZ FEW008 BKN012 BKN020 18/17 "
      "Q1012",
      KT(10), 0, 50, 8000, 6, 365.76, 18, 17, 1012, PEL_METAR_NO_FOG, true,
      false, false },
    { "METAR YSSY 140300Z AUTO /////KT //// // ///////// 24/12 Q////", NO, 0,
      NO, NO, -1, 0, 24, 12, NO, PEL_METAR_NO_FOG, false, false, false },
    { "KDEN 281855Z FEW029TCU FEW040 SCT250 09008KT 7SM 32/25 A3008 RMK VIRGA "
      "E TCU NE AND DSNT ALQDS SLP186 T03170250 10328 20267 58007 PK WND "
      "10026/1812",
      KT(8), 0, 90, 11265.408, 4, 7620, 32, 25, 1018.63, PEL_METAR_NO_FOG,
      false, false, false },
    { "METAR COR CYYT 130800Z CCA /////KT", NO, 0, NO, NO, -1, 0, NO, NO, NO,
      PEL_METAR_NO_FOG, false, false, false },
    { "METAR ENVA 130850Z ///12G25KT 3000 DRSN BLSN FEW008CB SCT012/// "
      "BKN020CU M02/M05 Q0978 88290592 W///S3 WS TKOF RWY23L BLACKAMB NOSIG",
      KT(12), KT(25), NO, 3000, 6, 609.6, -2, -5, 978, PEL_METAR_NO_FOG, false,
      false, false },
    { "METAR CYHZ 110900Z 21005KT M1/4SM R05/1000FT/N VCFG VV/// 09/09 A3001",
      KT(5), 0, 210, 402.336, 0, 0, 9, 9, 1016.25, PEL_METAR_PATCHES, false,
      false, false },
};

/* Forms of visibility, metres. */
static const struct {
    const char *text;
    double metres;
    bool ten_km;
} seen[] = {
    { "1/2SM", 804.672, false },
    { "1 1/2SM", 2414.016, false },
    { "11/2SM", 2414.016, false },
    { "21/4SM", 3621.024, false },
    { "113/4SM", 18909.792, true },
    { "11/16SM", 1106.424, false },
    { "M1/4SM", 402.336, false },
    { "P6SM", 9656.064, true },
    { "10SM", 16093.44, true },
    { "6KM", 6000, false },
    { "10KM", 10000, true },
    { "9999NDV", 10000, true },
    { "0800SW", 800, false },
    { "2000 0600NE", 2000, false },
    { "0SM", 0, false },
    { "CAVOK", 10000, true },
};

static void sees_as_far_as_was_said(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof seen / sizeof *seen; i++) {
        char text[80];
        struct pel_metar m;
        struct pel_fault fault = { 0 };
        snprintf(text, sizeof text, "KXYZ 130853Z 24010KT %s 10/08 A3001",
                 seen[i].text);
        print_message("%s\n", text);
        if (pel_metar_parse(text, &m, &fault)) {
            fail_msg("%s", fault.message);
        }
        assert_true(m.has_visibility && m.ten_km == seen[i].ten_km);
        assert_true(fabs(m.visibility_m - seen[i].metres) < 1e-6);
    }
}

static void is(bool has, double value, double wanted, double within)
{
    assert_int_equal(has, !isnan(wanted));
    if (has) {
        assert_true(fabs(value - wanted) <= within);
    }
}

static void says_what_stations_said(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof reports / sizeof *reports; i++) {
        struct pel_metar m;
        struct pel_fault fault = { 0 };
        print_message("%s\n", reports[i].text);
        if (pel_metar_parse(reports[i].text, &m, &fault) != PEL_OK) {
            fail_msg("%s", fault.message);
        }
        is(m.has_wind, m.wind_mps, reports[i].wind, 1e-9);
        is(m.has_direction, m.direction_deg, reports[i].direction, 0);
        assert_true(fabs(m.gust_mps - reports[i].gust) < 1e-9);
        is(m.has_visibility, m.visibility_m, reports[i].visibility, 1e-6);
        assert_int_equal(m.has_clouds, reports[i].octas >= 0);
        if (m.has_clouds) {
            assert_int_equal(m.octas, reports[i].octas);
            assert_true(fabs(m.base_m - reports[i].base) < 1e-6);
        }
        is(m.has_temperature, m.temperature_c, reports[i].temperature, 0);
        is(m.has_dew_point, m.dew_point_c, reports[i].dew_point, 0);
        is(m.has_pressure, m.pressure_hpa, reports[i].pressure, 0.01);
        assert_int_equal(m.fog, reports[i].fog);
        assert_int_equal(m.rain_mm_h > 0, reports[i].rain);
        assert_int_equal(m.snow_mm_h > 0, reports[i].snow);
        assert_int_equal(m.thunder, reports[i].thunder);
    }
}

static void refuses_the_rest(void **state)
{
    (void)state;
    /* And the group that the refusal names. */
    static const char *const wrong[][2] = {
        { "", NULL },
        { "METAR", NULL },
        { "EHAM 231355Z 24O15KT 9999", "24O15KT" },
        { "EHAM 231365Z", "231365Z" },
        { "EHAM 231355Z 37015KT", "37015KT" },
        { "EHAM 231355Z 24025G15KT", "24025G15KT" },
        { "EHAM 231355Z 24015KT 99999", "99999" },
        { "EHAM 231355Z 24015KT 9999 RAIN", "RAIN" },
        { "EHAM 231355Z 24015KT 9999 -", "-" },
        { "EHAM 231355Z 24015KT 9999 BKN12", "BKN12" },
        { "EHAM 231355Z 24015KT 9999 BKN012XX", "BKN012XX" },
        { "EHAM 231355Z 24015KT 9999 BKN012 09/12", "09/12" },
        { "EHAM 231355Z 24015KT 9999 BKN012 12/09 Q2013", "Q2013" },
        { "EHAM 231355Z 24015KT 9999 BKN012 8000", "8000" },
        { "EHAM 231355Z BKN012 24015KT 9999 26010KT", "26010KT" },
        { "EHAM 231355Z 24015KT 12/2SM", "12/2SM" },
        { "EHAM 231355Z 24015KT 3/2SM", "3/2SM" },
        { "EHAM 231355Z 24015KT 1 11/2SM", "11/2SM" },
        { "EHAM 231355Z 24015KT 1 BKN012", "BKN012" },
        { "EHAM 231355Z 24015KT 1", "1" },
        { "EHAM 231355Z 24015KT 1/0SM", "1/0SM" },
        { "eham 231355z", "eham" },
        { "EHAM 24015KT 231355Z", "231355Z" },
        { "EHAM 231355Z RADZSNSGIC", "RADZSNSGIC" },
        { "EHAM AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA",
          "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct pel_metar m;
        struct pel_fault fault = { 0 };
        assert_int_equal(pel_metar_parse(wrong[i][0], &m, &fault),
                         PEL_ERR_INVALID);
        assert_string_equal(fault.path, "sky.metar");
        print_message("%s\n", fault.message);
        if (wrong[i][1]) {
            assert_non_null(strstr(fault.message, wrong[i][1]));
        }
    }
    char *text = calloc(1, PEL_METAR_MOST + 10);
    memset(text, ' ', PEL_METAR_MOST + 1);
    struct pel_metar m;
    assert_int_equal(pel_metar_parse(text, &m, NULL), PEL_ERR_INVALID);
    free(text);
}

static const Pelagos__Sky *report(struct pel_scene *scene, const char *text)
{
    char json[PEL_METAR_MOST + 40];
    snprintf(json, sizeof json, "{\"sky\":{\"metar\":\"%s\"}}", text);
    must(scene, json);
    assert_null(pel_scene_state(scene)->sky->metar);
    return pel_scene_state(scene)->sky;
}

/* By the state's own way, which bounds texts. */
static void a_long_report_is_taken(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 20 });
    char text[PEL_METAR_MOST + 2] = "EHAM 231355Z 24020KT 4000 12/09 Q1003 RMK";
    memset(text + strlen(text), ' ', PEL_METAR_MOST + 1 - strlen(text));
    text[PEL_METAR_MOST - 1] = 'X';
    text[PEL_METAR_MOST] = '\0';
    report(scene, text);
    assert_true(pel_scene_state(scene)->sea->wind_direction == 240);
    char json[PEL_METAR_MOST + 40];
    struct pel_fault fault = { 0 };
    text[PEL_METAR_MOST] = 'X';
    snprintf(json, sizeof json, "{\"sky\":{\"metar\":\"%s\"}}", text);
    assert_int_equal(patch(scene, json, &fault), PEL_ERR_INVALID);
    assert_string_equal(fault.path, "sky.metar");
    assert_non_null(strstr(fault.message, "513 bytes long; at most 512"));
    pel_scene_destroy(scene);
}

/* It is another way to write fields, which stay when it is gone. */
static void sets_the_fields(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 20 });
    const Pelagos__Sky *sky = report(scene, "EHAM 231355Z 24020KT 4000 -RA BR "
                                            "FEW004 BKN012 12/09 Q1003");
    const Pelagos__Sea *sea = pel_scene_state(scene)->sea;
    assert_true(fabs(sea->wind_speed - KT(20)) < 1e-9);
    assert_true(sea->wind_direction == 240);
    assert_true(sky->rain == 1 && sky->snow == 0 && sky->n_fog == 0);
    assert_true(sky->lightning == 0);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_true(fabs(s->visibility_m - 4000) < 1e-6 && sky->visibility > 4000);
    pel_snapshot_unref(s);
    assert_true(sky->cloud_cover == 6 && fabs(sky->cloud_base - 365.76) < 1e-6);
    assert_int_equal(sky->cloud_genus, PELAGOS__CLOUD_GENUS__STRATOCUMULUS);

    sky = report(scene, "EHAM 231425Z 24020KT 4000 +TSRA SCT010CB 12/09 Q1003");
    assert_true(sky->lightning == 3);

    sky = report(scene, "EHAM 231455Z VRB01KT 0150 FG VV001 08/08 Q1021");
    assert_true(sky->lightning == 0);
    assert_true(pel_scene_state(scene)->sea->wind_direction == 240);
    assert_int_equal(sky->n_fog, 1);
    assert_true(sky->fog[0]->visibility == 150 && !sky->fog[0]->has_radius);
    assert_true(fabs(sky->fog[0]->top - 30.48) < 1e-9);
    assert_true(sky->visibility == 10000 && sky->cloud_cover == 0);
    assert_true(sky->rain == 0);
    s = pel_scene_snapshot(scene);
    assert_int_equal(s->fog_count, 1);
    assert_true(fabs(s->fog[0].extinction - 3.912 / 150) < 1e-12);
    pel_snapshot_unref(s);

    sky = report(scene, "EHAM 231555Z 27008KT 9999 BCFG NSC 08/08 Q1021");
    assert_int_equal(sky->n_fog, 3);
    s = pel_scene_snapshot(scene);
    assert_true(fabs(hypot(s->fog[1].east_m, s->fog[1].north_m) - 1300) < 20);
    assert_true(fabs(s->fog[1].east_mps - KT(8)) < 1e-9);
    pel_snapshot_unref(s);

    sky = report(scene, "EHAM 231655Z 27055KT CAVOK 08/02 Q1021");
    assert_true(sky->n_fog == 0 && sky->visibility == 20000);
    assert_true(pel_scene_state(scene)->sea->wind_speed < 30);
    sky = report(scene, "EHAM 231655Z 27085KT 9999 OVC009CB 08/02 Q1021");
    assert_true(pel_scene_state(scene)->sea->wind_speed == 30);
    assert_int_equal(sky->cloud_genus, PELAGOS__CLOUD_GENUS__CUMULONIMBUS);

    /* All or nothing. */
    struct pel_fault fault = { 0 };
    assert_int_equal(
        patch(scene, "{\"sky\":{\"metar\":\"EHAM 231655Z 09010KT 9O00\"}}",
              &fault),
        PEL_ERR_INVALID);
    assert_string_equal(fault.path, "sky.metar");
    assert_true(pel_scene_state(scene)->sea->wind_direction == 270);
    pel_scene_destroy(scene);
}

static void fog_is_checked(void **state)
{
    (void)state;
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 20 });
    struct pel_fault fault = { 0 };
    assert_int_equal(patch(scene,
                           "{\"sky\":{\"fog\":[{\"bottom\":90,\"top\":80}]}}",
                           &fault),
                     PEL_ERR_INVALID);
    assert_string_equal(fault.path, "sky.fog.0.top");
    assert_int_not_equal(
        patch(scene, "{\"sky\":{\"fog\":[{},{},{},{},{}]}}", &fault), PEL_OK);
    assert_int_not_equal(
        patch(scene, "{\"sky\":{\"fog\":[{\"visibility\":3}]}}", &fault),
        PEL_OK);
    must(scene, "{\"sky\":{\"fog\":[{\"radius\":600,\"latitude\":52.61,"
                "\"longitude\":5.2,\"speed\":4,\"direction\":90,"
                "\"time\":100},{}]}}");
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    assert_int_equal(s->fog_count, 2);
    /* Going west, it is at its place at 100 s. */
    assert_true(fabs(s->fog[0].east_mps + 4) < 1e-9);
    assert_true(fabs(s->fog[0].east_m - 400) < 0.1);
    assert_true(fabs(s->fog[0].north_m - 1113) < 2);
    assert_true(s->fog[1].radius_m == 0 && s->fog[1].top_m == 80);
    pel_snapshot_unref(s);
    pel_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(says_what_stations_said),
        cmocka_unit_test(sees_as_far_as_was_said),
        cmocka_unit_test(a_long_report_is_taken),
        cmocka_unit_test(refuses_the_rest),
        cmocka_unit_test(sets_the_fields),
        cmocka_unit_test(fog_is_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
