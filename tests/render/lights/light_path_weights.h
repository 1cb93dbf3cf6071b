// SPDX-License-Identifier: Apache-2.0
// The weights of camera paths and light paths by closed forms, and scenes of triangles that emit in
// one colour each, for tests of these weights.
#pragma once
#include <memory>
#include <optional>

#include "pack/geometry/instanced_meshes.h"
#include "pack/pack.h"
#include "render/lights/light_path_scenes.h"
#include "wavefront/wavefront.h"

namespace eikon::test {

// ---- the weights, by closed forms ---------------------------------------------------------------

/// A path as far as its weights depend on it: its end at the camera and its end at the lamp.
struct PathEnds {
  glm::dvec3 first{0.0}, first_normal{0.0};     // the first surface that the camera sees
  glm::dvec3 from_lamp{0.0}, lamp_normal{0.0};  // direction in which the light leaves the lamp, unit
  double start_m2 = 0;  // probability that a light path starts from this lamp, over the lamp's area
  double aim_sr = 0;    // mean density of the directions in which light paths leave it
};

/// Pixels of a pinhole's film per m^2 of a surface across the ray to a point: a pixel has the side
/// s on a film one metre ahead of the camera, and the solid angle s^2 cos^3 of the angle with the
/// camera's axis.
inline double film_density(const Settings& settings, const glm::dvec3& point) {
  const glm::dmat4& camera = settings.camera.world_from_camera;
  const glm::dvec3 ray = point - glm::dvec3(camera[3]);
  const double side = 2 * std::tan(0.5 * settings.camera.yfov_rad) / settings.height;
  const double cosine = glm::dot(-glm::dvec3(camera[2]), glm::normalize(ray));
  return 1 / (side * side * cosine * cosine * cosine * glm::dot(ray, ray));
}

/// R: the density of light paths over that of camera paths, as the renderer defines it.
inline double weight_ratio(const Settings& settings, const PathEnds& path) {
  const glm::dvec3 ray = glm::normalize(path.first - glm::dvec3(settings.camera.world_from_camera[3]));
  const double cos_first = std::abs(glm::dot(path.first_normal, ray)),
               cos_lamp = std::abs(glm::dot(path.lamp_normal, path.from_lamp));
  const double at_camera = double(settings.light_path_count) * kPi / (film_density(settings, path.first) * cos_first);
  return at_camera * path.start_m2 * path.aim_sr / cos_lamp;
}

// ---- scenes -------------------------------------------------------------------------------------

/// A black triangle that emits kRadiance in one channel alone, so that its light can be told from
/// others'.
struct TriangleLamp {
  glm::dvec3 a{0.0}, b{0.0}, c{0.0};  // its front has them counterclockwise
  std::uint32_t material = 0;
  double start_m2 = 0, aim_sr = 0;  // as in PathEnds, once a scene is packed

  [[nodiscard]] glm::dvec3 across() const { return glm::cross(b - a, c - a); }
  [[nodiscard]] glm::dvec3 normal() const { return glm::normalize(across()); }
  [[nodiscard]] double area() const { return 0.5 * glm::length(across()); }
  [[nodiscard]] glm::dvec3 middle() const { return (a + b + c) / 3.0; }
};
inline constexpr double kRadiance = 3, kFloorAlbedo = 0.5;

struct LampScene {
  Scene scene;
  std::vector<TriangleLamp> lamps;  // of which lamp i emits in channel i
};

inline void add_triangle_lamp(LampScene& made, TriangleLamp lamp) {
  glm::vec3 emission(0);
  emission[int(made.lamps.size())] = float(kRadiance);
  Primitive triangle;
  add_triangle(triangle, lamp.a, lamp.b, lamp.c);
  lamp.material = std::uint32_t(made.scene.materials.size());
  add_mesh(made.scene, "lamp", std::move(triangle), lambert(glm::vec3(0), emission));
  made.lamps.push_back(lamp);
}

inline Material perfect_mirror() {
  Material mirror;
  mirror.roughness = 0;
  mirror.metallic = 1;
  return mirror;
}

inline void add_matte_floor(Scene& scene, float half) {
  Primitive floor;
  add_quad(floor, {-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half});
  add_mesh(scene, "floor", std::move(floor), lambert(float(kFloorAlbedo)));
}

/// A wavefront of such a scene.
class LampWavefront {
 public:
  LampWavefront(LampScene made, const Settings& settings) : made_(std::move(made)), settings_(settings) {
    Execution execution;
    execution.fused = false;  // so that paths can be watched
    execution_ = as_tested(execution);
    const Features features = features_of(made_.scene, settings_, execution_);
    const DeviceInfo info = open_devices->pool.select(execution_.devices, execution_.threads).front();
    packed_ = pack_scene(made_.scene, features, settings_);
    add_accel(packed_, execution_.accel, configure(info, execution_).layout, execution_.threads);
    device_.emplace(open_devices->pool.take(info));
    wavefront_ = std::make_unique<Wavefront>(**device_, packed_, features, settings_, execution_);
    if (settings.light_path_count > 0) read_starts();
  }

  /// Another image, with a program that has the same stages.
  void restart(const Settings& settings) {
    settings_ = settings;
    wavefront_->restart(settings_, execution_);
  }
  Wavefront* operator->() { return wavefront_.get(); }
  [[nodiscard]] const Settings& settings() const { return settings_; }
  [[nodiscard]] const PackedScene& packed() const { return packed_; }
  [[nodiscard]] const Material& material_of(std::uint32_t triangle) const {
    return made_.scene.materials[packed_.triangles[triangle].material];
  }
  /// The lamp that a triangle is, or null.
  [[nodiscard]] const TriangleLamp* lamp_of(std::uint32_t triangle) const {
    for (const TriangleLamp& lamp : made_.lamps)
      if (packed_.triangles[triangle].material == lamp.material) return &lamp;
    return nullptr;
  }
  [[nodiscard]] const std::vector<TriangleLamp>& lamps() const { return made_.lamps; }
  [[nodiscard]] int channel_of(const TriangleLamp& lamp) const { return int(&lamp - made_.lamps.data()); }

 private:
  LampScene made_;
  Settings settings_;
  Execution execution_;
  PackedScene packed_;
  std::optional<DevicePool::Lease> device_;
  std::unique_ptr<Wavefront> wavefront_;  // destroyed before its device and its scene

  /// The packed scene says how likely each lamp is and how its light paths are aimed. The rest
  /// follows from that.
  void read_starts() {
    double all = 0;
    for (std::size_t i = 0; i < packed_.lights.size(); ++i)
      for (TriangleLamp& lamp : made_.lamps)
        if (packed_.triangles[packed_.lights[i].triangle].material == lamp.material) {
          lamp.start_m2 = double(packed_.emission_pdf[i]);
          lamp.aim_sr = double(packed_.emission_aim[i + 1]);
          all += lamp.start_m2 * lamp.area();
        }
    EXPECT_NEAR(all, 1, 1e-5) << "each light path starts from some lamp";
  }
};

}  // namespace eikon::test
