// SPDX-License-Identifier: Apache-2.0
#include "pack/frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "film/layers.h"
#include "pack/materials/camera_medium.h"
#include "pack/origin.h"
#include "scene/endless.h"

namespace eikon {
namespace {

float4 pack_vector(const glm::dvec3& v, double w = 0) { return {float(v.x), float(v.y), float(v.z), float(w)}; }

// The distance by which the plane at `eye` can move along the unit vector `dir` and stay in front
// of the whole scene. Rays that begin near the scene have origins as precise as its own
// coordinates, however far away the camera is.
double clear_way(const PackedScene& packed, const glm::dvec3& eye, const glm::dvec3& dir) {
  const Bounds& bounds = packed.bounds;
  if (bounds.empty()) return 0;
  for (std::size_t i = packed.triangle_count(); i < packed.triangles.size(); ++i)
    if (is_endless_box(&packed.triangles[i].p0_x)) return 0;  // an endless shape may be anywhere
  const glm::dvec3 half = 0.5 * (bounds.hi - bounds.lo), center = 0.5 * (bounds.hi + bounds.lo);
  const double size = glm::length(half);
  // A sixteenth of the scene's size is left, so that rounding does not matter. It is a float
  // because the kernels add it.
  return double(float(std::max(0.0, glm::dot(center - eye, dir) - glm::dot(half, glm::abs(dir)) - 0x1p-4 * size)));
}

/// Sets the inverse of the camera (kernels/film/camera_connection.h), and what light paths need
/// besides.
void set_light_paths(Frame& frame, const PackedScene& packed, const Settings& settings) {
  if (packed.light_targets.empty() || settings.light_path_count == 0) return;
  const auto vector = [](const float4& v) { return glm::dvec3(v.x, v.y, v.z); };
  const glm::dvec3 x = vector(frame.camera_x), y = vector(frame.camera_y), corner = vector(frame.camera_corner);
  const glm::dvec3 across = glm::cross(x, y);
  const bool parallel = settings.camera.projection == Projection::orthographic;
  if (settings.camera.projection == Projection::panorama) {
    const double pixels = double(settings.width) * settings.height;
    frame.film_normal = pack_vector(corner, pixels / (2 * std::numbers::pi * std::numbers::pi));
  } else {
    // The dual basis of the sides of a pixel; both lie across the axis, as `across` does along it.
    const double area2 = glm::dot(across, across);
    const glm::dvec3 dual_x = glm::cross(y, across) / area2, dual_y = glm::cross(across, x) / area2;
    const glm::dvec3 origin = parallel ? glm::dvec3(0) : corner;  // parallel rays start from the film's corner
    const double along = glm::dot(across, corner);
    frame.film_dual_x = pack_vector(dual_x, -glm::dot(dual_x, origin));
    frame.film_dual_y = pack_vector(dual_y, -glm::dot(dual_y, origin));
    frame.film_normal = pack_vector(across / along, 1 / std::abs(along));
  }
  frame.light_target_count = std::uint32_t(packed.light_targets.size());
  frame.emission_light_count = std::uint32_t(packed.emission_alias_table.size());
  frame.environment_emission = packed.environment_emission;
  frame.light_path_count = std::uint32_t(settings.light_path_count);
  frame.crop_begin = settings.crop.x0 | settings.crop.y0 << 16;
  frame.crop_end = settings.crop.x1 | settings.crop.y1 << 16;
}

/// Sets the radius in which the first photons are gathered: that of kPhotonPixels pixels, seen
/// where the scene is. Caustics are blurred over it at first (kernels/lights/README.md).
void set_photons(Frame& frame, const PackedScene& packed, const Settings& settings) {
  if (!settings.merges_caustics || packed.bounds.empty()) return;
  constexpr double kPhotonPixels = 2;
  const Camera& camera = settings.camera;
  const glm::dvec3 half = 0.5 * (packed.bounds.hi - packed.bounds.lo), center = packed.bounds.lo + half;
  // A camera in the middle of a room sees its walls.
  const double distance =
      std::max(glm::length(center - glm::dvec3(camera.world_from_camera[3])), 0.5 * glm::length(half));
  double pixel = 2 * std::tan(0.5 * camera.yfov_rad) / settings.height * distance;
  if (camera.projection == Projection::orthographic) pixel = 2 * camera.ymag_m / settings.height;
  if (camera.projection == Projection::panorama) pixel = std::numbers::pi / settings.height * distance;
  frame.photon_radius2 = float(kPhotonPixels * kPhotonPixels * pixel * pixel);
}

void set_sampling(Frame& frame, const Settings& settings) {
  frame.seed = settings.seed;
  frame.replicate_bits = settings.replicate_bits;
  frame.max_depth = settings.max_depth;
  frame.roulette_depth = settings.roulette_depth;
  frame.roulette = settings.roulette_survival;
  if (settings.guide != nullptr) set_guide(frame, *settings.guide);
}

/// Sets where a camera stands. ahead_m: by which an orthographic camera's plane moves towards the
/// scene
void set_camera(Frame& frame, const Camera& camera, const Settings& settings, double ahead_m) {
  const glm::dmat4& m = camera.world_from_camera;
  const glm::dvec3 right = glm::normalize(glm::dvec3(m[0])), up = glm::normalize(glm::dvec3(m[1])),
                   back = glm::normalize(glm::dvec3(m[2]));
  const bool parallel = camera.projection == Projection::orthographic;
  const double half_height = half_height_m(camera);
  const double pixel = 2 * half_height / settings.height;  // side of a pixel; perspective: on the plane at distance 1
  const glm::dvec3 corner = up * half_height - right * (0.5 * pixel * settings.width);
  frame.camera_x = pack_vector(right * pixel);
  frame.camera_y = pack_vector(up * -pixel);
  const glm::dvec3 eye(m[3]);
  if (camera.projection == Projection::panorama) {
    frame.camera_origin = pack_vector(eye);
    frame.camera_x = pack_vector(right, 1.0 / settings.width);
    frame.camera_y = pack_vector(up, 1.0 / settings.height);
    frame.camera_corner = pack_vector(back);
  } else if (parallel) {
    frame.camera_origin = pack_vector(eye + corner - back * ahead_m, ahead_m);
    frame.camera_corner = pack_vector(-back);
  } else {
    frame.camera_origin = pack_vector(eye);
    frame.camera_corner = pack_vector(corner - back);
  }
  if (const double radius = lens_radius_m(camera); radius > 0) {
    frame.lens_x = pack_vector(right * radius, 1.0 / camera.lens->focus_distance_m);
    frame.lens_y = pack_vector(up * radius);
  }
}

/// Appends the words by which kernels project points on the film.
void append_projection(const Camera& camera, const Settings& settings, std::vector<float>& words) {
  const glm::dmat4& m = camera.world_from_camera;
  const bool parallel = camera.projection == Projection::orthographic;
  const double half_height = half_height_m(camera);
  const double pixels = 0.5 * settings.height / half_height;  // of a metre: on the plane at distance 1 if rays diverge
  for (const glm::dvec3& row :
       {glm::dvec3(m[3]), glm::normalize(glm::dvec3(m[0])) * pixels, glm::normalize(glm::dvec3(m[1])) * pixels,
        parallel ? glm::dvec3(0) : -glm::normalize(glm::dvec3(m[2]))})
    for (int axis = 0; axis < 3; ++axis) words.push_back(float(row[axis]));
  words.push_back(parallel ? 1.0F : 0.0F);
  words.insert(words.end(), 3, 0.0F);  // up to EK_MOTION_CAMERA_WORDS
}

}  // namespace

std::vector<float> camera_pose_words(const PackedScene& packed, const Settings& in_world) {
  const Settings settings = seen_from_origin(in_world, packed.origin);
  std::vector<float> words;
  for (const Camera& camera : settings.camera_poses) {
    Frame frame{};
    set_camera(frame, camera, settings, 0);
    for (const float4& v :
         {frame.camera_origin, frame.camera_x, frame.camera_y, frame.camera_corner, frame.lens_x, frame.lens_y})
      words.insert(words.end(), {v.x, v.y, v.z, v.w});
  }
  if (!needs_sum(settings.aovs, FilmSum::motion)) return words;
  for (const Camera& camera : {settings.camera, settings.next_camera.value_or(settings.camera)})
    append_projection(camera, settings, words);
  return words;
}

Frame pack_frame(const PackedScene& packed, const Settings& in_world) {
  const Settings settings = seen_from_origin(in_world, packed.origin);
  Frame frame{};
  frame.origin = pack_vector(packed.origin);
  const Camera& camera = settings.camera;
  const glm::dvec3 eye(camera.world_from_camera[3]), back = glm::normalize(glm::dvec3(camera.world_from_camera[2]));
  // A camera that moves keeps its plane, so that distances along rays are those from where it is.
  const bool parallel = camera.projection == Projection::orthographic && settings.camera_poses.empty();
  set_camera(frame, camera, settings, parallel ? clear_way(packed, eye, -back) : 0);
  frame.pose_steps = packed.pose_steps;
  frame.camera_medium = camera_medium(packed, eye, -back);  // of parallel rays: at the origin of the middle one
  frame.environment = pack_vector(glm::dvec3(settings.environment.radiance), packed.environment_probability);
  if (const EnvironmentMap* const map = settings.environment.map.get()) {
    frame.environment = {};
    frame.environment_width = map->width;
    frame.environment_height = map->height;
  }
  frame.environment_sin = float(std::sin(settings.environment.rotation_rad));
  frame.environment_cos = float(std::cos(settings.environment.rotation_rad));
  if (!packed.bounds.empty()) {
    // Half the extent is measured from the rounded centre and rounded up, so that the box contains
    // the scene.
    const glm::vec3 center = glm::vec3(0.5 * (packed.bounds.lo + packed.bounds.hi));
    const glm::dvec3 half = glm::max(packed.bounds.hi - glm::dvec3(center), glm::dvec3(center) - packed.bounds.lo);
    frame.scene_center = pack_vector(center);
    frame.scene_half = pack_vector(half * (1.0 + 0x1p-20));
  }
  set_sampling(frame, settings);
  frame.light_count = std::uint32_t(packed.light_alias_table.size());
  frame.tree_light_count = packed.tree_light_count;
  frame.light_scale = packed.light_scale;
  set_light_paths(frame, packed, settings);
  set_photons(frame, packed, settings);
  return frame;
}

void set_guide(Frame& frame, const GuideTable& guide) {
  frame.guide_scale = guide.scale;
  frame.guide_slot_mask = guide.slot_mask();
  frame.guided_roulette_depth = guide.roulette_depth;
}

Frame unit_frame(Frame frame, std::uint64_t sample_begin, std::uint64_t sample_end, std::uint32_t pixel_count) {
  frame.pixel_count = pixel_count;
  frame.pixel_stride = pixel_count + EK_PAD;
  frame.sample_count = std::uint32_t(sample_end - sample_begin);
  frame.path_count = frame.pixel_count * frame.sample_count;
  frame.sample_begin = std::uint32_t(sample_begin);
  frame.sample_high = std::uint32_t(sample_begin >> 32);
  return frame;
}

}  // namespace eikon
