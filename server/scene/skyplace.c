#include "scene/skyplace.h"

void pel_sky_place(const Pelagos__Sky *sky, struct pel_snapshot *out)
{
    out->sun_azimuth_fixed = sky->has_sun_azimuth;
    out->sun_elevation_fixed = sky->has_sun_elevation;
    out->sun_azimuth_rad = sky->sun_azimuth * PEL_DEG;
    out->sun_elevation_rad = sky->sun_elevation * PEL_DEG;
    out->moon_azimuth_fixed = sky->has_moon_azimuth;
    out->moon_elevation_fixed = sky->has_moon_elevation;
    out->moon_phase_fixed = sky->has_moon_phase;
    out->moon_azimuth_rad = sky->moon_azimuth * PEL_DEG;
    out->moon_elevation_rad = sky->moon_elevation * PEL_DEG;
    out->moon_lit = sky->moon_phase;
    out->stars = sky->stars;
    out->visibility_m = sky->visibility;
}
