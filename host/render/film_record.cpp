// SPDX-License-Identifier: Apache-2.0
#include "render/film_record.h"

#include <algorithm>
#include <array>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"
#include "film/layers.h"
#include "io/text.h"
#include "io/xxhash64.h"
#include "render/pilot/pilot.h"

namespace eikon {
namespace {

constexpr const char* kChannelsName = "set of channels (--aov, --transparent)";
constexpr const char* kDepthLimitName = "depth limit (--max-depth)";
constexpr const char* kDirectDepthName = "depth limit (--integrator direct, --max-depth)";  // where it is 2
constexpr const char* kRouletteDepthName = "roulette depth";
constexpr const char* kVersionName = "version of image bits";
constexpr const char* kCullingName = "culling (--cull)";
constexpr const char* kGuidingName = "guiding (--guiding)";
constexpr const char* kNotGuided = "off";
constexpr const char* kLightPathsName = "light paths (--light-paths)";
constexpr const char* kCausticsName = "caustics (--caustics)";

std::string triple(const glm::dvec4& v) { return fmt::format("{},{},{}", v.x, v.y, v.z); }

/// A text that is the same for environments with the same light: it has a hash of the map's pixels
/// instead of the file's name. The rotation of a uniform sky does not count.
std::string identity_of(const Environment& environment) {
  if (!environment.map)
    return fmt::format("{},{},{}", environment.radiance.x, environment.radiance.y, environment.radiance.z);
  const EnvironmentMap& map = *environment.map;
  return fmt::format("map {:016x} of {}x{}, scale {}, rotation {}",
                     xxhash64(std::as_bytes(std::span(map.radiance)), map.width), map.width, map.height,
                     environment.scale, environment.rotation_rad);
}

/// Parses `count` unsigned numbers from "a b c"; returns nothing for any other text.
template <std::size_t count>
std::optional<std::array<std::uint64_t, count>> numbers(std::string_view text) {
  std::array<std::uint64_t, count> values{};
  const std::vector<std::string> words = split(text, ' ');
  if (words.size() != count) return std::nullopt;
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = number_in<std::uint64_t>(words[i]);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return values;
}

void parse_part(std::string_view text, const FilmLayout& layout, SampleSet& done) {
  const auto n = numbers<6>(text);
  const Crop& crop = layout.crop;
  if (!n || (*n)[0] < crop.x0 || (*n)[0] >= (*n)[2] || (*n)[2] > crop.x1 || (*n)[1] < crop.y0 || (*n)[1] >= (*n)[3] ||
      (*n)[3] > crop.y1 || (*n)[4] >= (*n)[5] || (*n)[5] > kMaxSamples ||
      (*n)[5] - (*n)[4] > kMaxImagePaths / crop.pixel_count())
    throw InputError(fmt::format("its record of samples has an impossible part, '{}'", text));
  const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>((*n)[i]); };
  const WorkUnit part{{at(0), at(1), at(2), at(3)}, (*n)[4], (*n)[5]};
  if (done.overlap(part)) throw InputError(fmt::format("its record of samples has the part '{}' twice", text));
  done.add(part);
}

std::string channels_and_mattes(const FilmLayout& layout) {
  std::vector<std::string> names = layout.channels;
  names.insert(names.end(), layout.mattes.begin(), layout.mattes.end());
  return fmt::format("{}", fmt::join(names, ","));
}

std::string describe_view(const Camera& camera) {
  switch (camera.projection) {
    case Projection::perspective:
      return fmt::format("{} rad", camera.yfov_rad);
    case Projection::orthographic:
      return fmt::format("orthographic, {} m", 2 * camera.ymag_m);
    case Projection::panorama:
      return "panorama";
  }
  return {};
}

std::string describe_lens(const Camera& camera) {
  const double radius_m = lens_radius_m(camera);
  return radius_m > 0 ? fmt::format("radius {} m, in focus at {} m", radius_m, camera.lens->focus_distance_m)
                      : "pinhole";
}

/// The same settings make the same pilot, so its size is all that is left to say.
std::string describe_guiding(Guiding guiding, std::uint64_t paths) {
  return paths == 0 ? kNotGuided : fmt::format("{}, by {} paths", name_of(guiding), paths);
}

/// If a trial decides on the number, it is not a setting: FilmRecord::light_path_counts has it.
std::string describe_light_paths(std::uint64_t count, std::uint64_t trial_paths) {
  if (trial_paths > 0) return fmt::format("auto, by {} paths", trial_paths);
  return count == 0 ? "none" : fmt::format("{} of each sample", count);
}

/// True for a setting that other flags than its own change, too: --integrator limits the depth,
/// --roulette moves its own depth, and --light-paths and --transparent add channels.
bool follows_from_others(const std::string& name) {
  return name == kDepthLimitName || name == kRouletteDepthName || name == kChannelsName;
}

/// Names a channel that only one of two lists has, and the flag that asks for it.
std::string difference_of_channels(const std::string& expected, const std::string& found) {
  const std::vector<std::string> wanted = split(expected, ','), there = split(found, ',');
  const auto beyond = [](const std::vector<std::string>& all, const std::vector<std::string>& known) {
    std::vector<std::string> more;
    for (const std::string& name : all)
      if (std::ranges::find(known, name) == known.end()) more.push_back(name);
    return more;
  };
  const std::vector<std::string> missing = beyond(wanted, there), more = beyond(there, wanted);
  const std::vector<std::string>& apart = missing.empty() ? more : missing;
  if (apart.empty()) return "its channels are in another order: another version of eikon wrote it";
  return fmt::format("its channels ({}) {} {}{}", bound_of(apart.front()) ? "--depth-series" : "--aov",
                     missing.empty() ? "have, beyond those asked for," : "lack", apart.front(),
                     apart.size() > 1 ? fmt::format(" and {} more", apart.size() - 1) : "");
}

std::string difference(const ImageSetting& expected, const ImageSetting& found) {
  if (expected.name == kChannelsName) return difference_of_channels(expected.value, found.value);
  const bool may_be_direct = found.name == kDepthLimitName && (found.value == "2" || expected.value == "2");
  return fmt::format("its {} is {}, not {}{}", may_be_direct ? kDirectDepthName : found.name, found.value,
                     expected.value, expected.name == kVersionName ? ": another version of eikon wrote it" : "");
}

const char* describe_caustics(bool merged) { return merged ? "merge" : "unbiased"; }

}  // namespace

std::vector<ImageSetting> image_settings(const Scene& scene, const Settings& settings, const FilmLayout& layout) {
  // A new member of Settings fails to compile here. Its author then decides whether image bits
  // depend on it, and adds it below if so.
  const auto& [width, height, crop, sample_begin, sample_end, likely_samples, seed, replicate_bits, max_depth,
               integrator, roulette_depth, roulette_survival, energy_compensation, culling, light_sampling,
               light_samples, aovs, depth_series, filter, transparent, light_path_count, light_trial_paths, light_aim,
               merges_caustics, guiding, pilot_paths, guide, camera, next_camera, camera_poses, environment] = settings;
  static_cast<void>(crop), static_cast<void>(sample_begin), static_cast<void>(sample_end);
  static_cast<void>(likely_samples);
  static_cast<void>(guide), static_cast<void>(light_aim);  // they follow from the pilot
  // The scene's hash depends on the shutter and on the time of the next frame.
  static_cast<void>(camera_poses), static_cast<void>(next_camera);
  static_cast<void>(aovs), static_cast<void>(depth_series);  // the channels depend on them
  const glm::dmat4& pose = camera.world_from_camera;
  // Sampling by the BSDF keeps the name that files of earlier versions have, so that they merge
  // and resume.
  const char* const sampling = light_sampling == LightSampling::bsdf ? "cosine" : name_of(light_sampling);
  return {{kVersionName, fmt::format("{}", kImageVersion)},
          {"scene's hash", scene.hash},
          {"size (--size)", fmt::format("{}x{}", width, height)},
          {"seed (--seed)", fmt::format("{}", seed)},
          {"number of replicates", fmt::format("{}", 1U << replicate_bits)},
          {kChannelsName, channels_and_mattes(layout)},
          {"transparency (--transparent)", transparent ? "on" : "off"},
          {"filter (--filter)", filter.name()},
          {kDepthLimitName, fmt::format("{}", max_depth)},
          {kRouletteDepthName, fmt::format("{}", roulette_depth)},
          {"roulette (--roulette)", roulette_survival > 0 ? fmt::format("{}", roulette_survival) : "by throughput"},
          {"integrator (--integrator)", name_of(integrator)},
          {"energy compensation (--energy-compensation)", energy_compensation ? "on" : "off"},
          {"light sampling (--light-sampling, --light-samples)",
           light_samples == 1 ? sampling : fmt::format("{}, {} times", sampling, light_samples)},
          {"camera's position (--camera, --look-at)", triple(pose[3])},
          {"camera's orientation (--camera, --look-at)",
           fmt::format("{} {} {}", triple(pose[0]), triple(pose[1]), triple(pose[2]))},
          {"field of view (--fov)", describe_view(camera)},
          {"lens (--f-number, --focus-distance)", describe_lens(camera)},
          {"environment (--env, --env-scale, --env-rotate)", identity_of(environment)},
          {kCullingName, name_of(culling)},
          {kGuidingName, describe_guiding(guiding, pilot_paths)},
          {kLightPathsName, describe_light_paths(light_path_count, light_trial_paths)},
          {kCausticsName, describe_caustics(merges_caustics)}};
}

std::optional<std::string> difference(const std::vector<ImageSetting>& expected,
                                      const std::vector<ImageSetting>& found) {
  if (expected == found) return std::nullopt;
  std::optional<std::string> first;
  for (std::size_t i = 0; i < std::min(expected.size(), found.size()); ++i) {
    if (expected[i].name != found[i].name) break;
    if (expected[i].value == found[i].value || (first && follows_from_others(expected[i].name))) continue;
    first = difference(expected[i], found[i]);
    if (!follows_from_others(expected[i].name)) break;
  }
  return first.value_or("other settings count in it: another version of eikon wrote it");
}

void agree_on_pilot(FilmState& begin, const Settings& settings, const PilotReport& pilot,
                    std::vector<std::string>& notes) {
  if (pilot.guiding_paths > 0)
    begin.guiding.insert(pilot.roulette_depth == 0 ? kNotGuided : fmt::format("{:016x}", pilot.guiding_digest));
  if (std::string note = note_of_guiding(begin.guiding); !note.empty()) notes.push_back(std::move(note));
  if (settings.light_trial_paths == 0) return;
  const std::set<std::uint64_t> now = {settings.light_path_count};
  if (!begin.light_path_counts.empty() && begin.light_path_counts != now)
    throw InputError(
        fmt::format("the sums to go on from have {} light paths of each sample, and the pilot on this device "
                    "decides on {}: go on with the devices that began, or share their pilot by --pilot",
                    *begin.light_path_counts.begin(), settings.light_path_count));
  begin.light_path_counts = now;
}

std::string note_of_guiding(const std::set<std::string>& guiding) {
  if (guiding.size() < 2) return {};
  return "some samples are guided by other tables than others, or by none: the image has no bias, but other bits than "
         "one that a single pilot guides; a device may have had too little memory for the tables";
}

std::string to_text(const FilmRecord& record) {
  std::string text;
  for (const ImageSetting& setting : record.settings)
    text += fmt::format("setting {}: {}\n", setting.name, setting.value);
  for (const std::string& name : record.arithmetic) text += fmt::format("arithmetic {}\n", name);
  for (const std::uint64_t count : record.light_path_counts) text += fmt::format("light-paths {}\n", count);
  for (const std::string& table : record.guiding) text += fmt::format("guiding {}\n", table);
  for (const std::string& layer : record.layers) text += fmt::format("layer {}\n", layer);
  for (const auto& [layer, manifest] : record.manifests) text += fmt::format("manifest {} {}\n", layer, manifest);
  for (const WorkUnit& part : record.sample_set.parts())
    text += fmt::format("part {} {} {} {} {} {}\n", part.block.x0, part.block.y0, part.block.x1, part.block.y1,
                        part.sample_begin, part.sample_end);
  return text;
}

FilmRecord parse_film_record(std::string_view text, const FilmLayout& layout) {
  FilmRecord record;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) throw InputError("its record of samples ends within a line");
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string_view kind = line.substr(0, space), rest = line.substr(std::min(space + 1, line.size()));
    const std::size_t colon = rest.find(": ");
    if (kind == "setting" && colon != std::string_view::npos)
      record.settings.push_back({std::string(rest.substr(0, colon)), std::string(rest.substr(colon + 2))});
    else if (kind == "arithmetic")
      record.arithmetic.emplace(rest);
    else if (kind == "light-paths" && number_in<std::uint64_t>(rest))
      record.light_path_counts.emplace(*number_in<std::uint64_t>(rest));
    else if (kind == "guiding")
      record.guiding.emplace(rest);
    else if (kind == "layer")
      record.layers.emplace(rest);
    else if (kind == "manifest" && rest.find(' ') != std::string_view::npos)
      record.manifests.emplace(rest.substr(0, rest.find(' ')), rest.substr(rest.find(' ') + 1));
    else if (kind == "part")
      parse_part(rest, layout, record.sample_set);
    else
      throw InputError(fmt::format("its record of samples has a line that says nothing, '{}'", line));
  }
  // Files of before there were culling, guiding, light paths and photons do not name them.
  const auto say = [&](const char* name, const char* value) {
    if (!record.settings.empty() &&
        std::ranges::find(record.settings, name, &ImageSetting::name) == record.settings.end())
      record.settings.push_back({name, value});
  };
  say(kCullingName, name_of(Culling::none));
  say(kGuidingName, kNotGuided);
  say(kLightPathsName, describe_light_paths(0, 0).c_str());
  say(kCausticsName, describe_caustics(false));
  return record;
}

}  // namespace eikon
