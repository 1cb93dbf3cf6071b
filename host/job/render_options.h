// SPDX-License-Identifier: Apache-2.0
// The options of a render: of `eikon render`, and of each line of a batch.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "io/tcp_sender.h"
#include "job/checkpoint.h"
#include "job/sequence/frames.h"
#include "job/goal.h"
#include "job/prepare.h"

namespace eikon {

/// The PNG of --png, and how linear colours become its 8 bits.
struct PngOptions {
  static constexpr double kMaxExposureEv = 64, kMaxEv100 = 32;  // to either side of 0

  std::string file;  // empty: none is wanted
  double exposure_ev = 0;
  std::optional<double> ev100;  // instead of exposure_ev: of a camera set to it
  ToneMap tone_map{};

  /// Writes the file, if one is wanted. throws as write_png
  void write(const Image& image) const;
  /// The exposure in EV, whichever way it is given.
  [[nodiscard]] double exposure() const;
};

struct PixelIndex {
  std::uint32_t x = 0, y = 0;
};

/// Holds everything that the words of `eikon render` ask for.
struct RenderOptions {
  SceneOptions scene;
  Execution execution;
  CheckpointOptions checkpoint;
  GoalOptions goal;
  std::string output, stats, profile, report;
  std::string pilot;  // file that is read, or written if it does not exist (job/pilot_keeper.h); empty: none
  PngOptions png;
  std::optional<NetworkAddress> tev;    // of a viewer that shows the growing image
  std::optional<FrameRange> frames;     // instead of one image
  bool force = false;                   // with `frames`: also those that are done
  bool half = false, quiet = false;
  std::optional<PixelIndex> pixel;      // with `sample`: trace this path instead of rendering
  std::optional<std::uint64_t> sample;
  std::string progress = "bar";
  std::string command;  // as the user gave it, for --stats
  // A batch needs these of the words that the options were read from (parse_render).
  std::string settings_text;                      // every flag that decides the results, and its value
  std::vector<std::string> words_without_frames;  // all words but --frames, from which each frame is read
  std::string frame_pattern;            // of a frame: the name of its image, with the place of the number
  std::vector<std::string> part_words;  // `--samples` and `-o`, added to these, make a render of some of the samples

  /// Returns true if somebody will see the times of stages.
  [[nodiscard]] bool wants_stage_times() const;
  /// The file of -o, or SCENE.exr in the current folder.
  [[nodiscard]] std::filesystem::path exr() const;
  /// The file beside `file` for light that was scattered at most `most` times (--depth-series):
  /// room.exr -> room.depth2.exr.
  [[nodiscard]] static std::filesystem::path partial(const std::filesystem::path& file, std::uint32_t most);
  /// True if its image has the exact sums, so that it can be merged, and an interrupted one can go
  /// on.
  [[nodiscard]] bool keeps_sums() const { return scene.samples || scene.crop; }
  /// The files that a finished render leaves.
  [[nodiscard]] std::vector<std::filesystem::path> results() const;
  /// Every file that it writes.
  [[nodiscard]] std::vector<std::filesystem::path> outputs() const;
  /// True if a path is to be traced and printed instead of rendering.
  [[nodiscard]] bool is_replay() const { return pixel || sample; }
};

}  // namespace eikon
