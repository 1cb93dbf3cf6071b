// SPDX-License-Identifier: Apache-2.0
// What materials say of light paths, for host and kernels.
#ifndef EK_SHARED_LIGHT_TARGET_H
#define EK_SHARED_LIGHT_TARGET_H

// Flag of MaterialRecord: the surface scatters light nearly as a mirror or as clear glass does, so light paths are aimed at it.
#define EK_MATERIAL_ROUGH_TARGET 0x2000u

#endif
