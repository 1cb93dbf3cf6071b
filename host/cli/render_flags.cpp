// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "cli/flags.h"
#include "pack/settings.h"
#include "film/layers.h"
#include "job/batch/shell_words.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxFrames = 100'000;
constexpr double kMaxShutter = 1000;  // frames
constexpr std::uint64_t kMaxMotionSteps = 256;

/// "1e-3" is a relMSE, "2%" the root of one. throws UsageError
double parse_target_error(const std::string& text) {
  // Rounding of single precision: its square is the least relMSE that images can have.
  constexpr double kLeast = 1e-12;
  const bool percent = text.ends_with('%');
  const double number = parse_numbers("--target-error", percent ? text.substr(0, text.size() - 1) : text, 1)[0];
  const double relmse = percent ? 1e-4 * number * number : number;
  if (number > 0 && relmse >= kLeast && relmse <= 1e6) return relmse;
  throw UsageError(fmt::format(
      "--target-error {}: takes a relMSE from {:g} to 1e6, or the root of one in percent, e.g. 2%", text, kLeast));
}

void add_goal_flags(CommandFlags& flags, GoalOptions& goal) {
  flags.group("End (by --spp, or what comes first of these)");
  flags.parsed({"--target-error", "RELMSE|PERCENT%",
                "end when the error is below a relMSE, or below the square of so many percent"},
               [&](const std::string& text) { goal.relmse = parse_target_error(text); });
  flags.parsed(
      {"--time", "SECONDS", "end so that the files are written in time, from the start; in a batch: of rendering"},
      [&](const std::string& text) { goal.seconds = parse_real("--time", text, 0.01, 1e9); });
}

void add_output_flags(CommandFlags& flags, RenderOptions& options) {
  flags.group("Output (- is standard output)");
  flags.picture({"-o,--output", "FILE", "OpenEXR image [SCENE.exr in this folder]"}, options.output, ".exr");
  flags.toggle("--half", "write 16-bit channels", options.half);
  add_png_flags(flags, options.png);
  flags.toggle("--denoise", "add denoised.R/G/B layers (Open Image Denoise 2, if installed), and use them for the PNG",
               options.scene.denoise);
  flags.list(
      {"--depth-series", "N,M,...", "also write images of the light scattered at most N, M, ... times"},
      [&](const std::string& text) {
        options.scene.depth_series.insert(std::uint32_t(parse_unsigned("--depth-series", text, kMaxScatterBound)));
      });
  flags.text(
      {"--pilot", "FILE",
       "take the pilot's decisions about light paths and guiding, and what it learned, from here, or keep them here "
       "if there is no such file"},
      options.pilot);
  flags.text({"--checkpoint", "FILE", "keep what is done here: regularly, at the end, and when interrupted"},
             options.checkpoint.file);
  flags.number({"--checkpoint-every", "SECONDS", "time between checkpoints [60]"}, options.checkpoint.every_s, 0.01,
               1e9);
  flags.toggle("--resume", "continue from the checkpoint if there is one, also with a larger --spp",
               options.checkpoint.resume);
  flags.list({"--add", "FILE", "take over the samples of a part or checkpoint of this image; may be given many times"},
             [&](const std::string& file) { options.checkpoint.parts.push_back(file); });
}

/// "localhost:14158" or "[::1]:14158". throws UsageError
NetworkAddress parse_address(const std::string& flag, const std::string& text) {
  constexpr std::uint64_t kMaxPort = 65535;
  const std::size_t colon = text.rfind(':');
  std::string host = text.substr(0, colon);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  const bool good = colon != std::string::npos && !host.empty() && host.find_first_of("[]") == std::string::npos &&
                    (bracketed || host.find(':') == std::string::npos);
  const auto port = number_in<std::uint64_t>(good ? text.substr(colon + 1) : "");
  if (!port || *port == 0 || *port > kMaxPort)
    throw UsageError(
        fmt::format("{} {}: takes HOST:PORT with a port from 1 to {}, such as localhost:14158 or [::1]:14158", flag,
                    in_quotes(text), kMaxPort));
  return {host, std::to_string(*port)};
}

void add_diagnosis_flags(CommandFlags& flags, RenderOptions& options) {
  flags.group("Diagnosis (- is standard output)");
  flags.text({"--stats", "FILE", "write counts and times as JSON"}, options.stats);
  flags.text({"--profile", "FILE", "write a timeline for Perfetto or chrome://tracing"}, options.profile);
  flags.text({"--report", "FILE.html", "write a page that shows the picture, its error, and where the time went"},
             options.report);
  flags.parsed({"--tev", "HOST:PORT", "show the growing image in the viewer tev, which runs there"},
               [&](const std::string& text) { options.tev = parse_address("--tev", text); });
  flags.parsed({"--pixel", "X,Y", "with --sample N: print the vertices of that path of the pixel, and write no file"},
               [&](const std::string& text) {
                 const std::vector<std::string> xy = split(text, ',');
                 if (xy.size() != 2) throw UsageError(fmt::format("--pixel {}: takes X,Y", text));
                 const auto at = [&](int i) {
                   return std::uint32_t(parse_unsigned("--pixel", xy[std::size_t(i)], 65534));
                 };
                 options.pixel = PixelIndex{at(0), at(1)};
               });
  flags.parsed({"--sample", "N", "see --pixel"},
               [&](const std::string& text) { options.sample = parse_unsigned("--sample", text, kMaxSamples - 1); });
  flags.choice({"--progress", "HOW", "bar, on a terminal; openjd: lines on stdout for Open Job Description [bar]"},
               options.progress, {"bar", "openjd"});
  flags.toggle("--quiet", "print no notes about the scene, no progress and no stage table; warnings stay",
               options.quiet);
}

FrameRange parse_frames(const std::string& text) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 2 && parts.size() != 3)
    throw UsageError(fmt::format("--frames {}: takes A:B[:STEP], from frame A to frame B", text));
  FrameRange frames{parse_unsigned("--frames", parts[0], kMaxFrame), parse_unsigned("--frames", parts[1], kMaxFrame)};
  if (parts.size() == 3) frames.step = parse_unsigned("--frames", parts[2], kMaxFrame, 1);
  if (frames.first > frames.last)
    throw UsageError(fmt::format("--frames {}: ends before it begins; the first frame comes first", text));
  if (frames.count() > kMaxFrames)
    throw UsageError(fmt::format("--frames {}: at most {} frames are rendered at a time", text, kMaxFrames));
  return frames;
}

void add_frames_flag(CommandFlags& flags, RenderOptions& options) {
  flags.group("Sequence (names of files have a place for the frame's number, such as walk_%04d.exr)");
  flags.parsed({"--frames", "A:B[:STEP]", "render frames A to B; those that are done already are skipped"},
               [&](const std::string& text) { options.frames = parse_frames(text); });
  for (const char* other : {"--frame", "--scene-time"}) flags.exclude("--frames", other);
  flags.toggle("--force", "with --frames, also render those that are done", options.force);
}

/// Flags that change neither the results nor their names.
const std::vector<std::string> kAboutExecution = {
    "--devices", "--accel", "--layout",   "--instances",  "--memory",
    "--threads", "--quiet", "--progress", "--checkpoint", "--checkpoint-every",
    "--resume",  "--add",   "--pilot",    "--tev",        "--force"};

/// Flags that a part of an image does not take over: how much of the image is rendered, and which
/// files come of it.
const std::vector<std::string> kNotForParts = {
    "--spp",   "--force",    "--samples", "--target-error", "--time",       "--output",           "--half",   "--png",
    "--ev100", "--exposure", "--tonemap", "--denoise",      "--checkpoint", "--checkpoint-every", "--resume", "--add",
    "--stats", "--profile",  "--report",  "--tev",          "--quiet",      "--progress"};

/// Asks for the layers that the denoiser reads.
void add_denoiser_layers(std::vector<std::string>& words) {
  const auto aovs = std::ranges::find_if(words, [](const std::string& word) { return word.starts_with("--aov="); });
  if (aovs == words.end())
    words.emplace_back("--aov=albedo,normal");
  else
    *aovs += ",albedo,normal";
}

}  // namespace

void add_png_flags(CommandFlags& flags, PngOptions& png) {
  flags.picture({"--png", "FILE", "also write an 8-bit sRGB picture, RGBA if the image has channel A"}, png.file,
                ".png");
  flags.number({"--exposure", "EV", "exposure of the PNG [0]"}, png.exposure_ev, -PngOptions::kMaxExposureEv,
               PngOptions::kMaxExposureEv);
  flags.parsed(
      {"--ev100", "EV", "expose the PNG as a camera set to EV, for scenes in lm, lx and cd/m2; sunlight is 15"},
      [&](const std::string& text) {
        png.ev100 = parse_real("--ev100", text, -PngOptions::kMaxEv100, PngOptions::kMaxEv100);
      });
  flags.exclude("--ev100", "--exposure");
  flags.parsed(
      {"--tonemap", "NAME", fmt::format("tone curve of the PNG: {} [none]", fmt::join(tone_map_names(), ", "))},
      [&](const std::string& text) {
        const auto map = tone_map_of(text);
        if (!map) refuse_choice("--tonemap", text, tone_map_names());
        png.tone_map = *map;
      });
  flags.suggest("--tonemap", tone_map_names());
}

void add_shutter_flags(CommandFlags& flags, AnimationOptions& options) {
  flags.group("Motion blur");
  flags.number(
      {"--shutter", "FRAMES", "blur what moves while the shutter is open: 0.5 is a shutter of 180 degrees [0]"},
      options.shutter, 0, kMaxShutter);
  flags.choice({"--shutter-at", "WHEN", "open, centre, close: what the shutter does at the time of the frame [open]"},
               options.shutter_at, {{"open", 0.0}, {"centre", 0.5}, {"close", 1.0}});
  flags.parsed({"--motion-steps", "N|auto", "follow what moves in N straight steps [auto: by its curvature]"},
               [&](const std::string& text) {
                 options.motion_steps =
                     text == "auto" ? 0 : std::uint32_t(parse_unsigned("--motion-steps", text, kMaxMotionSteps, 1));
               });
}

void add_render_flags(CommandFlags& flags, RenderOptions& options) {
  add_all_scene_flags(flags, options.scene);
  add_shutter_flags(flags, options.scene.animation);
  add_frames_flag(flags, options);
  add_goal_flags(flags, options.goal);
  add_execution_flags(flags, options.execution, true);
  add_output_flags(flags, options);
  add_diagnosis_flags(flags, options);
  for (const char* other : {"--target-error", "--time", "--frames"}) flags.exclude(other, "--pixel");
  flags.exclude("--target-error", "--samples");
  flags.exclude("--frames", "--add");
}

RenderOptions parse_render(std::vector<std::string> words) {
  RenderOptions options;
  options.command = "eikon render " + quote(words);
  const std::vector<GivenFlag> given =
      parse_words(words, [&](CommandFlags flags) { add_render_flags(flags, options); });
  for (const GivenFlag& flag : given) {
    const auto& [name, values] = flag;
    if (std::ranges::find(kAboutExecution, name) == kAboutExecution.end())
      options.settings_text += fmt::format("{}={}\n", name, fmt::join(values, "\n"));
    if (std::ranges::find(kNotForParts, name) != kNotForParts.end()) continue;
    flag.add_to(options.part_words);
  }
  for (const GivenFlag& flag : given)
    if (flag.name != "--frames" && flag.name != "--force") flag.add_to(options.words_without_frames);
  require_frames_for_force(options);
  number_outputs(options);
  if (options.scene.denoise) add_denoiser_layers(options.part_words);
  return options;
}

}  // namespace eikon
