// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade`: the material of a hit, and the media on both sides of it.
#ifndef EK_SHADE_MATERIAL_H
#define EK_SHADE_MATERIAL_H
#include "stages/shade/context.h"
#include "surface/alpha.h"
#include "surface/medium.h"

#if EK_HAS_open_solid
/// Mask of the lanes whose path has met an opening of a solid.
/// solid  mask: the surface bounds a solid
EK_FN vi meets_opening(const ShadeContext* c, const PathHit* hit, vi solid) {
  vi undecided = hit->live & solid & ((hit->corners.flags & EK_TRIANGLE_ALPHA_TESTED) == 0u);
  vu surface = hit->triangle;
#if EK_HAS_shape
  const vi is_shape = is_shape_record(hit->corners);
  const vu shape = is_shape ? AS_U(hit->corners.n.x) : (vu)(0u);
  surface = is_shape ? shape_opacity_surface(shape, 0u) : surface;
#if EK_HAS_implicit
  // The opacity of an implicit surface does not count.
  undecided = undecided & !(is_shape & (load_word_u(ShapeRecord, c->scene.shapes, shape, kind) == (uint)SHAPE_implicit));
#endif
#endif
  if (!ANY(undecided)) return undecided;
  const MaterialRecordLanes record = load_material(c->scene.materials, hit->corners.material);
  const vf opacity = material_opacity(c->scene, record, hit->attributes);
  vf number = (vf)(0.0f);  // the right decision for opacity 0 and 1
  if (ANY(undecided & (opacity > 0.0f) & (opacity < 1.0f)))
    number = opacity_number(opacity_key(hit->path.key, hit->path.index, c->depth, 0u), surface);
  return undecided & (number >= opacity);
}
#endif

/// Parameters of the material, its emission as it leaves the surface. interface: is set
EK_FN HitMaterial shade_material(const ShadeContext* c, const PathHit* hit, MediumInterface* interface) {
  HitMaterial material = hit_material(c->scene, hit->corners.material, hit->attributes, hit->front);
  const MediumInterface none = {.medium = (vu)(0u),
                                .transmitted_medium = (vu)(0u),
                                .is_null = (vi)(0),
                                .skips_depth = (vi)(0),
                                .null_interface_count = (vu)(0u)};
  *interface = none;
  if (EK_USES_MEDIUM) {
    interface->medium = hit->path.medium;
    interface->transmitted_medium = transmitted_medium(material, hit->path.medium, hit->corners.material, hit->front);
  }
  if (EK_HAS_nested_media)
    interface->is_null =
        resolve_interface(c->scene, interface->medium, interface->transmitted_medium, hit->front, &material);
#if EK_HAS_open_solid
  interface->is_opening = meets_opening(c, hit, material.bsdf.solid & !interface->is_null);
  interface->is_null = interface->is_null | interface->is_opening;
#endif
  if (EK_USES_NULL_INTERFACES) {
    interface->null_interface_count = hit->path.null_interface_count;
    interface->skips_depth = interface->is_null & (interface->null_interface_count < EK_NULL_INTERFACES_MOST);
  }
  if (EK_HAS_clearcoat) {
    const vf cosine = dot3(hit->surface.n_geom, hit->path.dir);
    material.emission = scale3(material.emission, clearcoat_passes(material.bsdf.clearcoat, cosine));
  }
  return material;
}

#endif
