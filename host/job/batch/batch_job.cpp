// SPDX-License-Identifier: Apache-2.0
#include "job/batch/batch_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "job/batch/job_lines.h"
#include "cli/arguments.h"
#include "job/file_identity.h"
#include "gltf/scene_files.h"

namespace eikon {
namespace {

namespace fs = std::filesystem;

/// What is rendered decides; where the file does not say its size, 1280x720 is a fair guess. The image does not depend on it.
double estimate_cost(const SceneOptions& scene) {
  const auto number = [](const std::string& text) { return std::strtod(text.c_str(), nullptr); };
  double pixels = 1280.0 * 720;
  if (const std::vector<std::string> size = split(scene.size, 'x'); size.size() == 2)
    pixels = number(size[0]) * number(size[1]);
  if (const std::vector<std::string> c = split(scene.crop, ','); c.size() == 4)
    pixels = (number(c[2]) - number(c[0])) * (number(c[3]) - number(c[1]));
  auto samples = double(scene.spp);
  if (const std::vector<std::string> range = split(scene.samples, ':'); range.size() == 2)
    samples = number(range[1]) - number(range[0]);
  return std::max(1.0, pixels * samples);
}

/// Without `eikon render`, either word or both of which may be left out. throws UsageError for another command
std::vector<std::string> arguments_of(std::vector<std::string> words) {
  if (!words.empty() && (words.front() == "eikon" || fs::path(words.front()).filename() == "eikon"))
    words.erase(words.begin());
  if (words.empty()) return words;
  static const std::set<std::string> others = {"batch",    "merge", "info",  "devices", "compare",
                                               "selftest", "bench", "meter", "measure"};  // no scene is called so
  if (others.count(words.front()) != 0)
    throw UsageError(fmt::format("'{}' cannot be in a batch: its lines are renders, SCENE and flags", words.front()));
  if (words.front() == "render") words.erase(words.begin());
  return words;
}

/// What a render of a scene reads, beside the environment that a flag names.
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

BatchJob read_job(const JobLine& line) {
  BatchJob job;
  job.line = line.line;
  job.text = quote(line.words);
  try {
    if (!line.error.empty()) throw UsageError(line.error);
    RenderOptions options = parse_render(arguments_of(line.words));
    if (options.is_replay()) throw UsageError("--pixel and --sample tell of one path; a batch renders pictures");
    job.cost = estimate_cost(options.scene);
    job.options = std::move(options);
  } catch (const UsageError& error) {
    job.state = JobState::failed;
    job.code = error.code();
    job.message = error.what();
  }
  return job;
}

}  // namespace

const char* name_of(JobState state) {
  switch (state) {
    case JobState::waiting:
      return "not run";
    case JobState::skipped:
      return "skipped";
    case JobState::done:
      return "done";
    case JobState::failed:
      return "failed";
    case JobState::interrupted:
      return "interrupted";
  }
  return "";
}

std::vector<BatchJob> read_jobs(std::string_view text) {
  std::vector<BatchJob> jobs;
  for (const JobLine& line : split_jobs(text)) jobs.push_back(read_job(line));
  return jobs;
}

void check_outputs(std::vector<BatchJob>& jobs, const std::string& name, const std::vector<fs::path>& reserved) {
  std::map<fs::path, std::size_t> writers;  // file -> line; to replace a file leaves the other names that it has alone
  for (const fs::path& file : reserved)
    if (!file.empty()) writers[place_of(file)] = 0;
  FileTable readers;
  std::map<std::string, SceneInputs> scenes;  // by name
  for (BatchJob& job : jobs) {
    if (!job.options) continue;
    const auto clash = [&](const fs::path& file, const std::string& what) {
      throw UsageError(
          fmt::format("{}:{}: cannot write {}: {}; nothing was rendered", name, job.line, file.string(), what));
    };
    const SceneOptions& scene = job.options->scene;
    const auto [inputs, is_first] = scenes.try_emplace(scene.scene, scene.scene);
    if (is_first)
      for (const fs::path& input : inputs->second.places) readers.put(input, job.line);
    if (!scene.env.empty()) readers.put(scene.env, job.line);
    const auto is_written = [&](const fs::path& input) { return writers.count(input) > 0; };
    job.after_others = std::ranges::any_of(inputs->second.places, is_written) ||
                       (!scene.env.empty() && is_written(place_of(scene.env)));
    for (const fs::path& file : job.options->outputs()) {
      if (inputs->second.files.find(file) || (!scene.env.empty() && is_same_file(file, scene.env)))
        clash(file, "it is an input of that line; choose another name");
      const auto [at, is_new] = writers.emplace(place_of(file), job.line);
      if (const auto line = readers.find(file); is_new && line)
        clash(file, fmt::format("line {} reads it; choose another name", *line));
      if (is_new) continue;
      clash(file, at->second == 0          ? "it belongs to the batch itself; choose another name"
                  : at->second == job.line ? "two outputs have that name; choose another for one of them"
                                           : fmt::format("so does line {}; choose another name with -o", at->second));
    }
  }
}

std::string ledger_name(const fs::path& file) {
  const fs::path real = place_of(file), here = fs::current_path();
  const bool below = std::mismatch(here.begin(), here.end(), real.begin(), real.end()).first == here.end();
  return (below ? real.lexically_relative(here) : real).string();
}

}  // namespace eikon
