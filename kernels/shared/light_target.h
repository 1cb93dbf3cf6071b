// SPDX-License-Identifier: Apache-2.0
// Rough targets of light paths (lights/light_path.h), for host and kernels.
#ifndef EK_SHARED_LIGHT_TARGET_H
#define EK_SHARED_LIGHT_TARGET_H

// Flag of MaterialRecord: the surface scatters light nearly as a mirror or as clear glass does, so light paths are aimed at it.
#define EK_MATERIAL_ROUGH_TARGET 0x2000u

// This is 1 if the scene has any; programs of scenes without them leave their code out.
#ifndef EK_ROUGH_TARGETS  // where only the text is checked
#define EK_ROUGH_TARGETS 1
#endif

#endif
