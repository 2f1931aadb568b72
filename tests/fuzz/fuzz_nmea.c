/* A ship's talkers and the NMEA bridge, with a scene of its own: datagrams and
 * streams as they are, or each line framed with the right sum; time, in which
 * fixes grow old and targets go; and a client that takes things away. */
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "bridges/nmea.h"
#include "fuzz_steps.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { FEED, LINES, STREAM, WAIT, REMOVE, STEPS };

struct ship {
    struct pel_scene *scene;
    struct pel_nmea *nmea;
    struct pel_nmea_lines lines;
};

/* Appends `$` or `!`, the line and its sum. */
static size_t frame(char *out, size_t size, const char *line, size_t length)
{
    unsigned sum = 0;
    for (size_t i = 1; i < length; i++) {
        sum ^= (unsigned char)line[i];
    }
    int n = snprintf(out, size, "%.*s*%02X\r\n", (int)length, line, sum);
    return n > 0 && (size_t)n < size ? (size_t)n : 0;
}

static size_t frame_all(char *framed, size_t room, const uint8_t *data,
                        size_t size)
{
    const char *text = (const char *)data, *end = text + size;
    size_t used = 0;
    while (text < end) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        stop = stop ? stop : end;
        if (!memchr(text, 0, (size_t)(stop - text))) {
            used +=
                frame(framed + used, room - used, text, (size_t)(stop - text));
        }
        text = stop + 1;
    }
    return used;
}

static void take_away(struct ship *ship, unsigned which)
{
    char path[32], *paths = path;
    Pelagos__Patch patch = PELAGOS__PATCH__INIT;
    snprintf(path, sizeof path, "entities.%u",
             which % 8 ? PEL_NMEA_TARGET_ID + which % 8 - 1 : 1);
    patch.n_remove = 1;
    patch.remove = &paths;
    (void)!pel_scene_patch(ship->scene, &patch, NULL);
}

static void take(struct ship *ship, const struct fuzz_step *s)
{
    char framed[8192];
    switch (s->what % STEPS) {
    case FEED:
        pel_nmea_feed(ship->nmea, s->data, s->size);
        break;
    case LINES:
        pel_nmea_feed(ship->nmea, framed,
                      frame_all(framed, sizeof framed, s->data, s->size));
        break;
    case STREAM:
        pel_nmea_feed_stream(ship->nmea, &ship->lines, s->data, s->size);
        break;
    case WAIT:
        fuzz_wait(s);
        pel_nmea_tick(ship->nmea, pel_now_ns());
        break;
    default:
        take_away(ship, fuzz_byte(s, 0));
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct fuzz_steps steps = { data, data + size };
    struct fuzz_step step;
    struct pel_nmea_options options = pel_nmea_default_options();
    struct ship ship = { .scene = fuzz_world() };
    double time_s = 0;
    options.listen = NULL;
    options.ais = true;
    options.wind = size > 0 ? data[0] / 8 % 3 : 0;
    if (pel_nmea_create(&options, ship.scene, &ship.nmea, NULL) != PEL_OK) {
        abort();
    }
    for (int i = 0; i < 64 && fuzz_next(&steps, &step); i++) {
        take(&ship, &step);
        fuzz_rest(); /* ships' shapes come when a thread has made them */
        fuzz_look(ship.scene, &time_s);
        struct pel_nmea_status status;
        pel_nmea_status(ship.nmea, &status);
        fuzz_demand(status.targets <= PEL_NMEA_TARGETS);
        fuzz_demand(status.fix_age_s >= -1);
        /* What has passed for long is not shown. */
        if (step.what % STEPS == WAIT && fuzz_byte(&step, 0) % 11 == 10) {
            fuzz_demand(status.targets == 0 && !status.fix_fresh);
        }
    }
    pel_nmea_destroy(ship.nmea);
    pel_scene_destroy(ship.scene);
    return 0;
}
