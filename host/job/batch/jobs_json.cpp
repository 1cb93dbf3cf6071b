// SPDX-License-Identifier: Apache-2.0
#include "job/batch/jobs_json.h"

#include <map>
#include <nlohmann/json.hpp>

#include "io/json_dump.h"
#include "io/text.h"
#include "job/batch/job_key.h"

namespace eikon {
namespace {

using nlohmann::json;

/// Makes keys of jobs, and reads each scene once: ten thousand parts of one image name the same.
class Keys {
 public:
  /// throws InputError
  std::string of(const RenderOptions& options) {
    const std::string& map = options.scene.environment.map;
    return job_key(kept(scenes_, options.scene.scene, digest_scene_files),
                   kept(maps_, map, [](const std::string& file) { return digest_environment(file); }),
                   options.settings_text);
  }

 private:
  std::map<std::string, Digest> scenes_, maps_;

  template <class Make>
  static const Digest& kept(std::map<std::string, Digest>& table, const std::string& file, const Make& make) {
    const auto found = table.find(file);
    return found != table.end() ? found->second : table.emplace(file, make(file)).first->second;
  }
};

template <class Names>
json list_of(const Names& names) {
  json list = json::array();
  for (const auto& name : names) list.push_back(name_to_utf8(std::string(name)));
  return list;
}

void describe(json& line, const RenderOptions& options) {
  const SceneOptions& scene = options.scene;
  const SampleRange samples = scene.samples.value_or(SampleRange{0, scene.spp.value_or(kUsualSpp)});
  line["scene"] = name_to_utf8(scene.scene);
  line["size"] = scene.size ? json{scene.size->width, scene.size->height} : json(nullptr);
  line["samples"] = {samples.begin, samples.end};
  line["crop"] = scene.crop ? json{scene.crop->x0, scene.crop->y0, scene.crop->x1, scene.crop->y1} : json(nullptr);
  line["open_ended"] = options.goal.any();
  line["output"] = name_to_utf8(options.exr().string());
  line["results"] = list_of(options.results());
  line["part"] = list_of(options.part_words);
}

}  // namespace

std::string to_json_lines(const std::vector<BatchJob>& jobs) {
  std::string text;
  Keys keys;
  for (const BatchJob& job : jobs) {
    json line = {{"eikon", EIKON_VERSION},
                 {"line", job.line},
                 {"job", name_to_utf8(job.text)},
                 {"error", nullptr},
                 {"key", nullptr}};
    if (job.options) {
      describe(line, *job.options);
      line["words"] = list_of(job.words);
      try {
        line["key"] = keys.of(*job.options);
      } catch (const InputError& error) {
        line["error"] = error.what();
      }
    } else {
      line["error"] = job.message;
    }
    text += dump_json(line) + "\n";
  }
  return text;
}

}  // namespace eikon
