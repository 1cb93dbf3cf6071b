// SPDX-License-Identifier: Apache-2.0
// Steps of stage `shade`: the normals of a hit, and the local frame in which its BSDF is evaluated.
#ifndef EK_SHADE_SHADING_FRAME_H
#define EK_SHADE_SHADING_FRAME_H
#include "stages/shade/context.h"
#include "surface/medium.h"
#include "surface/shading_normal.h"

/// The normal of a hit by vertex normals and normal map, on the viewer's side.
EK_FN v3 hit_raw_normal(const ShadeContext* c, const PathHit* hit, const HitMaterial* material) {
  v3 n = shading_normal(hit->attributes, hit->surface.n_geom);
  if (EK_HAS_normal_texture)
    n = mapped_normal(c->scene, material->normal_texture, hit->attributes, n, hit->surface.n_geom);
  return select3(hit->front, n, neg3(n));
}

/// Mask of the surfaces with a lobe other than Lambert's, or with a coat. Of these usable_normal
/// keeps the mirror direction above the surface, too.
EK_FN vi is_glossy(const HitMaterial* material) {
  const vi glossy = (material->bsdf.lobes & ~lobes_with(EK_TRAIT_LAMBERT)) != 0u;
  return EK_HAS_clearcoat ? glossy | (material->bsdf.clearcoat > 0.0f) : glossy;
}

#if EK_HAS_light_paths
/// Mask of the lanes whose normal usable_normal leaves as it is from the side of w.
/// n, n_geom  on one side of the surface, which may be the other one
EK_FN vi is_unbent_from(v3 n, v3 n_geom, v3 w, vi glossy) {
  const vi same_side = dot3(w, n_geom) > 0.0f;
  const v3 n_seen = select3(same_side, n, neg3(n));
  const v3 used = usable_normal(n_seen, select3(same_side, n_geom, neg3(n_geom)), w, glossy);
  return (used.x == n_seen.x) & (used.y == n_seen.y) & (used.z == n_seen.z);
}
#endif

/// Sets the shading normal of a point, on the viewer's side.
EK_FN void set_shading_normal(const ShadeContext* c, const PathHit* hit, const HitMaterial* material,
                              ShadingPoint* point) {
  const v3 raw = hit_raw_normal(c, hit, material), wo = neg3(hit->path.dir);
  point->n_shade = usable_normal(raw, point->n_geom, wo, is_glossy(material));
#if EK_HAS_light_paths
  point->faces_away = dot3(raw, wo) < 0.0f;
#endif
}

/// The shading point of a hit, without its basis and wo. The medium on the way has taken its share
/// of the throughput.
EK_FN ShadingPoint shading_point(const ShadeContext* c, const PathHit* hit, const HitMaterial* material,
                                 const MediumInterface* interface) {
  ShadingPoint point;
  point.live = hit->live;
  point.is_flat_lambert = hit->is_flat_lambert;
  point.needs_attributes = hit->needs_attributes;
  point.path = hit->path.path;
  point.key = hit->path.key;
  point.index = hit->path.index;
  point.triangle = hit->triangle;
#if EK_HAS_moving_surface | EK_HAS_moving_light
  point.time = hit->path.time;
#endif
  point.material = material->bsdf;
  point.interface = *interface;
  point.p = hit->surface.p;
  point.p_error = hit->surface.p_error;
  point.n_geom = select3(hit->front, hit->surface.n_geom, neg3(hit->surface.n_geom));
  point.n_shade = point.n_geom;
#if EK_HAS_light_paths
  point.faces_away = (vi)(0);
#endif
  if (EK_USES_SHADING_NORMAL & hit->needs_attributes) set_shading_normal(c, hit, material, &point);
  point.beta = hit->path.beta;
  if (EK_HAS_absorption)
    point.beta = mul3(point.beta, transmittance(medium_absorption(c->scene, interface->medium), hit->t));
#if EK_HAS_path_log
  point.transmitted = log_share(hit->path.beta, point.beta);
#endif
  return point;
}

/// Sets the basis of a shading point, and what is measured in it.
EK_FN void shading_frame(const ShadeContext* c, const PathHit* hit, const HitMaterial* material, ShadingPoint* point) {
  const v3 wo_world = neg3(hit->path.dir), n_front = hit->surface.n_geom;
  point->basis = basis_around(point->n_shade);
  if (EK_HAS_anisotropy)
    point->basis = basis_along(point->basis, anisotropy_direction(*material, hit->attributes, n_front));
  point->wo = to_local(point->basis, wo_world);
  point->both_sides = has_trait(point->material.lobes, EK_TRAIT_TRANSMITS);
  const v3 up = V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f));
  set_geometric_normal(&point->material, select3(point->is_flat_lambert, up, to_local(point->basis, point->n_geom)), point->needs_attributes);
  v3 n_light = point->n_shade;
  const vi transmits = point->both_sides;
  if (EK_HAS_clearcoat_normal & point->needs_attributes) {
    const v3 n_vertex = shading_normal(hit->attributes, n_front);
    v3 n_coat = mapped_normal(c->scene, material->clearcoat_normal_texture, hit->attributes, n_vertex, n_front);
    n_coat = select3(hit->front, n_coat, neg3(n_coat));
    n_coat = usable_normal(n_coat, point->n_geom, wo_world, point->material.clearcoat > 0.0f);
    point->material.clearcoat_normal = to_local(point->basis, n_coat);
    // The coat reflects light from below the shading normal's horizon, too, but none from below the
    // surface itself.
    const v3 apart = sub3(n_coat, point->n_shade);
    const vi has_own = (point->material.clearcoat > 0.0f) & (dot3(apart, apart) > 0.0f);
    n_light = select3(has_own, point->n_geom, n_light);
    point->both_sides = point->both_sides | has_own;
  }
  // Reflected rays begin at this point, so the tree gives a light that such a ray meets the
  // probability it has here, bit for bit.
  point->light_context.p = point->p;
  if (EK_HAS_light_tree)
    point->light_context.p = offset_ray_origin(point->p, point->p_error, point->n_geom, point->n_geom);
  point->light_context.packed_normal = EK_HAS_light_tree ? pack_normal(n_light, transmits) : (vu)(0u);
}

/// Mask of the lanes whose BSDF tells the sides of the surface itself for each part (clearcoat.h).
EK_FN vi bsdf_has_sides(const ShadingPoint* point) {
  return EK_HAS_clearcoat_normal ? point->material.clearcoat > 0.0f : (vi)(0);
}

/// Tells light that is transmitted from what is reflected, for directions that light is scattered
/// to.
/// wi  local; wi_world  the same
EK_FN vi is_transmitted(const ShadingPoint* point, v3 wi, v3 wi_world) {
  if (!EK_HAS_clearcoat_normal) return wi.z < 0.0f;
  return bsdf_has_sides(point) ? dot3(wi_world, point->n_geom) < 0.0f : wi.z < 0.0f;
}

/// Tells directions that lie on the same side of the surface itself as of its shading normal:
/// reflected light stays on the viewer's side, and transmitted light leaves it. Walls would leak
/// light otherwise.
/// wi  local; cos_geom  of the direction with n_geom
EK_FN vi is_on_geometric_side(const ShadingPoint* point, v3 wi, vf cos_geom) {
  const vi above = EK_HAS_clearcoat_normal ? bsdf_has_sides(point) | (wi.z > 0.0f) : wi.z > 0.0f;
  const vi reflected = above & (cos_geom > 0.0f);
  if (!has_lobe_with(EK_TRAIT_TRANSMITS)) return reflected;
  return reflected | ((wi.z < 0.0f) & (cos_geom < 0.0f));
}

#endif
