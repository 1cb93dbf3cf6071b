// SPDX-License-Identifier: Apache-2.0
// Keeps a GPU's registers free in stage `shade`. Sampling the BSDF and sampling lights both compute
// the same values of a material and the viewer's direction. A compiler finds that out and keeps
// them, 30 and more, from the one to the other, but computing them again is cheaper than the
// work-items that then do not fit.
#ifndef EK_SHADE_REGISTERS_H
#define EK_SHADE_REGISTERS_H
#include "stages/shade/direct_light.h"

#if !EK_CHUNKED
EK_FN void hide_f(vf* x, uint opaque_zero) { *x = AS_F(AS_U(*x) ^ opaque_zero); }
EK_FN void hide_3(v3* a, uint opaque_zero) {
  hide_f(&a->x, opaque_zero);
  hide_f(&a->y, opaque_zero);
  hide_f(&a->z, opaque_zero);
}

/// Changes no value, but hides from the compiler that they are those from before.
/// opaque_zero  0, which the compiler does not know
EK_FN void hide_point(ShadingPoint* point, uint opaque_zero) {
  MaterialLanes* m = &point->material;
  hide_3(&point->wo, opaque_zero);
  hide_3(&m->base_color, opaque_zero);
  hide_f(&m->metallic, opaque_zero);
  hide_f(&m->ggx_alpha, opaque_zero);
  hide_f(&m->ggx_alpha_x, opaque_zero);
  hide_3(&m->f0_dielectric, opaque_zero);
  hide_f(&m->specular, opaque_zero);
  hide_3(&m->f0, opaque_zero);
  hide_f(&m->f90, opaque_zero);
  hide_f(&m->transmission, opaque_zero);
  hide_f(&m->eta, opaque_zero);
  hide_f(&m->clearcoat, opaque_zero);
  hide_f(&m->clearcoat_alpha, opaque_zero);
#if EK_HAS_clearcoat_normal
  hide_3(&m->clearcoat_normal, opaque_zero);
#endif
  hide_3(&m->sheen, opaque_zero);
  hide_f(&m->sheen_roughness, opaque_zero);
}

/// As direct_light_add, once the next path is stored. point: as it was then
EK_FN uint direct_light_last(const ShadeContext* c, DirectLight* direct, ShadingPoint point, uint slot) {
  // Lambert's lobe computes nothing that both need. No path is so deep that depth >> 31 is not
  // 0, but a compiler does not know that.
  if ((EK_HAS_opaque_hits | EK_HAS_transmissive_hits) && !shades_only(c->scene, SHADING_FLAT_LAMBERT)) hide_point(&point, c->depth >> 31);
  return direct_light_add(c, direct, &point, slot);
}
#endif

#endif
