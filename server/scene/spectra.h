/* What the sea's spectra depend on, by the names of the schema. Made from
 * ocean/spectra.def; any thread. */
#pragma once

#include <stdbool.h>

#include "pelagos.pb-c.h"

/* Whether the spectrum depends on the state's field (as "sea.fetch"); false
 * for a number that is no spectrum's, and for other fields. */
bool pel_spectrum_reads(Pelagos__SpectrumKind kind, const char *path);
