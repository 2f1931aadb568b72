/* tables NAME FILE: writes a table of the program, as it is in memory, while
 * the server is built: clear_air (optics/clearair.h), foam_grain
 * (ocean/foam.h), colour_suns (optics/coloursuns.h). */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ocean/foam.h"
#include "optics/clearair.h"
#include "optics/coloursuns.h"
#include "pelagos.pb-c.h"

static bool write_table(const char *name, const void *table, size_t size)
{
    FILE *file = fopen(name, "wb");
    if (!file || fwrite(table, size, 1, file) != 1 || fclose(file)) {
        perror(name);
        return false;
    }
    return true;
}

static bool clear_air(const char *name)
{
    const Pelagos__Sky sky = PELAGOS__SKY__INIT;
    const struct pel_atmosphere_desc desc = { sky.visibility };
    struct pel_atmosphere air;
    struct pel_clear_air *out = calloc(1, sizeof *out);
    pel_atmosphere_init(&desc, &air);
    bool whole = out && !pel_atmosphere_tabulate(&air, NULL, NULL);
    if (whole) {
        out->visibility_m = sky.visibility;
        out->light = *air.airlight;
        whole = write_table(name, out, sizeof *out);
        pel_atmosphere_finish(&air);
    }
    free(out);
    return whole;
}

static bool foam_grain(const char *name)
{
    static float grain[PEL_FOAM_GRAIN * PEL_FOAM_GRAIN];
    return pel_foam_grain_make(grain) && write_table(name, grain, sizeof grain);
}

static bool colour_suns(const char *name)
{
    struct pel_colour_suns suns;
    pel_colour_suns_make(&suns);
    return write_table(name, &suns, sizeof suns);
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        bool (*write)(const char *file);
    } tables[] = { { "clear_air", clear_air },
                   { "foam_grain", foam_grain },
                   { "colour_suns", colour_suns } };
    bool whole = false;
    for (size_t i = 0; argc == 3 && i < sizeof tables / sizeof tables[0]; i++) {
        if (strcmp(argv[1], tables[i].name) == 0) {
            whole = tables[i].write(argv[2]);
        }
    }
    if (!whole) {
        fputs("tables: no table\n", stderr);
    }
    return !whole;
}
