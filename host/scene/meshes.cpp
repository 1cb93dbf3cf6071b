// SPDX-License-Identifier: Apache-2.0
#include "scene/meshes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace eikon {
namespace {

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;
constexpr int kTriangles = 4;
constexpr std::array<const char*, 7> kModeNames{"POINTS",    "LINES",          "LINE_LOOP",   "LINE_STRIP",
                                                "TRIANGLES", "TRIANGLE_STRIP", "TRIANGLE_FAN"};

std::string mesh_label(const tinygltf::Model& model, std::size_t mesh) {
  return label("mesh", mesh, model.meshes[mesh].name);
}

std::string primitive_label(const tinygltf::Model& model, std::size_t mesh, std::size_t primitive) {
  return fmt::format("{}, primitive {}", mesh_label(model, mesh), primitive);
}

// Index of the accessor of an attribute, or -1.
int attribute(const tinygltf::Primitive& primitive, const char* name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

std::uint32_t restart_value(ComponentType type) {
  switch (type) {
    case ComponentType::u8:
      return 0xFFU;
    case ComponentType::u16:
      return 0xFFFFU;
    default:
      return 0xFFFFFFFFU;
  }
}

}  // namespace

MeshReader::MeshReader(const tinygltf::Model& model, const Json& document, const std::vector<Accessor>& accessors,
                       std::function<std::uint32_t(int)> material_of, Notes& notes)
    : model_(model),
      document_(document),
      accessors_(accessors),
      material_of_(std::move(material_of)),
      notes_(notes),
      positions_checked_(accessors.size(), false) {}

const Json* MeshReader::indices_member(std::size_t mesh, std::size_t primitive) const {
  return member(document_["meshes"][mesh]["primitives"][primitive], "indices");
}

void MeshReader::check_memory(const std::vector<std::size_t>& meshes) const {
  double bytes = 0;  // a file of a megabyte can share one accessor between any number of primitives
  for (const std::size_t mesh : meshes) {
    for (std::size_t p = 0; p < model_.meshes[mesh].primitives.size(); ++p) {
      const int positions = attribute(model_.meshes[mesh].primitives[p], "POSITION");
      if (positions < 0) continue;
      const auto vertices = static_cast<double>(accessors_[static_cast<std::size_t>(positions)].count);
      const Json* indices = indices_member(mesh, p);
      const double corners =
          indices == nullptr ? vertices : static_cast<double>(accessors_[indices->get<std::size_t>()].count);
      bytes += corners * sizeof(std::uint32_t) + std::min(corners, vertices) * 2 * sizeof(glm::vec3);
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
  Mesh mesh;
  mesh.name = source.name;
  if (const Json* extensions = member(document_["meshes"][index], "extensions")) {
    for (const auto& entry : extensions->items()) notes_.unsupported(one_line(entry.key()), user);
  }
  for (std::size_t p = 0; p < source.primitives.size(); ++p) {
    const tinygltf::Primitive& primitive = source.primitives[p];
    if (primitive.mode != kTriangles) {
      notes_.unsupported(std::string("primitives of mode ") + kModeNames[static_cast<std::size_t>(primitive.mode)],
                         user);
      continue;
    }
    if (!primitive.targets.empty()) notes_.unsupported("morph targets", user);
    for (const auto& entry : primitive.attributes) {
      if (entry.first.starts_with("COLOR_")) notes_.unsupported("vertex colours " + one_line(entry.first), user);
    }
    if (const Json* extensions = member(document_["meshes"][index]["primitives"][p], "extensions")) {
      for (const auto& entry : extensions->items()) notes_.unsupported(one_line(entry.key()), user);
    }
    Primitive read = read_primitive(index, p);
    if (read.indices.empty()) continue;
    read.material = material_of_(primitive.material);
    mesh.primitives.push_back(std::move(read));
  }
  return mesh;
}

Primitive MeshReader::read_primitive(std::size_t mesh, std::size_t primitive) {
  const tinygltf::Primitive& source = model_.meshes[mesh].primitives[primitive];
  const std::string user = primitive_label(model_, mesh, primitive);
  Primitive result;
  const int position_index = attribute(source, "POSITION");
  if (position_index < 0) {
    notes_.warn(user + ": left out, it has no POSITION");
    return result;
  }
  const Accessor& positions = accessors_[static_cast<std::size_t>(position_index)];
  if (!positions.is(ComponentType::f32, 3)) {
    throw InputError(
        fmt::format("{}: POSITION in {} is not VEC3 of float (5126); quantised meshes have to be expanded first", user,
                    positions.label));
  }
  check_positions(static_cast<std::size_t>(position_index));

  std::uint64_t vertex_count = positions.count;
  if (const Json* indices = indices_member(mesh, primitive)) {
    result.indices = read_indices(accessors_[indices->get<std::size_t>()], vertex_count, user);
  } else {
    result.indices.resize(vertex_count);
    for (std::size_t i = 0; i < result.indices.size(); ++i) result.indices[i] = static_cast<std::uint32_t>(i);
  }
  if (const std::size_t rest = result.indices.size() % 3; rest != 0) {
    notes_.warn(fmt::format("{}: {} corners are no whole number of triangles; the last {} left out", user,
                            result.indices.size(), rest));
    result.indices.resize(result.indices.size() - rest);
  }
  const std::vector<std::uint32_t> used = compact(result.indices, vertex_count);
  if (!used.empty()) vertex_count = used.size();
  if (result.indices.empty()) return {};

  result.positions_object.resize(vertex_count);
  for (std::size_t i = 0; i < vertex_count; ++i)
    result.positions_object[i] = positions.vec3_at(used.empty() ? i : used[i]);

  if (const int normal_index = attribute(source, "NORMAL"); normal_index >= 0) {
    const Accessor& normals = accessors_[static_cast<std::size_t>(normal_index)];
    if (!normals.is(ComponentType::f32, 3) || normals.count != positions.count) {
      throw InputError(fmt::format("{}: NORMAL in {} is not {} VEC3 of float (5126), one per position", user,
                                   normals.label, positions.count));
    }
    result.normals_object = read_normals(normals, used, vertex_count, user);
  }
  return result;
}

std::vector<std::uint32_t> MeshReader::read_indices(const Accessor& indices, std::uint64_t vertex_count,
                                                    const std::string& user) const {
  const ComponentType type = indices.component;
  const bool is_unsigned = type == ComponentType::u8 || type == ComponentType::u16 || type == ComponentType::u32;
  if (!is_unsigned || !indices.is(type, 1) || indices.normalized) {
    throw InputError(
        fmt::format("{}: indices in {} are not plain SCALAR of unsigned byte, short or int", user, indices.label));
  }
  std::vector<std::uint32_t> result(indices.count);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::uint32_t index = indices.index_at(i);
    if (index == restart_value(type)) {
      throw InputError(fmt::format("{}: {}, element {} is {}, the primitive restart value, which glTF forbids", user,
                                   indices.label, i, index));
    }
    if (index >= vertex_count) {
      throw InputError(fmt::format("{}: {}, element {} is {}, but there are only {} positions", user, indices.label, i,
                                   index, vertex_count));
    }
    result[i] = index;
  }
  return result;
}

void MeshReader::check_positions(std::size_t accessor) {
  if (positions_checked_[accessor]) return;
  positions_checked_[accessor] = true;
  const Accessor& positions = accessors_[accessor];
  for (std::uint64_t i = 0; i < positions.count; ++i) {
    const glm::vec3 p = positions.vec3_at(i);
    for (int axis = 0; axis < 3; ++axis) {
      const auto size = static_cast<double>(std::abs(p[axis]));
      if (size <= kMaxCoordinate) continue;
      throw InputError(fmt::format("{}, element {}: {} = {:g} {}", positions.label, i, "xyz"[axis], p[axis],
                                   std::isfinite(p[axis])
                                       ? "is beyond 2^40 m, the largest coordinate; scale the scene down"
                                       : "is not finite; repair or export the mesh again"));
    }
  }
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

std::vector<glm::vec3> MeshReader::read_normals(const Accessor& normals, const std::vector<std::uint32_t>& used,
                                                std::size_t vertex_count, const std::string& user) const {
  std::vector<glm::vec3> result(vertex_count);
  std::size_t bad_count = 0;
  std::uint64_t first_bad = 0;
  for (std::size_t i = 0; i < vertex_count; ++i) {
    const std::uint64_t element = used.empty() ? i : used[i];
    const glm::dvec3 normal(normals.vec3_at(element));  // in double: the square of a float may overflow or vanish
    const double length = std::sqrt(glm::dot(normal, normal));
    if (!(length > 0) || !std::isfinite(length)) {
      if (bad_count++ == 0) first_bad = element;
      continue;
    }
    result[i] = glm::vec3(normal / length);
  }
  if (bad_count == 0) return result;
  notes_.warn(fmt::format("{}: normals dropped and made flat: {}, element {} is zero or not finite ({} of them are)",
                          user, normals.label, first_bad, bad_count));
  return {};
}

}  // namespace eikon
