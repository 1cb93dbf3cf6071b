// SPDX-License-Identifier: Apache-2.0
#include "instruments/analytic_scenes.h"

#include <algorithm>
#include <cmath>

namespace eikon {

void add_quad(Primitive& primitive, glm::vec3 p, glm::vec3 a, glm::vec3 b) {
  const auto first = std::uint32_t(primitive.positions_object.size());
  for (const glm::vec3& corner : {p, p + a, p + a + b, p + b}) primitive.positions_object.push_back(corner);
  for (std::uint32_t i : {0U, 1U, 2U, 0U, 2U, 3U}) primitive.indices.push_back(first + i);
}

void add_box(Primitive& primitive, glm::vec3 lo, glm::vec3 hi, bool inwards) {
  const glm::vec3 size = hi - lo;
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec3 a(0), b(0), across(0);
    a[(axis + 1) % 3] = size[(axis + 1) % 3], b[(axis + 2) % 3] = size[(axis + 2) % 3], across[axis] = size[axis];
    add_quad(primitive, lo, inwards ? a : b, inwards ? b : a);
    add_quad(primitive, lo + across, inwards ? b : a, inwards ? a : b);
  }
}

Node& add_mesh(Scene& scene, const std::string& name, Primitive primitive, const Material& material) {
  primitive.material = std::uint32_t(scene.materials.size());
  scene.materials.push_back(material);
  scene.materials.back().name = name;
  Node node;
  node.name = name;
  node.mesh = std::uint32_t(scene.meshes.size());
  scene.meshes.push_back({name, {std::move(primitive)}});
  return scene.nodes.emplace_back(node);
}

Material lambert(glm::vec3 albedo, glm::vec3 emission) {
  Material material;
  material.base_color = albedo;
  material.metallic = 0;
  material.specular = 0;
  material.emission = emission;
  return material;
}

Scene furnace(float albedo, float emission) {
  Primitive cube;
  add_box(cube, glm::vec3(-1), glm::vec3(1), true);
  Scene scene;
  add_mesh(scene, "cube", std::move(cube), lambert(albedo, emission));
  return scene;
}

Scene square_light() {
  Scene scene;
  Primitive floor, light;
  add_quad(floor, {-0.01F, 0, 0.01F}, {0.02F, 0, 0}, {0, 0, -0.02F});
  add_quad(light, {-0.5F, 1, -0.5F}, {1, 0, 0}, {0, 0, 1});
  add_mesh(scene, "floor", std::move(floor), lambert(1));
  add_mesh(scene, "light", std::move(light), lambert(0, 1));
  return scene;
}

Settings settings_for(std::uint32_t width, std::uint32_t height, std::uint64_t spp) {
  Settings settings;
  settings.width = width;
  settings.height = height;
  settings.crop = {0, 0, width, height};
  settings.sample_end = spp;
  return settings;
}

MeanAndError mean_between_pixels(const Film& film, std::uint32_t channel) {
  const Crop& crop = film.layout().crop;
  double sum = 0, squares = 0;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
      const double value = film.mean(x, y, channel);
      sum += value;
      squares += value * value;
    }
  const double n = double(crop.pixel_count());
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean) / n)};
}

bool same_bits(const Film& a, const Film& b) {
  if (!(a.layout() == b.layout())) return false;
  const Crop& crop = a.layout().crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    if (!std::ranges::equal(a.row_sums(y), b.row_sums(y)) || !std::ranges::equal(a.row_counts(y), b.row_counts(y)))
      return false;
  for (std::size_t m = 0; m < a.layout().mattes.size(); ++m)
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
        if (a.matte(m, x, y) != b.matte(m, x, y)) return false;
  return true;
}

}  // namespace eikon
