// SPDX-License-Identifier: Apache-2.0
// Surfaces by a formula: EIKON_implicit_surface.
#pragma once
#include <map>
#include <string>

#include "gltf/document/node_graph.h"
#include "gltf/materials/materials.h"
#include "io/json_text.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

inline constexpr const char* kImplicitExtension = "EIKON_implicit_surface";

/// Reads the surfaces by formula that nodes place.
class ImplicitSurfaceReader {
 public:
  /// The arguments outlive the reader.
  ImplicitSurfaceReader(const Json& document, MaterialReader& materials, Scene& scene, Notes& notes)
      : document_(document), materials_(materials), scene_(scene), notes_(notes) {}

  /// Appends the surface that a node places, if it places one: where f is 0 within the bounds
  /// (least x, y, z, then the largest; in the node's space). Where f > 0 is outside.
  /// throws InputError: a formula that is missing, does not parse, or has more than
  /// kMaxFormulaNodes with those before it; bounds that are missing, empty, or beyond 2^40
  void add(const PlacedNode& placed);

 private:
  std::uint32_t formula(const JsonView& view);

  const Json& document_;
  MaterialReader& materials_;
  Scene& scene_;
  Notes& notes_;
  std::map<std::string, std::uint32_t> known_;  // by text
  std::size_t node_count_ = 0;                  // of all formulas
};

}  // namespace eikon
