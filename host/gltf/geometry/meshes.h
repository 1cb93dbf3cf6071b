// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "gltf/geometry/attributes.h"
#include "gltf/document/document.h"
#include "gltf/geometry/draco_mesh.h"
#include "gltf/geometry/morph.h"
#include "gltf/geometry/triangles.h"
#include "gltf/materials/materials.h"
#include "gltf/skin/skins.h"
#include "scene/notes.h"
#include "scene/scene_memory.h"

namespace eikon {

/// Reads the triangles of meshes. Several primitives may share accessors; each gets only the
/// vertices it uses, so every position of a Primitive belongs to one of its triangles. Where all
/// their accessors are the same, they are read once. Degenerate triangles stay, because rays never
/// hit them.
class MeshReader {
 public:
  /// Everything outlives the reader.
  struct Source {
    const Document& document;
    const AccessorTable& accessors;
    const BufferViews& views;
    const std::vector<Material>& materials;  // those of `reader`'s scene
    MaterialReader& reader;
    SkinReader& skins;
    Notes& notes;
    MissingTangents missing_tangents = MissingTangents::make;
    SceneMemory* memory = nullptr;  // has, and gets, what no pose changes; null: nothing is kept
  };
  explicit MeshReader(const Source& source);

  /// A mesh of the document at a pose.
  struct Wanted {
    std::size_t mesh = 0;
    std::vector<double> weights{};       // of its morph targets; empty: none is in force
    std::optional<std::size_t> skin{};
    auto operator<=>(const Wanted&) const = default;
  };

  /// Looks at what the file announces, before anything of it is unpacked but by meshoptimizer.
  /// throws InputError when the meshes need more memory than there is
  void check_memory(const std::vector<Wanted>& meshes) const;

  /// The triangles of a mesh; primitives without any are left out. Texture
  /// coordinates and tangents are read or made only where the primitive's material asks for them.
  /// throws InputError: positions that are not finite or beyond kMaxCoordinate, indices out of
  /// range, types that do not fit, compressed data that do not decode
  Mesh read(const Wanted& wanted);

  /// The compressed data that were read until now.
  [[nodiscard]] CompressedMeshes compressed() const;

 private:
  /// A primitive while it is read.
  struct Part {
    const GltfPrimitive& primitive;
    PrimitiveAtRest place;
    std::string user;  // "mesh 'box', primitive 2"
    DracoMesh draco;     // empty if it is not compressed
    OwnAttributes posed;  // in place of the file's; empty if nothing moves it
    std::vector<bool> mirrored;  // by vertex of the file: its joints mirror it; empty if those of none do
    std::shared_ptr<const Connections> connections;
  };
  /// Equal for primitives of the same geometry, if their triangles are neither compressed nor
  /// posed.
  using Contents = decltype(Accessor().contents());
  using Accessors = std::tuple<int, std::optional<Contents>, std::map<std::string, Contents>>;
  static constexpr std::size_t kUvSets = 2;
  static MaterialNeeds needs_of(const Material& material);

  /// A primitive that was read for another pose of the file.
  [[nodiscard]] std::optional<Primitive> find_kept(const Wanted& wanted, std::size_t primitive);
  void keep(const Wanted& wanted, std::size_t primitive, const Primitive& read);
  Primitive read_primitive(Part& part);
  /// A primitive that was read before from the same accessors, but for its material.
  [[nodiscard]] std::optional<Primitive> find_known(const Part& part, std::uint32_t material) const;
  void remember(const Part& part, const Primitive& read);
  [[nodiscard]] Accessors accessors_of(const Part& part) const;
  void note_features(const Part& part, const std::string& mesh_label);
  [[nodiscard]] const Accessor* attribute(const Part& part, const std::string& name) const;
  [[nodiscard]] const Accessor* checked_attribute(const Part& part, const std::string& name,
                                                  std::uint64_t position_count) const;
  /// Those of another pose of the file, if they were read before.
  [[nodiscard]] std::shared_ptr<const Connections> connections_of(Part& part, std::uint64_t vertex_count);
  [[nodiscard]] TriangleIndices read_indices(Part& part, std::uint64_t vertex_count);
  void read_surface(const Part& part, const VertexChoice& vertices, std::uint64_t position_count, Primitive& primitive);
  void read_or_make_tangents(const Part& part, const VertexChoice& vertices, std::uint64_t position_count,
                             Primitive& primitive);
  /// Positions, normals and triangles of a posed primitive as they are in the file.
  [[nodiscard]] Primitive at_rest(const Part& part, const VertexChoice& vertices, const Primitive& posed) const;
  void read_uv(const Part& part, const VertexChoice& vertices, std::uint64_t position_count, Primitive& primitive);
  void check_positions_once(const Part& part, const Accessor& positions);
  /// Adds the morph targets, and then lets the vertices follow their joints. Returns whether the
  /// primitive stays.
  bool pose(Part& part, const Wanted& wanted);
  void morph(Part& part, const std::vector<double>& weights) const;
  void follow_joints(Part& part, const Skin& skin) const;
  /// The triangles of a primitive; those of which most corners are mirrored have two of their
  /// corners exchanged, so that their fronts stay in front.
  static TriangleIndices facing(const Connections& connections, const std::vector<bool>& mirrored);

  Source source_;
  DracoDecoder draco_;
  bool quantized_ = false;                                      // the document uses KHR_mesh_quantization
  Morpher morpher_;
  std::vector<bool> positions_checked_;                         // per accessor
  VertexCompactor compact_;
  std::map<Accessors, std::vector<std::pair<MaterialNeeds, Primitive>>> known_;
  std::set<std::pair<std::uint32_t, std::size_t>> uv_missing_;  // material and set, each said once
};

}  // namespace eikon
