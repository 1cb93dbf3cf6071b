// SPDX-License-Identifier: Apache-2.0
// Normal maps and brushed metal on shapes: as on the triangles that come close to them.
#include <functional>
#include <random>

#include "render/scene_builder.h"
#include "gltf/geometry/tangents.h"

namespace eikon::test {
namespace {

/// Slopes of up to 30 degrees that go over into each other, the same on no two texels.
Texture add_relief(Scene& scene) {
  std::mt19937 random(1);
  TextureImage image;
  image.name = "relief";
  image.width = image.height = 8;
  for (int i = 0; i < 64; ++i)
    image.rgba8.push_back(
        std::uint32_t((80U + random() % 96U) | (80U + random() % 96U) << 8 | 245U << 16 | 0xff000000U));
  scene.images.push_back(image);
  Texture texture;
  texture.image = std::uint32_t(scene.images.size() - 1);
  return texture;
}

struct Vertex {
  glm::dvec3 p, n;
  double u, v;
};

/// A patch of a surface by two numbers from 0 to 1: along a row, and downwards as seen from its
/// front.
void add_patch(Primitive& primitive, std::uint32_t columns, std::uint32_t rows,
               const std::function<Vertex(double, double)>& vertex_at) {
  const auto first = std::uint32_t(primitive.positions_object.size());
  for (std::uint32_t i = 0; i <= rows; ++i)
    for (std::uint32_t j = 0; j <= columns; ++j) {
      const Vertex vertex = vertex_at(double(j) / columns, double(i) / rows);
      primitive.positions_object.emplace_back(vertex.p);
      primitive.normals_object.emplace_back(vertex.n);
      primitive.uv[0].emplace_back(vertex.u, vertex.v);
    }
  for (std::uint32_t i = 0; i < rows; ++i)
    for (std::uint32_t j = 0; j < columns; ++j) {
      const std::uint32_t a = first + i * (columns + 1) + j, b = a + columns + 1;
      for (const std::uint32_t k : {a, b, b + 1, a, b + 1, a + 1}) primitive.indices.push_back(k);
    }
}

// As README lays textures round shapes: from the back, eastwards, with the front at +Z in the
// middle, and from the top down.
glm::dvec3 around(double u) {
  const double phi = 2 * std::numbers::pi * (u - 0.5);
  return {std::sin(phi), 0, std::cos(phi)};
}

Primitive globe() {
  Primitive primitive;
  add_patch(primitive, 192, 96, [](double u, double v) {
    const double theta = std::numbers::pi * v;
    const glm::dvec3 p = std::sin(theta) * around(u) + glm::dvec3(0, std::cos(theta), 0);
    return Vertex{p, p, u, v};
  });
  return primitive;
}

/// Radius 1 at the bottom and 1/2 on top, 2 high.
Primitive tub() {
  Primitive primitive;
  add_patch(primitive, 192, 16, [](double u, double v) {
    const double y = 1 - 2 * v;
    return Vertex{(0.75 - 0.25 * y) * around(u) + glm::dvec3(0, y, 0),
                  glm::normalize(around(u) + glm::dvec3(0, 0.25, 0)), u, v};
  });
  for (const double y : {1.0, -1.0})
    add_patch(primitive, 192, 8, [&](double u, double v) {
      const glm::dvec3 p = (0.75 - 0.25 * y) * v * around(y > 0 ? u : 1 - u) + glm::dvec3(0, y, 0);
      return Vertex{p, {0, y, 0}, 0.5 + 0.5 * p.x, 0.5 + 0.5 * y * p.z};
    });
  return primitive;
}

Primitive cube() {
  Primitive primitive;
  struct Face {
    glm::dvec3 out, right;
  };
  for (const Face& face : {Face{{1, 0, 0}, {0, 0, -1}}, Face{{-1, 0, 0}, {0, 0, 1}}, Face{{0, 1, 0}, {1, 0, 0}},
                           Face{{0, -1, 0}, {1, 0, 0}}, Face{{0, 0, 1}, {1, 0, 0}}, Face{{0, 0, -1}, {-1, 0, 0}}})
    add_patch(primitive, 1, 1, [&](double u, double v) {
      const glm::dvec3 up = glm::cross(face.out, face.right);
      return Vertex{face.out + (2 * u - 1) * face.right + (1 - 2 * v) * up, face.out, u, v};
    });
  return primitive;
}

struct Pair {
  const char* what;
  ShapeKind kind;
  std::array<double, 3> size;
  Primitive (*triangles)();
};
const Pair kPairs[] = {{"sphere", ShapeKind::sphere, {1, 0, 0}, globe},
                       {"cylinder", ShapeKind::cylinder, {2, 0.5, 1}, tub},
                       {"box", ShapeKind::box, {2, 2, 2}, cube}};

enum class As { shape, triangles };

/// On a black ground, lit by a low sun from the right and a weaker one from the left.
Film film_with(const Pair& pair, As as, const glm::dmat4& place, Material material, bool relief, std::uint64_t spp) {
  Scene scene;
  if (relief) material.normal_texture = add_relief(scene);
  if (as == As::shape) {
    Shape shape;
    shape.name = pair.what;
    shape.kind = pair.kind;
    shape.size = pair.size;
    shape.world_from_object = place;
    scene.materials.push_back(material);
    scene.shapes.push_back(shape);
  } else {
    Primitive primitive = pair.triangles();
    make_tangents(primitive, {});
    Node& node = add_mesh(scene, pair.what, std::move(primitive), material);
    node.world_from_object = place;
    node.mirrored = glm::determinant(glm::dmat3(place)) < 0;
  }
  for (const bool right : {true, false}) {
    PunctualLight sun;
    sun.kind = LightKind::directional;
    sun.direction = glm::normalize(right ? glm::dvec3(-1, -0.4, -0.5) : glm::dvec3(0.6, -0.9, -0.4));
    sun.intensity = glm::vec3(right ? 3.0F : 1.0F);
    scene.lights.push_back(sun);
  }
  Settings settings = settings_for(40, 40, spp);
  settings.seed = as == As::shape ? 0 : 1;
  settings.max_depth = 2;
  settings.camera = look_at_camera({0.5, 1.4, 4}, {0, 0, 0}, {0, 1, 0}, 0.75);
  return film_of(scene, settings);
}

/// Mean difference of windows of 5 x 5 pixels, as a share of the brightest.
double difference(const Film& a, const Film& b) {
  double sum = 0, most = 0;
  for (std::uint32_t y = 0; y < 40; y += 5)
    for (std::uint32_t x = 0; x < 40; x += 5) {
      const Crop window{x, y, x + 5, y + 5};
      const double one = mean_of(a, 0, window).mean, other = mean_of(b, 0, window).mean;
      sum += std::abs(one - other);
      most = std::max({most, one, other});
    }
  return sum / 64 / most;
}

const glm::dmat4 kPlaces[] = {
    glm::dmat4(1),
    glm::rotate(glm::dmat4(1), 0.6, glm::dvec3(0.3, 1, 0.2)) * glm::scale(glm::dmat4(1), {1.0, 0.6, 0.8}),
    glm::rotate(glm::dmat4(1), 0.4, glm::dvec3(0.5, 1, 0)) * glm::scale(glm::dmat4(1), {-1.0, 0.9, 0.7})};

// Without the map windows differ by a hundredth, with one whose pictures are seen from behind or
// upside down by twice that; what is left of the difference to triangles comes from samples that
// fall beside edges and silhouettes.
TEST(ShapeTangents, a_normal_map_on_a_shape_looks_as_on_its_triangles) {
  for (const Pair& pair : kPairs)
    for (const glm::dmat4& place : kPlaces) {
      const Film shape = film_with(pair, As::shape, place, lambert(0.8F), true, 256);
      const Film triangles = film_with(pair, As::triangles, place, lambert(0.8F), true, 256);
      const Film smooth = film_with(pair, As::shape, place, lambert(0.8F), false, 256);
      const double apart = difference(shape, triangles), relief = difference(shape, smooth);
      EXPECT_LT(apart, 0.002) << pair.what;
      EXPECT_GT(relief, 8 * apart) << pair.what;
      EXPECT_GT(relief, 0.005) << pair.what;
    }
}

TEST(ShapeTangents, brushed_metal_on_a_shape_looks_as_on_its_triangles) {
  Material steel = lambert(0.8F);
  steel.metallic = 1;
  steel.specular = 1;
  steel.roughness = 0.35F;
  Material brushed = steel;
  brushed.anisotropy = 0.9F;
  brushed.anisotropy_rotation_rad = 0.5F;
  for (const Pair& pair : kPairs)
    for (const glm::dmat4& place : kPlaces) {
      const Film shape = film_with(pair, As::shape, place, brushed, false, 256);
      const Film triangles = film_with(pair, As::triangles, place, brushed, false, 256);
      const Film plain = film_with(pair, As::shape, place, steel, false, 256);
      const double apart = difference(shape, triangles), grooves = difference(shape, plain);
      EXPECT_LT(apart, 0.003) << pair.what;
      EXPECT_GT(grooves, 4 * apart) << pair.what;
    }
}

}  // namespace
}  // namespace eikon::test
