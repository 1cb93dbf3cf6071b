// SPDX-License-Identifier: Apache-2.0
#include "job/render_options.h"

#include <fmt/format.h>

namespace eikon {

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

}  // namespace eikon
