// SPDX-License-Identifier: Apache-2.0
// Lobes as bits of MaterialLanes.lobes, and questions about their traits (shared/lobe_traits.h).
#ifndef EK_LOBE_TRAITS_H
#define EK_LOBE_TRAITS_H
#include "lanes/math.h"
#include "shared/lobe_traits.h"

// The bit of each lobe, and the bit set of all for which this program has code.
enum {
#define EK_LOBE(name, bit, traits) LOBE_##name = bit,
#include "shared/features.def"
  LOBES_OF_PROGRAM = 0
#define EK_LOBE(name, bit, traits) | (EK_HAS_##name << bit)
#include "shared/features.def"
};

/// Bit set of the lobes that have a trait. Compilers make a constant of it.
EK_FN uint lobes_with(uint trait) {
  return 0u
#define EK_LOBE(name, bit, traits) | ((((traits) & trait) != 0u ? 1u : 0u) << bit)
#include "shared/features.def"
      ;
}

/// Tells whether this program has code for some lobe with a trait. Compilers leave out what depends
/// on that in programs without such lobes.
EK_FN int has_lobe_with(uint trait) { return (lobes_with(trait) & (uint)LOBES_OF_PROGRAM) != 0u; }

/// Mask of the lanes whose lobe has a trait. lobes: as MaterialLanes.lobes
EK_FN vi has_trait(vu lobes, uint trait) { return (lobes & lobes_with(trait)) != 0u; }

#endif
