// SPDX-License-Identifier: Apache-2.0
#include "view/view_frame.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "film/layers.h"
#include "image/relative_error.h"
#include "page/page_picture.h"

namespace eikon {
namespace {

float finite_or_black(double value) { return std::isfinite(value) ? float(value) : 0.0F; }

/// Writes the R, G, B of a row of the film's window to three values a pixel.
using RowWriter = std::function<void(std::uint32_t y, float* values)>;

void write_radiance(const Film& film, std::uint32_t y, float* values) {
  const Crop& crop = film.layout().crop;
  for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
    for (std::uint32_t c = 0; c < 3; ++c) *values++ = finite_or_black(film.mean(x, y, c));
}

/// The root of the mean over R, G, B of the terms of relMSE.
void write_errors(const Film& film, std::uint32_t y, float* values) {
  const std::uint32_t width = film.layout().crop.width();
  std::vector<double> means(width), variances(width), sums(width);
  for (std::uint32_t channel = 0; channel < 3; ++channel) {
    film.row_means_and_variances(y, channel, means.data(), variances.data());
    for (std::uint32_t x = 0; x < width; ++x) sums[x] += variances[x] / (means[x] * means[x] + kErrorEpsilon) / 3;
  }
  for (const double sum : sums) values = std::fill_n(values, 3, finite_or_black(std::sqrt(sum)));
}

void write_layer(const Film& film, const std::vector<LayerChannel>& channels, std::uint32_t y, float* values) {
  const Crop& crop = film.layout().crop;
  for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
    for (std::size_t c = 0; c < 3; ++c) {
      const LayerChannel& channel = channels[std::min(c, channels.size() - 1)];
      const double value = channel.rule == LayerRule::mean_of_hit
                               ? film.mean(x, y, channel.film.at(0)) / film.mean(x, y, channel.film.at(1))
                               : film.mean(x, y, channel.film);
      *values++ = finite_or_black(value);
    }
}

/// Normals as colours.
void write_normals(const Film& film, const std::vector<LayerChannel>& channels, std::uint32_t y, float* values) {
  write_layer(film, channels, y, values);
  for (std::size_t i = 0; i < 3 * std::size_t{film.layout().crop.width()}; ++i) values[i] = 0.5F * values[i] + 0.5F;
}

/// channels, factors: three for each light group
void write_lights(const Film& film, const std::vector<LayerChannel>& channels, const std::vector<double>& factors,
                  std::uint32_t y, float* values) {
  const Crop& crop = film.layout().crop;
  for (std::uint32_t x = crop.x0; x < crop.x1; ++x, values += 3) {
    double sums[3] = {};
    for (std::size_t i = 0; i < channels.size(); ++i)
      if (factors[i] > 0) sums[i % 3] += factors[i] * film.mean(x, y, channels[i].film);
    for (std::size_t c = 0; c < 3; ++c) values[c] = finite_or_black(sums[c]);
  }
}

/// The factor of each channel "light.NAME.R".
std::vector<double> factors_of(const std::vector<LayerChannel>& channels, const ViewLook& look) {
  std::vector<double> factors;
  for (const LayerChannel& channel : channels) {
    const std::size_t begin = channel.name.find('.') + 1, end = channel.name.rfind('.');
    const auto found = look.mix.find(channel.name.substr(begin, end - begin));
    factors.push_back(found == look.mix.end() ? 1 : found->second);
  }
  return factors;
}

RowWriter writer_of(const Film& film, const ViewLook& look) {
  if (look.layer == "error") return [&](std::uint32_t y, float* values) { write_errors(film, y, values); };
  if (!look.needs_layers() || look.layer == "denoised")
    return [&](std::uint32_t y, float* values) { write_radiance(film, y, values); };
  const bool lights = look.layer == "lights";
  const std::vector<LayerChannel> channels = layer_channels(lights ? "light_groups" : look.layer, film.layout());
  if (lights)
    return [&, channels, factors = factors_of(channels, look)](std::uint32_t y, float* values) {
      write_lights(film, channels, factors, y, values);
    };
  const auto write = look.layer == "normal" ? write_normals : write_layer;
  return [&, channels, write](std::uint32_t y, float* values) { write(film, channels, y, values); };
}

std::vector<unsigned char> pixels_of(std::uint32_t width, std::uint32_t height, const RowWriter& write) {
  const std::size_t row_bytes = std::size_t{4} * width;
  std::vector<unsigned char> picture(row_bytes * height);
  tbb::parallel_for(0U, height, [&](std::uint32_t y) {
    std::vector<float> values(3 * std::size_t{width});
    write(y, values.data());
    std::vector<unsigned char> row;
    row.reserve(row_bytes);
    for (std::size_t i = 0; i < values.size(); i += 3) append_rgbe(row, {values[i], values[i + 1], values[i + 2]});
    std::ranges::copy(row, picture.begin() + std::ptrdiff_t(row_bytes * y));
  });
  return picture;
}

}  // namespace

std::vector<unsigned char> view_pixels(const Film& film, const ViewLook& look) {
  const Crop& crop = film.layout().crop;
  const RowWriter write = writer_of(film, look);
  return pixels_of(crop.width(), crop.height(), [&](std::uint32_t y, float* values) { write(crop.y0 + y, values); });
}

std::vector<unsigned char> view_pixels(const Image& picture) {
  std::array<const std::vector<float>*, 3> planes{};
  std::ranges::transform(kRgb, planes.begin(), [&](const char* name) { return picture.plane(name); });
  return pixels_of(picture.width, picture.height, [&](std::uint32_t y, float* values) {
    for (std::size_t x = std::size_t{y} * picture.width; x < std::size_t{y + 1} * picture.width; ++x)
      for (const std::vector<float>* plane : planes) *values++ = finite_or_black((*plane)[x]);
  });
}

}  // namespace eikon
