// SPDX-License-Identifier: Apache-2.0
#include "cli/render_options.h"

#include <algorithm>
#include <fmt/format.h>

#include "cli/arguments.h"
#include "cli/empty_values.h"
#include "cli/execution_options.h"
#include "image/image.h"
#include "film/layers.h"

namespace eikon {

void RenderOptions::add_to(CLI::App& command) {
  scene.add_to(command);
  command.add_option("-o,--output", output, "OpenEXR file; SCENE.exr here if not given");
  command.add_flag("--half", half, "16-bit channels");
  command
      .add_option(
          "--depth-series", scene.depth_series,
          "N,M,...: from the same samples also pictures of the light that was scattered at most N, M, ... times")
      ->delimiter(',')
      ->check(between(0U, kMaxScatterBound));
  command.add_flag("--denoise", scene.denoise,
                   "also layers denoised.R/G/B, and the PNG of them, by Open Image Denoise 2 if it is installed");
  png.add_to(command);
  add_execution_options(command, execution, true);
  checkpoint.add_to(command);
  command.add_option("--pixel", pixel, "X,Y: with --sample N, trace that one path and print its vertices");
  command.add_option("--sample", sample, "N: see --pixel");
  command.add_option("--stats", stats, "JSON file of counts and times");
  command.add_option("--profile", profile, "JSON file of trace events, for Perfetto or chrome://tracing");
  command
      .add_option("--progress", progress,
                  "bar: on a terminal; openjd: lines for queues that speak Open Job Description, on stdout")
      ->check(CLI::IsMember({"bar", "openjd"}))
      ->capture_default_str();
  command.add_flag("--quiet", quiet, "no notes, no progress, no stage table");
}

std::filesystem::path RenderOptions::exr() const {
  return output.empty() ? std::filesystem::path(scene.scene).filename().replace_extension(".exr")
                        : std::filesystem::path(output);
}

std::filesystem::path RenderOptions::partial(const std::filesystem::path& file, std::uint32_t most) {
  std::filesystem::path name = file.stem();
  name += fmt::format(".depth{}", most);
  name += file.extension();
  return file.parent_path() / name;
}

std::vector<std::filesystem::path> RenderOptions::outputs() const {
  std::vector<std::filesystem::path> files = results();
  if (!checkpoint.file.empty()) files.emplace_back(checkpoint.file);
  return files;
}

std::vector<std::filesystem::path> RenderOptions::results() const {
  std::vector<std::filesystem::path> files = {exr()};
  for (const std::string& file : {png.file, stats, profile})
    if (!file.empty()) files.emplace_back(file);
  for (const std::uint32_t most : scene.depth_series) {
    files.push_back(partial(exr(), most));
    if (!png.file.empty()) files.push_back(partial(png.file, most));
  }
  return files;
}

namespace {

/// What changes neither the results nor their names.
bool is_about_execution(const std::string& flag) {
  static const std::vector<std::string> flags = {"--devices", "--accel",      "--layout",           "--memory",
                                                 "--threads", "--checkpoint", "--checkpoint-every", "--resume",
                                                 "--quiet",   "--progress"};
  return std::find(flags.begin(), flags.end(), flag) != flags.end();
}

std::string describe_settings(CLI::App& app) {
  std::string text;
  for (const CLI::Option* option : app.get_options()) {
    if (is_about_execution(option->get_name())) continue;
    text += option->get_name() + "=";
    if (option->count() == 0) text += option->get_default_str();
    for (const std::string& value : option->results()) text += value + "\n";
    text += "\n";
  }
  return text;
}

}  // namespace

RenderOptions parse_render(std::vector<std::string> words) {
  CLI::App app;
  app.set_help_flag();  // a line of a batch that asks for help renders nothing: an error like any unknown flag
  RenderOptions options;
  options.add_to(app);
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  try {
    app.parse(std::move(words));
    require_values(app);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  options.settings_text = describe_settings(app);
  return options;
}

}  // namespace eikon
