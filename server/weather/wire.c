#include "weather/wire.h"

#include <string.h>

#define HEAD 16
#define GRID_HEAD 48

static size_t padded(size_t bytes)
{
    return (bytes + 7) / 8 * 8;
}

static bool put(FILE *to, const void *bytes, size_t size)
{
    static const char zeros[8] = { 0 };
    size_t more = padded(size) - size;
    return (size == 0 || fwrite(bytes, size, 1, to) == 1) &&
           (more == 0 || fwrite(zeros, more, 1, to) == 1);
}

static bool write_grid(const struct pel_weather_grid *g, FILE *to)
{
    size_t times = (size_t)g->times;
    size_t count = (size_t)g->columns * (size_t)g->rows * times;
    uint32_t counts[4] = { (uint32_t)g->columns, (uint32_t)g->rows,
                           (uint32_t)g->times, 0 };
    const double degrees[] = { g->west_deg, g->south_deg, g->east_step,
                               g->north_step };
    size_t planes = 0;
    for (int n = 0; n < PEL_WEATHER_NUMBERS; n++) {
        counts[3] |= g->values[n] ? 1u << n : 0;
        planes += g->values[n] != NULL;
    }
    bool whole = put(to, counts, sizeof counts) &&
                 put(to, degrees, sizeof degrees) &&
                 put(to, g->unix_s, 8 * times);
    for (int n = 0; whole && n < PEL_WEATHER_NUMBERS; n++) {
        const int16_t *v = g->values[n];
        whole = !v || fwrite(v, sizeof *v, count, to) == count;
    }
    static const char zeros[8] = { 0 };
    size_t bytes = 2 * count * planes, more = padded(bytes) - bytes;
    return whole && fwrite(zeros, 1, more, to) == more;
}

bool pel_weather_wire_write(const struct pel_weather_grid *grid, FILE *to)
{
    const char *notes = grid->notes ? grid->notes : "";
    const uint32_t counts[] = { grid->waves ? 2 : 1, (uint32_t)strlen(notes) };
    return fwrite(PEL_WEATHER_WIRE_MAGIC, 8, 1, to) == 1 &&
           put(to, counts, sizeof counts) && put(to, notes, counts[1]) &&
           write_grid(grid, to) &&
           (!grid->waves || write_grid(grid->waves, to));
}

/* The rest of the bytes; each part is a multiple of 8 bytes, and so is
 * where they begin. */
struct rest {
    const unsigned char *at;
    size_t left;
};

static const void *take(struct rest *rest, size_t size)
{
    const unsigned char *at = rest->at;
    if (rest->left < padded(size)) {
        return NULL;
    }
    rest->at += padded(size);
    rest->left -= padded(size);
    return at;
}

static bool read_grid(struct rest *rest, struct pel_weather_grid *out)
{
    uint32_t counts[4];
    double degrees[4];
    const void *head = take(rest, GRID_HEAD);
    if (!head) {
        return false;
    }
    memcpy(counts, head, sizeof counts);
    memcpy(degrees, (const char *)head + sizeof counts, sizeof degrees);
    if (counts[0] > PEL_WEATHER_MOST_COLUMNS ||
        counts[1] > PEL_WEATHER_MOST_ROWS ||
        counts[2] > PEL_WEATHER_MOST_TIMES ||
        counts[3] >= 1u << PEL_WEATHER_NUMBERS) {
        return false;
    }
    size_t plane = (size_t)counts[0] * counts[1] * counts[2];
    size_t planes = (size_t)__builtin_popcount(counts[3]);
    const double *times = take(rest, (size_t)8 * counts[2]);
    const int16_t *values = times ? take(rest, 2 * plane * planes) : NULL;
    *out = (struct pel_weather_grid){
        .columns = (int)counts[0],
        .rows = (int)counts[1],
        .times = (int)counts[2],
        .west_deg = degrees[0],
        .south_deg = degrees[1],
        .east_step = degrees[2],
        .north_step = degrees[3],
        .unix_s = times,
    };
    for (int n = 0; values && n < PEL_WEATHER_NUMBERS; n++) {
        if (counts[3] & 1u << n) {
            out->values[n] = values;
            values += plane;
        }
    }
    return values != NULL;
}

enum pel_err pel_weather_wire_read(const unsigned char *bytes, size_t size,
                                   const struct pel_weather **out,
                                   struct pel_fault *fault)
{
    struct rest rest = { bytes, size };
    struct pel_weather_grid grid, waves;
    uint32_t counts[2] = { 0 };
    char notes[PEL_WEATHER_MOST_NOTES] = "";
    const unsigned char *head = take(&rest, HEAD);
    if (!head || memcmp(head, PEL_WEATHER_WIRE_MAGIC, 8) != 0) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED, "not a weather field");
    }
    memcpy(counts, head + 8, sizeof counts);
    const char *text = counts[1] < sizeof notes ? take(&rest, counts[1]) : NULL;
    bool whole = text && counts[0] >= 1 && counts[0] <= 2 &&
                 read_grid(&rest, &grid) &&
                 (counts[0] == 1 || read_grid(&rest, &waves)) && rest.left == 0;
    if (!whole) {
        return pel_fault_set(fault, PEL_ERR_MALFORMED,
                             "%u grids in %zu bytes that are not as they say",
                             counts[0], size);
    }
    memcpy(notes, text, counts[1]);
    grid.notes = notes;
    grid.waves = counts[0] == 2 ? &waves : NULL;
    return pel_weather_create(&grid, out, fault);
}
