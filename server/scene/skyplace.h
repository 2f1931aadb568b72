/* What the snapshot has of the sky. Any thread. */
#pragma once

#include "pelagos.pb-c.h"
#include "scene/snapshot.h"

void pel_sky_place(const Pelagos__Sky *sky, struct pel_snapshot *out);
