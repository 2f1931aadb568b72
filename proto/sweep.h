/* Axes of a series as people write them: `sunElevation=0:90:5`,
 * `wavelength=440,550`, several with `;` between. Any thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* Adds them to the query. INVALID: another form; the query then has those
 * before it. Whether there is such an axis is the server's business. */
PEL_CHECK enum pel_err pel_sweep_parse(const char *text,
                                       Pelagos__SeriesQuery *query,
                                       struct pel_fault *fault);
