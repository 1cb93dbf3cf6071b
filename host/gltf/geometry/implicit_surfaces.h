// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <string>

#include "io/json_text.h"
#include "scene/scene.h"
#include "io/text.h"

namespace eikon {

inline constexpr const char* kImplicitExtension = "EIKON_implicit_surface";

/// Reads the surfaces by formula that nodes place.
class ImplicitSurfaceReader {
 public:
  /// use_material  as MeshReader's
  ImplicitSurfaceReader(const Json& document, std::function<std::uint32_t(int)> use_material, Scene& scene,
                        Notes& notes)
      : document_(document), use_material_(std::move(use_material)), scene_(scene), notes_(notes) {}

  /// Whether a node of the checked document places one.
  [[nodiscard]] static bool has(const Json& node);

  /// Appends what a node places: {"f": "x^2+y^2+z^2-1", "bounds": [-1, -1, -1, 1, 1, 1], "material": 0}. The surface is where f is 0 within
  /// the bounds (least x, y, z, then the largest; the node's space); f > 0 is outside.
  /// throws InputError: a formula that is missing or does not parse; bounds that are missing, empty, or beyond 2^40
  void add(const Place& node, const std::string& name, const glm::dmat4& world_from_object);

 private:
  std::uint32_t formula(const Place& place);

  const Json& document_;
  std::function<std::uint32_t(int)> use_material_;
  Scene& scene_;
  Notes& notes_;
  std::map<std::string, std::uint32_t> known_;  // by text
};

}  // namespace eikon
