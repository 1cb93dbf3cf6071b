// SPDX-License-Identifier: Apache-2.0
// Stage `film`.   From: the film slots of all paths of the unit.
//                 To: film sums, exact per pixel, replicate and channel.
// A lane owns a pixel and adds its samples as fixed-point numbers, so neither order nor the size of
// units matters. A sample with a value that is not finite or beyond the range is left out as a
// whole, counted and reported.
//   film_sums      [((replicate * channels + channel) * limbs + limb) * pixel_stride + pixel]
//   film_rejected  [replicate * pixel_stride + pixel]
#include "film/fixed_point.h"
#include "lanes/simd.h"
#include "stages/wavefront.h"

/// Counts samples that were left out and notes the first of them. This is rare, so it goes lane by
/// lane.
EK_FN void film_report(global Diagnostics* diagnostics, vi nonfinite, vi saturated, uint pixel, uint sample) {
#if EK_WIDTH == 1
  const int bad[1] = {nonfinite}, big[1] = {saturated};
#else
  int bad[EK_WIDTH], big[EK_WIDTH];
  *(vi*)bad = nonfinite;
  *(vi*)big = saturated;
#endif
  for (uint lane = 0; lane < EK_WIDTH; ++lane) {
    if (!bad[lane] && !big[lane]) continue;
    atomic_inc(bad[lane] ? &diagnostics->nonfinite : &diagnostics->saturated);
    const uint place = atomic_inc(&diagnostics->reported);
    if (place < EK_REPORT_COUNT) {
      diagnostics->report[2 * place] = pixel + lane;
      diagnostics->report[2 * place + 1] = sample;
    }
  }
}

/// Fetches the same sample of the next pixels: a pixel's samples lie too far apart for the
/// processor to fetch ahead by itself.
EK_FN void film_fetch_ahead(global const float* slots, uint film_stride) {
#if EK_CHUNKED && EK_CPU
  for (uint c = 0; c < SLOT_CHANNELS; ++c) EK_PREFETCH(slots + (size_t)c * film_stride + EK_WIDTH);
#endif
}

/// The sums of a unit, for the host.
typedef struct {
  global uint* sums;
  global uint* rejected;
  global Diagnostics* diagnostics;
} FilmSums;

/// Sums the pixels [first, end).
EK_FN_ONCE void film_run(constant Frame* frame, global const float* film_slots, FilmSums out, uint first, uint end) {
  const uint pixel_count = frame->pixel_count, stride = frame->pixel_stride;
  const uint replicates = 1u << frame->replicate_bits;
  for (uint pixel = first; pixel < end; pixel += EK_WIDTH) {
    const vi inside = (vu)(pixel) + LANE_INDEX < (vu)(pixel_count);
    for (uint replicate = 0; replicate < replicates; ++replicate) {
      Fixed sums[SLOT_CHANNELS];
      for (uint c = 0; c < SLOT_CHANNELS; ++c)
        for (uint i = 0; i < EK_FILM_LIMBS; ++i) sums[c].limb[i] = (vu)(0u);
      vu rejected = (vu)(0u);
      for (uint s = (replicate - frame->sample_begin) & (replicates - 1u); s < frame->sample_count; s += replicates) {
        global const float* slots = film_slots + (size_t)s * pixel_count + pixel;
        film_fetch_ahead(slots, frame->film_stride);
        vi finite = ALL_LANES, in_range = ALL_LANES;
        for (uint c = 0; c < SLOT_CHANNELS; ++c) {
          const vf x = load_f(slots + (size_t)c * frame->film_stride);
          finite = finite & is_finite(x);
          in_range = in_range & fixed_in_range(x);
        }
        const vi bad = inside & !in_range;
        if (ANY(bad)) {
          film_report(out.diagnostics, inside & !finite, bad & finite, pixel, s);
          rejected = bad ? rejected + 1u : rejected;
        }
        for (uint c = 0; c < SLOT_CHANNELS; ++c) {
          const vf x = load_f(slots + (size_t)c * frame->film_stride);
          sums[c] = fixed_add(sums[c], fixed_from_float(bad ? (vf)(0.0f) : x));
        }
      }
      for (uint c = 0; c < SLOT_CHANNELS; ++c)
        for (uint i = 0; i < EK_FILM_LIMBS; ++i)
          store_u(out.sums + ((size_t)(replicate * SLOT_CHANNELS + c) * EK_FILM_LIMBS + i) * stride + pixel,
                  sums[c].limb[i]);
      store_u(out.rejected + (size_t)replicate * stride + pixel, rejected);
    }
  }
}

kernel void film(constant Frame* frame, global const float* film_slots, global uint* film_sums,
                 global uint* film_rejected, global Diagnostics* diagnostics) {
  const uint pixels = EK_CHUNKED ? EK_FILM_PIXELS : 1;  // of one work-item
  const uint first = (uint)get_global_id(0) * pixels;
  const FilmSums out = {film_sums, film_rejected, diagnostics};
  film_run(frame, film_slots, out, first, min(first + pixels, frame->pixel_count));
}
