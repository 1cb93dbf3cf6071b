// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/emissive_texture.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace eikon {
namespace {

constexpr double kFarthest = 0x1p30;  // texels; lookups beyond it give texel 0 (kernels/surface/texture.h)

struct Axis {
  std::uint32_t size;
  bool clamp, mirror;
};
Axis axis_u(const TextureRecord& t) {
  return {t.width, (t.flags & EK_TEXTURE_CLAMP_U) != 0, (t.flags & EK_TEXTURE_MIRROR_U) != 0};
}
Axis axis_v(const TextureRecord& t) {
  return {t.height, (t.flags & EK_TEXTURE_CLAMP_V) != 0, (t.flags & EK_TEXTURE_MIRROR_V) != 0};
}

std::uint32_t wrapped(double whole, const Axis& axis) {
  const double n = axis.size;
  if (axis.clamp) return std::uint32_t(std::clamp(whole, 0.0, n - 1));
  const double period = axis.mirror ? 2 * n : n;
  const double k = whole - std::floor(whole / period) * period;
  return std::uint32_t(std::clamp(k < n ? k : period - 1 - k, 0.0, n - 1));
}

/// The texels [first, last] of an axis that lookups between two places touch. They are all texels
/// if a border of the image lies between the places.
std::pair<std::uint32_t, std::uint32_t> touched(double lo, double hi, const Axis& axis) {
  const double first = std::floor(lo - 1), last = std::floor(hi + 1);
  if (!axis.clamp && std::floor(first / axis.size) != std::floor(last / axis.size)) return {0, axis.size - 1};
  const std::uint32_t a = wrapped(first, axis), b = wrapped(last, axis);
  return {std::min(a, b), std::max(a, b)};
}

}  // namespace

EmissiveTextures::Place EmissiveTextures::corner_place(std::uint32_t index, const TextureRecord& texture,
                                                       int corner) const {
  double u = 0, v = 0;
  const auto take = [&](const auto& r) {
    u = double(corner == 0 ? r.u0 : corner == 1 ? r.u1 : r.u2);
    v = double(corner == 0 ? r.v0 : corner == 1 ? r.v1 : r.v2);
  };
  if ((texture.flags & EK_TEXTURE_UV1) != 0)
    take(packed_.tangents.at(index));
  else
    take(packed_.normals.at(index));
  return place_of(texture, u, v);
}

EmissiveTextures::Place EmissiveTextures::place_of(const TextureRecord& texture, double u, double v) {
  return {.x = (double(texture.u_u) * u + double(texture.u_v) * v + double(texture.u_1)) * texture.width,
          .y = (double(texture.v_u) * u + double(texture.v_v) * v + double(texture.v_1)) * texture.height};
}

std::span<const std::uint32_t> EmissiveTextures::texels_of(const TextureRecord& texture) const {
  std::uint64_t first = 0;
  for (const std::span<const std::uint32_t> part : packed_.texels) {
    if (first == texture.first_texel) return part;
    first += part.size();
  }
  throw InternalError("a texture without texels");
}

const EmissiveTextures::LitTexels& EmissiveTextures::lit_texels(const TextureRecord& texture, std::uint32_t channels) {
  LitTexels& lit = lit_[{texture.first_texel, channels}];
  if (!lit.sums.empty()) return lit;
  const std::span<const std::uint32_t> texels = texels_of(texture);
  lit.width = texture.width;
  lit.height = texture.height;
  const std::size_t stride = std::size_t{lit.width} + 1;
  lit.sums.assign(stride * (std::size_t{lit.height} + 1), 0);
  for (std::size_t y = 0; y < lit.height; ++y) {
    std::uint32_t row = 0;
    for (std::size_t x = 0; x < lit.width; ++x) {
      row += (texels[y * lit.width + x] & channels) != 0 ? 1 : 0;
      lit.sums[(y + 1) * stride + x + 1] = lit.sums[y * stride + x + 1] + row;
    }
  }
  return lit;
}

bool EmissiveTextures::may_emit(const TextureRecord& texture, std::uint32_t channels, const Place (&corners)[3]) {
  const LitTexels& lit = lit_texels(texture, channels);
  const auto [x_lo, x_hi] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
  const auto [y_lo, y_hi] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  const bool near = std::max({-x_lo, x_hi, -y_lo, y_hi}) < kFarthest;  // false for NaN
  const auto [left, right] = near ? touched(x_lo, x_hi, axis_u(texture)) : std::pair(0U, texture.width - 1);
  const auto [top, bottom] = near ? touched(y_lo, y_hi, axis_v(texture)) : std::pair(0U, texture.height - 1);
  const std::size_t stride = std::size_t{lit.width} + 1;
  const auto sum = [&](std::size_t x, std::size_t y) { return lit.sums[y * stride + x]; };
  return sum(right + 1, bottom + 1) - sum(left, bottom + 1) - sum(right + 1, top) + sum(left, top) != 0;
}

glm::dvec3 EmissiveTextures::lookup(const TextureRecord& texture, Place place) const {
  const std::span<const std::uint32_t> texels = texels_of(texture);
  const auto texel = [&](double x, double y) {
    const std::uint32_t word =
        texels[std::size_t{wrapped(y, axis_v(texture))} * texture.width + wrapped(x, axis_u(texture))];
    glm::dvec3 color;
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t code = (word >> (8 * c)) & 255U;
      color[c] =
          (texture.flags & EK_TEXTURE_SRGB) != 0 ? double(std::bit_cast<float>(packed_.texels[0][code])) : code / 255.0;
    }
    return color;
  };
  if (!(std::abs(place.x) < kFarthest && std::abs(place.y) < kFarthest)) return texel(0, 0);
  if ((texture.flags & EK_TEXTURE_NEAREST) != 0) return texel(std::floor(place.x), std::floor(place.y));
  const double x = std::floor(place.x - 0.5), y = std::floor(place.y - 0.5);
  const double tx = place.x - 0.5 - x, ty = place.y - 0.5 - y;
  return (1 - ty) * ((1 - tx) * texel(x, y) + tx * texel(x + 1, y)) +
         ty * ((1 - tx) * texel(x, y + 1) + tx * texel(x + 1, y + 1));
}

namespace {
double mean_factor(const MaterialRecord& m) {
  return (double(m.emission_r) + double(m.emission_g) + double(m.emission_b)) / 3;
}
}  // namespace

double EmissiveTextures::mean_emission(std::uint32_t index) {
  const MaterialRecord& material = packed_.materials[packed_.triangles[index].material];
  if (material.emissive_texture == EK_NO_TEXTURE || !(mean_factor(material) > 0)) return mean_factor(material);
  const TextureRecord& texture = packed_.textures[material.emissive_texture];
  Place corners[3];
  for (int k = 0; k < 3; ++k) corners[k] = corner_place(index, texture, k);
  return mean_between(material, corners);
}

double EmissiveTextures::mean_emission_of_whole_texture(std::uint32_t index) {
  const MaterialRecord& material = packed_.materials[packed_.triangles[index].material];
  if (material.emissive_texture == EK_NO_TEXTURE || !(mean_factor(material) > 0)) return mean_factor(material);
  const TextureRecord& texture = packed_.textures[material.emissive_texture];
  const Place a = place_of(texture, 0, 0), b = place_of(texture, 1, 0), c = place_of(texture, 0, 1),
              d = place_of(texture, 1, 1);
  return 0.5 * (mean_between(material, {a, b, c}) + mean_between(material, {d, c, b}));
}

double EmissiveTextures::mean_between(const MaterialRecord& material, const Place (&corners)[3]) {
  const TextureRecord& texture = packed_.textures[material.emissive_texture];
  const glm::dvec3 factor(material.emission_r, material.emission_g, material.emission_b);
  const double all = mean_factor(material);
  std::uint32_t channels = 0;
  for (int c = 0; c < 3; ++c) channels |= factor[c] > 0 ? 255U << (8 * c) : 0;
  if (!may_emit(texture, channels, corners)) return 0;

  // Sums over the middles of n^2 equal parts. A part is about a texel, as long as there are not too
  // many.
  const auto longest = [&](int a, int b) {
    return std::max(std::abs(corners[a].x - corners[b].x), std::abs(corners[a].y - corners[b].y));
  };
  const double texels = std::max({longest(0, 1), longest(1, 2), longest(2, 0)});
  const int n = texels < 64 ? std::max(int(texels), 4) : 64;  // NaN: 64
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * i + 1; ++j) {  // row i from the first corner: 2 i + 1 parts, every second upside down
      const double down = (i + (j % 2 == 0 ? 2.0 : 1.0) / 3) / n, across = (j / 2 + (j % 2 == 0 ? 1.0 : 2.0) / 3) / n;
      const double w1 = down - across, w2 = across, w0 = 1 - down;
      const Place place{.x = w0 * corners[0].x + w1 * corners[1].x + w2 * corners[2].x,
                        .y = w0 * corners[0].y + w1 * corners[1].y + w2 * corners[2].y};
      const glm::dvec3 emission = factor * lookup(texture, place);
      sum += (emission.x + emission.y + emission.z) / 3;
    }
  // The sum is at least a sixteenth of one point's emission, because all points may have missed the
  // lit texels.
  return std::max(sum, 0x1p-4 * all) / (double(n) * n);
}

}  // namespace eikon
