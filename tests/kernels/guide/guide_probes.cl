// SPDX-License-Identifier: Apache-2.0
// Probes of path guiding, behind the text of probes.cl.
#include "guide/guide.h"
// Inputs: random numbers u and v, a cell. Outputs: u and v after the warp, its density, the
// direction, the density of that.
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

#if EK_HAS_guiding
#include "bsdf/bsdf.h"
// Inputs: cell, the material's lobe as a bit set, its metallic part and alpha, wo, u, v, choice.
// Outputs: f / pdf of a guided sample and its pdf; f and pdf of its direction, guided; f and pdf of
// it, not guided; whether it is of a mirror; its bin.
EK_FN MaterialLanes guided_material(global const uint* cells, vu cell, vu lobes, vf metallic, vf alpha) {
  MaterialLanes m = {0};
  m.lobes = lobes;
  m.base_color = V3((vf)(0.9f), (vf)(0.6f), (vf)(0.3f));
  m.metallic = metallic;
  m.ggx_alpha = alpha;
  m.ggx_alpha_x = m.ggx_alpha;
  m.specular = (vf)(1.0f);
  m.f90 = (vf)(1.0f);
  m.f0_dielectric = V3((vf)(0.04f), (vf)(0.04f), (vf)(0.04f));
  m.f0 = add3(scale3(m.f0_dielectric, 1.0f - m.metallic), scale3(m.base_color, m.metallic));
  m.eta = (vf)(1.5f);
  m.guide.cells = cells;
  m.guide.cell = cell;
  return m;
}

EK_FN_ONCE void probe_guided_bsdf_run(PROBE_ITEMS, global const uint* cells) {
  MaterialLanes m = guided_material(cells, IN_U(0), IN_U(1), IN_F(2), IN_F(3));
  const v3 wo = IN_3(4);
  const BsdfSample s = bsdf_sample(m, wo, IN_F(7), IN_F(8), IN_F(9));
  const BsdfValue guided = bsdf_evaluate(m, wo, s.wi);
  m.guide.cell = (vu)(EK_NO_CELL);
  const BsdfValue plain = bsdf_evaluate(m, wo, s.wi);
  OUT_F(0, max_component(s.weight));
  OUT_F(1, s.pdf);
  OUT_F(2, max_component(guided.f));
  OUT_F(3, guided.pdf);
  OUT_F(4, max_component(plain.f));
  OUT_F(5, plain.pdf);
  OUT_U(6, s.delta ? (vu)(1u) : (vu)(0u));
  OUT_U(7, guide_bin(s.wi));
}
kernel void probe_guided_bsdf(PROBE_ARGUMENTS, global const uint* cells) { probe_guided_bsdf_run(PROBE_PASSED, cells); }

// Inputs: as probe_guided_bsdf, but for wi after wo. Outputs: its pdf, its bin.
EK_FN_ONCE void probe_guided_pdf_run(PROBE_ITEMS, global const uint* cells) {
  const MaterialLanes m = guided_material(cells, IN_U(0), IN_U(1), IN_F(2), IN_F(3));
  const v3 wi = IN_3(7);
  OUT_F(0, bsdf_evaluate(m, IN_3(4), wi).pdf);
  OUT_U(1, guide_bin(wi));
}
kernel void probe_guided_pdf(PROBE_ARGUMENTS, global const uint* cells) { probe_guided_pdf_run(PROBE_PASSED, cells); }
#endif
