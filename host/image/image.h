// SPDX-License-Identifier: Apache-2.0
// Pictures in memory and on disk. The .cpp files beside this header read any OpenEXR picture and
// write PNG files; film/exr writes and reads the files of exact films. Every file is written under
// a temporary name in the same folder and renamed when it is complete, so that nobody ever sees
// half a file.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/error.h"
#include "image/tonemap.h"

namespace eikon {

inline constexpr std::array<const char*, 3> kRgb{"R", "G", "B"};  // channels of a colour

/// A planar, linear float image of the data window; rows start at the top.
struct Image {
  std::uint32_t width = 0, height = 0;          // size of the data window
  std::vector<std::string> channels;            // "R", "G", "B", "albedo.R", "depth.Z", ...
  std::vector<std::vector<float>> planes;       // one per channel, width * height values each
  std::map<std::string, std::string> metadata;  // eikon.* attributes, with numbers as text
  std::int64_t x0 = 0, y0 = 0;                  // of the data window, from the corner of the display window

  /// The values of a channel, or null when there is no such channel.
  [[nodiscard]] const std::vector<float>* plane(const std::string& channel) const;
};

/// Header attributes, written as OpenEXR string, double and m44f attributes named "eikon.<key>";
/// the matrices worldToCamera and worldToNDC keep these standard names. OpenEXR's matrices act on
/// row
/// vectors: v' = v M.
struct Metadata {
  std::map<std::string, std::string> strings;
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<double>> matrices;  // 16 values, row-major; stored as float
};

/// Reads the eikon.* attributes and standard matrices of part 0. throws InputError
Metadata read_metadata(const std::filesystem::path& path);

/// Reads part 0 of any flat scanline or tiled EXR; half and uint values become float. Sizes are
/// checked before anything is allocated: at most 65536 pixels a side, 4096 channels, 16 GiB, and a
/// size that is credible for the bytes of the file. throws InputError
Image read_exr(const std::filesystem::path& path);

/// Bytes of a PNG's pixels, row by row from the top.
struct PngBytes {
  std::uint32_t width = 0, height = 0;
  std::size_t channels = 3;  // 1: grey, 3: RGB, 4: RGBA, each sRGB as far as it is colour
  const std::vector<unsigned char>& bytes;  // [(y * width + x) * channels + channel]
};

/// The bytes of the PNG file. throws InternalError for sizes that a PNG cannot have
[[nodiscard]] std::string encode_png(const PngBytes& picture);

/// Writes R, G, B as an 8-bit sRGB PNG after multiplication by 2^exposure_ev and tone mapping.
/// Values are rounded to nearest; values above 1 become 255, negative and non-finite ones black. R,
/// G, B of an image with a channel A are premultiplied; the PNG has straight colours and A. throws
/// InputError
void write_png(const std::filesystem::path& path, const Image& image, double exposure_ev, ToneMap map = ToneMap::none);

/// Metrics between R, G, B of two images; x is the test value, r the reference. Means are over all
/// pixels and the three channels, without values that are not finite in one of the images. 1e-2 is
/// kErrorEpsilon.
struct Comparison {
  double mse = 0;               // mean of (x - r)^2
  double relmse = 0;            // mean of (x - r)^2 / (r^2 + 1e-2)
  double mape = 0;              // mean of |x - r| / (|r| + 1e-2)
  double ratio_of_means = 0;    // mean(x) / mean(r); 1 when both are 0
  std::uint64_t nonfinite = 0;  // values left out; when all are, the numbers above are NaN
};
/// throws InputError when the sizes differ (it names both) or an image has no R, G, B
Comparison compare_images(const Image& test, const Image& reference);
/// Colours each pixel by its error, the mean over R, G, B of |x - r| / (|r| + 1e-2): from black for
/// 0 over purple and orange to white for 1, as write_png() shows it with exposure 0. Pixels with a
/// value that is not finite are green. throws InputError as compare_images()
Image difference_image(const Image& test, const Image& reference);

}  // namespace eikon
