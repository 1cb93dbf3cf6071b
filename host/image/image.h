// SPDX-License-Identifier: Apache-2.0
// Images on disk. The only users of OpenEXR and stb are the .cpp files beside this one. Every file is written under a
// temporary name in the same folder and renamed when it is complete, so that no half-written file is ever seen.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/film.h"

namespace eikon {

/// Planar float image of the data window, linear; rows from the top.
struct Image {
  std::uint32_t width = 0, height = 0;              // of the data window
  std::vector<std::string> channels;                // "R", "G", "B", "albedo.R", "depth.Z", ...
  std::vector<std::vector<float>> planes;           // one per channel, width * height
  std::map<std::string, std::string> metadata;      // eikon.* attributes

  [[nodiscard]] const std::vector<float>* plane(const std::string& channel) const;
};

/// Header attributes, written as OpenEXR string, int, float or matrix attributes named "eikon.<key>".
struct Metadata {
  std::map<std::string, std::string> strings;
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<double>> matrices;  // 16 values, row-major: worldToCamera, worldToNDC
};

struct ExrOptions {
  bool half = false;                      // R, G, B and layers as half; refused when a value would become infinite
  std::vector<std::string> layers;        // of --aov: albedo normal depth id variance samples
  bool exact_sums = false;                // second, lossless part with the film's integer sums
};

/// Writes the film: part 0 "image" with R, G, B and layers; with exact_sums a part "sums" of UINT channels, from which
/// read_film restores the film to the bit. throws InputError when the file cannot be written (disk full, no such folder).
void write_exr(const std::filesystem::path& path, const Film& film, const Metadata& metadata, const ExrOptions& options);

/// Reads the "sums" part. throws InputError when the file is not an EXR, is truncated, or has no such part.
Film read_film(const std::filesystem::path& path);

/// Reads part 0 of any scanline or tiled EXR (size limited before allocation). throws InputError.
Image read_exr(const std::filesystem::path& path);

/// Writes R, G, B as sRGB PNG after multiplying by 2^exposure_ev; non-finite values become black. throws InputError.
void write_png(const std::filesystem::path& path, const Image& image, double exposure_ev);
[[nodiscard]] Image to_image(const Film& film);

/// Metrics between R, G, B of two images of the same size (throws InputError otherwise, naming both sizes).
struct Comparison {
  double mse = 0;
  double relmse = 0;         // mean of (x - r)^2 / (r^2 + 1e-2)
  double mape = 0;           // mean of |x - r| / (|r| + 1e-2)
  double ratio_of_means = 0; // mean(x) / mean(r); 1 when both are 0
  std::uint64_t nonfinite = 0;  // values left out of the means above, in either image
  std::optional<double> flip;   // mean HDR-FLIP by the Python package flip-evaluator; nothing when it is not installed
};
Comparison compare_images(const Image& test, const Image& reference);
/// |test - reference| through a colour map, for looking at.
Image difference_image(const Image& test, const Image& reference);
/// Mean HDR-FLIP [Andersson et al. 2021] by `python3 -m flip_evaluator` in a child process; nothing when not installed.
std::optional<double> flip(const std::filesystem::path& test, const std::filesystem::path& reference);

}  // namespace eikon
