// SPDX-License-Identifier: Apache-2.0
#include "render/render.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <memory>

#include "cli/commands.h"
#include "cli/flags.h"
#include "core/time_share.h"
#include "job/batch/shell_words.h"
#include "job/batch/openjd.h"
#include "job/batch/run_jobs.h"
#include "job/log.h"
#include "job/render_job.h"
#include "job/stop_signals.h"

namespace eikon {
namespace {

/// A line on a terminal that is rewritten in place.
class ProgressBar {
 public:
  explicit ProgressBar(bool wanted) : on_(wanted && isatty(STDERR_FILENO) != 0) {}
  ~ProgressBar() { clear(); }

  void show(const Progress& now, const Film& film) {
    if (!on_) return;
    if (predicting_.is_due()) predicting_.run([&] { error_ = film.predicted_error(); });
    constexpr int width = 24;
    const int filled = int(now.share * width);
    print_to_stderr(
        "\r\x1b[K[{:=<{}}{:{}}] {:3.0f} %  {:.2f} Msamples/s  {:.0f} s left  relMSE {}", "", filled, "", width - filled,
        100 * now.share, 1e-6 * now.samples_per_second, now.left_s,
        !error_.known ? "?" : fmt::format("{}{:.2e}", std::isfinite(error_.hi) ? "" : ">= ", error_.relmse));
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) print_to_stderr("\r\x1b[K");
    shown_ = false;
  }

 private:
  bool on_, shown_ = false;
  // The devices wait for the film while its error is predicted.
  TimeShare predicting_{0.05, 1};
  PredictedError error_;
};

/// Refuses a sample that the image does not have. Without --spp and --samples, any will do. throws
/// UsageError
void require_sample(const SceneOptions& scene, std::uint64_t sample) {
  if (!scene.samples && !scene.spp) return;
  const SampleRange all = scene.samples.value_or(SampleRange{0, scene.spp.value_or(kUsualSpp)});
  if (sample < all.begin || sample >= all.end)
    throw UsageError(fmt::format("--sample {}: {} asks for the samples {} to {}", sample,
                                 scene.samples ? "--samples" : "--spp", all.begin, all.end - 1));
}

/// throws UsageError
void require_pixel(const Settings& settings, std::uint32_t x, std::uint32_t y) {
  const Crop& crop = settings.crop;
  if (x >= settings.width || y >= settings.height)
    throw UsageError(fmt::format("--pixel {},{}: the image has {} x {} pixels, counted from 0", x, y, settings.width,
                                 settings.height));
  if (x < crop.x0 || x >= crop.x1 || y < crop.y0 || y >= crop.y1)
    throw UsageError(fmt::format("--pixel {},{}: --crop asks for the pixels {},{} to {},{}", x, y, crop.x0, crop.y0,
                                 crop.x1 - 1, crop.y1 - 1));
}

ExitCode replay(const RenderOptions& options) {
  if (!options.pixel || !options.sample) throw UsageError("--pixel X,Y and --sample N go together");
  const auto [x, y] = *options.pixel;
  const std::uint64_t sample = *options.sample;
  require_sample(options.scene, sample);
  const Prepared prepared = prepare(options.scene, log_unless(options.quiet));
  require_pixel(prepared.settings, x, y);
  fmt::print("pixel {},{} sample {}\n", x, y, sample);
  const ReplayedSample replayed =
      replay_path(*prepared.scene, prepared.settings, options.execution, {x, y, sample}, [&](const PathVertex& v) {
        fmt::print(
            "  edge {:>2}: from ({:.12g}, {:.12g}, {:.12g}) towards ({:.9g}, {:.9g}, {:.9g}), "
            "throughput ({:.6g}, {:.6g}, {:.6g})",
            v.depth, v.origin.x, v.origin.y, v.origin.z, v.dir.x, v.dir.y, v.dir.z, v.beta.x, v.beta.y, v.beta.z);
        if (v.triangle == EK_NO_HIT)
          fmt::print(": leaves the scene\n");
        else
          fmt::print(": hits triangle {} at {:.9g} m\n", v.triangle, v.t);
      });
  glm::vec3 radiance = replayed.radiance;
  for (const ReplayedSample::Splat& splat : replayed.splats) {
    fmt::print("  light path: ({:.9g}, {:.9g}, {:.9g}) by {} scatterings\n", splat.radiance.x, splat.radiance.y,
               splat.radiance.z, splat.scatterings);
    radiance += splat.radiance;
  }
  fmt::print("  radiance ({:.9g}, {:.9g}, {:.9g})\n", radiance.x, radiance.y, radiance.z);
  return ExitCode::done;
}

ExitCode render_with_progress(RenderOptions options, OpenJdLines& lines) {
  ProgressBar bar(!options.quiet && options.progress == "bar");
  RenderJob job(std::move(options), log_unless(false));
  lines.status("loading the scene");
  job.load();
  const std::atomic<bool>& stop = catch_stop_signals();
  RenderHooks hooks;
  hooks.progress = [&](const Progress& now, const Film& film) {
    bar.show(now, film);
    lines.status("rendering");
    lines.progress(now.share);
  };
  lines.status("preparing the devices");
  job.render(stop, std::move(hooks));
  bar.clear();
  lines.status("writing the image");
  job.write();
  job.print();
  const bool stopped = job.code() == ExitCode::interrupted;
  if (!stopped) lines.progress(1);
  lines.status(stopped ? "interrupted" : "done");
  return stopped ? stop_exit_code() : job.code();
}

ExitCode render_command(RenderOptions options, const std::vector<std::string>& words) {
  require_frames_for_force(options);
  if (options.frames) {
    receive_signals();
    return run_frames(parse_render(words), parse_render);
  }
  options.command = "eikon render " + quote(words);
  number_outputs(options);
  if (options.is_replay()) {
    read_execution_environment(options.execution);
    return replay(options);
  }
  receive_signals();
  OpenJdLines lines(options.progress == "openjd");
  try {
    return render_with_progress(std::move(options), lines);
  } catch (const Error& error) {
    lines.fail(error.what());
    throw;
  }
}

}  // namespace

void add_render(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<RenderOptions>();
  CommandFlags flags = root.command("render", "render a scene to an OpenEXR image",
                                    "Example:\n  eikon render scenes/cornell.gltf -o cornell.exr --png cornell.png "
                                    "--size 512x512 --spp 256 --aov albedo,normal\n\n" +
                                        environment_help());
  add_render_flags(flags, *options);
  flags.run(chosen, [options](const std::vector<std::string>& words) { return render_command(*options, words); });
}

}  // namespace eikon
