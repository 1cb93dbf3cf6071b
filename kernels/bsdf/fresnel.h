// SPDX-License-Identifier: Apache-2.0
// Reflectance and refraction at a smooth interface.
#ifndef EK_FRESNEL_H
#define EK_FRESNEL_H
#include "lanes/math.h"

// Outside of [1 / limit, limit] an index of refraction stands for a perfect mirror: 0 is glTF's
// special mode [KHR_materials_ior], and beyond 2^27 the reflectance is 1 in float.
#define EK_IOR_LIMIT 0x1p27f

EK_FN vi fresnel_is_mirror(vf eta) { return !((eta > (1.0f / EK_IOR_LIMIT)) & (eta < EK_IOR_LIMIT)); }

/// (1 - cos)^5, the weight of f90 in Schlick's approximation [Schlick 1994, eq. 15].
EK_FN vf schlick_weight(vf cosine) {
  const vf m = max_f(1.0f - cosine, (vf)(0.0f));
  const vf m2 = m * m;
  return (m2 * m2) * m;
}

/// Reflectance of a coat of lacquer, of index 1.5, by Schlick's approximation
/// [KHR_materials_clearcoat].
EK_FN vf coat_reflectance(vf cosine) { return 0.04f + 0.96f * schlick_weight(cosine); }

/// f0 + (f90 - f0) weight [glTF 2.0, appendix B.3.2]; weight: schlick_weight of the angle to the
/// microfacet.
EK_FN v3 schlick(v3 f0, vf f90, vf weight) {
  return V3(f0.x + (f90 - f0.x) * weight, f0.y + (f90 - f0.y) * weight, f0.z + (f90 - f0.z) * weight);
}

/// Unpolarised reflectance of a dielectric interface: 1 under total internal reflection, and for
/// indices that stand for a mirror; 0 for eta = 1.
/// cos_o  of the light with the normal, (0, 1]
/// eta    index of refraction of the far side over that of the near side
// [Born and Wolf 1999, section 1.5.2] with g = eta cos_t. The differences cos_o - g and eta^2 cos_o
// - g are multiplied by their sums, which takes (eta - 1)(eta + 1) out as a factor: nothing
// cancels, however close eta is to 1.
EK_FN vf fresnel_dielectric(vf cos_o, vf eta) {
  const vi mirror = fresnel_is_mirror(eta);
  const vf n = mirror ? (vf)(1.0f) : eta;
  const vf k = (n - 1.0f) * (n + 1.0f);
  const vf n2 = n * n;
  const vf g2 = cos_o * cos_o + k;
  const vf g = sqrt_f(max_f(g2, (vf)(0.0f)));
  const vf sum_s = cos_o + g, sum_p = n2 * cos_o + g;
  const vf r_s = div_f(div_f(k, sum_s), sum_s);
  const vf r_p = div_f(div_f(k * (n2 * (cos_o * cos_o) - (1.0f - cos_o) * (1.0f + cos_o)), sum_p), sum_p);
  vf f = 0.5f * (r_s * r_s + r_p * r_p);
  f = k == 0.0f ? (vf)(0.0f) : f;
  return (mirror | (g2 < 0.0f)) ? (vf)(1.0f) : min_f(f, (vf)(1.0f));
}

/// Unpolarised reflectance of a conductor seen from air.
/// cosine  of the light with the normal, [0, 1]
/// eta, k  its index of refraction is eta + i k; 0 <= eta, k <= 2^14
/// source  [Born and Wolf 1999, section 14.2], with a^2 and b^2 of the complex eta cos_t from
///         a^2 b^2 = eta^2 k^2 and a^2 - b^2 = eta^2 - k^2 - sin^2; k = 0 gives the dielectric
EK_FN vf fresnel_conductor(vf cosine, vf eta, vf k) {
  const vf c2 = cosine * cosine, s2 = (1.0f - cosine) * (1.0f + cosine);
  const vf difference = (eta - k) * (eta + k) - s2, twice = 2.0f * (eta * k);
  const vf sum = sqrt_f(difference * difference + twice * twice);  // a^2 + b^2
  // a^2 = (sum + difference) / 2; where that would cancel, it comes from the product.
  const vf b2 = 0.5f * (sum - difference);
  const vf a2 = difference >= 0.0f ? 0.5f * (sum + difference) : b2 > 0.0f ? div_f(0.25f * (twice * twice), b2) : (vf)(0.0f);
  const vf across = 2.0f * (sqrt_f(a2) * cosine);
  const vf r_s = div_f((sum + c2) - across, (sum + c2) + across);
  const vf top = c2 * sum + s2 * s2, side = across * s2;
  const vf ratio = top + side > 0.0f ? div_f(top - side, top + side) : (vf)(1.0f);
  return min_f(max_f(0.5f * (r_s + r_s * ratio), (vf)(0.0f)), (vf)(1.0f));
}

/// Refracted direction [Walter et al. 2007, eq. 40]; meaningless under total internal reflection.
/// wo, h  unit, on one side; cos_o: dot(wo, h);  eta: not a mirror's
EK_FN v3 refract(v3 wo, v3 h, vf cos_o, vf eta) {
  const vf k = (eta - 1.0f) * (eta + 1.0f);
  const vf g = sqrt_f(max_f(cos_o * cos_o + k, (vf)(0.0f)));
  vf along = div_f(-k, cos_o + g);  // cos_o - g
  along = k == 0.0f ? (vf)(0.0f) : along;
  return scale3(sub3(scale3(h, along), wo), div_f((vf)(1.0f), eta));
}

#endif
