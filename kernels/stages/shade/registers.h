// SPDX-License-Identifier: Apache-2.0
// Keeps a GPU's registers free in stage `shade`. Sampling the BSDF and sampling lights both compute
// the same values of a material and the viewer's direction. A compiler finds that out and keeps
// them, 30 and more, from the one to the other, but computing them again is cheaper than the
// work-items that then do not fit.
#ifndef EK_SHADE_REGISTERS_H
#define EK_SHADE_REGISTERS_H
#include "stages/shade/direct_light.h"

#if !EK_CHUNKED
EK_FN void forget_f(vf* x, uint nothing) { *x = AS_F(AS_U(*x) ^ nothing); }
EK_FN void forget_3(v3* a, uint nothing) {
  forget_f(&a->x, nothing);
  forget_f(&a->y, nothing);
  forget_f(&a->z, nothing);
}

/// Changes no value, but hides from the compiler that they are those from before.
/// nothing  0, without the compiler knowing
EK_FN void forget_point(ShadingPoint* point, uint nothing) {
  MaterialLanes* m = &point->material;
  forget_3(&point->wo, nothing);
  forget_3(&m->base_color, nothing);
  forget_f(&m->metallic, nothing);
  forget_f(&m->ggx_alpha, nothing);
  forget_f(&m->ggx_alpha_x, nothing);
  forget_3(&m->f0_dielectric, nothing);
  forget_f(&m->specular, nothing);
  forget_3(&m->f0, nothing);
  forget_f(&m->f90, nothing);
  forget_f(&m->transmission, nothing);
  forget_f(&m->eta, nothing);
  forget_f(&m->clearcoat, nothing);
  forget_f(&m->clearcoat_alpha, nothing);
#if EK_HAS_clearcoat_normal
  forget_3(&m->clearcoat_normal, nothing);
#endif
  forget_3(&m->sheen, nothing);
  forget_f(&m->sheen_roughness, nothing);
}

/// As direct_light_add, once the next path is stored. point: as it was then
EK_FN uint direct_light_last(const ShadeContext* c, DirectLight* direct, ShadingPoint point, uint slot) {
  // Lambert's lobe computes nothing that both need. No path is so deep that depth >> 31 is not 0,
  // but a compiler does not know that.
  if ((EK_HAS_opaque_hits | EK_HAS_transmissive_hits) && !shades_only(c->scene, SHADING_FLAT_LAMBERT)) forget_point(&point, c->depth >> 31);
  return direct_light_add(c, direct, &point, slot);
}
#endif

#endif
