/* A CIGI bridge and a host for the unit tests of this room: a datagram is
 * begun, packets are put into it, and it is sent. One user a program. */
#pragma once

#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "base/near.h"
#include "bridges/cigi.h"
#include "bridges/cigi_query.h"
#include "scene/scene_testkit.h"

static struct pel_scene *scene;
static struct pel_cigi *cigi;
static uint8_t bytes[65536];
static size_t used;
static bool little;
static uint32_t frame, last_ig;

static inline int open_bridge(void **state)
{
    (void)state;
    struct pel_cigi_options options = pel_cigi_default_options();
    options.listen = NULL;
    options.database = 5;
    pel_log_set_level(PEL_LOG_ERROR);
    scene = make_scene((struct pel_scene_options){ .wave_count = 20 });
    assert_int_equal(pel_cigi_create(&options, scene, &cigi, NULL), PEL_OK);
    little = false;
    frame = last_ig = 0;
    return 0;
}

static inline int close_bridge(void **state)
{
    (void)state;
    pel_cigi_destroy(cigi);
    pel_scene_destroy(scene);
    return 0;
}

static inline void put(const struct pel_cigi_packet *p)
{
    used += pel_cigi_put(p, little, bytes + used, sizeof bytes - used);
}

/* A packet of kind `kind` from pairs of field and value, ended by 0. */
static inline void with(enum pel_cigi_kind kind, ...)
{
    struct pel_cigi_packet p = pel_cigi_packet_of(kind);
    va_list args;
    va_start(args, kind);
    for (int field; (field = va_arg(args, int)) != 0;) {
        pel_cigi_set(&p, (enum pel_cigi_field)field, va_arg(args, double));
    }
    va_end(args);
    put(&p);
}

static inline void begin_at(uint32_t number)
{
    frame = number;
    used = 0;
    with(PEL_CIGI_KIND_IG_CONTROL, PEL_CIGI_IG_CONTROL_MAJOR, 3.0,
         PEL_CIGI_IG_CONTROL_MINOR, 3.0, PEL_CIGI_IG_CONTROL_MAGIC, 32768.0,
         PEL_CIGI_IG_CONTROL_MODE, 1.0, PEL_CIGI_IG_CONTROL_FRAME,
         (double)frame, 0);
}

static inline void begin(void)
{
    begin_at(frame + 1);
}

static inline void stamped(double timestamp, double database)
{
    frame++;
    used = 0;
    with(PEL_CIGI_KIND_IG_CONTROL, PEL_CIGI_IG_CONTROL_MAJOR, 3.0,
         PEL_CIGI_IG_CONTROL_MINOR, 2.0, PEL_CIGI_IG_CONTROL_MAGIC, 32768.0,
         PEL_CIGI_IG_CONTROL_STAMPED, 1.0, PEL_CIGI_IG_CONTROL_MODE, 1.0,
         PEL_CIGI_IG_CONTROL_FRAME, (double)frame,
         PEL_CIGI_IG_CONTROL_TIMESTAMP, timestamp, PEL_CIGI_IG_CONTROL_DATABASE,
         database, 0);
}

static inline void send(void)
{
    pel_cigi_feed(cigi, bytes, used);
    pel_cigi_settle(cigi);
}

static inline void place_ship(uint32_t id, double latitude, double yaw)
{
    with(PEL_CIGI_KIND_ENTITY_CONTROL, PEL_CIGI_ENTITY_CONTROL_ID, (double)id,
         PEL_CIGI_ENTITY_CONTROL_STATE, 1.0, PEL_CIGI_ENTITY_CONTROL_LATITUDE,
         latitude, PEL_CIGI_ENTITY_CONTROL_LONGITUDE, 5.2,
         PEL_CIGI_ENTITY_CONTROL_ALTITUDE, 2.0, PEL_CIGI_ENTITY_CONTROL_YAW,
         yaw, PEL_CIGI_ENTITY_CONTROL_ROLL, 3.0, 0);
}

static inline const Pelagos__Entity *entity(uint32_t id)
{
    const Pelagos__State *s = pel_scene_state(scene);
    for (size_t i = 0; i < s->n_entities; i++) {
        if (s->entities[i]->id == id) {
            return s->entities[i];
        }
    }
    return NULL;
}

static inline const Pelagos__View *view(const char *name)
{
    const Pelagos__State *s = pel_scene_state(scene);
    for (size_t i = 0; i < s->n_views; i++) {
        if (strcmp(s->views[i]->name, name) == 0) {
            return s->views[i];
        }
    }
    return NULL;
}

/* The next Start of Frame; further packets by next_answer(). */
static struct pel_cigi_reader answers;
static struct pel_cigi_packet sof;

static inline void take_frame(void)
{
    const uint8_t *out;
    size_t size = pel_cigi_frame(cigi, &out);
    assert_int_equal(
        pel_cigi_open(out, size, PEL_CIGI_KIND_START_OF_FRAME, &answers),
        PEL_CIGI_GOOD);
    assert_int_equal(answers.little, little);
    assert_true(pel_cigi_next(&answers, &sof));
    last_ig++;
    assert_near(pel_cigi_get(&sof, PEL_CIGI_START_OF_FRAME_FRAME), last_ig, 0);
    assert_near(pel_cigi_get(&sof, PEL_CIGI_START_OF_FRAME_LAST_HOST_FRAME),
                frame, 0);
}

static inline struct pel_cigi_packet next_answer(enum pel_cigi_kind kind)
{
    struct pel_cigi_packet p;
    assert_true(pel_cigi_next(&answers, &p));
    assert_int_equal(p.kind, kind);
    return p;
}

static inline void no_more_answers(void)
{
    struct pel_cigi_packet p;
    assert_false(pel_cigi_next(&answers, &p));
}

static inline void train(double id, double height, double on)
{
    with(PEL_CIGI_KIND_WAVE, PEL_CIGI_WAVE_ID, id, PEL_CIGI_WAVE_ENABLE, on,
         PEL_CIGI_WAVE_HEIGHT, height, PEL_CIGI_WAVE_PERIOD, 9.0,
         PEL_CIGI_WAVE_DIRECTION, 90.0, 0);
}

static inline void wind(double mps, double from, double visibility)
{
    with(PEL_CIGI_KIND_ATMOSPHERE, PEL_CIGI_ATMOSPHERE_ENABLE, 1.0,
         PEL_CIGI_ATMOSPHERE_WIND, mps, PEL_CIGI_ATMOSPHERE_WIND_DIRECTION,
         from, PEL_CIGI_ATMOSPHERE_VISIBILITY, visibility, 0);
}
