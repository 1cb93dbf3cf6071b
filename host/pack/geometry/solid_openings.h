// SPDX-License-Identifier: Apache-2.0
// The openings in the boundaries of solids: where alphaMode MASK or BLEND lets rays through glass
// with a volume.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "pack/materials/material_traits.h"
#include "scene/scene.h"

namespace eikon {

/// Tells the surfaces whose opacity stage `shade` decides about, instead of the traversal
/// (kernels/surface/alpha.h): boundaries of solids that refract, where rays may pass them. The
/// medium of a path changes at such an opening as it does in the glass beside it. Radiance over the
/// square of the index of refraction stays the same there, as it does where glass refracts, so a
/// room of one radiance stays of one; but the ray is not bent, so that the power of a beam changes
/// by that square, and back where it leaves by another opening.
///
/// Openings of a mesh that is not closed lead to no inside, so they are passed within the
/// traversal, as those of a leaf are. So are those of solids that emit, because light sampling
/// counts them by the triangles that shadow rays meet. Every shape counts as closed. The opacity of
/// an implicit surface counts nowhere.
class SolidOpenings {
 public:
  SolidOpenings() = default;  // of a scene that has none
  explicit SolidOpenings(const Scene& scene);

  /// True if the opacity of a primitive of mesh `mesh` is below 1 somewhere, and shade decides.
  [[nodiscard]] bool has(std::uint32_t mesh, const Primitive& primitive) const;
  [[nodiscard]] bool has(const Shape& shape) const;  // likewise
  /// The material of one that the scene shows; nothing if there is none.
  [[nodiscard]] std::optional<std::uint32_t> first_material(const Scene& scene) const;

 private:
  std::vector<bool> by_material_;  // may_have_openings
  std::vector<bool> is_closed_;    // per mesh; false where no material of it may have openings
  std::optional<PassableMaterials> passable_;
};

/// True if the triangles that bound a solid close it but for a ten-thousandth of their area, and
/// face all outwards or all inwards. (Holes that lie evenly around the middle may go unnoticed.)
[[nodiscard]] bool is_closed(const Scene& scene, const Mesh& mesh);

}  // namespace eikon
