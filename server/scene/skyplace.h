/* What the snapshot has of the sky. Any thread. */
#pragma once

#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

void pel_sky_place(const Pelagos__Sky *sky, struct pel_snapshot *out);

/* Under a picture: its Sun as strong as it shines there, or none, no Moon. */
void pel_panorama_lights(const struct pel_snapshot *s,
                         struct pel_light lights[PEL_LIGHTS]);
/* Fog, which drifts with the snapshot's wind unless it is told otherwise. */
void pel_fog_place(const Pelagos__State *state, struct pel_snapshot *out);
/* Of the clouds, over a wind that blows to this direction (mathematical). */
void pel_clouds_place(const Pelagos__Sky *sky, double wind_mps,
                      double wind_to_rad, struct pel_clouds *out);
