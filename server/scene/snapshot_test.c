#include "scene/snapshot.h"

#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "formats.h"
#include "models/builtin.h"
#include "scene/scene_testkit.h"

/* Rounding of a few dozen operations on numbers of order one. */
#define EPS 1e-12

static void near(double got, double want, double tolerance)
{
    if (!(fabs(got - want) <= tolerance)) {
        fail_msg("%.12g is not %.12g ± %g", got, want, tolerance);
    }
}

static void near3(struct pel_vec3 got, double x, double y, double z)
{
    near(got.x, x, EPS);
    near(got.y, y, EPS);
    near(got.z, z, EPS);
}

static const struct pel_snapshot *snapshot_of(const char *json)
{
    struct pel_scene *scene =
        make_scene((struct pel_scene_options){ .wave_count = 60 });
    must(scene, json);
    const struct pel_snapshot *s = pel_scene_snapshot(scene);
    pel_scene_destroy(scene);
    return s;
}

static struct pel_camera camera_of(const char *json, uint32_t width,
                                   uint32_t height)
{
    const struct pel_snapshot *s = snapshot_of(json);
    struct pel_camera camera;
    pel_snapshot_camera(s, 0, s->entities[0].pose_time_s, width, height,
                        &camera);
    pel_snapshot_unref(s);
    const struct pel_mat3 *m = &camera.world_from_camera;
    near3(pel_vec3_cross(m->x, m->y), m->z.x, m->z.y, m->z.z);
    near(pel_vec3_dot(m->x, m->x), 1, EPS);
    near(pel_vec3_dot(m->x, m->y), 0, EPS);
    return camera;
}

/* {"entities":{"1":{E}},"views":{"bridge":{V}}} with the origin at the ship. */
#define SHIP(e, v)                                                             \
    "{\"entities\":{\"1\":{" e "}},\"views\":{\"bridge\":{\"roll\":0" v "}}}"

static void the_camera_looks_ahead(void **state)
{
    (void)state;
    struct pel_camera c = camera_of(SHIP("", ""), 0, 0);
    near3(c.world_from_camera.x, 1, 0, 0);
    near3(c.world_from_camera.y, 0, 0, 1);
    near3(c.world_from_camera.z, 0, -1, 0);
    c = camera_of(SHIP("\"heading\":90", ""), 0, 0);
    near3(c.world_from_camera.x, 0, -1, 0);
    near3(c.world_from_camera.z, -1, 0, 0);
    c = camera_of(SHIP("\"heading\":90", ",\"yaw\":90"), 0, 0);
    near3(c.world_from_camera.z, 0, 1, 0); /* south */
    c = camera_of(SHIP("\"pitch\":30", ""), 0, 0);
    near3(c.world_from_camera.z, 0, -cos(30 * PEL_DEG), -sin(30 * PEL_DEG));
    c = camera_of(SHIP("", ",\"pitch\":-90"), 0, 0);
    near3(c.world_from_camera.z, 0, 0, 1); /* looks down */
    near3(c.world_from_camera.y, 0, 1, 0);
}

static void the_ships_attitude_moves_the_camera(void **state)
{
    (void)state;
    /* Starboard down by 90°: to starboard is down, up is to starboard. */
    struct pel_camera c = camera_of(
        SHIP("\"roll\":90", ",\"right\":2,\"up\":3,\"forward\":5"), 0, 0);
    near3(c.world_from_camera.x, 0, 0, -1);
    near3(c.world_from_camera.y, 1, 0, 0);
    near(c.east_m, 3, 1e-6);
    near(c.north_m, 5, 1e-6);
    near(c.altitude_m, -2, EPS);
    /* Bow up by 90°, at altitude 7, heading east. */
    c = camera_of(SHIP("\"pitch\":90,\"altitude\":7,\"heading\":90",
                       ",\"up\":3,\"forward\":5"),
                  0, 0);
    near(c.altitude_m, 12, EPS);
    near(c.east_m, -3, 1e-6);
    /* To starboard of a ship that heels: the camera rolls with pitch. */
    c = camera_of(SHIP("\"pitch\":20", ",\"yaw\":90"), 0, 0);
    near3(c.world_from_camera.z, -1, 0, 0);
    near3(c.world_from_camera.x, 0, -cos(20 * PEL_DEG), -sin(20 * PEL_DEG));
}

static void the_world_can_carry_a_view(void **state)
{
    (void)state;
    struct pel_camera c =
        camera_of(SHIP("\"heading\":50",
                       ",\"entity\":null,\"up\":4,\"forward\":10,\"right\":20"),
                  0, 0);
    near(c.east_m, 20, EPS);
    near(c.north_m, 10, EPS);
    near(c.altitude_m, 4, EPS);
    near3(c.world_from_camera.z, 0, -1, 0);
}

/* 10 m/s north: for 60 s, or as long as clock.reckoning says. */
static void poses_are_reckoned_for_a_bounded_time(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        double seconds, north_m;
    } cases[] = {
        { "{\"entities\":{\"1\":{\"speed\":10}}}", 59, 590 },
        { "{\"entities\":{\"1\":{\"speed\":10}}}", 90, 600 },
        { "{\"entities\":{\"1\":{\"speed\":10}},"
          "\"clock\":{\"reckoning\":100}}",
          90, 900 },
        { "{\"entities\":{\"1\":{\"speed\":10}},"
          "\"clock\":{\"reckoning\":0}}",
          90, 0 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const struct pel_snapshot *s = snapshot_of(cases[i].json);
        struct pel_entity_state from, at;
        double pose_s = s->entities[0].pose_time_s;
        pel_snapshot_entity_at(s, 0, pose_s, &from);
        pel_snapshot_entity_at(s, 0, pose_s + cases[i].seconds, &at);
        near(at.north_m - from.north_m, cases[i].north_m, 1e-9);
        pel_snapshot_unref(s);
    }
}

static void poses_grow_stale(void **state)
{
    (void)state;
    const struct pel_snapshot *s = snapshot_of(
        "{\"clock\":{\"mode\":\"STEPPED\",\"time\":10,\"reckoning\":5},"
        "\"sources\":{\"nmeaStale\":true},\"entities\":{"
        "\"1\":{\"climbRate\":2,\"rollRate\":3,\"altitude\":4},"
        "\"2\":{\"poseTime\":0}}}"); /* this one lies still */
    struct pel_entity_state e;
    pel_snapshot_entity_at(s, 0, 12, &e);
    near(e.altitude_m, 8, EPS);
    near(e.roll_rad, 6 * PEL_DEG, EPS);
    assert_int_equal(pel_snapshot_stale(s, 15), PEL_STALE_NMEA);
    assert_int_equal(pel_snapshot_stale(s, 15.1),
                     PEL_STALE_NMEA | PEL_STALE_POSES);
    pel_snapshot_entity_at(s, 0, 99, &e);
    near(e.altitude_m, 14, EPS); /* it stands */
    pel_snapshot_unref(s);
    s = snapshot_of("{\"ownShip\":{\"on\":true,\"throttle\":1},"
                    "\"clock\":{\"mode\":\"STEPPED\",\"reckoning\":5}}");
    assert_int_equal(pel_snapshot_stale(s, 100), 0); /* the model moves it */
    pel_snapshot_unref(s);
}

static void silent_inputs_have_names(void **state)
{
    (void)state;
    char text[PEL_STALE_TEXT];
    assert_string_equal(pel_stale_text(0, text), "none");
    assert_string_equal(pel_stale_text(31, text),
                        "cigi,modbus,nmea,console,other");
    const struct pel_snapshot *s =
        snapshot_of("{\"sources\":{\"mark\":true,\"nmeaStale\":true,"
                    "\"otherStale\":true},\"sea\":{\"level\":-1.5}}");
    assert_string_equal(pel_stale_text(s->stale, text), "nmea,other");
    assert_true(s->mark_stale);
    near(s->sea_level_m, -1.5, 0);
    struct pel_vec2 place = { 30, -7 };
    struct pel_surface_sample with, without;
    pel_snapshot_surface(s, &place, 1, 9, false, &with);
    pel_sea_sample(pel_snapshot_sea(s), 30, -7, 9, &without);
    near(with.height_m, without.height_m - 1.5, 0);
    pel_snapshot_unref(s);
}

static void pictures_keep_their_field(void **state)
{
    (void)state;
#define WIDE SHIP("", ",\"fieldOfView\":90,\"width\":1600,\"height\":800")
    struct pel_camera c = camera_of(WIDE, 0, 0);
    near(c.tan_left, -1, EPS);
    near(c.tan_right, 1, EPS);
    near(c.tan_top, 0.5, EPS);
    near(c.tan_bottom, -0.5, EPS);
    assert_int_equal(c.width, 1600);
    c = camera_of(WIDE, 300, 300);
    near(c.tan_right, 1, EPS);
    near(c.tan_top, 1, EPS);
    assert_int_equal(c.height, 300);
    assert_true(c.auto_exposure);
    c = camera_of(SHIP("", ",\"frustum\":{\"left\":-45,\"right\":0,"
                           "\"top\":20,\"bottom\":-10},\"exposure\":12"),
                  0, 0);
    near(c.tan_left, -1, EPS);
    near(c.tan_right, 0, EPS);
    near(c.tan_top, tan(20 * PEL_DEG), 0); /* to the bit: tiles must meet */
    near(c.tan_bottom, tan(-10 * PEL_DEG), 0);
    assert_false(c.auto_exposure);
    near(c.exposure_ev, 12, 0);
    assert_int_equal(c.tone, PEL_TONE_FILMIC);
    near(c.glare, 0.01, 0);
    assert_int_equal(c.sight_count, 0);
}

/* A camera that is carried level has the place and heading of its ship. */
static void level_views_do_not_roll(void **state)
{
    (void)state;
#define TILTED(level)                                                          \
    SHIP("\"heading\":90,\"pitch\":20,\"roll\":30",                            \
         ",\"forward\":-100,\"up\":10,\"level\":" level)
    struct pel_camera c = camera_of(TILTED("true"), 0, 0);
    near(c.east_m, -100, EPS);
    near(c.north_m, 0, EPS);
    near(c.altitude_m, 10, EPS);
    near(c.world_from_camera.x.z, 0, EPS);
    near(c.world_from_camera.z.z, 0, EPS);
    c = camera_of(TILTED("false"), 0, 0);
    near(c.world_from_camera.z.z, -sin(20 * PEL_DEG), EPS);
#undef TILTED
}

static void views_share_a_meter(void **state)
{
    (void)state;
    const struct pel_snapshot *s = snapshot_of(
        "{\"entities\":[{\"id\":1,\"altitude\":3}],\"views\":{"
        "\"a\":{\"meter\":\"m\",\"entity\":1,\"yaw\":-60,\"up\":20},"
        "\"b\":{\"meter\":\"n\"},"
        "\"c\":{\"meter\":\"m\",\"yaw\":60,\"width\":500,\"height\":250,"
        "\"fieldOfView\":90}}}");
    struct pel_camera a, c;
    /* The size that a picture is asked for in changes no exposure. */
    pel_snapshot_camera(s, (size_t)pel_snapshot_find_view(s, "a"), 5, 0, 0, &a);
    pel_snapshot_camera(s, (size_t)pel_snapshot_find_view(s, "c"), 5, 90, 90,
                        &c);
    assert_int_equal(a.sight_count, 2);
    assert_int_equal(c.sight_count, 2);
    assert_memory_equal(a.sights, c.sights, 2 * sizeof a.sights[0]);
    near(a.sights[0].altitude_m, 23, EPS);
    assert_memory_equal(&a.sights[0].world_from_camera, &a.world_from_camera,
                        sizeof a.world_from_camera);
    near(c.sights[1].tan_top, 0.5, EPS);
    near(c.tan_top, 1, EPS);
    pel_snapshot_camera(s, (size_t)pel_snapshot_find_view(s, "b"), 5, 0, 0, &a);
    assert_int_equal(a.sight_count, 1);
    pel_snapshot_unref(s);
}

static void entities_go_on(void **state)
{
    (void)state;
    const struct pel_snapshot *s =
        snapshot_of(SHIP("\"speed\":10,\"course\":90,\"heading\":80,"
                         "\"turnRate\":3,\"poseTime\":100",
                         ""));
    struct pel_entity_state at;
    pel_snapshot_entity_at(s, 0, 130, &at);
    double radius = 10 / (3 * PEL_DEG);
    near(at.heading_rad / PEL_DEG, 170, 1e-9);
    near(at.course_rad / PEL_DEG, 180, 1e-9);
    near(at.east_m, radius, 1e-6);
    near(at.north_m, -radius, 1e-6);
    near(at.pose_time_s, 130, 0);
    struct pel_entity_state held, later;
    pel_snapshot_entity_at(s, 0, 160, &held);
    pel_snapshot_entity_at(s, 0, 1000, &later);
    assert_memory_equal(&held, &later, sizeof held);
    pel_snapshot_unref(s);
}

/* A buoy of 3 m in a long swell: the height and the slopes of the sea, which is
 * a plane under it to a few millimetres. */
static void what_floats_lies_in_the_sea(void **state)
{
    (void)state;
    const struct pel_snapshot *s = snapshot_of(
        "{\"sea\":{\"windSpeed\":0,\"level\":0.7,\"swell\":[{\"height\":2,"
        "\"period\":12}]},\"entities\":{\"1\":{\"heading\":30}}}");
    const struct pel_builtin what = { .name = "cardinal-north" };
    struct pel_entity_state buoy = s->entities[0], at;
    struct pel_fault fault;
    assert_int_equal(pel_builtin_make(&what, &buoy.model, &fault), PEL_OK);
    struct pel_snapshot with = *s;
    with.entities = &buoy;
    pel_snapshot_entity_at(&with, 0, 7, &at);
    near(at.altitude_m, buoy.altitude_m, EPS);
    buoy.afloat = true;
    for (double t = 5; t < 12; t += 1.7) {
        pel_snapshot_entity_at(&with, 0, t, &at);
        double sh = sin(at.heading_rad), ch = cos(at.heading_rad);
        const struct pel_vec2 around[] = { { at.east_m, at.north_m },
                                           { at.east_m + sh, at.north_m + ch },
                                           { at.east_m + ch,
                                             at.north_m - sh } };
        struct pel_surface_sample sea[3];
        pel_snapshot_surface(s, around, 3, t, false, sea);
        near(at.altitude_m, sea[0].height_m, 0.01);
        near(tan(at.pitch_rad), sea[1].height_m - sea[0].height_m, 0.005);
        near(tan(at.roll_rad), sea[0].height_m - sea[2].height_m, 0.005);
    }
    struct pel_object object[PEL_MAX_ENTITIES];
    assert_int_equal(pel_snapshot_objects(&with, 7, NULL, object), 1);
    const struct pel_mat3 *m = &object[0].world_from_model;
    near3(pel_vec3_cross(m->x, m->y), m->z.x, m->z.y, m->z.z);
    assert_int_equal(pel_snapshot_objects(s, 7, NULL, object), 0);
    pel_model_unref(buoy.model);
    pel_snapshot_unref(s);
}

static void the_sun_can_be_fixed(void **state)
{
    (void)state;
    const struct pel_snapshot *s =
        snapshot_of("{\"sky\":{\"sunAzimuth\":90,\"sunElevation\":30}}");
    struct pel_vec3 sun = pel_snapshot_sun(s, 5);
    near3(sun, cos(30 * PEL_DEG), 0, 0.5);
    pel_snapshot_unref(s);
    /* Default: Lelystad at 12:00 UTC of midsummer, Sun past south, at about
     * 90 - 52.6 + 23.4 degrees; an hour later further west. */
    s = snapshot_of("{}");
    sun = pel_snapshot_sun(s, 0);
    near(asin(sun.z) / PEL_DEG, 60.8, 0.3);
    assert_true(sun.y < 0 && sun.x < 0);
    assert_true(pel_snapshot_sun(s, 3600).x < sun.x);
    pel_snapshot_unref(s);
    /* Elevation alone: the azimuth is still that of the time. */
    s = snapshot_of("{\"sky\":{\"sunElevation\":0}}");
    struct pel_vec3 low = pel_snapshot_sun(s, 0);
    near(low.z, 0, EPS);
    near(atan2(low.x, low.y), atan2(sun.x, sun.y), EPS);
    pel_snapshot_unref(s);
}

/* "NORTH_ATLANTIC" as "north-atlantic", Jerlov's "C1" as "1C". */
static void spoken(const char *name, char out[32])
{
    bool turned = name[0] == 'C' && isdigit((unsigned char)name[1]);
    size_t n = strlen(name);
    assert_true(n < 32);
    for (size_t i = 0; i <= n; i++) {
        char c = turned && i < n ? name[n - 1 - i] : name[i];
        out[i] = (char)(c == '_' ? '-' : tolower((unsigned char)c));
    }
}

static void numbered_alike(const ProtobufCEnumDescriptor *schema,
                           unsigned count, const char *(*word)(int))
{
    assert_int_equal(schema->n_values, count);
    for (unsigned i = 0; i < count; i++) {
        char want[32], have[32];
        assert_int_equal(schema->values[i].value, i);
        spoken(schema->values[i].name, want);
        assert_non_null(word((int)i));
        spoken(word((int)i), have);
        assert_string_equal(have, want);
    }
}

/* A name that is appended to the schema alone would index past a table. */
static void enums_are_numbered_as_in_the_schema(void **state)
{
    (void)state;
    numbered_alike(&pelagos__jerlov_type__descriptor, PEL_JERLOV_COUNT,
                   pel_jerlov_word);
    numbered_alike(&pelagos__water_name__descriptor, PEL_WATER_NAME_COUNT,
                   pel_water_name_word);
    numbered_alike(&pelagos__bottom__descriptor, PEL_BOTTOM_ALBEDO,
                   pel_bottom_word);
    assert_int_equal(pelagos__water_orders__descriptor.n_values,
                     PEL_ORDERS_COUNT);
    assert_int_equal(pelagos__clock_mode__descriptor.n_values,
                     PEL_CLOCK_HOST + 1);
    assert_int_equal(pelagos__spectrum_kind__descriptor.n_values, PEL_SPECTRA);
    /* Every format of the schema is a row that endings and paths lead to. */
    const ProtobufCEnumDescriptor *formats = &pelagos__frame_format__descriptor;
    assert_int_equal(formats->n_values, PEL_FORMATS);
    for (unsigned i = 0; i < formats->n_values; i++) {
        const struct pel_format *row =
            pel_format_of((Pelagos__FrameFormat)formats->values[i].value);
        assert_non_null(row);
        assert_string_equal(row->name, formats->values[i].name);
        assert_ptr_equal(pel_format_by_ending(row->ending), row);
    }
    assert_ptr_equal(pel_format_by_path("a.b/c.JPEG"),
                     pel_format_of(PELAGOS__FRAME_FORMAT__JPEG));
    assert_null(pel_format_by_path("clip.mp4"));
    assert_null(pel_format_by_path("exr"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_camera_looks_ahead),
        cmocka_unit_test(the_ships_attitude_moves_the_camera),
        cmocka_unit_test(the_world_can_carry_a_view),
        cmocka_unit_test(poses_are_reckoned_for_a_bounded_time),
        cmocka_unit_test(poses_grow_stale),
        cmocka_unit_test(silent_inputs_have_names),
        cmocka_unit_test(pictures_keep_their_field),
        cmocka_unit_test(level_views_do_not_roll),
        cmocka_unit_test(views_share_a_meter),
        cmocka_unit_test(entities_go_on),
        cmocka_unit_test(what_floats_lies_in_the_sea),
        cmocka_unit_test(the_sun_can_be_fixed),
        cmocka_unit_test(enums_are_numbered_as_in_the_schema),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
