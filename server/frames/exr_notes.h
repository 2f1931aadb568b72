/* What an EXR's header says of the sea, the water and the camera, beside what
 * picture_exr.c has: a function of what is drawn. Any thread. */
#pragma once

#include "frames/job.h"

#define PEL_EXR_NOTES 64
#define PEL_EXR_NOTES_TEXT 4096

struct pel_exr_notes {
    struct pel_exr_attribute list[PEL_EXR_NOTES];
    size_t count;
    char text[PEL_EXR_NOTES_TEXT]; /* what strings of the list point into */
    size_t used;
};

/*   pelagos.spectrum            its name in the schema
 *   pelagos.significantHeight   [m] of the whole spectrum, swell and single
 *                               waves too; pelagos.drawnHeight of what is drawn
 *   pelagos.peakPeriod [s], pelagos.waveDirection [deg] from; both absent
 *                               without waves
 *   pelagos.swell, pelagos.singleWaves  a text; absent: none
 *   pelagos.seaLevel, pelagos.waterDepth [m]
 *   pelagos.water               how the water is described
 *   pelagos.chlorophyll [mg/m3], pelagos.cdom, pelagos.detritus [1/m at 440
 *                               nm], pelagos.minerals [g/m3], .salinity [g/kg],
 *                               .waterTemperature [C]: of water by constituents
 *   pelagos.absorption, .scattering, .backscatterRatio, .bottomAlbedo
 *                               texts, at 680, 550, 440 nm
 *   pelagos.wavelengths, pelagos.bandwidths [nm] of R, G, B, texts
 *   pelagos.unit.LAYER          of each layer in the file
 *   pelagos.projection          "rectilinear"
 *   pelagos.horizontalField, pelagos.verticalField [deg] edge to edge
 *   pelagos.tanLeft, .tanRight, .tanTop, .tanBottom  of the edges' angles
 *   pelagos.heading, pelagos.pitch, pelagos.roll [deg] of the line of sight
 *   pelagos.east, pelagos.north [m] of the origin */
void pel_exr_notes_list(const struct pel_output *output,
                        struct pel_exr_notes *out);
