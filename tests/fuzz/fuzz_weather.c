/* Weather fields as the reader process hands them over: what is taken must
 * answer everywhere and always. The first byte puts the magic bytes in front.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/vec.h"
#include "weather/wire.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void look(const struct pel_weather *w)
{
    double span = w->unix_s[w->times - 1] - w->unix_s[0];
    for (int i = -3; i < 14; i++) {
        struct pel_weather_now now;
        pel_weather_at(w, (15 * i - 90) * PEL_DEG,
                       (w->west_deg + 41 * i) * PEL_DEG,
                       w->unix_s[0] + span * i / 9.3, &now);
        if (!(hypot(now.wind_east_mps, now.wind_north_mps) < 182) ||
            !(now.height_m <= 32) || !(fabs(now.period_s) <= 32) ||
            !(fabs(now.direction_rad) <= PEL_PI) || !(now.agreement >= 0) ||
            !(now.agreement <= 1) || !(now.wind_height_m <= 32) ||
            !(fabs(now.swell_period_s) <= 32)) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct pel_weather *w = NULL;
    struct pel_fault fault;
    if (size == 0) {
        return 0;
    }
    unsigned char *bytes = malloc(size + 8);
    if (!bytes) {
        abort();
    }
    size_t magic = data[0] % 2 ? 8 : 0;
    memcpy(bytes, PEL_WEATHER_WIRE_MAGIC, 8);
    memcpy(bytes + magic, data + 1, size - 1);
    if (pel_weather_wire_read(bytes, magic + size - 1, &w, &fault) == PEL_OK) {
        look(w);
        pel_weather_unref(w);
    }
    free(bytes);
    return 0;
}
