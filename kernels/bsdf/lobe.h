// SPDX-License-Identifier: Apache-2.0
// The types that every lobe takes and returns (contract: bsdf.h).
#ifndef EK_LOBE_H
#define EK_LOBE_H
#include "bsdf/lobe_traits.h"
#include "lanes/math.h"
#include "lanes/record_lanes.h"
#include "lanes/warp.h"
#include "guide/guide.h"

/// A shading normal may differ from that of the surface itself (surface/shading_normal.h).
#define EK_USES_SHADING_NORMAL (EK_HAS_vertex_normal | EK_HAS_normal_texture)
/// BSDFs need the normal of the surface itself (MaterialLanes.n_geom).
#define EK_USES_GEOMETRIC_NORMAL (EK_USES_SHADING_NORMAL | EK_HAS_clearcoat_normal)

// The parameters of a material at a hit, one per lane (surface/material.h fills them in).
typedef struct {
  vu lobes;          // bit set of EK_LOBE (lobe_traits.h)
  v3 base_color;     // linear, [0, 1]
  vf metallic;       // [0, 1]
  vf ggx_alpha;      // square of glTF's roughness
  vf ggx_alpha_x;    // the same along x, which is the direction of anisotropy; not less
  v3 f0_dielectric;  // reflectance at normal incidence of the dielectric part
  vf specular;  // its reflectance at grazing incidence: KHR_materials_specular's factor, [0, 1]
  v3 f0;             // both reflectances of the whole surface, with its metallic part
  vf f90;
  vf transmission;   // share of what enters the dielectric part that passes through, [0, 1]
  vf diffuse_transmission;  // share of the diffuse base that transmits, [0, 1]
  v3 diffuse_transmission_color;
  vi solid;          // transmits by refraction; else the surface is a thin wall
  vf eta;            // solids: index of refraction of the far side over that of wo's side
  // The layers on it (bsdf/layers.h):
  vf clearcoat;        // [0, 1]
  vf clearcoat_alpha;  // square of glTF's roughness
  v3 clearcoat_normal; // local, unit, on wo's side
#if EK_USES_GEOMETRIC_NORMAL
  int has_n_geom;      // 0: n_geom is +z in all lanes
  v3 n_geom;           // normal of the surface itself, local, unit, on wo's side
#endif
  v3 sheen;            // colour of the fibres, [0, 1]
  vf sheen_roughness;  // [0, 1]
  vf iridescence;      // share of the surface under a thin film, [0, 1]
  vf thin_film_index;      // of the film over that of air
  vf thin_film_thickness;  // metres
  LobeDetailLanes own;  // what one lobe alone needs (shared/lobe_parameters.def)
  global const float* measured;   // tables of all materials, the same for all lanes
  vu measured_table;              // word at which the lane's own table begins
#if EK_USES_GUIDE
  GuideCell guide;  // steers the diffuse part
#endif
} MaterialLanes;

/// Sets n_geom.
/// has_n_geom  0: it is +z in all lanes
EK_FN void set_geometric_normal(MaterialLanes* m, v3 n_geom, int has_n_geom) {
#if EK_USES_GEOMETRIC_NORMAL
  m->n_geom = n_geom;
  m->has_n_geom = has_n_geom;
#else
  (void)m;
  (void)n_geom;
  (void)has_n_geom;
#endif
}

typedef struct {
  v3 weight;  // eval / pdf
  v3 wi;      // local, unit
  vf pdf;     // per sr; 0: nothing sampled
  vi delta;   // mask
} BsdfSample;

// eval and pdf of one pair of directions. A lobe's `evaluate` gives both: they share most of their
// work.
typedef struct {
  v3 f;    // f |cos theta_i|
  vf pdf;  // per sr
} BsdfValue;

// value where m is set, else zero.
EK_FN BsdfValue bsdf_value_if(vi m, BsdfValue value) {
  const vf zero = (vf)(0.0f);
  BsdfValue r = {select3(m, value.f, V3(zero, zero, zero)), m ? value.pdf : zero};
  return r;
}

/// The sample of direction wi.
/// value  of wi, or of the delta part where `delta` is set
EK_FN BsdfSample bsdf_sample_of(BsdfValue value, v3 wi, vi delta) {
  const vi some = value.pdf > 0x1p-100f;
  const vf zero = (vf)(0.0f);
  BsdfSample s = {select3(some, scale3(value.f, div_f((vf)(1.0f), value.pdf)), V3(zero, zero, zero)),
                  select3(some, wi, V3(zero, zero, (vf)(1.0f))),
                  some ? value.pdf : zero, some & delta};
  return s;
}

/// Density with which a diffuse part is sampled in a direction of the upper hemisphere, per sr.
EK_FN vf diffuse_pdf(MaterialLanes m, v3 wi) {
  const vf cosine = wi.z * EK_INV_PI;
#if EK_USES_GUIDE
  return cosine * guide_density(m.guide, wi);
#else
  (void)m;
  return cosine;
#endif
}

/// Samples a direction for a diffuse part. over_cosine: is set to its density over that of the
/// cosine
EK_FN v3 diffuse_direction(MaterialLanes m, vf u, vf v, vf* over_cosine) {
  *over_cosine = (vf)(1.0f);
#if EK_USES_GUIDE
  *over_cosine = guide_warp(m.guide, &u, &v);
#else
  (void)m;
#endif
  return warp_cosine_hemisphere(u, v);
}

EK_FN vf mean_component(v3 a) { return ((a.x + a.y) + a.z) * (1.0f / 3.0f); }

#endif
