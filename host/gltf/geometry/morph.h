// SPDX-License-Identifier: Apache-2.0
// Morph targets: differences that weights add to the attributes of a mesh. Animations have set the
// weights.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "gltf/document/document.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

/// Attributes by glTF's names, and the bytes that they are read from.
struct OwnAttributes {
  std::map<std::string, Accessor> attributes;
  std::vector<Bytes> storage;
};

/// The weights at which `mesh` stands under `node`: the node's count before the mesh's [glTF 2.0,
/// section 3.7.2.2]. Empty if they change nothing.
/// throws InputError: other than one for each target of each primitive
std::vector<double> morph_weights(const GltfNode& node, const GltfMesh& mesh, Notes& notes);

/// Lists the meshes with morph targets.
[[nodiscard]] std::vector<MorphSummary> list_morphs(const Document& document);

/// Adds the targets of a primitive to its attributes.
class Morpher {
 public:
  /// The arguments outlive the morpher. `quantized`: as check_attribute has it
  Morpher(const AccessorTable& accessors, std::uint64_t file_bytes, bool quantized, Notes& notes)
      : accessors_(accessors), file_bytes_(file_bytes), quantized_(quantized), notes_(notes) {}

  /// True for the name of an attribute that targets may change.
  [[nodiscard]] static bool reads(const std::string& name);

  /// Returns those of the checked attributes `base` that the targets change, as floats.
  /// throws InputError naming `user`: types or counts that do not fit, targets that name more
  ///        elements than the file holds
  [[nodiscard]] OwnAttributes apply(const GltfPrimitive& primitive, const std::vector<double>& weights,
                                    const std::map<std::string, const Accessor*>& base, const std::string& user) const;

 private:
  struct Target {
    const Accessor& differences;
    double weight;
    std::uint64_t next_sparse = 0;  // where the next block goes on
  };
  [[nodiscard]] std::vector<Target> targets_of(const GltfPrimitive& primitive, const std::vector<double>& weights,
                                               const std::string& name) const;
  void check_target(const std::string& name, const Accessor& target, const Accessor& base,
                    const std::string& user) const;
  static void add(Target& target, std::uint64_t first, std::vector<glm::dvec4>& sums);
  static Accessor sum(const Accessor& base, std::vector<Target> targets, Bytes& storage);

  const AccessorTable& accessors_;
  std::uint64_t file_bytes_;
  bool quantized_;
  Notes& notes_;
};

}  // namespace eikon
