// SPDX-License-Identifier: Apache-2.0
// Splats: what light paths bring to pixels. Any light path may reach any pixel, so they have no
// slots of the film, but stand in a list that the host adds to its sums (host/film/splats.cpp).
// They have no fixed order; the host adds integers, so this changes no bit.
#ifndef EK_SPLAT_H
#define EK_SPLAT_H
#include "film/slots.h"
#include "shared/photon.h"
#include "shared/splat.h"

/// A list of records that light paths leave: splats, or photons (shared/photon.h).
typedef struct {
  global uint* words;
  global uint* counts;  // SPLATS_*; there may be more than there is room for
  uint capacity;
} RecordList;

/// Adds a record of so many words for each lane of the mask `live`. Records that there is no room
/// for are counted alone.
/// record  [count]; count: SPLAT_WORDS or PHOTON_WORDS
EK_FN void record_add(RecordList list, vi live, const vu* record, const uint count) {
#if EK_WIDTH == 1
  if (!live) return;
  const uint place = atomic_inc(list.counts + SPLATS_stored);
  if (place >= list.capacity) return;
  for (uint word = 0; word < count; ++word) list.words[(size_t)place * count + word] = record[word];
#else
  uint bits = mask_bits(live);
  if (bits == 0) return;
  uint place = atomic_add(list.counts + SPLATS_stored, popcount(bits));
  uint lanes[PHOTON_WORDS][EK_WIDTH];
  for (uint word = 0; word < count; ++word) *(vu_unaligned*)lanes[word] = record[word];
  for (; bits != 0 && place < list.capacity; bits &= bits - 1, ++place)
    for (uint word = 0; word < count; ++word) list.words[(size_t)place * count + word] = lanes[word][lowest_bit(bits)];
#endif
}

/// Adds the splats of the mask `live`.
EK_FN void splat_add(RecordList list, vi live, vu pixel, vu info, v3 value) {
  vu record[SPLAT_WORDS];
  record[SPLAT_pixel] = pixel;
  record[SPLAT_info] = info;
  record[SPLAT_r] = AS_U(value.x);
  record[SPLAT_g] = AS_U(value.y);
  record[SPLAT_b] = AS_U(value.z);
  record_add(list, live, record, SPLAT_WORDS);
}

#endif
