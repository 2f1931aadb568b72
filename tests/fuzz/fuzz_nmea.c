/* Datagrams into the NMEA bridge and a real scene. The first byte chooses: as
 * they are, or each line framed with the right sum, to get past it. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "bridges/nmea.h"
#include "scene/scene.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static struct pel_nmea *open_bridge(void)
{
    struct pel_scene_options scene_options = { .wave_count = 20 };
    struct pel_nmea_options options = pel_nmea_default_options();
    struct pel_scene *scene;
    struct pel_nmea *nmea;
    pel_log_set_level(PEL_LOG_ERROR);
    options.listen = NULL;
    options.ais = true;
    if (pel_scene_create(&scene_options, &scene, NULL) != PEL_OK ||
        pel_nmea_create(&options, scene, &nmea, NULL) != PEL_OK) {
        abort();
    }
    return nmea;
}

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

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct pel_nmea *nmea;
    char framed[8192];
    size_t used = 0;
    if (!nmea) {
        nmea = open_bridge();
    }
    if (size == 0) {
        return 0;
    }
    const char *text = (const char *)data + 1;
    const char *end = (const char *)data + size;
    if (data[0] % 2 == 0) {
        pel_nmea_feed(nmea, text, size - 1);
        return 0;
    }
    while (text < end) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        stop = stop ? stop : end;
        if (!memchr(text, 0, (size_t)(stop - text))) {
            used += frame(framed + used, sizeof framed - used, text,
                          (size_t)(stop - text));
        }
        text = stop + 1;
    }
    pel_nmea_feed(nmea, framed, used);
    return 0;
}
