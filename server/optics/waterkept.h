/* Kernels of water (pel_water_kernel_build), of which those used last are kept:
 * each renderer of a scene wants the same one, and one made anew after a loss
 * of the device would pay some 20 ms of a core again. Any thread. */
#pragma once

#include "optics/waterkernel.h"

/* As pel_water_kernel_build, to the bit. NO_MEMORY. */
PEL_CHECK enum pel_err pel_water_kernel_take(
    const struct pel_water_body *body, const struct pel_water_depths *depths,
    enum pel_water_orders orders, struct pel_water_kernel *out);
