// SPDX-License-Identifier: Apache-2.0
// A virtual gonioreflectometer: it evaluates f of a material at the middle of every cell of a MERL
// table, with the code that renders. A work-item serves one cell; EK_WIDTH is 1.
//   measured_values    R, G, B of each cell; -1 where a direction lies below the surface
//   measured_findings  one word, zero at first: EK_FOUND_*
//   measured_u, _v     where on its textures, bits of floats
#include "surface/material.h"
#include "lanes/sampler.h"

// A cell stands for (wo, wi) and (wi, wo). Of coated surfaces, whose model is not reciprocal, it
// holds the mean of both.
EK_FN_ONCE v3 measure_one_way(MaterialLanes m, v3 wo, v3 wi) { return scale3(bsdf_eval(m, wo, wi), div_f(1.0f, wi.z)); }

/// The material to measure, and the place in its textures.
typedef struct {
  uint material, u, v;
} MeasuredPoint;

EK_FN_ONCE void measure_run(SceneData scene, global float* measured_values, global uint* measured_findings,
                            MeasuredPoint point, uint cell) {
  if (cell >= EK_MEASURED_CELLS) return;
  const float share = div_f((float)(cell / (EK_MEASURED_PHI_D * EK_MEASURED_THETA_D)) + 0.5f, EK_MEASURED_THETA_H);
  const float theta_d = div_f((float)(cell / EK_MEASURED_PHI_D % EK_MEASURED_THETA_D) + 0.5f, EK_MEASURED_THETA_D);
  const float phi_d = div_f((float)(cell % EK_MEASURED_PHI_D) + 0.5f, EK_MEASURED_PHI_D);
  float sin_h, cos_h, sin_d, cos_d, sin_p, cos_p;
  sincos_2pi(0.25f * (share * share), &sin_h, &cos_h);
  sincos_2pi(0.25f * theta_d, &sin_d, &cos_d);
  sincos_2pi(0.5f * phi_d, &sin_p, &cos_p);
  // The half vector lies above +x. `aside` is across it, along its meridian and parallel; wi and wo
  // are on either side.
  const v3 half_vector = V3(sin_h, 0.0f, cos_h);
  const v3 aside = add3(scale3(V3(cos_h, 0.0f, -sin_h), sin_d * cos_p), V3(0.0f, sin_d * sin_p, 0.0f));
  const v3 wi = normalize3(add3(scale3(half_vector, cos_d), aside));
  const v3 wo = normalize3(sub3(scale3(half_vector, cos_d), aside));
  v3 f = V3(-1.0f, -1.0f, -1.0f);
  uint found = 0u;
  if ((wo.z > 0.0f) & (wi.z > 0.0f)) {
    HitAttributes at = hit_attributes(scene, 0u, 0.0f, 0.0f);
    at.uv0_u = at.uv1_u = as_float(point.u);
    at.uv0_v = at.uv1_v = as_float(point.v);
    const MaterialLanes m = hit_material(scene, point.material, at, ALL_LANES).bsdf;
    f = scale3(add3(measure_one_way(m, wo, wi), measure_one_way(m, wi, wo)), 0.5f);
    float u, v, choice, unused;
    sample_2d(hash_bits(cell), 0u, 0u, &u, &v);
    sample_2d(hash_bits(cell), 0u, 2u, &choice, &unused);
    const BsdfSample s = bsdf_sample(m, wo, u, v, choice);
    found |= ((s.pdf > 0.0f) & s.delta) != 0 ? EK_FOUND_DELTA : 0u;
    found |= ((s.pdf > 0.0f) & (s.wi.z < 0.0f)) != 0 ? EK_FOUND_TRANSMISSION : 0u;
    found |= (is_finite(f.x) & is_finite(f.y) & is_finite(f.z)) != 0 ? 0u : EK_FOUND_NOT_FINITE;
  }
  if (found != 0u) atomic_or(measured_findings, found);
  measured_values[3u * cell] = f.x;
  measured_values[3u * cell + 1u] = f.y;
  measured_values[3u * cell + 2u] = f.z;
}

kernel void measure(EK_SCENE_ARGUMENTS, global float* measured_values, global uint* measured_findings, uint measured_material,
                    uint measured_u, uint measured_v) {
  const SceneData scene = EK_SCENE_DATA;
  const MeasuredPoint point = {measured_material, measured_u, measured_v};
  measure_run(scene, measured_values, measured_findings, point, (uint)get_global_id(0));
}
