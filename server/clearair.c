/* clearair FILE: writes pel_clear_air (optics/clearair.h) while the server is
 * built. */
#include <stdio.h>
#include <stdlib.h>

#include "optics/clearair.h"
#include "pelagos.pb-c.h"

int main(int argc, char **argv)
{
    const Pelagos__Sky sky = PELAGOS__SKY__INIT;
    const struct pel_atmosphere_desc desc = { sky.visibility };
    struct pel_atmosphere air;
    struct pel_clear_air *out = calloc(1, sizeof *out);
    pel_atmosphere_init(&desc, &air);
    if (argc != 2 || !out || pel_atmosphere_tabulate(&air, NULL, NULL)) {
        fputs("clearair: no table\n", stderr);
        return 1;
    }
    out->visibility_m = sky.visibility;
    out->light = *air.airlight;
    FILE *file = fopen(argv[1], "wb");
    if (!file || fwrite(out, sizeof *out, 1, file) != 1 || fclose(file)) {
        perror(argv[1]);
        return 1;
    }
    pel_atmosphere_finish(&air);
    free(out);
    return 0;
}
