// SPDX-License-Identifier: Apache-2.0
#include "job/render_options.h"

#include <cmath>
#include <fmt/format.h>

namespace eikon {

namespace {

/// The exposure in EV that maps 1.2 * 2^EV100 cd/m^2 to white: the largest luminance that a camera
/// set to EV100 can record.
/// source  [Lagarde, de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", 5.1.2]
double exposure_of_camera(double ev100) { return -(ev100 + std::log2(1.2)); }

}  // namespace

void PngOptions::write(const Image& image) const {
  if (file.empty()) return;
  write_png(file, image, exposure(), tone_map);
}

double PngOptions::exposure() const { return ev100 ? exposure_of_camera(*ev100) : exposure_ev; }

bool RenderOptions::wants_stage_times() const {
  return !quiet || !stats.empty() || !profile.empty() || !report.empty();
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
  for (const std::string& file : {png.file, stats, profile, report})
    if (!file.empty()) files.emplace_back(file);
  for (const std::uint32_t most : scene.depth_series) {
    files.push_back(partial(exr(), most));
    if (!png.file.empty()) files.push_back(partial(png.file, most));
  }
  return files;
}

}  // namespace eikon
