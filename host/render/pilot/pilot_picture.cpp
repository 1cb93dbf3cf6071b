// SPDX-License-Identifier: Apache-2.0
#include "render/pilot/pilot_picture.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "pack/seeds.h"
#include "wavefront/memory_need.h"

namespace eikon {
namespace {

/// Returns the execution whose units have room for `largest` paths, or for fewer where the device
/// lacks the memory. throws DeviceError if it lacks the memory for the smallest units, too
Execution with_unit_paths(const PilotContext& context, const Settings& settings, std::uint64_t largest) {
  const DeviceInfo& info = context.device->info();
  const auto most_paths = std::uint32_t(std::min<std::uint64_t>(std::bit_ceil(largest), kMaxPilotUnitPaths));
  Execution execution =
      fit_units(*context.scene, info, context.features, settings, context.execution, {.most_paths = most_paths});
  require_memory(memory_need(*context.scene, configure(info, execution), context.features, settings), info, execution);
  return execution;
}

}  // namespace

Settings pilot_picture_settings(const Settings& settings, double pixels) {
  Settings picture = settings;
  pixels = std::clamp(pixels, 1.0, double(kMaxPilotPixels));
  const double aspect = double(settings.width) / double(settings.height);
  const auto side = [](double x) { return std::uint32_t(std::clamp(std::round(x), 1.0, double(kMaxPilotPixels))); };
  picture.height = side(std::sqrt(pixels / aspect));
  picture.width = side(pixels / picture.height);
  picture.crop = {0, 0, picture.width, picture.height};
  picture.replicate_bits = 1;
  const double scale = double(picture.crop.pixel_count()) / (double(settings.width) * settings.height);
  if (settings.light_path_count > 0)
    picture.light_path_count =
        std::max<std::uint64_t>(std::uint64_t(std::llround(double(settings.light_path_count) * scale)), 1);
  picture.seed = kPilotSeed;
  return picture;
}

PilotPicture::PilotPicture(const PilotContext& context, const Settings& settings, std::uint64_t largest)
    : settings_(settings), execution_(with_unit_paths(context, settings, largest)), steps_(context.steps) {
  wavefront_ =
      &ReadyWavefronts::of(context.device).get(context.device, context.scene, context.features, settings_, execution_);
}

void PilotPicture::restart(const Settings& settings) {
  settings_ = settings;
  wavefront_->restart(settings_, execution_);
}

void PilotPicture::render(std::uint64_t sample_begin, std::uint64_t sample_end, bool logs, const Use& use) {
  const std::uint32_t capacity = wavefront_->config().capacity();
  const std::uint32_t rows = std::max(1U, std::min(settings_.height, capacity / settings_.width));
  for (std::uint64_t next = sample_begin; next < sample_end;) {
    const std::uint64_t most = std::max<std::uint64_t>(capacity / (std::uint64_t{rows} * settings_.width), 1);
    const std::uint64_t until = std::min(sample_end, next + most);
    for (std::uint32_t y = 0; y < settings_.height; y += rows) {
      const std::uint32_t height = std::min(rows, settings_.height - y);
      const std::size_t pixels = std::size_t{height} * settings_.width;
      steps_.begin_unit(pixels * (until - next));
      wavefront_->begin({{0, y, settings_.width, y + height}, next, until});
      const UnitResult result = wavefront_->finish();
      const PathLog log = logs ? wavefront_->path_log() : PathLog{};
      steps_.end_unit();
      use({result, log, std::size_t{y} * settings_.width, pixels, next});
    }
    next = until;
  }
}

std::vector<double> smoothed(const std::vector<double>& means, std::uint32_t width) {
  std::vector<double> result(means.size());
  const auto columns = int(width), rows = int(means.size() / width);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      double around = 0, count = 0;
      for (int j = std::max(y - 1, 0); j < std::min(y + 2, rows); ++j)
        for (int i = std::max(x - 1, 0); i < std::min(x + 2, columns); ++i)
          around += means[std::size_t(j) * width + std::size_t(i)], ++count;
      result[std::size_t(y) * width + std::size_t(x)] = around / count;
    }
  return result;
}

}  // namespace eikon
