// SPDX-License-Identifier: Apache-2.0
// Layout `none`: every triangle is tested. nodes[0] is their number, and leaves their indices.
// Tests compare the trees with this.
#ifndef EK_TRAVERSE_NONE_H
#define EK_TRAVERSE_NONE_H
#include "traverse/hit.h"

EK_FN int traverse_none(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  const uint count = geometry.nodes[0];
  for (uint i = 0; i < count; ++i) {
    if (try_triangle(geometry, ray, geometry.leaves[i], any_hit, hit)) return 1;
  }
  return 0;
}

#endif
