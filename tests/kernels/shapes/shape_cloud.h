// SPDX-License-Identifier: Apache-2.0
// Shapes of every kind, and rays at them.
#pragma once
#include <glm/gtc/matrix_transform.hpp>

#include "kernels/traverse/traverse_probe.h"
#include "support/random.h"

namespace eikon {

/// A shape of each kind at `center`, turned and stretched by as much as `stretch` says.
inline Shape shape_of(ShapeKind kind, const glm::dvec3& center, double size, double stretch, test::Random& random) {
  Shape shape;
  shape.kind = kind;
  std::size_t at = 0;
  for (const ShapeParameter& parameter : shape_kind(kind).parameters)
    for (std::size_t i = 0; i < parameter.count; ++i)
      shape.size[at++] = parameter.usual * size * test::uniform(random, 0.6, 1.4);
  const glm::dvec3 scale(std::exp2(test::uniform(random, -stretch, stretch)),
                         std::exp2(test::uniform(random, -stretch, stretch)),
                         std::exp2(test::uniform(random, -stretch, stretch)));
  shape.world_from_object = glm::translate(glm::dmat4(1), center);
  if (stretch > 0)
    shape.world_from_object = shape.world_from_object *
                              glm::rotate(glm::dmat4(1), test::uniform(random, 0, 6), test::random_direction(random)) *
                              glm::scale(glm::dmat4(1), scale);
  return shape;
}

/// A cloud of shapes of all kinds, some of which overlap or coincide, and a few triangles among
/// them.
inline Scene cloud(std::size_t count, double size, std::uint32_t seed, bool opacity = false) {
  test::Random random(seed);
  Scene scene;
  Material material;
  material.metallic = 0;
  material.specular = 0;
  scene.materials.push_back(material);
  if (opacity) {
    material.alpha_mode = AlphaMode::blend;
    material.opacity = 0.5F;
    scene.materials.push_back(material);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const ShapeKindInfo& kind = shape_kinds()[i % shape_kinds().size()];
    const glm::dvec3 center =
        size * (i % 16 == 15 ? glm::dvec3(0.0) : test::random_direction(random) * test::uniform(random, 0, 4));
    Shape shape = shape_of(kind.kind, center, size, i % 3 == 0 ? 0 : 1.5, random);
    shape.material = opacity ? std::uint32_t(i % 2) : 0;
    scene.shapes.push_back(shape);
    if (i % 20 == 19) scene.shapes.push_back(shape);  // two in one place: the smaller id wins
  }
  Primitive few;
  for (std::size_t i = 0; i < count / 4; ++i)
    for (std::uint32_t k = 0; k < 3; ++k) {
      few.indices.push_back(std::uint32_t(few.positions_object.size()));
      few.positions_object.push_back(glm::vec3(size * test::random_direction(random) * test::uniform(random, 0, 4)));
    }
  if (!few.indices.empty()) {
    scene.meshes.push_back({"few", {std::move(few)}});
    scene.nodes.emplace_back();
  }
  return scene;
}

/// Rays from everywhere: random ones, along axes, at centres, at silhouettes, from inside and from
/// far away.
inline std::vector<ProbeRay> rays_at(const Scene& scene, std::size_t count, double size, std::uint32_t seed) {
  test::Random random(seed);
  std::vector<ProbeRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Shape& shape = scene.shapes[std::size_t(test::uniform(random, 0, double(scene.shapes.size()) - 0.5))];
    const glm::dmat4& m = shape.world_from_object;
    const glm::dvec3 center(m[3]), side = test::random_direction(random);
    const double reach = (i % 7 == 6 ? 1e6 : i % 7 == 5 ? 0.1 : 6) * size;
    glm::dvec3 origin = center + reach * test::random_direction(random), target = center;
    switch (i % 5) {
      case 1:
        target = center + size * 0.5 * glm::normalize(glm::cross(center - origin, side));
        break;  // about the silhouette
      case 2:
        target = center + size * side;
        break;
      case 3:
        target = origin, target[int(i / 5 % 3)] += i / 15 % 2 == 0 ? 1 : -1;
        break;  // along an axis
      case 4:
        target = origin + side;
        break;
      default:
        break;
    }
    const glm::dvec3 d = glm::normalize(target - origin);
    rays.push_back(probe_ray(origin, d, test::uniform(random, 0, 2) * reach));
  }
  return rays;
}

/// A scene as it goes to a device, with what it needs there, or what a larger one would need.
struct Packed {
  Settings settings{};
  Features features;
  PackedScene scene;
  explicit Packed(const Scene& from) : Packed(from, from) {}
  Packed(const Scene& from, const Scene& larger)
      : features(larger, settings), scene(pack_in_world(from, features, settings)) {}
};

}  // namespace eikon
