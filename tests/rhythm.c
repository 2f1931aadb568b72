/* Prints what a character of light shows at each frame: the colours' letters,
 * '.' where nothing is lit.
 *
 *   rhythm FRAMES RATE CHARACTER...: one line each, or "refused" */
#include <stdio.h>
#include <stdlib.h>

#include "scene/rhythm.h"

int main(int argc, char **argv)
{
    static const char letters[] = "WRGYB";
    long frames = argc > 3 ? strtol(argv[1], NULL, 10) : 0;
    double rate = argc > 3 ? strtod(argv[2], NULL) : 0;
    if (frames < 1 || !(rate > 0)) {
        return 2;
    }
    for (int i = 3; i < argc; i++) {
        struct pel_rhythm rhythm;
        char why[PEL_RHYTHM_WHY];
        if (pel_rhythm_parse(argv[i], &rhythm, why)) {
            printf("refused: %s\n", why);
            continue;
        }
        for (long k = 0; k < frames; k++) {
            int lit = pel_rhythm_at(&rhythm, (double)k / rate);
            putchar(lit < 0 ? '.' : letters[rhythm.colours[lit]]);
        }
        putchar('\n');
    }
    return 0;
}
