// SPDX-License-Identifier: Apache-2.0
// A table of measurements (EIKON_materials_measured), times the base colour, in MERL's coordinates:
// the half vector's angle theta_h with the normal, and the angles theta_d and phi_d of the
// directions about the half vector [Matusik et al. 2003, "A Data-Driven Reflectance Model";
// Rusinkiewicz 1998, "A New Change of Variables for Efficient BRDF Representation"]. The value is
// interpolated in all three between the centres of cells; phi_d is periodic, since exchanging wo
// and wi adds half a turn to it.
//
// Sampling is a mixture of the cosine and of the table's excess over its least value
// (host/scene/measured_table.cpp), with probabilities that depend on wo. The cosine has at least
// 1/8, so no sample has a weight above 8 pi f.
#ifndef EK_BSDF_MEASURED_H
#define EK_BSDF_MEASURED_H
#include "bsdf/lobe.h"
#include "bsdf/microfacet.h"
#include "bsdf/terminator.h"
#include "shared/measured.h"
#include "lanes/warp.h"

// The coordinates of a pair of directions in the table.
typedef struct {
  vf length;   // |wo + wi|, twice the cosine of theta_d
  vf theta_h;  // in cells: i is the lower bound of cell i
  vf theta_d, phi_d;
} HalfAngles;

// wo and wi are above the surface. Exchanging them gives the same bits.
EK_FN HalfAngles half_angles(v3 wo, v3 wi) {
  const v3 sum = add3(wo, wi), difference = sub3(wi, wo);
  const vf flat2 = sum.x * sum.x + sum.y * sum.y;
  HalfAngles a;
  a.length = sqrt_f(flat2 + sum.z * sum.z);
  a.theta_h = EK_MEASURED_THETA_H * sqrt_f(4.0f * atan2_turns(sqrt_f(flat2), sum.z));
  a.theta_d = (4.0f * EK_MEASURED_THETA_D) * atan2_turns(sqrt_f(dot3(difference, difference)), a.length);
  // y and x are wi's components along the half vector's parallel and meridian, both times
  // 2 sin theta_h |wo + wi|. Exchanging wo and wi changes both signs and nothing else, and angles
  // are counted within half a turn.
  const vf y = 2.0f * (wo.x * wi.y - wo.y * wi.x), x = (wo.z - wi.z) * a.length;
  const vi other = (y < 0.0f) | ((y == 0.0f) & (x < 0.0f));
  a.phi_d = (2.0f * EK_MEASURED_PHI_D) * atan2_turns(other ? -y : y, other ? -x : x);
  return a;
}

EK_FN v3 measured_entry(MaterialLanes m, vu cell) {
  const vu at = m.measured_table + ((vu)(EK_MEASURED_VALUES) + 3u * cell);
  return V3(gather_f(m.measured, at), gather_f(m.measured, at + 1u), gather_f(m.measured, at + 2u));
}

// The result is exact where a equals b.
EK_FN v3 measured_between(v3 a, v3 b, vf t) { return add3(a, scale3(sub3(b, a), t)); }

// The lower of the two cells whose centres are on both sides of x; t: the weight of the upper one.
EK_FN vu measured_cell(vf x, float cells, vf* t) {
  const vf middle = max_f(min_f(x - 0.5f, (vf)(cells - 1.0f)), (vf)(0.0f));
  const vi cell = TO_I(min_f(middle, (vf)(cells - 2.0f)));
  *t = middle - TO_F(cell);
  return AS_U(cell);
}

// A cell of theta_d and two neighbours of phi_d, with the weights of the upper ones.
typedef struct {
  vu theta_d, phi0, phi1;
  vf t_d, t_phi;
} MeasuredCell;

// The value at one theta_h, interpolated in theta_d and phi_d.
EK_FN v3 measured_slice(MaterialLanes m, vu theta_h, MeasuredCell c) {
  const vu row = (theta_h * EK_MEASURED_THETA_D + c.theta_d) * EK_MEASURED_PHI_D, next = row + EK_MEASURED_PHI_D;
  return measured_between(measured_between(measured_entry(m, row + c.phi0), measured_entry(m, row + c.phi1), c.t_phi),
                          measured_between(measured_entry(m, next + c.phi0), measured_entry(m, next + c.phi1), c.t_phi), c.t_d);
}

/// f, interpolated.
EK_FN v3 measured_f(MaterialLanes m, HalfAngles a) {
  vf t_h;
  MeasuredCell c;
  const vu theta_h = measured_cell(a.theta_h, EK_MEASURED_THETA_H, &t_h);
  c.theta_d = measured_cell(a.theta_d, EK_MEASURED_THETA_D, &c.t_d);
  vf phi = a.phi_d - 0.5f;
  phi = phi < 0.0f ? phi + EK_MEASURED_PHI_D : phi;
  const vi cell = TO_I(max_f(min_f(phi, (vf)(EK_MEASURED_PHI_D - 1.0f)), (vf)(0.0f)));
  c.t_phi = phi - TO_F(cell);
  c.phi0 = AS_U(cell);
  c.phi1 = c.phi0 == EK_MEASURED_PHI_D - 1u ? (vu)(0u) : c.phi0 + 1u;
  return measured_between(measured_slice(m, theta_h, c), measured_slice(m, theta_h + 1u, c), t_h);
}

// The first word of the sampling table for the view direction wo.
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
  value.f = scale3(mul3(m.base_color, measured_f(m, a)), wi.z * diffuse_terminator(m, wi));
  value.pdf = p_half * div_f(density, 2.0f * max_f(a.length, (vf)(0x1p-60f))) + (1.0f - p_half) * (EK_INV_PI * wi.z);
  return bsdf_value_if(valid, value);
}

EK_FN BsdfValue measured_evaluate(MaterialLanes m, v3 wo, v3 wi) { return measured_value(m, measured_view(m, wo), wo, wi); }

// A half vector, uniform in the cell of theta_h that v chooses.
EK_FN v3 measured_half_vector(MaterialLanes m, vu view, vf u, vf v) {
  vu cell = (vu)(0u);  // will be the last cell whose cumulative probability is at most v
  const vu cumulative = view + EK_MEASURED_VIEW_CUMULATIVE;
  for (uint step = 64u; step > 0u; step >>= 1) {
    const vu next = cell + step;
    const vi inside = next < EK_MEASURED_THETA_H;
    const vf before = gather_f(m.measured, cumulative + (inside ? next : (vu)(0u)));
    cell = (inside & (before <= v)) ? next : cell;
  }
  const vf before = gather_f(m.measured, cumulative + cell), behind = gather_f(m.measured, cumulative + (cell + 1u));
  const vf share = behind > before ? div_f(v - before, behind - before) : (vf)(0.5f);
  const vf inner = gather_f(m.measured, m.measured_table + cell), outer = gather_f(m.measured, m.measured_table + (cell + 1u));
  const vf versine = inner + share * (outer - inner);  // 1 - cos, which is exact where it is small
  const vf r = sqrt_f(max_f(versine * (2.0f - versine), (vf)(0.0f)));
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
