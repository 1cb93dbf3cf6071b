// SPDX-License-Identifier: Apache-2.0
#include "pack/geometry/seen_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pack/materials/material_traits.h"
#include "scene/emission.h"
#include "scene/endless.h"
#include "scene/transform.h"

namespace eikon {
namespace {

constexpr std::uint32_t kPixels = 1024;

glm::dvec3 world_corner(const Node& node, const Primitive& primitive, std::uint32_t vertex) {
  return transform_point(node.world_from_object, primitive.positions_object[vertex]);
}

template <class T>
T interpolate(const SharedVector<T>& values, const WorldTriangle& triangle, double u, double v) {
  const std::array<std::uint32_t, 3> corner = triangle.primitive->indices.triangle(triangle.index);
  return values[corner[0]] * float(1 - u - v) + values[corner[1]] * float(u) + values[corner[2]] * float(v);
}

double wrapped(double turns, Wrap wrap) {
  if (wrap == Wrap::clamp) return std::clamp(turns, 0.0, 1.0);
  const double period = wrap == Wrap::mirror ? 2 : 1;
  const double rest = turns - period * std::floor(turns / period);
  return rest > 1 ? 2 - rest : rest;
}

/// The texel nearest to the place on a triangle, R, G, B and A in [0, 1]; colours linear to a few
/// per cent.
glm::dvec4 texel_at(const Scene& scene, const Texture& texture, const WorldTriangle& triangle, double u, double v) {
  const SharedVector<glm::vec2>& uvs = triangle.primitive->uv[texture.uv_set];
  const glm::vec3 uv(uvs.empty() ? glm::vec2(0) : interpolate(uvs, triangle, u, v), 1.0F);
  const TextureImage& image = scene.images[texture.image];
  const auto index = [](double turns, Wrap wrap, std::uint32_t size) {
    return std::isfinite(turns) ? std::min(std::size_t(wrapped(turns, wrap) * size), std::size_t{size} - 1) : 0;
  };
  const std::size_t x = index(glm::dot(texture.image_from_uv[0], uv), texture.wrap_u, image.width);
  const std::size_t y = index(glm::dot(texture.image_from_uv[1], uv), texture.wrap_v, image.height);
  const std::uint32_t word = image.rgba8[y * image.width + x];
  glm::dvec4 texel;
  for (int c = 0; c < 4; ++c) texel[c] = ((word >> (8 * c)) & 255U) / 255.0;
  if (texture.srgb)
    for (int c = 0; c < 3; ++c) texel[c] = std::pow(texel[c], 2.2);
  return texel;
}

void visit_box(const Shape& shape, const std::function<void(const WorldTriangle&)>& visit) {
  const OwnShape own = own_shape(bounded_piece(shape));
  const auto corner = [&](int i) {
    return own.center + own.half * glm::dvec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
  };
  constexpr std::array<std::array<int, 4>, 6> kFaces{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const std::array<int, 4>& face : kFaces)
    for (const std::array<int, 3>& half : {std::array{face[0], face[1], face[2]}, {face[0], face[2], face[3]}})
      visit({.corners = {corner(half[0]), corner(half[1]), corner(half[2])}, .material = shape.material});
}

/// A pinhole or orthographic picture that keeps the nearest triangle of each pixel. Camera space:
/// +X right, +Y up, and the camera looks along -Z.
class CoarsePicture {
 public:
  CoarsePicture(const Camera& camera, double aspect, std::uint32_t pixels, Culling culling)
      : culling_(culling),
        from_camera_(camera.world_from_camera),
        camera_from_world_(glm::inverse(camera.world_from_camera)),
        orthographic_(camera.projection == Projection::orthographic),
        width_(std::max(1U, std::uint32_t(std::lround(std::sqrt(pixels * aspect))))),
        height_(std::max(1U, pixels / width_)) {
    const double half = half_height_m(camera);
    half_ = {half * aspect, half};
    hits_.resize(std::size_t{width_} * height_);
  }

  void add(const Scene& scene, const WorldTriangle& triangle) {
    glm::dvec3 p[3];
    for (int k = 0; k < 3; ++k) p[k] = transform_point(camera_from_world_, triangle.corners[k]);
    if (p[0].z >= 0 && p[1].z >= 0 && p[2].z >= 0) return;
    const bool may_pass = culling_ != Culling::none && triangle.primitive != nullptr;
    if (may_pass && is_single_sided(scene.materials[triangle.material]) && shows_back(triangle)) return;
    glm::dvec2 lo(std::numeric_limits<double>::infinity()), hi = -lo;
    for (const glm::dvec3& corner : p) {
      if (corner.z >= 0 && !orthographic_) {  // a corner beside or behind the camera has no place in the picture
        lo = glm::dvec2(-1), hi = glm::dvec2(1);
        break;
      }
      const glm::dvec2 place = glm::dvec2(corner) / (orthographic_ ? half_ : half_ * -corner.z);
      lo = glm::min(lo, place), hi = glm::max(hi, place);
    }
    const auto pixel = [](double place, std::uint32_t size) {
      return std::uint32_t(std::clamp((place * 0.5 + 0.5) * size + 0.5, 0.0, double(size)));
    };
    for (std::uint32_t y = pixel(lo.y, height_); y < pixel(hi.y, height_); ++y)
      for (std::uint32_t x = pixel(lo.x, width_); x < pixel(hi.x, width_); ++x) meet(scene, triangle, p, x, y);
  }

  void take(const Scene& scene, std::vector<SeenPoint>& points) const {
    for (const Hit& hit : hits_) {
      if (hit.distance == std::numeric_limits<double>::infinity()) continue;
      const WorldTriangle& t = hit.triangle;
      const glm::dvec3 position = t.corners[0] * (1 - hit.u - hit.v) + t.corners[1] * hit.u + t.corners[2] * hit.v;
      const bool back = shows_back(t);
      const Material& material = scene.materials[t.material];
      points.push_back({.position = position,
                        .normal = back ? -front_normal(t) : front_normal(t),
                        .emission = back && !material.double_sided ? 0 : emission_at(scene, t, hit.u, hit.v),
                        .unlit = material.unlit});
    }
  }

 private:
  [[nodiscard]] bool shows_back(const WorldTriangle& t) const {
    const glm::dvec3 to_viewer =
        glm::dvec3(from_camera_[orthographic_ ? 2 : 3]) - (orthographic_ ? glm::dvec3(0) : t.corners[0]);
    return glm::dot(front_normal(t), to_viewer) < 0;
  }

  struct Hit {
    double distance = std::numeric_limits<double>::infinity();  // along -Z
    double u = 0, v = 0;
    WorldTriangle triangle{};
  };

  // [Möller, Trumbore 1997]
  void meet(const Scene& scene, const WorldTriangle& triangle, const glm::dvec3 (&p)[3], std::uint32_t x,
            std::uint32_t y) {
    const glm::dvec2 place = (glm::dvec2(x + 0.5, y + 0.5) / glm::dvec2(width_, height_) * 2.0 - 1.0) * half_;
    const glm::dvec3 origin = orthographic_ ? glm::dvec3(place, 0) : glm::dvec3(0);
    const glm::dvec3 direction = orthographic_ ? glm::dvec3(0, 0, -1) : glm::dvec3(place, -1);
    const glm::dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0], h = glm::cross(direction, e2), s = origin - p[0];
    const double determinant = glm::dot(e1, h);
    const glm::dvec3 q = glm::cross(s, e1);
    const double u = glm::dot(s, h) / determinant, v = glm::dot(direction, q) / determinant;
    const double distance = glm::dot(e2, q) / determinant;
    Hit& hit = hits_[std::size_t{y} * width_ + x];
    if (!(u >= 0 && v >= 0 && u + v <= 1 && distance > 0 && distance < hit.distance)) return;  // false for NaN
    if (!is_clear_at(scene, triangle, u, v)) hit = {distance, u, v, triangle};
  }

  Culling culling_;
  glm::dmat4 from_camera_, camera_from_world_;
  bool orthographic_;
  std::uint32_t width_, height_;
  glm::dvec2 half_{};  // of the picture, one metre ahead of a pinhole
  std::vector<Hit> hits_;
};

/// A panorama is seen as the six faces of a cube.
std::vector<CoarsePicture> pictures_of(const Settings& settings) {
  const Camera& camera = settings.camera;
  if (camera.projection != Projection::panorama)
    return {CoarsePicture(camera, double(settings.width) / settings.height, kPixels, settings.culling)};
  std::vector<CoarsePicture> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      Camera face{.name = {}, .world_from_camera = camera.world_from_camera, .yfov_rad = std::acos(0.0)};
      for (int k = 0; k < 3; ++k) face.world_from_camera[k] = sign * camera.world_from_camera[(axis + k) % 3];
      faces.emplace_back(face, 1.0, kPixels / 6, settings.culling);
    }
  return faces;
}

}  // namespace

void for_each_triangle(const Scene& scene, const std::function<void(const WorldTriangle&)>& visit) {
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
      for (std::size_t i = 0; i < primitive.indices.triangle_count(); ++i) {
        const std::array<std::uint32_t, 3> vertices = primitive.indices.triangle(i);
        const auto corner = [&](std::size_t k) { return world_corner(node, primitive, vertices[k]); };
        WorldTriangle triangle{.corners = {corner(0), corner(1), corner(2)},
                               .material = primitive.material,
                               .primitive = &primitive,
                               .index = std::uint32_t(i),
                               .mirrored = node.mirrored};
        visit(triangle);
      }
  for (const Shape& shape : scene.shapes) visit_box(shape, visit);
}

glm::dvec3 front_normal(const WorldTriangle& t) {
  const glm::dvec3 normal = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
  const double length = glm::length(normal);
  return length > 0 ? normal / (t.mirrored ? -length : length) : glm::dvec3(0);
}

double emission_at(const Scene& scene, const WorldTriangle& triangle, double u, double v) {
  const Material& material = scene.materials[triangle.material];
  if (!emits(material)) return 0;
  glm::dvec3 emission(material.emission);
  if (material.emissive_texture && triangle.primitive != nullptr)
    emission *= glm::dvec3(texel_at(scene, *material.emissive_texture, triangle, u, v));
  return (emission.x + emission.y + emission.z) / 3;
}

bool is_clear_at(const Scene& scene, const WorldTriangle& triangle, double u, double v) {
  const Material& material = scene.materials[triangle.material];
  if (material.alpha_mode == AlphaMode::opaque) return false;
  double opacity = material.opacity;
  if (triangle.primitive != nullptr) {
    if (material.base_color_texture) opacity *= texel_at(scene, *material.base_color_texture, triangle, u, v).w;
    if (!triangle.primitive->colors.empty()) opacity *= interpolate(triangle.primitive->colors, triangle, u, v).w;
  }
  return opacity < (material.alpha_mode == AlphaMode::mask ? double(material.alpha_cutoff) : 0.5);
}

std::vector<SeenPoint> seen_points(const Scene& scene, const Settings& settings) {
  std::vector<CoarsePicture> pictures = pictures_of(settings);
  for_each_triangle(scene, [&](const WorldTriangle& triangle) {
    for (CoarsePicture& picture : pictures) picture.add(scene, triangle);
  });
  std::vector<SeenPoint> points;
  for (const CoarsePicture& picture : pictures) picture.take(scene, points);
  return points;
}

}  // namespace eikon
