// SPDX-License-Identifier: Apache-2.0
// The options of a render: of `eikon render`, and of each line of a batch.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "job/checkpoint.h"
#include "job/png_options.h"
#include "job/scene_options.h"

namespace eikon {

struct PixelIndex {
  std::uint32_t x = 0, y = 0;
};

struct RenderOptions {
  SceneOptions scene;
  Execution execution;
  CheckpointOptions checkpoint;
  std::string output, stats, profile;
  PngOptions png;
  bool half = false, quiet = false;
  std::optional<PixelIndex> pixel;      // with `sample`: trace this path instead of rendering
  std::optional<std::uint64_t> sample;
  std::string progress = "bar";
  std::string settings_text;  // of a batch: every flag that decides the results, and its value

  /// The file of -o, or SCENE.exr in the current folder.
  [[nodiscard]] std::filesystem::path exr() const;
  /// The file beside `file` for light that was scattered at most `most` times (--depth-series):
  /// room.exr -> room.depth2.exr.
  [[nodiscard]] static std::filesystem::path partial(const std::filesystem::path& file, std::uint32_t most);
  /// The files that a finished render leaves.
  [[nodiscard]] std::vector<std::filesystem::path> results() const;
  /// Every file that it writes.
  [[nodiscard]] std::vector<std::filesystem::path> outputs() const;
  /// True if a path is to be traced and printed instead of rendering.
  [[nodiscard]] bool is_replay() const { return pixel || sample; }
};

}  // namespace eikon
