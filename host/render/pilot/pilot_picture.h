// SPDX-License-Identifier: Apache-2.0
// The small picture that a pilot renders, of few pixels with many samples each: a wavefront, and
// its units one by one.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

#include "render/pilot/pilot.h"
#include "render/ready_wavefronts.h"

namespace eikon {

/// A pilot's picture has at most so many pixels, of which each is a block of the image: errors are
/// measured in them.
inline constexpr std::uint32_t kMaxPilotPixels = 512;

/// The settings of a picture of about so many pixels that shows the whole image, with as many light
/// paths for each pixel as the image has.
[[nodiscard]] Settings pilot_picture_settings(const Settings& settings, double pixels);

/// A unit that was rendered: whole rows of the picture, and a range of samples.
struct PilotUnit {
  const UnitResult& result;
  PathLog log;                  // empty unless PilotPicture::render() was asked for logs
  std::size_t first_pixel = 0;  // row by row
  std::size_t pixels = 0;
  std::uint64_t sample_begin = 0;
};

/// The device, the scene and the settings with which a pilot's picture is rendered. All must
/// outlive it.
struct PilotContext {
  DevicePool::Lease& device;
  const ReadyWavefronts::SharedScene& scene;
  const Features& features;
  const Execution& execution;
  PilotSteps& steps;
};

class PilotPicture {
 public:
  using Use = std::function<void(const PilotUnit&)>;

  /// settings  of the picture
  /// largest   paths that render() may be asked for at once. The size of units follows from it and
  ///           from the memory that there is, and changes nothing of what they bring
  /// throws DeviceError, also when the device has not even the memory for small units
  PilotPicture(const PilotContext& context, const Settings& settings, std::uint64_t largest);

  /// Goes on with another picture, of the same channels and replicates.
  void restart(const Settings& settings);
  /// Renders samples of each pixel, and hands over each unit when it has ended.
  /// logs  whether the units have their logs; of a program with feature path_log
  void render(std::uint64_t sample_begin, std::uint64_t sample_end, bool logs, const Use& use);

  [[nodiscard]] const Settings& settings() const { return settings_; }
  [[nodiscard]] std::size_t pixel_count() const { return settings_.crop.pixel_count(); }
  [[nodiscard]] Wavefront& wavefront() { return *wavefront_; }

 private:
  Settings settings_;
  Execution execution_;
  PilotSteps& steps_;
  Wavefront* wavefront_;  // of the device's guest
};

/// The means of a picture's pixels, each with its neighbours: one that is too low by chance would
/// otherwise count for too much where errors are relative to it.
[[nodiscard]] std::vector<double> smoothed(const std::vector<double>& means, std::uint32_t width);
/// The number that a pixel's squared error is divided by, to make it relative. Dark pixels count as
/// if they had a tenth of the picture's mean.
/// mean  of the pixel
/// all   mean of the whole picture
[[nodiscard]] inline double pilot_error_scale(double mean, double all) { return mean * mean + 0.01 * all * all; }

}  // namespace eikon
