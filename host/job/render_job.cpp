// SPDX-License-Identifier: Apache-2.0
#include "job/render_job.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "core/clock.h"
#include "job/file_identity.h"
#include "job/report/metadata.h"
#include "job/report/result_lines.h"
#include "job/report/stage_table.h"
#include "job/report/trace_file.h"
#include "job/report/write_report.h"
#include "io/atomic_file.h"
#include "io/private_folder.h"
#include "io/text.h"
#include "render/error_curve.h"
#include "film/layers.h"
#include "pack/geometry/instanced_meshes.h"

namespace eikon {
namespace {

/// The most of the time that a render with --report spends on the curve of its error.
constexpr double kReportErrorShare = 0.05;

/// True if each pixel would be 0 as 8 bits of sRGB.
bool is_black(const Film& film) {
  constexpr double kBlack = 0.5 / 255 / 12.92;
  const Crop& crop = film.layout().crop;
  for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      for (std::uint32_t channel = 0; channel < 3; ++channel)
        if (film.mean(x, y, channel) > kBlack) return false;
  return true;
}

}  // namespace

RenderJob::RenderJob(RenderOptions options, Log log, double begin_s)
    : options_(std::move(options)),
      log_(std::move(log)),
      output_(options_.exr()),
      begin_s_(begin_s),
      checkpoint_(options_.checkpoint, log_),
      pilot_(options_.pilot, options_.outputs(), log_) {
  read_execution_environment(options_.execution);
  if (!options_.scene.depth_series.empty() && (options_.output == kStandardOutput || options_.png.file == kStandardOutput))
    throw UsageError("--depth-series writes several files: name one with -o and --png instead of standard output");
  Inputs inputs{.scene = options_.scene.scene, .files = options_.checkpoint.parts};
  inputs.files.push_back(options_.scene.environment.map);
  require_writable(options_.outputs(), inputs);
  if (options_.scene.denoise) denoiser_ = std::make_unique<Denoiser>(options_.execution.threads);
  if (!options_.profile.empty() || !options_.report.empty()) trace_ = std::make_shared<Trace>();
  options_.execution.trace = trace_;
  options_.execution.timed = options_.wants_stage_times();
}

void RenderJob::load() {
  const TraceScope loading(trace_.get(), Trace::kMain, "load");
  prepared_ = prepare(options_.scene, options_.quiet ? log_unless(true) : log_);
  settle_goal();
  checkpoint_.begin(prepared_);
  pilot_.begin(prepared_, options_.execution, options_.quiet);
}

void RenderJob::load(std::shared_ptr<Scene> scene, double load_s) {
  prepared_ = prepare(options_.scene, std::move(scene), options_.quiet ? log_unless(true) : log_);
  prepared_.load_s = load_s;
  settle_goal();
  if (options_.execution.instances == InstanceMode::two_level) {
    InstanceChoice choice;
    (void)features_of(*prepared_.scene, prepared_.settings, options_.execution, &choice);
    if (choice.refused) log_(fmt::format("--instances two-level: meshes are stored for each instance: {}", choice.why));
  }
  checkpoint_.begin(prepared_);
  pilot_.begin(prepared_, options_.execution, options_.quiet);
}

void RenderJob::settle_goal() {
  if (!options_.goal.any()) return;
  Settings& settings = prepared_.settings;
  if (!options_.scene.spp && !options_.scene.samples) settings.sample_end = kMaxSppOfGoals;
  settings.likely_samples = Goal::likely_samples(options_.goal, settings.crop);
}

Goal RenderJob::make_goal() {
  const double begin_s = host_seconds() - (process_seconds() - begin_s_);
  return {options_.goal, settings(), begin_s + options_.goal.seconds.value_or(0),
          [this](const Film& film) { return finish_seconds(film); }, log_};
}

void RenderJob::end_samples() {
  Settings& settings = prepared_.settings;
  std::uint64_t end = settings.sample_begin;
  for (const WorkUnit& part : done_->sample_set.parts()) end = std::max(end, part.sample_end);
  settings.sample_end = std::min(settings.sample_end, end);
}

std::string RenderJob::how_it_ended() const {
  const Settings& settings = prepared_.settings;
  const std::uint64_t most = settings.sample_end - settings.sample_begin,
                      least =
                          done_->sample_set.complete_until(settings.crop, settings.sample_begin, settings.sample_end) -
                          settings.sample_begin;
  const std::string samples = least == most ? fmt::format("{}", most) : fmt::format("{} to {}", least, most);
  switch (report().end) {
    case RenderEnd::target_error:
      return fmt::format("ended by --target-error, at {} samples per pixel", samples);
    case RenderEnd::time_limit:
      return fmt::format("ended by --time, at {} samples per pixel", samples);
    case RenderEnd::all_samples:
      return fmt::format("ended by the limit of {} samples per pixel", samples);
    case RenderEnd::interrupted:
      break;
  }
  return fmt::format("interrupted, at {} samples per pixel", samples);
}

void RenderJob::take_devices(DevicePrefetcher& devices, const std::atomic<bool>& stop) {
  const std::shared_ptr<const Scene> scene = prepared_.scene;
  if (packed_ == nullptr)
    device_turn_ = devices.turn();
  else
    device_turn_ = devices.turn(
        {packed_, features_of(*scene, settings(), options_.execution), settings(), options_.execution}, stop);
}

void RenderJob::render(const std::atomic<bool>& stop, RenderHooks hooks) {
  if (device_turn_ != nullptr) {
    hooks.devices = &device_turn_->pool();
    hooks.under_way = [this] { device_turn_->under_way(); };
  }
  checkpoint_.attach(hooks);
  pilot_.attach(hooks, pilots_);
  std::optional<Goal> goal;
  if (options_.goal.any()) goal.emplace(make_goal()).attach(hooks);
  hooks.scene_owner = prepared_.scene;
  if (options_.tev) {
    const TevTarget target{*options_.tev, output_.string(), exr_options(), denoiser_ != nullptr};
    viewer_ = std::make_unique<TevViewer>(target, log_);
    viewer_->attach(hooks);
  }
  if (!options_.report.empty()) hooks.error_share = kReportErrorShare;
  if (!options_.stats.empty() || !options_.report.empty()) facts_ = facts_of(prepared_, options_.command);
  try {
    done_ = render_scene(stop, std::move(hooks));
  } catch (const NoDeviceLeft& error) {
    done_ = std::move(*error.output);
    failure_ = error.what();
  }
  end_render();
}

RenderOutput RenderJob::render_scene(const std::atomic<bool>& stop, RenderHooks hooks) {
  const Settings& settings = prepared_.settings;
  if (packed_ == nullptr)
    return render_and_release(*prepared_.scene, settings, options_.execution, stop, std::move(hooks));
  const Features features = features_of(*prepared_.scene, settings, options_.execution);
  return render_packed(packed_, features, settings, options_.execution, stop, std::move(hooks));
}

void RenderJob::end_render() {
  if (device_turn_ != nullptr) device_turn_->under_way();
  if (report().end == RenderEnd::target_error || report().end == RenderEnd::time_limit) end_samples();
  for (const std::string& note : report().notes) log_(note);
  for (const DeviceEvent& event : report().events)
    if (failure_.empty())  // else it says why each device was dropped
      log_(fmt::format("device {}: {}", report().devices[event.device].info.selector, event.text));
  checkpoint_.end(*done_);
  if (!failure_.empty() && checkpoint_.is_whole())
    throw DeviceError(fmt::format("{}; {} holds what is done: --resume goes on from it", failure_, checkpoint_.file()));
}

ExrOptions RenderJob::exr_options() const {
  ExrOptions exr;
  exr.half = options_.half;
  exr.layers = prepared_.layers;
  exr.manifests = checkpoint_.manifests();
  // A render that failed can be resumed from its exact sums.
  exr.exact_sums = options_.keeps_sums() || !failure_.empty();
  exr.quick = options_.scene.samples.has_value();  // to be merged
  return exr;
}

void RenderJob::write_image(bool elsewhere) {
  ExrOptions exr = exr_options();
  exr.record = to_text(checkpoint_.record(*done_));
  if (denoiser_) denoised_ = denoise(done_->film);
  exr.denoised = denoised_ ? &*denoised_ : nullptr;
  if (viewer_) viewer_->show_last(done_->film, exr);  // sent while the files are written
  write_picture(exr, elsewhere);
  if (!options_.png.file.empty()) options_.png.write(denoised_ ? *denoised_ : to_image(done_->film));
  write_depth_series(exr);
}

void RenderJob::write_picture(const ExrOptions& exr, bool elsewhere) {
  try {
    write_film(output_, done_->film, describe_render(prepared_, *done_, error_), exr);
  } catch (const InputError& error) {
    throw InputError(error.what() + (elsewhere ? keep_elsewhere(exr) : ""));
  }
}

std::string RenderJob::keep_elsewhere(ExrOptions exr) {
  if (checkpoint_.is_whole())
    return fmt::format("; {} holds what is done: --resume goes on from it", checkpoint_.file());
  exr.half = false;
  exr.denoised = nullptr;
  exr.exact_sums = true;
  std::filesystem::path folder, file;
  try {
    folder = make_private_folder("eikon_kept");
    file = folder / fmt::format("{}.exr", output_.stem().string());
    write_exr(file, done_->film, describe_render(prepared_, *done_, error_), exr);
  } catch (const InputError&) {
    std::error_code none;
    if (!folder.empty()) std::filesystem::remove(folder, none);
    return "";
  }
  return fmt::format("; what is done was kept in \"{}\": --checkpoint {} --resume goes on from it", file.string(),
                     file.string());
}

std::optional<Image> RenderJob::denoise(const Film& film) {
  const TraceScope denoising(trace_.get(), Trace::kMain, "denoise");
  try {
    Image picture = to_image(film, Denoiser::kAuxiliary);
    denoiser_->denoise(picture);
    return picture;
  } catch (const InputError& failure) {
    log_(fmt::format("{}; the picture is written as it is", failure.what()));
    as_asked_ = false;
    return std::nullopt;
  }
}

ExrOptions RenderJob::options_of_series(ExrOptions exr) {
  exr.exact_sums = false;
  exr.layers = {};
  exr.denoised = nullptr;
  return exr;
}

void RenderJob::write_depth_series(ExrOptions exr) {
  exr = options_of_series(std::move(exr));
  PngOptions png = options_.png;
  for (const std::uint32_t most : settings().depth_series) {
    const Film film = scattered_at_most(done_->film, most);
    Metadata metadata = describe_render(prepared_, *done_, film.predicted_error());
    metadata.numbers["scatteredAtMost"] = most;
    write_film(RenderOptions::partial(output_, most), film, metadata, exr);
    if (png.file.empty()) continue;
    png.file = RenderOptions::partial(options_.png.file, most).string();
    png.write(to_image(film));
  }
}

void RenderJob::write_film(const std::filesystem::path& file, const Film& film, const Metadata& metadata,
                           ExrOptions exr) {
  try {
    write_exr(file, film, metadata, exr);
  } catch (const HalfOverflow& overflow) {
    // The work is done; a file in full precision is better than none.
    log_(fmt::format("{}; written with 32-bit channels", overflow.what()));
    exr.half = false;
    write_exr(file, film, metadata, exr);
    as_asked_ = false;
  }
}

std::uint64_t RenderJob::rejected_samples() const { return rejected_in(done_->film, done_->sample_set); }

void RenderJob::write(bool elsewhere) {
  if (failure_.empty()) return write_files(elsewhere);
  try {
    write_files(elsewhere);
  } catch (const InputError& error) {
    throw DeviceError(fmt::format("{}; and {}", failure_, error.what()));
  }
  throw DeviceError(fmt::format("{}; what is done is in {}: --checkpoint {} --resume, and another -o, go on from it",
                                failure_, output_.string(), output_.string()));
}

void RenderJob::write_files(bool elsewhere) {
  if (!has_samples()) {
    as_asked_ = false;
    log_(report().end == RenderEnd::time_limit
             ? "the time was over before the first sample: nothing was written; give --time more seconds"
             : "interrupted before the first sample: nothing was written");
    return;
  }
  TraceScope predicting(trace_.get(), Trace::kMain, "predict error");
  error_ = done_->film.predicted_error();
  predicting.end();
  ErrorCurve::add_point(trace_.get(), error_);
  const double write_begin = host_seconds();
  TraceScope writing(trace_.get(), Trace::kMain, "write");
  write_image(elsewhere);
  writing.end();
  times_.load_s = prepared_.load_s;
  times_.write_s = host_seconds() - write_begin;
  times_.total_s = process_seconds() - begin_s_;
  write_reports();
  if (viewer_) viewer_->close();

  if (done_->arithmetic != std::set<std::string>{"exact"})
    log_(fmt::format("arithmetic {}: other devices may give other bits; see `eikon selftest`",
                     fmt::join(done_->arithmetic, ", ")));
  const std::uint64_t rejected = rejected_samples();
  if (rejected > 0) log_(rejected_line(report(), rejected));
  if (report().search_failures > 0) log_(search_failures_line(*prepared_.scene, report()));
  if (rejected == 0 && is_black(done_->film))
    log_("the picture is black all over: nothing that the camera sees gives or gets light; choose another view with "
         "--camera or --look-at, or light with --env neutral, FILE or R,G,B");
  if (report().interrupted() && failure_.empty()) {
    const Settings& settings = prepared_.settings;
    log_(fmt::format("interrupted: {} of {} samples are in {}", done_->sample_set.sample_count(),
                     settings.crop.pixel_count() * (settings.sample_end - settings.sample_begin), output_.string()));
  }
}

void RenderJob::write_reports() {
  if (trace_) trace_->end();
  if (!options_.profile.empty()) write_trace(options_.profile, *trace_);
  if (options_.stats.empty() && options_.report.empty()) return;
  const Json stats = stats_json(*done_, error_, prepared_, times_, facts_);
  if (!options_.stats.empty()) write_stats(options_.stats, stats);
  const ReportPicture picture{
      .film = done_->film, .denoised = denoised_ ? &*denoised_ : nullptr, .display = options_.png};
  if (!options_.report.empty()) write_report(options_.report, stats, picture, *trace_);
}

void RenderJob::print() const {
  if (!has_samples()) return;
  if (!options_.quiet) {
    print_stage_table(report());
    print_times(report(), times_);
    if (report().pilot.exists()) fmt::print("{}\n", in_words(report().pilot, prepared_.settings));
  }
  const std::uint64_t before = report().samples_before;
  fmt::print("{}: {} x {}, {}{} samples in {:.2f} s ({:.2f} Msamples/s)\n", printable(output_.string()),
             prepared_.settings.crop.width(), prepared_.settings.crop.height(),
             before > 0 ? fmt::format("{} samples before and ", before) : "", report().samples, report().render_s,
             1e-6 * per_second(double(report().samples), report().render_s));
  fmt::print("{}{}\n", in_words(error_), words_of_bias(prepared_.settings));
  if (options_.goal.any()) fmt::print("{}\n", how_it_ended());
}

ExitCode RenderJob::code() const {
  if (report().interrupted()) return ExitCode::interrupted;
  return (rejected_samples() > 0 && options_.scene.strict) || !as_asked_ || !checkpoint_.as_asked() ||
                 !pilot_.as_asked()
             ? ExitCode::not_as_asked
             : ExitCode::done;
}

}  // namespace eikon
