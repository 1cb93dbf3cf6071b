// SPDX-License-Identifier: Apache-2.0
// Traits are derived from a material: its lobe, the class of shading that its surfaces take, and
// its rank among overlapping solids.
#pragma once
#include <cstdint>
#include <vector>

#include "scene/scene.h"
#include "shared/lobe_traits.h"

namespace eikon {

/// The lobe that scatters as this material does. A material has one, and coat and sheen lie over
/// it.
[[nodiscard]] Lobe lobe_of(const Material& material);

/// Tells whether the material's lobe has one of the traits of kernels/shared/lobe_traits.h.
/// wanted  a bit set of EK_TRAIT_*
[[nodiscard]] bool has_trait(const Material& material, std::uint32_t wanted);

/// True if the material's surfaces are the boundary of something that light goes into.
[[nodiscard]] bool is_solid(const Material& material);

/// True if the material may be that of a solid with openings (SolidOpenings): it refracts, does not
/// emit, and rays may pass it. Its textures and the colours of its meshes decide.
[[nodiscard]] bool may_have_openings(const Material& material);

/// True if camera rays pass the backs of the material's surfaces (Culling). Surfaces that transmit
/// light are seen from both sides, because a path inside of glass has to meet its boundary.
[[nodiscard]] bool is_single_sided(const Material& material);

/// The class SHADING_* (records.h) of a surface. Kernels for one class leave out what it says that
/// no surface of the class has (record_of_class in kernels/surface/material.h). primitive: null for
/// shapes
[[nodiscard]] std::uint32_t shading_class(const Material& material, const Primitive* primitive);

/// The bits of a triangle's flags that depend on its material: the class, and
/// EK_TRIANGLE_SINGLE_SIDED.
[[nodiscard]] std::uint32_t surface_flags(const Material& material, const Primitive* primitive);

/// Tells which primitives have an opacity below 1 somewhere, so that a ray may pass them: those
/// with alphaMode MASK or BLEND whose factor, texture or vertex colours are below 1. Many files say
/// BLEND where everything is opaque.
class PassableMaterials {
 public:
  explicit PassableMaterials(const Scene& scene);
  [[nodiscard]] bool has(const Primitive& primitive) const;
  /// The same for a surface without vertex colours.
  [[nodiscard]] bool has(std::uint32_t material) const { return by_material_.at(material) == Passable::always; }

 private:
  enum class Passable { never, if_colors, always };
  std::vector<Passable> by_material_;
};

/// Tells for each material whether some node shows it.
[[nodiscard]] std::vector<bool> shown_materials(const Scene& scene);

/// The rank of each material among the solids that are shown, as nested_media.h uses it: 1 is the
/// lowest, and 0 means that the material is no solid. Ranks follow mediumPriority, which is 0 by
/// default; of equal priorities the later in the file is higher. throws InputError when there are
/// more than EK_MEDIA_RANKS solids
[[nodiscard]] std::vector<std::uint32_t> medium_ranks(const Scene& scene);

}  // namespace eikon
