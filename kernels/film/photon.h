// SPDX-License-Identifier: Apache-2.0
// The list in which light paths leave photons, as they leave splats (film/splat.h).
#ifndef EK_PHOTON_H
#define EK_PHOTON_H
#include "film/splat.h"
#include "shared/photon.h"

/// Adds the photons of the mask `live`. Those that there is no room for are counted alone.
/// photon  its words
EK_FN void photon_add(SplatList list, vi live, const vu* photon) {
#if EK_WIDTH == 1
  if (!live) return;
  const uint place = atomic_inc(list.counts + SPLATS_stored);
  if (place >= list.capacity) return;
  for (uint word = 0; word < PHOTON_WORDS; ++word) list.words[(size_t)place * PHOTON_WORDS + word] = photon[word];
#else
  uint bits = mask_bits(live);
  if (bits == 0) return;
  uint place = atomic_add(list.counts + SPLATS_stored, popcount(bits));
  uint lanes[PHOTON_WORDS][EK_WIDTH];
  for (uint word = 0; word < PHOTON_WORDS; ++word) *(vu_unaligned*)lanes[word] = photon[word];
  for (; bits != 0 && place < list.capacity; bits &= bits - 1, ++place)
    for (uint word = 0; word < PHOTON_WORDS; ++word)
      list.words[(size_t)place * PHOTON_WORDS + word] = lanes[word][lowest_bit(bits)];
#endif
}

#endif
