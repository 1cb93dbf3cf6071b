// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/geometry/tangents.h"
#include "gltf/geometry/triangles.h"
#include "gltf/materials/variants.h"

namespace eikon {
namespace {

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;
constexpr int kTriangles = 4;  // modes below have no triangles
constexpr std::array<const char*, 4> kModeNames{"POINTS", "LINES", "LINE_LOOP", "LINE_STRIP"};
constexpr std::size_t kUvSets = 2;

std::string mesh_label(const tinygltf::Model& model, std::size_t mesh) {
  return label("mesh", mesh, model.meshes[mesh].name);
}

std::string uv_name(std::size_t set) { return fmt::format("TEXCOORD_{}", set); }

bool uses_extension(const Json& document, std::string_view name) {
  const Json* used = member(document, "extensionsUsed");
  return used != nullptr && std::find(used->begin(), used->end(), name) != used->end();
}

// Which sets of texture coordinates the textures of a material need.
std::array<bool, kUvSets> uv_sets_of(const Material& material) {
  std::array<bool, kUvSets> needed{};
  for (const TextureUse& use : textures_of(material))
    if (use.texture->uv_set < kUvSets) needed[use.texture->uv_set] = true;
  return needed;
}

// The set of texture coordinates that tangents are made from, if the material needs any.
std::optional<std::size_t> tangent_set(const Material& material) {
  for (const auto* texture :
       {&material.normal_texture, &material.clearcoat_normal_texture, &material.anisotropy_texture})
    if (*texture) return (*texture)->uv_set;
  return material.anisotropy > 0 ? std::optional<std::size_t>(0) : std::nullopt;
}

// Bytes per vertex of what may be read, by attribute.
double vertex_bytes(const tinygltf::Primitive& primitive) {
  double bytes = sizeof(glm::vec3);
  for (const auto& [name, size] : {std::pair{"NORMAL", sizeof(glm::vec3)}, std::pair{"TANGENT", sizeof(glm::vec4)},
                                   std::pair{"COLOR_0", sizeof(glm::vec4)}, std::pair{"TEXCOORD_0", sizeof(glm::vec2)},
                                   std::pair{"TEXCOORD_1", sizeof(glm::vec2)}}) {
    if (primitive.attributes.contains(name)) bytes += static_cast<double>(size);
  }
  return bytes;
}

}  // namespace

MeshReader::MeshReader(const tinygltf::Model& model, const Json& document, const std::vector<Accessor>& accessors,
                       const BufferViews& views, const std::vector<Material>& materials,
                       std::function<std::uint32_t(int)> material_of, Notes& notes)
    : model_(model),
      document_(document),
      accessors_(accessors),
      materials_(materials),
      material_of_(std::move(material_of)),
      notes_(notes),
      draco_(views, accessors),
      quantized_(uses_extension(document, "KHR_mesh_quantization")),
      positions_checked_(accessors.size(), false) {}

void MeshReader::check_memory(const std::vector<std::size_t>& meshes) const {
  double bytes = 0;  // a file of a megabyte can share one accessor between any number of primitives
  for (const std::size_t mesh : meshes) {
    for (std::size_t p = 0; p < model_.meshes[mesh].primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = model_.meshes[mesh].primitives[p];
      const auto positions = primitive.attributes.find("POSITION");
      if (positions == primitive.attributes.end() || primitive.mode < kTriangles) continue;
      const auto vertices = static_cast<double>(accessors_[static_cast<std::size_t>(positions->second)].count);
      const Json* indices = member(document_["meshes"][mesh]["primitives"][p], "indices");
      double corners =
          indices == nullptr ? vertices : static_cast<double>(accessors_[indices->get<std::size_t>()].count);
      if (primitive.mode != kTriangles) corners *= 3;
      bytes += corners * sizeof(std::uint32_t) + std::min(corners, vertices) * vertex_bytes(primitive);
    }
  }
  const std::uint64_t memory = physical_memory_bytes();
  if (memory != 0 && bytes > static_cast<double>(memory)) {
    throw InputError(fmt::format("its meshes need {:.1f} GB of memory, this machine has {:.1f} GB; split the scene",
                                 bytes * 1e-9, static_cast<double>(memory) * 1e-9));
  }
}

Mesh MeshReader::read(std::size_t index) {
  const tinygltf::Mesh& source = model_.meshes[index];
  const std::string user = mesh_label(model_, index);
  const Json& json = document_["meshes"][index];
  Mesh mesh;
  mesh.name = source.name;
  if (const Json* extensions = member(json, "extensions")) {
    for (const auto& entry : extensions->items()) notes_.unsupported(one_line(entry.key()), user);
  }
  for (std::size_t p = 0; p < source.primitives.size(); ++p) {
    Source part{.primitive = source.primitives[p],
                .json = json["primitives"][p],
                .user = fmt::format("{}, primitive {}", user, p),
                .draco = {}};
    if (part.primitive.mode < kTriangles) {
      notes_.unsupported(std::string("primitives of mode ") + kModeNames[static_cast<std::size_t>(part.primitive.mode)],
                         user);
      continue;
    }
    note_features(part, user);
    if (!part.primitive.attributes.contains("POSITION")) {
      notes_.warn(part.user + ": left out, it has no POSITION");
      continue;
    }
    if (const Json* extension = draco_member(part.json)) {
      const Place outer{.value = json, .kind = "mesh", .index = static_cast<std::int64_t>(index)};
      const Place middle{
          .value = part.json, .kind = "primitive", .index = static_cast<std::int64_t>(p), .parent = &outer};
      part.draco =
          draco_.decode({.value = *extension, .kind = "KHR_draco_mesh_compression", .parent = &middle}, part.json);
    }
    Primitive read = read_primitive(part);
    if (!read.indices.empty()) mesh.primitives.push_back(std::move(read));
  }
  return mesh;
}

void MeshReader::note_features(const Source& source, const std::string& mesh_label) {
  if (!source.primitive.targets.empty()) notes_.unsupported("morph targets", mesh_label);
  for (const auto& entry : source.primitive.attributes) {
    if (entry.first.starts_with("COLOR_") && entry.first != "COLOR_0")
      notes_.unsupported("vertex colours " + one_line(entry.first), mesh_label);
  }
  if (const Json* extensions = member(source.json, "extensions")) {
    for (const auto& entry : extensions->items()) {
      if (entry.key() != "KHR_draco_mesh_compression" && entry.key() != kVariantsExtension)
        notes_.unsupported(one_line(entry.key()), mesh_label);
    }
  }
}

const Accessor* MeshReader::attribute(const Source& source, const std::string& name) const {
  if (const auto decoded = source.draco.attributes.find(name); decoded != source.draco.attributes.end())
    return &decoded->second;
  const auto found = source.primitive.attributes.find(name);
  return found == source.primitive.attributes.end() ? nullptr : &accessors_[static_cast<std::size_t>(found->second)];
}

Primitive MeshReader::read_primitive(Source& source) {
  const Accessor& positions = *attribute(source, "POSITION");
  check_attribute("POSITION", positions, positions.count, quantized_, source.user);
  check_positions_once(source, positions);

  Primitive result;
  result.indices = read_triangles(source, positions.count);
  const std::vector<std::uint32_t> used = compact(result.indices, positions.count);
  if (result.indices.empty()) return {};
  const VertexChoice vertices{.used = used, .count = used.empty() ? positions.count : used.size()};
  result.positions_object = read_positions(positions, vertices);
  result.material = material_of_(source.primitive.material);
  read_surface(source, vertices, positions.count, result);
  return result;
}

// A Draco stream holds a list of triangles, whatever the mode that it was made from.
std::vector<std::uint32_t> MeshReader::read_triangles(Source& source, std::uint64_t vertex_count) {
  if (!source.draco.attributes.empty()) return std::move(source.draco.indices);
  std::vector<std::uint32_t> corners;
  if (const Json* indices = member(source.json, "indices")) {
    corners = read_indices(accessors_[indices->get<std::size_t>()], vertex_count, source.user);
  } else {
    corners.resize(vertex_count);
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
  }
  const auto mode = static_cast<TriangleMode>(source.primitive.mode);
  const std::size_t count = corners.size(),
                    rest = mode == TriangleMode::list ? count % 3 : (count < 3 ? count : std::size_t{0});
  if (rest != 0) {
    notes_.warn(
        fmt::format("{}: {} corners are no whole number of triangles; the last {} left out", source.user, count, rest));
  }
  return list_triangles(std::move(corners), mode);
}

void MeshReader::read_surface(const Source& source, const VertexChoice& vertices, std::uint64_t position_count,
                              Primitive& primitive) {
  const Material& material = materials_[primitive.material];
  const auto checked = [&](const std::string& name) {
    const Accessor* found = attribute(source, name);
    if (found != nullptr) check_attribute(name, *found, position_count, quantized_, source.user);
    return found;
  };
  if (const Accessor* normals = checked("NORMAL"))
    primitive.normals_object = read_normals(*normals, vertices, source.user, notes_);
  if (const Accessor* colors = checked("COLOR_0"))
    primitive.colors = read_colors(*colors, vertices, source.user, notes_);

  const std::array<bool, kUvSets> needed = uv_sets_of(material);
  for (std::size_t set = 0; set < kUvSets; ++set) {
    const Accessor* uv = checked(uv_name(set));
    const bool shown = set == 0 && uv != nullptr;  // by the layer `uv`
    const bool steers = uv != nullptr && tangent_set(material) == set;
    if (!needed[set] && !shown && !steers) continue;
    if (uv != nullptr) {
      primitive.uv[set] = read_texture_coordinates(*uv, vertices, source.user, notes_);
      continue;
    }
    primitive.uv[set].resize(vertices.count);
    if (!uv_missing_.emplace(primitive.material, set).second) continue;
    notes_.warn(fmt::format("{}: material {} has a texture with {}, which the primitive lacks; taken as 0", source.user,
                            in_quotes(material.name), uv_name(set)));
  }

  const Accessor* tangents = checked("TANGENT");
  const std::optional<std::size_t> set = tangent_set(material);
  if (!set || *set >= kUvSets) return;
  // Without normals of its own a mesh is flat, and tangents that it brings belong to others [glTF 2.0, section 3.7.2.1].
  if (tangents != nullptr && !primitive.normals_object.empty())
    primitive.tangents_object = read_tangents(*tangents, vertices, primitive.normals_object, source.user, notes_);
  if (!primitive.tangents_object.empty()) return;
  if (!primitive.uv[*set].empty()) return make_tangents(primitive, *set);
  notes_.warn(
      fmt::format("{}: material {} is anisotropic, but the primitive has neither TANGENT nor {}; taken as isotropic",
                  source.user, in_quotes(material.name), uv_name(*set)));
}

void MeshReader::check_positions_once(const Source& source, const Accessor& positions) {
  if (!source.draco.attributes.empty()) return check_positions(positions);
  const auto accessor = static_cast<std::size_t>(source.primitive.attributes.at("POSITION"));
  if (!positions_checked_[accessor]) check_positions(positions);
  positions_checked_[accessor] = true;
}

std::vector<std::uint32_t> MeshReader::compact(std::vector<std::uint32_t>& indices, std::uint64_t vertex_count) {
  if (slot_of_vertex_.size() < vertex_count) slot_of_vertex_.resize(vertex_count, kNoSlot);
  std::vector<std::uint32_t> used;
  for (const std::uint32_t vertex : indices) {
    if (slot_of_vertex_[vertex] != kNoSlot) continue;
    slot_of_vertex_[vertex] = static_cast<std::uint32_t>(used.size());
    used.push_back(vertex);
  }
  if (used.size() == vertex_count) {
    // Nothing to leave out: the file's own order stays.
    for (const std::uint32_t vertex : used) slot_of_vertex_[vertex] = kNoSlot;
    return {};
  }
  for (std::uint32_t& index : indices) index = slot_of_vertex_[index];
  for (const std::uint32_t vertex : used) slot_of_vertex_[vertex] = kNoSlot;
  return used;
}

}  // namespace eikon
