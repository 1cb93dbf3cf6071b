// SPDX-License-Identifier: Apache-2.0
// Targets of light paths (lights/light_path.h), for host and kernels.
#ifndef EK_SHARED_LIGHT_TARGET_H
#define EK_SHARED_LIGHT_TARGET_H
#include "shared/guide.h"

// Flags of MaterialRecord. Light paths are aimed at surfaces of delta scattering, which are
// specular targets, and at those that come close to it, which are glossy targets.
#define EK_MATERIAL_GLOSSY_TARGET 0x2000u
#define EK_MATERIAL_LIGHT_TARGET 0x4000u  // both kinds

// This is 1 if the scene has any; programs of scenes without them leave their code out.
#ifndef EK_GLOSSY_TARGETS  // where only the text is checked
#define EK_GLOSSY_TARGETS 1
#endif

#define EK_LIGHT_TARGETS_MOST 64  // balls

// Light paths start in two ways: from a point, within the cone of a target, and as parallel light,
// on the disc of one.
#define EK_AIM_CONE 0u
#define EK_AIM_DISC 1u
// Buffer light_aim, of cells as path guiding has them (shared/guide.h): the first has AIM_flags
// alone, and then each target has one for its cone and one for its disc, whose bins are those of
// the start's coordinates in the unit square.
#define EK_AIM_CELL(target, kind) ((target)*2u + (kind) + 1u)
EK_BEGIN
enum {
  AIM_flags = 0,  // of the first cell
  // Float, of the others: the probability of the target over the one that it has by its size
  // alone.
  AIM_weight = GUIDE_indirect
};
EK_END
#define EK_AIM_LEARNED 1u       // a trial has filled the cells; without this flag the buffer has the flags alone
#define EK_AIM_NAMES_STARTS 2u  // splats name the starts of their light paths (EK_SPLAT_START)

// Name of a start: a target, a way to start, and a bin.
#define EK_AIM_START(target, kind, bin) (((target)*2u + (kind)) * EK_GUIDE_BINS + (bin))
#define EK_AIM_STARTS (EK_LIGHT_TARGETS_MOST * 2 * EK_GUIDE_BINS)

#endif
