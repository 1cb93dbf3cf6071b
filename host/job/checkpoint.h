// SPDX-License-Identifier: Apache-2.0
// The checkpoint of a render: an OpenEXR file with the exact sums so far, which --resume continues
// and `eikon merge` accepts.
#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "job/prepare.h"
#include "image/image.h"
#include "render/film_record.h"
#include "render/render.h"

namespace eikon {

struct CheckpointOptions {
  std::string file;  // empty: none
  double every_s = 60;
  bool resume = false;
  bool implied = false;  // resume if possible: a file that cannot be resumed is replaced, not refused
  std::vector<std::string> parts = {};  // files of the same image whose samples are taken over, too
  std::string left = {};  // what an interrupted run of this render may have left, which is taken over if it fits
};

class CheckpointFile {
 public:
  /// From now on SIGUSR1 asks for a checkpoint, if a file is named; see stop_signals.h
  /// throws UsageError when the options do not go together
  CheckpointFile(CheckpointOptions options, Log log);

  /// Reads the file if there is one and --resume is given, and the parts. To be called before the
  /// scene is released.
  /// throws InputError if a file is damaged, holds another image, and names what differs, or holds
  /// samples of another
  void begin(const Prepared& prepared);
  /// Gives the render the sums to begin with, and writes its checkpoints. A failure to write one is
  /// logged, and the next is tried.
  void attach(RenderHooks& hooks);
  /// Writes the last checkpoint again if that failed. To be called when the render has ended.
  void end(const RenderOutput& done);

  /// After begin(): describes sums of such samples, for the header of any file that has them.
  [[nodiscard]] FilmRecord record(const FilmState& state) const;
  /// After begin(): the manifests of the mattes among the layers (film/mattes.h).
  [[nodiscard]] const std::map<std::string, std::string>& manifests() const { return manifests_; }
  /// After end(): false if the last checkpoint could not be written, or has more samples than asked
  /// for.
  [[nodiscard]] bool as_asked() const { return last_failure_.empty() && extra_samples_ == 0; }
  /// After end(): true if there is a file and it holds everything that was done.
  [[nodiscard]] bool is_whole() const { return !options_.file.empty() && there_is_one_ && last_failure_.empty(); }
  [[nodiscard]] const std::string& file() const { return options_.file; }

 private:
  CheckpointOptions options_;
  Log log_;
  std::vector<ImageSetting> settings_;
  std::vector<std::string> layers_;  // of --aov
  std::map<std::string, std::string> manifests_;
  Metadata metadata_;
  std::optional<FilmState> begin_with_;
  std::uint64_t asked_samples_ = 0, extra_samples_ = 0, saved_samples_ = 0;
  bool there_is_one_ = false;   // the file is a checkpoint of this render
  std::string last_failure_;    // empty if the last checkpoint was written
  std::uint64_t requests_ = 0;  // how many SIGUSR1s were seen
  std::unique_ptr<std::atomic<bool>> asked_ = std::make_unique<std::atomic<bool>>(false);

  void read(const Prepared& prepared, const std::string& file);
  void read_if_it_fits(const Prepared& prepared, const std::string& file);
  /// Adds the samples of a file to begin_with_. where: "resume from", for messages
  void take_over(const Prepared& prepared, const std::string& file, const char* where);
  void count_extra_samples(const Settings& settings);
  void write(const FilmState& state);
  [[nodiscard]] std::string saved() const;
};

}  // namespace eikon
