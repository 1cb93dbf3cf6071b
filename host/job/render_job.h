// SPDX-License-Identifier: Apache-2.0
// A render from its options to its files, in the steps load(), render(), write(). Any number of
// jobs can run in one process, each with one thread at a time: the caller handles signals, progress
// and messages.
#pragma once
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>

#include "job/pilot_keeper.h"
#include "job/render_options.h"
#include "job/report/stats.h"
#include "job/tev/tev_viewer.h"
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
  /// log      takes notes for the user: defaults that were chosen, faults of the image
  /// begin_s  process_seconds() when the work began, for --stats
  /// throws UsageError, InputError
  RenderJob(RenderOptions options, Log log, double begin_s = 0);

  /// Loads the scene and settles what is to be rendered. throws InputError, UsageError
  void load();
  /// The same with a scene that is loaded already, in load_s seconds. throws InputError, UsageError
  void load(std::shared_ptr<Scene> scene, double load_s);
  /// Makes render() use this packed scene for settings(), and leave the scene as it is.
  void use(std::shared_ptr<PackedScene> packed) { packed_ = std::move(packed); }
  /// Makes render() look for the image's pilot here, and keep it here.
  void share(PilotCache& pilots) { pilots_ = &pilots; }
  /// Takes a turn of `devices`: render() then takes its devices from there. To be called after
  /// use(), if that is called.
  /// stop  as DevicePrefetcher::turn() takes it
  void take_devices(DevicePrefetcher& devices, const std::atomic<bool>& stop);
  /// Renders until all is done or `stop` is set. throws Error
  void render(const std::atomic<bool>& stop, RenderHooks hooks);
  /// Writes every output, also of a render that was stopped, but nothing before its first sample.
  /// elsewhere  keep what is done in the folder for temporary files if the picture cannot be
  ///            written
  /// throws InputError; DeviceError, after writing, if the render ended because no device was left
  void write(bool elsewhere = true);

  [[nodiscard]] const RenderOptions& options() const { return options_; }
  [[nodiscard]] const std::filesystem::path& output() const { return output_; }
  /// After load():
  [[nodiscard]] const Settings& settings() const { return prepared_.settings; }
  /// After render():
  [[nodiscard]] const RenderReport& report() const { return done_->report; }
  [[nodiscard]] bool has_samples() const { return !done_->sample_set.empty(); }
  /// After write():
  [[nodiscard]] const PredictedError& error() const { return error_; }
  /// done, not_as_asked, or interrupted.
  [[nodiscard]] ExitCode code() const;
  /// Prints the table of stages unless quiet, where the image is, and its predicted error on
  /// stdout.
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
  std::unique_ptr<DevicePrefetcher::Turn> device_turn_{};
  std::unique_ptr<Denoiser> denoiser_{};  // for --denoise
  std::optional<Image> denoised_{};       // the finished picture without noise
  RenderFacts facts_{};  // for --stats and --report
  std::unique_ptr<TevViewer> viewer_{};  // for --tev, from the begin of render()
  std::optional<RenderOutput> done_;
  PredictedError error_;
  bool as_asked_ = true;   // false: something was written otherwise than asked, and a line said so
  std::string failure_{};  // why no device was left, once render() has something to keep for write()
  CheckpointFile checkpoint_;
  PilotKeeper pilot_;
  PilotCache* pilots_ = nullptr;

  /// Renders the packed scene of use(), or packs the loaded one and frees its meshes.
  [[nodiscard]] RenderOutput render_scene(const std::atomic<bool>& stop, RenderHooks hooks);
  /// Logs what happened to the devices, and writes the last checkpoint again if that failed.
  /// throws DeviceError if no device was left and a checkpoint holds what is done
  void end_render();
  /// Sets how far the samples may go, once the scene is known.
  void settle_goal();
  /// The goal of a render that begins now.
  [[nodiscard]] Goal make_goal();
  /// Estimates the seconds from the last sample to the last file, by write_trial() on some rows of
  /// the film.
  [[nodiscard]] double finish_seconds(const Film& film);
  /// The part of that which the images of --depth-series take.
  [[nodiscard]] double series_seconds(const Film& film);
  /// Does with the film what the end of the job does but for --depth-series (predict, denoise,
  /// write), and removes the files again.
  void write_trial(const Film& film);
  /// Writes one image and its PNG, and removes them again.
  void write_trial_picture(const Film& film, const ExrOptions& exr);
  /// The options of the images of --depth-series, of those of the picture.
  [[nodiscard]] static ExrOptions options_of_series(ExrOptions exr);
  /// After a render that ended by its goal: shortens the range of samples to what was done, so that
  /// headers state it.
  void end_samples();
  [[nodiscard]] ExrOptions exr_options() const;
  /// The last line that print() prints: what ended the render.
  [[nodiscard]] std::string how_it_ended() const;
  void write_files(bool elsewhere);
  void write_image(bool elsewhere);
  /// Writes --stats, --profile and --report.
  void write_reports();
  void write_picture(const ExrOptions& exr, bool elsewhere);
  /// Keeps what is done in another file. Returns a text that says how to resume; empty if that
  /// failed.
  [[nodiscard]] std::string keep_elsewhere(ExrOptions exr);
  /// Returns nothing, and logs why, if the library fails.
  [[nodiscard]] std::optional<Image> denoise(const Film& film);
  /// exr  the options of the whole picture
  void write_depth_series(ExrOptions exr);
  /// Falls back to full precision if half floats overflow.
  void write_film(const std::filesystem::path& file, const Film& film, const Metadata& metadata, ExrOptions exr);
  [[nodiscard]] std::uint64_t rejected_samples() const;  // of this run and those before
};

}  // namespace eikon
