// SPDX-License-Identifier: Apache-2.0
#include "scene/merl.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "io/atomic_file.h"

namespace eikon {
namespace {

static_assert(std::endian::native == std::endian::little, "MERL's files are little-endian, and are read as they are");

constexpr std::size_t kCells = EK_MEASURED_CELLS;
constexpr std::array<std::int32_t, 3> kDimensions{EK_MEASURED_THETA_H, EK_MEASURED_THETA_D, EK_MEASURED_PHI_D};
constexpr std::array<double, 3> kScales{1 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0};
constexpr double kLargestValue = 1e30;  // products and sums of more would overflow

}  // namespace

std::vector<float> read_merl(std::span<const std::byte> file) {
  std::array<std::int32_t, 3> dimensions{};
  if (file.size() < sizeof(dimensions))
    throw InputError(fmt::format("has {} bytes; a MERL table has {}", file.size(), kMerlBytes));
  std::memcpy(dimensions.data(), file.data(), sizeof(dimensions));
  if (dimensions != kDimensions)
    throw InputError(fmt::format("is {} x {} x {} cells, as it says; a MERL table is {} x {} x {}", dimensions[0],
                                 dimensions[1], dimensions[2], kDimensions[0], kDimensions[1], kDimensions[2]));
  if (file.size() != kMerlBytes)
    throw InputError(
        fmt::format("has {} bytes; a MERL table has {}: copy it again, unpacked", file.size(), kMerlBytes));
  std::vector<float> rgb(3 * kCells);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < kCells; ++i) {
      double value = 0;
      std::memcpy(&value, file.data() + sizeof(dimensions) + 8 * (c * kCells + i), sizeof(value));
      value *= kScales[c];
      if (!(std::abs(value) <= kLargestValue))
        throw InputError(fmt::format("entry {} of {} is {:g}; entries are finite, of at most {:g}", i,
                                     std::array{"red", "green", "blue"}[c], value / kScales[c], kLargestValue));
      rgb[3 * i + c] = static_cast<float>(value);
    }
  return rgb;
}

void write_merl(const std::filesystem::path& path, std::span<const float> rgb) {
  if (rgb.size() != 3 * kCells) throw InternalError(fmt::format("a MERL table of {} values", rgb.size()));
  AtomicFile file(path);
  file.write(kDimensions.data(), sizeof(kDimensions));
  std::vector<double> channel(kCells);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < kCells; ++i) {
      const auto value = static_cast<double>(rgb[3 * i + c]);
      channel[i] = value < 0 ? -1 : value / kScales[c];
    }
    file.write(channel.data(), channel.size() * sizeof(double));
  }
  file.commit();
}

}  // namespace eikon
