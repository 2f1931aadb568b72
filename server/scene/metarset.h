/* What a METAR does to a state. Any thread. */
#pragma once

#include "base/err.h"
#include "pelagos.pb-c.h"

/* Where the state has sky.metar, sets what that says and takes it out, so that
 * the log and the file of the state have the fields:
 *
 * - sea.windSpeed, at most 30 m/s, and unless it is variable or calm
 *   sea.windDirection; gusts are not.
 * - sky.visibility, 20 km where it is "10 km or more"; sky.fog is emptied. In
 * FG the visibility is that of a layer, 120 m high or as high as VV says, and
 * the air has 10 km; MIFG is a layer of 3 m; BCFG, PRFG and VCFG are three
 * banks about the origin.
 * - sky.rain and snow by what falls and how; the visibility is then of the air
 * without them, so that with them it is the reported one
 * (pel_visibility_besides).
 * - cloudCover 2, 4, 6, 8 for FEW, SCT, BKN, OVC or 0, cloudBase and, by base,
 *   cover, CB, TCU and rain, cloudGenus; of several layers the one that covers
 *   most, of equals the lowest. VV is overcast from there on, but for fog.
 *
 * What a report does not say stays. INVALID: pel_metar_parse. */
PEL_CHECK enum pel_err pel_metar_settle(Pelagos__State *state,
                                        struct pel_fault *fault);
