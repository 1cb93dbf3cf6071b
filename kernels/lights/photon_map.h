// SPDX-License-Identifier: Apache-2.0
// The photons of the generation that the unit's samples belong to, one map for each replicate, in a
// hash table of cubic cells. A photon stands in all cells that are within the radius of it, so
// whoever looks for photons around a point finds them in the point's own cell. The host builds the
// table (host/wavefront/photons/photon_map.cpp), with the photons of a cell in an order that
// depends on no device.
#ifndef EK_PHOTON_MAP_H
#define EK_PHOTON_MAP_H
#include "guide/cell.h"
#include "shared/photon.h"

#if EK_HAS_merging
typedef struct {
  global const uint* buckets;  // first place of each bucket, and behind them the number of places
  global const uint* places;   // index of the photon
  global const uint* photons;  // PHOTON_WORDS each
} PhotonMap;

#define EK_PHOTON_ARGUMENTS \
  , global const uint *photon_buckets, global const uint *photon_places, global const uint *photons
#define EK_PHOTON_DATA , {photon_buckets, photon_places, photons}

/// The bucket in which the photons of a replicate around a point stand. Other photons may stand
/// there, too.
EK_FN vu photon_bucket(constant Frame* frame, v3 p, vu replicate) {
  const float scale = frame->photon_cell_scale;
  const CellKey cell = {cell_coordinate(p.x * scale) | (cell_coordinate(p.y * scale) << 16),
                        cell_coordinate(p.z * scale) | (replicate << 16)};
  return cell_hash(cell.xy, cell.zn) & frame->photon_bucket_mask;
}

EK_FN v3 photon_v3(global const uint* photons, vu first_word) {
  return V3(AS_F(gather_u(photons, first_word)), AS_F(gather_u(photons, first_word + 1u)),
            AS_F(gather_u(photons, first_word + 2u)));
}
#else
#define EK_PHOTON_ARGUMENTS
#define EK_PHOTON_DATA
#endif

#endif
