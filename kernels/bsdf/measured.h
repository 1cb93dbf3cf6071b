// SPDX-License-Identifier: Apache-2.0
// A table of measurements (EIKON_materials_measured), times the base colour, as MERL has them: by the half vector's angle theta_h
// with the normal, and the angles theta_d and phi_d of either direction about the half vector [Matusik et al. 2003, "A Data-Driven
// Reflectance Model"; Rusinkiewicz 1998, "A New Change of Variables for Efficient BRDF Representation"]. Between the middles of
// cells the value is interpolated in all three; where phi_d ends it begins again, since exchanging wo and wi adds half a turn to it.
//
// Sampled half by the cosine, half by what the table has beyond its least value (host/scene/measured_table.cpp), both with a
// probability that hangs on wo. The cosine's is 1/8 at least: no sample has a weight above 8 pi f.
#ifndef EK_BSDF_MEASURED_H
#define EK_BSDF_MEASURED_H
#include "bsdf/microfacet.h"
#include "shared/measured.h"
#include "lanes/warp.h"

// Where a pair of directions is in the table.
typedef struct {
  vf length;   // |wo + wi|, twice the cosine of theta_d
  vf theta_h;  // in cells: i is the lower bound of cell i
  vf theta_d, phi_d;
} HalfAngles;

// Both above the surface. The same bits for (wi, wo).
EK_FN HalfAngles half_angles(v3 wo, v3 wi) {
  const v3 sum = add3(wo, wi), difference = sub3(wi, wo);
  const vf flat2 = sum.x * sum.x + sum.y * sum.y;
  HalfAngles a;
  a.length = sqrt(flat2 + sum.z * sum.z);
  a.theta_h = EK_MEASURED_THETA_H * sqrt(4.0f * atan2_turns(sqrt(flat2), sum.z));
  a.theta_d = (4.0f * EK_MEASURED_THETA_D) * atan2_turns(sqrt(dot3(difference, difference)), a.length);
  // wi's components along the half vector's parallel and meridian, both times 2 sin theta_h |wo + wi|. Exchanging wo and wi
  // changes both signs and nothing else, and angles are counted within half a turn.
  const vf y = 2.0f * (wo.x * wi.y - wo.y * wi.x), x = (wo.z - wi.z) * a.length;
  const vi other = (y < 0.0f) | ((y == 0.0f) & (x < 0.0f));
  a.phi_d = (2.0f * EK_MEASURED_PHI_D) * atan2_turns(other ? -y : y, other ? -x : x);
  return a;
}

EK_FN v3 measured_entry(MaterialLanes m, vu cell) {
  const vu at = m.measured_table + ((vu)(EK_MEASURED_VALUES) + 3u * cell);
  return V3(gather_f(m.measured, at), gather_f(m.measured, at + 1u), gather_f(m.measured, at + 2u));
}

// Equal ends come out exactly.
EK_FN v3 measured_between(v3 a, v3 b, vf t) { return add3(a, scale3(sub3(b, a), t)); }

// The lower of the two cells whose middles x is between, and in t how far it is from one to the other.
EK_FN vu measured_cell(vf x, float cells, vf* t) {
  const vf middle = max_f(min_f(x - 0.5f, (vf)(cells - 1.0f)), (vf)(0.0f));
  const vi cell = TO_I(min_f(middle, (vf)(cells - 2.0f)));
  *t = middle - TO_F(cell);
  return AS_U(cell);
}

// Four values of one theta_h: at theta_d and phi_d.
EK_FN v3 measured_slice(MaterialLanes m, vu theta_h, vu theta_d, vf t_d, vu phi0, vu phi1, vf t_phi) {
  const vu row = (theta_h * EK_MEASURED_THETA_D + theta_d) * EK_MEASURED_PHI_D, next = row + EK_MEASURED_PHI_D;
  return measured_between(measured_between(measured_entry(m, row + phi0), measured_entry(m, row + phi1), t_phi),
                          measured_between(measured_entry(m, next + phi0), measured_entry(m, next + phi1), t_phi), t_d);
}

/// f, interpolated.
EK_FN v3 measured_f(MaterialLanes m, HalfAngles a) {
  vf t_h, t_d;
  const vu theta_h = measured_cell(a.theta_h, EK_MEASURED_THETA_H, &t_h),
           theta_d = measured_cell(a.theta_d, EK_MEASURED_THETA_D, &t_d);
  vf phi = a.phi_d - 0.5f;
  phi = phi < 0.0f ? phi + EK_MEASURED_PHI_D : phi;
  const vi cell = TO_I(max_f(min_f(phi, (vf)(EK_MEASURED_PHI_D - 1.0f)), (vf)(0.0f)));
  const vf t_phi = phi - TO_F(cell);
  const vu phi0 = AS_U(cell), phi1 = phi0 == EK_MEASURED_PHI_D - 1u ? (vu)(0u) : phi0 + 1u;
  return measured_between(measured_slice(m, theta_h, theta_d, t_d, phi0, phi1, t_phi),
                          measured_slice(m, theta_h + 1u, theta_d, t_d, phi0, phi1, t_phi), t_h);
}

// Where what is sampled for a view begins.
EK_FN vu measured_view(MaterialLanes m, v3 wo) {
  const vf view = max_f(min_f(wo.z * (float)EK_MEASURED_VIEWS, (vf)(EK_MEASURED_VIEWS - 1.0f)), (vf)(0.0f));
  return m.measured_table + ((vu)(EK_MEASURED_EDGES) + AS_U(TO_I(view)) * EK_MEASURED_VIEW_WORDS);
}

EK_FN BsdfValue measured_value(MaterialLanes m, vu view, v3 wo, v3 wi) {
  const vi valid = (wo.z > 0.0f) & (wi.z > 0.0f);
  const HalfAngles a = half_angles(wo, wi);
  const vf p_half = gather_f(m.measured, view);
  const vu cell = AS_U(TO_I(max_f(min_f(a.theta_h, (vf)(EK_MEASURED_THETA_H - 1.0f)), (vf)(0.0f))));
  const vf density = gather_f(m.measured, view + (cell + EK_MEASURED_VIEW_DENSITY));
  BsdfValue value;
  value.f = scale3(mul3(m.base_color, measured_f(m, a)), wi.z);
  value.pdf = p_half * (density / (2.0f * max_f(a.length, (vf)(0x1p-60f)))) + (1.0f - p_half) * (EK_INV_PI * wi.z);
  return bsdf_value_if(valid, value);
}

EK_FN BsdfValue measured_evaluate(MaterialLanes m, v3 wo, v3 wi) { return measured_value(m, measured_view(m, wo), wo, wi); }

// A half vector, uniform in the cell of theta_h that v chooses.
EK_FN v3 measured_half_vector(MaterialLanes m, vu view, vf u, vf v) {
  vu cell = (vu)(0u);  // the last whose cumulative probability does not exceed v
  const vu cumulative = view + EK_MEASURED_VIEW_CUMULATIVE;
  for (uint step = 64u; step > 0u; step >>= 1) {
    const vu next = cell + step;
    const vi inside = next < EK_MEASURED_THETA_H;
    const vf before = gather_f(m.measured, cumulative + (inside ? next : (vu)(0u)));
    cell = (inside & (before <= v)) ? next : cell;
  }
  const vf before = gather_f(m.measured, cumulative + cell), behind = gather_f(m.measured, cumulative + (cell + 1u));
  const vf share = behind > before ? (v - before) / (behind - before) : (vf)(0.5f);
  const vf inner = gather_f(m.measured, m.measured_table + cell), outer = gather_f(m.measured, m.measured_table + (cell + 1u));
  const vf versine = inner + share * (outer - inner);  // 1 - cos, of which small ones keep all their digits
  const vf r = sqrt(max_f(versine * (2.0f - versine), (vf)(0.0f)));
  vf s, c;
  sincos_2pi(u, &s, &c);
  return V3(r * c, r * s, 1.0f - versine);
}

EK_FN BsdfSample measured_sample(MaterialLanes m, v3 wo, vf u, vf v, vf choice) {
  const vu view = measured_view(m, wo);
  const vi by_half = choice < gather_f(m.measured, view);
  const v3 reflected = normalize3(mirrored(wo, measured_half_vector(m, view, u, v)));
  const v3 wi = select3(by_half, reflected, warp_cosine_hemisphere(u, v));
  return bsdf_sample_of(measured_value(m, view, wo, wi), wi, (vi)(0));
}

#endif
