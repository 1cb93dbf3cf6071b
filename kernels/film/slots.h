// SPDX-License-Identifier: Apache-2.0
// Film slots: one float per path and channel, in which a path gathers what it brings to its pixel.
//
// "Film" has four forms, and a sample's radiance passes through them in this order:
//   film slots   this file           one float per path and channel of a unit
//   film sums    stages/film.cl      one exact sum per pixel, replicate and channel of a unit
//   fixed point  film/fixed_point.h  the number format of those sums, in 32-bit limbs
//   the film     host/film/film.h    the sums of all units, on the host
#ifndef EK_FILM_SLOTS_H
#define EK_FILM_SLOTS_H
#include "lanes/math.h"
#include "lanes/simd.h"

// Bit i of EK_BOUNCE_BOUNDS ends a bin of layer `bounce_bins` after light that was scattered i
// times; one more bin has the rest.
#ifndef EK_BOUNCE_BOUNDS
#define EK_BOUNCE_BOUNDS 0u
#define EK_BOUNCE_BINS 1
#endif

// Layer `light_group` has EK_LIGHT_GROUPS groups; the environment belongs to EK_ENVIRONMENT_GROUP.
#ifndef EK_LIGHT_GROUPS
#define EK_LIGHT_GROUPS 1
#define EK_ENVIRONMENT_GROUP 0u
#endif

// The planes of the film slots: R, G, B, then the layers that were asked for (features.def), summed
// by stage film.
enum {
  SLOT_r, SLOT_g, SLOT_b,
#define EK_AOV(name, channels) SLOT_##name, SLOT_LAST_##name = SLOT_##name + (channels) * EK_HAS_##name - 1,
#include "shared/features.def"
  SLOT_CHANNELS,
  // The planes from here on hold the bits of integers and are not summed (first_hit.h).
  SLOT_matte_object = SLOT_CHANNELS,
  SLOT_matte_material = SLOT_matte_object + EK_HAS_matte_object,
  SLOT_PLANES = SLOT_matte_material + EK_HAS_matte_material
};

typedef struct {
  global float* slots;  // [plane * stride + path]
  uint stride;          // paths per plane, padded
} FilmSlots;

EK_FN global float* film_plane(FilmSlots film, uint plane) { return film.slots + (size_t)plane * film.stride; }

/// Sets one plane of the paths of the mask `live`.
EK_FN void film_set(FilmSlots film, uint plane, vi live, vu path, vf value) {
#if EK_WIDTH == 1
  if (!live) return;
#endif
  // Lanes without a path write to the padding behind the plane.
  const vu slot = live ? path : (vu)(film.stride - EK_PAD) + LANE_INDEX;
  scatter_f(film_plane(film, plane), slot, value);
}

EK_FN void film_set_3(FilmSlots film, uint plane, vi live, vu path, v3 value) {
  film_set(film, plane, live, path, value.x);
  film_set(film, plane + 1, live, path, value.y);
  film_set(film, plane + 2, live, path, value.z);
}

/// Adds to three planes of the paths of the mask `live`, lane by lane, because no processor has a
/// faster scatter.
EK_FN void film_add_3(FilmSlots film, uint plane, vi live, vu path, v3 value) {
  global float* red = film_plane(film, plane);
  global float* green = red + film.stride;
  global float* blue = green + film.stride;
#if EK_WIDTH == 1
  if (!live) return;
  red[path] += value.x;
  green[path] += value.y;
  blue[path] += value.z;
#else
  uint paths[EK_WIDTH];
  float r[EK_WIDTH], g[EK_WIDTH], b[EK_WIDTH];
  *(vu_unaligned*)paths = path;
  *(vf_unaligned*)r = value.x;
  *(vf_unaligned*)g = value.y;
  *(vf_unaligned*)b = value.z;
  for (uint bits = mask_bits(live); bits != 0; bits &= bits - 1) {
    const uint lane = lowest_bit(bits), at = paths[lane];
    red[at] += r[lane];
    green[at] += g[lane];
    blue[at] += b[lane];
  }
#endif
}

// Paths may meet null interfaces: boundaries between nested media (surface/nested_media.h), and the
// openings of solids (surface/alpha.h), which they pass straight on.
#define EK_USES_NULL_INTERFACES (EK_HAS_nested_media | EK_HAS_open_solid)

/// Light that reaches the camera along a path.
typedef struct {
  vi live;                  // mask of the lanes that have some
  vu path;
  // surface_count less this is the number of surfaces that scattered the light: the null interfaces
  // among them, less the surfaces that a merged photon met before (stages/shade/merge.h). It wraps
  // below 0.
  vu uncounted;
  vu group;                 // light group of its source
  v3 radiance;
} Contribution;

/// Adds a contribution to the layers that show parts of R, G, B.
/// surface_count  surfaces that the light met between its source and the camera
EK_FN void film_add_light_layers(FilmSlots film, uint surface_count, Contribution light) {
  if (EK_HAS_bounce_bins & (EK_USES_NULL_INTERFACES | EK_HAS_merging)) {
    vu bin = (vu)(0u);
    for (uint bits = EK_BOUNCE_BOUNDS; bits != 0u; bits &= bits - 1u) {
      const uint bound = lowest_bit(bits);
      bin = bin + (((vu)(surface_count) - light.uncounted > bound) ? (vu)(1u) : (vu)(0u));
    }
    film_add_3(film, SLOT_bounce_bins, light.live, light.path + bin * (3u * film.stride), light.radiance);
  } else if (EK_HAS_bounce_bins) {
    const uint bin = popcount(EK_BOUNCE_BOUNDS & ((1u << min(surface_count, 31u)) - 1u));
    film_add_3(film, SLOT_bounce_bins + 3 * bin, light.live, light.path, light.radiance);
  }
  if (EK_HAS_light_group)
    film_add_3(film, SLOT_light_group, light.live, light.path + light.group * (3u * film.stride), light.radiance);
}

/// Adds a contribution to R, G, B, and to those layers.
EK_FN void film_add_light(FilmSlots film, uint surface_count, Contribution light) {
  film_add_3(film, SLOT_r, light.live, light.path, light.radiance);
  film_add_light_layers(film, surface_count, light);
}

#endif
