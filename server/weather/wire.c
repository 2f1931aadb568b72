#include "weather/wire.h"

#include <string.h>

void pel_weather_wire_head(const struct pel_weather_grid *grid,
                           unsigned char out[PEL_WEATHER_WIRE_HEAD])
{
    uint32_t counts[4] = { (uint32_t)grid->columns, (uint32_t)grid->rows,
                           (uint32_t)grid->times, 0 };
    const double degrees[] = { grid->west_deg, grid->south_deg, grid->east_step,
                               grid->north_step };
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        counts[3] |= grid->values[n] ? 1u << n : 0;
    }
    memcpy(out, PEL_WEATHER_WIRE_MAGIC, 8);
    memcpy(out + 8, counts, sizeof counts);
    memcpy(out + 24, degrees, sizeof degrees);
}

enum pel_err pel_weather_wire_read(const unsigned char *bytes, size_t size,
                                   const struct pel_weather **out,
                                   struct pel_fault *fault)
{
    uint32_t counts[4] = { 0 };
    double degrees[4];
    double times[PEL_WEATHER_MOST_TIMES];
    if (size < PEL_WEATHER_WIRE_HEAD ||
        memcmp(bytes, PEL_WEATHER_WIRE_MAGIC, 8) != 0) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "not a weather field");
    }
    memcpy(counts, bytes + 8, sizeof counts);
    memcpy(degrees, bytes + 24, sizeof degrees);
    size_t nodes = (size_t)counts[0] * counts[1];
    size_t plane = 2 * nodes * counts[2];
    size_t planes = (size_t)__builtin_popcount(counts[3]);
    if (counts[0] > PEL_WEATHER_MOST_COLUMNS ||
        counts[1] > PEL_WEATHER_MOST_ROWS ||
        counts[2] > PEL_WEATHER_MOST_TIMES ||
        counts[3] >= 1u << PEL_WEATHER_NUMBERS ||
        size != PEL_WEATHER_WIRE_HEAD + 8 * counts[2] + plane * planes) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "%u × %u nodes at %u times in %zu bytes",
                             counts[0], counts[1], counts[2], size);
    }
    memcpy(times, bytes + PEL_WEATHER_WIRE_HEAD, (size_t)8 * counts[2]);
    struct pel_weather_grid grid = {
        .columns = (int)counts[0],
        .rows = (int)counts[1],
        .times = (int)counts[2],
        .west_deg = degrees[0],
        .south_deg = degrees[1],
        .east_step = degrees[2],
        .north_step = degrees[3],
        .unix_s = times,
    };
    /* What comes before is a multiple of 8 bytes, and so is `bytes`. */
    const unsigned char *at =
        bytes + PEL_WEATHER_WIRE_HEAD + (size_t)8 * counts[2];
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        if (counts[3] & 1u << n) {
            grid.values[n] = (const int16_t *)(const void *)at;
            at += plane;
        }
    }
    return pel_weather_create(&grid, out, fault);
}
