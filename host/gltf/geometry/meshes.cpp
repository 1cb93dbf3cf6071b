// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/error.h"
#include "gltf/extensions.h"
#include "gltf/geometry/tangents.h"
#include "gltf/geometry/triangles.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;
constexpr int kTriangles = 4;  // modes below have no triangles
constexpr std::array<const char*, 4> kModeNames{"POINTS", "LINES", "LINE_LOOP", "LINE_STRIP"};
constexpr std::size_t kUvSets = 2;

std::string uv_name(std::size_t set) { return fmt::format("TEXCOORD_{}", set); }

bool uses_extension(const Json& document, std::string_view name) {
  const Json* used = member(document, "extensionsUsed");
  for (std::size_t i = 0; used != nullptr && i < size_of(*used); ++i)
    if (equals(&element(*used, i), name)) return true;
  return false;
}

// The sets of texture coordinates that the textures of a material need.
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

// The bytes per vertex of all attributes that may be read.
double vertex_bytes(const GltfPrimitive& primitive) {
  double bytes = sizeof(glm::vec3);
  for (const auto& [name, size] : {std::pair{"NORMAL", sizeof(glm::vec3)}, std::pair{"TANGENT", sizeof(glm::vec4)},
                                   std::pair{"COLOR_0", sizeof(glm::vec4)}, std::pair{"TEXCOORD_0", sizeof(glm::vec2)},
                                   std::pair{"TEXCOORD_1", sizeof(glm::vec2)}}) {
    if (primitive.attributes.contains(name)) bytes += static_cast<double>(size);
  }
  return bytes;
}

}  // namespace

MeshReader::MeshReader(const Source& source)
    : source_(source),
      draco_(source.views, source.accessors),
      quantized_(uses_extension(source.document.json, "KHR_mesh_quantization")),
      morpher_(source.accessors, source.views.file_bytes(), quantized_, source.notes),
      positions_checked_(source.accessors.size(), false) {}

void MeshReader::check_memory(const std::vector<Wanted>& meshes) const {
  double bytes = 0;  // a file of a megabyte can share one accessor between any number of primitives
  for (const Wanted& wanted : meshes) {
    for (const GltfPrimitive& primitive : source_.document.meshes[wanted.first].primitives) {
      const auto positions = primitive.attributes.find("POSITION");
      if (positions == primitive.attributes.end() || primitive.mode < kTriangles) continue;
      const auto vertices = static_cast<double>(source_.accessors[positions->second].count);
      double corners = primitive.indices ? static_cast<double>(source_.accessors[*primitive.indices].count) : vertices;
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

Mesh MeshReader::read(const Wanted& wanted) {
  const GltfMesh& mesh = source_.document.meshes[wanted.first];
  const std::string user = mesh.view.label();
  Mesh result;
  result.name = mesh.name;
  note_unsupported_extensions(mesh.view.value, ExtensionOwner::mesh, user, source_.notes);
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    const GltfPrimitive& primitive = mesh.primitives[p];
    Part part{.primitive = primitive, .user = fmt::format("{}, primitive {}", user, p), .draco = {}, .morphed = {}};
    if (primitive.mode < kTriangles) {
      source_.notes.unsupported(
          std::string("primitives of mode ") + kModeNames[static_cast<std::size_t>(primitive.mode)], user);
      continue;
    }
    note_features(part, user);
    if (!primitive.attributes.contains("POSITION")) {
      source_.notes.mended(part.user + ": left out, it has no POSITION");
      continue;
    }
    if (const Json* extension = extension_of(primitive.json, kDracoExtension)) {
      const JsonView view{
          .value = primitive.json, .kind = "primitive", .index = static_cast<std::int64_t>(p), .parent = &mesh.view};
      part.draco = draco_.decode({.value = *extension, .kind = kDracoExtension, .parent = &view}, primitive);
    }
    for (const auto& [name, accessor] : primitive.attributes) (void)source_.accessors[accessor];  // none is wrong
    if (!wanted.second.empty()) morph(part, wanted.second);
    Primitive read = read_primitive(part);
    if (!read.indices.empty()) result.primitives.push_back(std::move(read));
  }
  return result;
}

void MeshReader::note_features(const Part& part, const std::string& mesh_label) {
  for (const auto& entry : part.primitive.attributes) {
    if (entry.first.starts_with("COLOR_") && entry.first != "COLOR_0")
      source_.notes.unsupported("vertex colours " + one_line(entry.first), mesh_label);
  }
  note_unsupported_extensions(part.primitive.json, ExtensionOwner::primitive, mesh_label, source_.notes);
}

const Accessor* MeshReader::attribute(const Part& part, const std::string& name) const {
  if (const auto morphed = part.morphed.attributes.find(name); morphed != part.morphed.attributes.end())
    return &morphed->second;
  if (const auto decoded = part.draco.attributes.find(name); decoded != part.draco.attributes.end())
    return &decoded->second;
  const auto found = part.primitive.attributes.find(name);
  return found == part.primitive.attributes.end() ? nullptr : &source_.accessors[found->second];
}

const Accessor* MeshReader::checked_attribute(const Part& part, const std::string& name,
                                              std::uint64_t position_count) const {
  const Accessor* found = attribute(part, name);
  if (found != nullptr) check_attribute(name, *found, position_count, quantized_, part.user);
  return found;
}

Primitive MeshReader::read_primitive(Part& part) {
  const Accessor& positions = *attribute(part, "POSITION");
  check_attribute("POSITION", positions, positions.count, quantized_, part.user);
  check_positions_once(part, positions);

  Primitive result;
  result.indices = read_triangles(part, positions.count);
  const std::vector<std::uint32_t> used = compact(result.indices, positions.count);
  if (result.indices.empty()) return {};
  const VertexChoice vertices{.used = used, .count = used.empty() ? positions.count : used.size()};
  result.positions_object = read_positions(positions, vertices);
  result.material = source_.reader.use(part.primitive.material);
  read_surface(part, vertices, positions.count, result);
  return result;
}

// A Draco stream holds a list of triangles, whatever the mode that it was made from.
std::vector<std::uint32_t> MeshReader::read_triangles(Part& part, std::uint64_t vertex_count) {
  if (!part.draco.attributes.empty()) return std::move(part.draco.indices);
  std::vector<std::uint32_t> corners;
  if (part.primitive.indices) {
    corners = read_indices(source_.accessors[*part.primitive.indices], vertex_count, part.user);
  } else {
    corners.resize(vertex_count);
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
  }
  const auto mode = static_cast<TriangleMode>(part.primitive.mode);
  const std::size_t count = corners.size(),
                    rest = mode == TriangleMode::list ? count % 3 : (count < 3 ? count : std::size_t{0});
  if (rest != 0) {
    source_.notes.warn(
        fmt::format("{}: {} corners are no whole number of triangles; the last {} left out", part.user, count, rest));
  }
  return list_triangles(std::move(corners), mode);
}

void MeshReader::read_surface(const Part& part, const VertexChoice& vertices, std::uint64_t position_count,
                              Primitive& primitive) {
  const Material& material = source_.materials[primitive.material];
  if (const Accessor* normals = checked_attribute(part, "NORMAL", position_count))
    primitive.normals_object = read_normals(*normals, vertices, primitive, part.user, source_.notes);
  if (const Accessor* colors = checked_attribute(part, "COLOR_0", position_count))
    primitive.colors = read_colors(*colors, vertices, part.user, source_.notes);
  read_uv(part, vertices, position_count, primitive);

  const Accessor* tangents = checked_attribute(part, "TANGENT", position_count);
  const std::optional<std::size_t> set = tangent_set(material);
  if (!set || *set >= kUvSets) return;
  // A mesh without normals of its own is flat, and tangents that it brings belong to others [glTF
  // 2.0, section 3.7.2.1].
  if (tangents != nullptr && !primitive.normals_object.empty())
    primitive.tangents_object = read_tangents(*tangents, vertices, primitive.normals_object, part.user, source_.notes);
  if (!primitive.tangents_object.empty()) return;
  if (!primitive.uv[*set].empty()) return make_tangents(primitive, *set);
  source_.notes.warn(
      fmt::format("{}: material {} is anisotropic, but the primitive has neither TANGENT nor {}; taken as isotropic",
                  part.user, in_quotes(material.name), uv_name(*set)));
}

// Set 0 is read even if no texture needs it, because the layer `uv` shows it; so is the set that
// tangents are made from.
void MeshReader::read_uv(const Part& part, const VertexChoice& vertices, std::uint64_t position_count,
                         Primitive& primitive) {
  const Material& material = source_.materials[primitive.material];
  const std::array<bool, kUvSets> needed = uv_sets_of(material);
  for (std::size_t set = 0; set < kUvSets; ++set) {
    const Accessor* uv = checked_attribute(part, uv_name(set), position_count);
    if (uv != nullptr) {
      if (needed[set] || set == 0 || tangent_set(material) == set)
        primitive.uv[set] = read_texture_coordinates(*uv, vertices, part.user, source_.notes);
      continue;
    }
    if (!needed[set]) continue;
    primitive.uv[set].resize(vertices.count);
    if (!uv_missing_.emplace(primitive.material, set).second) continue;
    source_.notes.warn(fmt::format("{}: material {} has a texture with {}, which the primitive lacks; taken as 0",
                                   part.user, in_quotes(material.name), uv_name(set)));
  }
}

void MeshReader::check_positions_once(const Part& part, const Accessor& positions) {
  const std::size_t accessor = part.primitive.attributes.at("POSITION");
  if (&positions != &source_.accessors[accessor]) return check_positions(positions);
  if (!positions_checked_[accessor]) check_positions(positions);
  positions_checked_[accessor] = true;
}

void MeshReader::morph(Part& part, const std::vector<double>& weights) const {
  const std::uint64_t position_count = attribute(part, "POSITION")->count;
  std::map<std::string, const Accessor*> base;
  for (const auto& entry : part.primitive.attributes)
    if (Morpher::reads(entry.first)) base[entry.first] = checked_attribute(part, entry.first, position_count);
  part.morphed = morpher_.apply(part.primitive, weights, base, part.user);
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
    // There is nothing to leave out, so the file's own order stays.
    for (const std::uint32_t vertex : used) slot_of_vertex_[vertex] = kNoSlot;
    return {};
  }
  for (std::uint32_t& index : indices) index = slot_of_vertex_[index];
  for (const std::uint32_t vertex : used) slot_of_vertex_[vertex] = kNoSlot;
  return used;
}

}  // namespace eikon
