// SPDX-License-Identifier: Apache-2.0
// Probes of path guiding, behind the text of probes.cl.
#include "guide/guide.h"
// Inputs: random numbers u and v, a cell. Outputs: u and v after the warp, its density, the direction, the density of that.
EK_FN_ONCE void probe_guide_run(PROBE_ITEMS, global const uint* cells) {
  const GuideCell guide = {cells, IN_U(2)};
  vf u = IN_F(0), v = IN_F(1);
  const vf density = guide_warp(guide, &u, &v);
  const v3 wi = warp_cosine_hemisphere(u, v);
  OUT_F(0, u);
  OUT_F(1, v);
  OUT_F(2, density);
  OUT_3(3, wi);
  OUT_F(6, guide_density(guide, wi));
  OUT_U(7, guide_bin(wi));
}
kernel void probe_guide(PROBE_ARGUMENTS, global const uint* cells) { probe_guide_run(PROBE_PASSED, cells); }

// Inputs: a point, a normal. Outputs: the key of its cell, and the cell that the table has for it.
EK_FN_ONCE void probe_cells_run(PROBE_ITEMS, constant Frame* frame, global const uint* slots) {
  const CellKey key = cell_key(frame, IN_3(0), IN_3(3));
  OUT_U(0, key.xy);
  OUT_U(1, key.zn);
  OUT_U(2, cell_find(frame, slots, key, ALL_LANES));
}
kernel void probe_cells(PROBE_ARGUMENTS, constant Frame* frame, global const uint* slots) {
  probe_cells_run(PROBE_PASSED, frame, slots);
}
