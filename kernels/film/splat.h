// SPDX-License-Identifier: Apache-2.0
// Splats: what light paths bring to pixels. Any light path may reach any pixel, so they have no slots of the film, but
// stand in a list that the host adds to its sums (host/film/splats.cpp). Their order is that of chance, and integers make
// it irrelevant.
#ifndef EK_SPLAT_H
#define EK_SPLAT_H
#include "film/slots.h"
#include "shared/splat.h"

typedef struct {
  global uint* words;
  global uint* counts;  // SPLATS_*; of splats there may be more than there is room for
  uint capacity;
} SplatList;

/// Adds the splats of the mask `live`. Those that there is no room for are counted alone.
EK_FN void splat_add(SplatList list, vi live, vu pixel, vu info, v3 value) {
#if EK_WIDTH == 1
  if (!live) return;
  const uint place = atomic_inc(list.counts + SPLATS_stored);
  if (place >= list.capacity) return;
  global uint* words = list.words + (size_t)place * SPLAT_WORDS;
  words[SPLAT_pixel] = pixel;
  words[SPLAT_info] = info;
  words[SPLAT_r] = AS_U(value.x);
  words[SPLAT_g] = AS_U(value.y);
  words[SPLAT_b] = AS_U(value.z);
#else
  uint bits = mask_bits(live);
  if (bits == 0) return;
  uint place = atomic_add(list.counts + SPLATS_stored, popcount(bits));
  uint lanes[SPLAT_WORDS][EK_WIDTH];
  *(vu_unaligned*)lanes[SPLAT_pixel] = pixel;
  *(vu_unaligned*)lanes[SPLAT_info] = info;
  *(vu_unaligned*)lanes[SPLAT_r] = AS_U(value.x);
  *(vu_unaligned*)lanes[SPLAT_g] = AS_U(value.y);
  *(vu_unaligned*)lanes[SPLAT_b] = AS_U(value.z);
  for (; bits != 0 && place < list.capacity; bits &= bits - 1, ++place)
    for (uint word = 0; word < SPLAT_WORDS; ++word)
      list.words[(size_t)place * SPLAT_WORDS + word] = lanes[word][lowest_bit(bits)];
#endif
}

#endif
