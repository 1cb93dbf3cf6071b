// SPDX-License-Identifier: Apache-2.0
#include "pack/materials/lobe.h"

namespace eikon {

Lobe lobe_of(const Material& material) {
  if (material.unlit) return Lobe::diffuse;
  if (material.lobe) return *material.lobe;
  const bool may_be_dielectric = material.metallic < 1 || material.metallic_roughness_texture;
  if ((material.transmission > 0 || material.diffuse_transmission > 0) && may_be_dielectric) return Lobe::transmission;
  if (material.metallic > 0 || material.specular > 0 || material.iridescence > 0) return Lobe::metallic_roughness;
  return Lobe::diffuse;
}

bool is_solid(const Material& material) { return material.solid && lobe_of(material) == Lobe::transmission; }

}  // namespace eikon
