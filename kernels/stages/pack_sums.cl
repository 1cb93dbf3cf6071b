// SPDX-License-Identifier: Apache-2.0
// Stage `pack_sums`, on GPU devices.
// From: film sums.   To: the same sums, packed for their way to the host (shared/packed_sums.h).
// A work-item owns a pixel.
#include "film/packed_sums.h"
#include "stages/wavefront.h"

kernel void pack_sums(constant Frame* frame, global const uint* film_sums, global uint* film_packed) {
#if !EK_CHUNKED
  const uint pixel = (uint)get_global_id(0), stride = frame->pixel_stride;
  if (pixel >= frame->pixel_count) return;
  const uint sums = SLOT_CHANNELS << frame->replicate_bits;
  global uint* planes = film_packed + EK_PACKED_HEAD + pixel;
  uint shifts = 0u, wide = 0u;
  for (uint k = 0; k < sums; ++k) {
    Fixed sum;
    for (uint i = 0; i < EK_FILM_LIMBS; ++i) sum.limb[i] = film_sums[((size_t)k * EK_FILM_LIMBS + i) * stride + pixel];
    const PackedSum packed = pack_sum(sum);
    planes[(size_t)(2u * k) * stride] = packed.low;
    planes[(size_t)(2u * k + 1u) * stride] = packed.high;
    wide += packed.is_wide;
    shifts |= packed.shift << 8u * (k & 3u);
    if ((k & 3u) != 3u && k + 1u != sums) continue;
    planes[(size_t)(2u * sums + (k >> 2)) * stride] = shifts;
    shifts = 0u;
  }
  if (wide != 0u) atomic_add(film_packed, wide);
#endif
}
