// SPDX-License-Identifier: Apache-2.0
#include "job/batch/batch_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "job/batch/shell_words.h"
#include "job/file_identity.h"
#include "gltf/scene_files.h"
#include "io/atomic_file.h"

namespace eikon {
namespace {

namespace fs = std::filesystem;

/// Pixels times samples. Without --size, 1280x720 is a fair guess. The image does not depend on it.
double estimate_cost(const SceneOptions& scene) {
  const ImageSize size = scene.size.value_or(ImageSize{1280, 720});
  const Crop crop = scene.crop.value_or(Crop{0, 0, size.width, size.height});
  const SampleRange samples = scene.samples.value_or(SampleRange{0, scene.spp.value_or(kUsualSpp)});
  return std::max(1.0, (double(crop.x1) - crop.x0) * (double(crop.y1) - crop.y0) * double(samples.end - samples.begin));
}

/// The words behind `eikon render`, which may be left out. throws UsageError for another command
std::vector<std::string> arguments_of(std::vector<std::string> words) {
  if (!words.empty() && (words.front() == "eikon" || fs::path(words.front()).filename() == "eikon"))
    words.erase(words.begin());
  if (words.empty()) return words;
  static const std::set<std::string> others = {"batch", "merge", "info", "devices", "compare", "selftest", "bench",
                                               "meter",
                                               // No scene has such a name.
                                               "measure", "report", "view", "completion", "man"};
  if (others.count(words.front()) != 0)
    throw UsageError(fmt::format("'{}' cannot be in a batch: its lines are renders, SCENE and flags", words.front()));
  if (words.front() == "render") words.erase(words.begin());
  return words;
}

/// The files that a render of a scene reads, without the environment that a flag names.
struct SceneInputs {
  std::vector<fs::path> places;
  FileTable files;

  explicit SceneInputs(const std::string& scene) {
    for (const fs::path& file : scene_files(scene)) {
      places.push_back(place_of(file));
      files.put(file, 0);
    }
  }
};

void set_failed(BatchJob& job, const UsageError& error) {
  job.state = JobState::failed;
  job.code = error.code();
  job.message = shortened(error.what());
}

BatchJob read_job(const JobLine& line, const ParseRender& parse) {
  BatchJob job;
  job.line = line.line;
  job.text = quote(line.words);
  try {
    if (!line.error.empty()) throw UsageError(line.error);
    job.words = arguments_of(line.words);
    RenderOptions options = parse(job.words);
    if (options.is_replay()) throw UsageError("--pixel and --sample trace one path; a batch renders images");
    if (options.frames) return {.line = line.line, .text = job.text, .options = std::move(options)};  // for read_frames
    for (const fs::path& file : options.outputs())
      if (file == kStandardOutput) throw UsageError("a job of a batch cannot write to standard output; name a file");
    job.cost = estimate_cost(options.scene);
    job.options = std::move(options);
  } catch (const UsageError& error) {
    set_failed(job, error);
  }
  return job;
}

}  // namespace

const char* name_of(JobState state) {
  return std::array{"not run", "skipped", "done", "failed", "interrupted"}.at(std::size_t(state));
}

std::vector<BatchJob> read_jobs(std::string_view text, const ParseRender& parse) {
  std::vector<BatchJob> jobs;
  for (const JobLine& line : split_jobs(text)) {
    BatchJob job = read_job(line, parse);
    if (!job.options || !job.options->frames) {
      jobs.push_back(std::move(job));
      continue;
    }
    try {
      for (BatchJob& frame : read_frames(*job.options, line.line, parse)) jobs.push_back(std::move(frame));
    } catch (const UsageError& error) {
      job.options.reset();
      set_failed(job, error);
      jobs.push_back(std::move(job));
    }
  }
  return jobs;
}

std::vector<BatchJob> read_frames(const RenderOptions& options, std::size_t line, const ParseRender& parse) {
  RenderOptions named = options;
  JobLine of_frame{.line = line, .words = {"render"}};
  for (const std::string& word : options.words_without_frames) of_frame.words.push_back(word);
  if (named.output.empty()) {
    named.output = fmt::format("{}.%04d.exr", fs::path(options.scene.scene).stem().string());
    of_frame.words.push_back("--output=" + named.output);
  }
  require_numbers(named);
  std::vector<BatchJob> jobs;
  const FrameRange& frames = *options.frames;
  of_frame.words.emplace_back();
  for (std::uint64_t frame = frames.first; frame <= frames.last; frame += frames.step) {
    of_frame.words.back() = fmt::format("--frame={}", frame);
    jobs.push_back(read_job(of_frame, parse));
    jobs.back().frame = frame;
    if (!jobs.back().options) continue;
    jobs.back().options->frame_pattern = named.output;
    jobs.back().options->force = options.force;
  }
  return jobs;
}

std::string label_of(const BatchJob& job, const std::string& name) {
  const std::string frame = job.frame ? fmt::format("frame {}", *job.frame) : "";
  if (job.line == 0) return frame;
  const std::string line = name.empty() ? fmt::format("line {}", job.line) : fmt::format("{}:{}", name, job.line);
  return line + (job.frame ? ", " : "") + frame;
}

void check_outputs(std::vector<BatchJob>& jobs, const std::string& name, const std::vector<fs::path>& reserved) {
  // File -> number of its job, from 1; by path, since replacing a file leaves its hard links alone.
  std::map<fs::path, std::size_t> writers;
  for (const fs::path& file : reserved)
    if (!file.empty() && !writers.emplace(place_of(file), 0).second)
      throw UsageError(fmt::format(
          "cannot write {}: the batch itself has another file of that name; choose another name", file.string()));
  FileTable readers;
  std::map<std::string, SceneInputs> scenes;  // by name
  const auto line_of = [&](std::size_t number) { return label_of(jobs[number - 1]); };
  for (std::size_t number = 1; number <= jobs.size(); ++number) {
    BatchJob& job = jobs[number - 1];
    if (!job.options) continue;
    const auto clash = [&](const fs::path& file, const std::string& what) {
      throw UsageError(
          fmt::format("{}: cannot write {}: {}; nothing was rendered", label_of(job, name), file.string(), what));
    };
    const std::string &scene = job.options->scene.scene, &environment = job.options->scene.environment.map,
                      &pilot = job.options->pilot;
    const auto [inputs, is_first] = scenes.try_emplace(scene, scene);
    if (is_first)
      for (const fs::path& input : inputs->second.places) readers.put(input, number);
    std::vector<std::string> named = job.options->checkpoint.parts;  // inputs beside the scene's
    if (!environment.empty()) named.push_back(environment);
    for (const std::string& input : named) readers.put(input, number);
    if (!pilot.empty()) readers.put(pilot, number);
    const auto wait_for_writer = [&](const fs::path& input) {
      const auto writer = writers.find(input);
      if (writer != writers.end() && writer->second > 0) job.writers.push_back(writer->second - 1);
    };
    for (const fs::path& input : inputs->second.places) wait_for_writer(input);
    for (const std::string& input : named) wait_for_writer(place_of(input));
    for (const fs::path& file : job.options->outputs()) {
      const auto is_file = [&](const std::string& input) { return is_same_file(file, input); };
      if (inputs->second.files.find(file) || std::ranges::any_of(named, is_file))
        clash(file, "it is an input of that line; choose another name");
      const auto [at, is_new] = writers.emplace(place_of(file), number);
      if (const auto reader = readers.find(file); is_new && reader)
        clash(file, fmt::format("{} reads it; choose another name", line_of(*reader)));
      if (is_new) continue;
      clash(file, at->second == 0        ? "it belongs to the batch itself; choose another name"
                  : at->second == number ? "two outputs have that name; choose another for one of them"
                                         : fmt::format("so does {}; choose another name with -o", line_of(at->second)));
    }
  }
  for (const fs::path& file : reserved)
    if (const auto reader = file.empty() ? std::nullopt : readers.find(file))
      throw UsageError(
          fmt::format("cannot write {}: {} reads it; choose another name", file.string(), line_of(*reader)));
}

std::string shortened(const std::string& text) {
  constexpr std::size_t kMost = 300;
  return text.size() <= kMost ? text : text.substr(0, kMost - 3) + "...";
}

std::string ledger_name(const fs::path& file) {
  const fs::path real = place_of(file), here = fs::current_path();
  const bool below = std::mismatch(here.begin(), here.end(), real.begin(), real.end()).first == here.end();
  return (below ? real.lexically_relative(here) : real).string();
}

}  // namespace eikon
