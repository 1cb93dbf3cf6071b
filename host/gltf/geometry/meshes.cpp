// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/error.h"
#include "gltf/extensions.h"
#include "gltf/geometry/tangents.h"
#include "gltf/geometry/triangles.h"
#include "gltf/skin/skinning.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr int kTriangles = 4;  // modes below have no triangles
constexpr std::array<const char*, 4> kModeNames{"POINTS", "LINES", "LINE_LOOP", "LINE_STRIP"};

std::string uv_name(std::size_t set) { return fmt::format("TEXCOORD_{}", set); }

bool uses_extension(const Json& document, std::string_view name) {
  const Json* used = member(document, "extensionsUsed");
  for (std::size_t i = 0; used != nullptr && i < size_of(*used); ++i)
    if (equals(&element(*used, i), name)) return true;
  return false;
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

/// No morph target and no joint moves its vertices.
bool is_at_rest(const MeshReader::Wanted& wanted) { return wanted.weights.empty() && !wanted.skin; }

}  // namespace

MaterialNeeds MeshReader::needs_of(const Material& material) {
  MaterialNeeds needs;
  for (const TextureUse& use : textures_of(material))
    if (use.texture->uv_set < kUvSets) needs.uv[use.texture->uv_set] = true;
  for (const auto* texture :
       {&material.normal_texture, &material.clearcoat_normal_texture, &material.anisotropy_texture})
    if (*texture && !needs.tangents) {
      const auto& [u, v] = (*texture)->image_from_uv;
      needs.tangents = (*texture)->uv_set;
      if (u.x * v.y != u.y * v.x) needs.tangents_from_uv = {u.x, u.y, v.x, v.y};
    }
  if (material.anisotropy > 0 && !needs.tangents) needs.tangents = 0;
  return needs;
}

MeshReader::MeshReader(const Source& source)
    : source_(source),
      draco_(source.views, source.accessors),
      quantized_(uses_extension(source.document.json, "KHR_mesh_quantization")),
      morpher_(source.accessors, source.views.file_bytes(), quantized_, source.notes),
      positions_checked_(source.accessors.size(), false) {}

void MeshReader::check_memory(const std::vector<Wanted>& meshes) const {
  // A file of a megabyte can share one accessor between any number of primitives. Devices have the
  // triangles of each, in records that are larger than what is counted here.
  double bytes = 0, decoder_bytes = 0;
  for (const Wanted& wanted : meshes) {
    for (const GltfPrimitive& primitive : source_.document.meshes[wanted.mesh].primitives) {
      const auto positions = primitive.attributes.find("POSITION");
      if (positions == primitive.attributes.end() || primitive.mode < kTriangles) continue;
      const auto vertices = static_cast<double>(source_.accessors[positions->second].count);
      double corners = primitive.indices ? static_cast<double>(source_.accessors[*primitive.indices].count) : vertices;
      if (primitive.mode != kTriangles) corners *= 3;
      bytes += corners * sizeof(std::uint32_t) + std::min(corners, vertices) * vertex_bytes(primitive);
      if (const Json* draco = extension_of(primitive.json, kDracoExtension))
        decoder_bytes = std::max(decoder_bytes, draco_.expected_bytes(*draco, primitive));
    }
  }
  bytes += decoder_bytes + static_cast<double>(source_.views.decompressed_bytes());
  const std::uint64_t memory = usable_memory_bytes();
  if (memory != 0 && bytes > static_cast<double>(memory)) {
    throw InputError(fmt::format("its meshes need {:.1f} GB of memory{}, there are {:.1f} GB; split the scene",
                                 bytes * 1e-9, decoder_bytes > 0 ? " while they are unpacked" : "",
                                 static_cast<double>(memory) * 1e-9));
  }
}

CompressedMeshes MeshReader::compressed() const {
  CompressedMeshes all = draco_.decoded();
  all.file_bytes += source_.views.compressed_bytes();
  all.unpacked_bytes += source_.views.decompressed_bytes();
  return all;
}

Mesh MeshReader::read(const Wanted& wanted) {
  const GltfMesh& mesh = source_.document.meshes[wanted.mesh];
  const std::string user = mesh.view.label();
  Mesh result;
  result.name = mesh.name;
  note_unsupported_extensions(mesh.view.value, ExtensionOwner::mesh, user, source_.notes);
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    const GltfPrimitive& primitive = mesh.primitives[p];
    Part part{.primitive = primitive,
              .place = {wanted.mesh, p},
              .user = fmt::format("{}, primitive {}", user, p),
              .draco = {},
              .posed = {},
              .mirrored = {},
              .connections = {}};
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
    if (std::optional<Primitive> kept = find_kept(wanted, p)) {
      result.primitives.push_back(*std::move(kept));
      continue;
    }
    const std::size_t warnings = source_.notes.warning_count();
    if (const Json* extension = extension_of(primitive.json, kDracoExtension)) {
      const JsonView view{
          .value = primitive.json, .kind = "primitive", .index = static_cast<std::int64_t>(p), .parent = &mesh.view};
      part.draco = draco_.decode({.value = *extension, .kind = kDracoExtension, .parent = &view}, primitive);
    }
    for (const auto& [name, accessor] : primitive.attributes) (void)source_.accessors[accessor];  // none is wrong
    if (!pose(part, wanted)) continue;
    Primitive read = read_primitive(part);
    if (read.indices.empty()) continue;
    // A primitive with a warning is read again, so that every pose has the warning.
    if (source_.notes.warning_count() == warnings) keep(wanted, p, read);
    result.primitives.push_back(std::move(read));
  }
  return result;
}

std::optional<Primitive> MeshReader::find_kept(const Wanted& wanted, std::size_t primitive) {
  const PrimitiveAtRest which{wanted.mesh, primitive};
  if (source_.memory == nullptr || !is_at_rest(wanted) || !source_.memory->has_primitive(which)) return std::nullopt;
  const std::uint32_t material =
      source_.reader.use(source_.document.meshes[wanted.mesh].primitives[primitive].material);
  std::optional<Primitive> kept = source_.memory->primitive(which, needs_of(source_.materials[material]));
  if (kept) kept->material = material;
  return kept;
}

void MeshReader::keep(const Wanted& wanted, std::size_t primitive, const Primitive& read) {
  if (source_.memory == nullptr || !is_at_rest(wanted)) return;
  const MaterialNeeds needs = needs_of(source_.materials[read.material]);
  if (needs.tangents && source_.missing_tangents == MissingTangents::mark) return;  // they are of no use to others
  source_.memory->keep_primitive({wanted.mesh, primitive}, needs, read);
}

void MeshReader::note_features(const Part& part, const std::string& mesh_label) {
  for (const auto& entry : part.primitive.attributes) {
    if (entry.first.starts_with("COLOR_") && entry.first != "COLOR_0")
      source_.notes.unsupported("vertex colours " + one_line(entry.first), mesh_label);
  }
  note_unsupported_extensions(part.primitive.json, ExtensionOwner::primitive, mesh_label, source_.notes);
}

const Accessor* MeshReader::attribute(const Part& part, const std::string& name) const {
  if (const auto posed = part.posed.attributes.find(name); posed != part.posed.attributes.end()) return &posed->second;
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
  if (known_.contains(accessors_of(part))) {
    const std::uint32_t material = source_.reader.use(part.primitive.material);
    if (std::optional<Primitive> known = find_known(part, material)) return *std::move(known);
  }

  Primitive result;
  std::size_t warnings = source_.notes.warning_count();
  part.connections = connections_of(part, positions.count);
  result.indices = facing(*part.connections, part.mirrored);
  if (result.indices.empty()) return {};
  const std::vector<std::uint32_t>& used = part.connections->used;
  const VertexChoice vertices{.used = used, .count = used.empty() ? positions.count : used.size()};
  result.positions_object = read_positions(positions, vertices);
  warnings = source_.notes.warning_count() - warnings;
  result.material = source_.reader.use(part.primitive.material);
  const std::size_t before = source_.notes.warning_count();
  read_surface(part, vertices, positions.count, result);
  // A warning names its primitive, so another one has to be read for its own.
  if (warnings == 0 && source_.notes.warning_count() == before) remember(part, result);
  return result;
}

MeshReader::Accessors MeshReader::accessors_of(const Part& part) const {
  const GltfPrimitive& primitive = part.primitive;
  std::map<std::string, Contents> attributes;
  for (const auto& [name, accessor] : primitive.attributes) attributes[name] = source_.accessors[accessor].contents();
  std::optional<Contents> indices;
  if (primitive.indices) indices = source_.accessors[*primitive.indices].contents();
  return {primitive.mode, indices, std::move(attributes)};
}

std::optional<Primitive> MeshReader::find_known(const Part& part, std::uint32_t material) const {
  if (!part.draco.attributes.empty() || !part.posed.attributes.empty()) return std::nullopt;
  const MaterialNeeds needs = needs_of(source_.materials[material]);
  for (const auto& [of, known] : known_.at(accessors_of(part))) {
    if (of != needs) continue;
    Primitive result = known;
    result.material = material;
    return result;
  }
  return std::nullopt;
}

void MeshReader::remember(const Part& part, const Primitive& read) {
  if (!part.draco.attributes.empty() || !part.posed.attributes.empty()) return;
  const MaterialNeeds needs = needs_of(source_.materials[read.material]);
  // That a set is missing is said once for each material.
  for (std::size_t set = 0; set < kUvSets; ++set)
    if (needs.uv[set] && !part.primitive.attributes.contains(uv_name(set))) return;
  known_[accessors_of(part)].emplace_back(needs, read);
}

std::shared_ptr<const Connections> MeshReader::connections_of(Part& part, std::uint64_t vertex_count) {
  const bool is_shared = source_.memory != nullptr && part.draco.attributes.empty() && !part.posed.attributes.empty();
  if (is_shared)
    if (auto known = source_.memory->connections(part.place)) return known;
  const std::size_t warnings = source_.notes.warning_count();
  auto read = std::make_shared<Connections>();
  read->indices = read_indices(part, vertex_count);
  read->used = compact_.renumber(read->indices, vertex_count);
  // With a warning they are read again, so that every pose has it.
  if (is_shared && source_.notes.warning_count() == warnings) source_.memory->keep_connections(part.place, read);
  return read;
}

// A Draco stream holds a list of triangles, whatever the mode that it was made from.
TriangleIndices MeshReader::read_indices(Part& part, std::uint64_t vertex_count) {
  if (!part.draco.attributes.empty()) return std::move(part.draco.indices);
  const Accessor* indices = nullptr;
  if (part.primitive.indices) {
    indices = &source_.accessors[*part.primitive.indices];
    check_indices(*indices, vertex_count, part.user);
  }
  const auto mode = static_cast<TriangleMode>(part.primitive.mode);
  const std::uint64_t count = indices != nullptr ? indices->count : vertex_count,
                      rest = mode == TriangleMode::list ? count % 3 : (count < 3 ? count : std::uint64_t{0});
  if (rest != 0) {
    source_.notes.warn(
        fmt::format("{}: {} corners are no whole number of triangles; the last {} left out", part.user, count, rest));
  }
  return read_triangles(indices, mode, vertex_count);
}

void MeshReader::read_surface(const Part& part, const VertexChoice& vertices, std::uint64_t position_count,
                              Primitive& primitive) {
  if (const Accessor* normals = checked_attribute(part, "NORMAL", position_count))
    primitive.normals_object = read_normals(*normals, vertices, primitive, part.user, source_.notes);
  if (const Accessor* colors = checked_attribute(part, "COLOR_0", position_count))
    primitive.colors = read_colors(*colors, vertices, part.user, source_.notes);
  read_uv(part, vertices, position_count, primitive);
  read_or_make_tangents(part, vertices, position_count, primitive);
}

void MeshReader::read_or_make_tangents(const Part& part, const VertexChoice& vertices, std::uint64_t position_count,
                                       Primitive& primitive) {
  const Accessor* tangents = checked_attribute(part, "TANGENT", position_count);
  const Material& material = source_.materials[primitive.material];
  const MaterialNeeds needs = needs_of(material);
  const std::optional<std::size_t> set = needs.tangents;
  if (!set || *set >= kUvSets) return;
  // A mesh without normals of its own is flat, and tangents that it brings belong to others [glTF
  // 2.0, section 3.7.2.1].
  if (tangents != nullptr && !primitive.normals_object.empty())
    primitive.tangents_object = read_tangents(*tangents, vertices, primitive.normals_object, part.user, source_.notes);
  if (!primitive.tangents_object.empty()) return;
  if (!primitive.uv[*set].empty()) {
    if (source_.missing_tangents == MissingTangents::mark) return mark_tangents(primitive);
    const TangentSource source{*set, needs.tangents_from_uv};
    if (part.posed.attributes.empty()) return make_tangents(primitive, source);
    const Primitive rest = at_rest(part, vertices, primitive);
    return make_tangents(primitive, source, &rest);
  }
  source_.notes.warn(
      fmt::format("{}: material {} is anisotropic, but the primitive has neither TANGENT nor {}; taken as isotropic",
                  part.user, in_quotes(material.name), uv_name(*set)));
}

Primitive MeshReader::at_rest(const Part& part, const VertexChoice& vertices, const Primitive& posed) const {
  const auto attribute_at_rest = [&](const char* name) -> const Accessor& {
    const auto decoded = part.draco.attributes.find(name);
    return decoded != part.draco.attributes.end() ? decoded->second
                                                  : source_.accessors[part.primitive.attributes.at(name)];
  };
  Primitive rest;
  rest.indices = part.connections->indices;
  rest.positions_object = read_positions(attribute_at_rest("POSITION"), vertices);
  if (posed.normals_object.empty()) return rest;  // it is flat
  Notes said_of_the_pose;
  rest.normals_object = read_normals(attribute_at_rest("NORMAL"), vertices, rest, part.user, said_of_the_pose);
  if (rest.normals_object.empty()) rest.normals_object.resize(rest.positions_object.size());
  return rest;
}

// Set 0 is read even if no texture needs it, because the layer `uv` shows it; so is the set that
// tangents are made from.
void MeshReader::read_uv(const Part& part, const VertexChoice& vertices, std::uint64_t position_count,
                         Primitive& primitive) {
  const Material& material = source_.materials[primitive.material];
  const MaterialNeeds needs = needs_of(material);
  for (std::size_t set = 0; set < kUvSets; ++set) {
    const Accessor* uv = checked_attribute(part, uv_name(set), position_count);
    if (uv != nullptr) {
      if (needs.uv[set] || set == 0 || needs.tangents == set)
        primitive.uv[set] = read_texture_coordinates(*uv, vertices, part.user, source_.notes);
      continue;
    }
    if (!needs.uv[set]) continue;
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

bool MeshReader::pose(Part& part, const Wanted& wanted) {
  if (!wanted.weights.empty()) morph(part, wanted.weights);
  if (!wanted.skin) return true;
  if (!part.primitive.attributes.contains("JOINTS_0")) {
    source_.notes.mended(part.user + ": left out, it has no JOINTS_0 for the skin of its node");
    return false;
  }
  follow_joints(part, source_.skins[*wanted.skin]);
  return true;
}

void MeshReader::follow_joints(Part& part, const Skin& skin) const {
  const std::uint64_t position_count = attribute(part, "POSITION")->count;
  std::map<std::string, const Accessor*> attributes;
  for (const auto& entry : part.primitive.attributes)
    if (is_for_skins(entry.first)) attributes[entry.first] = checked_attribute(part, entry.first, position_count);
  SkinnedVertices moved = skin_vertices(skin, attributes, part.user, source_.notes);
  for (auto& [name, accessor] : moved.own.attributes) part.posed.attributes.insert_or_assign(name, std::move(accessor));
  for (Bytes& bytes : moved.own.storage) part.posed.storage.push_back(std::move(bytes));
  part.mirrored = std::move(moved.mirrored);
}

TriangleIndices MeshReader::facing(const Connections& connections, const std::vector<bool>& mirrored) {
  if (mirrored.empty()) return connections.indices;
  std::vector<std::uint32_t> list = connections.indices.list();
  const auto mirrors = [&](std::uint32_t slot) {
    return mirrored[connections.used.empty() ? slot : connections.used[slot]] ? 1 : 0;
  };
  for (std::size_t i = 0; i + 2 < list.size(); i += 3)
    if (mirrors(list[i]) + mirrors(list[i + 1]) + mirrors(list[i + 2]) >= 2) std::swap(list[i + 1], list[i + 2]);
  return {std::move(list)};
}

void MeshReader::morph(Part& part, const std::vector<double>& weights) const {
  const std::uint64_t position_count = attribute(part, "POSITION")->count;
  std::map<std::string, const Accessor*> base;
  for (const auto& entry : part.primitive.attributes)
    if (Morpher::reads(entry.first)) base[entry.first] = checked_attribute(part, entry.first, position_count);
  part.posed = morpher_.apply(part.primitive, weights, base, part.user);
}

}  // namespace eikon
