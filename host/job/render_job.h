// SPDX-License-Identifier: Apache-2.0
// A render of the command line in its steps. Any number of jobs can run in one process: signals, progress and what is said to
// the user are the caller's.
#pragma once
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>

#include "job/render_options.h"
#include "job/report/report.h"
#include "core/error.h"
#include "image/denoise.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "render/device_prefetcher.h"
#include "render/render.h"

namespace eikon {

class RenderJob {
 public:
  /// Checks that the outputs can be written, before any work.
  /// log      takes what the user should know: what was decided, what is wrong with the image
  /// begin_s  process_seconds() when the work began, for --stats
  /// throws UsageError, InputError
  RenderJob(RenderOptions options, Log log, double begin_s = 0);

  /// Loads the scene and settles what is to be rendered. throws InputError, UsageError
  void load();
  /// The same with a scene that is loaded already, in load_s seconds. throws InputError, UsageError
  void load(std::shared_ptr<Scene> scene, double load_s);
  /// The scene's layout for settings(): render() takes that, and leaves the scene as it is.
  void use(std::shared_ptr<PackedScene> packed) { packed_ = std::move(packed); }
  /// Its turn of `devices`, which is where render() has them from. After use(). stop: see DevicePrefetcher
  void take_devices(DevicePrefetcher& devices, const std::atomic<bool>& stop);
  /// Renders until all is done or `stop` is set. throws Error
  void render(const std::atomic<bool>& stop, RenderHooks hooks);
  /// Writes every output, also of a render that was stopped; nothing when that was before its first sample.
  /// elsewhere: whether what is done is kept in the folder for temporary files where the picture cannot be written
  /// throws InputError; DeviceError, when all is written, if that is all that was done before no device was left
  void write(bool elsewhere = true);

  [[nodiscard]] const RenderOptions& options() const { return options_; }
  [[nodiscard]] const std::filesystem::path& output() const { return output_; }
  /// After load():
  [[nodiscard]] const Settings& settings() const { return prepared_.settings; }
  /// After render():
  [[nodiscard]] const RenderReport& report() const { return done_->report; }
  [[nodiscard]] bool has_samples() const { return !report().interrupted || !done_->done.empty(); }
  /// After write():
  [[nodiscard]] const PredictedError& error() const { return error_; }
  /// done, not_as_asked, or interrupted.
  [[nodiscard]] ExitCode code() const;
  /// What a render prints on stdout: the table of stages unless quiet, where the image is, and how wrong it is.
  void print() const;

 private:
  RenderOptions options_;
  Log log_;
  std::filesystem::path output_;
  double begin_s_;
  std::shared_ptr<Trace> trace_;  // for --profile
  CommandTimes times_;
  Prepared prepared_;
  std::shared_ptr<PackedScene> packed_{};
  std::unique_ptr<DevicePrefetcher::Slot> device_slot_{};
  std::unique_ptr<Denoiser> denoiser_{};  // for --denoise
  std::optional<RenderOutput> done_;
  PredictedError error_;
  bool as_asked_ = true;
  std::string failure_{};  // why no device was left, once render() has something to keep for write()
  CheckpointFile checkpoint_;

  void write_files(bool elsewhere);
  void write_image(bool elsewhere);
  void write_picture(const ExrOptions& exr, bool elsewhere);
  /// Where what is done was kept instead, and how to get at it; empty: it could not be.
  [[nodiscard]] std::string keep_elsewhere(ExrOptions exr);
  /// Nothing, and that is said, when the library fails.
  [[nodiscard]] std::optional<Image> denoise();
  /// exr: as of the whole picture
  void write_depth_series(ExrOptions exr);
  /// In full precision when half floats do not do.
  void write_film(const std::filesystem::path& file, const Film& film, const Metadata& metadata, ExrOptions exr);
  [[nodiscard]] std::uint64_t rejected_samples() const;  // of this run and those before
};

}  // namespace eikon
