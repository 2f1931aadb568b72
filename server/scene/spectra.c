#include "scene/spectra.h"

#include <string.h>

#include "ocean/spectrum.h"

bool pel_spectrum_reads(Pelagos__SpectrumKind kind, const char *path)
{
    static const struct {
        const char *path;
        enum pel_spectrum_uses use;
    } fields[] = {
#define PEL_SPECTRUM_NUMBER(ID, member, field, path, ...)                      \
    { path, PEL_USES_##ID },
#include "ocean/spectra.def"
        { "sea.measured", PEL_USES_RECORD },
        { "sea.measuredTime", PEL_USES_RECORD },
    };
    bool known = (int)kind >= 0 && (int)kind < PEL_SPECTRA;
    for (size_t i = 0; known && i < sizeof fields / sizeof *fields; i++) {
        if (strcmp(fields[i].path, path) == 0) {
            return pel_spectrum_uses((enum pel_spectrum_kind)kind,
                                     fields[i].use);
        }
    }
    return false;
}
