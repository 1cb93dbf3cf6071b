// SPDX-License-Identifier: Apache-2.0
#include "render/render.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <memory>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/execution_options.h"
#include "cli/metadata.h"
#include "cli/report.h"
#include "core/process_time.h"
#include "image/image.h"

namespace eikon {
namespace {

struct RenderOptions {
  SceneOptions scene;
  Execution execution;
  std::string output, png, stats, profile, pixel;
  double exposure_ev = 0;
  bool half = false, quiet = false;
  std::string sample, tone_map = "none";
};

std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signal{0};

void on_signal(int signal) {
  stop_signal = signal;
  stop_requested = true;
  std::signal(signal, SIG_DFL);  // a second one ends the process
}

/// One line on a terminal, rewritten in place.
class ProgressBar {
 public:
  explicit ProgressBar(bool wanted) : on_(wanted && isatty(STDERR_FILENO) != 0) {}
  ~ProgressBar() { clear(); }

  void show(const Progress& now, const Film& film) {
    if (!on_) return;
    // The devices wait for the film meanwhile: at most a twentieth of the time goes into the estimate.
    const double begin = host_seconds();
    if (begin >= next_error_s_) {
      error_ = film.predicted_error();
      const double end = host_seconds();
      next_error_s_ = end + std::max(1.0, 20 * (end - begin));
    }
    const double done = double(now.samples) / double(now.samples_total);
    constexpr int width = 24;
    const int filled = int(done * width);
    const double left =
        now.samples_per_second > 0 ? double(now.samples_total - now.samples) / now.samples_per_second : 0;
    fmt::print(stderr, "\r\x1b[K[{:=<{}}{:{}}] {:3.0f} %  {:.2f} Msamples/s  {:.0f} s left  relMSE {}", "", filled, "",
               width - filled, 100 * done, 1e-6 * now.samples_per_second, left,
               error_.known ? fmt::format("{:.2e}", error_.relmse) : "?");
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) fmt::print(stderr, "\r\x1b[K");
    shown_ = false;
  }

 private:
  bool on_, shown_ = false;
  double next_error_s_ = 0;
  PredictedError error_;
};

std::string rejected_line(const RenderReport& report) {
  std::string line = fmt::format("{} samples were rejected ({} not finite, {} beyond the film's range)",
                                 report.nonfinite + report.saturated, report.nonfinite, report.saturated);
  if (!report.rejected.empty()) {
    const RejectedSample& first = report.rejected.front();
    line += fmt::format("; replay the first with --pixel {},{} --sample {}", first.x, first.y, first.sample);
  }
  return line;
}

ExitCode replay(const RenderOptions& options) {
  if (options.pixel.empty() || options.sample.empty()) throw UsageError("--pixel X,Y and --sample N go together");
  const Prepared prepared = prepare(options.scene, options.quiet);
  const std::vector<std::string> xy = split(options.pixel, ',');
  if (xy.size() != 2) throw UsageError(fmt::format("--pixel {}: takes X,Y", options.pixel));
  const auto x = std::uint32_t(parse_unsigned("--pixel", xy[0], prepared.settings.width - 1));
  const auto y = std::uint32_t(parse_unsigned("--pixel", xy[1], prepared.settings.height - 1));
  const std::uint64_t sample = parse_unsigned("--sample", options.sample, (std::uint64_t{1} << 48) - 1);
  fmt::print("pixel {},{} sample {}\n", x, y, sample);
  const glm::vec3 radiance =
      replay_path(prepared.scene, prepared.settings, options.execution, x, y, sample, [&](const PathVertex& v) {
        fmt::print(
            "  edge {:>2}: from ({:.9g}, {:.9g}, {:.9g}) towards ({:.9g}, {:.9g}, {:.9g}), throughput ({:.6g}, {:.6g}, "
            "{:.6g})",
            v.depth, v.origin.x, v.origin.y, v.origin.z, v.dir.x, v.dir.y, v.dir.z, v.beta.x, v.beta.y, v.beta.z);
        if (v.triangle == EK_NO_HIT)
          fmt::print(": leaves the scene\n");
        else
          fmt::print(": hits triangle {} at {:.9g} m\n", v.triangle, v.t);
      });
  fmt::print("  radiance ({:.9g}, {:.9g}, {:.9g})\n", radiance.x, radiance.y, radiance.z);
  return ExitCode::done;
}

ExitCode render_command(RenderOptions options) {
  read_execution_environment(options.execution);
  if (!options.pixel.empty() || !options.sample.empty()) return replay(options);
  const std::filesystem::path output =
      options.output.empty() ? std::filesystem::path(options.scene.scene).filename().replace_extension(".exr")
                             : std::filesystem::path(options.output);
  require_writable({output, options.png, options.stats, options.profile}, options.scene.scene);
  options.execution.keep_spans = !options.profile.empty();
  Prepared prepared = prepare(options.scene, options.quiet);

  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  ProgressBar bar(!options.quiet);
  RenderHooks hooks;
  hooks.progress = [&](const Progress& now, const Film& film) { bar.show(now, film); };
  const RenderOutput done =
      render_and_release(prepared.scene, prepared.settings, options.execution, stop_requested, std::move(hooks));
  bar.clear();
  const RenderReport& report = done.report;
  if (report.interrupted && report.samples == 0) {
    fmt::print(stderr, "eikon: interrupted before the first sample: nothing was written\n");
    return stop_signal.load() == SIGTERM ? ExitCode::terminated : ExitCode::interrupted;
  }
  const PredictedError error = done.film.predicted_error();

  const double write_begin = host_seconds();
  ExrOptions exr;
  exr.half = options.half;
  exr.layers = prepared.layers;
  exr.exact_sums = !options.scene.samples.empty() || !options.scene.crop.empty();
  const Metadata metadata = describe_render(prepared, report, error);
  bool as_asked = true;
  try {
    write_exr(output, done.film, metadata, exr);
  } catch (const HalfOverflow& overflow) {
    // The work is done; a file in full precision is better than none.
    fmt::print(stderr, "eikon: {}; written with 32-bit channels\n", overflow.what());
    exr.half = false;
    write_exr(output, done.film, metadata, exr);
    as_asked = false;
  }
  if (!options.png.empty())
    write_png(options.png, to_image(done.film), options.exposure_ev, *tone_map_of(options.tone_map));
  CommandTimes times;
  times.load_s = prepared.load_s;
  times.write_s = host_seconds() - write_begin;
  times.total_s = process_seconds();
  if (!options.stats.empty()) write_stats(options.stats, report, error, prepared, times);
  if (!options.profile.empty()) write_profile(options.profile, report);

  if (!options.quiet) print_stage_table(report);
  const double rate = report.render_s > 0 ? double(report.samples) / report.render_s : 0;
  fmt::print("{}: {} x {}, {} samples in {:.2f} s ({:.2f} Msamples/s)\n", output.string(),
             prepared.settings.crop.width(), prepared.settings.crop.height(), report.samples, report.render_s,
             1e-6 * rate);
  if (error.known)
    fmt::print("predicted relMSE {:.3e} (95 %: {:.3e} to {:.3e})\n", error.relmse, error.lo, error.hi);
  else
    fmt::print("predicted relMSE unknown: it takes two samples per pixel\n");
  if (report.arithmetic() != "exact")
    fmt::print(stderr, "eikon: arithmetic {}: other devices may give other bits; see `eikon selftest`\n",
               report.arithmetic());
  const bool rejected = report.nonfinite + report.saturated > 0;
  if (rejected) fmt::print(stderr, "eikon: {}\n", rejected_line(report));
  if (report.interrupted) {
    fmt::print(stderr, "eikon: interrupted: {} of {} samples are in {}\n", report.samples,
               prepared.settings.crop.pixel_count() * (prepared.settings.sample_end - prepared.settings.sample_begin),
               output.string());
    return stop_signal.load() == SIGTERM ? ExitCode::terminated : ExitCode::interrupted;
  }
  return (rejected && options.scene.strict) || !as_asked ? ExitCode::not_as_asked : ExitCode::done;
}

}  // namespace

void add_render(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("render", "render a scene to an OpenEXR image");
  options->scene.add_to(*command);
  command->add_option("-o,--output", options->output, "OpenEXR file; SCENE.exr here if not given");
  command->add_flag("--half", options->half, "16-bit channels");
  command->add_option("--png", options->png, "also an sRGB picture; with --transparent an RGBA one");
  command->add_option("--exposure", options->exposure_ev, "of the PNG, in EV")
      ->check(check_is_finite)
      ->check(CLI::Range(-64.0, 64.0))
      ->capture_default_str();
  command
      ->add_option("--tonemap", options->tone_map, "tone curve of the PNG, after the exposure; none: cut off at white")
      ->check(CLI::IsMember(tone_map_names()))
      ->capture_default_str();
  add_execution_options(*command, options->execution, true);
  command->add_option("--pixel", options->pixel, "X,Y: with --sample N, trace that one path and print its vertices");
  command->add_option("--sample", options->sample, "N: see --pixel");
  command->add_option("--stats", options->stats, "JSON file of counts and times");
  command->add_option("--profile", options->profile, "JSON file of trace events, for Perfetto or chrome://tracing");
  command->add_flag("--quiet", options->quiet, "no notes, no progress, no stage table");
  command->footer(
      "Example:\n  eikon render scenes/cornell.gltf -o cornell.exr --png cornell.png --size 512x512 --spp 256 --aov "
      "albedo,normal");
  command->callback([options, &chosen] { chosen = [options] { return render_command(*options); }; });
}

}  // namespace eikon
