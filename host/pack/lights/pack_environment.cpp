// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/pack_environment.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "pack/lights/light_table.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxTexels = std::uint64_t{1} << 28;  // 16 random words each
constexpr float kFaintest = 0x1p-96F;  // products with smaller numbers may be denormal, which devices may flush
constexpr double kBrightest = 1e30;

/// The mean weights of the rows above, at and below row j in the linear interpolation over row j's
/// cells. The row above has weight 1/2 - y at y in [0, 1/2] of a cell; its share by solid angle is
/// the integral of that times sin(polar).
struct RowShares {
  double above, own, below;
};
RowShares row_shares(std::uint32_t j, std::uint32_t height) {
  const double step = std::numbers::pi / height, top = j * step, middle = (j + 0.5) * step, bottom = (j + 1) * step;
  const double whole = 2 * std::sin(middle) * std::sin(0.5 * step);
  const double above = (0.5 * step * std::cos(top) + std::sin(top) - std::sin(middle)) / step / whole;
  const double below = (std::sin(bottom) - std::sin(middle) - 0.5 * step * std::cos(bottom)) / step / whole;
  // Rounding errors of 1e-16 do no harm beside squares of the step, but could make a share
  // negative.
  const double least = 1e-6;
  return {.above = std::max(above, least),
          .own = 1 - std::max(above, least) - std::max(below, least),
          .below = std::max(below, least)};
}

/// The mean over a texel's cell of the bilinear interpolation between the cells' middles, which
/// reaches into all neighbours. It is 0 only if the interpolation is 0 all over the cell.
double cell_mean(const DeviceVector<float4>& texels, std::uint32_t i, std::uint32_t j, std::uint32_t width,
                 std::uint32_t height, const RowShares& shares) {
  const std::uint32_t columns[] = {i == 0 ? width - 1 : i - 1, i, i + 1 == width ? 0 : i + 1};
  const std::uint32_t rows[] = {j == 0 ? 0 : j - 1, j, j + 1 == height ? j : j + 1};
  constexpr double column_share[] = {0.125, 0.75, 0.125};
  const double row_share[] = {shares.above, shares.own, shares.below};
  double mean = 0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const float4& texel = texels[std::size_t{rows[a]} * width + columns[b]];
      mean += row_share[a] * column_share[b] * (double(texel.x) + double(texel.y) + double(texel.z)) / 3.0;
    }
  return mean;
}

}  // namespace

double texel_solid_angle(std::uint32_t row, std::uint32_t width, std::uint32_t height) {
  // 2 pi / width (cos of its top - cos of its bottom), written as a product, which keeps all digits
  // at the poles.
  const double step = std::numbers::pi / height;
  return 2 * std::numbers::pi / width * 2 * std::sin((row + 0.5) * step) * std::sin(0.5 * step);
}

double pack_environment_map(const Environment& environment, PackedScene& packed) {
  const EnvironmentMap& map = *environment.map;
  const std::uint32_t width = map.width, height = map.height;
  const std::size_t count = map.radiance.size();
  if (count == 0 || count != std::size_t{width} * height)
    throw InternalError(fmt::format("an environment map of {} x {} with {} texels", width, height, count));
  if (count > kMaxTexels)
    throw InputError(
        fmt::format("environment '{}': {} x {} texels are more than 2^28; scale it down", map.name, width, height));
  packed.environment_texels.resize(count);
  std::atomic<bool> too_bright{false};
  tbb::parallel_for(std::uint32_t{0}, height, [&](std::uint32_t j) {
    for (std::size_t k = std::size_t{j} * width; k < (std::size_t{j} + 1) * width; ++k) {
      const auto scaled = [&](float x) {
        const double radiance = double(x) * environment.scale;
        if (radiance > kBrightest) too_bright = true;
        return radiance < double(kFaintest) ? 0.0F : float(radiance);
      };
      const glm::vec3& radiance = map.radiance[k];
      packed.environment_texels[k] = {scaled(radiance.x), scaled(radiance.y), scaled(radiance.z), 0.0F};
    }
  });
  if (too_bright)
    throw InputError(fmt::format("environment '{}': its radiance times {:g} exceeds {:g}; choose a smaller scale",
                                 map.name, environment.scale, kBrightest));
  std::vector<double> powers(count);
  DeviceVector<float4>& texels = packed.environment_texels;
  tbb::parallel_for(std::uint32_t{0}, height, [&](std::uint32_t j) {
    const double solid_angle = texel_solid_angle(j, width, height);
    const RowShares shares = row_shares(j, height);
    for (std::uint32_t i = 0; i < width; ++i)
      powers[std::size_t{j} * width + i] = cell_mean(texels, i, j, width, height, shares) * solid_angle;
  });
  double integral = 0;
  for (const double power : powers) integral += power;
  LightTable table = build_light_table(powers);
  packed.environment_alias_table = std::move(table.buckets);
  if (packed.environment_alias_table.empty()) return 0;
  tbb::parallel_for(std::uint32_t{0}, height, [&](std::uint32_t j) {
    const double solid_angle = texel_solid_angle(j, width, height);
    for (std::size_t k = std::size_t{j} * width; k < (std::size_t{j} + 1) * width; ++k)
      texels[k].w = float(table.probability[k] / solid_angle);
  });
  return integral;
}

}  // namespace eikon
