// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include "scene/accessor_table.h"
#include "scene/document.h"
#include "scene/text.h"

namespace eikon {

/// The largest coordinate that a scene may have, in metres; squares and cubes of it stay far from overflow.
inline constexpr double kMaxCoordinate = 1099511627776.0;  // 2^40

/// Reads the triangles of meshes. Several primitives may share accessors; each gets only the vertices it uses, so every
/// position of a Primitive belongs to one of its triangles. Degenerate triangles stay: renderers never hit them.
class MeshReader {
 public:
  /// `material_of` gives the index in Scene::materials for a primitive's material (-1: none); called once per
  /// primitive. All arguments outlive the reader.
  MeshReader(const tinygltf::Model& model, const Json& document, const std::vector<Accessor>& accessors,
             std::function<std::uint32_t(int)> material_of, Notes& notes);

  /// throws InputError when the meshes need more memory than this machine has
  void check_memory(const std::vector<std::size_t>& meshes) const;

  /// Triangles of mesh `index` of the document; primitives without any are left out.
  /// throws InputError: positions that are not finite or beyond kMaxCoordinate, indices out of range, types that do not
  /// fit
  Mesh read(std::size_t index);

 private:
  Primitive read_primitive(std::size_t mesh, std::size_t primitive);
  std::vector<std::uint32_t> read_indices(const Accessor& indices, std::uint64_t vertex_count,
                                          const std::string& user) const;
  void check_positions(std::size_t accessor);
  /// Renumbers `indices` to the vertices they use; returns those, or nothing when they use all of them.
  std::vector<std::uint32_t> compact(std::vector<std::uint32_t>& indices, std::uint64_t vertex_count);
  [[nodiscard]] std::vector<glm::vec3> read_normals(const Accessor& normals, const std::vector<std::uint32_t>& used,
                                                    std::size_t vertex_count, const std::string& user) const;
  [[nodiscard]] const Json* indices_member(std::size_t mesh, std::size_t primitive) const;

  const tinygltf::Model& model_;
  const Json& document_;
  const std::vector<Accessor>& accessors_;
  std::function<std::uint32_t(int)> material_of_;
  Notes& notes_;
  std::vector<bool> positions_checked_;        // per accessor
  std::vector<std::uint32_t> slot_of_vertex_;  // scratch of compact(); all kNoSlot between calls
};

}  // namespace eikon
