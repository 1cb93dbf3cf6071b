// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade` where light paths take part: what a camera path must know to share its
// light with them.
//
// A light path and a camera path can build the same path: a lamp, one or more targets, and a
// surface that the camera sees. Light paths build it from the lamp: the first surface that they
// meet must be a target, specular or glossy (light_path.h), and the last one before the camera must
// scatter otherwise than as delta. Camera paths build it by meeting the lamp, and at glossy targets
// also by sampling it. The balance heuristic [Veach 1995] gives each a share: with R the density of
// the light path over that of the camera path, the camera path has 1 / (1 + R) of the light, and
// the light path R / (1 + R).
//
// R is the product of two factors that each side knows:
//   mean_emission_density                  at the lamp: the density with which light paths start
//   M pi / (film_density_m2 cosine)        at the first surface that the camera sees (light_ratio)
// M is the number of light paths of the image at each sample index, film_density_m2 the density of
// camera rays across the ray (film/camera_connection.h), and cosine that of the ray with the
// surface. If that surface is a glossy target, the second factor is multiplied by the solid angle
// of its lobe over pi (lobe_sr), since camera paths sample that lobe and light paths do not.
//
// What surfaces between these two do is left out: for diffuse surfaces it cancels, and for others
// both sides leave it out alike, so the weights add up to one wherever both may go. Camera paths
// keep the light of those where light paths may not: is_reversible, is_target and
// is_hidden_from_light_paths tell. That takes one word of a path (lights/light_ratio_word.h) and no
// evaluation of a BSDF.
#ifndef EK_LIGHT_RATIO_H
#define EK_LIGHT_RATIO_H
#include "film/camera_connection.h"
#include "lights/light_path.h"
#include "stages/shade/merge.h"
#include "stages/shade/scatter.h"

#if EK_HAS_light_paths
/// Mask of the lanes that hit a target: of any kind, EK_MATERIAL_LIGHT_TARGET, or a glossy one,
/// EK_MATERIAL_GLOSSY_TARGET. No ball holds a plane without end, so it is no target whatever its
/// material is.
EK_FN vi is_target(const ShadeContext* c, const PathHit* hit, uint kind) {
  const vi is = (load_word_u(MaterialRecord, c->scene.materials, hit->corners.material, flags) & kind) != 0u;
  return EK_HAS_plane ? is & !is_endless_record(hit->corners) : is;
}
EK_FN vi is_glossy_target(const ShadeContext* c, const PathHit* hit) {
  return EK_GLOSSY_TARGETS ? is_target(c, hit, EK_MATERIAL_GLOSSY_TARGET) : (vi)(0);
}

/// PathState.light_ratio behind the first surface on a path from the camera.
/// dir, distance  of the camera's ray
EK_FN vf first_light_ratio(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point, v3 dir, vf distance) {
  constant Frame* frame = c->stage.frame;
  const vf cosine = abs_f(dot3(hit->surface.n_geom, dir));
  const vf density = film_density_m2(frame, dir, distance) * cosine;
  const vf width = is_glossy_target(c, hit) ? lobe_sr(point->material.ggx_alpha, (vf)(1.0f)) * EK_INV_PI : (vf)(1.0f);
  return unmarked(density > 0.0f ? div_f((TO_F((vi)(frame->light_path_count)) * EK_PI) * width, density) : (vf)(0.0f));
}

/// Mask of the lanes whose shading normal is the surface's own from the side of w: usable_normal
/// bends it for some directions, so a path and the same path the other way round would see
/// different mirrors.
EK_FN vi is_unbent(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                   v3 w) {
  const v3 raw = hit_raw_normal(c, hit, material);
  return is_unbent_from(raw, point->n_geom, w, is_glossy(material));
}

/// Mask of the lanes that hit a glossy target whose normal is not bent for this viewer. is_glossy
/// is true of it, so is_unbent_from tells the same of another direction by n_shade.
EK_FN vi is_unbent_glossy_target(const ShadeContext* c, const PathHit* hit, const HitMaterial* material,
                                const ShadingPoint* point) {
  vi is = is_glossy_target(c, hit);
  if (EK_USES_SHADING_NORMAL & point->needs_attributes && ANY(is))
    is = is & is_unbent(c, hit, material, point, neg3(hit->path.dir));
  return is;
}

/// Mask of the lanes where a light path has the delta scattering of a camera path that goes the
/// other way. Coats and thin films are left out, since they may differ between both sides of a
/// surface.
EK_FN vi is_reversible(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                       const ScatteredPath* next) {
  vi reversible = has_no_density(next->pdf);
  if (EK_LAYERED) {
    const LayerDetailLanes layers = load_layer_detail(c->scene.material_details, hit->corners.material);
    reversible = reversible & !((layers.clearcoat > 0.0f) | (max_component(layers.sheen_color) > 0.0f));
  }
  if (EK_HAS_iridescence) reversible = reversible & !(point->material.iridescence > 0.0f);
  if (EK_USES_SHADING_NORMAL & point->needs_attributes)
    reversible = reversible & is_unbent(c, hit, material, point, neg3(hit->path.dir)) & is_unbent(c, hit, material, point, next->dir);
  return reversible | point->interface.is_null;
}

/// The ratio of a path that shares light, after delta scattering. It is 0 where light paths cannot
/// go the same way, and has a mark where the surface is no target.
EK_FN vf delta_light_ratio(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                           const ScatteredPath* next, vf ratio) {
  const vf from_target = marked(ratio, is_target(c, hit, EK_MATERIAL_LIGHT_TARGET) ? (vu)(0u) : (vu)(EK_NO_TARGET_MARK));
  return is_reversible(c, hit, material, point, next) ? from_target : (vf)(0.0f);
}

/// Mask of the lanes where light paths do not scatter towards the viewer, because the shading
/// normal faces away from there: as the light sees it, the viewer is below the surface, and their
/// density is 0. Light paths that bend the normal for themselves might go there, and end instead
/// (light_scatter).
EK_FN vi is_hidden_from_light_paths(const ShadingPoint* point, const ScatteredPath* next) {
  return point->faces_away & has_density(next->pdf);
}

#if EK_HAS_merging
/// As next_light_ratio, from the second surface on, where photons take part.
EK_FN vf next_merged_ratio(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                           const ScatteredPath* next) {
  const vf ratio = unmarked(hit->path.light_ratio);
  const vi is_delta = has_no_density(next->pdf), seen_by_delta = ratio == EK_SEEN_BY_DELTA;
  const vi found_by_light_paths = !seen_by_delta & (ratio != 0.0f);
  vf after = (seen_by_delta & !is_delta) ? (vf)(EK_MERGED) : ratio;
  after = (found_by_light_paths & is_hidden_from_light_paths(point, next)) ? (vf)(0.0f) : after;
  if (!ANY(found_by_light_paths & is_delta)) return after;
  return (found_by_light_paths & is_delta) ? delta_light_ratio(c, hit, material, point, next, ratio) : after;
}
#endif

/// As next_light_ratio, from the second surface on, without the mark of a glossy target.
EK_FN vf next_shared_ratio(const ShadeContext* c, const PathHit* hit, const HitMaterial* material,
                           const ShadingPoint* point, const ScatteredPath* next) {
#if EK_HAS_merging
  return next_merged_ratio(c, hit, material, point, next);
#else
  vf ratio = unmarked(hit->path.light_ratio);
  const vi is_delta = (ratio > 0.0f) & has_no_density(next->pdf);
  ratio = is_hidden_from_light_paths(point, next) ? (vf)(0.0f) : ratio;
  if (!ANY(is_delta)) return ratio;
  return is_delta ? delta_light_ratio(c, hit, material, point, next, ratio) : ratio;
#endif
}

/// PathState.light_ratio of a camera path that goes on; 0 if light paths do not bring its light.
/// point  with sampled_light_ratio
EK_FN vf next_light_ratio(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, const ShadingPoint* point,
                          const ScatteredPath* next) {
  const vi is_delta = has_no_density(next->pdf);
  if (c->depth == 1)
    return is_delta ? (vf)(EK_HAS_merging ? EK_SEEN_BY_DELTA : 0.0f)
                    : first_light_ratio(c, hit, point, hit->path.dir, hit->t);
  const vf ratio = next_shared_ratio(c, hit, material, point, next);
  if (!EK_GLOSSY_TARGETS) return ratio;
  vi leaves_glossy_target = !is_delta & (point->sampled_light_ratio != 0.0f);
  if (!ANY(leaves_glossy_target)) return ratio;
  if (EK_USES_SHADING_NORMAL & point->needs_attributes)
    leaves_glossy_target =
        leaves_glossy_target & is_unbent_from(point->n_shade, point->n_geom, next->dir, (vi)(-1));
  const vu mark = lobe_mark(lobe_sr(point->material.ggx_alpha, abs_f(dot3(point->n_geom, next->dir))));
  return leaves_glossy_target ? marked(ratio, mark) : ratio;
}

/// The ratio by which a path shares what it samples of lights at this hit (sampled_light_share), if
/// that is a glossy target; 0: it shares nothing.
EK_FN vf sampled_light_ratio(const ShadeContext* c, const PathHit* hit, const HitMaterial* material,
                             const ShadingPoint* point) {
  const vi shared = hit->live & is_shared_ratio(hit->path.light_ratio);
  if (!EK_GLOSSY_TARGETS || c->depth == 1 || !ANY(shared)) return (vf)(0.0f);
  return (shared & is_unbent_glossy_target(c, hit, material, point)) ? unmarked(hit->path.light_ratio) : (vf)(0.0f);
}

/// Does what light paths ask of a path before it samples lights: gathers photons, and finds what it
/// shares of that light.
EK_FN void begin_sharing(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, ShadingPoint* point) {
#if EK_HAS_merging
  if (c->depth > 1) add_merged_light(c, hit, point);
#endif
  point->sampled_light_ratio = sampled_light_ratio(c, hit, material, point);
}

/// Share of the emission of a hit that camera paths bring: the rest comes by light paths.
EK_FN vf emission_share(const ShadeContext* c, const PathHit* hit, vi emits) {
  const vf ratio = hit->path.light_ratio;
  const vi shared = emits & is_shared_scattering(hit->path.pdf, ratio) & (hit->corners.light_pdf_m2 > 0.0f);
  if (!ANY(shared)) return (vf)(1.0f);
  const vu light = shared ? hit->corners.flags >> EK_TRIANGLE_LIGHT_SHIFT : (vu)(0u);
  vf pdf_of_point = (vf)(1.0f);
#if EK_HAS_shape & EK_HAS_shape_light
  const vi is_shape = shared & is_shape_record(hit->corners);
  if (ANY(is_shape)) {
    const vu index = is_shape ? AS_U(hit->corners.n.x) : (vu)(0u);
    const ShapeView view =
        shape_view_of_all(load_shape(c->scene.shapes, index), load_shape_world(c->scene.shapes, index));
    pdf_of_point = is_shape ? shape_pdf_m2(view, hit->on_shape, hit->u) : pdf_of_point;
  }
#endif
  const v3 n_geom = hit->surface.n_geom, dir = neg3(hit->path.dir);
  const vf start_m2 = start_pdf_m2(c->lights, light, pdf_of_point);
  const vf emitted = mean_emission_density(c->lights, light, start_m2, n_geom, dir);
  const vf pdf_sr = pdf_sr_from_m2(start_m2, n_geom, dir, hit->t);
  const vf density = density_beside_sampling(emitted, pdf_sr, marked_lobe_sr(ratio));
  return shared ? camera_share(ratio, density) : (vf)(1.0f);
}
#endif

#endif
