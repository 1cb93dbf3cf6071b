// SPDX-License-Identifier: Apache-2.0
// The checkpoint of a render: an OpenEXR file with the exact sums so far, which --resume goes on from and `eikon merge` takes.
#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "job/prepare.h"
#include "image/image.h"
#include "render/film_record.h"
#include "render/render.h"

namespace eikon {

struct CheckpointOptions {
  std::string file;  // empty: none
  double every_s = 60;
  bool resume = false;
  bool implied = false;  // --resume was not asked for: what cannot be gone on from is replaced rather than refused
};

class CheckpointFile {
 public:
  /// From now on SIGUSR1 asks for a checkpoint, if there is a file for it; see stop_signals.h
  /// log: takes what the user should know. throws UsageError when the options do not go together
  CheckpointFile(CheckpointOptions options, Log log);

  /// Before the scene is released. With --resume, reads the file if there is one.
  /// throws InputError when that is damaged or holds another image, naming what differs
  void begin(const Prepared& prepared);
  /// What the render begins with, and where its checkpoints go. Writing one may fail: that is said, and tried again.
  void attach(RenderHooks& hooks);
  /// Once the render has ended: whether the last checkpoint is whole, with another try if it is not.
  void end(const RenderOutput& done);

  /// After begin(): what is said beside sums of such samples, in any output that carries them.
  [[nodiscard]] FilmRecord record(const SampleSet& done, const std::set<std::string>& arithmetic) const;
  /// After begin(): of the mattes among the layers (render/mattes.h).
  [[nodiscard]] const std::map<std::string, std::string>& manifests() const { return manifests_; }
  /// After end(): false when the last checkpoint could not be written, or holds more samples than were asked for.
  [[nodiscard]] bool as_asked() const { return last_failure_.empty() && extra_samples_ == 0; }
  /// After end(): whether there is a file, and it holds all that was done.
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
  bool there_is_one_ = false;   // a checkpoint of this render lies in the file
  std::string last_failure_;    // of the last try; empty when it went well
  std::uint64_t requests_ = 0;  // SIGUSR1s that were seen
  std::unique_ptr<std::atomic<bool>> asked_ = std::make_unique<std::atomic<bool>>(false);  // by one of them

  void read(const Prepared& prepared);
  void read_if_it_fits(const Prepared& prepared);
  void write(const Film& film, const SampleSet& done, const std::set<std::string>& arithmetic);
  [[nodiscard]] std::string saved() const;
};

}  // namespace eikon
