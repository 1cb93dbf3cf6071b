// SPDX-License-Identifier: Apache-2.0
#include "pack/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "core/error.h"
#include "core/host_limits.h"
#include "io/text.h"

namespace eikon {

const char* name_of(Integrator integrator) {
  return std::array{"path", "whitted", "raycast"}.at(std::size_t(integrator));
}

const char* name_of(LightSampling sampling) {
  return std::array{"mis", "light", "bsdf", "hemisphere"}.at(std::size_t(sampling));
}

const char* name_of(Guiding guiding) { return std::array{"auto", "on", "off"}.at(std::size_t(guiding)); }
const char* name_of(Culling culling) { return culling == Culling::camera ? "camera" : "none"; }

bool moves(const Scene& scene, const Settings& settings) {
  return scene.moves_surfaces || scene.moves_lights || !settings.camera_poses.empty();
}

std::uint64_t light_paths_of_ratio(const Settings& settings, double ratio) {
  if (ratio == 0) return 0;
  constexpr std::uint64_t kMost = (std::uint64_t{1} << 31) - 1;  // of the numbers that kernels count by
  const double count = ratio * settings.width * settings.height;
  return std::clamp<std::uint64_t>(std::uint64_t(std::llround(count)), 1, kMost);
}

double expected_rays(const Settings& settings) {
  const std::uint64_t range = settings.sample_end - settings.sample_begin;
  const auto samples = double(settings.likely_samples > 0 ? std::min(range, settings.likely_samples) : range);
  // A path has about five edges, if max_depth allows, and each edge a shadow ray.
  const std::uint32_t edges = settings.max_depth == 0 ? 5 : std::min(settings.max_depth, 5U);
  return double(settings.crop.pixel_count()) * samples * 2 * edges;
}

namespace {

/// Takes a whole number from an environment variable that is set. throws UsageError
void take_number(const char* name, std::uint32_t least, std::uint32_t most, std::uint32_t& value) {
  const char* const text = std::getenv(name);
  if (text == nullptr) return;
  const auto number = number_in<std::uint32_t>(text);
  if (!number || *number < least || *number > most)
    throw UsageError(fmt::format("{}={}: takes a whole number from {} to {}", name, text, least, most));
  value = *number;
}

}  // namespace

void read_execution_environment(Execution& execution) {
  execution.thread_limit = limit_threads(execution.threads);
  if (const char* off = std::getenv("EIKON_NO_OPTIMISE")) execution.optimise = std::string(off) != "1";
  if (const char* text = std::getenv("EIKON_LANES")) {
    const std::string lanes = text;
    if (lanes != "1" && lanes != "8" && lanes != "16") throw UsageError("EIKON_LANES=" + lanes + ": takes 1, 8 or 16");
    execution.lanes = std::uint32_t(std::stoul(lanes));
    execution.chunked = lanes != "1";
  }
  if (const char* text = std::getenv("EIKON_STAGES")) {
    const std::string stages = text;
    if (stages != "fused" && stages != "unfused")
      throw UsageError("EIKON_STAGES=" + stages + ": takes fused or unfused");
    execution.fused = stages == "fused";
  }
  if (const char* text = std::getenv("EIKON_WATCHDOG")) {
    char* end = nullptr;
    const double seconds = std::strtod(text, &end);
    if (end == text || *end != '\0' || !(seconds > 0) || seconds > 1e9)
      throw UsageError(std::string("EIKON_WATCHDOG=") + text + ": takes seconds above 0");
    execution.watchdog_s = seconds;
  }
  if (const char* text = std::getenv("EIKON_TICKS")) {
    if (std::string(text) != "off") throw UsageError(std::string("EIKON_TICKS=") + text + ": takes off");
    execution.ticks = false;
  }
  take_number("EIKON_UNIT_PATHS", 64, kMaxUnitPaths, execution.unit_paths);
  // The pixels of an image are numbered by 16 bits a side.
  take_number("EIKON_UNIT_BLOCK", 1, 1U << 11, execution.block);
}

}  // namespace eikon
