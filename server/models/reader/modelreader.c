/* pelagos-model: reads one mesh and writes it to standard output in the form of
 * models/modelwire.h, its levels of detail made. The daemon starts one for a
 * file and throws it away: what a file makes assimp do, crash or take, it does
 * here.
 *
 *   pelagos-model DIRECTORY FILE BOW UP SCALE LENGTH DRAUGHT
 *
 * BOW and UP are numbers of enum pel_axis; SCALE and LENGTH 0, DRAUGHT -1 where
 * they are not known. Of the directory's files it may read all, since meshes
 * name textures and parts beside them; nothing elsewhere (base/sandbox.h). On
 * failure a sentence on standard error, status 1, or 2 for wrong use. */
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/reader.h"
#include "models/reader/meshfile.h"

#define MOST_MEMORY ((size_t)512 << 20)
#define MOST_CPU_S 6

void pel_mesh_note(struct pel_mesh_notes *notes, const char *format, ...)
{
    size_t used = strlen(notes->text);
    char line[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    if (!strstr(notes->text, line) &&
        used + strlen(line) + 3 < sizeof notes->text) {
        snprintf(notes->text + used, sizeof notes->text - used, "%s%s",
                 used ? "; " : "", line);
    }
}

static bool number(const char *text, double low, double high, double *out)
{
    char *end = NULL;
    errno = 0;
    *out = strtod(text, &end);
    return *text && end && !*end && *out >= low && *out <= high;
}

static bool read_arguments(int argc, char **argv, struct pel_mesh_request *out)
{
    double bow, up;
    if (argc != 8 || !number(argv[3], 0, PEL_AXIS_NONE, &bow) ||
        !number(argv[4], 0, PEL_AXIS_NONE, &up) ||
        !number(argv[5], 0, 1e6, &out->scale) ||
        !number(argv[6], 0, PEL_MODEL_MOST_SIZE_M, &out->length_m) ||
        !number(argv[7], -1, 100, &out->draught_m)) {
        return false;
    }
    out->bow = (enum pel_axis)bow;
    out->up = (enum pel_axis)up;
    return true;
}

int main(int argc, char **argv)
{
    struct pel_mesh_request request = { 0 };
    struct pel_shape shape = { 0 };
    struct pel_model_draft draft;
    struct pel_mesh_notes notes = { "" };
    struct pel_fault fault = { 0 };
    char name[4096];
    if (!read_arguments(argc, argv, &request)) {
        fprintf(stderr, "usage: pelagos-model DIRECTORY FILE BOW UP SCALE "
                        "LENGTH DRAUGHT\n");
        return 2;
    }
    snprintf(name, sizeof name, "./%.4000s", argv[2]);
    request.path = name;
    const char *readable[] = { ".", NULL };
    pel_reader_begin(
        &(struct pel_reader){ argv[1], readable, MOST_CPU_S, MOST_MEMORY });
    if (pel_mesh_read(&request, &shape, &notes, &fault) ||
        pel_shape_finish(&shape, &draft, &fault)) {
        pel_reader_refuse(fault.message);
    }
    pel_reader_end(pel_model_wire_write(stdout, &draft.model, notes.text));
}
