// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade`: the material of a hit, and the media on both sides of it.
#ifndef EK_SHADE_MATERIAL_H
#define EK_SHADE_MATERIAL_H
#include "stages/shade/context.h"
#include "surface/medium.h"

/// Parameters of the material, its emission as it leaves the surface. interface: is set
EK_FN HitMaterial shade_material(const ShadeContext* c, const PathHit* hit, MediumInterface* interface) {
  HitMaterial material = hit_material(c->scene, hit->corners.material, hit->attributes, hit->front);
  const MediumInterface none = {(vu)(0u), (vu)(0u), (vi)(0), (vi)(0), (vu)(0u)};
  *interface = none;
  if (EK_USES_MEDIUM) {
    interface->medium = hit->path.medium;
    interface->transmitted_medium = transmitted_medium(material, hit->path.medium, hit->corners.material, hit->front);
  }
  if (EK_HAS_nested_media) {
    interface->is_null =
        resolve_interface(c->scene, interface->medium, interface->transmitted_medium, hit->front, &material);
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
