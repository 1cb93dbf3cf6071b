// SPDX-License-Identifier: Apache-2.0
// What a ray caster makes of a material: Blinn's highlight over Lambert's base, and nothing else
// [Appel 1968; Blinn 1977].
#ifndef EK_RAYCAST_H
#define EK_RAYCAST_H
#include "bsdf/bsdf.h"

/// Reflectance of a conductor at normal incidence: |(eta + i k - 1) / (eta + i k + 1)|^2.
EK_FN vf conductor_normal_reflectance(vf eta, vf k) {
  const vf below = eta - 1.0f, above = eta + 1.0f;
  return div_f(below * below + k * k, above * above + k * k);
}

/// The material of a ray caster. EIKON_materials_phong stays as it is. The highlight of any other
/// material has the colour that the surface reflects at normal incidence. Its shininess, from 1 to
/// 2^16, makes it as wide as the lobe of the material's roughness: 2 / alpha^2 - 2 [Walter et al.
/// 2007, section 5.2]. The base is the base colour times 1 - metallic. Nothing is transmitted, so
/// glass looks like plastic.
EK_FN MaterialLanes raycast_material(MaterialLanes m) {
  const vu phong = (vu)(1u << LOBE_phong);
  const vi own = m.lobes == phong, lambert = m.lobes == (1u << LOBE_diffuse), metal = m.lobes == (1u << LOBE_conductor);
  const vf zero = (vf)(0.0f);
  const v3 conductor = V3(conductor_normal_reflectance(m.own.conductor_eta.x, m.own.conductor_k.x),
                          conductor_normal_reflectance(m.own.conductor_eta.y, m.own.conductor_k.y),
                          conductor_normal_reflectance(m.own.conductor_eta.z, m.own.conductor_k.z));
  const v3 highlight = select3(lambert, V3(zero, zero, zero), select3(metal, conductor, m.f0));
  const vf alpha2 = max_f(m.ggx_alpha * m.ggx_alpha, (vf)(0x1p-20f));
  const vf shininess = min_f(max_f(div_f(2.0f, alpha2) - 2.0f, (vf)(1.0f)), (vf)(0x1p16f));
  m.own.phong_specular = select3(own, m.own.phong_specular, highlight);
  m.own.phong_shininess = own ? m.own.phong_shininess : shininess;
  m.base_color = scale3(m.base_color, own | lambert ? (vf)(1.0f) : metal ? zero : 1.0f - m.metallic);
  m.lobes = phong;
  m.clearcoat = m.sheen_roughness = zero;
  m.sheen = V3(zero, zero, zero);
  return m;
}

#endif
