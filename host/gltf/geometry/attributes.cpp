// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/attributes.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "core/error.h"
#include "scene/transform.h"

namespace eikon {
namespace {

constexpr const char* kQuantization = "KHR_mesh_quantization";

bool is_signed(ComponentType type) { return type == ComponentType::i8 || type == ComponentType::i16; }
bool is_unsigned(ComponentType type) { return type == ComponentType::u8 || type == ComponentType::u16; }

// The types that [glTF 2.0, section 3.7.2.1] allows, and if `quantized` those of
// [KHR_mesh_quantization, "Extending Mesh Attributes"].
bool is_legal(const std::string& name, const Accessor& a, bool quantized) {
  const auto has = [&](std::uint32_t components) { return a.component_count == components && !a.is_matrix; };
  const ComponentType type = a.component;
  const bool is_float = type == ComponentType::f32;
  if (name == "POSITION") return has(3) && (is_float || (quantized && (is_signed(type) || is_unsigned(type))));
  const bool direction = is_float || (quantized && is_signed(type) && a.normalized);
  if (name == "NORMAL") return has(3) && direction;
  if (name == "TANGENT") return has(4) && direction;
  if (name.starts_with("JOINTS_")) return has(4) && is_unsigned(type) && !a.normalized;
  if (name.starts_with("WEIGHTS_")) return has(4) && (is_float || (is_unsigned(type) && a.normalized));
  if (name.starts_with("COLOR_")) return (has(3) || has(4)) && (is_float || (is_unsigned(type) && a.normalized));
  return has(2) && (is_float || (is_unsigned(type) && (a.normalized || quantized)) || (quantized && is_signed(type)));
}

std::string type_name(const Accessor& a) {
  const auto component = [&] {
    switch (a.component) {
      case ComponentType::i8:
        return "byte";
      case ComponentType::u8:
        return "unsigned byte";
      case ComponentType::i16:
        return "short";
      case ComponentType::u16:
        return "unsigned short";
      case ComponentType::u32:
        return "unsigned int";
      case ComponentType::f32:
        return "float";
    }
    return "?";
  }();
  const std::string shape = a.is_matrix              ? "matrices"
                            : a.component_count == 1 ? "SCALAR"
                                                     : fmt::format("VEC{}", a.component_count);
  return fmt::format("{} of {}{}", shape, a.normalized ? "normalised " : "", component);
}

// Counts elements that are not as they should be, and keeps the first.
class Odd {
 public:
  void add(std::uint64_t element) {
    if (count_++ == 0) first_ = element;
  }
  [[nodiscard]] bool any() const { return count_ != 0; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] std::string text(const Accessor& accessor, const char* what) const {
    return fmt::format("{}, element {} {} ({} of them)", accessor.label, first_, what, count_);
  }

 private:
  std::uint64_t first_ = 0, count_ = 0;
};

// Replaces zeros by the mean normal of the triangles at the vertex, by their area. Where these have
// none, no ray hits them, and any unit vector will do.
void fill_normals(const Primitive& primitive, std::vector<glm::vec3>& normals) {
  std::vector<bool> is_filled(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) is_filled[i] = normals[i] == glm::vec3(0.0F);
  std::vector<glm::dvec3> sums(normals.size(), glm::dvec3(0.0));
  for (std::size_t t = 0; t < primitive.indices.triangle_count(); ++t) {
    const std::array<std::uint32_t, 3> corner = primitive.indices.triangle(t);
    if (!is_filled[corner[0]] && !is_filled[corner[1]] && !is_filled[corner[2]]) continue;
    const glm::dvec3 a(primitive.positions_object[corner[0]]), b(primitive.positions_object[corner[1]]),
        c(primitive.positions_object[corner[2]]);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    for (const std::uint32_t vertex : corner) sums[vertex] += normal;
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!is_filled[i]) continue;
    const double length = glm::length(sums[i]);
    normals[i] = length > 0 ? glm::vec3(sums[i] / length) : glm::vec3(0.0F, 0.0F, 1.0F);
  }
}

}  // namespace

void check_attribute(const std::string& name, const Accessor& accessor, std::uint64_t position_count, bool quantized,
                     const std::string& user) {
  if (!is_legal(name, accessor, quantized)) {
    const bool hint = is_legal(name, accessor, true);
    throw InputError(fmt::format(
        "{}: {} in {} is {}, which glTF does not allow there{}", user, name, accessor.label, type_name(accessor),
        hint ? fmt::format(" unless extensionsUsed lists {}", kQuantization) : "; export the file again"));
  }
  if (accessor.count != position_count) {
    throw InputError(fmt::format("{}: {} in {} has {} elements for {} positions; export the file again", user, name,
                                 accessor.label, accessor.count, position_count));
  }
  if (accessor.data == nullptr && accessor.count > kMaxZeroCount) {
    throw InputError(
        fmt::format("{}: {} in {} is {} elements of zeros without a bufferView, at most {} are read; "
                    "give it one",
                    user, name, accessor.label, accessor.count, kMaxZeroCount));
  }
}

void check_positions(const Accessor& positions) {
  for (std::uint64_t i = 0; i < positions.count; ++i) {
    const glm::vec4 p = positions.vector_at(i);
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

std::vector<glm::vec3> read_positions(const Accessor& positions, const VertexChoice& vertices) {
  std::vector<glm::vec3> result(vertices.count);
  for (std::size_t i = 0; i < vertices.count; ++i) result[i] = glm::vec3(positions.vector_at(vertices[i]));
  return result;
}

std::vector<glm::vec3> read_normals(const Accessor& normals, const VertexChoice& vertices, const Primitive& primitive,
                                    const std::string& user, Notes& notes) {
  std::vector<glm::vec3> result(vertices.count);
  Odd odd;
  for (std::size_t i = 0; i < vertices.count; ++i) {
    result[i] = direction_of(glm::dvec3(normals.vector_at(vertices[i])));
    if (result[i] == glm::vec3(0.0F)) odd.add(vertices[i]);
  }
  if (!odd.any()) return result;
  const bool all = odd.count() == vertices.count;
  const char* what = all ? ": normals dropped and made flat: " : ": normals taken from the triangles: ";
  notes.mended(user + what + odd.text(normals, "is zero or not finite"));
  if (all) return {};
  fill_normals(primitive, result);
  return result;
}

std::vector<glm::vec2> read_texture_coordinates(const Accessor& uv, const VertexChoice& vertices,
                                                const std::string& user, Notes& notes) {
  std::vector<glm::vec2> result(vertices.count);
  Odd odd;
  for (std::size_t i = 0; i < vertices.count; ++i) {
    const glm::vec2 value(uv.vector_at(vertices[i]));
    if (std::abs(value.x) <= kMaxTextureCoordinate && std::abs(value.y) <= kMaxTextureCoordinate) {
      result[i] = value;
    } else {
      odd.add(vertices[i]);
    }
  }
  if (odd.any()) notes.warn(user + ": texture coordinates taken as 0: " + odd.text(uv, "is not finite or beyond 2^24"));
  return result;
}

std::vector<glm::vec4> read_colors(const Accessor& colors, const VertexChoice& vertices, const std::string& user,
                                   Notes& notes) {
  std::vector<glm::vec4> result(vertices.count);
  Odd not_numbers, outside;
  bool all_white = true;
  for (std::size_t i = 0; i < vertices.count; ++i) {
    glm::vec4 value = colors.vector_at(vertices[i]);
    if (colors.component_count == 3) value.w = 1.0F;
    if (std::isnan(value.x) || std::isnan(value.y) || std::isnan(value.z) || std::isnan(value.w)) {
      not_numbers.add(vertices[i]);
      value = glm::vec4(1.0F);
    }
    result[i] = glm::clamp(value, 0.0F, 1.0F);
    if (result[i] != value) outside.add(vertices[i]);
    all_white = all_white && result[i] == glm::vec4(1.0F);
  }
  if (not_numbers.any()) notes.warn(user + ": vertex colours taken as white: " + not_numbers.text(colors, "is NaN"));
  if (outside.any()) notes.warn(user + ": vertex colours clamped: " + outside.text(colors, "is outside [0, 1]"));
  if (all_white) return {};
  return result;
}

std::vector<glm::vec4> read_tangents(const Accessor& tangents, const VertexChoice& vertices,
                                     const std::vector<glm::vec3>& normals, const std::string& user, Notes& notes) {
  std::vector<glm::vec4> result(vertices.count);
  Odd odd;
  for (std::size_t i = 0; i < vertices.count; ++i) {
    const glm::vec4 value = tangents.vector_at(vertices[i]);
    const glm::vec3 direction = direction_of(glm::dvec3(value));
    const float bitangent = glm::length(glm::cross(normals[i], direction));
    if (!(bitangent > 1e-3F) || !(std::abs(value.w) > 0)) odd.add(vertices[i]);
    result[i] = glm::vec4(direction, value.w < 0 ? -1.0F : 1.0F);
  }
  if (!odd.any()) return result;
  notes.warn(user + ": tangents dropped and made from the texture coordinates: " +
             odd.text(tangents, "is zero, not finite, along its normal or without a sign"));
  return {};
}

}  // namespace eikon
