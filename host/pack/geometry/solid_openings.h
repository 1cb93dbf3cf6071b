// SPDX-License-Identifier: Apache-2.0
// The openings in the boundaries of solids: where alphaMode MASK or BLEND lets rays through glass
// with a volume.
#pragma once
#include <cstdint>
#include <vector>

#include "pack/materials/material_traits.h"
#include "scene/scene.h"

namespace eikon {

/// Tells the surfaces whose opacity stage `shade` decides about, instead of the traversal
/// (kernels/surface/alpha.h): boundaries of solids that refract, where rays may pass them. The
/// medium of a path changes at such an opening as it does in the glass beside it.
///
/// A mesh that is not closed has no inside, so its openings are passed within the traversal, as
/// those of a leaf are. So are those of solids that emit: light sampling counts them by the
/// triangles that shadow rays meet.
class SolidOpenings {
 public:
  explicit SolidOpenings(const Scene& scene);

  /// True if a material may have such openings where a closed mesh or a shape has it.
  [[nodiscard]] bool has(std::uint32_t material) const { return by_material_.at(material); }
  /// The same of a primitive of mesh `mesh`.
  [[nodiscard]] bool has(std::uint32_t mesh, const Primitive& primitive) const {
    return has(primitive.material) && is_closed_.at(mesh);
  }
  /// True if some mesh or shape of the scene has such openings.
  [[nodiscard]] bool any(const Scene& scene) const;

 private:
  std::vector<bool> by_material_;
  std::vector<bool> is_closed_;  // per mesh; false where no material of it may have openings
};

/// True if the material's own values allow such openings; its textures and colours decide.
[[nodiscard]] bool may_have_openings(const Material& material);

/// True if every edge of the triangles that bound a solid has a neighbour on its other side, in the
/// opposite direction. Vertices are the same if their positions are, to the bit.
[[nodiscard]] bool is_closed(const Scene& scene, const Mesh& mesh);

}  // namespace eikon
