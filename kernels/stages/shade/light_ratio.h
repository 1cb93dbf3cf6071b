// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade` where light paths take part: what a camera path must know to share its light with them.
//
// Light paths bring the light of paths that leave a lamp, are reflected or refracted exactly at their first surface, and
// are scattered otherwise at the last one before the camera. Camera paths find the same light where they meet the lamp.
// The balance heuristic [Veach 1995] gives each its share: with R the density of light paths over that of camera paths,
// camera paths have 1 / (1 + R) of it, and light paths R / (1 + R).
//
// R is the product of two factors that each side knows: the density of emission at the lamp (emission_density), and
//   M pi / (film density cosine)                                                                   (light_ratio)
// at the first surface that the camera sees, where M is the number of light paths of the image at each sample index. What surfaces
// between them do is left out: for diffuse surfaces it cancels, and for others both sides leave it out alike, so the
// weights add up to one in any case. That takes one word of a path and no evaluation of a BSDF.
#ifndef EK_LIGHT_RATIO_H
#define EK_LIGHT_RATIO_H
#include "film/camera_connection.h"
#include "lights/light_path.h"
#include "stages/shade/merge.h"
#include "stages/shade/scatter.h"

#if EK_HAS_light_paths
/// light_ratio of the first surface on a path from the camera.
/// dir, distance  of the camera's ray; n_geom: of the surface
EK_FN vf first_light_ratio(constant Frame* frame, v3 dir, vf distance, v3 n_geom) {
  const vf cosine = abs_f(dot3(n_geom, dir));
  const vf density = film_density_m2(frame, dir, distance) * cosine;
  return density > 0.0f ? (TO_F((vi)(frame->light_path_count)) * EK_PI) / density : (vf)(0.0f);
}

/// Mask of the lanes whose shading normal is the surface's own from the side of w: usable_normal bends it for some
/// directions, so a path and the same path the other way round would see different mirrors.
EK_FN vi is_unbent(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point, v3 w) {
  const vi same_side = dot3(w, point->n_geom) > 0.0f;
  const v3 raw = hit_raw_normal(c, hit, material);
  const v3 n = select3(same_side, raw, neg3(raw)), n_geom = select3(same_side, point->n_geom, neg3(point->n_geom));
  const v3 used = usable_normal(n, n_geom, w, is_glossy(material));
  return (used.x == n.x) & (used.y == n.y) & (used.z == n.z);
}

/// Mask of the lanes where a light path is reflected or refracted exactly as a camera path is, and the other way round.
/// Coats and thin films are left out, since they may differ between both sides of a surface.
EK_FN vi is_reversible(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                       const ScatteredPath* next) {
  vi reversible = next->pdf < 0.0f;
  if (EK_LAYERED) {
    const LayerDetailLanes layers = load_layer_detail(c->scene.material_details, hit->corners.material);
    reversible = reversible & !((layers.clearcoat > 0.0f) | (max_component(layers.sheen_color) > 0.0f));
  }
  if (EK_HAS_iridescence) reversible = reversible & !(point->material.iridescence > 0.0f);
  if (EK_HAS_SHADING_NORMAL & point->detailed)
    reversible = reversible & is_unbent(c, hit, material, point, neg3(hit->path.dir)) & is_unbent(c, hit, material, point, next->dir);
  return reversible | point->interface.is_null;
}

#if EK_HAS_merging
/// As next_light_ratio, from the second surface on, where photons take part.
EK_FN vf next_merged_ratio(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                           const ScatteredPath* next) {
  const vf ratio = hit->path.light_ratio;
  const vi is_exact = next->pdf < 0.0f, seen_exactly = ratio == EK_SEEN_EXACTLY;
  const vf after = (seen_exactly & !is_exact) ? (vf)(EK_MERGED) : ratio;
  const vi found_by_light_paths = !seen_exactly & (ratio != 0.0f);
  if (!ANY(found_by_light_paths & is_exact)) return after;
  return (found_by_light_paths & is_exact & !is_reversible(c, hit, material, point, next)) ? (vf)(0.0f) : after;
}
#endif

/// light_ratio of a camera path that goes on; 0 if light paths do not bring its light.
EK_FN vf next_light_ratio(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                          const ScatteredPath* next) {
  const vi is_exact = next->pdf < 0.0f;
  if (c->depth == 1)
    return is_exact ? (vf)(EK_HAS_merging ? EK_SEEN_EXACTLY : 0.0f) : first_light_ratio(c->stage.frame, hit->path.dir, hit->t, hit->surface.n_geom);
#if EK_HAS_merging
  return next_merged_ratio(c, hit, material, point, next);
#else
  const vi shared = hit->path.light_ratio > 0.0f;
  if (!ANY(shared & is_exact)) return hit->path.light_ratio;
  return (is_exact & !is_reversible(c, hit, material, point, next)) ? (vf)(0.0f) : hit->path.light_ratio;
#endif
}

/// Share of the emission of a hit that camera paths bring: the rest comes by light paths.
EK_FN vf emission_share(const ShadeContext* c, const PathHit* hit, vi emits) {
  const vf ratio = hit->path.light_ratio;
  const vi shared = emits & (hit->path.pdf < 0.0f) & is_shared_ratio(ratio) & (hit->corners.light_pdf_m2 > 0.0f);
  if (!ANY(shared)) return (vf)(1.0f);
  const vu light = shared ? hit->corners.flags >> EK_TRIANGLE_LIGHT_SHIFT : (vu)(0u);
  const vf density = emission_density(c->stage.frame, c->lights, light, hit->surface.p, hit->surface.n_geom, neg3(hit->path.dir));
  return shared ? camera_share(ratio, density) : (vf)(1.0f);
}
#endif

#endif
