// SPDX-License-Identifier: Apache-2.0
// The flags of a render: of `eikon render`, and of each line of a batch.
#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "job/checkpoint.h"
#include "cli/png_options.h"
#include "cli/scene_options.h"

namespace eikon {

struct RenderOptions {
  SceneOptions scene;
  Execution execution;
  CheckpointOptions checkpoint;
  std::string output, stats, profile, pixel;
  PngOptions png;
  bool half = false, quiet = false;
  std::string sample, progress = "bar";
  std::string settings_text;  // of parse_render: every flag that decides the results, and its value

  /// Adds the flags to a subcommand. The object must live as long as the parser.
  void add_to(CLI::App& command);
  /// -o, or SCENE.exr in the current folder.
  [[nodiscard]] std::filesystem::path exr() const;
  /// Beside `file`, for the light that was scattered at most `most` times (--depth-series): "room.exr", 2 -> "room.depth2.exr".
  [[nodiscard]] static std::filesystem::path partial(const std::filesystem::path& file, std::uint32_t most);
  /// The files that a finished render leaves.
  [[nodiscard]] std::vector<std::filesystem::path> results() const;
  /// Every file that it writes.
  [[nodiscard]] std::vector<std::filesystem::path> outputs() const;
  /// Whether one path is to be traced and told, rather than a picture rendered.
  [[nodiscard]] bool is_replay() const { return !pixel.empty() || !sample.empty(); }
};

/// What follows `eikon render` on a command line, already split into words. throws UsageError
[[nodiscard]] RenderOptions parse_render(std::vector<std::string> words);

}  // namespace eikon
