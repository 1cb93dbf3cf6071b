// SPDX-License-Identifier: Apache-2.0
#include "pack/geometry/solid_openings.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

namespace eikon {
namespace {

/// Numbers positions so that equal ones have the same number.
class PositionNumbers {
 public:
  std::uint32_t of(const glm::vec3& p) {
    // + 0 makes one zero of both.
    return number_.try_emplace({p.x + 0.0F, p.y + 0.0F, p.z + 0.0F}, std::uint32_t(number_.size())).first->second;
  }

 private:
  std::map<std::tuple<float, float, float>, std::uint32_t> number_;
};

}  // namespace

bool may_have_openings(const Material& m) {
  if (m.alpha_mode == AlphaMode::opaque || !is_solid(m) || m.transmission == 0) return false;
  // What is nowhere to be seen has no inside either.
  const bool is_somewhere = m.alpha_mode == AlphaMode::mask ? m.opacity >= m.alpha_cutoff : m.opacity > 0;
  return is_somewhere && m.emission == glm::vec3(0);
}

bool is_closed(const Scene& scene, const Mesh& mesh) {
  PositionNumbers numbers;
  struct Edge {
    std::uint32_t from, to;  // from < to
    int direction;           // 1: as stored, -1: the triangle goes from `to` to `from`
  };
  std::vector<Edge> edges;
  for (const Primitive& primitive : mesh.primitives) {
    if (!is_solid(scene.materials[primitive.material])) continue;
    std::vector<std::uint32_t> number;
    number.reserve(primitive.positions_object.size());
    for (const glm::vec3& p : primitive.positions_object) number.push_back(numbers.of(p));
    for (std::size_t t = 0; t < primitive.indices.triangle_count(); ++t) {
      const std::array<std::uint32_t, 3> corners = primitive.indices.triangle(t);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = number[corners[i]], b = number[corners[(i + 1) % 3]];
        if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
      }
    }
  }
  std::ranges::sort(edges, {}, [](const Edge& e) { return std::tuple(e.from, e.to); });
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    int balance = 0;
    for (; end < edges.size() && edges[end].from == edges[begin].from && edges[end].to == edges[begin].to; ++end)
      balance += edges[end].direction;
    if (balance != 0) return false;
  }
  return !edges.empty();
}

SolidOpenings::SolidOpenings(const Scene& scene)
    : by_material_(scene.materials.size()), is_closed_(scene.meshes.size()) {
  if (std::ranges::none_of(scene.materials, may_have_openings)) return;
  const PassableMaterials passable(scene);
  for (std::uint32_t i = 0; i < scene.materials.size(); ++i)
    by_material_[i] = may_have_openings(scene.materials[i]) && passable.may_have(i);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    if (std::ranges::any_of(mesh.primitives, [&](const Primitive& p) { return has(p.material); }))
      is_closed_[i] = is_closed(scene, mesh);
  }
}

bool SolidOpenings::any(const Scene& scene) const {
  const auto in_mesh = [&](const Node& node) {
    return std::ranges::any_of(scene.meshes[node.mesh].primitives,
                               [&](const Primitive& p) { return has(node.mesh, p); });
  };
  return std::ranges::any_of(scene.nodes, in_mesh) ||
         std::ranges::any_of(scene.shapes, [&](const Shape& shape) { return has(shape.material); });
}

}  // namespace eikon
