/* The spectrum of the light of the sky by the Sun's elevation: what is between
 * and beyond the three wavelengths that everything else is computed at, for
 * colours alone (optics/colour.h). Ozone's Chappuis band, deepest at 600 nm, is
 * missed by 680 and 550 nm; through twilight's long paths it is what makes a
 * dusk sky blue above its orange. Any thread. */
#pragma once

/* The middle of each 10 nm from 360 to 840. */
#define PEL_DAYLIGHT_FIRST_NM 365.0
#define PEL_DAYLIGHT_STEP_NM 10.0
#define PEL_DAYLIGHT_COUNT 48

struct pel_daylight {
    double at[PEL_DAYLIGHT_COUNT];
    double sample[3]; /* at 680, 550, 440 nm */
};

/* Light through every direction of the upper half and of the Sun's beam, of any
 * unit: the Sun above the air times what one scattering in air of 40 km of
 * visibility with ozone sends down. sun_sine: of the Sun's elevation; below
 * -9 deg it stays that of -9. Some 5 ms. */
void pel_daylight(double sun_sine, struct pel_daylight *out);

/* The Sun above the air in the same steps, W m^-2 nm^-1. */
extern const double pel_sun_spectrum[PEL_DAYLIGHT_COUNT];
