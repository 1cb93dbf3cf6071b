// SPDX-License-Identifier: Apache-2.0
#include "pack/materials/hit_class.h"

#include "pack/materials/lobe.h"
#include "shared/records.h"

namespace eikon {

std::uint32_t hit_class(const Material& material, const Primitive* primitive) {
  const Lobe lobe = lobe_of(material);
  if (lobe == Lobe::transmission) return SHADING_TRANSMISSIVE;
  const bool bare = material.clearcoat == 0 && material.sheen_color == glm::vec3(0) && textures_of(material).empty();
  const bool flat = primitive == nullptr || (primitive->normals_object.empty() && primitive->tangents_object.empty() &&
                                             primitive->colors.empty());
  return lobe == Lobe::diffuse && bare && flat ? SHADING_LAMBERT : SHADING_OPAQUE;
}

std::uint32_t hit_class_flags(const Material& material, const Primitive* primitive) {
  return hit_class(material, primitive) << EK_TRIANGLE_CLASS_SHIFT;
}

}  // namespace eikon
