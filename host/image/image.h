// SPDX-License-Identifier: Apache-2.0
// Pictures in memory and on disk. The .cpp files beside this header read any OpenEXR picture and write PNG files; the files of
// exact films are the business of film/exr. Every file is written under a temporary name in the same folder and renamed when it
// is complete, so that nobody ever sees half a file.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "image/tonemap.h"

namespace eikon {

/// Planar float image of the data window, linear; rows from the top.
struct Image {
  std::uint32_t width = 0, height = 0;          // of the data window
  std::vector<std::string> channels;            // "R", "G", "B", "albedo.R", "depth.Z", ...
  std::vector<std::vector<float>> planes;       // one per channel, width * height
  std::map<std::string, std::string> metadata;  // eikon.* attributes, numbers printed

  /// The channel's values, or null.
  [[nodiscard]] const std::vector<float>* plane(const std::string& channel) const;
};

/// Header attributes, written as OpenEXR string, double and m44f attributes named "eikon.<key>"; the matrices worldToCamera
/// and worldToNDC under those standard names. OpenEXR's matrices act on row vectors: v' = v M.
struct Metadata {
  std::map<std::string, std::string> strings;
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<double>> matrices;  // 16 values, row-major; stored as float
};

/// The eikon.* attributes and standard matrices of part 0. throws InputError.
Metadata read_metadata(const std::filesystem::path& path);

/// Reads part 0 of any flat scanline or tiled EXR; half and uint values become float. Sizes are limited before allocation: at
/// most 65536 pixels a side, 4096 channels, 16 GiB, and what the file's own size makes credible. throws InputError.
Image read_exr(const std::filesystem::path& path);
/// The same with at most `max_bytes` for all planes together.
Image read_exr_within(const std::filesystem::path& path, std::uint64_t max_bytes);

/// Writes R, G, B as 8-bit sRGB PNG after multiplying by 2^exposure_ev and mapping tones, rounded to nearest; above 1 becomes
/// 255, negative and non-finite values become black. With a channel A (R, G, B multiplied by it) the PNG has colours that are
/// not, and A as it is. throws InputError.
void write_png(const std::filesystem::path& path, const Image& image, double exposure_ev, ToneMap map = ToneMap::none);

/// Metrics between R, G, B of two images. x: test, r: reference; means are over all pixels and the three channels, without the
/// values that are not finite in either image.
struct Comparison {
  double mse = 0;               // mean of (x - r)^2
  double relmse = 0;            // mean of (x - r)^2 / (r^2 + 1e-2)
  double mape = 0;              // mean of |x - r| / (|r| + 1e-2)
  double ratio_of_means = 0;    // mean(x) / mean(r); 1 when both are 0
  std::uint64_t nonfinite = 0;  // values left out; when all are, the numbers above are NaN
  std::optional<double> flip;   // left empty by compare_images (it takes seconds): for flip() below
};
/// throws InputError when the sizes differ (naming both) or one has no R, G, B.
Comparison compare_images(const Image& test, const Image& reference);
/// The error of each pixel, mean over R, G, B of |x - r| / (|r| + 1e-2), from 0 to 1 through a colour map from black over
/// purple and orange to white, such that write_png with exposure 0 shows the map; green where a value is not finite.
/// throws InputError as compare_images.
Image difference_image(const Image& test, const Image& reference);
/// Mean HDR-FLIP [Andersson et al. 2021] by the Python package flip-evaluator in a child process ($EIKON_PYTHON, else python3
/// of PATH); nothing when it is not installed or fails. Negative and non-finite values are given to it as 0.
/// throws InputError as compare_images.
std::optional<double> flip(const Image& test, const Image& reference);

}  // namespace eikon
