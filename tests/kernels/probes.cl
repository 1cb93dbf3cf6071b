// SPDX-License-Identifier: Apache-2.0
// Production functions applied to arrays (probe.h). Item i of input k is word k * count + i of
// in_words, and the same for outputs. A program holds the probes of one subject. Bodies are
// functions of their own: a kernel's own code takes three times as long to compile (EK_FN_ONCE).
#include "lanes/compact.h"
#include "lanes/math.h"

#define IN_U(k) load_u(in_words + (k) * count + item)
#define IN_F(k) AS_F(IN_U(k))
#define IN_3(k) V3(IN_F(k), IN_F((k) + 1), IN_F((k) + 2))
#define OUT_U(k, x) store_u(out_words + (k) * count + item, (x))
#define OUT_F(k, x) OUT_U(k, AS_U(x))
#define PROBE_ARGUMENTS global const uint *in_words, global uint *out_words, uint count
// Of a body: item is the first of EK_WIDTH.
#define PROBE_ITEMS PROBE_ARGUMENTS, uint item
#define PROBE_PASSED in_words, out_words, count, (uint)get_global_id(0) * EK_WIDTH
// A kernel that is given no more than that, and the head of its body.
#define PROBE(name)                                                   \
  EK_FN_ONCE void name##_run(PROBE_ITEMS);                            \
  kernel void name(PROBE_ARGUMENTS) { name##_run(PROBE_PASSED); } \
  EK_FN_ONCE void name##_run(PROBE_ITEMS)

EK_FN void out_3(global uint* out_words, uint count, uint item, uint k, v3 a) {
  OUT_F(k, a.x);
  OUT_F(k + 1, a.y);
  OUT_F(k + 2, a.z);
}
#define OUT_3(k, a) out_3(out_words, count, item, (k), (a))

#ifdef EK_PROBE_lanes
// Keeps the words whose flag is set, in order, as a chunked stage does. The rest is 0.
PROBE(probe_compaction) {
  if (item != 0) return;
  uint kept = 0;
  for (uint i = 0; i < count; i += EK_WIDTH) {
    const Packing p = packing(load_u(in_words + i) != 0u);
    store_u(out_words + kept, packed(p, load_u(in_words + count + i)));
    kept += p.count;
  }
  for (uint i = kept; i < count; ++i) out_words[i] = 0;
}

PROBE(probe_any) {
  // Lanes of one group of 16 see the same flag, so that the answer does not depend on the width.
  const vi m = IN_U(0) != 0u;
  OUT_U(0, (vu)(ANY(m) ? 1u : 0u));
}

EK_FN_ONCE void probe_records_run(PROBE_ITEMS, global const uint* records) {
  const Rec r = rec16(records, IN_U(0));
  OUT_F(0, r.w0); OUT_F(1, r.w1); OUT_F(2, r.w2); OUT_F(3, r.w3); OUT_F(4, r.w4); OUT_F(5, r.w5); OUT_F(6, r.w6);
  OUT_F(7, r.w7); OUT_F(8, r.w8); OUT_F(9, r.w9); OUT_F(10, r.wa); OUT_F(11, r.wb); OUT_F(12, r.wc); OUT_F(13, r.wd);
  OUT_F(14, r.we); OUT_F(15, r.wf);
}
kernel void probe_records(PROBE_ARGUMENTS, global const uint* records) {
  probe_records_run(PROBE_PASSED, records);
}

PROBE(probe_gather_scatter) {
  const vu from = IN_U(0);
  const vu to = IN_U(1);
  scatter_f((global float*)out_words, to, gather_f((global const float*)(in_words + 2 * count), from));
  OUT_U(1, gather_u(in_words + 2 * count, from));
  OUT_U(2, LANE_INDEX + item);
}
#endif

#ifdef EK_PROBE_math
PROBE(probe_vectors) {
  const v3 a = IN_3(0);
  const v3 b = IN_3(3);
  OUT_3(0, add3(a, b));
  OUT_3(3, sub3(a, b));
  OUT_3(6, mul3(a, b));
  OUT_3(9, scale3(a, b.x));
  OUT_F(12, dot3(a, b));
  OUT_3(13, cross3(a, b));
  OUT_3(16, normalize3(a));
  OUT_3(19, select3(a.x < b.x, a, neg3(b)));
  OUT_F(22, min_f(a.x, b.x));
  OUT_F(23, max_f(a.x, b.x));
  OUT_F(24, abs_f(a.y));
  OUT_F(25, copysign_f(a.z, b.z));
  OUT_F(26, max_component(a));
  const vi finite = is_finite(div_f(a.x, b.x));
  OUT_U(27, finite ? (vu)(1u) : (vu)(0u));
  OUT_F(28, div_f(a.x, b.y));
  OUT_F(29, sqrt_f(abs_f(a.z)));
}

PROBE(probe_exp2) { OUT_F(0, exp2_f(IN_F(0))); }
PROBE(probe_log2) { OUT_F(0, log2_f(IN_F(0))); }

PROBE(probe_sincos_2pi) {
  vf s, c;
  sincos_2pi(IN_F(0), &s, &c);
  OUT_F(0, s);
  OUT_F(1, c);
}

PROBE(probe_atan2_turns) { OUT_F(0, atan2_turns(IN_F(0), IN_F(1))); }
#endif

#ifdef EK_PROBE_sampler
#include "lanes/sampler.h"
PROBE(probe_words) {
  const vu x = IN_U(0);
  OUT_U(0, hash_bits(x));
  OUT_U(1, reverse_bits(x));
  OUT_U(2, laine_karras(x, IN_U(1)));
  OUT_U(3, reverse_bits(sobol_1_reversed(x)));
  OUT_F(4, to_unit_float(x));
}

EK_FN_ONCE void probe_samples_run(PROBE_ITEMS, uint seed, uint index_high, uint dimension) {
  const vu key = sample_key(IN_U(0), IN_U(1), IN_U(2), seed, index_high);
  vu a, b;
  sample_2d_bits(key, IN_U(3), dimension, &a, &b);
  OUT_U(0, a);
  OUT_U(1, b);
  vf x, y;
  sample_2d(key, IN_U(3), dimension, &x, &y);
  OUT_F(2, x);
  OUT_F(3, y);
  OUT_U(4, key);
}
kernel void probe_samples(PROBE_ARGUMENTS, uint seed, uint index_high, uint dimension) {
  probe_samples_run(PROBE_PASSED, seed, index_high, dimension);
}

PROBE(probe_dimensions) {
  // Depth and decision are scalars of a stage, so lane by lane.
  for (uint i = item; i < item + EK_WIDTH; ++i) out_words[i] = bounce_dimension(in_words[i], in_words[count + i]);
}
#endif

#ifdef EK_PROBE_warp
#include "lanes/warp.h"
PROBE(probe_warps) {
  const vf u = IN_F(0);
  const vf v = IN_F(1);
  OUT_3(0, warp_cosine_hemisphere(u, v));
  OUT_3(3, warp_uniform_hemisphere(u, v));
  OUT_3(6, warp_uniform_sphere(u, v));
  vf b1, b2;
  warp_triangle(u, v, &b1, &b2);
  OUT_F(9, b1);
  OUT_F(10, b2);
  const DiskPoint p = warp_disk(u, v);
  OUT_F(11, p.x);
  OUT_F(12, p.y);
}
#endif

#ifdef EK_PROBE_surface
#include "lanes/basis.h"
#include "surface/surface.h"
// Inputs: triangle, weights u and v, a direction w, the way from the ray's origin.
EK_FN_ONCE void probe_surface_run(PROBE_ITEMS, global const Triangle* triangles) {
  const TriangleLanes t = load_triangle(triangles, IN_U(0));
  const Surface s = surface_at(t, IN_F(1), IN_F(2), IN_3(6));
  OUT_3(0, s.p);
  OUT_3(3, s.p_error);
  OUT_3(6, s.n_geom);
  OUT_3(9, offset_ray_origin(s.p, s.p_error, s.n_geom, IN_3(3)));
  OUT_U(12, t.material);
  OUT_F(13, t.light_pdf_m2);
  OUT_U(14, t.node);
}
kernel void probe_surface(PROBE_ARGUMENTS, global const Triangle* triangles) {
  probe_surface_run(PROBE_PASSED, triangles);
}

PROBE(probe_basis) {
  const Basis basis = basis_around(IN_3(0));
  OUT_3(0, basis.x);
  OUT_3(3, basis.y);
  OUT_3(6, basis.z);
  OUT_3(9, to_local(basis, IN_3(3)));
  OUT_3(12, to_world(basis, IN_3(3)));
}

PROBE(probe_next_float) { OUT_F(0, next_float_towards(IN_F(0), IN_F(1))); }
#endif

#ifdef EK_PROBE_texture
#include "surface/texture.h"
// Inputs: texture, TEXCOORD_0, TEXCOORD_1.
EK_FN_ONCE void probe_texture_run(PROBE_ITEMS, global const TextureRecord* textures, global const uint* texels) {
  const vf zero = (vf)(0.0f);
  const v3 none = V3(zero, zero, zero);
  const HitAttributes at = {none, IN_F(1), IN_F(2), IN_F(3), IN_F(4), none, zero, zero, zero, zero, zero};
  const v4 c = texture_sample(texels, load_texture(textures, IN_U(0)), at);
  OUT_F(0, c.x);
  OUT_F(1, c.y);
  OUT_F(2, c.z);
  OUT_F(3, c.w);
}
kernel void probe_texture(PROBE_ARGUMENTS, global const TextureRecord* textures, global const uint* texels) {
  probe_texture_run(PROBE_PASSED, textures, texels);
}
#endif

#ifdef EK_PROBE_material
#include "surface/material.h"
#include "surface/medium.h"
// Inputs: material, triangle, weights u and v, whether the front was hit.
EK_FN_ONCE void probe_material_run(PROBE_ITEMS, SceneData scene) {
  const vu one = (vu)(1u), zero = (vu)(0u);
  const HitAttributes at = hit_attributes(scene, IN_U(1), IN_F(2), IN_F(3));
  const HitMaterial hit = hit_material(scene, IN_U(0), at, IN_U(4) != 0u);
  OUT_3(0, hit.bsdf.base_color);
  OUT_3(3, hit.emission);
  OUT_F(6, hit.bsdf.metallic);
  OUT_F(7, hit.bsdf.ggx_alpha);
  OUT_3(8, hit.bsdf.f0_dielectric);
  OUT_F(11, hit.bsdf.specular);
  OUT_3(12, hit.bsdf.f0);
  OUT_F(15, hit.bsdf.f90);
  OUT_F(16, hit.bsdf.transmission);
  OUT_U(17, hit.bsdf.solid ? one : zero);
  OUT_F(18, hit.bsdf.eta);
  OUT_U(19, hit.bsdf.lobes);
  OUT_U(20, hit.double_sided ? one : zero);
  OUT_U(21, hit.unlit ? one : zero);
  OUT_F(22, material_opacity(scene, load_material(scene.materials, IN_U(0)), at));
}
kernel void probe_material(PROBE_ARGUMENTS, EK_SCENE_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  probe_material_run(PROBE_PASSED, scene);
}

// Inputs: medium of the ray, distance; whether it hit a front and was transmitted; material.
EK_FN_ONCE void probe_medium_run(PROBE_ITEMS, SceneData scene) {
  OUT_3(0, transmittance(medium_absorption(scene, IN_U(0)), IN_F(1)));
  const HitAttributes at = hit_attributes(scene, (vu)(0u), (vf)(0.0f), (vf)(0.0f));
  const vi front = IN_U(2) != 0u;
  const vu beyond = transmitted_medium(hit_material(scene, IN_U(4), at, front), IN_U(0), IN_U(4), front);
  OUT_U(3, IN_U(3) != 0u ? beyond : IN_U(0));
}
kernel void probe_medium(PROBE_ARGUMENTS, EK_SCENE_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  probe_medium_run(PROBE_PASSED, scene);
}

// Inputs: list of media, rank.
PROBE(probe_media_list) {
  OUT_U(0, media_with(IN_U(0), IN_U(1)));
  OUT_U(1, media_without(IN_U(0), IN_U(1)));
}

// Inputs: list of media that the ray is in, material that it hit, whether its front.
EK_FN_ONCE void probe_media_meet_run(PROBE_ITEMS, SceneData scene) {
  const HitAttributes at = hit_attributes(scene, (vu)(0u), (vf)(0.0f), (vf)(0.0f));
  const vi front = IN_U(2) != 0u;
  HitMaterial hit = hit_material(scene, IN_U(1), at, front);
  const vu beyond = transmitted_medium(hit, IN_U(0), IN_U(1), front);
  const vi hidden = resolve_interface(scene, IN_U(0), beyond, front, &hit);
  OUT_U(0, beyond);
  OUT_U(1, hidden ? (vu)(1u) : (vu)(0u));
  OUT_F(2, hit.bsdf.eta);
  OUT_3(3, hit.bsdf.f0_dielectric);
  OUT_F(6, hit.spread);
  OUT_F(7, hit.other_spread);
  OUT_F(8, media_radiance_outside(scene, IN_U(0)));
  OUT_3(9, medium_absorption(scene, IN_U(0)));
}
kernel void probe_media_meet(PROBE_ARGUMENTS, EK_SCENE_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  probe_media_meet_run(PROBE_PASSED, scene);
}
#endif

#ifdef EK_PROBE_shading_normal
#include "surface/shading_normal.h"
// Inputs: triangle, weights u and v, n_geom; index of a normal texture.
EK_FN_ONCE void probe_shading_normal_run(PROBE_ITEMS, SceneData scene) {
  const HitAttributes at = hit_attributes(scene, IN_U(0), IN_F(1), IN_F(2));
  const v3 n_geom = IN_3(3);
  const v3 n_shade = shading_normal(at, n_geom);
  OUT_3(0, n_shade);
  OUT_3(3, mapped_normal(scene, IN_U(6), at, n_shade, n_geom));
}
kernel void probe_shading_normal(PROBE_ARGUMENTS, EK_SCENE_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  probe_shading_normal_run(PROBE_PASSED, scene);
}

// Inputs: n_shade, n_geom, wo, whether the surface reflects.
PROBE(probe_usable_normal) {
  OUT_3(0, usable_normal(IN_3(0), IN_3(3), IN_3(6), IN_U(9) != 0u));
}

// Inputs: cosines of the light with n_geom, with n_shade, and of the two.
PROBE(probe_terminator) { OUT_F(0, terminator_factor(IN_F(0), IN_F(1), IN_F(2))); }
#endif

#ifdef EK_PROBE_bsdf
#include "surface/material.h"
EK_FN_ONCE BsdfValue probe_evaluate(MaterialLanes m, v3 wo, v3 wi) { return bsdf_evaluate(m, wo, wi); }

// Inputs: material, wo, wi, u, v, choice, front or not, coat's normal, alpha along x or -1, n_geom.
EK_FN_ONCE void probe_bsdf_run(PROBE_ITEMS, SceneData scene) {
  const HitAttributes at = hit_attributes(scene, (vu)(0u), (vf)(0.0f), (vf)(0.0f));
  const HitMaterial hit = hit_material(scene, IN_U(0), at, IN_U(10) != 0u);
  MaterialLanes m = hit.bsdf;
  m.clearcoat_normal = IN_3(11);
  set_geometric_normal(&m, IN_3(15), 1);
  m.ggx_alpha_x = IN_F(14) >= 0.0f ? IN_F(14) : m.ggx_alpha;
  const v3 wo = IN_3(1), wi = IN_3(4);
  const BsdfValue stated = probe_evaluate(m, wo, wi);
  OUT_3(0, stated.f);
  OUT_F(3, stated.pdf);
  const BsdfSample s = bsdf_sample(m, wo, IN_F(7), IN_F(8), IN_F(9));
  OUT_3(4, s.weight);
  OUT_3(7, s.wi);
  OUT_F(10, s.pdf);
  const BsdfValue again = probe_evaluate(m, wo, s.wi);
  OUT_3(11, again.f);
  OUT_F(14, again.pdf);
  OUT_3(15, hit.emission);
  OUT_U(18, hit.double_sided ? (vu)(1u) : (vu)(0u));
  OUT_U(19, s.delta ? (vu)(1u) : (vu)(0u));
}
kernel void probe_bsdf(PROBE_ARGUMENTS, EK_SCENE_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  probe_bsdf_run(PROBE_PASSED, scene);
}

// Inputs: cosine, eta.
PROBE(probe_fresnel) { OUT_F(0, fresnel_dielectric(IN_F(0), IN_F(1))); }

// Inputs: cosine, eta, k.
PROBE(probe_fresnel_conductor) { OUT_F(0, fresnel_conductor(IN_F(0), IN_F(1), IN_F(2))); }

#if EK_HAS_iridescence
// Inputs: index and thickness of a film, reflectance of its base, cosine.
PROBE(probe_thin_film_reflectance) {
  const ThinFilm film = {IN_F(0), IN_F(1)};
  const v3 f = thin_film_reflectance(film, V3(IN_F(2), IN_F(2), IN_F(2)), IN_F(3));
  OUT_F(0, f.x);
  OUT_F(1, f.y);
  OUT_F(2, f.z);
}

// Inputs: index and thickness of a film, eta and k of the conductor below, cosine.
PROBE(probe_thin_film_conductor) {
  const ThinFilm film = {IN_F(0), IN_F(1)};
  OUT_3(0, thin_film_conductor_reflectance(film, IN_3(2), IN_3(5), IN_F(8)));
}
#endif

// Inputs: alpha, wo.
PROBE(probe_ggx_albedo) {
  const vf alpha = IN_F(0);
  const v3 wo = IN_3(1);
  const GgxAlbedoFit fit = ggx_albedo_fit(alpha < EK_SMOOTH_ALPHA, alpha);
  const GgxAlbedo a = ggx_albedo(fit, wo.z, ggx_length(wo, ggx_isotropic(alpha)));
  OUT_F(0, a.full);
  OUT_F(1, a.grazing);
  OUT_F(2, fit.mean.full);
  OUT_F(3, fit.mean.grazing);
}
#endif

#ifdef EK_PROBE_light
#include "lights/light.h"
PROBE(probe_power_heuristic) { OUT_F(0, power_heuristic(IN_F(0), IN_F(1))); }

EK_FN_ONCE void probe_alias_table_run(PROBE_ITEMS, global const AliasEntry* light_alias_table, uint light_count) {
  const AliasSample c = alias_table_sample(light_alias_table, light_count, IN_U(0), IN_U(1));
  OUT_U(0, c.index);
  OUT_F(1, c.u);
  OUT_F(2, c.v);
}
kernel void probe_alias_table(PROBE_ARGUMENTS, global const AliasEntry* light_alias_table, uint light_count) {
  probe_alias_table_run(PROBE_PASSED, light_alias_table, light_count);
}

// Inputs: two random words, point, its error per axis, normal, whether below counts, two words.
EK_FN_ONCE void probe_light_run(PROBE_ITEMS, constant Frame* frame, LightData data) {
  const v3 p = IN_3(2);
  const v3 p_error = IN_3(5);
  const v3 n = IN_3(8);
  const vi both_sides = IN_U(11) != 0u;
  const LightWords words = {IN_U(0), IN_U(1), IN_U(12), IN_U(13)};
  const LightQuery query = {.context = {p, pack_normal(n, both_sides)}, .wanted = ALL_LANES, .words = words};
  const Basis basis = basis_around(n);
  const LightSample s = light_sample(frame, data, pick_light(frame, data, query), (LightViewer){basis, both_sides}, words);
  const LightRay path = light_ray(s, p, p_error, n);
  OUT_U(0, s.is_distant ? (vu)(1u) : (vu)(0u));
  OUT_3(1, s.p);
  OUT_3(4, s.n);
  OUT_3(7, s.radiance);
  OUT_F(10, s.pdf);
  OUT_3(11, path.wi);
  OUT_F(14, path.pdf);
  OUT_3(15, path.origin);
  OUT_3(18, path.dir);
  OUT_F(21, path.t_max);
  // What a ray that met the same point or direction would be weighted with.
  const v3 d = sub3(s.p, p);
  vf asked = pdf_sr_from_m2(s.pdf, s.n, path.wi, sqrt_f(dot3(d, d)));
  const vf constant_sky = environment_pdf_sr(frame->environment.w, dot3(path.wi, basis.z), both_sides);
  const vf sky = frame->environment_width > 0
                     ? environment_map_value(frame, data.environment_texels, path.wi).pdf
                     : constant_sky;
  asked = s.is_distant ? sky : asked;
  OUT_F(22, asked);
  OUT_3(23, path.radiance);
  OUT_U(26, s.is_delta ? (vu)(1u) : (vu)(0u));
}
kernel void probe_light(PROBE_ARGUMENTS, constant Frame* frame, EK_LIGHT_ARGUMENTS) {
  const LightData data = EK_LIGHT_DATA;
  probe_light_run(PROBE_PASSED, frame, data);
}

#if EK_HAS_light_tree
// Inputs: two random words, shading point, its normal, whether light from below counts, a light.
EK_FN_ONCE void probe_light_tree_run(PROBE_ITEMS, global const LightNode* light_nodes, uint light_count, float scale) {
  const LightSampleContext lit = {IN_3(2), pack_normal(IN_3(5), IN_U(8) != 0u)};
  TreeSearch search = tree_search(light_count, scale, lit, ALL_LANES, IN_U(0), IN_U(1));
  while (ANY(search.walk.open)) tree_search_step(light_nodes, &search);
  const TreeChoice c = tree_search_end(search);
  OUT_U(0, c.light);
  OUT_F(1, c.probability);
  OUT_F(2, c.u);
  OUT_F(3, light_tree_probability(light_nodes, light_count, scale, lit, ALL_LANES, c.light));
  OUT_F(4, light_tree_probability(light_nodes, light_count, scale, lit, ALL_LANES, IN_U(9)));
}
kernel void probe_light_tree(PROBE_ARGUMENTS, global const LightNode* light_nodes, uint light_count, float scale) {
  probe_light_tree_run(PROBE_PASSED, light_nodes, light_count, scale);
}
#endif

// Inputs: a direction.
EK_FN_ONCE void probe_environment_map_run(PROBE_ITEMS, constant Frame* frame, global const float4* environment_texels) {
  const v3 dir = IN_3(0);
  const MapPlace place = map_place(frame, dir);
  const MapValue value = environment_map_value(frame, environment_texels, dir);
  OUT_3(0, value.radiance);
  OUT_F(3, value.pdf);
  OUT_F(4, place.x);
  OUT_F(5, place.y);
  OUT_U(6, map_texel(frame, place));
}
kernel void probe_environment_map(PROBE_ARGUMENTS, constant Frame* frame, global const float4* environment_texels) {
  probe_environment_map_run(PROBE_PASSED, frame, environment_texels);
}
#endif

#ifdef EK_PROBE_light_shape
#include "lights/shape_light.h"
#include "traverse/ray.h"
#include "traverse/shape_hit.h"

// Where the ray from p along dir first meets the only shape, and light sampling's density of that.
EK_FN vi probe_met(constant Frame* frame, SceneData scene, v3 p, v3 dir, v3* point, v3* normal, vf* pdf) {
  const OpacityKey key = {(vu)(0u), (vu)(0u)};
  const RayLanes ray = ray_lanes(frame, p, dir, key);
  const vu zero = (vu)(0u);
  const TriangleLanes corners = load_triangle(scene.triangles, zero);
  const ShapeHit hit = shape_hit(scene, &ray, ALL_LANES, zero, zero, corners.p0, corners.p1, EK_INFINITY);
  Surface surface = {p, p, p};
  const ShapePoint at = shape_surface(scene, corners, hit.part, p, dir, hit.t, &surface);
  *point = surface.p;
  *normal = surface.n_geom;
  const ShapeLightHit shape_hit = {.is_shape = ALL_LANES, .at = at, .part = hit.part};
  *pdf = shape_light_pdf_sr(scene, corners, shape_hit, p, dir);
  return hit.hit;
}

// Inputs: place on the shape, viewpoint.
EK_FN_ONCE void probe_shape_light_run(PROBE_ITEMS, constant Frame* frame, SceneData scene) {
  const v3 p = IN_3(2);
  LightSample s;
  s.is_shape = ALL_LANES;
  s.is_distant = s.is_punctual = s.is_delta = s.double_sided = (vi)(0);
  s.triangle = (vu)(0u);
  s.u = IN_F(0);
  s.v = IN_F(1);
  s.b1 = s.b2 = (vf)(0.0f);
  s.p = s.p_error = s.n = s.wi = s.radiance = p;
  s.pdf = (vf)(1.0f);
  s = shape_light_sample(scene, s, p);
  const v3 wi = normalize3(sub3(s.p, p));
  v3 met, normal;
  vf pdf;
  const vi hit = probe_met(frame, scene, p, wi, &met, &normal, &pdf);
  OUT_3(0, s.p);
  OUT_3(3, s.n);
  OUT_F(6, s.pdf);
  OUT_3(7, wi);
  OUT_U(10, hit ? (vu)(1u) : (vu)(0u));
  OUT_3(11, met);
  OUT_F(14, pdf);
}
kernel void probe_shape_light(PROBE_ARGUMENTS, constant Frame* frame, EK_SCENE_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  probe_shape_light_run(PROBE_PASSED, frame, scene);
}

// Inputs: viewpoint, direction.
EK_FN_ONCE void probe_shape_pdf_run(PROBE_ITEMS, constant Frame* frame, SceneData scene) {
  v3 met, normal;
  vf pdf;
  const vi hit = probe_met(frame, scene, IN_3(0), IN_3(3), &met, &normal, &pdf);
  OUT_U(0, hit ? (vu)(1u) : (vu)(0u));
  OUT_F(1, pdf);
}
kernel void probe_shape_pdf(PROBE_ARGUMENTS, constant Frame* frame, EK_SCENE_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  probe_shape_pdf_run(PROBE_PASSED, frame, scene);
}
#endif

#ifdef EK_PROBE_filter
#include "film/filter.h"
EK_FN_ONCE void probe_filter_run(PROBE_ITEMS, global const float* filter_table) {
  const FilterSample s = filter_sample(filter_table, IN_F(0));
  OUT_F(0, s.offset);
  OUT_F(1, s.weight);
}
kernel void probe_filter(PROBE_ARGUMENTS, global const float* filter_table) {
  probe_filter_run(PROBE_PASSED, filter_table);
}
#endif

#ifdef EK_PROBE_opacity
#include "surface/alpha.h"
// Inputs: key of a path, index of its sample, triangle.
EK_FN_ONCE void probe_opacity_number_run(PROBE_ITEMS, uint depth, uint kind) {
  OUT_F(0, opacity_number(opacity_key(IN_U(0), IN_U(1), depth, kind), IN_U(2)));
}
kernel void probe_opacity_number(PROBE_ARGUMENTS, uint depth, uint kind) {
  probe_opacity_number_run(PROBE_PASSED, depth, kind);
}
#endif

#ifdef EK_PROBE_implicit
#include "shapes/implicit_root.h"
// Inputs: a point, a direction; the same region as low and high ends of a point.
EK_FN_ONCE void probe_implicit_values_run(PROBE_ITEMS, uint formula) {
  OUT_F(0, implicit_value(formula, IN_3(0)));
  OUT_3(1, implicit_gradient(formula, IN_3(0)));
  const ImplicitBounds b = implicit_bounds(formula, interval(IN_F(6), IN_F(9)), interval(IN_F(7), IN_F(10)),
                                           interval(IN_F(8), IN_F(11)), IN_3(3));
  OUT_F(4, b.value.lo);
  OUT_F(5, b.value.hi);
  OUT_F(6, b.slope.lo);
  OUT_F(7, b.slope.hi);
  OUT_U(8, b.undefined ? (vu)(1u) : (vu)(0u));
}
kernel void probe_implicit_values(PROBE_ARGUMENTS, uint formula) {
  probe_implicit_values_run(PROBE_PASSED, formula);
}

// Inputs: a ray, and the bounds. Without a hit only the first word and the last count.
EK_FN_ONCE void probe_implicit_hits_run(PROBE_ITEMS, uint formula) {
  const ImplicitRay ray = implicit_ray(IN_3(0), IN_3(3), IN_3(6), IN_3(9));
  const ImplicitRoot root = implicit_root(formula, ray, (vi)(ALL_LANES), (vi)(0), EK_INFINITY);
  const ImplicitPoint at = implicit_point(formula, ray, (vi)(ALL_LANES), root.hit ? root.s : (vf)(0.0f), (vf)(0.0f));
  OUT_U(0, root.hit ? (vu)(1u) : (vu)(0u));
  OUT_F(1, root.hit ? (ray.begin + root.s) * ray.per_length : (vf)(0.0f));
  OUT_3(2, select3(root.hit, at.p, V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f))));
  OUT_3(5, select3(root.hit, at.n, V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f))));
  OUT_F(8, root.hit ? at.error : (vf)(0.0f));
  OUT_U(9, root.given_up ? (vu)(1u) : (vu)(0u));
}
kernel void probe_implicit_hits(PROBE_ARGUMENTS, uint formula) {
  probe_implicit_hits_run(PROBE_PASSED, formula);
}
#endif
