// SPDX-License-Identifier: Apache-2.0
#include "job/report/metadata.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "film/mattes.h"
#include "io/text.h"

namespace eikon {
namespace {

std::vector<double> row_major(const glm::dmat4& m) {
  std::vector<double> values;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) values.push_back(m[column][row]);
  return values;
}

// The spaces of a camera are those of OpenEXR's standard attributes (ImfStandardAttributes.h),
// which are RenderMan's.

/// From the space that glTF's cameras look along -Z of, which OpenEXR's look along +Z of.
glm::dmat4 camera_from_world(const Camera& camera) {
  return glm::scale(glm::dmat4(1.0), glm::dvec3(1, 1, -1)) * glm::inverse(camera.world_from_camera);
}

/// (0, 0) and (1, 1) are the upper left and the lower right corner of the display window.
glm::dmat4 ndc_from_camera(const Settings& settings) {
  const Camera& camera = settings.camera;
  const double aspect = double(settings.width) / settings.height;
  const bool orthographic = camera.projection == Projection::orthographic;
  const double y = 1.0 / half_height_m(camera);
  glm::dmat4 clip(0.0);
  clip[0][0] = y / aspect;
  clip[1][1] = y;
  clip[2][2] = 1;
  if (orthographic) {
    clip[3][3] = 1;  // z is the depth in metres, as there is no far plane
  } else {
    clip[2][3] = 1;
    clip[3][2] = -0.02;  // near plane at 0.01 m, no far plane
  }
  const glm::dmat4 ndc_from_clip = glm::scale(glm::translate(glm::dmat4(1.0), {0.5, 0.5, 0}), {0.5, -0.5, 1});
  return ndc_from_clip * clip;
}

/// "'walk', 'blink'"
std::string animations_in_force(const Scene& scene) {
  std::vector<std::string> names;
  for (const AnimationSummary& animation : scene.animations)
    if (animation.in_force)
      names.push_back(animation.name.empty() ? fmt::format("{}", &animation - scene.animations.data())
                                             : in_quotes(animation.name));
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::string describe(const Environment& environment) {
  if (environment.map)
    return fmt::format("{}, scale {}, rotation {:.6g} degrees", environment.map->name, environment.scale,
                       environment.rotation_rad * 180.0 / std::numbers::pi);
  const glm::vec3& sky = environment.radiance;
  return fmt::format("{},{},{}", sky.x, sky.y, sky.z);
}

Metadata describe_picture(const Prepared& prepared) {
  const Settings& settings = prepared.settings;
  Metadata metadata;
  metadata.strings["scene"] = prepared.scene->path.filename().string();
  metadata.strings["sceneHash"] = prepared.scene->hash;
  metadata.strings["camera"] = prepared.camera_name;
  if (const std::string animations = animations_in_force(*prepared.scene); !animations.empty()) {
    metadata.strings["animations"] = animations;
    metadata.numbers["sceneTime"] = prepared.scene->time_s;
    if (const Shutter& shutter = prepared.scene->shutter; shutter.is_open()) {
      metadata.numbers["shutterOpen"] = shutter.open_s;
      metadata.numbers["shutterClose"] = shutter.close_s;
    }
  }
  metadata.strings["size"] = fmt::format("{}x{}", settings.width, settings.height);
  metadata.strings["environment"] = describe(settings.environment);
  metadata.strings["filter"] = settings.filter.name();
  metadata.numbers["maxDepth"] = settings.max_depth;
  // GLM's matrices act on column vectors, those of OpenEXR on row vectors: the matrices are
  // transposed.
  const glm::dmat4 to_camera = camera_from_world(settings.camera);
  metadata.matrices["worldToCamera"] = row_major(glm::transpose(to_camera));
  if (settings.camera.projection != Projection::panorama)
    metadata.matrices["worldToNDC"] = row_major(glm::transpose(ndc_from_camera(settings) * to_camera));
  return metadata;
}

Metadata describe_image(const Prepared& prepared) {
  const Settings& settings = prepared.settings;
  Metadata metadata = describe_picture(prepared);
  metadata.strings["version"] = "eikon " EIKON_VERSION;
  metadata.strings["sampleRange"] = fmt::format("{}:{}", settings.sample_begin, settings.sample_end);
  metadata.strings["lightSampling"] = name_of(settings.light_sampling);
  metadata.numbers["replicates"] = double(1U << settings.replicate_bits);
  metadata.numbers["seed"] = settings.seed;
  metadata.numbers["rouletteDepth"] = settings.roulette_depth;
  if (settings.roulette_survival > 0) metadata.numbers["roulette"] = double(settings.roulette_survival);
  if (settings.energy_compensation) metadata.strings["energyCompensation"] = "on";
  metadata.strings["cull"] = name_of(settings.culling);
  if (settings.merges_caustics) metadata.strings["caustics"] = "merge: biased, less with each sample";
  metadata.strings["integrator"] = name_of(settings.integrator);
  if (settings.light_samples > 1) metadata.numbers["lightSamples"] = settings.light_samples;
  const auto has = [&](const char* layer) {
    return std::ranges::find(prepared.layers, layer) != prepared.layers.end();
  };
  if (has("id") || has("object_id")) metadata.strings["objectNames"] = to_json(object_names(*prepared.scene));
  if (has("material_id")) metadata.strings["materialNames"] = to_json(material_names(*prepared.scene));
  return metadata;
}

std::uint64_t rejected_in(const Film& film, const SampleSet& done) {
  std::uint64_t in_sums = 0;
  const Crop& crop = film.layout().crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (const std::uint64_t count : film.row_counts(y)) in_sums += count;
  return done.sample_count() - in_sums;
}

void add_sample_counts(Metadata& metadata, const Film& film, const SampleSet& done,
                       const std::set<std::string>& arithmetic) {
  metadata.strings["arithmetic"] = fmt::format("{}", fmt::join(arithmetic, ", "));
  metadata.numbers["samples"] = double(done.sample_count());  // fewer than the range has after an interruption
  metadata.numbers["rejectedSamples"] = double(rejected_in(film, done));
}

void add_error(Metadata& metadata, const PredictedError& error) {
  for (const char* key : {"relmsePredicted", "relmsePredictedLow", "relmsePredictedHigh"}) metadata.numbers.erase(key);
  if (!error.known) return;
  metadata.numbers["relmsePredicted"] = error.relmse;
  metadata.numbers["relmsePredictedLow"] = error.lo;
  if (std::isfinite(error.hi)) metadata.numbers["relmsePredictedHigh"] = error.hi;
}

Metadata describe_render(const Prepared& prepared, const RenderOutput& done, const PredictedError& error) {
  const RenderReport& report = done.report;
  Metadata metadata = describe_image(prepared);
  add_sample_counts(metadata, done.film, done.sample_set, done.arithmetic);
  add_error(metadata, error);
  metadata.strings["features"] = report.features;
  if (report.pilot.guiding_paths > 0) {
    metadata.strings["guiding"] =
        report.pilot.roulette_depth == 0 ? "off" : fmt::format("{:016x}", report.pilot.guiding_digest);
    metadata.numbers["guidingGain"] = report.pilot.guiding_gain;
  }
  if (report.pilot.light_aim_gain > 0) metadata.numbers["lightAimGain"] = report.pilot.light_aim_gain;
  if (report.pilot.light_trial_paths > 0) metadata.numbers["lightPaths"] = double(report.pilot.light_path_count);
  std::string devices;
  for (const DeviceReport& device : report.devices)
    devices += fmt::format("{}{} ({})", devices.empty() ? "" : "; ", device.info.name, device.info.driver);
  metadata.strings["devices"] = devices;
  metadata.strings["endedBy"] = name_of(report.end);
  metadata.numbers["interrupted"] = report.interrupted() ? 1 : 0;
  metadata.numbers["renderSeconds"] = report.render_s;
  return metadata;
}

}  // namespace eikon
