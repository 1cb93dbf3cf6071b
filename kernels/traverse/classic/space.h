// SPDX-License-Identifier: Apache-2.0
// The structure of this program, if it is one that divides space (cells.h).
#ifndef EK_TRAVERSE_SPACE_H
#define EK_TRAVERSE_SPACE_H
#include "traverse/classic/cells.h"

#if EK_LAYOUT_grid
#include "traverse/classic/grid.h"
#elif EK_LAYOUT_octree
#include "traverse/classic/octree.h"
#elif EK_LAYOUT_kdtree | EK_LAYOUT_bsp
#include "traverse/classic/kdtree.h"
#else
#define USE_CELLS 0
#endif
#ifndef USE_CELLS
#define USE_CELLS 1

EK_FN int traverse_space(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
#if EK_HAS_plane
  if (try_list(geometry, ray, geometry.nodes[13], geometry.nodes[14], any_hit, hit)) return 1;
#endif
  return traverse_cells(geometry, ray, any_hit, hit);
}
#endif

#endif
